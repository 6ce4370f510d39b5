#include "engine/shade/import_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/color.h"
#include "engine/core/file.h"
#include "engine/image/exr.h"
#include "engine/image/oiio.h"

static bool ends_with(const char *path, const char *extension)
{
    const size_t n = strlen(path), m = strlen(extension);
    return n > m && strcmp(path + n - m, extension) == 0;
}

static enum pbnds_status fail_memory(const char *path, struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its pixels", path);
}

/* A plane of the file, by the last part of its name. */
static const float *exr_plane(const struct pbnds_exr *exr, const char *part)
{
    for (int i = 0; i < exr->channel_count; ++i) {
        const struct pbnds_exr_channel *c = &exr->channels[i];
        const char *dot = strrchr(c->name, '.');
        if (c->type != PBNDS_EXR_UINT && strcmp(dot ? dot + 1 : c->name, part) == 0)
            return c->data;
    }
    return NULL;
}

static enum pbnds_status copy_exr(const struct pbnds_exr *exr, const char *path,
                                  struct pbnds_import_map *map,
                                  struct pbnds_error *error)
{
    const float *planes[4] = {exr_plane(exr, "R"), exr_plane(exr, "G"),
                              exr_plane(exr, "B"), exr_plane(exr, "A")};
    if (!planes[0] || !planes[1] || !planes[2]) {
        planes[0] = exr_plane(exr, "X");
        planes[1] = exr_plane(exr, "Y");
        planes[2] = exr_plane(exr, "Z");
    }
    if (!planes[0] || !planes[1] || !planes[2]) { /* a value: the only channel */
        const float *only = exr->channel_count == 1 ? exr->channels[0].data : NULL;
        if (exr->channel_count == 1 && exr->channels[0].type == PBNDS_EXR_UINT)
            only = NULL;
        static const char *const values[] = {"Y", "Z", "V", "R"};
        for (int k = 0; k < 4 && !only; ++k)
            only = exr_plane(exr, values[k]);
        planes[0] = planes[1] = planes[2] = only;
    }
    if (!planes[0]) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: has neither R, G and B nor X, Y and Z nor a single "
                          "channel; name its channels so",
                          path);
    }
    const size_t count = (size_t)exr->width * (size_t)exr->height;
    map->rgba = malloc(4 * count * sizeof *map->rgba);
    if (!map->rgba) return fail_memory(path, error);
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 4; ++c)
            map->rgba[4 * i + c] = planes[c] ? planes[c][i] : 1.0f;
    }
    map->width = exr->width;
    map->height = exr->height;
    map->bits = 32;
    return PBNDS_OK;
}

static enum pbnds_status copy_pixels(struct pbnds_pixels *pixels, const char *path,
                                     struct pbnds_import_map *map,
                                     struct pbnds_error *error)
{
    const size_t count = 4 * (size_t)pixels->width * (size_t)pixels->height;
    map->width = pixels->width;
    map->height = pixels->height;
    map->integer = !ends_with(path, ".hdr");
    map->bits = pixels->u8 ? 8 : 16;
    if (pixels->f32) { /* taken over */
        map->rgba = pixels->f32;
        pixels->f32 = NULL;
        return PBNDS_OK;
    }
    map->rgba = malloc(count * sizeof *map->rgba);
    if (!map->rgba) return fail_memory(path, error);
    for (size_t i = 0; i < count; ++i)
        map->rgba[i] = (float)pixels->u8[i] / 255.0f;
    return PBNDS_OK;
}

enum pbnds_status pbnds_import_map_load(const char *path, struct pbnds_import_map *map,
                                        struct pbnds_error *error)
{
    *map = (struct pbnds_import_map){0, 0, NULL, false, 0};
    enum pbnds_status status;
    if (ends_with(path, ".exr")) {
        struct pbnds_exr exr;
        PBNDS_TRY(pbnds_exr_read(path, &exr, error));
        status = copy_exr(&exr, path, map, error);
        pbnds_exr_free(&exr);
        return status;
    }
    uint8_t *bytes = NULL;
    size_t size = 0;
    PBNDS_TRY(pbnds_file_read(path, (size_t)1 << 30, &bytes, &size, error));
    struct pbnds_pixels pixels;
    status = pbnds_pixels_decode(bytes, size, path, &pixels, error);
    free(bytes);
    if (status != PBNDS_OK) return status;
    status = copy_pixels(&pixels, path, map, error);
    pbnds_pixels_free(&pixels);
    return status;
}

void pbnds_import_map_free(struct pbnds_import_map *map)
{
    free(map->rgba);
    *map = (struct pbnds_import_map){0, 0, NULL, false, 0};
}

enum pbnds_status pbnds_import_map_finite(const struct pbnds_import_map *map,
                                          const char *path, bool infinity,
                                          struct pbnds_error *error)
{
    const size_t width = (size_t)map->width, count = width * (size_t)map->height;
    for (size_t i = 0; i < 4 * count; ++i) {
        if (isfinite(map->rgba[i]) || (infinity && map->rgba[i] > 0.0f)) continue;
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is not a finite number at pixel (%zu, %zu); write it "
                          "again without",
                          path, i / 4 % width, i / 4 / width);
    }
    return PBNDS_OK;
}

struct pbnds_vec3 pbnds_import_map_color(const struct pbnds_import_map *map, size_t i)
{
    const float *p = map->rgba + 4 * i;
    if (!map->integer) return pbnds_vec3_make(p[0], p[1], p[2]);
    return pbnds_vec3_make(pbnds_srgb_decode(p[0]), pbnds_srgb_decode(p[1]),
                           pbnds_srgb_decode(p[2]));
}
