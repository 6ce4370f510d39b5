#include "neural/data/atrous.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/color.h"
#include "engine/core/parallel.h"
#include "engine/core/report.h"

enum { PASSES = 3, RADIUS = 2 };

static const float SIGMA = 1.5f; /* of luminance, in standard deviations */
static const float MATERIAL = 0.1f;
static const float DARKEST = 0.02f; /* a reflectance below is not divided by */

/* What the weights know of a pixel. */
struct guide {
    struct pbnds_vec3 n, ng, position, reflectance;
    float footprint, roughness, metallic;
    bool covered;
};

struct filter {
    const struct pbnds_gbuffer *gbuffer;
    int width, height, count;
    struct guide *guides;
    struct pbnds_vec3 *light[2]; /* count images one after another: from, to */
    float *variance[2];          /* of the luminance of the first            */
    int step;
};

static size_t pixels(const struct filter *f)
{
    return (size_t)f->width * (size_t)f->height;
}

/* What the surface makes of light from everywhere, roughly: diffuse part plus f0. */
static struct pbnds_vec3 reflectance(const struct pbnds_gbuffer *g, size_t i)
{
    const float metallic = g->metallic[i];
    const struct pbnds_vec3 base = pbnds_gbuffer_vec3(g->albedo, i);
    const float dielectric =
        fmaxf(g->specular[i] - metallic * pbnds_luminance(base), 0.0f);
    const struct pbnds_vec3 sum = pbnds_add(base, pbnds_splat(dielectric));
    return pbnds_vec3_make(fmaxf(sum.x, DARKEST), fmaxf(sum.y, DARKEST),
                           fmaxf(sum.z, DARKEST));
}

static void make_guides(struct filter *f)
{
    const struct pbnds_gbuffer *g = f->gbuffer;
    const struct pbnds_camera_view view =
        pbnds_camera_view(&g->camera, g->width, g->height);
    for (size_t i = 0; i < pixels(f); ++i) {
        struct guide *guide = &f->guides[i];
        guide->covered = g->coverage[i] > 0.0f && isfinite(g->depth[i]);
        if (!guide->covered) continue;
        guide->n = pbnds_gbuffer_vec3(g->normal, i);
        guide->ng = pbnds_gbuffer_vec3(g->geometric_normal, i);
        guide->position = pbnds_gbuffer_vec3(g->position, i);
        guide->reflectance = reflectance(g, i);
        guide->footprint = view.pixel * (view.orthographic ? 1.0f : g->depth[i]);
        guide->roughness = g->roughness[i];
        guide->metallic = g->metallic[i];
    }
}

static struct pbnds_vec3 pixel_of(const struct pbnds_image *image, size_t i)
{
    const float *p = image->data + 3 * i;
    return pbnds_vec3_make(p[0], p[1], p[2]);
}

static struct pbnds_vec3 quotient(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(a.x / b.x, a.y / b.y, a.z / b.z);
}

/* Channels share their paths, so their errors go together: deviations add up. */
static float luminance_variance(struct pbnds_vec3 variance, struct pbnds_vec3 by)
{
    const struct pbnds_vec3 deviation =
        pbnds_vec3_make(sqrtf(fmaxf(variance.x, 0.0f)), sqrtf(fmaxf(variance.y, 0.0f)),
                        sqrtf(fmaxf(variance.z, 0.0f)));
    const float l = pbnds_luminance(quotient(deviation, by));
    return l * l;
}

static void load(struct filter *f, const struct pbnds_image *variance,
                 struct pbnds_image *const *images)
{
    for (size_t i = 0; i < pixels(f); ++i) {
        const struct guide *guide = &f->guides[i];
        if (!guide->covered) continue;
        f->variance[0][i] =
            luminance_variance(pixel_of(variance, i), guide->reflectance);
        for (int k = 0; k < f->count; ++k)
            f->light[0][(size_t)k * pixels(f) + i] =
                quotient(pixel_of(images[k], i), guide->reflectance);
    }
}

static void store(const struct filter *f, struct pbnds_image *const *images)
{
    for (size_t i = 0; i < pixels(f); ++i) {
        const struct guide *guide = &f->guides[i];
        if (!guide->covered) continue;
        for (int k = 0; k < f->count; ++k) {
            const struct pbnds_vec3 v =
                pbnds_mul(f->light[0][(size_t)k * pixels(f) + i], guide->reflectance);
            float *out = images[k]->data + 3 * i;
            out[0] = v.x, out[1] = v.y, out[2] = v.z;
        }
    }
}

/* Deviation of the luminance about a pixel, a 3 x 3 Gaussian over the covered ones. */
static float deviation(const struct filter *f, int x, int y)
{
    float sum = 0.0f, weights = 0.0f;
    for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
            const int qx = x + i, qy = y + j;
            if (qx < 0 || qy < 0 || qx >= f->width || qy >= f->height) continue;
            const size_t q = (size_t)qy * (size_t)f->width + (size_t)qx;
            if (!f->guides[q].covered) continue;
            const float w = (i == 0 ? 2.0f : 1.0f) * (j == 0 ? 2.0f : 1.0f);
            sum += w * f->variance[0][q];
            weights += w;
        }
    }
    return sqrtf(sum / weights);
}

static float power_128(float x)
{
    for (int i = 0; i < 7; ++i)
        x *= x;
    return x;
}

static float geometry_weight(const struct guide *p, const struct guide *q, int step)
{
    const float cosine = pbnds_dot(p->n, q->n);
    if (!(cosine > 0.0f)) return 0.0f;
    const float off = fabsf(pbnds_dot(p->ng, pbnds_sub(q->position, p->position)));
    const float apart =
        off / ((float)step * p->footprint) +
        (fabsf(p->roughness - q->roughness) + fabsf(p->metallic - q->metallic)) /
            MATERIAL;
    return power_128(fminf(cosine, 1.0f)) * expf(-apart);
}

static void filter_pixel(const struct filter *f, int x, int y)
{
    static const float SPLINE[2 * RADIUS + 1] = {0.0625f, 0.25f, 0.375f, 0.25f,
                                                 0.0625f};
    const size_t n = pixels(f), p = (size_t)y * (size_t)f->width + (size_t)x;
    const struct guide *guide = &f->guides[p];
    if (!guide->covered) return;
    const float luminance = pbnds_luminance(f->light[0][p]);
    const float scale =
        1.0f / (SIGMA * deviation(f, x, y) + 1e-6f * luminance + 1e-20f);
    float weights = 0.0f, variance = 0.0f;
    for (int k = 0; k < f->count; ++k)
        f->light[1][(size_t)k * n + p] = pbnds_splat(0.0f);
    for (int j = -RADIUS; j <= RADIUS; ++j) {
        for (int i = -RADIUS; i <= RADIUS; ++i) {
            const int qx = x + i * f->step, qy = y + j * f->step;
            if (qx < 0 || qy < 0 || qx >= f->width || qy >= f->height) continue;
            const size_t q = (size_t)qy * (size_t)f->width + (size_t)qx;
            if (!f->guides[q].covered) continue;
            const float unlike =
                fabsf(pbnds_luminance(f->light[0][q]) - luminance) * scale;
            const float w = SPLINE[i + RADIUS] * SPLINE[j + RADIUS] *
                            geometry_weight(guide, &f->guides[q], f->step) *
                            expf(-unlike);
            weights += w;
            variance += w * w * f->variance[0][q];
            for (int k = 0; k < f->count; ++k) {
                struct pbnds_vec3 *out = &f->light[1][(size_t)k * n + p];
                *out = pbnds_mad(*out, f->light[0][(size_t)k * n + q], w);
            }
        }
    }
    /* the pixel itself weighs most, so there is a sum to divide by */
    f->variance[1][p] = variance / (weights * weights);
    for (int k = 0; k < f->count; ++k) {
        struct pbnds_vec3 *out = &f->light[1][(size_t)k * n + p];
        *out = pbnds_scale(*out, 1.0f / weights);
    }
}

static void filter_row(void *context, size_t y, int thread)
{
    const struct filter *f = context;
    (void)thread;
    for (int x = 0; x < f->width; ++x)
        filter_pixel(f, x, (int)y);
}

static void run(struct filter *f)
{
    for (int pass = 0; pass < PASSES; ++pass) {
        f->step = 1 << pass;
        pbnds_parallel_for((size_t)f->height, filter_row, f);
        struct pbnds_vec3 *light = f->light[0];
        float *variance = f->variance[0];
        f->light[0] = f->light[1];
        f->light[1] = light;
        f->variance[0] = f->variance[1];
        f->variance[1] = variance;
    }
}

enum pbnds_status pbnds_atrous(const struct pbnds_gbuffer *gbuffer,
                               const struct pbnds_image *variance,
                               struct pbnds_image *const *images, int count,
                               struct pbnds_error *error)
{
    struct filter f = {.gbuffer = gbuffer,
                       .width = gbuffer->width,
                       .height = gbuffer->height,
                       .count = count};
    const size_t n = pixels(&f);
    f.guides = calloc(n, sizeof *f.guides);
    for (int i = 0; i < 2; ++i) {
        f.light[i] = calloc(n * (size_t)count, sizeof *f.light[i]);
        f.variance[i] = calloc(n, sizeof *f.variance[i]);
    }
    enum pbnds_status status = PBNDS_OK;
    if (f.guides && f.light[0] && f.light[1] && f.variance[0] && f.variance[1]) {
        make_guides(&f);
        load(&f, variance, images);
        run(&f);
        if (pbnds_stop_requested())
            status = pbnds_fail_interrupted(error);
        else
            store(&f, images);
    } else {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory to filter a sample");
    }
    free(f.guides);
    for (int i = 0; i < 2; ++i) {
        free(f.light[i]);
        free(f.variance[i]);
    }
    return status;
}
