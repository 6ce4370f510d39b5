#include "neural/transport_pass.h"

#include <stdlib.h>

#include "engine/core/parallel.h"

enum { MARCHED = 32 }; /* lights that the march packs to a word */

struct run {
    const struct pbnds_transport_pass *pass;
    struct pbnds_tiling tiling;
    float median_depth;
    /* of the largest window, used again for every tile */
    float *input; /* of the view, then of lights: [chunk, window, channels] */
    float *output, *occlusion;
    struct pbnds_transport_pixel *pixels;
    struct pbnds_march march;
    /* of the tile at hand */
    struct pbnds_view view;
    struct pbnds_transport_tile tile;
};

static size_t window_pixels(const struct run *r)
{
    return (size_t)r->tiling.window_width * (size_t)r->tiling.window_height;
}

/* Floats of input a pixel: the view's or those of all lights at hand. */
static size_t input_channels(const struct pbnds_model *model, int lights)
{
    const size_t light = (size_t)lights * (size_t)model->light_channels;
    return light > (size_t)model->view_channels ? light : (size_t)model->view_channels;
}

static size_t tile_bytes(const void *context, int width, int height, int lights)
{
    const struct pbnds_transport_pass *p = context;
    const struct pbnds_shader_neural *s = p->shader;
    const struct pbnds_pass pass = {
        .batch = 1, .lights = lights, .h = height, .w = width};
    const size_t net = pbnds_net_bytes(s->net, &pass);
    const size_t a_pixel = pbnds_view_bytes_a_pixel() + 2 * sizeof(uint32_t) +
                           sizeof(float) + sizeof(struct pbnds_transport_pixel) +
                           sizeof(float) * (input_channels(s->model, lights) +
                                            (size_t)lights * (size_t)PBNDS_OUT_COUNT);
    const size_t planes = a_pixel * (size_t)width * (size_t)height;
    return net > SIZE_MAX - planes ? SIZE_MAX : net + planes;
}

static enum pbnds_status prepare(struct run *r, struct pbnds_error *error)
{
    const struct pbnds_transport_pass *p = r->pass;
    const struct pbnds_gbuffer *g = p->job->gbuffer;
    r->tiling = pbnds_tiling_plan(p->shader->net, g->width, g->height, p->count,
                                  p->job->max_memory, tile_bytes, p);
    r->median_depth = pbnds_view_median_depth(g);
    const size_t pixels = window_pixels(r), chunk = (size_t)r->tiling.chunk;
    r->input = malloc(pixels * input_channels(p->shader->model, r->tiling.chunk) *
                      sizeof *r->input);
    r->output = malloc(chunk * pixels * PBNDS_OUT_COUNT * sizeof *r->output);
    r->occlusion = malloc(pixels * sizeof *r->occlusion);
    r->pixels = malloc(pixels * sizeof *r->pixels);
    r->march.thin = malloc(pixels * sizeof *r->march.thin);
    r->march.thick = malloc(pixels * sizeof *r->march.thick);
    if (r->input && r->output && r->occlusion && r->pixels && r->march.thin &&
        r->march.thick) {
        return PBNDS_OK;
    }
    return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                      "transport: no memory to shade a %d x %d image, use --max-memory",
                      g->width, g->height);
}

static void release(struct run *r)
{
    free(r->input);
    free(r->output);
    free(r->occlusion);
    free(r->pixels);
    free(r->march.thin);
    free(r->march.thick);
}

static void pixel_row(void *context, size_t row, int thread)
{
    (void)thread;
    struct run *r = context;
    const struct pbnds_window own = r->tile.at.own;
    const size_t y = (size_t)(own.y - r->view.y) + row;
    for (int k = 0; k < own.width; ++k) {
        const size_t x = (size_t)(own.x - r->view.x + k);
        r->pixels[row * (size_t)own.width + (size_t)k] =
            pbnds_transport_pixel(&r->view, y * (size_t)r->view.width + x);
    }
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
    pbnds_parallel_for((size_t)r->tile.at.own.height, pixel_row, r);
    r->tile.pixels = r->pixels;
    r->tile.occlusion = NULL;
    if (r->pass->count == 0) return PBNDS_OK;
    pbnds_features_view(&pbnds_features_transport, &r->view, r->tile.at.window,
                        r->input);
    const struct pbnds_pass pass = net_pass(r, r->tiling.chunk);
    r->tile.occlusion = r->occlusion;
    return pbnds_net_forward_view(r->pass->shader->net, &pass, r->input, r->occlusion,
                                  error);
}

static enum pbnds_status run_lights(struct run *r, int first, int count,
                                    struct pbnds_error *error)
{
    const size_t stride =
        window_pixels(r) * (size_t)r->pass->shader->model->light_channels;
    const struct pbnds_vec3 *wi = r->pass->wi + first;
    for (int from = 0; from < count; from += MARCHED) {
        const int group = count - from < MARCHED ? count - from : MARCHED;
        pbnds_view_march(&r->view, wi + from, group, &r->march);
        for (int k = 0; k < group; ++k) {
            const struct pbnds_light_source source = {.wi = wi[from + k], .bit = k};
            pbnds_features_light(&pbnds_features_transport, &r->view, &r->march,
                                 &source, r->tile.at.window,
                                 r->input + (size_t)(from + k) * stride);
        }
    }
    const struct pbnds_pass pass = net_pass(r, count);
    r->tile.first = first;
    r->tile.count = count;
    r->tile.lights = r->output;
    return pbnds_net_forward_light(r->pass->shader->net, &pass, r->input, r->output,
                                   error);
}

static enum pbnds_status run_tile(struct run *r, int index, struct pbnds_error *error)
{
    const struct pbnds_transport_pass *p = r->pass;
    const int tiles = r->tiling.columns * r->tiling.rows;
    enum pbnds_status status = run_view(r, error);
    for (int first = 0; status == PBNDS_OK && first < p->count;
         first += r->tiling.chunk) {
        pbnds_progress(p->job->report, p->shader->base.ops->name,
                       index * p->count + first, tiles * p->count);
        const int left = p->count - first;
        status = run_lights(r, first, left < r->tiling.chunk ? left : r->tiling.chunk,
                            error);
        if (status == PBNDS_OK) status = p->lights(p->context, &r->tile, error);
        if (pbnds_stop_requested()) status = pbnds_fail_interrupted(error);
    }
    if (status == PBNDS_OK) status = p->end(p->context, &r->tile, error);
    if (status == PBNDS_OK && pbnds_stop_requested())
        status = pbnds_fail_interrupted(error);
    return status;
}

enum pbnds_status pbnds_transport_run(const struct pbnds_transport_pass *pass,
                                      struct pbnds_error *error)
{
    struct run r = {.pass = pass};
    enum pbnds_status status = prepare(&r, error);
    const int tiles = r.tiling.columns * r.tiling.rows;
    for (int i = 0; status == PBNDS_OK && i < tiles; ++i) {
        r.tile = (struct pbnds_transport_tile){.at = pbnds_tiling_tile(&r.tiling, i),
                                               .view = &r.view};
        status = pbnds_view_create_part(pass->job->gbuffer, r.tile.at.window,
                                        r.median_depth, &r.view, error);
        if (status == PBNDS_OK) status = run_tile(&r, i, error);
        pbnds_view_free(&r.view);
    }
    if (status == PBNDS_OK) {
        pbnds_progress(pass->job->report, pass->shader->base.ops->name, 1, 1);
    }
    release(&r);
    return status;
}
