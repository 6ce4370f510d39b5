/* pbnds shade: the deferred stage alone. */
#include "tools/commands.h"
#include "tools/shading.h"

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    return tool_shade_one(options, tool_world_gbuffer, error);
}

const struct tool_command tool_shade = {
    .name = "shade",
    .mask = TOOL_SHADE,
    .min_inputs = 1,
    .max_inputs = 1,
    .needs_output = true,
    .usage = "shade GBUFFER.exr -o OUT.{exr,png} [--shader NAME] [options]",
    .about = "relights a G-buffer file with one shader",
    .details =
        "GBUFFER.exr comes from 'pbnds gbuffer', from 'pbnds render', or from any "
        "program that\n"
        "writes albedo.{R,G,B}, normal.{X,Y,Z}, Z and roughness.R. Without its scene "
        "there "
        "are\nno rays: no ray-traced shadows, and no reference.\n\n"
        "  pbnds gbuffer scene.glb -o g.exr\n"
        "  pbnds shade g.exr -o out.png --env sunset.hdr --env-yaw 90 --shader "
        "neural\n\n"
        "--cache FILE keeps what the view does with light from a set of fixed "
        "directions; once\n"
        "made, any light map costs a weighted sum. A cache of another G-buffer, other "
        "weights\n"
        "or another precision is refused.\n\n"
        "  pbnds shade g.exr -o a.png --cache view.cache --env sunset.hdr\n"
        "  pbnds shade g.exr -o b.png --cache view.cache --env noon.hdr",
    .run = run,
};
