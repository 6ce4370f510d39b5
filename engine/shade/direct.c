/* Direct light by multiple importance sampling; see direct.h. */
#include "engine/shade/direct.h"

#include <assert.h>
#include <math.h>

#include "engine/shade/light_punctual.h"
#include "engine/shade/sampler.h"
#include "engine/shade/tiles.h"

/* Decisions of a sample; the lights of the file follow the last. */
enum { SET_LIGHT, SET_BRDF, SET_PUNCTUAL };

struct pass {
    const struct pbnds_direct_model *model;
    const struct pbnds_shade_job *job;
    struct pbnds_image *radiance;
    int spp;
    bool shadows, blends; /* blends: what a shadow ray meets is a matter of chance */
};

/* The surface point of one pixel. */
struct point {
    const struct pass *pass;
    union pbnds_direct_lobe lobe;
    size_t pixel;
    struct pbnds_vec3 position, n, ng, wo;
    struct pbnds_vec3 origin; /* position, moved off the surface */
    struct pbnds_vec3 sum;    /* of the samples so far */
};

/* Shadow rays go one by one: packets of 16 of one pixel's rays, which point anywhere,
 * were no faster. */
static bool sees(const struct point *point, struct pbnds_vec3 wi, float max_t,
                 const struct pbnds_sampler *sampler, uint32_t set)
{
    if (!point->pass->shadows) return true;
    if (pbnds_dot(wi, point->ng) <= 0.0f) return false;
    const struct pbnds_ray ray = {.origin = point->origin, .direction = wi};
    struct pbnds_query query = {.max_t = max_t, .stochastic = point->pass->blends};
    if (query.stochastic) query.seed = pbnds_sampler_hash(sampler, set);
    return !pbnds_accel_occluded_query(point->pass->job->accel, &ray, &query);
}

static void add_light(struct point *point, struct pbnds_vec3 wi,
                      struct pbnds_vec3 light, const struct pbnds_sampler *sampler,
                      uint32_t set)
{
    assert(light.x >= 0.0f && light.y >= 0.0f && light.z >= 0.0f);
    assert(isfinite(light.x) && isfinite(light.y) && isfinite(light.z));
    if (pbnds_max3(light) == 0.0f) return;
    if (sees(point, wi, INFINITY, sampler, set))
        point->sum = pbnds_add(point->sum, light);
}

static void light_sample(struct point *point, const struct pbnds_sampler *sampler)
{
    const struct pbnds_direct_model *model = point->pass->model;
    float u[2];
    pbnds_sampler_get(sampler, SET_LIGHT, 2, u);
    const struct pbnds_env_sample s =
        pbnds_envmap_sample(point->pass->job->envmap, u[0], u[1]);
    const float cos_i = pbnds_dot(point->n, s.wi);
    if (!(s.pdf > 0.0f) || cos_i <= 0.0f) return;
    const struct pbnds_vec3 f = model->eval(&point->lobe, point->wo, s.wi);
    const float pdf = s.pdf + model->pdf(&point->lobe, point->wo, s.wi);
    add_light(point, s.wi, pbnds_scale(pbnds_mul(f, s.radiance), cos_i / pdf), sampler,
              SET_LIGHT);
}

static void brdf_sample(struct point *point, const struct pbnds_sampler *sampler)
{
    const struct pbnds_envmap *envmap = point->pass->job->envmap;
    float u[3];
    pbnds_sampler_get(sampler, SET_BRDF, 3, u);
    struct pbnds_brdf_sample s;
    if (!point->pass->model->sample(&point->lobe, point->wo, u[0], u[1], u[2], &s))
        return;
    const float cos_i = pbnds_dot(point->n, s.wi);
    if (cos_i <= 0.0f) return;
    const float pdf = s.pdf + pbnds_envmap_pdf(envmap, s.wi);
    const struct pbnds_vec3 light = pbnds_mul(s.f, pbnds_envmap_eval(envmap, s.wi));
    add_light(point, s.wi, pbnds_scale(light, cos_i / pdf), sampler, SET_BRDF);
}

static struct pbnds_sampler sampler_of(const struct point *point, int s)
{
    const struct pass *pass = point->pass;
    return pbnds_sampler_make(pass->job->seed, point->pixel, (uint32_t)s,
                              (uint32_t)pass->spp);
}

/* Reflected light of the map. */
static struct pbnds_vec3 from_map(struct point *point)
{
    point->sum = pbnds_splat(0.0f);
    for (int s = 0; s < point->pass->spp; ++s) {
        const struct pbnds_sampler sampler = sampler_of(point, s);
        light_sample(point, &sampler);
        brdf_sample(point, &sampler);
    }
    return pbnds_scale(point->sum, 1.0f / (float)point->pass->spp);
}

/* Share of a light's rays that arrive. One ray tells all where nothing blends. */
static float visibility(const struct point *point, struct pbnds_vec3 wi, float distance,
                        int light)
{
    const int rays = point->pass->blends ? point->pass->spp : 1;
    int arrived = 0;
    for (int s = 0; s < rays; ++s) {
        const struct pbnds_sampler sampler = sampler_of(point, s);
        const uint32_t set = SET_PUNCTUAL + (uint32_t)light;
        arrived += sees(point, wi, distance, &sampler, set) ? 1 : 0;
    }
    return (float)arrived / (float)rays;
}

/* Reflected light of one light of the file. */
static struct pbnds_vec3 from_light(const struct point *point, int light)
{
    const struct pass *pass = point->pass;
    struct pbnds_punctual p;
    if (!pbnds_light_punctual(&pass->job->scene->lights[light], point->position, &p))
        return pbnds_splat(0.0f);
    const float cos_i = pbnds_dot(point->n, p.wi);
    if (cos_i <= 0.0f) return pbnds_splat(0.0f);
    const struct pbnds_vec3 f = pass->model->eval(&point->lobe, point->wo, p.wi);
    if (pbnds_max3(f) <= 0.0f) return pbnds_splat(0.0f);
    return pbnds_scale(pbnds_mul(f, p.irradiance),
                       cos_i * visibility(point, p.wi, p.distance, light));
}

static struct pbnds_vec3 reflected(const struct pass *pass, int x, int y, size_t i)
{
    const struct pbnds_gbuffer *g = pass->job->gbuffer;
    const int lights = pass->job->scene ? pass->job->scene->light_count : 0;
    struct pbnds_vec3 sum = {0.0f, 0.0f, 0.0f};
    if (!pass->job->envmap && lights == 0) return sum;
    struct point point = {.pass = pass, .pixel = i};
    pass->model->load(&point.lobe, g, i);
    point.n = pbnds_gbuffer_vec3(g->normal, i);
    point.ng = pbnds_gbuffer_vec3(g->geometric_normal, i);
    point.wo = pbnds_gbuffer_wo(g, x, y);
    point.position = pbnds_gbuffer_vec3(g->position, i);
    point.origin = pbnds_offset_origin(point.position, point.ng);
    if (pass->job->envmap) sum = from_map(&point);
    for (int light = 0; light < lights; ++light)
        sum = pbnds_add(sum, from_light(&point, light));
    return sum;
}

static void shade_tile(void *context, const struct pbnds_tile *tile)
{
    const struct pass *pass = context;
    const struct pbnds_gbuffer *g = pass->job->gbuffer;
    for (int y = tile->y0; y < tile->y1 && !pbnds_stop_requested(); ++y)
        for (int x = tile->x0; x < tile->x1; ++x) {
            const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
            if (!(g->coverage[i] > 0.0f)) continue;
            const struct pbnds_vec3 sum =
                pbnds_add(pbnds_gbuffer_vec3(g->emission, i), reflected(pass, x, y, i));
            float *out = pbnds_image_at(pass->radiance, x, y);
            out[0] = sum.x, out[1] = sum.y, out[2] = sum.z;
        }
}

enum pbnds_status pbnds_direct(const struct pbnds_direct_model *model,
                               const struct pbnds_shade_job *job,
                               struct pbnds_image *radiance, struct pbnds_error *error)
{
    struct pass pass = {.model = model, .job = job, .radiance = radiance};
    pass.spp = job->spp > 0 ? job->spp : model->spp;
    pass.shadows = job->accel && (job->shadows < 0 ? model->shadows : job->shadows > 0);
    pass.blends = pass.shadows && pbnds_accel_blends(job->accel);
    return pbnds_for_tiles(job->gbuffer->width, job->gbuffer->height, 16, job->report,
                           model->name, shade_tile, &pass, error);
}
