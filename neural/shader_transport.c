/* The `transport` shading pass: cluster the light map, run the network a light, sum. */
#include <stdlib.h>

#include "engine/core/parallel.h"
#include "neural/transport_pass.h"

struct sum {
    const struct pbnds_shade_job *job;
    struct pbnds_image *radiance;
    const struct pbnds_env_light *lights;
    int light_count;
    const struct pbnds_transport_tile *tile; /* at hand */
};

/* Light after light onto the picture, so that chunks do not show in its bits. */
static void sum_row(void *context, size_t row, int thread)
{
    (void)thread;
    const struct sum *sum = context;
    const struct pbnds_transport_tile *t = sum->tile;
    const size_t stride = (size_t)t->at.window.width * (size_t)t->at.window.height;
    struct pbnds_vec3 wi[PBNDS_CHUNK_MAX];
    for (int k = 0; k < t->count; ++k) {
        wi[k] = pbnds_camera_from_world_vector(&t->view->camera,
                                               sum->lights[t->first + k].wi);
    }
    const int y = t->at.own.y + (int)row;
    for (int x = t->at.own.x; x < t->at.own.x + t->at.own.width; ++x) {
        const struct pbnds_transport_pixel *pixel =
            &t->pixels[pbnds_transport_own(t, x, y)];
        if (!pixel->covered) continue;
        const size_t i = pbnds_transport_in_window(t, x, y);
        float *r = pbnds_image_at(sum->radiance, x, y);
        struct pbnds_vec3 total = {r[0], r[1], r[2]};
        for (int k = 0; k < t->count; ++k) {
            const float *out = t->lights + ((size_t)k * stride + i) * PBNDS_OUT_COUNT;
            total = pbnds_add(total,
                              pbnds_mul(sum->lights[t->first + k].power,
                                        pbnds_transport_outgoing(pixel, wi[k], out)));
        }
        r[0] = total.x;
        r[1] = total.y;
        r[2] = total.z;
    }
}

static enum pbnds_status sum_lights(void *context,
                                    const struct pbnds_transport_tile *tile,
                                    struct pbnds_error *error)
{
    (void)error;
    struct sum *sum = context;
    sum->tile = tile;
    pbnds_parallel_for((size_t)tile->at.own.height, sum_row, sum);
    return PBNDS_OK;
}

/* The narrow specular of the whole map, and what the surface emits. */
static void finish_row(void *context, size_t row, int thread)
{
    (void)thread;
    const struct sum *sum = context;
    const struct pbnds_transport_tile *t = sum->tile;
    const struct pbnds_gbuffer *g = sum->job->gbuffer;
    const int y = t->at.own.y + (int)row;
    for (int x = t->at.own.x; x < t->at.own.x + t->at.own.width; ++x) {
        const struct pbnds_transport_pixel *pixel =
            &t->pixels[pbnds_transport_own(t, x, y)];
        if (!pixel->covered) continue;
        struct pbnds_vec3 gloss = pbnds_splat(0.0f);
        if (t->occlusion) {
            gloss =
                pbnds_scale(pbnds_transport_specular(pixel, t->view, sum->job->envmap),
                            pbnds_transport_occlusion(
                                t->occlusion[pbnds_transport_in_window(t, x, y)]));
        }
        const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
        float *r = pbnds_image_at(sum->radiance, x, y);
        r[0] += gloss.x + g->emission[0][i];
        r[1] += gloss.y + g->emission[1][i];
        r[2] += gloss.z + g->emission[2][i];
    }
}

static enum pbnds_status finish(void *context, const struct pbnds_transport_tile *tile,
                                struct pbnds_error *error)
{
    (void)error;
    struct sum *sum = context;
    sum->tile = tile;
    pbnds_parallel_for((size_t)tile->at.own.height, finish_row, sum);
    return PBNDS_OK;
}

enum pbnds_status pbnds_shade_transport(const struct pbnds_shader *self,
                                        const struct pbnds_shade_job *job,
                                        struct pbnds_image *radiance,
                                        struct pbnds_error *error)
{
    const struct pbnds_shader_neural *shader = (const struct pbnds_shader_neural *)self;
    const int wanted = job->lights > 0 ? job->lights : shader->lights;
    struct pbnds_env_light *lights = calloc((size_t)wanted, sizeof *lights);
    struct pbnds_vec3 *wi = calloc((size_t)wanted, sizeof *wi);
    enum pbnds_status status;
    if (!lights || !wi) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY,
                            "transport: no memory for %d lights", wanted);
    } else {
        struct sum sum = {.job = job, .radiance = radiance, .lights = lights};
        if (job->envmap)
            sum.light_count = pbnds_envmap_cluster(job->envmap, wanted, lights);
        for (int i = 0; i < sum.light_count; ++i)
            wi[i] = lights[i].wi;
        const struct pbnds_transport_pass pass = {.shader = shader,
                                                  .job = job,
                                                  .wi = wi,
                                                  .count = sum.light_count,
                                                  .context = &sum,
                                                  .lights = sum_lights,
                                                  .end = finish};
        status = pbnds_transport_run(&pass, error);
    }
    free(lights);
    free(wi);
    return status;
}
