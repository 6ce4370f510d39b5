/* The `pbnds+` shading pass: a U-Net a light, mean over the lights; tile by tile. */
#include <stdlib.h>
#include <string.h>

#include "neural/pbnds_plus.h"
#include "neural/shader_neural_impl.h"
#include "neural/tiles.h"

struct run {
    const struct pbnds_shader_neural *shader;
    const struct pbnds_shade_job *job;
    struct pbnds_image *radiance;
    struct pbnds_tiling tiling;
    float median_depth;
    struct pbnds_light_source *lights;
    int light_count;
    /* of one window, used again for every tile */
    float *view_input, *light_input, *light_output;
    float *sum; /* [window, 3] of radiance */
    /* of the tile at hand */
    struct pbnds_view view;
    struct pbnds_tile tile;
};

static void release(struct run *r)
{
    free(r->lights);
    free(r->view_input);
    free(r->light_input);
    free(r->light_output);
    free(r->sum);
}

static size_t window_pixels(const struct run *r)
{
    return (size_t)r->tiling.window_width * (size_t)r->tiling.window_height;
}

static size_t tile_bytes(const void *context, int width, int height, int lights)
{
    const struct pbnds_shader_neural *s = context;
    const struct pbnds_pass pass = {
        .batch = 1, .lights = lights, .h = height, .w = width};
    const size_t net = pbnds_net_bytes(s->net, &pass);
    const size_t floats = (size_t)s->model->view_channels + 3 +
                          (size_t)lights * ((size_t)s->model->light_channels + 3);
    const size_t planes = (pbnds_view_bytes_a_pixel() + floats * sizeof(float)) *
                          (size_t)width * (size_t)height;
    return net > SIZE_MAX - planes ? SIZE_MAX : net + planes;
}

static enum pbnds_status prepare(struct run *r, struct pbnds_error *error)
{
    const struct pbnds_shade_job *job = r->job;
    const struct pbnds_gbuffer *g = job->gbuffer;
    const struct pbnds_model *model = r->shader->model;
    r->light_count = job->lights > 0 ? job->lights : r->shader->lights;
    r->tiling = pbnds_tiling_plan(r->shader->net, g->width, g->height, r->light_count,
                                  job->max_memory, tile_bytes, r->shader);
    r->median_depth = pbnds_view_median_depth(g);
    const size_t pixels = window_pixels(r), chunk = (size_t)r->tiling.chunk;
    r->lights = calloc((size_t)r->light_count, sizeof *r->lights);
    r->view_input = malloc(pixels * (size_t)model->view_channels * sizeof(float));
    r->light_input =
        malloc(chunk * pixels * (size_t)model->light_channels * sizeof(float));
    r->light_output = malloc(chunk * pixels * 3 * sizeof(float));
    r->sum = malloc(pixels * 3 * sizeof(float));
    if (!r->lights || !r->view_input || !r->light_input || !r->light_output ||
        !r->sum) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "pbnds+: no memory to shade a %d x %d image, use "
                          "--max-memory",
                          g->width, g->height);
    }
    pbnds_plus_draw_lights(job->envmap, job->seed, r->light_count, r->lights);
    return PBNDS_OK;
}

static struct pbnds_pass net_pass(const struct run *r, int lights)
{
    return (struct pbnds_pass){.batch = 1,
                               .lights = lights,
                               .h = r->tiling.window_height,
                               .w = r->tiling.window_width};
}

static enum pbnds_status run_view(struct run *r, struct pbnds_error *error)
{
    memset(r->sum, 0, window_pixels(r) * 3 * sizeof *r->sum);
    pbnds_features_view(&pbnds_features_pbnds_plus, &r->view, r->tile.window,
                        r->view_input);
    const struct pbnds_pass pass = net_pass(r, r->tiling.chunk);
    return pbnds_net_forward_view(r->shader->net, &pass, r->view_input, NULL, error);
}

static enum pbnds_status run_lights(struct run *r, int first, int count,
                                    struct pbnds_error *error)
{
    const size_t pixels = window_pixels(r);
    const size_t stride = pixels * (size_t)r->shader->model->light_channels;
    for (int k = 0; k < count; ++k) {
        pbnds_features_light(&pbnds_features_pbnds_plus, &r->view, NULL,
                             &r->lights[first + k], r->tile.window,
                             r->light_input + (size_t)k * stride);
    }
    const struct pbnds_pass pass = net_pass(r, count);
    PBNDS_TRY(pbnds_net_forward_light(r->shader->net, &pass, r->light_input,
                                      r->light_output, error));
    for (int k = 0; k < count; ++k) {
        const float *out = r->light_output + (size_t)k * pixels * 3;
        for (size_t i = 0; i < 3 * pixels; ++i)
            r->sum[i] += out[i];
    }
    return PBNDS_OK;
}

static void write_radiance(const struct run *r)
{
    const struct pbnds_gbuffer *g = r->job->gbuffer;
    const struct pbnds_window own = r->tile.own, window = r->tile.window;
    const float scale = 1.0f / (float)r->light_count;
    for (int y = own.y; y < own.y + own.height; ++y) {
        for (int x = own.x; x < own.x + own.width; ++x) {
            const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
            if (!(g->coverage[i] > 0.0f) || !isfinite(g->depth[i])) continue;
            const size_t w =
                (size_t)(y - window.y) * (size_t)window.width + (size_t)(x - window.x);
            float *to = pbnds_image_at(r->radiance, x, y);
            for (size_t c = 0; c < 3; ++c) {
                to[c] = fmaxf(r->sum[3 * w + c] * scale, 0.0f) + g->emission[c][i];
            }
        }
    }
}

static enum pbnds_status run_tile(struct run *r, int index, struct pbnds_error *error)
{
    const int tiles = r->tiling.columns * r->tiling.rows;
    enum pbnds_status status = run_view(r, error);
    for (int first = 0; status == PBNDS_OK && first < r->light_count;
         first += r->tiling.chunk) {
        pbnds_progress(r->job->report, r->shader->base.ops->name,
                       index * r->light_count + first, tiles * r->light_count);
        const int left = r->light_count - first;
        status = run_lights(r, first, left < r->tiling.chunk ? left : r->tiling.chunk,
                            error);
        if (pbnds_stop_requested()) status = pbnds_fail_interrupted(error);
    }
    if (status == PBNDS_OK) write_radiance(r);
    return status;
}

enum pbnds_status pbnds_shade_pbnds_plus(const struct pbnds_shader *self,
                                         const struct pbnds_shade_job *job,
                                         struct pbnds_image *radiance,
                                         struct pbnds_error *error)
{
    struct run r = {.shader = (const struct pbnds_shader_neural *)self,
                    .job = job,
                    .radiance = radiance};
    enum pbnds_status status = prepare(&r, error);
    const int tiles = r.tiling.columns * r.tiling.rows;
    for (int i = 0; status == PBNDS_OK && i < tiles; ++i) {
        r.tile = pbnds_tiling_tile(&r.tiling, i);
        status = pbnds_view_create_part(job->gbuffer, r.tile.window, r.median_depth,
                                        &r.view, error);
        if (status == PBNDS_OK) status = run_tile(&r, i, error);
        pbnds_view_free(&r.view);
    }
    if (status == PBNDS_OK) pbnds_progress(job->report, self->ops->name, 1, 1);
    release(&r);
    return status;
}
