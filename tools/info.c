/* pbnds info, pbnds check: what a file is, and whether it is sound. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cjson/cJSON.h>

#include "engine/core/file.h"
#include "engine/image/oiio.h"
#include "engine/scene/envmap.h"
#include "neural/data/dataset.h"
#include "tools/check_dataset.h"
#include "tools/check_gbuffer.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/facts.h"
#include "tools/output.h"
#include "tools/weights.h"
#include "tools/world.h"

static void add_attributes(cJSON *facts, const struct pbnds_exr *exr)
{
    cJSON *object = cJSON_AddObjectToObject(facts, "attributes");
    for (int i = 0; i < exr->attribute_count; ++i) {
        const struct pbnds_exr_attribute *a = &exr->attributes[i];
        switch (a->type) {
        case PBNDS_EXR_ATTRIBUTE_STRING:
            tool_add_text(object, a->name, a->value.string);
            break;
        case PBNDS_EXR_ATTRIBUTE_TEXT:
            tool_add_text(object, a->name, a->value.text);
            break;
        case PBNDS_EXR_ATTRIBUTE_INT:
            tool_add_number(object, a->name, a->value.i);
            break;
        case PBNDS_EXR_ATTRIBUTE_FLOAT:
            tool_add_number(object, a->name, (double)a->value.f);
            break;
        case PBNDS_EXR_ATTRIBUTE_M44F:
            tool_add_floats(object, a->name, a->value.m44, 16);
            break;
        }
    }
}

static enum pbnds_status describe_image(const char *path, cJSON *facts,
                                        struct pbnds_error *error)
{
    struct pbnds_image image;
    PBNDS_TRY(pbnds_image_read_rgb(path, &image, error));
    struct pbnds_envmap *envmap = NULL;
    const enum pbnds_status status =
        pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &envmap, error);
    if (status == PBNDS_OK) {
        const size_t count = 3 * (size_t)image.width * (size_t)image.height;
        float top = 0.0f;
        for (size_t i = 0; i < count; ++i)
            top = fmaxf(top, image.data[i]);
        tool_add_text(facts, "kind",
                      image.width == 2 * image.height ? "light map (equirect)"
                                                      : "picture");
        tool_add_size(facts, image.width, image.height);
        tool_add_vec3(facts, "mean", pbnds_envmap_mean(envmap));
        tool_add_floats(facts, "max", &top, 1);
    }
    pbnds_envmap_free(envmap);
    pbnds_image_free(&image);
    return status;
}

static enum pbnds_status describe_exr(const char *path, cJSON *facts,
                                      struct pbnds_error *error)
{
    struct pbnds_exr exr;
    const enum pbnds_status status = pbnds_exr_read(path, &exr, error);
    /* Light maps with lossy compression or tiles are read by the other library. */
    if (status == PBNDS_ERROR_UNSUPPORTED) return describe_image(path, facts, error);
    if (status != PBNDS_OK) return status;
    if (!pbnds_exr_find(&exr, "albedo.R")) {
        pbnds_exr_free(&exr);
        return describe_image(path, facts, error);
    }
    tool_add_text(facts, "kind", "G-buffer");
    tool_add_size(facts, exr.width, exr.height);
    cJSON *channels = cJSON_AddArrayToObject(facts, "channels");
    static const char *const types[] = {"uint", "half", "float"};
    for (int i = 0; i < exr.channel_count; ++i) {
        cJSON *item = tool_add_item(channels);
        tool_add_text(item, "name", exr.channels[i].name);
        tool_add_text(item, "type", types[exr.channels[i].type]);
    }
    add_attributes(facts, &exr);
    pbnds_exr_free(&exr);
    return PBNDS_OK;
}

static enum pbnds_status check_sheet_name(const char *path, struct pbnds_error *error)
{
    if (!tool_has_extension(path, ".png")) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: a contact sheet is written as .png", path);
    }
    return tool_output_check(path, error);
}

/* What the file is is said by its name; that it is so, by reading it. */
static enum pbnds_status describe(const struct tool_options *options, bool deep,
                                  cJSON *facts, struct pbnds_error *error)
{
    const char *path = options->inputs[0];
    struct stat info;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode)) {
        if (options->output) PBNDS_TRY(check_sheet_name(options->output, error));
        PBNDS_TRY(tool_describe_dataset(options, !deep, facts, error));
        return PBNDS_OK;
    }
    if (options->output) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "info: -o is for the contact sheet of a data set, which %s is "
            "not",
            path);
    }
    if (tool_has_extension(path, ".glb") || tool_has_extension(path, ".gltf")) {
        return tool_describe_scene(options, path, facts, error);
    }
    if (tool_has_extension(path, ".exr")) {
        return describe_exr(path, facts, error);
    }
    if (tool_has_extension(path, ".safetensors")) {
        return tool_describe_weights(path, options->json, facts, error);
    }
    if (tool_has_extension(path, ".hdr") || tool_has_extension(path, ".png") ||
        tool_has_extension(path, ".jpg") || tool_has_extension(path, ".jpeg")) {
        return describe_image(path, facts, error);
    }
    return pbnds_fail(
        error, PBNDS_ERROR_UNSUPPORTED,
        "%s: is none of .glb, .gltf, .exr, .hdr, .png, .jpg, .safetensors or a "
        "data set folder",
        path);
}

/* One line a fact; what has parts goes on the lines below it. */
static void print_facts(const cJSON *facts, int indent)
{
    for (const cJSON *at = facts->child; at; at = at->next) {
        const bool table = cJSON_IsObject(at) || (cJSON_IsArray(at) && at->child &&
                                                  cJSON_IsObject(at->child));
        if (table && cJSON_IsArray(at)) {
            (void)printf("%*s%s: %d\n", indent, "", at->string, cJSON_GetArraySize(at));
            for (const cJSON *item = at->child; item; item = item->next) {
                char *line = cJSON_PrintUnformatted(item);
                (void)printf("%*s%s\n", indent + 2, "", line ? line : "");
                cJSON_free(line);
            }
        } else if (table) {
            (void)printf("%*s%s:\n", indent, "", at->string);
            print_facts(at, indent + 2);
        } else if (cJSON_IsString(at)) {
            pbnds_plain_text(at->valuestring); /* it may come from the file */
            (void)printf("%*s%s: %s\n", indent, "", at->string, at->valuestring);
        } else {
            char *line = cJSON_PrintUnformatted(at);
            (void)printf("%*s%s: %s\n", indent, "", at->string, line ? line : "");
            cJSON_free(line);
        }
    }
}

static enum pbnds_status run_info(const struct tool_options *options,
                                  struct pbnds_error *error)
{
    cJSON *facts = cJSON_CreateObject();
    if (!facts) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory");
    tool_add_text(facts, "file", options->inputs[0]);
    const enum pbnds_status status = describe(options, false, facts, error);
    if (status == PBNDS_OK && options->json) {
        char *text = cJSON_Print(facts);
        (void)printf("%s\n", text ? text : "{}");
        cJSON_free(text);
    } else if (status == PBNDS_OK) {
        print_facts(facts, 0);
    }
    cJSON_Delete(facts);
    return status;
}

static enum pbnds_status run_check(const struct tool_options *options,
                                   struct pbnds_error *error)
{
    struct stat info;
    if (stat(options->inputs[0], &info) == 0 && S_ISDIR(info.st_mode))
        return tool_check_dataset(options->inputs[0], options->json, error);
    cJSON *facts = cJSON_CreateObject();
    if (!facts) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory");
    enum pbnds_status status = describe(options, true, facts, error);
    const cJSON *item = cJSON_GetObjectItem(facts, "kind");
    const char *kind = cJSON_IsString(item) ? item->valuestring : "file";
    if (status == PBNDS_OK && strcmp(kind, "G-buffer") == 0) {
        status = tool_check_gbuffer(options->inputs[0], options->json, error);
    } else if (status == PBNDS_OK && strcmp(kind, "weights") == 0) {
        status = tool_check_weights(options->inputs[0], options->json, error);
    } else if (status == PBNDS_OK && options->json) {
        tool_json_result(options->inputs[0], 1, "sound", 1.0);
    } else if (status == PBNDS_OK) {
        (void)printf("%s: %s, sound\n", options->inputs[0], kind);
    }
    cJSON_Delete(facts);
    return status;
}

const struct tool_command tool_info = {
    .name = "info",
    .mask = TOOL_INFO,
    .min_inputs = 1,
    .max_inputs = 1,
    .needs_output = false,
    .usage = "info FILE [--json]",
    .about = "says what a file is",
    .details =
        "FILE is a scene (.glb, .gltf), a G-buffer (.exr), a light map (.hdr, .exr), "
        "a\n"
        "weights file (.safetensors; its model, features and training) or a data set "
        "folder; of\n"
        "that, statistics of its pixels, and with -o a contact sheet of 64 "
        "samples.\n\n"
        "  pbnds info data/ -o sheet.png\n"
        "  pbnds info scene.glb\n"
        "  pbnds info transport.safetensors --json",
    .run = run_info,
};

const struct tool_command tool_check = {
    .name = "check",
    .mask = TOOL_CHECK,
    .min_inputs = 1,
    .max_inputs = 1,
    .needs_output = false,
    .usage = "check FILE [--json]",
    .about = "reads a file through and says what is wrong with it",
    .details = "Takes what 'pbnds info' takes and reads all of it: every tensor of a "
               "weights file\n"
               "against its model; every file of a data set against its hash, and that "
               "no scene or\n"
               "light map is in two splits. Of G-buffers it looks at every "
               "pixel: unit normals\n"
               "that face the eye, depth that agrees with position, ranges, NaN, ids, "
               "mattes; each\n"
               "finding with the number of pixels and the first of them.\n"
               "Status 3: it is not sound; warnings alone leave 0.\n\n"
               "  pbnds check g.exr\n"
               "  pbnds check data/",
    .run = run_check,
};
