/* pbnds render: a scene, a light map, a shader, a picture. */
#include "tools/commands.h"
#include "tools/shading.h"

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    return tool_shade_one(options, tool_world_scene, error);
}

const struct tool_command tool_render = {
    .name = "render",
    .mask = TOOL_RENDER,
    .min_inputs = 1,
    .max_inputs = 1,
    .needs_output = true,
    .usage = "render SCENE -o OUT.{exr,png} [--shader NAME] [options]",
    .about = "renders a glTF scene with one shader",
    .details =
        "SCENE is a .gltf or .glb file. OUT.exr holds linear radiance (R, G, B, with A "
        "the\n"
        "coverage) and every channel of the G-buffer, of the reference also the "
        "variance\n"
        "of its mean (variance.R, .G, .B); OUT.png is the tone-mapped preview. With\n"
        "--noise the reference takes at most --spp samples a pixel (default 4096).\n\n"
        "  pbnds render scene.glb -o out.exr --env studio.hdr --preview out.png\n"
        "  pbnds render scene.glb -o out.png --shader reference --spp 256 --size "
        "640x480\n"
        "  pbnds render scene.glb -o out.png --look 30,20 --shader "
        "neural:my.safetensors",
    .run = run,
};
