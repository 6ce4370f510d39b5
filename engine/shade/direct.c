/* Direct light from the map by multiple importance sampling; see direct.h. */
#include "engine/shade/direct.h"

#include <assert.h>
#include <math.h>

#include "engine/shade/sampler.h"
#include "engine/shade/tiles.h"

enum { SET_LIGHT, SET_BRDF };

struct pass {
    const struct pbnds_direct_model *model;
    const struct pbnds_shade_job *job;
    struct pbnds_image *radiance;
    int spp;
    bool shadows;
};

/* The surface point of one pixel. */
struct point {
    const struct pass *pass;
    union pbnds_direct_lobe lobe;
    struct pbnds_vec3 n, ng, wo, origin;
    struct pbnds_vec3 sum;
};

/* Shadow rays go one by one: packets of 16 of one pixel's rays, which point anywhere,
 * were no faster. */
static void add_light(struct point *point, struct pbnds_vec3 wi,
                      struct pbnds_vec3 light)
{
    assert(light.x >= 0.0f && light.y >= 0.0f && light.z >= 0.0f);
    assert(isfinite(light.x) && isfinite(light.y) && isfinite(light.z));
    if (pbnds_max3(light) == 0.0f) return;
    if (point->pass->shadows) {
        const struct pbnds_ray ray = {.origin = point->origin, .direction = wi};
        if (pbnds_dot(wi, point->ng) <= 0.0f) return;
        if (pbnds_accel_occluded(point->pass->job->accel, &ray, INFINITY)) return;
    }
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
    add_light(point, s.wi, pbnds_scale(pbnds_mul(f, s.radiance), cos_i / pdf));
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
    add_light(point, s.wi, pbnds_scale(light, cos_i / pdf));
}

static struct pbnds_vec3 plane3(float *const plane[3], size_t i)
{
    return pbnds_vec3_make(plane[0][i], plane[1][i], plane[2][i]);
}

static struct pbnds_vec3 incident(const struct pass *pass, int x, int y, size_t i)
{
    const struct pbnds_gbuffer *g = pass->job->gbuffer;
    struct point point;
    point.pass = pass;
    pass->model->load(&point.lobe, g, i);
    point.n = plane3(g->normal, i);
    point.ng = plane3(g->geometric_normal, i);
    point.wo = pbnds_gbuffer_wo(g, x, y);
    point.origin = pbnds_offset_origin(plane3(g->position, i), point.ng);
    point.sum = pbnds_splat(0.0f);
    for (int s = 0; s < pass->spp; ++s) {
        const struct pbnds_sampler sampler =
            pbnds_sampler_make(pass->job->seed, i, (uint32_t)s, (uint32_t)pass->spp);
        light_sample(&point, &sampler);
        brdf_sample(&point, &sampler);
    }
    return pbnds_scale(point.sum, 1.0f / (float)pass->spp);
}

static void shade_tile(void *context, const struct pbnds_tile *tile)
{
    const struct pass *pass = context;
    const struct pbnds_gbuffer *g = pass->job->gbuffer;
    for (int y = tile->y0; y < tile->y1 && !pbnds_stop_requested(); ++y)
        for (int x = tile->x0; x < tile->x1; ++x) {
            const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
            if (!(g->coverage[i] > 0.0f)) continue;
            struct pbnds_vec3 sum = plane3(g->emission, i);
            if (pass->job->envmap) sum = pbnds_add(sum, incident(pass, x, y, i));
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
    return pbnds_for_tiles(job->gbuffer->width, job->gbuffer->height, 16, job->report,
                           model->name, shade_tile, &pass, error);
}
