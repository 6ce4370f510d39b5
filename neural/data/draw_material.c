#include "neural/data/draw_material.h"

#include <stdlib.h>
#include <string.h>

#include "neural/data/draw_random.h"

bool pbnds_material_is_free(const struct pbnds_material *m)
{
    return m->alpha_mode == PBNDS_ALPHA_OPAQUE && !m->unlit &&
           !(pbnds_max3(m->emissive) > 0.0f);
}

/* Colour. */

struct hsv {
    float h, s, v; /* each in [0, 1]; h is periodic */
};

static struct hsv to_hsv(struct pbnds_vec3 c)
{
    const float v = pbnds_max3(c), low = fminf(c.x, fminf(c.y, c.z)), range = v - low;
    struct hsv out = {0.0f, v > 0.0f ? range / v : 0.0f, v};
    if (!(range > 0.0f)) return out;
    float h;
    if (v == c.x) {
        h = (c.y - c.z) / range;
    } else if (v == c.y) {
        h = 2.0f + (c.z - c.x) / range;
    } else {
        h = 4.0f + (c.x - c.y) / range;
    }
    out.h = h / 6.0f - floorf(h / 6.0f);
    return out;
}

static float hsv_channel(struct hsv c, float shift)
{
    const float k = shift + 6.0f * c.h;
    const float turn = k - 6.0f * floorf(k / 6.0f);
    return c.v * (1.0f - c.s * pbnds_clamp(fminf(turn, 4.0f - turn), 0.0f, 1.0f));
}

static struct pbnds_vec3 from_hsv(struct hsv c)
{
    return pbnds_vec3_make(hsv_channel(c, 5.0f), hsv_channel(c, 3.0f),
                           hsv_channel(c, 1.0f));
}

/* What multiplies a texture can only darken it. */
static struct pbnds_vec3 draw_tint(struct pbnds_rng *rng, float strength)
{
    struct hsv c;
    c.h = pbnds_rng_float(rng);
    c.s = strength * 0.6f * pbnds_rng_float(rng) * pbnds_rng_float(rng);
    c.v = 1.0f - 0.5f * strength * pbnds_rng_float(rng);
    return from_hsv(c);
}

static struct pbnds_vec3 draw_shade(struct pbnds_rng *rng, struct pbnds_vec3 color,
                                    float strength)
{
    const struct pbnds_vec3 u = pbnds_draw_vec3(rng, -1.0f, 1.0f);
    const float saturated = pbnds_rng_float(rng);
    struct hsv c = to_hsv(color);
    const float h = c.h + 0.5f * strength * u.x;
    c.h = h - floorf(h);
    /* Greys get some colour too. */
    c.s = pbnds_clamp(c.s * exp2f(u.y) + 0.3f * strength * saturated * saturated, 0.0f,
                      0.95f);
    c.v = pbnds_clamp(c.v * exp2f(1.2f * strength * u.z), 0.02f, 0.92f);
    return from_hsv(c);
}

/* Reflectance at normal incidence, linear Rec. 709: from the measured indices that are
 * found in tables of physically based rendering (silver, aluminium, gold, copper, iron,
 * titanium, nickel, chromium, brass, zinc). */
static const float METALS[][3] = {{0.962f, 0.949f, 0.922f}, {0.912f, 0.914f, 0.920f},
                                  {0.944f, 0.776f, 0.373f}, {0.926f, 0.721f, 0.504f},
                                  {0.531f, 0.512f, 0.496f}, {0.616f, 0.582f, 0.544f},
                                  {0.649f, 0.610f, 0.541f}, {0.549f, 0.556f, 0.554f},
                                  {0.887f, 0.789f, 0.434f}, {0.808f, 0.844f, 0.865f}};

static struct pbnds_vec3 draw_metal(struct pbnds_rng *rng)
{
    const int count = (int)(sizeof METALS / sizeof METALS[0]);
    const float *m = METALS[pbnds_draw_below(rng, count)];
    const struct pbnds_vec3 tarnish = pbnds_draw_vec3(rng, 0.85f, 1.0f);
    return pbnds_mul(pbnds_vec3_make(m[0], m[1], m[2]), tarnish);
}

/* Factors. Every material takes the same numbers from the stream, whatever it is, so that
 * one material more or less in front of it is all that can move its look. */
struct look {
    float kind, rough, spread, flip, specular, ior, normal, how;
    struct pbnds_vec3 metal, tint, skin_tint;
};

static struct look draw_look(struct pbnds_rng *rng)
{
    struct look l;
    l.kind = pbnds_rng_float(rng);
    l.rough = pbnds_rng_float(rng);
    l.spread = pbnds_draw_normal(rng);
    l.flip = pbnds_rng_float(rng);
    l.specular = pbnds_draw_uniform(rng, 0.3f, 1.0f);
    l.ior = pbnds_draw_log_uniform(rng, 0.02f, 0.08f);
    l.normal = pbnds_rng_float(rng);
    l.how = pbnds_rng_float(rng);
    l.metal = draw_metal(rng);
    l.tint = draw_tint(rng, 1.0f);
    l.skin_tint = draw_tint(rng, 0.35f);
    return l;
}

static bool has_surface_map(const struct pbnds_material *m)
{
    return m->metallic_roughness_texture.texture >= 0 ||
           (m->specular_glossiness && m->specular_color_texture.texture >= 0);
}

static void set_roughness(struct pbnds_material *m, const struct look *l)
{
    if (l->kind < 0.25f) return;
    if (l->kind < 0.6f && !has_surface_map(m)) {
        m->roughness = 0.05f + 0.95f * l->rough;
        return;
    }
    const float r = m->roughness * expf(0.7f * l->spread);
    /* A map is multiplied and what comes of it is clamped. */
    m->roughness = pbnds_clamp(r, 0.03f, has_surface_map(m) ? 3.0f : 1.0f);
}

static void set_color(struct pbnds_material *m, struct pbnds_vec3 c)
{
    m->base_color.x = c.x;
    m->base_color.y = c.y;
    m->base_color.z = c.z;
}

static struct pbnds_vec3 color_of(const struct pbnds_material *m)
{
    return pbnds_vec3_make(m->base_color.x, m->base_color.y, m->base_color.z);
}

/* @return true: it is a metal now, with its colour */
static bool set_metallic(struct pbnds_material *m, const struct look *l)
{
    if (m->specular_glossiness) return false;
    if (m->metallic > 0.5f && l->flip < 0.25f) {
        m->metallic = 0.0f;
    } else if (m->metallic <= 0.5f && l->flip < 1.0f / 6.0f && !has_surface_map(m)) {
        m->metallic = 1.0f;
        set_color(m, l->metal);
        m->roughness = fminf(m->roughness, 0.6f);
        return true;
    }
    return false;
}

static void set_specular(struct pbnds_material *m, const struct look *l)
{
    if (l->how >= 0.33f || m->specular_glossiness) return;
    m->ior_f0 = l->ior;
    m->specular *= l->specular;
}

static void randomize_one(struct pbnds_material *m, bool skin, struct pbnds_rng *rng)
{
    const struct look l = draw_look(rng);
    const struct pbnds_vec3 shade = draw_shade(rng, color_of(m), 1.0f);
    const struct pbnds_vec3 skin_shade = draw_shade(rng, color_of(m), 0.12f);
    if (!pbnds_material_is_free(m)) return;
    if (l.normal < 0.5f) m->normal_scale = 4.0f * l.normal;
    set_specular(m, &l);
    const bool textured = m->base_color_texture.texture >= 0;
    if (skin && !has_surface_map(m) && m->metallic <= 0.5f) {
        m->roughness = 0.3f + 0.4f * l.rough;
        set_color(m, textured ? pbnds_mul(color_of(m), l.skin_tint) : skin_shade);
        return;
    }
    set_roughness(m, &l);
    if (set_metallic(m, &l)) return;
    set_color(m, textured ? pbnds_mul(color_of(m), l.tint) : shade);
}

void pbnds_materials_randomize(struct pbnds_scene *scene, bool skin,
                               struct pbnds_rng *rng)
{
    for (int i = 0; i < scene->material_count; ++i)
        randomize_one(&scene->materials[i], skin, rng);
}

/* Textures. */

/* Where the reference of a map is in a material. */
static const size_t REFS[PBNDS_MAP_COUNT] = {
    [PBNDS_MAP_BASE_COLOR] = offsetof(struct pbnds_material, base_color_texture),
    [PBNDS_MAP_METALLIC_ROUGHNESS] =
        offsetof(struct pbnds_material, metallic_roughness_texture),
    [PBNDS_MAP_NORMAL] = offsetof(struct pbnds_material, normal_texture),
    [PBNDS_MAP_EMISSIVE] = offsetof(struct pbnds_material, emissive_texture),
    [PBNDS_MAP_OCCLUSION] = offsetof(struct pbnds_material, occlusion_texture),
    [PBNDS_MAP_SPECULAR] = offsetof(struct pbnds_material, specular_texture),
    [PBNDS_MAP_SPECULAR_COLOR] =
        offsetof(struct pbnds_material, specular_color_texture)};

/* UV sets that the maps of a material read, as bits; 0: it has no maps. */
static unsigned sets_read(const struct pbnds_material *m)
{
    unsigned sets = 0;
    for (int map = 0; map < PBNDS_MAP_COUNT; ++map) {
        struct pbnds_texture_ref ref;
        memcpy(&ref, (const char *)m + REFS[map], sizeof ref);
        if (ref.texture >= 0) sets |= ref.texcoord == 1 ? 2u : 1u;
    }
    return sets;
}

/* Those may exchange maps that are free, read the first UV set only, and whose meshes all
 * have it. Plain ones take part: they get maps, others lose theirs. Specular-glossiness
 * reads the same maps in another way. */
static void find_swaps(const struct pbnds_scene *scene, bool *swaps)
{
    for (int i = 0; i < scene->material_count; ++i) {
        const struct pbnds_material *m = &scene->materials[i];
        swaps[i] = pbnds_material_is_free(m) && !m->specular_glossiness &&
                   (sets_read(m) & 2u) == 0;
    }
    bool *used = calloc((size_t)scene->material_count + 1, sizeof *used);
    for (int i = 0; i < scene->mesh_count; ++i) {
        const struct pbnds_mesh *mesh = &scene->meshes[i];
        if (used) used[mesh->material] = true;
        if (!mesh->uv[0]) swaps[mesh->material] = false;
    }
    for (int i = 0; i < scene->material_count; ++i)
        swaps[i] = swaps[i] && used && used[i];
    free(used);
}

enum pbnds_status pbnds_materials_keep(const struct pbnds_scene *scene,
                                       struct pbnds_material_store *store,
                                       struct pbnds_error *error)
{
    const size_t n = (size_t)scene->material_count;
    *store = (struct pbnds_material_store){0};
    store->materials = malloc((n + 1) * sizeof *store->materials);
    store->swaps = calloc(n + 1, sizeof *store->swaps);
    if (scene->maps) store->maps = malloc((n + 1) * sizeof *store->maps);
    if (!store->materials || !store->swaps || (scene->maps && !store->maps)) {
        pbnds_material_store_free(store);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for materials");
    }
    memcpy(store->materials, scene->materials, n * sizeof *store->materials);
    if (scene->maps)
        memcpy(store->maps, scene->maps->materials, n * sizeof *store->maps);
    find_swaps(scene, store->swaps);
    return PBNDS_OK;
}

void pbnds_materials_restore(const struct pbnds_material_store *store,
                             struct pbnds_scene *scene)
{
    const size_t n = (size_t)scene->material_count;
    memcpy(scene->materials, store->materials, n * sizeof *store->materials);
    if (store->maps)
        memcpy(scene->maps->materials, store->maps, n * sizeof *store->maps);
}

void pbnds_material_store_free(struct pbnds_material_store *store)
{
    free(store->materials);
    free(store->maps);
    free(store->swaps);
    *store = (struct pbnds_material_store){0};
}

/* All maps of a material at once, for they lie together (maps.h), and the factors that
 * go with them. */
static void take_maps(const struct pbnds_material_store *store,
                      struct pbnds_scene *scene, int to, int from)
{
    struct pbnds_material *m = &scene->materials[to];
    const struct pbnds_material *other = &store->materials[from];
    for (int map = 0; map < PBNDS_MAP_COUNT; ++map)
        memcpy((char *)m + REFS[map], (const char *)other + REFS[map],
               sizeof(struct pbnds_texture_ref));
    m->base_color = other->base_color;
    m->metallic = other->metallic;
    m->roughness = other->roughness;
    m->normal_scale = other->normal_scale;
    m->occlusion_strength = other->occlusion_strength;
    if (store->maps) scene->maps->materials[to] = store->maps[from];
}

/* A turn of the ring of those that swap, by a number that is drawn: nobody keeps his own,
 * and none is lost. */
int pbnds_materials_swap(const struct pbnds_material_store *store,
                         struct pbnds_scene *scene, struct pbnds_rng *rng)
{
    const float u = pbnds_rng_float(rng);
    int count = 0, textured = 0;
    for (int i = 0; i < scene->material_count; ++i) {
        count += store->swaps[i];
        textured += store->swaps[i] && sets_read(&store->materials[i]) != 0;
    }
    if (count < 2 || textured < 1) return 0;
    int turn = 1 + (int)(u * (float)(count - 1));
    if (turn >= count) turn = count - 1;
    int from = -1;
    for (int k = 0; k <= turn; ++k) { /* the turn-th of the ring */
        do
            from = (from + 1) % scene->material_count;
        while (!store->swaps[from]);
    }
    for (int to = 0; to < scene->material_count; ++to) {
        if (!store->swaps[to]) continue;
        take_maps(store, scene, to, from);
        do
            from = (from + 1) % scene->material_count;
        while (!store->swaps[from]);
    }
    return count;
}
