/* The `transport` shading pass: cluster the light map, run the network a light, sum. */
#include <stdlib.h>

#include "engine/core/parallel.h"
#include "neural/shader_neural_impl.h"
#include "neural/transport.h"

struct pass {
    const struct pbnds_shader_neural *shader;
    const struct pbnds_shade_job *job;
    struct pbnds_image *radiance;
    struct pbnds_view view;
    struct pbnds_window window;
    struct pbnds_transport_pixel *pixels;
    struct pbnds_env_light *lights;
    int light_count;
    float *occlusion;    /* [window] view output */
    float *light_input;  /* [chunk, window, channels] */
    float *light_output; /* [chunk, window, 4] */
    struct pbnds_march march;
    int first, chunk; /* the lights at hand */
};

static size_t window_pixels(const struct pass *p)
{
    return (size_t)p->window.width * (size_t)p->window.height;
}

static void release(struct pass *p)
{
    pbnds_view_free(&p->view);
    free(p->pixels);
    free(p->lights);
    free(p->occlusion);
    free(p->light_input);
    free(p->light_output);
    free(p->march.thin);
    free(p->march.thick);
}

static enum pbnds_status prepare(struct pass *p, struct pbnds_error *error)
{
    const struct pbnds_shade_job *job = p->job;
    const size_t count = (size_t)job->gbuffer->width * (size_t)job->gbuffer->height;
    const int wanted = job->lights > 0 ? job->lights : p->shader->lights;
    p->window =
        pbnds_padded_window(p->shader->net, job->gbuffer->width, job->gbuffer->height);
    PBNDS_TRY(pbnds_view_create(job->gbuffer, &p->view, error));
    p->lights = calloc((size_t)wanted, sizeof *p->lights);
    if (p->lights && job->envmap) {
        p->light_count = pbnds_envmap_cluster(job->envmap, wanted, p->lights);
    }
    p->chunk = pbnds_lights_a_chunk(p->shader->model, p->window, job->max_memory,
                                    p->light_count);
    const size_t pixels = window_pixels(p), chunk = (size_t)p->chunk;
    p->pixels = malloc(count * sizeof *p->pixels);
    p->occlusion = malloc(pixels * sizeof *p->occlusion);
    p->light_input = malloc(chunk * pixels * (size_t)p->shader->model->light_channels *
                            sizeof *p->light_input);
    p->light_output =
        malloc(chunk * pixels * PBNDS_OUT_COUNT * sizeof *p->light_output);
    p->march.thin = malloc(count * sizeof *p->march.thin);
    p->march.thick = malloc(count * sizeof *p->march.thick);
    if (!p->lights || !p->pixels || !p->occlusion || !p->light_input ||
        !p->light_output || !p->march.thin || !p->march.thick) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "transport: no memory to shade a %d x %d image",
                          job->gbuffer->width, job->gbuffer->height);
    }
    for (size_t i = 0; i < count; ++i)
        p->pixels[i] = pbnds_transport_pixel(&p->view, i);
    return PBNDS_OK;
}

static enum pbnds_status run_view(struct pass *p, struct pbnds_error *error)
{
    float *input = malloc(window_pixels(p) * (size_t)p->shader->model->view_channels *
                          sizeof *input);
    if (!input) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "transport: no memory for features");
    }
    pbnds_features_view(&pbnds_features_transport, &p->view, p->window, input);
    const struct pbnds_pass pass = {
        .batch = 1, .lights = p->chunk, .h = p->window.height, .w = p->window.width};
    const enum pbnds_status status =
        pbnds_net_forward_view(p->shader->net, &pass, input, p->occlusion, error);
    free(input);
    return status;
}

static enum pbnds_status run_lights(struct pass *p, int count,
                                    struct pbnds_error *error)
{
    const size_t stride = window_pixels(p) * (size_t)p->shader->model->light_channels;
    for (int first = 0; first < count; first += 32) { /* the march packs 32 to a word */
        const int group = count - first < 32 ? count - first : 32;
        struct pbnds_vec3 wi[32];
        for (int k = 0; k < group; ++k)
            wi[k] = p->lights[p->first + first + k].wi;
        pbnds_view_march(&p->view, wi, group, &p->march);
        for (int k = 0; k < group; ++k) {
            const struct pbnds_light_source source = {.wi = wi[k], .bit = k};
            pbnds_features_light(&pbnds_features_transport, &p->view, &p->march,
                                 &source, p->window,
                                 p->light_input + (size_t)(first + k) * stride);
        }
    }
    const struct pbnds_pass pass = {
        .batch = 1, .lights = count, .h = p->window.height, .w = p->window.width};
    return pbnds_net_forward_light(p->shader->net, &pass, p->light_input,
                                   p->light_output, error);
}

struct sum_job {
    struct pass *pass;
    int count;
};

static void sum_row(void *context, size_t y, int thread)
{
    (void)thread;
    const struct sum_job *job = context;
    struct pass *p = job->pass;
    struct pbnds_vec3 wi[PBNDS_CHUNK_MAX];
    for (int k = 0; k < job->count; ++k) {
        wi[k] =
            pbnds_camera_from_world_vector(&p->view.camera, p->lights[p->first + k].wi);
    }
    for (int x = 0; x < p->view.width; ++x) {
        const struct pbnds_transport_pixel *pixel =
            &p->pixels[y * (size_t)p->view.width + (size_t)x];
        if (!pixel->covered) continue;
        const size_t i = y * (size_t)p->window.width + (size_t)x;
        struct pbnds_vec3 sum = pbnds_splat(0.0f);
        for (int k = 0; k < job->count; ++k) {
            const float *out =
                p->light_output + ((size_t)k * window_pixels(p) + i) * PBNDS_OUT_COUNT;
            const struct pbnds_vec3 s = {
                pbnds_transport_indirect(out[PBNDS_OUT_INDIRECT]),
                pbnds_transport_indirect(out[PBNDS_OUT_INDIRECT + 1]),
                pbnds_transport_indirect(out[PBNDS_OUT_INDIRECT + 2])};
            const struct pbnds_vec3 direct =
                pbnds_scale(pbnds_transport_direct(pixel, wi[k]),
                            pbnds_transport_visibility(out[PBNDS_OUT_VISIBILITY]));
            sum = pbnds_add(sum, pbnds_mul(p->lights[p->first + k].power,
                                           pbnds_add(direct, pbnds_mul(pixel->b, s))));
        }
        float *r = pbnds_image_at(p->radiance, x, (int)y);
        r[0] += sum.x;
        r[1] += sum.y;
        r[2] += sum.z;
    }
}

/* The narrow specular of the whole map, and what the surface emits. */
static void finish_row(void *context, size_t y, int thread)
{
    (void)thread;
    struct pass *p = context;
    const struct pbnds_gbuffer *g = p->job->gbuffer;
    for (int x = 0; x < p->view.width; ++x) {
        const size_t i = y * (size_t)p->view.width + (size_t)x;
        if (!p->pixels[i].covered) continue;
        struct pbnds_vec3 gloss = pbnds_splat(0.0f);
        if (p->light_count > 0) {
            const float o = p->occlusion[y * (size_t)p->window.width + (size_t)x];
            gloss = pbnds_scale(
                pbnds_transport_specular(&p->pixels[i], &p->view, p->job->envmap),
                pbnds_transport_occlusion(o));
        }
        float *r = pbnds_image_at(p->radiance, x, (int)y);
        r[0] += gloss.x + g->emission[0][i];
        r[1] += gloss.y + g->emission[1][i];
        r[2] += gloss.z + g->emission[2][i];
    }
}

enum pbnds_status pbnds_shade_transport(const struct pbnds_shader *self,
                                        const struct pbnds_shade_job *job,
                                        struct pbnds_image *radiance,
                                        struct pbnds_error *error)
{
    struct pass p = {.shader = (const struct pbnds_shader_neural *)self,
                     .job = job,
                     .radiance = radiance};
    enum pbnds_status status = prepare(&p, error);
    if (status == PBNDS_OK && p.light_count > 0) status = run_view(&p, error);
    for (p.first = 0; status == PBNDS_OK && p.first < p.light_count;
         p.first += p.chunk) {
        pbnds_progress(job->report, self->ops->name, p.first, p.light_count);
        const int left = p.light_count - p.first;
        struct sum_job sum = {&p, left < p.chunk ? left : p.chunk};
        status = run_lights(&p, sum.count, error);
        if (status == PBNDS_OK)
            pbnds_parallel_for((size_t)p.view.height, sum_row, &sum);
        if (pbnds_stop_requested()) status = pbnds_fail_interrupted(error);
    }
    if (status == PBNDS_OK) {
        pbnds_parallel_for((size_t)p.view.height, finish_row, &p);
        pbnds_progress(job->report, self->ops->name, p.light_count, p.light_count);
        if (pbnds_stop_requested()) status = pbnds_fail_interrupted(error);
    }
    release(&p);
    return status;
}
