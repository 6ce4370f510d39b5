#include "tools/shading.h"

#include <stdio.h>

#include "tools/console.h"
#include "tools/output.h"

static enum pbnds_status check_outputs(const struct tool_options *options,
                                       struct pbnds_error *error)
{
    PBNDS_TRY(tool_picture_check(options->output, error));
    if (!options->preview) return PBNDS_OK;
    if (!tool_has_extension(options->preview, ".png")) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "--preview %s: is not a .png",
                          options->preview);
    }
    return tool_output_check(options->preview, error);
}

/* What a shader gives. */
struct result {
    struct pbnds_image radiance, alpha, variance;
    int taken; /* samples a pixel; 0: the shader does not say */
    double seconds;
};

static enum pbnds_status write_outputs(const struct tool_options *options,
                                       const struct tool_world *world,
                                       struct result *result, struct pbnds_error *error)
{
    const struct pbnds_display display = tool_display(options);
    tool_background(world, options->background, &result->alpha, &result->radiance);
    PBNDS_TRY(tool_picture_write(options->output, world, &result->radiance,
                                 &result->alpha, &result->variance, &display, error));
    if (!options->preview) return PBNDS_OK;
    return tool_picture_write(options->preview, world, &result->radiance,
                              &result->alpha, &result->variance, &display, error);
}

static enum pbnds_status shade(const struct tool_options *options,
                               const struct tool_world *world,
                               const struct pbnds_shader *shader, struct result *result,
                               struct pbnds_error *error)
{
    struct pbnds_shade_job job = tool_world_job(options, world);
    job.alpha = &result->alpha;
    job.taken = &result->taken;
    if (tool_has_extension(options->output, ".exr")) job.variance = &result->variance;
    const double start = tool_seconds();
    PBNDS_TRY(pbnds_shade(shader, &job, &result->radiance, error));
    result->seconds = tool_seconds() - start;
    return tool_check_stop(error);
}

static void say(const struct tool_options *options, const char *shader,
                const struct result *result)
{
    const struct pbnds_image *picture = &result->radiance;
    if (options->json) {
        tool_json_result(options->output, result->taken > 0 ? 4 : 3, "width",
                         (double)picture->width, "height", (double)picture->height,
                         "seconds", result->seconds, "spp", (double)result->taken);
        return;
    }
    (void)printf("%s: %dx%d, %s, shaded in %.2f s", options->output, picture->width,
                 picture->height, shader, result->seconds);
    if (result->taken > 0) (void)printf(", %d samples a pixel", result->taken);
    (void)printf("\n");
}

enum pbnds_status tool_shade_one(const struct tool_options *options,
                                 tool_world_loader load, struct pbnds_error *error)
{
    struct tool_world world = {.accel = NULL};
    struct tool_shader shader = {NULL, false};
    struct result result = {.taken = 0};
    const char *name = options->shader ? options->shader : "neural";
    enum pbnds_status status = tool_shader_check(name, error);
    if (status == PBNDS_OK) status = check_outputs(options, error);
    if (status == PBNDS_OK) {
        status = tool_shader_open(name, options->precision, &shader, error);
    }
    if (status == PBNDS_OK) status = load(options, options->inputs[0], &world, error);
    if (status == PBNDS_OK) status = tool_world_light(options, &world, error);
    if (status == PBNDS_OK)
        status = shade(options, &world, shader.shader, &result, error);
    if (status == PBNDS_OK) status = write_outputs(options, &world, &result, error);
    if (status == PBNDS_OK) say(options, name, &result);
    pbnds_image_free(&result.radiance);
    pbnds_image_free(&result.alpha);
    pbnds_image_free(&result.variance);
    tool_shader_close(&shader);
    tool_world_free(&world);
    return status;
}
