/* pbnds bench: throughput of the stages on the scene that ships, one line each. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/shaders.h"
#include "tools/shipped.h"
#include "tools/world.h"

enum { REPEATS = 5, SIDE = 512, SHADE_SIDE = 256 };

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Median and best of the runs, as "stage=... median_s=..." for scripts. */
static void print_line(const char *stage, const struct pbnds_gbuffer *g,
                       double *seconds)
{
    qsort(seconds, REPEATS, sizeof *seconds, ascending);
    const double pixels = (double)g->width * (double)g->height;
    (void)printf("stage=%s size=%dx%d threads=%d runs=%d median_s=%.6f best_s=%.6f "
                 "pixels_per_s=%.0f\n",
                 stage, g->width, g->height, pbnds_threads(), REPEATS,
                 seconds[REPEATS / 2], seconds[0], pixels / seconds[REPEATS / 2]);
    (void)fflush(stdout);
}

/* One ray a pixel, so pixels are rays. */
static enum pbnds_status bench_gbuffer(const struct tool_world *world,
                                       struct pbnds_error *error)
{
    double seconds[REPEATS];
    for (int i = 0; i < REPEATS; ++i) {
        struct pbnds_gbuffer g;
        const double start = tool_seconds();
        PBNDS_TRY(pbnds_gbuffer_raycast(&world->scene, world->accel,
                                        &world->gbuffer.camera, world->gbuffer.width,
                                        world->gbuffer.height, NULL, &g, error));
        seconds[i] = tool_seconds() - start;
        pbnds_gbuffer_free(&g);
        PBNDS_TRY(tool_check_stop(error));
    }
    print_line("gbuffer", &world->gbuffer, seconds);
    return PBNDS_OK;
}

static enum pbnds_status bench_shader(const struct tool_options *options,
                                      const char *name, const struct tool_world *world,
                                      struct pbnds_error *error)
{
    struct tool_shader shader;
    PBNDS_TRY(tool_shader_open(name, TOOL_PRECISION_AUTO, &shader, error));
    const struct pbnds_shade_job job = tool_world_job(options, world);
    double seconds[REPEATS];
    enum pbnds_status status = PBNDS_OK;
    /* The first run compiles kernels and is not counted. */
    for (int i = -1; i < REPEATS && status == PBNDS_OK; ++i) {
        struct pbnds_image radiance = {0, 0, 0, NULL};
        const double start = tool_seconds();
        status = pbnds_shade(shader.shader, &job, &radiance, error);
        if (i >= 0) seconds[i] = tool_seconds() - start;
        pbnds_image_free(&radiance);
        if (status == PBNDS_OK) status = tool_check_stop(error);
    }
    if (status == PBNDS_OK) print_line(name, &world->gbuffer, seconds);
    tool_shader_close(&shader);
    return status;
}

static enum pbnds_status bench_all(const struct tool_options *options,
                                   const char *scene, const char *const *stages,
                                   int count, struct pbnds_error *error)
{
    for (int i = 0; i < count; ++i) {
        struct tool_world world = {.accel = NULL};
        struct tool_options view = *options;
        const bool gbuffer = strcmp(stages[i], "gbuffer") == 0;
        if (!view.size[0]) view.size[0] = view.size[1] = gbuffer ? SIDE : SHADE_SIDE;
        enum pbnds_status status = tool_world_scene(&view, scene, &world, error);
        if (status == PBNDS_OK) status = tool_world_light(&view, &world, error);
        if (status == PBNDS_OK) {
            status = gbuffer ? bench_gbuffer(&world, error)
                             : bench_shader(options, stages[i], &world, error);
        }
        tool_world_free(&world);
        PBNDS_TRY(status);
    }
    return PBNDS_OK;
}

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    static const char *const all[] = {"gbuffer", "blinn-phong", "ggx", "transport",
                                      "pbnds+"};
    const char *const *stages = options->input_count ? options->inputs : all;
    const int count =
        options->input_count ? options->input_count : (int)(sizeof all / sizeof *all);
    for (int i = 0; i < count; ++i) {
        if (strcmp(stages[i], "gbuffer") == 0) continue;
        PBNDS_TRY(tool_shader_check(stages[i], error));
    }
    char scene[1400];
    if (!tool_shipped("scenes/still_life.glb", scene, sizeof scene)) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "%s: the scene to measure on is not installed", scene);
    }
    return bench_all(options, scene, stages, count, error);
}

const struct tool_command tool_bench = {
    .name = "bench",
    .mask = TOOL_BENCH,
    .min_inputs = 0,
    .max_inputs = -1,
    .needs_output = false,
    .usage = "bench [STAGE...] [--size WxH]",
    .about = "measures the throughput of the stages",
    .details = "STAGE is gbuffer or the name of a shader (default: gbuffer, "
               "blinn-phong, ggx,\n"
               "transport and pbnds+). Each is run five times on the scene that ships, "
               "under its\n"
               "sky, gbuffer at 512x512 (one ray a pixel) and shaders at 256x256, with "
               "one run\n"
               "before that is not counted; one line of key=value each.\n\n"
               "  pbnds bench gbuffer neural --threads 1",
    .run = run,
};
