#include "neural/data/targets.h"

#include <stdlib.h>

#include "engine/shade/pathtrace.h"

struct visibility_job {
    const struct pbnds_gbuffer *g;
    const struct pbnds_accel *accel;
    const struct pbnds_env_light *lights;
    int count;
    uint32_t *bits;
};

static uint32_t visible_lights(const struct visibility_job *job, size_t i)
{
    const struct pbnds_gbuffer *g = job->g;
    const struct pbnds_vec3 p = {g->position[0][i], g->position[1][i],
                                 g->position[2][i]};
    const struct pbnds_vec3 ng = {g->geometric_normal[0][i], g->geometric_normal[1][i],
                                  g->geometric_normal[2][i]};
    const struct pbnds_vec3 origin = pbnds_offset_origin(p, ng);
    uint32_t bits = 0;
    for (int k = 0; k < job->count; ++k) {
        const struct pbnds_ray ray = {origin, job->lights[k].wi};
        if (pbnds_dot(ng, ray.direction) > 0.0f &&
            !pbnds_accel_occluded(job->accel, &ray, INFINITY)) {
            bits |= 1u << k;
        }
    }
    return bits;
}

static uint32_t *trace_visibility(const struct visibility_job *job)
{
    const size_t count = (size_t)job->g->width * (size_t)job->g->height;
    uint32_t *bits = calloc(count, sizeof *bits);
    if (!bits) return NULL;
    for (size_t i = 0; i < count; ++i) {
        if (isfinite(job->g->depth[i])) bits[i] = visible_lights(job, i);
    }
    return bits;
}

enum pbnds_status pbnds_targets_render(const struct pbnds_dataset_recipe *recipe,
                                       const struct pbnds_draw *draw,
                                       struct pbnds_targets *targets,
                                       struct pbnds_error *error)
{
    *targets = (struct pbnds_targets){0};
    struct pbnds_envmap *env = NULL;
    PBNDS_TRY(
        pbnds_envmap_create(&draw->light, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, error));
    enum pbnds_status status =
        pbnds_gbuffer_raycast(draw->scene, draw->accel, &draw->camera, recipe->width,
                              recipe->height, NULL, &targets->gbuffer, error);
    if (status == PBNDS_OK) {
        const struct pbnds_shade_job job = {
            .gbuffer = &targets->gbuffer,
            .envmap = env,
            .scene = draw->scene,
            .accel = draw->accel,
            .seed =
                pbnds_draw_rng(recipe, draw->split, draw->index, PBNDS_DRAW_TRACE).key,
            .shadows = 1,
        };
        const struct pbnds_pathtrace_options options = {.spp = recipe->spp};
        status = pbnds_pathtrace(&job, &options, &targets->radiance, &targets->direct,
                                 error);
    }
    if (status == PBNDS_OK) {
        struct pbnds_env_light lights[PBNDS_DATASET_LIGHTS];
        const int count = pbnds_envmap_cluster(env, PBNDS_DATASET_LIGHTS, lights);
        targets->visibility = trace_visibility(&(struct visibility_job){
            &targets->gbuffer, draw->accel, lights, count, NULL});
        if (!targets->visibility) {
            status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a sample");
        }
    }
    pbnds_envmap_free(env);
    if (status != PBNDS_OK) pbnds_targets_free(targets);
    return status;
}

void pbnds_targets_free(struct pbnds_targets *targets)
{
    pbnds_gbuffer_free(&targets->gbuffer);
    pbnds_image_free(&targets->radiance);
    pbnds_image_free(&targets->direct);
    free(targets->visibility);
    *targets = (struct pbnds_targets){0};
}
