/* One path; see path.h. Rays go one by one: packets of one pixel's rays were 10 to 20 %
 * slower, because past the first hit they share nothing. */
#include "engine/shade/path.h"

#include <assert.h>
#include <math.h>

#include "engine/shade/light_punctual.h"

enum { ROULETTE_BOUNCE = 3 };

/* The decisions at one vertex, for the sampler. */
enum { SET_LIGHT, SET_BRDF, SET_ROULETTE, SET_COUNT };

struct path {
    const struct pbnds_path_world *world;
    const struct pbnds_sampler *sampler;
    struct pbnds_path_vertex vertex;
    struct pbnds_vec3 throughput;
    int bounce; /* surfaces behind the vertex; 0 at the first */
    struct pbnds_path_light light;
};

static void add_light(struct path *path, struct pbnds_vec3 light, bool direct)
{
    assert(light.x >= 0.0f && light.y >= 0.0f && light.z >= 0.0f);
    assert(isfinite(light.x) && isfinite(light.y) && isfinite(light.z));
    path->light.total = pbnds_add(path->light.total, light);
    if (direct && path->bounce == 0)
        path->light.direct = pbnds_add(path->light.direct, light);
}

static uint32_t set_of(const struct path *path, int decision)
{
    return (uint32_t)(path->bounce * SET_COUNT + decision);
}

/* The query of a ray that belongs to a set of the sampler. */
static struct pbnds_query query(const struct path *path, uint32_t set, float max_t)
{
    struct pbnds_query q = {.max_t = max_t, .stochastic = path->world->blends};
    if (q.stochastic) q.seed = pbnds_sampler_hash(path->sampler, set);
    return q;
}

static struct pbnds_vec3 origin(const struct pbnds_path_vertex *vertex)
{
    return pbnds_offset_origin(vertex->position, vertex->ng);
}

float pbnds_path_cosine(const struct pbnds_path_vertex *vertex, struct pbnds_vec3 wi)
{
    const float cos_i = pbnds_dot(vertex->bsdf.frame.n, wi);
    return cos_i > 0.0f && pbnds_dot(vertex->ng, wi) > 0.0f ? cos_i : 0.0f;
}

/* Nothing in the way from the vertex along wi. */
static bool sees(const struct path *path, struct pbnds_vec3 from, struct pbnds_vec3 wi,
                 float max_t)
{
    const struct pbnds_ray ray = {.origin = from, .direction = wi};
    const struct pbnds_query how = query(path, set_of(path, SET_LIGHT), max_t);
    return !pbnds_accel_occluded_query(path->world->accel, &ray, &how);
}

/* Light from a direction drawn from the map. */
static void gather_map(struct path *path, float probability, const float u[2])
{
    const struct pbnds_path_vertex *vertex = &path->vertex;
    const struct pbnds_env_sample s =
        pbnds_envmap_sample(path->world->envmap, u[0], u[1]);
    const float cos_i = pbnds_path_cosine(vertex, s.wi);
    if (!(s.pdf > 0.0f) || cos_i == 0.0f) return;
    const struct pbnds_vec3 f = pbnds_bsdf_eval(&vertex->bsdf, vertex->wo, s.wi);
    const float pdf =
        probability * s.pdf + pbnds_bsdf_pdf(&vertex->bsdf, vertex->wo, s.wi);
    const struct pbnds_vec3 light =
        pbnds_scale(pbnds_mul(pbnds_mul(path->throughput, f), s.radiance), cos_i / pdf);
    if (pbnds_max3(light) == 0.0f) return;
    if (sees(path, origin(vertex), s.wi, INFINITY)) add_light(path, light, true);
}

/* A light without extent: no other way leads to it. */
static void gather_punctual(struct path *path, const struct pbnds_light_choice *choice)
{
    const struct pbnds_path_vertex *vertex = &path->vertex;
    const struct pbnds_light *source = &path->world->scene->lights[choice->index];
    struct pbnds_punctual p;
    if (!pbnds_light_punctual(source, vertex->position, &p)) return;
    const float cos_i = pbnds_path_cosine(vertex, p.wi);
    if (cos_i == 0.0f) return;
    const struct pbnds_vec3 f = pbnds_bsdf_eval(&vertex->bsdf, vertex->wo, p.wi);
    const struct pbnds_vec3 light =
        pbnds_scale(pbnds_mul(pbnds_mul(path->throughput, f), p.irradiance),
                    cos_i / choice->probability);
    if (pbnds_max3(light) == 0.0f) return;
    if (sees(path, origin(vertex), p.wi, p.distance)) add_light(path, light, true);
}

/* A point on a triangle that emits. A path that may visit no further surface does not
 * see it either way. */
static void gather_emissive(struct path *path, const struct pbnds_light_choice *choice,
                            const float u[2])
{
    const struct pbnds_path_vertex *vertex = &path->vertex;
    const struct pbnds_emissive *emissive = &path->world->lights->emissive;
    const struct pbnds_vec3 from = origin(vertex);
    struct pbnds_emissive_sample s;
    if (path->bounce == path->world->max_bounces) return;
    if (!pbnds_emissive_sample(emissive, choice->index, from, u[0], u[1], &s)) return;
    const float cos_i = pbnds_path_cosine(vertex, s.wi);
    if (cos_i == 0.0f) return;
    const struct pbnds_vec3 f = pbnds_bsdf_eval(&vertex->bsdf, vertex->wo, s.wi);
    const float pdf =
        choice->probability * s.pdf + pbnds_bsdf_pdf(&vertex->bsdf, vertex->wo, s.wi);
    const struct pbnds_vec3 share =
        pbnds_scale(pbnds_mul(path->throughput, f), cos_i / pdf);
    if (pbnds_max3(share) == 0.0f) return;
    const struct pbnds_vec3 light =
        pbnds_mul(share, pbnds_emissive_radiance(emissive, &s));
    if (pbnds_max3(light) == 0.0f) return;
    const struct pbnds_vec3 way = pbnds_sub(s.reach, from);
    const float distance = pbnds_length(way);
    if (!(distance > 0.0f)) return;
    if (sees(path, from, pbnds_scale(way, 1.0f / distance), distance))
        add_light(path, light, false);
}

/* Light from one light of the table. */
static void gather_light(struct path *path)
{
    const struct pbnds_light_table *lights = path->world->lights;
    const bool map_only = lights->map_probability == 1.0f;
    uint32_t bits[3];
    pbnds_sampler_get_bits(path->sampler, set_of(path, SET_LIGHT), map_only ? 2 : 3,
                           bits);
    const float u[2] = {pbnds_sampler_unit(bits[0]), pbnds_sampler_unit(bits[1])};
    if (map_only) {
        gather_map(path, 1.0f, u);
        return;
    }
    const struct pbnds_light_choice choice = pbnds_light_table_choose(lights, bits[2]);
    switch (choice.kind) {
    case PBNDS_LIGHT_CLASS_MAP:
        gather_map(path, choice.probability, u);
        return;
    case PBNDS_LIGHT_CLASS_PUNCTUAL:
        gather_punctual(path, &choice);
        return;
    case PBNDS_LIGHT_CLASS_EMISSIVE:
        gather_emissive(path, &choice, u);
        return;
    }
}

/* Paths that carry little end at random, the others make up for them. */
static bool survives_roulette(struct path *path)
{
    if (path->bounce < ROULETTE_BOUNCE) return true;
    const float keep = fminf(pbnds_max3(path->throughput), 0.95f);
    float u;
    pbnds_sampler_get(path->sampler, set_of(path, SET_ROULETTE), 1, &u);
    if (u >= keep) return false;
    path->throughput = pbnds_scale(path->throughput, 1.0f / keep);
    return true;
}

/* Draws the next direction from the BRDF. false: the path ends here. */
static bool scatter(struct path *path, struct pbnds_vec3 *wi, float *pdf)
{
    float u[3];
    struct pbnds_brdf_sample s;
    pbnds_sampler_get(path->sampler, set_of(path, SET_BRDF), 3, u);
    if (!pbnds_bsdf_sample(&path->vertex.bsdf, path->vertex.wo, u[0], u[1], u[2], &s))
        return false;
    const float cos_i = pbnds_path_cosine(&path->vertex, s.wi);
    path->throughput = pbnds_scale(pbnds_mul(path->throughput, s.f), cos_i / s.pdf);
    *wi = s.wi;
    *pdf = s.pdf;
    return pbnds_max3(path->throughput) > 0.0f && survives_roulette(path);
}

/* The ray left the scene: the map's light, weighed against gather_map(). */
static void escape(struct path *path, struct pbnds_vec3 wi, float pdf)
{
    const struct pbnds_envmap *envmap = path->world->envmap;
    if (!envmap) return;
    const float other =
        path->world->lights->map_probability * pbnds_envmap_pdf(envmap, wi);
    const struct pbnds_vec3 radiance = pbnds_envmap_eval(envmap, wi);
    add_light(path,
              pbnds_scale(pbnds_mul(path->throughput, radiance), pdf / (pdf + other)),
              true);
}

/* Goes to the surface that was hit. @return its emission */
static struct pbnds_vec3 arrive(struct path *path, const struct pbnds_hit *hit,
                                struct pbnds_vec3 wi, float footprint)
{
    struct pbnds_path_vertex *vertex = &path->vertex;
    struct pbnds_surface surface;
    vertex->wo = pbnds_scale(wi, -1.0f);
    pbnds_scene_surface(path->world->scene, hit, vertex->wo, footprint, &surface);
    vertex->position = surface.position;
    vertex->ng = surface.ng;
    vertex->bsdf = pbnds_bsdf_from_surface(&surface);
    return surface.emission;
}

/* A direction of the BRDF hit a surface: its emission, weighed against
 * gather_emissive(). */
static void add_emission(struct path *path, const struct pbnds_hit *hit,
                         struct pbnds_vec3 emission, float pdf)
{
    if (pbnds_max3(emission) == 0.0f) return;
    const float cos_l = pbnds_dot(path->vertex.ng, path->vertex.wo);
    const float other = pbnds_light_table_emissive_pdf(path->world->lights, hit, cos_l);
    add_light(path,
              pbnds_scale(pbnds_mul(path->throughput, emission), pdf / (pdf + other)),
              false);
}

/* The way to the next surface, drawn from the BRDF. */
struct step {
    struct pbnds_vec3 wi;
    float pdf;
    struct pbnds_hit hit;
};

/* false: the path ends here. */
static bool advance(struct path *path, struct step *step)
{
    if (!scatter(path, &step->wi, &step->pdf)) return false;
    const struct pbnds_ray ray = {.origin = origin(&path->vertex),
                                  .direction = step->wi};
    const struct pbnds_query how = query(path, set_of(path, SET_BRDF), INFINITY);
    pbnds_accel_intersect_query(path->world->accel, &ray, &how, &step->hit);
    return true;
}

static void run(struct path *path)
{
    const struct pbnds_path_world *world = path->world;
    for (;;) {
        if (world->lights->count > 0) gather_light(path);
        struct step step;
        if (!advance(path, &step)) return;
        if (step.hit.mesh == UINT32_MAX) {
            escape(path, step.wi, step.pdf);
            return;
        }
        if (path->bounce == world->max_bounces) return;
        const struct pbnds_vec3 emission = arrive(path, &step.hit, step.wi, 0.0f);
        ++path->bounce;
        add_emission(path, &step.hit, emission, step.pdf);
    }
}

static void walk(struct path *path,
                 void (*visit)(void *context, const struct pbnds_path_visit *visit),
                 void *context)
{
    for (;;) {
        const struct pbnds_path_visit at = {&path->vertex, path->throughput,
                                            path->bounce};
        visit(context, &at);
        struct step step;
        if (path->bounce == path->world->max_bounces) return;
        if (!advance(path, &step) || step.hit.mesh == UINT32_MAX) return;
        (void)arrive(path, &step.hit, step.wi, 0.0f);
        ++path->bounce;
    }
}

void pbnds_path_trace(const struct pbnds_path_world *world,
                      const struct pbnds_path_vertex *first,
                      const struct pbnds_sampler *sampler,
                      struct pbnds_path_light *light)
{
    struct path path = {.world = world,
                        .sampler = sampler,
                        .vertex = *first,
                        .throughput = {1.0f, 1.0f, 1.0f}};
    run(&path);
    *light = path.light;
}

void pbnds_path_walk(const struct pbnds_path_world *world,
                     const struct pbnds_path_vertex *first,
                     const struct pbnds_sampler *sampler,
                     void (*visit)(void *context, const struct pbnds_path_visit *visit),
                     void *context)
{
    struct path path = {.world = world,
                        .sampler = sampler,
                        .vertex = *first,
                        .throughput = {1.0f, 1.0f, 1.0f}};
    walk(&path, visit, context);
}

/* From the eye to the first surface. @return false: there is none */
static bool enter(struct path *path, const struct pbnds_ray *ray, const float cone[2],
                  struct pbnds_vec3 *emission)
{
    struct pbnds_query how = query(path, PBNDS_PATH_SET_PIXEL, INFINITY);
    how.cull = true;
    struct pbnds_hit hit;
    pbnds_accel_intersect_query(path->world->accel, ray, &how, &hit);
    if (hit.mesh == UINT32_MAX) return false;
    *emission = arrive(path, &hit, ray->direction, cone[0] * hit.t + cone[1]);
    return true;
}

bool pbnds_path_walk_camera(
    const struct pbnds_path_world *world, const struct pbnds_ray *ray,
    const float cone[2], const struct pbnds_sampler *sampler,
    void (*visit)(void *context, const struct pbnds_path_visit *visit), void *context)
{
    struct path path = {
        .world = world, .sampler = sampler, .throughput = {1.0f, 1.0f, 1.0f}};
    struct pbnds_vec3 emission;
    if (!enter(&path, ray, cone, &emission)) return false;
    walk(&path, visit, context);
    return true;
}

bool pbnds_path_trace_camera(const struct pbnds_path_world *world,
                             const struct pbnds_ray *ray, const float cone[2],
                             const struct pbnds_sampler *sampler,
                             struct pbnds_path_light *light)
{
    struct path path = {
        .world = world, .sampler = sampler, .throughput = {1.0f, 1.0f, 1.0f}};
    struct pbnds_vec3 emission;
    *light = path.light;
    if (!enter(&path, ray, cone, &emission)) return false;
    add_light(&path, emission, true);
    run(&path);
    *light = path.light;
    return true;
}
