#include "tools/output.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/image/oiio.h"
#include "tools/console.h"

enum pbnds_status tool_output_check(const char *path, struct pbnds_error *error)
{
    struct pbnds_file_writer writer;
    PBNDS_TRY(pbnds_file_begin(&writer, path, error));
    pbnds_file_abort(&writer);
    return PBNDS_OK;
}

enum pbnds_status tool_picture_check(const char *path, struct pbnds_error *error)
{
    if (!tool_has_extension(path, ".exr") && !tool_has_extension(path, ".png")) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: a picture is written as .exr or .png", path);
    }
    return tool_output_check(path, error);
}

enum pbnds_status tool_folder_check(const char *folder, struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_make_folder(folder, error));
    char probe[1400];
    if (snprintf(probe, sizeof probe, "%s/probe", folder) >= (int)sizeof probe) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: is too long a name",
                          folder);
    }
    struct pbnds_file_writer writer;
    if (pbnds_file_begin(&writer, probe, NULL) != PBNDS_OK) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "%s: no file can be made in this folder; choose another",
                          folder);
    }
    pbnds_file_abort(&writer);
    return PBNDS_OK;
}

void tool_background(const struct tool_world *world, bool light_map,
                     const struct pbnds_image *alpha, struct pbnds_image *radiance)
{
    const struct pbnds_gbuffer *g = &world->gbuffer;
    const float *coverage = alpha && alpha->data ? alpha->data : g->coverage;
    for (int y = 0; y < g->height; ++y) {
        for (int x = 0; x < g->width; ++x) {
            const float c = coverage[(size_t)y * (size_t)g->width + (size_t)x];
            if (c >= 1.0f) continue;
            struct pbnds_vec3 l = {0.0f, 0.0f, 0.0f};
            if (light_map && world->envmap) {
                const struct pbnds_ray ray = pbnds_camera_ray(
                    &g->camera, g->width, g->height, (float)x + 0.5f, (float)y + 0.5f);
                l = pbnds_envmap_eval(world->envmap, ray.direction);
            }
            float *pixel = pbnds_image_at(radiance, x, y);
            pixel[0] = c * pixel[0] + (1.0f - c) * l.x;
            pixel[1] = c * pixel[1] + (1.0f - c) * l.y;
            pixel[2] = c * pixel[2] + (1.0f - c) * l.z;
        }
    }
}

enum pbnds_status tool_displayed(const struct pbnds_image *radiance,
                                 const struct pbnds_display *display,
                                 struct pbnds_image *shown, struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_image_init(shown, radiance->width, radiance->height, 3, error));
    pbnds_display_image(display, radiance, shown);
    return PBNDS_OK;
}

/* Planes of an image as channels of a file. */
static void add_planes(struct pbnds_exr_channel *channels, int *count, float **plane,
                       const char *prefix, const char *names,
                       const struct pbnds_image *image)
{
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    const size_t n = (size_t)image->channels;
    for (size_t c = 0; c < n; ++c, *plane += pixels) {
        struct pbnds_exr_channel *channel = &channels[(*count)++];
        (void)snprintf(channel->name, sizeof channel->name, "%s%c", prefix, names[c]);
        channel->type = PBNDS_EXR_FLOAT;
        channel->data = *plane;
        for (size_t i = 0; i < pixels; ++i)
            (*plane)[i] = image->data[n * i + c];
    }
}

static enum pbnds_status write_exr(const char *path, const struct tool_world *world,
                                   const struct pbnds_image *radiance,
                                   const struct pbnds_image *alpha,
                                   const struct pbnds_image *variance,
                                   struct pbnds_error *error)
{
    struct pbnds_exr_channel extra[4];
    int count = 0;
    const size_t pixels = (size_t)radiance->width * (size_t)radiance->height;
    const bool has_alpha = alpha && alpha->data,
               has_variance = variance && variance->data;
    const size_t planes = (has_alpha ? 1u : 0u) + (has_variance ? 3u : 0u);
    float *data = NULL;
    if (planes > 0) {
        data = malloc(planes * pixels * sizeof *data);
        if (!data)
            return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for %zu planes",
                              path, planes);
        float *plane = data;
        if (has_alpha) add_planes(extra, &count, &plane, "", "A", alpha);
        if (has_variance)
            add_planes(extra, &count, &plane, "variance.", "RGB", variance);
    }
    const enum pbnds_status status =
        pbnds_gbuffer_write(path, &world->gbuffer, &world->origin, radiance, extra,
                            count, PBNDS_EXR_ZIP, error);
    free(data);
    return status;
}

enum pbnds_status tool_picture_write(const char *path, const struct tool_world *world,
                                     const struct pbnds_image *radiance,
                                     const struct pbnds_image *alpha,
                                     const struct pbnds_image *variance,
                                     const struct pbnds_display *display,
                                     struct pbnds_error *error)
{
    if (tool_has_extension(path, ".exr"))
        return write_exr(path, world, radiance, alpha, variance, error);
    struct pbnds_image shown = {0, 0, 0, NULL};
    PBNDS_TRY(tool_displayed(radiance, display, &shown, error));
    const enum pbnds_status status = pbnds_png_write(path, &shown, error);
    pbnds_image_free(&shown);
    return status;
}

void tool_json_string(FILE *file, const char *text)
{
    (void)fputc('"', file);
    for (const unsigned char *at = (const unsigned char *)text; *at; ++at) {
        if (*at == '"' || *at == '\\') {
            (void)fprintf(file, "\\%c", *at);
        } else if (*at < 0x20) {
            (void)fprintf(file, "\\u%04x", *at);
        } else {
            (void)fputc(*at, file);
        }
    }
    (void)fputc('"', file);
}

void tool_json_number(FILE *file, double value)
{
    if (isfinite(value)) {
        (void)fprintf(file, "%.9g", value);
    } else {
        (void)fputs("null", file);
    }
}

enum pbnds_status tool_text_begin(struct tool_text *text, struct pbnds_error *error)
{
    *text = (struct tool_text){NULL, NULL, 0};
    text->file = open_memstream(&text->data, &text->size);
    if (!text->file)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a text");
    return PBNDS_OK;
}

enum pbnds_status tool_text_end(struct tool_text *text, const char *path,
                                struct pbnds_error *error)
{
    enum pbnds_status status = PBNDS_OK;
    const bool broken = ferror(text->file) != 0;
    if (fclose(text->file) != 0 || broken) {
        status =
            pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its text", path);
    } else if (strcmp(path, "-") == 0) {
        (void)fwrite(text->data, 1, text->size,
                     stdout); /* checked when the program ends */
    } else {
        status = pbnds_file_write(path, text->data, text->size, error);
    }
    free(text->data);
    *text = (struct tool_text){NULL, NULL, 0};
    return status;
}

void tool_json_result(const char *output, int count, ...)
{
    (void)printf("{\"output\": ");
    tool_json_string(stdout, output);
    va_list pairs;
    va_start(pairs, count);
    for (int i = 0; i < count; ++i) {
        (void)printf(", \"%s\": ", va_arg(pairs, const char *));
        tool_json_number(stdout, va_arg(pairs, double));
    }
    va_end(pairs);
    (void)printf("}\n");
}
