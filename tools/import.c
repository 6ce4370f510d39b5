/* pbnds import: G-buffers and photographs that other programs made. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "engine/shade/import.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/import_ffhq.h"
#include "tools/output.h"

static struct pbnds_import_options import_options(const struct tool_options *options)
{
    const float degree = PBNDS_PI / 180.0f;
    return (struct pbnds_import_options){
        .yfov = options->fov > 0.0 ? (float)options->fov * degree : 0.0f,
        .look_given = options->look_given,
        .yaw = (float)options->look[0] * degree,
        .pitch = (float)options->look[1] * degree,
    };
}

static void print_json(const char *path, const struct pbnds_gbuffer *g, double coverage,
                       const struct pbnds_import_notes *notes)
{
    (void)printf("{\"output\": ");
    tool_json_string(stdout, path);
    (void)printf(", \"width\": %d, \"height\": %d, \"coverage\": ", g->width,
                 g->height);
    tool_json_number(stdout, coverage);
    (void)printf(", \"notes\": [");
    for (int i = 0; i < notes->count; ++i) {
        if (i > 0) (void)printf(", ");
        tool_json_string(stdout, notes->text[i]);
    }
    (void)printf("]}\n");
}

static void print_result(const struct tool_options *options, const char *path,
                         const struct pbnds_gbuffer *g,
                         const struct pbnds_import_notes *notes)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    double covered = 0.0;
    for (size_t i = 0; i < count; ++i)
        covered += (double)g->coverage[i];
    covered /= (double)count;
    if (options->json) {
        print_json(path, g, covered, notes);
        return;
    }
    (void)printf("%s: %dx%d, %.1f %% covered\n", path, g->width, g->height,
                 100.0 * covered);
    for (int i = 0; i < notes->count; ++i)
        (void)printf("  %s\n", notes->text[i]);
}

static enum pbnds_status write_result(const struct tool_options *options,
                                      const char *path, const struct pbnds_gbuffer *g,
                                      const struct pbnds_image *radiance,
                                      enum pbnds_target target,
                                      struct pbnds_error *error)
{
    struct pbnds_gbuffer_origin origin = {
        .env_strength = 1.0f, .seed = options->seed, .target = target};
    (void)snprintf(origin.arguments, sizeof origin.arguments, "%s", options->arguments);
    return pbnds_gbuffer_write(path, g, &origin, radiance->data ? radiance : NULL, NULL,
                               0, PBNDS_EXR_ZIP, error);
}

static enum pbnds_status import_one(const struct tool_options *options, bool blender,
                                    const char *from, const char *to,
                                    struct pbnds_error *error)
{
    const struct pbnds_import_options how = import_options(options);
    struct pbnds_gbuffer g;
    struct pbnds_image radiance = {0, 0, 0, NULL};
    enum pbnds_target target = PBNDS_TARGET_RADIANCE;
    struct pbnds_import_notes *notes = malloc(sizeof *notes);
    if (!notes) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory");
    enum pbnds_status status =
        blender ? pbnds_import_blender(from, &how, &g, &radiance, notes, error)
                : pbnds_import_images(from, &how, &g, &radiance, &target, notes, error);
    if (status == PBNDS_OK) {
        status = write_result(options, to, &g, &radiance, target, error);
        if (status == PBNDS_OK) print_result(options, to, &g, notes);
        pbnds_gbuffer_free(&g);
        pbnds_image_free(&radiance);
    }
    free(notes);
    return status;
}

static int is_exr(const struct dirent *entry)
{
    return entry->d_name[0] != '.' && tool_has_extension(entry->d_name, ".exr");
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

/* Every .exr of a folder, into another folder under the same name. */
static enum pbnds_status import_folder(const struct tool_options *options,
                                       const char *folder, struct pbnds_error *error)
{
    PBNDS_TRY(tool_folder_check(options->output, error));
    struct dirent **entries = NULL;
    const int count = scandir(folder, &entries, is_exr, by_name);
    enum pbnds_status status = PBNDS_OK;
    if (count < 1) {
        status = pbnds_fail(error, count < 0 ? PBNDS_ERROR_IO : PBNDS_ERROR_FORMAT,
                            "%s: has no .exr to import; give a file, or a folder of "
                            "them",
                            folder);
    }
    for (int i = 0; i < count; ++i) {
        char from[1400], to[1400];
        const char *name = entries[i]->d_name;
        const bool fits =
            snprintf(from, sizeof from, "%s/%s", folder, name) < (int)sizeof from &&
            snprintf(to, sizeof to, "%s/%s", options->output, name) < (int)sizeof to;
        if (status == PBNDS_OK && !fits)
            status = pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                                "%s/%s: is too long a name", folder, name);
        if (status == PBNDS_OK) status = import_one(options, true, from, to, error);
        if (status == PBNDS_OK) status = tool_check_stop(error);
        pbnds_progress(tool_report(), "import", i + 1.0, count);
        free(entries[i]);
    }
    free(entries);
    return status;
}

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    const char *kind = options->inputs[0], *from = options->inputs[1];
    const bool blender = strcmp(kind, "blender") == 0;
    if (strcmp(kind, "ffhq-pbr") == 0) return tool_import_ffhq(options, error);
    if (!blender && strcmp(kind, "images") != 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "import: '%s' is not one of blender, images, ffhq-pbr", kind);
    }
    if (options->format || options->per_tar) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "import %s: makes no data set; leave out --format and --per-tar", kind);
    }
    struct stat info;
    if (blender && stat(from, &info) == 0 && S_ISDIR(info.st_mode))
        return import_folder(options, from, error);
    if (!tool_has_extension(options->output, ".exr")) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: a G-buffer is written as .exr", options->output);
    }
    PBNDS_TRY(tool_output_check(options->output, error));
    return import_one(options, blender, from, options->output, error);
}

const struct tool_command tool_import = {
    .name = "import",
    .mask = TOOL_IMPORT,
    .min_inputs = 2,
    .max_inputs = 2,
    .needs_output = true,
    .usage = "import blender|images|ffhq-pbr FILE|DIR -o OUT [options]",
    .about = "makes a G-buffer, or a data set, of what other programs wrote",
    .details =
        "blender FILE.exr|DIR: OpenEXR MultiLayer files with the passes Combined, Z, "
        "Normal and\n"
        "Diffuse Color, and where they are there Position (the camera is found from "
        "it),\n"
        "Glossy Color, Emission, Object and Material Index, and AOVs called roughness, "
        "metallic,\n"
        "specular and albedo. A folder goes into a folder. ZIP and PIZ, not DWA.\n"
        "images DIR: maps of one size, NAME.png, .exr, .jpg, .webp or .hdr: albedo, "
        "normal\n"
        "(2 v - 1, +y up), roughness, metallic, specular, depth (.exr: metres; 16 "
        "bit:\n"
        "millimetres), mask, emission, ao, and photo, the photograph itself, which "
        "goes along\n"
        "as R, G, B; its alpha is the mask where there is no other. 8- and 16-bit "
        "colours are\n"
        "decoded from sRGB. What is missing gets a default, and is told.\n"
        "ffhq-pbr DIR: photographs with maps and light, laid out as FFHQ-PBR and "
        "CelebA-PBR\n"
        "are, become a data set: bgremoval/SUB/ID.png (RGBA), "
        "texture/KIND/SUB/KIND_ID.png for\n"
        "albedo, normal, roughness, specular; texture/depth/SUB/depth_ID.exr (may be "
        "missing);\n"
        "hdri/SUB/hdri_ID.exr ('pbnds' convention, camera frame); pred_fov.json "
        "({\"ID\": degrees,\n"
        "horizontal}; --fov for those that it leaves out). Split by the hash of the "
        "ID, or as\n"
        "train.txt, val.txt and test.txt in DIR say, one ID a line. Broken pictures "
        "are listed in\n"
        "import.json. It trains pbnds+, not transport: a photograph tells no direct "
        "light.\n"
        "\n"
        "  pbnds import blender render.exr -o g.exr\n"
        "  pbnds import images maps/ -o g.exr --fov 30 && pbnds shade g.exr -o "
        "out.png\n"
        "  pbnds import ffhq-pbr FFHQ-PBR/ -o faces/",
    .run = run,
};
