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

static enum pbnds_status write_outputs(const struct tool_options *options,
                                       const struct tool_world *world,
                                       struct pbnds_image *radiance,
                                       struct pbnds_error *error)
{
    const struct pbnds_display display = tool_display(options);
    if (options->background) tool_background(world, radiance);
    PBNDS_TRY(tool_picture_write(options->output, world, radiance, &display, error));
    if (!options->preview) return PBNDS_OK;
    return tool_picture_write(options->preview, world, radiance, &display, error);
}

enum pbnds_status tool_shade_one(const struct tool_options *options,
                                 tool_world_loader load, struct pbnds_error *error)
{
    struct tool_world world = {.accel = NULL};
    struct tool_shader shader = {NULL, false};
    struct pbnds_image radiance = {0, 0, 0, NULL};
    const char *name = options->shader ? options->shader : "neural";
    enum pbnds_status status = tool_shader_check(name, error);
    if (status == PBNDS_OK) status = check_outputs(options, error);
    if (status == PBNDS_OK) {
        status = tool_shader_open(name, options->precision, &shader, error);
    }
    if (status == PBNDS_OK) status = load(options, options->inputs[0], &world, error);
    if (status == PBNDS_OK) status = tool_world_light(options, &world, error);
    if (status != PBNDS_OK) goto done;

    const struct pbnds_shade_job job = tool_world_job(options, &world);
    const double start = tool_seconds();
    status = pbnds_shade(shader.shader, &job, &radiance, error);
    const double seconds = tool_seconds() - start;
    if (status == PBNDS_OK) status = tool_check_stop(error);
    if (status == PBNDS_OK) status = write_outputs(options, &world, &radiance, error);
    if (status == PBNDS_OK) {
        if (options->json) {
            tool_json_result(options->output, 3, "width", (double)radiance.width,
                             "height", (double)radiance.height, "seconds", seconds);
        } else {
            (void)printf("%s: %dx%d, %s, shaded in %.2f s\n", options->output,
                         radiance.width, radiance.height, name, seconds);
        }
    }
done:
    pbnds_image_free(&radiance);
    tool_shader_close(&shader);
    tool_world_free(&world);
    return status;
}
