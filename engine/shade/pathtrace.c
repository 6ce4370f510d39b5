/* The reference path tracer; see pathtrace.h.
 *
 * The samples of a pixel advance in bundles of one ray packet: at each vertex a bundle
 * casts the shadow rays of its light samples together, then the rays that its BRDFs
 * drew. A direction that both ways of sampling could have drawn counts by the balance
 * heuristic (Veach 1997, eq. 9.8). Emitting surfaces are found by BRDF rays alone. */
#include "engine/shade/pathtrace.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "engine/shade/bsdf.h"
#include "engine/shade/sampler.h"
#include "engine/shade/tiles.h"

enum { DEFAULT_SPP = 256, DEFAULT_BOUNCES = 8, ROULETTE_BOUNCE = 3, TILE = 8 };

/* The decisions at one vertex, for the sampler. */
enum { SET_LIGHT, SET_BRDF, SET_ROULETTE, SET_COUNT };

struct trace {
    const struct pbnds_shade_job *job;
    int spp, max_bounces;
    float *radiance, *direct; /* direct may be NULL */
};

/* A path and the surface point it has come to. */
struct path {
    struct pbnds_sampler sampler;
    struct pbnds_vec3 throughput;
    struct pbnds_vec3 position, ng, wo;
    struct pbnds_bsdf bsdf;
};

struct bundle {
    const struct trace *trace;
    struct path paths[PBNDS_PACKET]; /* those alive are the first `count` */
    int count, bounce;
    struct pbnds_vec3 total, direct;
};

static void add_light(struct bundle *bundle, struct pbnds_vec3 light)
{
    assert(light.x >= 0.0f && light.y >= 0.0f && light.z >= 0.0f);
    assert(isfinite(light.x) && isfinite(light.y) && isfinite(light.z));
    bundle->total = pbnds_add(bundle->total, light);
    if (bundle->bounce == 0) bundle->direct = pbnds_add(bundle->direct, light);
}

static uint32_t decision(const struct bundle *bundle, int set)
{
    return (uint32_t)(bundle->bounce * SET_COUNT + set);
}

static struct pbnds_ray leave(const struct path *path, struct pbnds_vec3 wi)
{
    return (struct pbnds_ray){.origin = pbnds_offset_origin(path->position, path->ng),
                              .direction = wi};
}

/* Draws a direction from the map. false: it brings no light whatever the shadow ray
 * says. */
static bool sample_light(const struct bundle *bundle, const struct path *path,
                         struct pbnds_ray *ray, struct pbnds_vec3 *light)
{
    float u[2];
    pbnds_sampler_get(&path->sampler, decision(bundle, SET_LIGHT), 2, u);
    const struct pbnds_env_sample s =
        pbnds_envmap_sample(bundle->trace->job->envmap, u[0], u[1]);
    const float cos_i = pbnds_dot(path->bsdf.frame.n, s.wi);
    if (!(s.pdf > 0.0f) || cos_i <= 0.0f || pbnds_dot(path->ng, s.wi) <= 0.0f)
        return false;
    const struct pbnds_vec3 f = pbnds_bsdf_eval(&path->bsdf, path->wo, s.wi);
    const float pdf = s.pdf + pbnds_bsdf_pdf(&path->bsdf, path->wo, s.wi);
    *light =
        pbnds_scale(pbnds_mul(pbnds_mul(path->throughput, f), s.radiance), cos_i / pdf);
    *ray = leave(path, s.wi);
    return pbnds_max3(*light) > 0.0f;
}

static void gather_light(struct bundle *bundle)
{
    struct pbnds_ray rays[PBNDS_PACKET];
    struct pbnds_vec3 light[PBNDS_PACKET];
    bool occluded[PBNDS_PACKET];
    int n = 0;
    for (int i = 0; i < bundle->count; ++i)
        if (sample_light(bundle, &bundle->paths[i], &rays[n], &light[n])) ++n;
    if (n == 0) return;
    pbnds_accel_occluded_packet(bundle->trace->job->accel, rays, n, INFINITY, occluded);
    for (int i = 0; i < n; ++i)
        if (!occluded[i]) add_light(bundle, light[i]);
}

/* Paths that carry little end at random, the others make up for them. */
static bool survives_roulette(const struct bundle *bundle, struct path *path)
{
    if (bundle->bounce < ROULETTE_BOUNCE) return true;
    const float keep = fminf(pbnds_max3(path->throughput), 0.95f);
    float u;
    pbnds_sampler_get(&path->sampler, decision(bundle, SET_ROULETTE), 1, &u);
    if (u >= keep) return false;
    path->throughput = pbnds_scale(path->throughput, 1.0f / keep);
    return true;
}

/* Draws the next direction from the BRDF. false: the path ends here. Directions below
 * the geometric surface end it too: the surface itself is in the way. */
static bool sample_brdf(const struct bundle *bundle, struct path *path,
                        struct pbnds_ray *ray, float *pdf)
{
    float u[3];
    struct pbnds_brdf_sample s;
    pbnds_sampler_get(&path->sampler, decision(bundle, SET_BRDF), 3, u);
    if (!pbnds_bsdf_sample(&path->bsdf, path->wo, u[0], u[1], u[2], &s)) return false;
    const float cos_i = pbnds_dot(path->bsdf.frame.n, s.wi);
    if (cos_i <= 0.0f || pbnds_dot(path->ng, s.wi) <= 0.0f) return false;
    path->throughput = pbnds_scale(pbnds_mul(path->throughput, s.f), cos_i / s.pdf);
    if (!survives_roulette(bundle, path)) return false;
    *pdf = s.pdf;
    *ray = leave(path, s.wi);
    return pbnds_max3(path->throughput) > 0.0f;
}

/* The ray left the scene: the map's light, weighed against sample_light(). */
static void escape(struct bundle *bundle, const struct path *path, struct pbnds_vec3 wi,
                   float pdf)
{
    const struct pbnds_envmap *envmap = bundle->trace->job->envmap;
    if (!envmap) return;
    const float weight = pdf / (pdf + pbnds_envmap_pdf(envmap, wi));
    const struct pbnds_vec3 radiance = pbnds_envmap_eval(envmap, wi);
    add_light(bundle, pbnds_scale(pbnds_mul(path->throughput, radiance), weight));
}

static void arrive(const struct trace *trace, struct path *path,
                   const struct pbnds_hit *hit, struct pbnds_vec3 wi,
                   struct pbnds_vec3 *emission)
{
    struct pbnds_surface surface;
    path->wo = pbnds_scale(wi, -1.0f);
    pbnds_scene_surface(trace->job->scene, hit, path->wo, &surface);
    path->position = surface.position;
    path->ng = surface.ng;
    path->bsdf = pbnds_bsdf_make(surface.n, surface.base_color, surface.metallic,
                                 surface.roughness, surface.dielectric_f0);
    *emission = pbnds_mul(path->throughput, surface.emission);
}

/* Moves every path to its next vertex; those that end leave the bundle. */
static void advance(struct bundle *bundle)
{
    const struct trace *trace = bundle->trace;
    struct pbnds_ray rays[PBNDS_PACKET];
    struct pbnds_hit hits[PBNDS_PACKET];
    float pdf[PBNDS_PACKET];
    int n = 0;
    for (int i = 0; i < bundle->count; ++i) {
        if (n != i) bundle->paths[n] = bundle->paths[i];
        if (sample_brdf(bundle, &bundle->paths[n], &rays[n], &pdf[n])) ++n;
    }
    bundle->count = 0;
    if (n == 0) return;
    pbnds_accel_intersect_packet(trace->job->accel, rays, n, hits);
    struct pbnds_vec3 emitted = {0.0f, 0.0f, 0.0f};
    for (int i = 0; i < n; ++i) {
        struct path *path = &bundle->paths[i];
        if (hits[i].mesh == UINT32_MAX) {
            escape(bundle, path, rays[i].direction, pdf[i]);
        } else if (bundle->bounce < trace->max_bounces) {
            struct pbnds_vec3 emission;
            arrive(trace, path, &hits[i], rays[i].direction, &emission);
            emitted = pbnds_add(emitted, emission);
            if (bundle->count != i) bundle->paths[bundle->count] = *path;
            ++bundle->count;
        }
    }
    ++bundle->bounce;
    add_light(bundle, emitted);
}

static void trace_bundle(struct bundle *bundle)
{
    while (bundle->count > 0) {
        if (bundle->trace->job->envmap) gather_light(bundle);
        advance(bundle);
    }
}

static struct pbnds_vec3 plane3(float *const plane[3], size_t i)
{
    return pbnds_vec3_make(plane[0][i], plane[1][i], plane[2][i]);
}

static void store(float *out, size_t i, struct pbnds_vec3 emission,
                  struct pbnds_vec3 sum, int spp)
{
    if (!out) return;
    const struct pbnds_vec3 mean = pbnds_mad(emission, sum, 1.0f / (float)spp);
    out[3 * i] = mean.x, out[3 * i + 1] = mean.y, out[3 * i + 2] = mean.z;
}

static void trace_pixel(const struct trace *trace, int x, int y, size_t i)
{
    const struct pbnds_gbuffer *g = trace->job->gbuffer;
    const struct path first = {.throughput = {1.0f, 1.0f, 1.0f},
                               .position = plane3(g->position, i),
                               .ng = plane3(g->geometric_normal, i),
                               .wo = pbnds_gbuffer_wo(g, x, y),
                               .bsdf = pbnds_bsdf_from_gbuffer(g, i)};
    struct pbnds_vec3 total = {0.0f, 0.0f, 0.0f}, direct = total;
    struct bundle bundle;
    bundle.trace = trace;
    for (int s = 0; s < trace->spp; s += PBNDS_PACKET) {
        bundle.count = trace->spp - s < PBNDS_PACKET ? trace->spp - s : PBNDS_PACKET;
        bundle.bounce = 0;
        bundle.total = bundle.direct = pbnds_splat(0.0f);
        for (int lane = 0; lane < bundle.count; ++lane) {
            bundle.paths[lane] = first;
            bundle.paths[lane].sampler = pbnds_sampler_make(
                trace->job->seed, i, (uint32_t)(s + lane), (uint32_t)trace->spp);
        }
        trace_bundle(&bundle);
        total = pbnds_add(total, bundle.total);
        direct = pbnds_add(direct, bundle.direct);
    }
    const struct pbnds_vec3 emission = plane3(g->emission, i);
    store(trace->radiance, i, emission, total, trace->spp);
    store(trace->direct, i, emission, direct, trace->spp);
}

static void trace_tile(void *context, const struct pbnds_tile *tile)
{
    const struct trace *trace = context;
    const struct pbnds_gbuffer *g = trace->job->gbuffer;
    for (int y = tile->y0; y < tile->y1; ++y)
        for (int x = tile->x0; x < tile->x1; ++x) {
            const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
            if (g->coverage[i] > 0.0f) trace_pixel(trace, x, y, i);
        }
}

static enum pbnds_status check(const struct pbnds_shade_job *job,
                               const struct pbnds_pathtrace_options *options,
                               struct pbnds_error *error)
{
    if (!job->scene || !job->accel)
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "reference needs the scene; give a .glb, or choose ggx, neural");
    if (options->spp < 0 || options->max_bounces < 0)
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "reference: %d samples and %d bounces were asked for; give "
                          "positive numbers, or 0 for the defaults",
                          options->spp, options->max_bounces);
    return PBNDS_OK;
}

enum pbnds_status pbnds_pathtrace(const struct pbnds_shade_job *job,
                                  const struct pbnds_pathtrace_options *options,
                                  struct pbnds_image *radiance,
                                  struct pbnds_image *direct, struct pbnds_error *error)
{
    memset(radiance, 0, sizeof *radiance);
    if (direct) memset(direct, 0, sizeof *direct);
    PBNDS_TRY(check(job, options, error));
    const int width = job->gbuffer->width, height = job->gbuffer->height;
    struct trace trace = {.job = job};
    trace.spp = options->spp > 0 ? options->spp : DEFAULT_SPP;
    trace.max_bounces =
        options->max_bounces > 0 ? options->max_bounces : DEFAULT_BOUNCES;
    enum pbnds_status status = pbnds_image_init(radiance, width, height, 3, error);
    if (status == PBNDS_OK && direct)
        status = pbnds_image_init(direct, width, height, 3, error);
    if (status == PBNDS_OK) {
        trace.radiance = radiance->data;
        trace.direct = direct ? direct->data : NULL;
        status = pbnds_for_tiles(width, height, TILE, job->report, "reference",
                                 trace_tile, &trace, error);
    }
    if (status != PBNDS_OK) {
        pbnds_image_free(radiance);
        if (direct) pbnds_image_free(direct);
    }
    return status;
}
