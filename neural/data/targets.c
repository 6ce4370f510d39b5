#include "neural/data/targets.h"

#include <stdlib.h>
#include <string.h>

#include "engine/shade/pathtrace.h"
#include "neural/data/pack.h"

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

/* The draw's light as its file will hold it. */
static enum pbnds_status copy_light(const struct pbnds_image *light,
                                    struct pbnds_image *copy, struct pbnds_error *error)
{
    const size_t count =
        (size_t)light->width * (size_t)light->height * (size_t)light->channels;
    PBNDS_TRY(
        pbnds_image_init(copy, light->width, light->height, light->channels, error));
    memcpy(copy->data, light->data, count * sizeof *copy->data);
    if (pbnds_pack_fits_half(copy->data, count))
        pbnds_pack_round_half(copy->data, count);
    return PBNDS_OK;
}

/* What all targets of a sample share. */
struct rendering {
    const struct pbnds_dataset_recipe *recipe;
    const struct pbnds_draw *draw;
    struct pbnds_envmap *env;
    struct pbnds_targets *targets;
};

static enum pbnds_status render_radiance(const struct rendering *r,
                                         struct pbnds_error *error)
{
    const struct pbnds_draw *draw = r->draw;
    struct pbnds_targets *t = r->targets;
    const struct pbnds_shade_job job = {
        .gbuffer = &t->gbuffer,
        .envmap = r->env,
        .scene = draw->scene,
        .accel = draw->accel,
        .seed =
            pbnds_draw_rng(r->recipe, draw->split, draw->index, PBNDS_DRAW_TRACE).key,
        .shadows = 1,
        .variance = r->recipe->variance ? &t->variance : NULL,
    };
    const struct pbnds_pathtrace_options options = {.spp = r->recipe->spp};
    return pbnds_pathtrace(&job, &options, &t->radiance, &t->direct, error);
}

static enum pbnds_status find_visibility(const struct rendering *r,
                                         struct pbnds_error *error)
{
    struct pbnds_env_light lights[PBNDS_DATASET_LIGHTS];
    const int count = pbnds_envmap_cluster(r->env, PBNDS_DATASET_LIGHTS, lights);
    r->targets->visibility = trace_visibility(&(struct visibility_job){
        &r->targets->gbuffer, r->draw->accel, lights, count, NULL});
    if (r->targets->visibility) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a sample");
}

static enum pbnds_status render(struct rendering *r, struct pbnds_error *error)
{
    const struct pbnds_draw *draw = r->draw;
    struct pbnds_targets *t = r->targets;
    PBNDS_TRY(copy_light(&draw->light, &t->light, error));
    PBNDS_TRY(
        pbnds_envmap_create(&t->light, PBNDS_ENV_GLTF, 0.0f, 1.0f, &r->env, error));
    PBNDS_TRY(pbnds_gbuffer_raycast(draw->scene, draw->accel, &draw->camera,
                                    r->recipe->width, r->recipe->height, NULL,
                                    &t->gbuffer, error));
    PBNDS_TRY(render_radiance(r, error));
    return find_visibility(r, error);
}

enum pbnds_status pbnds_targets_render(const struct pbnds_dataset_recipe *recipe,
                                       const struct pbnds_draw *draw,
                                       struct pbnds_targets *targets,
                                       struct pbnds_error *error)
{
    *targets = (struct pbnds_targets){0};
    struct rendering r = {.recipe = recipe, .draw = draw, .targets = targets};
    const enum pbnds_status status = render(&r, error);
    pbnds_envmap_free(r.env);
    if (status != PBNDS_OK) pbnds_targets_free(targets);
    return status;
}

void pbnds_olat_free(struct pbnds_olat *olat)
{
    for (int k = 0; k < olat->count && olat->images; ++k)
        pbnds_image_free(&olat->images[k]);
    free(olat->images);
    free(olat->visibility);
    *olat = (struct pbnds_olat){0};
}

void pbnds_targets_free(struct pbnds_targets *targets)
{
    pbnds_image_free(&targets->light);
    pbnds_gbuffer_free(&targets->gbuffer);
    pbnds_image_free(&targets->radiance);
    pbnds_image_free(&targets->direct);
    pbnds_image_free(&targets->variance);
    free(targets->visibility);
    pbnds_olat_free(&targets->olat);
    *targets = (struct pbnds_targets){0};
}
