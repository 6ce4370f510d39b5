/* pbnds bench: throughput of the stages, one line each. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "tools/bench_data.h"
#include "tools/bench_scene.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/rows.h"
#include "tools/shaders.h"
#include "tools/shipped.h"
#include "tools/world.h"

enum {
    REPEATS = 5,
    SHADE_SIDE = 256,
    CAST_WIDTH = 1920,
    CAST_HEIGHT = 1080,
    PATHS = 4,
    BOUNCES = 8
};

static double median(double seconds[REPEATS])
{
    qsort(seconds, REPEATS, sizeof *seconds, tool_ascending);
    return seconds[REPEATS / 2];
}

/* Median and best of the runs, as "stage=... median_s=..." for scripts; the line stays
 * open for more. */
static void print_stage(const char *stage, int width, int height, int threads,
                        double seconds[REPEATS])
{
    const double middle = median(seconds), pixels = (double)width * (double)height;
    (void)printf("stage=%s size=%dx%d threads=%d runs=%d median_s=%.6f best_s=%.6f "
                 "pixels_per_s=%.0f",
                 stage, width, height, threads, REPEATS, middle, seconds[0],
                 pixels / middle);
}

static void end_line(void)
{
    (void)printf("\n");
    (void)fflush(stdout);
}

/* The million triangles and what looks at them. */
struct stand {
    struct pbnds_scene scene;
    struct pbnds_accel *accel;
    struct pbnds_camera camera;
    int width, height;
};

static enum pbnds_status set_up(const struct tool_options *options, struct stand *stand,
                                struct pbnds_error *error)
{
    stand->width = options->size[0] ? options->size[0] : CAST_WIDTH;
    stand->height = options->size[1] ? options->size[1] : CAST_HEIGHT;
    PBNDS_TRY(tool_bench_scene(&stand->scene, &stand->camera, error));
    return pbnds_accel_create(&stand->scene, &stand->accel, error);
}

static void take_down(struct stand *stand)
{
    pbnds_accel_free(stand->accel);
    pbnds_scene_free(&stand->scene);
}

/* Seconds of one G-buffer, and of the same rays through bare Embree. */
static enum pbnds_status time_casts(const struct stand *stand, struct pbnds_gbuffer *g,
                                    double *pass, double *bare,
                                    struct pbnds_error *error)
{
    const double start = tool_seconds();
    PBNDS_TRY(pbnds_gbuffer_recast(&stand->scene, stand->accel, &stand->camera,
                                   stand->width, stand->height, NULL, g, error));
    const double middle = tool_seconds();
    const struct pbnds_camera_view view =
        pbnds_camera_view(&stand->camera, stand->width, stand->height);
    (void)pbnds_accel_bare_primary(stand->accel, &view, stand->width, stand->height);
    *pass = middle - start;
    *bare = tool_seconds() - middle;
    return tool_check_stop(error);
}

/* The whole pass beside bare Embree on the same tree and camera, with one thread and
 * with all, in turns: a slow moment of the machine then hits all of them. One ray a
 * pixel, so pixels are rays. first_s is the first of all, into memory that the system has
 * yet to hand out; the others write to the same memory again. */
static enum pbnds_status bench_gbuffer(const struct stand *stand,
                                       struct pbnds_error *error)
{
    const int all = pbnds_threads(), counts[2] = {1, all}, kinds = all > 1 ? 2 : 1;
    double pass[2][REPEATS], bare[2][REPEATS], ratio[2][REPEATS], speedup[REPEATS];
    double first = 0.0;
    struct pbnds_gbuffer g = {.width = 0};
    enum pbnds_status status = PBNDS_OK;
    for (int i = -1; i < REPEATS && status == PBNDS_OK; ++i) {
        const int at = i < 0 ? 0 : i; /* the first round warms up and is written over */
        for (int k = 0; k < kinds && status == PBNDS_OK; ++k) {
            pbnds_set_threads(counts[k]);
            status = time_casts(stand, &g, &pass[k][at], &bare[k][at], error);
            if (i < 0 && k == 0) first = pass[0][0];
            ratio[k][at] = bare[k][at] / pass[k][at];
        }
        speedup[at] = pass[0][at] / pass[kinds - 1][at];
    }
    pbnds_set_threads(all);
    pbnds_gbuffer_free(&g);
    for (int k = 0; k < kinds && status == PBNDS_OK; ++k) {
        print_stage("gbuffer", stand->width, stand->height, counts[k], pass[k]);
        (void)printf(" bare_pixels_per_s=%.0f of_bare=%.3f",
                     (double)stand->width * (double)stand->height / median(bare[k]),
                     median(ratio[k]));
        if (k)
            (void)printf(" speedup=%.2f", median(speedup));
        else
            (void)printf(" first_s=%.6f", first);
        end_line();
    }
    return status;
}

static enum pbnds_status run_gbuffer(const struct tool_options *options,
                                     struct pbnds_error *error)
{
    struct stand stand = {.accel = NULL};
    enum pbnds_status status = set_up(options, &stand, error);
    if (status == PBNDS_OK) status = bench_gbuffer(&stand, error);
    take_down(&stand);
    return status;
}

/* The trees that the flags of Embree give, of one scene. */
struct trees {
    struct pbnds_accel *accel[4];
    double build[4];
};

static struct pbnds_accel_flags flags_of(int kind)
{
    return (struct pbnds_accel_flags){.robust = kind < 2, .compact = kind % 2 == 1};
}

static enum pbnds_status build_trees(const struct pbnds_scene *scene,
                                     struct trees *trees, struct pbnds_error *error)
{
    for (int kind = 0; kind < 4; ++kind) {
        const struct pbnds_accel_flags flags = flags_of(kind);
        const double start = tool_seconds();
        PBNDS_TRY(pbnds_accel_create_as(scene, &flags, &trees->accel[kind], error));
        trees->build[kind] = tool_seconds() - start;
        PBNDS_TRY(tool_check_stop(error));
    }
    return PBNDS_OK;
}

/* Camera rays by bare packets through each tree in turns. */
static enum pbnds_status cast_trees(const struct trees *trees,
                                    const struct pbnds_camera_view *view, int width,
                                    int height, struct pbnds_error *error)
{
    double seconds[4][REPEATS];
    for (int i = -1; i < REPEATS; ++i) {
        for (int kind = 0; kind < 4; ++kind) {
            const double start = tool_seconds();
            (void)pbnds_accel_bare_primary(trees->accel[kind], view, width, height);
            seconds[kind][i < 0 ? 0 : i] = tool_seconds() - start;
            PBNDS_TRY(tool_check_stop(error));
        }
    }
    for (int kind = 0; kind < 4; ++kind) {
        const struct pbnds_accel_flags flags = flags_of(kind);
        print_stage("bvh", width, height, pbnds_threads(), seconds[kind]);
        (void)printf(" robust=%d compact=%d build_s=%.3f mib=%.1f", flags.robust,
                     flags.compact, trees->build[kind],
                     (double)pbnds_accel_bytes(trees->accel[kind]) / 1048576.0);
        end_line();
    }
    return PBNDS_OK;
}

static enum pbnds_status run_bvh(const struct tool_options *options,
                                 struct pbnds_error *error)
{
    const int width = options->size[0] ? options->size[0] : CAST_WIDTH;
    const int height = options->size[1] ? options->size[1] : CAST_HEIGHT;
    struct pbnds_scene scene;
    struct pbnds_camera camera;
    struct trees trees = {.build = {0.0}};
    PBNDS_TRY(tool_bench_scene(&scene, &camera, error));
    enum pbnds_status status = build_trees(&scene, &trees, error);
    const struct pbnds_camera_view view = pbnds_camera_view(&camera, width, height);
    if (status == PBNDS_OK) status = cast_trees(&trees, &view, width, height, error);
    for (int kind = 0; kind < 4; ++kind)
        pbnds_accel_free(trees.accel[kind]);
    pbnds_scene_free(&scene);
    return status;
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
    if (status == PBNDS_OK) {
        print_stage(name, world->gbuffer.width, world->gbuffer.height, pbnds_threads(),
                    seconds);
        end_line();
    }
    tool_shader_close(&shader);
    return status;
}

/* Paths of the reference beside bare Embree's, on the million triangles under the sky, in
 * turns. Both start at the pixels' centres and go on for as many surfaces; the bare ones
 * shade nothing and end only where they leave the scene. */
static enum pbnds_status bench_paths(const struct tool_world *world,
                                     const struct pbnds_shade_job *job,
                                     const struct pbnds_shader *shader,
                                     struct pbnds_error *error)
{
    const int w = world->gbuffer.width, h = world->gbuffer.height;
    const struct pbnds_camera_view view =
        pbnds_camera_view(&world->gbuffer.camera, w, h);
    double pass[REPEATS], bare[REPEATS], ratio[REPEATS];
    uint64_t rays = 0;
    for (int i = -1; i < REPEATS; ++i) {
        const int at = i < 0 ? 0 : i; /* the first round warms up and is written over */
        struct pbnds_image radiance = {0, 0, 0, NULL};
        const double start = tool_seconds();
        PBNDS_TRY(pbnds_shade(shader, job, &radiance, error));
        const double middle = tool_seconds();
        pbnds_image_free(&radiance);
        rays = pbnds_accel_bare_paths(world->accel, &view, w, h, job->spp, BOUNCES);
        bare[at] = tool_seconds() - middle;
        pass[at] = middle - start;
        ratio[at] = bare[at] / pass[at];
        PBNDS_TRY(tool_check_stop(error));
    }
    const double paths = (double)w * (double)h * (double)job->spp;
    print_stage("reference", w, h, pbnds_threads(), pass);
    (void)printf(" paths_per_s=%.0f bare_paths_per_s=%.0f bare_rays_per_path=%.2f "
                 "of_bare=%.3f",
                 paths / median(pass), paths / median(bare), (double)rays / paths,
                 median(ratio));
    end_line();
    return PBNDS_OK;
}

static enum pbnds_status run_paths(const struct tool_options *options,
                                   struct pbnds_error *error)
{
    const int width = options->size[0] ? options->size[0] : SHADE_SIDE;
    const int height = options->size[1] ? options->size[1] : SHADE_SIDE;
    struct tool_world world = {.accel = NULL};
    struct pbnds_camera camera;
    enum pbnds_status status = tool_bench_scene(&world.scene, &camera, error);
    if (status == PBNDS_OK)
        status = pbnds_accel_create(&world.scene, &world.accel, error);
    if (status == PBNDS_OK)
        status = pbnds_gbuffer_raycast(&world.scene, world.accel, &camera, width,
                                       height, NULL, &world.gbuffer, error);
    if (status == PBNDS_OK) status = tool_world_light(options, &world, error);
    if (status == PBNDS_OK) {
        struct pbnds_shade_job job = tool_world_job(options, &world);
        if (job.spp <= 0) job.spp = PATHS;
        job.report = NULL;
        status = bench_paths(&world, &job, pbnds_shader_find("reference"), error);
    }
    tool_world_free(&world);
    return status;
}

static enum pbnds_status bench_all(const struct tool_options *options,
                                   const char *scene, const char *const *stages,
                                   int count, struct pbnds_error *error)
{
    for (int i = 0; i < count; ++i) {
        if (strcmp(stages[i], "gbuffer") == 0) {
            PBNDS_TRY(run_gbuffer(options, error));
            continue;
        }
        if (strcmp(stages[i], "bvh") == 0) {
            PBNDS_TRY(run_bvh(options, error));
            continue;
        }
        if (strcmp(stages[i], "reference") == 0) {
            PBNDS_TRY(run_paths(options, error));
            continue;
        }
        if (strcmp(stages[i], "dataset") == 0) {
            PBNDS_TRY(tool_bench_data(options, error));
            continue;
        }
        struct tool_world world = {.accel = NULL};
        struct tool_options view = *options;
        if (!view.size[0]) view.size[0] = view.size[1] = SHADE_SIDE;
        enum pbnds_status status = tool_world_scene(&view, scene, &world, error);
        if (status == PBNDS_OK) status = tool_world_light(&view, &world, error);
        if (status == PBNDS_OK)
            status = bench_shader(options, stages[i], &world, error);
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
        if (strcmp(stages[i], "gbuffer") == 0 || strcmp(stages[i], "bvh") == 0 ||
            strcmp(stages[i], "dataset") == 0)
            continue;
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
    .details =
        "STAGE: gbuffer, bvh, dataset or the name of a shader (default: gbuffer, "
        "blinn-phong, "
        "ggx,\n"
        "transport and pbnds+). Each is run five times, after one run that is not "
        "counted;\n"
        "one line of key=value each. Shaders: the scene that ships under its sky, at "
        "256x256.\n"
        "gbuffer: a million textured triangles at 1920x1080, one ray a pixel, with one "
        "thread\n"
        "and with all; of_bare is its speed as a share of the same rays through "
        "Embree\n"
        "alone, in turns; first_s is a first cast, into memory not yet handed out.\n"
        "bvh: the same triangles in the trees that Embree's flags give: seconds to "
        "build,\n"
        "memory, camera rays a second.\n"
        "reference: the same triangles at 256x256, four paths a pixel, beside a loop "
        "of\n"
        "random bounces.\n"
        "dataset: eight samples of procedural worlds, 128x128 at 256 samples a pixel "
        "with all\n"
        "targets; added is the time of all that is not the path tracer, as a share of "
        "its own.\n\n"
        "  pbnds bench gbuffer neural --threads 2",
    .run = run,
};
