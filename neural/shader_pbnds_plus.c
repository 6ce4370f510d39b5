/* The `pbnds+` shading pass: a U-Net a light, mean over the lights.
 */
#include <stdlib.h>

#include "neural/pbnds_plus.h"
#include "neural/shader_neural_impl.h"

struct pass {
    const struct pbnds_shader_neural *shader;
    const struct pbnds_shade_job *job;
    struct pbnds_view view;
    struct pbnds_window window;
    struct pbnds_light_source *lights;
    int light_count, chunk;
    float *view_input, *light_input, *light_output;
    float *sum; /* [window, 3] of radiance */
};

static void release(struct pass *p)
{
    pbnds_view_free(&p->view);
    free(p->lights);
    free(p->view_input);
    free(p->light_input);
    free(p->light_output);
    free(p->sum);
}

static size_t window_pixels(const struct pass *p)
{
    return (size_t)p->window.width * (size_t)p->window.height;
}

static enum pbnds_status prepare(struct pass *p, struct pbnds_error *error)
{
    const struct pbnds_shade_job *job = p->job;
    const struct pbnds_model *model = p->shader->model;
    p->light_count = job->lights > 0 ? job->lights : p->shader->lights;
    p->window =
        pbnds_padded_window(p->shader->net, job->gbuffer->width, job->gbuffer->height);
    p->chunk = pbnds_lights_a_chunk(model, p->window, job->max_memory, p->light_count);
    PBNDS_TRY(pbnds_view_create(job->gbuffer, &p->view, error));
    const size_t pixels = window_pixels(p), chunk = (size_t)p->chunk;
    p->lights = calloc((size_t)p->light_count, sizeof *p->lights);
    p->view_input = malloc(pixels * (size_t)model->view_channels * sizeof(float));
    p->light_input =
        malloc(chunk * pixels * (size_t)model->light_channels * sizeof(float));
    p->light_output = malloc(chunk * pixels * 3 * sizeof(float));
    p->sum = calloc(pixels * 3, sizeof(float));
    if (!p->lights || !p->view_input || !p->light_input || !p->light_output ||
        !p->sum) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "pbnds+: no memory to shade a %d x %d image",
                          job->gbuffer->width, job->gbuffer->height);
    }
    pbnds_plus_draw_lights(job->envmap, job->seed, p->light_count, p->lights);
    pbnds_features_view(&pbnds_features_pbnds_plus, &p->view, p->window, p->view_input);
    return PBNDS_OK;
}

static enum pbnds_status run_chunk(struct pass *p, int first, int count,
                                   struct pbnds_error *error)
{
    const size_t pixels = window_pixels(p);
    const size_t stride = pixels * (size_t)p->shader->model->light_channels;
    for (int k = 0; k < count; ++k) {
        pbnds_features_light(&pbnds_features_pbnds_plus, &p->view, NULL,
                             &p->lights[first + k], p->window,
                             p->light_input + (size_t)k * stride);
    }
    const struct pbnds_pass pass = {
        .batch = 1, .lights = count, .h = p->window.height, .w = p->window.width};
    PBNDS_TRY(pbnds_net_forward_light(p->shader->net, &pass, p->light_input,
                                      p->light_output, error));
    for (int k = 0; k < count; ++k) {
        const float *out = p->light_output + (size_t)k * pixels * 3;
        for (size_t i = 0; i < 3 * pixels; ++i)
            p->sum[i] += out[i];
    }
    return PBNDS_OK;
}

static void write_radiance(const struct pass *p, struct pbnds_image *radiance)
{
    float *const *emission = p->job->gbuffer->emission;
    const float scale = 1.0f / (float)p->light_count;
    for (int y = 0; y < p->view.height; ++y) {
        for (int x = 0; x < p->view.width; ++x) {
            const size_t i = (size_t)y * (size_t)p->view.width + (size_t)x;
            if (!(p->view.plane[PBNDS_PLANE_MASK][i] > 0.0f)) continue;
            const size_t w = (size_t)y * (size_t)p->window.width + (size_t)x;
            float *r = pbnds_image_at(radiance, x, y);
            for (size_t c = 0; c < 3; ++c) {
                r[c] = fmaxf(p->sum[3 * w + c] * scale, 0.0f) + emission[c][i];
            }
        }
    }
}

enum pbnds_status pbnds_shade_pbnds_plus(const struct pbnds_shader *self,
                                         const struct pbnds_shade_job *job,
                                         struct pbnds_image *radiance,
                                         struct pbnds_error *error)
{
    struct pass p = {.shader = (const struct pbnds_shader_neural *)self, .job = job};
    enum pbnds_status status = prepare(&p, error);
    if (status == PBNDS_OK) {
        const struct pbnds_pass pass = {
            .batch = 1, .lights = p.chunk, .h = p.window.height, .w = p.window.width};
        status =
            pbnds_net_forward_view(p.shader->net, &pass, p.view_input, NULL, error);
    }
    for (int first = 0; status == PBNDS_OK && first < p.light_count; first += p.chunk) {
        pbnds_progress(job->report, self->ops->name, first, p.light_count);
        const int left = p.light_count - first;
        status = run_chunk(&p, first, left < p.chunk ? left : p.chunk, error);
        if (pbnds_stop_requested()) status = pbnds_fail_interrupted(error);
    }
    if (status == PBNDS_OK) {
        write_radiance(&p, radiance);
        pbnds_progress(job->report, self->ops->name, p.light_count, p.light_count);
    }
    release(&p);
    return status;
}
