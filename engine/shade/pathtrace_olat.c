/* One light at a time; see pathtrace_olat.h. */
#include "engine/shade/pathtrace_olat.h"

#include <math.h>
#include <string.h>

#include "engine/shade/path_blocks.h"
#include "engine/shade/path_start.h"
#include "engine/shade/tiles.h"

enum { DEFAULT_SPP = 256, DEFAULT_BOUNCES = 8, TILE = 8 };
/* Sets of the sampler for shadow rays, apart from those of path.c, which are few. */
enum { SET_SHADOW = 0x10000 };

struct olat {
    const struct pbnds_shade_job *job;
    struct pbnds_path_world world;
    struct pbnds_path_lens lens;
    const struct pbnds_vec3 *wi;
    int count, spp, block;
    struct pbnds_image *radiance, *variance; /* variance: NULL, not wanted */
};

/* The sums of one pixel while its paths are walked. */
struct gathering {
    const struct olat *olat;
    const struct pbnds_sampler *sampler;
    bool first_known; /* the first surface was asked already */
    struct pbnds_vec3 sum[PBNDS_OLAT_LIGHTS];
};

/* Lights of a surface that a shadow ray is worth, with what they would bring. */
struct candidates {
    struct pbnds_ray rays[PBNDS_OLAT_LIGHTS];
    struct pbnds_vec3 light[PBNDS_OLAT_LIGHTS];
    int index[PBNDS_OLAT_LIGHTS];
    int count;
};

static void find_candidates(const struct olat *olat,
                            const struct pbnds_path_visit *visit,
                            struct candidates *found)
{
    const struct pbnds_path_vertex *vertex = visit->vertex;
    const struct pbnds_vec3 origin = pbnds_offset_origin(vertex->position, vertex->ng);
    found->count = 0;
    for (int k = 0; k < olat->count; ++k) {
        const float cos_i = pbnds_path_cosine(vertex, olat->wi[k]);
        if (cos_i == 0.0f) continue;
        const struct pbnds_vec3 f =
            pbnds_bsdf_eval(&vertex->bsdf, vertex->wo, olat->wi[k]);
        const struct pbnds_vec3 light =
            pbnds_scale(pbnds_mul(visit->throughput, f), cos_i);
        if (pbnds_max3(light) == 0.0f) continue;
        found->rays[found->count] = (struct pbnds_ray){origin, olat->wi[k]};
        found->light[found->count] = light;
        found->index[found->count++] = k;
    }
}

/* Every shadow ray of a scene that blends meets layers of its own. */
static bool sees(const struct gathering *g, const struct pbnds_ray *ray, int bounce,
                 int light)
{
    struct pbnds_query how = {.max_t = INFINITY, .stochastic = g->olat->world.blends};
    if (how.stochastic) {
        const int set = SET_SHADOW + bounce * PBNDS_OLAT_LIGHTS + light;
        how.seed = pbnds_sampler_hash(g->sampler, (uint32_t)set);
    }
    return !pbnds_accel_occluded_query(g->olat->world.accel, ray, &how);
}

static void gather(void *context, const struct pbnds_path_visit *visit)
{
    struct gathering *g = context;
    if (visit->bounce == 0 && g->first_known) return;
    struct candidates found;
    find_candidates(g->olat, visit, &found);
    for (int n = 0; n < found.count; ++n) {
        const int k = found.index[n];
        if (sees(g, &found.rays[n], visit->bounce, k))
            g->sum[k] = pbnds_add(g->sum[k], found.light[n]);
    }
}

/* Walks the paths [begin, end) of a pixel. @return how many of them met a surface */
static int walk_block(const struct olat *olat, int x, int y,
                      const struct pbnds_path_vertex *first, int begin, int end,
                      struct gathering *g)
{
    const size_t i = (size_t)y * (size_t)olat->job->gbuffer->width + (size_t)x;
    int hits = 0;
    for (int s = begin; s < end; ++s) {
        const struct pbnds_sampler sampler =
            pbnds_sampler_make(olat->job->seed, i, (uint32_t)s, (uint32_t)olat->spp);
        g->sampler = &sampler;
        if (first) {
            pbnds_path_walk(&olat->world, first, &sampler, gather, g);
            ++hits;
        } else {
            float cone[2];
            const struct pbnds_ray ray =
                pbnds_path_start_ray(&olat->lens, x, y, &sampler, cone);
            hits +=
                pbnds_path_walk_camera(&olat->world, &ray, cone, &sampler, gather, g);
        }
    }
    g->sampler = NULL;
    return hits;
}

/* Adds a block's sums to those of the pixel, which are kept in its place in the images. */
static void add_block(const struct olat *olat, size_t i, const struct gathering *block,
                      int before, int count)
{
    for (int k = 0; k < olat->count; ++k) {
        const float of_block[3] = {block->sum[k].x, block->sum[k].y, block->sum[k].z};
        float *sum = olat->radiance[k].data + 3 * i;
        if (olat->variance)
            pbnds_path_add_spread(olat->variance[k].data + 3 * i, sum, of_block, before,
                                  count);
        for (int c = 0; c < 3; ++c)
            sum[c] += of_block[c];
    }
}

/* Sums to means; `once` is what every path brought, and was not asked again. */
static void resolve(const struct olat *olat, size_t i, int hits,
                    const struct gathering *once)
{
    const float share = (float)hits / (float)olat->spp;
    const double scale =
        olat->variance ? pbnds_path_variance_scale(olat->spp, olat->block) : 0.0;
    for (int k = 0; k < olat->count; ++k) {
        const float known[3] = {once->sum[k].x, once->sum[k].y, once->sum[k].z};
        for (int c = 0; c < 3; ++c) {
            float *value = olat->radiance[k].data + 3 * i + (size_t)c;
            *value = known[c] + *value / (float)hits;
            if (!olat->variance) continue;
            olat->variance[k].data[3 * i + (size_t)c] *= (float)scale / (share * share);
        }
    }
}

static void trace_pixel(const struct olat *olat, int x, int y)
{
    const size_t i = (size_t)y * (size_t)olat->job->gbuffer->width + (size_t)x;
    struct pbnds_path_vertex first;
    const enum pbnds_path_start start = pbnds_path_start_of(&olat->lens, x, y, &first);
    if (start == PBNDS_PATH_NOWHERE) return;
    const bool surface = start == PBNDS_PATH_SURFACE;
    const bool known = surface && !olat->world.blends;
    struct gathering once = {.olat = olat};
    if (known) {
        const struct pbnds_path_visit visit = {&first, pbnds_splat(1.0f), 0};
        gather(&once, &visit);
    }
    int hits = 0;
    for (int s = 0; s < olat->spp; s += olat->block) {
        const int end = s + olat->block < olat->spp ? s + olat->block : olat->spp;
        struct gathering block = {.olat = olat, .first_known = known};
        hits += walk_block(olat, x, y, surface ? &first : NULL, s, end, &block);
        add_block(olat, i, &block, s, end - s);
    }
    if (hits > 0) resolve(olat, i, hits, &once);
}

static void trace_tile(void *context, const struct pbnds_tile *tile)
{
    const struct olat *olat = context;
    for (int y = tile->y0; y < tile->y1 && !pbnds_stop_requested(); ++y)
        for (int x = tile->x0; x < tile->x1; ++x)
            trace_pixel(olat, x, y);
}

static enum pbnds_status check(const struct pbnds_shade_job *job,
                               const struct pbnds_pathtrace_options *options, int count,
                               struct pbnds_error *error)
{
    if (!job->scene || !job->accel)
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "one light at a time needs the scene");
    if (options->spp < 0 || options->max_bounces < 0 || count < 1 ||
        count > PBNDS_OLAT_LIGHTS)
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "one light at a time takes 1 to %d lights, and samples and "
                          "bounces of at least 0",
                          (int)PBNDS_OLAT_LIGHTS);
    return PBNDS_OK;
}

static enum pbnds_status render(struct olat *olat, struct pbnds_error *error)
{
    const struct pbnds_gbuffer *g = olat->job->gbuffer;
    for (int k = 0; k < olat->count; ++k) {
        PBNDS_TRY(pbnds_image_init(&olat->radiance[k], g->width, g->height, 3, error));
        if (olat->variance)
            PBNDS_TRY(
                pbnds_image_init(&olat->variance[k], g->width, g->height, 3, error));
    }
    return pbnds_for_tiles(g->width, g->height, TILE, olat->job->report, "olat",
                           trace_tile, olat, error);
}

enum pbnds_status pbnds_pathtrace_olat(const struct pbnds_shade_job *job,
                                       const struct pbnds_pathtrace_options *options,
                                       const struct pbnds_vec3 *wi, int count,
                                       struct pbnds_image *radiance,
                                       struct pbnds_image *variance,
                                       struct pbnds_error *error)
{
    PBNDS_TRY(check(job, options, count, error));
    memset(radiance, 0, (size_t)count * sizeof *radiance);
    if (variance) memset(variance, 0, (size_t)count * sizeof *variance);
    struct olat olat = {.job = job,
                        .wi = wi,
                        .count = count,
                        .spp = options->spp > 0 ? options->spp : DEFAULT_SPP,
                        .radiance = radiance};
    olat.block = pbnds_path_block_size(olat.spp);
    if (olat.spp > 1) olat.variance = variance;
    olat.world = (struct pbnds_path_world){.scene = job->scene,
                                           .accel = job->accel,
                                           .max_bounces = options->max_bounces > 0
                                                              ? options->max_bounces
                                                              : DEFAULT_BOUNCES,
                                           .blends = pbnds_accel_blends(job->accel)};
    olat.lens = pbnds_path_lens_make(job->gbuffer, &olat.world);
    const enum pbnds_status status = render(&olat, error);
    for (int k = 0; k < count && status != PBNDS_OK; ++k) {
        pbnds_image_free(&radiance[k]);
        if (variance) pbnds_image_free(&variance[k]);
    }
    return status;
}
