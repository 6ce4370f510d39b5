/* Area averages of an equirect map: the prefiltered chain, its lookup, and baking. */
#include <stdlib.h>
#include <string.h>

#include "engine/scene/envmap_map.h"

static const double PI = 3.14159265358979323846;

/* A grid of texels to read from. u_shift turns it: column u of the result is column
   u + u_shift of the source. */
struct source {
    int width, height;
    const struct pbnds_vec3 *texels;
    double u_shift;
};

/* Mean of one source row over each of `width` columns, by exact overlap, wrapping. */
static void filter_row(const struct source *src, int y, int width, double *out)
{
    const struct pbnds_vec3 *row = src->texels + (size_t)y * (size_t)src->width;
    const double ratio = (double)src->width / (double)width;
    const double shift = src->u_shift * (double)src->width;
    for (int x = 0; x < width; ++x) {
        const double begin = (double)x * ratio + shift;
        const double end = (double)(x + 1) * ratio + shift;
        double sum[3] = {0.0, 0.0, 0.0}, total = 0.0;
        int column = (int)floor(begin);
        for (double at = begin; at < end; ++column) {
            const double next = fmin((double)(column + 1), end);
            const double weight = next - at;
            const int wrapped = ((column % src->width) + src->width) % src->width;
            const struct pbnds_vec3 c = row[wrapped];
            sum[0] += weight * (double)c.x;
            sum[1] += weight * (double)c.y;
            sum[2] += weight * (double)c.z;
            total += weight;
            at = next;
        }
        for (int c = 0; c < 3; ++c)
            out[3 * x + c] = sum[c] / total;
    }
}

/* Area average of src on a width x height grid. Rows are weighted by the solid angle of
   their overlap, cos(theta_0) - cos(theta_1), so that the integral over the sphere is
   kept. `out` is width * height * 3 floats. */
static bool resample(const struct source *src, int width, int height, float *out)
{
    const size_t n = 3 * (size_t)width;
    double *filtered = malloc(2 * n * sizeof *filtered);
    if (!filtered) return false;
    double *sum = filtered + n;
    int cached = -1; /* a row on the border of two results is filtered once */
    for (int y = 0; y < height; ++y) {
        const double begin = (double)y / (double)height;
        const double end = (double)(y + 1) / (double)height;
        double total = 0.0;
        memset(sum, 0, n * sizeof *sum);
        for (int row = (int)(begin * (double)src->height); row < src->height; ++row) {
            const double top = fmax(begin, (double)row / (double)src->height);
            const double bottom = fmin(end, (double)(row + 1) / (double)src->height);
            if (top >= end) break;
            if (top >= bottom) continue;
            const double weight = cos(PI * top) - cos(PI * bottom);
            if (row != cached) filter_row(src, row, width, filtered);
            cached = row;
            for (size_t i = 0; i < n; ++i)
                sum[i] += weight * filtered[i];
            total += weight;
        }
        for (size_t i = 0; i < n; ++i)
            out[(size_t)y * n + i] = (float)(sum[i] / total);
    }
    free(filtered);
    return true;
}

bool pbnds_envmap_build_levels(struct pbnds_envmap *envmap)
{
    struct pbnds_envmap_level *level = envmap->levels;
    level->width = envmap->width;
    level->height = envmap->height;
    level->texels = envmap->texels;
    envmap->level_count = 1;
    for (;; ++level) {
        level->log2_solid_angle =
            (float)log2(4.0 * PI / ((double)level->width * (double)level->height));
        if (level->width == 1 && level->height == 1) return true;
        struct pbnds_envmap_level *next = level + 1;
        next->width = level->width > 1 ? level->width / 2 : 1;
        next->height = level->height > 1 ? level->height / 2 : 1;
        const size_t n = (size_t)next->width * (size_t)next->height;
        next->texels = malloc(n * sizeof *next->texels);
        if (!next->texels) return false;
        ++envmap->level_count;
        const struct source src = {level->width, level->height, level->texels, 0.0};
        if (!resample(&src, next->width, next->height, &next->texels->x)) return false;
    }
}

/* Bilinear; u wraps, v stops at the centres of the first and last row. */
static struct pbnds_vec3 lookup(const struct pbnds_envmap_level *level, float u,
                                float v)
{
    const float fx = u * (float)level->width - 0.5f;
    const float fy =
        pbnds_clamp(v * (float)level->height - 0.5f, 0.0f, (float)(level->height - 1));
    const float floor_x = floorf(fx);
    int x0 = (int)floor_x;
    const int y0 = (int)fy;
    const float s = fx - floor_x, t = fy - (float)y0;
    int x1 = x0 + 1;
    if (x0 < 0) x0 += level->width;
    if (x1 >= level->width) x1 -= level->width;
    const int y1 = y0 + 1 < level->height ? y0 + 1 : y0;
    const struct pbnds_vec3 *top = level->texels + (size_t)y0 * (size_t)level->width;
    const struct pbnds_vec3 *bottom = level->texels + (size_t)y1 * (size_t)level->width;
    return pbnds_lerp(pbnds_lerp(top[x0], top[x1], s),
                      pbnds_lerp(bottom[x0], bottom[x1], s), t);
}

/* log2 of the texel whose bilinear lookup blurs like the cone. A texel of area A under
   a tent has variance A/12 + A/6 along each axis, a disc of area W has W / 4 pi: equal
   when A = W / pi. Towards the whole sphere the divisor goes to 1, so that 4 pi is the
   mean. */
static float log2_texel_for(float solid_angle)
{
    const float whole = 4.0f * PBNDS_PI;
    const float cone = fminf(fmaxf(solid_angle, 1e-12f), whole); /* NaN too */
    return log2f(cone / (PBNDS_PI - (PBNDS_PI - 1.0f) * cone / whole));
}

/* Trilinear, between the levels whose texels are next in size. */
static struct pbnds_vec3 lookup_between(const struct pbnds_envmap *envmap, float u,
                                        float v, float size)
{
    const struct pbnds_envmap_level *levels = envmap->levels;
    const int last = envmap->level_count - 1;
    int i = 0;
    while (i < last && levels[i + 1].log2_solid_angle <= size)
        ++i;
    const struct pbnds_vec3 fine = lookup(&levels[i], u, v);
    if (i == last || size <= levels[i].log2_solid_angle) return fine;
    const float t = (size - levels[i].log2_solid_angle) /
                    (levels[i + 1].log2_solid_angle - levels[i].log2_solid_angle);
    return pbnds_lerp(fine, lookup(&levels[i + 1], u, v), t);
}

struct pbnds_vec3 pbnds_envmap_eval_cone(const struct pbnds_envmap *envmap,
                                         struct pbnds_vec3 w, float solid_angle)
{
    double u, v;
    pbnds_envmap_uv(envmap, w, &u, &v);
    if (isnan(u) || isnan(v)) u = v = 0.0;
    return lookup_between(envmap, (float)u, (float)v, log2_texel_for(solid_angle));
}

struct pbnds_env_place pbnds_envmap_place(struct pbnds_vec3 w, float solid_angle)
{
    static const struct pbnds_envmap unturned = {.u_offset = 0.5};
    double u, v;
    pbnds_envmap_uv(&unturned, w, &u, &v);
    if (isnan(u) || isnan(v)) u = v = 0.0;
    return (struct pbnds_env_place){(float)(u - 0.5), (float)v,
                                    log2_texel_for(solid_angle)};
}

struct pbnds_vec3 pbnds_envmap_eval_place(const struct pbnds_envmap *envmap,
                                          struct pbnds_env_place place)
{
    const double turned = (double)place.turn + envmap->u_offset;
    const double u = turned - floor(turned);
    return lookup_between(envmap, (float)u, place.v, place.log2_texel);
}

enum pbnds_status pbnds_envmap_bake(const struct pbnds_envmap *envmap, int width,
                                    int height, struct pbnds_image *image,
                                    struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_image_init(image, width, height, 3, error));
    const struct source src = {envmap->width, envmap->height, envmap->texels,
                               envmap->u_offset - 0.5};
    if (resample(&src, width, height, image->data)) return PBNDS_OK;
    pbnds_image_free(image);
    return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                      "light map: no memory to bake it to %d x %d; use a smaller size",
                      width, height);
}
