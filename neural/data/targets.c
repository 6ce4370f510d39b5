#include "neural/data/targets.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "engine/shade/openness.h"
#include "engine/shade/pathtrace_olat.h"
#include "engine/shade/visibility.h"
#include "neural/data/atrous.h"
#include "neural/data/olat.h"
#include "neural/data/pack.h"

enum { OPENNESS_RAYS = 64 };

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

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static uint64_t seed_of(const struct rendering *r, enum pbnds_draw_stream stream)
{
    return pbnds_draw_rng(r->recipe, r->draw->split, r->draw->index, stream).key;
}

static struct pbnds_shade_job job_of(const struct rendering *r,
                                     enum pbnds_draw_stream stream)
{
    return (struct pbnds_shade_job){.gbuffer = &r->targets->gbuffer,
                                    .envmap = r->env,
                                    .scene = r->draw->scene,
                                    .accel = r->draw->accel,
                                    .seed = seed_of(r, stream),
                                    .shadows = 1};
}

static enum pbnds_status cast(const struct rendering *r, struct pbnds_error *error)
{
    const struct pbnds_draw *draw = r->draw;
    struct pbnds_gbuffer *g = &r->targets->gbuffer;
    const struct pbnds_raycast_options options = {
        .optional = r->recipe->ao ? PBNDS_OPTIONAL_AO : 0u};
    PBNDS_TRY(pbnds_gbuffer_raycast(draw->scene, draw->accel, &draw->camera,
                                    r->recipe->width, r->recipe->height, &options, g,
                                    error));
    if (!r->recipe->ao) return PBNDS_OK;
    return pbnds_openness(g, draw->accel, OPENNESS_RAYS, seed_of(r, PBNDS_DRAW_TRACE),
                          g->ao, error);
}

static enum pbnds_status render_radiance(const struct rendering *r,
                                         struct pbnds_error *error)
{
    struct pbnds_targets *t = r->targets;
    struct pbnds_shade_job job = job_of(r, PBNDS_DRAW_TRACE);
    const struct pbnds_pathtrace_options options = {.spp = r->recipe->spp};
    if (r->recipe->variance || t->denoised) job.variance = &t->variance;
    const double start = seconds();
    PBNDS_TRY(pbnds_pathtrace(&job, &options, &t->radiance, &t->direct, error));
    t->path_seconds += seconds() - start;
    return PBNDS_OK;
}

static void add_emission(struct pbnds_image *image, const struct pbnds_gbuffer *g,
                         float times)
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c)
            image->data[3 * i + c] += times * g->emission[c][i];
    }
}

/* Radiance and its direct part by the same weights, so that the rest is what it was. */
static enum pbnds_status denoise(const struct rendering *r, struct pbnds_error *error)
{
    struct pbnds_targets *t = r->targets;
    struct pbnds_image *const images[2] = {&t->radiance, &t->direct};
    if (!t->denoised || !t->variance.data) return PBNDS_OK;
    for (int i = 0; i < 2; ++i)
        add_emission(images[i], &t->gbuffer, -1.0f);
    PBNDS_TRY(pbnds_atrous(&t->gbuffer, &t->variance, images, 2, error));
    for (int i = 0; i < 2; ++i)
        add_emission(images[i], &t->gbuffer, 1.0f);
    if (!r->recipe->variance) pbnds_image_free(&t->variance);
    return PBNDS_OK;
}

static enum pbnds_status look(const struct rendering *r, const struct pbnds_vec3 *wi,
                              int count, uint32_t **bits, struct pbnds_error *error)
{
    const struct pbnds_gbuffer *g = &r->targets->gbuffer;
    *bits = malloc((size_t)g->width * (size_t)g->height * sizeof **bits);
    if (!*bits) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a sample");
    return pbnds_visibility(g, r->draw->accel, wi, count, *bits, error);
}

static enum pbnds_status find_visibility(const struct rendering *r,
                                         struct pbnds_error *error)
{
    struct pbnds_env_light lights[PBNDS_DATASET_LIGHTS];
    struct pbnds_vec3 wi[PBNDS_DATASET_LIGHTS];
    const int count = pbnds_envmap_cluster(r->env, PBNDS_DATASET_LIGHTS, lights);
    for (int k = 0; k < count; ++k)
        wi[k] = lights[k].wi;
    return look(r, wi, count, &r->targets->visibility, error);
}

/* Each light by itself, where the tracer knows how noisy it is. */
static enum pbnds_status denoise_olat(const struct rendering *r,
                                      const struct pbnds_image *variance,
                                      struct pbnds_error *error)
{
    struct pbnds_olat *olat = &r->targets->olat;
    for (int k = 0; k < olat->count; ++k) {
        struct pbnds_image *const image = &olat->images[k];
        if (!variance || !variance[k].data) continue;
        PBNDS_TRY(pbnds_atrous(&r->targets->gbuffer, &variance[k], &image, 1, error));
    }
    return PBNDS_OK;
}

static enum pbnds_status trace_olat(const struct rendering *r,
                                    struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe *recipe = r->recipe;
    struct pbnds_olat *olat = &r->targets->olat;
    struct pbnds_image variance[PBNDS_DATASET_OLAT] = {{.data = NULL}};
    struct pbnds_image *wanted = r->targets->denoised ? variance : NULL;
    const struct pbnds_shade_job job = job_of(r, PBNDS_DRAW_OLAT);
    const struct pbnds_pathtrace_options options = {
        .spp = recipe->olat_spp ? recipe->olat_spp : recipe->spp};
    const double start = seconds();
    enum pbnds_status status = pbnds_pathtrace_olat(
        &job, &options, olat->wi, olat->count, olat->images, wanted, error);
    r->targets->path_seconds += seconds() - start;
    if (status == PBNDS_OK) status = denoise_olat(r, wanted, error);
    for (int k = 0; k < olat->count && wanted; ++k)
        pbnds_image_free(&variance[k]);
    return status;
}

static enum pbnds_status render_olat(const struct rendering *r,
                                     struct pbnds_error *error)
{
    struct pbnds_olat *olat = &r->targets->olat;
    const int count = r->recipe->olat;
    if (count == 0) return PBNDS_OK;
    olat->images = calloc((size_t)count, sizeof *olat->images);
    if (!olat->images)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a sample");
    olat->count = count;
    struct pbnds_rng rng =
        pbnds_draw_rng(r->recipe, r->draw->split, r->draw->index, PBNDS_DRAW_OLAT);
    (void)pbnds_olat_choose(r->env, count, &rng, olat->wi);
    PBNDS_TRY(trace_olat(r, error));
    return look(r, olat->wi, count, &olat->visibility, error);
}

static enum pbnds_status render(struct rendering *r, struct pbnds_error *error)
{
    struct pbnds_targets *t = r->targets;
    PBNDS_TRY(copy_light(&r->draw->light, &t->light, error));
    PBNDS_TRY(
        pbnds_envmap_create(&t->light, PBNDS_ENV_GLTF, 0.0f, 1.0f, &r->env, error));
    t->denoised = r->recipe->denoise && r->draw->split != PBNDS_SPLIT_TEST;
    PBNDS_TRY(cast(r, error));
    PBNDS_TRY(render_radiance(r, error));
    PBNDS_TRY(denoise(r, error));
    PBNDS_TRY(find_visibility(r, error));
    return render_olat(r, error);
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
