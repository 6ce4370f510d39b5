/* pbnds gbuffer: what the primary rays hit, as a file. */
#include <stdio.h>

#include "tools/commands.h"
#include "tools/console.h"
#include "tools/output.h"
#include "tools/world.h"

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    if (!tool_has_extension(options->output, ".exr")) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: a G-buffer is written as .exr", options->output);
    }
    PBNDS_TRY(tool_output_check(options->output, error));
    struct tool_world world = {.accel = NULL};
    enum pbnds_status status =
        tool_world_scene(options, options->inputs[0], &world, error);
    if (status == PBNDS_OK) {
        status = pbnds_gbuffer_write(options->output, &world.gbuffer, &world.origin,
                                     NULL, NULL, 0, PBNDS_EXR_ZIP, error);
    }
    if (status == PBNDS_OK) {
        const struct pbnds_gbuffer *g = &world.gbuffer;
        const size_t count = (size_t)g->width * (size_t)g->height;
        double covered = 0.0;
        for (size_t i = 0; i < count; ++i)
            covered += (double)g->coverage[i];
        if (options->json) {
            tool_json_result(options->output, 3, "width", (double)g->width, "height",
                             (double)g->height, "coverage", covered / (double)count);
        } else {
            (void)printf("%s: %dx%d, %.1f %% covered\n", options->output, g->width,
                         g->height, 100.0 * covered / (double)count);
        }
    }
    tool_world_free(&world);
    return status;
}

const struct tool_command tool_gbuffer = {
    .name = "gbuffer",
    .mask = TOOL_GBUFFER,
    .min_inputs = 1,
    .max_inputs = 1,
    .needs_output = true,
    .usage = "gbuffer SCENE -o OUT.exr [options]",
    .about = "casts the G-buffer of a glTF scene into an EXR file",
    .details =
        "One ray through each pixel centre, or --aov-samples of them. Channels: "
        "albedo, "
        "normal,\n"
        "specular, roughness, metallic, Z (metres), coverage, position, emission, "
        "object_id; f0 and\n"
        "f90 where a material needs them; uv, ao, material_id (--aovs), motion, "
        "Cryptomatte. The\n"
        "header says camera, spaces, contract version, seed and arguments; 'pbnds "
        "check' "
        "reads it\n"
        "all.\n\n"
        "  pbnds gbuffer scene.glb -o g.exr --camera main --size 640x480\n"
        "  pbnds gbuffer scene.glb -o g.exr --aov-samples 16 --aov-through alpha "
        "--cryptomatte",
    .run = run,
};
