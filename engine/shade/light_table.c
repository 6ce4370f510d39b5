/* One table for the choice between all lights; see light_table.h. */
#include "engine/shade/light_table.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CLASSES = 3 };
static const double EVEN_CLASSES = 0.25, EVEN_PUNCTUAL = 0.1;

/* Estimated powers before they become shares. */
struct powers {
    const struct pbnds_scene *scene;
    const struct pbnds_emissive *emissive;
    double of_class[CLASSES];
    size_t lit; /* punctual lights that shine */
    double cross_section;
};

/* pi r^2 of the sphere about the bounds; of a scene without any, a metre's. */
static double cross_section(const struct pbnds_scene *scene)
{
    const struct pbnds_vec3 d = pbnds_sub(scene->hi, scene->lo);
    const double square = (double)d.x * (double)d.x + (double)d.y * (double)d.y +
                          (double)d.z * (double)d.z;
    const bool usable = square > 0.0 && square < 1e40;
    return (double)PBNDS_PI * (usable ? 0.25 * square : 1.0);
}

static double positive(double x)
{
    return x > 0.0 && x < 1e200 ? x : 0.0;
}

static double punctual_power(const struct powers *powers,
                             const struct pbnds_light *light)
{
    const double two_pi = 2.0 * (double)PBNDS_PI;
    const double intensity = positive((double)pbnds_luminance(light->intensity));
    switch (light->kind) {
    case PBNDS_LIGHT_DIRECTIONAL:
        return intensity * powers->cross_section;
    case PBNDS_LIGHT_POINT:
        return intensity * 2.0 * two_pi;
    case PBNDS_LIGHT_SPOT:
        /* a spot may be a needle: it must not become nothing */
        return intensity * two_pi *
               fmax(1.0 - (2.0 * (double)light->cos_inner + (double)light->cos_outer) /
                              3.0,
                    1e-4);
    }
    return 0.0;
}

static struct powers estimate(const struct pbnds_scene *scene,
                              const struct pbnds_envmap *envmap,
                              const struct pbnds_emissive *emissive)
{
    struct powers powers = {.scene = scene, .emissive = emissive};
    powers.cross_section = cross_section(scene);
    if (envmap)
        powers.of_class[PBNDS_LIGHT_CLASS_MAP] =
            positive(4.0 * (double)PBNDS_PI * powers.cross_section *
                     (double)pbnds_luminance(pbnds_envmap_mean(envmap)));
    for (int i = 0; i < scene->light_count; ++i) {
        const double power = punctual_power(&powers, &scene->lights[i]);
        powers.of_class[PBNDS_LIGHT_CLASS_PUNCTUAL] += power;
        powers.lit += power > 0.0;
    }
    for (size_t i = 0; i < emissive->count; ++i)
        powers.of_class[PBNDS_LIGHT_CLASS_EMISSIVE] +=
            (double)emissive->triangles[i].power;
    return powers;
}

/* Shares of the kinds; all 0 where nothing shines. */
static void share_classes(const struct powers *powers, double share[CLASSES])
{
    double total = 0.0;
    int present = 0;
    for (int c = 0; c < CLASSES; ++c) {
        total += powers->of_class[c];
        present += powers->of_class[c] > 0.0;
    }
    for (int c = 0; c < CLASSES; ++c) {
        share[c] = 0.0;
        if (powers->of_class[c] > 0.0)
            share[c] = (1.0 - EVEN_CLASSES) * powers->of_class[c] / total +
                       EVEN_CLASSES / present;
    }
}

/* Share of entry i of the table. */
static double entry_share(const struct powers *powers, const double share[CLASSES],
                          size_t i)
{
    const size_t lights = (size_t)powers->scene->light_count;
    if (i == 0) return share[PBNDS_LIGHT_CLASS_MAP];
    if (i <= lights) {
        const double power = punctual_power(powers, &powers->scene->lights[i - 1]);
        if (!(power > 0.0)) return 0.0;
        return share[PBNDS_LIGHT_CLASS_PUNCTUAL] *
               ((1.0 - EVEN_PUNCTUAL) * power /
                    powers->of_class[PBNDS_LIGHT_CLASS_PUNCTUAL] +
                EVEN_PUNCTUAL / (double)powers->lit);
    }
    const double power = (double)powers->emissive->triangles[i - 1 - lights].power;
    return power > 0.0 ? share[PBNDS_LIGHT_CLASS_EMISSIVE] * power /
                             powers->of_class[PBNDS_LIGHT_CLASS_EMISSIVE]
                       : 0.0;
}

static float width(const struct pbnds_light_table *table, size_t i)
{
    const uint64_t next = i + 1 < table->count ? table->start[i + 1] : 1ull << 32;
    return (float)((double)(next - table->start[i]) * 0x1p-32);
}

static void cumulate(struct pbnds_light_table *table, const struct powers *powers,
                     const double share[CLASSES])
{
    double sum = 0.0, total = 0.0;
    const size_t all = table->count;
    for (size_t i = 0; i < all; ++i) {
        const double s = entry_share(powers, share, i);
        total += s;
        if (s > 0.0) table->count = i + 1; /* nothing past the last that shines */
    }
    for (size_t i = 0; i < table->count; ++i) {
        const double at = rint(sum / total * 0x1p32);
        table->start[i] = at < 0x1p32 ? (uint32_t)at : UINT32_MAX;
        sum += entry_share(powers, share, i);
    }
    table->map_probability = width(table, 0);
}

enum pbnds_status pbnds_light_table_create(const struct pbnds_scene *scene,
                                           const struct pbnds_envmap *envmap,
                                           struct pbnds_light_table *table,
                                           struct pbnds_error *error)
{
    memset(table, 0, sizeof *table);
    table->scene = scene;
    PBNDS_TRY(pbnds_emissive_create(scene, &table->emissive, error));
    const struct powers powers = estimate(scene, envmap, &table->emissive);
    double share[CLASSES];
    share_classes(&powers, share);
    if (!(share[0] + share[1] + share[2] > 0.0)) return PBNDS_OK;
    const size_t count = 1 + (size_t)scene->light_count + table->emissive.count;
    table->start = malloc(count * sizeof *table->start);
    if (!table->start) {
        pbnds_light_table_free(table);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "out of memory for a table of %zu lights", count);
    }
    table->count = count;
    cumulate(table, &powers, share);
    return PBNDS_OK;
}

void pbnds_light_table_free(struct pbnds_light_table *table)
{
    pbnds_emissive_free(&table->emissive);
    free(table->start);
    memset(table, 0, sizeof *table);
}

struct pbnds_light_choice
pbnds_light_table_choose(const struct pbnds_light_table *table, uint32_t bits)
{
    /* the last entry that starts at or before the number; those before it that start
     * there too have no width */
    size_t low = 0, high = table->count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (table->start[middle] <= bits)
            low = middle;
        else
            high = middle;
    }
    const size_t lights = (size_t)table->scene->light_count;
    struct pbnds_light_choice choice = {PBNDS_LIGHT_CLASS_MAP, 0, width(table, low)};
    if (low > lights) {
        choice.kind = PBNDS_LIGHT_CLASS_EMISSIVE;
        choice.index = low - 1 - lights;
    } else if (low > 0) {
        choice.kind = PBNDS_LIGHT_CLASS_PUNCTUAL;
        choice.index = low - 1;
    }
    assert(choice.probability > 0.0f);
    return choice;
}

float pbnds_light_table_emissive_pdf(const struct pbnds_light_table *table,
                                     const struct pbnds_hit *hit, float cos_l)
{
    if (table->emissive.count == 0) return 0.0f;
    const size_t index =
        pbnds_emissive_find(&table->emissive, hit->mesh, hit->triangle);
    if (index == SIZE_MAX) return 0.0f;
    const size_t entry = 1 + (size_t)table->scene->light_count + index;
    const float probability = entry < table->count ? width(table, entry) : 0.0f;
    if (!(probability > 0.0f)) return 0.0f;
    return probability * pbnds_emissive_pdf(&table->emissive, index, hit->t, cos_l);
}
