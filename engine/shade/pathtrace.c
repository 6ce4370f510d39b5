/* The reference path tracer; see pathtrace.h.
 *
 * At each vertex one direction is drawn from the light map (and gets a shadow ray) and
 * one from the BRDF (whose ray also finds the next vertex). A direction that both could
 * have drawn counts by the balance heuristic (Veach 1997, eq. 9.8). Emitting surfaces
 * are found by BRDF rays alone. Rays go one by one: packets of one pixel's rays were 10
 * to 20 % slower, because past the first hit they share nothing. */
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

/* The surface point that a path has come to. */
struct vertex {
    struct pbnds_vec3 position, ng, wo;
    struct pbnds_bsdf bsdf;
};

struct path {
    const struct trace *trace;
    struct pbnds_sampler sampler;
    struct vertex vertex;
    struct pbnds_vec3 throughput;
    int bounce; /* surfaces behind the vertex; 0 at the primary hit */
    struct pbnds_vec3 total, direct;
};

static void add_light(struct path *path, struct pbnds_vec3 light)
{
    assert(light.x >= 0.0f && light.y >= 0.0f && light.z >= 0.0f);
    assert(isfinite(light.x) && isfinite(light.y) && isfinite(light.z));
    path->total = pbnds_add(path->total, light);
    if (path->bounce == 0) path->direct = pbnds_add(path->direct, light);
}

static void draw(const struct path *path, int set, int dimensions, float *u)
{
    pbnds_sampler_get(&path->sampler, (uint32_t)(path->bounce * SET_COUNT + set),
                      dimensions, u);
}

static struct pbnds_ray leave(const struct vertex *vertex, struct pbnds_vec3 wi)
{
    return (struct pbnds_ray){
        .origin = pbnds_offset_origin(vertex->position, vertex->ng), .direction = wi};
}

/* n.wi, or 0 where the surface itself is in the way: below either of its normals. */
static float cosine(const struct vertex *vertex, struct pbnds_vec3 wi)
{
    const float cos_i = pbnds_dot(vertex->bsdf.frame.n, wi);
    return cos_i > 0.0f && pbnds_dot(vertex->ng, wi) > 0.0f ? cos_i : 0.0f;
}

/* Light from a direction drawn from the map. */
static void gather_light(struct path *path)
{
    const struct vertex *vertex = &path->vertex;
    float u[2];
    draw(path, SET_LIGHT, 2, u);
    const struct pbnds_env_sample s =
        pbnds_envmap_sample(path->trace->job->envmap, u[0], u[1]);
    const float cos_i = cosine(vertex, s.wi);
    if (!(s.pdf > 0.0f) || cos_i == 0.0f) return;
    const struct pbnds_vec3 f = pbnds_bsdf_eval(&vertex->bsdf, vertex->wo, s.wi);
    const float pdf = s.pdf + pbnds_bsdf_pdf(&vertex->bsdf, vertex->wo, s.wi);
    const struct pbnds_vec3 light =
        pbnds_scale(pbnds_mul(pbnds_mul(path->throughput, f), s.radiance), cos_i / pdf);
    if (pbnds_max3(light) == 0.0f) return;
    const struct pbnds_ray ray = leave(vertex, s.wi);
    if (!pbnds_accel_occluded(path->trace->job->accel, &ray, INFINITY))
        add_light(path, light);
}

/* Paths that carry little end at random, the others make up for them. */
static bool survives_roulette(struct path *path)
{
    if (path->bounce < ROULETTE_BOUNCE) return true;
    const float keep = fminf(pbnds_max3(path->throughput), 0.95f);
    float u;
    draw(path, SET_ROULETTE, 1, &u);
    if (u >= keep) return false;
    path->throughput = pbnds_scale(path->throughput, 1.0f / keep);
    return true;
}

/* Draws the next direction from the BRDF. false: the path ends here. */
static bool scatter(struct path *path, struct pbnds_vec3 *wi, float *pdf)
{
    float u[3];
    struct pbnds_brdf_sample s;
    draw(path, SET_BRDF, 3, u);
    if (!pbnds_bsdf_sample(&path->vertex.bsdf, path->vertex.wo, u[0], u[1], u[2], &s))
        return false;
    const float cos_i = cosine(&path->vertex, s.wi);
    path->throughput = pbnds_scale(pbnds_mul(path->throughput, s.f), cos_i / s.pdf);
    *wi = s.wi;
    *pdf = s.pdf;
    return pbnds_max3(path->throughput) > 0.0f && survives_roulette(path);
}

/* The ray left the scene: the map's light, weighed against gather_light(). */
static void escape(struct path *path, struct pbnds_vec3 wi, float pdf)
{
    const struct pbnds_envmap *envmap = path->trace->job->envmap;
    if (!envmap) return;
    const float weight = pdf / (pdf + pbnds_envmap_pdf(envmap, wi));
    const struct pbnds_vec3 radiance = pbnds_envmap_eval(envmap, wi);
    add_light(path, pbnds_scale(pbnds_mul(path->throughput, radiance), weight));
}

static void arrive(struct path *path, const struct pbnds_hit *hit, struct pbnds_vec3 wi)
{
    struct vertex *vertex = &path->vertex;
    struct pbnds_surface surface;
    vertex->wo = pbnds_scale(wi, -1.0f);
    pbnds_scene_surface(path->trace->job->scene, hit, vertex->wo, 0.0f, &surface);
    vertex->position = surface.position;
    vertex->ng = surface.ng;
    vertex->bsdf = pbnds_bsdf_from_surface(&surface);
    ++path->bounce;
    add_light(path, pbnds_mul(path->throughput, surface.emission));
}

static void trace_path(struct path *path)
{
    for (;;) {
        if (path->trace->job->envmap) gather_light(path);
        struct pbnds_vec3 wi;
        float pdf;
        struct pbnds_hit hit;
        if (!scatter(path, &wi, &pdf)) return;
        const struct pbnds_ray ray = leave(&path->vertex, wi);
        pbnds_accel_intersect(path->trace->job->accel, &ray, &hit);
        if (hit.mesh == UINT32_MAX) {
            escape(path, wi, pdf);
            return;
        }
        if (path->bounce == path->trace->max_bounces) return;
        arrive(path, &hit, wi);
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
    const struct vertex first = {.position = plane3(g->position, i),
                                 .ng = plane3(g->geometric_normal, i),
                                 .wo = pbnds_gbuffer_wo(g, x, y),
                                 .bsdf = pbnds_bsdf_from_gbuffer(g, i)};
    struct pbnds_vec3 total = {0.0f, 0.0f, 0.0f}, direct = total;
    for (int s = 0; s < trace->spp; ++s) {
        struct path path = {.trace = trace,
                            .sampler = pbnds_sampler_make(
                                trace->job->seed, i, (uint32_t)s, (uint32_t)trace->spp),
                            .vertex = first,
                            .throughput = {1.0f, 1.0f, 1.0f}};
        trace_path(&path);
        total = pbnds_add(total, path.total);
        direct = pbnds_add(direct, path.direct);
    }
    const struct pbnds_vec3 emission = plane3(g->emission, i);
    store(trace->radiance, i, emission, total, trace->spp);
    store(trace->direct, i, emission, direct, trace->spp);
}

static void trace_tile(void *context, const struct pbnds_tile *tile)
{
    const struct trace *trace = context;
    const struct pbnds_gbuffer *g = trace->job->gbuffer;
    for (int y = tile->y0; y < tile->y1 && !pbnds_stop_requested(); ++y)
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
