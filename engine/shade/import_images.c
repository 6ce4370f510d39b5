/* Folders of material maps; names, encodings and defaults are in import.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "engine/core/color.h"
#include "engine/core/file.h"
#include "engine/image/oiio.h"
#include "engine/shade/gbuffer_planes.h"
#include "engine/shade/import.h"

enum map_name {
    ALBEDO,
    NORMAL,
    ROUGHNESS,
    METALLIC,
    SPECULAR,
    DEPTH,
    MASK,
    EMISSION,
    AO,
    MAPS,
};

static const char *const map_names[MAPS] = {"albedo",   "normal",   "roughness",
                                            "metallic", "specular", "depth",
                                            "mask",     "emission", "ao"};

static const char *const extensions[] = {".exr",  ".png",  ".jpg",
                                         ".jpeg", ".webp", ".hdr"};

/* One map as it is stored: four floats a pixel, grey replicated, alpha 1 by default. */
struct map {
    int width, height;
    float *rgba;  /* owned; NULL: there is none */
    bool integer; /* 8 or 16 bit: display-encoded where it is a colour, [0, 1] */
    int bits;
};

struct job {
    const char *folder;
    struct map maps[MAPS];
    char paths[MAPS][1400];
    struct pbnds_gbuffer *gbuffer;
    struct pbnds_import_notes *notes;
};

static bool find_file(struct job *job, enum map_name name)
{
    for (size_t e = 0; e < sizeof extensions / sizeof extensions[0]; ++e) {
        char *path = job->paths[name];
        struct stat info;
        const int n = snprintf(path, sizeof job->paths[name], "%s/%s%s", job->folder,
                               map_names[name], extensions[e]);
        if (n < (int)sizeof job->paths[name] && stat(path, &info) == 0 &&
            S_ISREG(info.st_mode))
            return true;
    }
    return false;
}

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
                                  struct map *map, struct pbnds_error *error)
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
                                     struct map *map, struct pbnds_error *error)
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

static enum pbnds_status load_map(const char *path, struct map *map,
                                  struct pbnds_error *error)
{
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

static enum pbnds_status check_map(const struct job *job, int name,
                                   struct pbnds_error *error)
{
    const struct map *map = &job->maps[name];
    const char *path = job->paths[name];
    for (int other = 0; other < name; ++other) {
        const struct map *m = &job->maps[other];
        if (!m->rgba || (m->width == map->width && m->height == map->height)) continue;
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "%s: is %d x %d pixels and %s %d x %d; give all maps one size", path,
            map->width, map->height, job->paths[other], m->width, m->height);
    }
    if (name == DEPTH && map->integer && map->bits == 8) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: 8 bits are too coarse for depth; store millimetres in "
                          "16 bits, or metres as .exr",
                          path);
    }
    const size_t width = (size_t)map->width, count = width * (size_t)map->height;
    for (size_t i = 0; i < 4 * count; ++i) {
        /* depth may say "nothing" by infinity */
        if (isfinite(map->rgba[i]) || (name == DEPTH && map->rgba[i] == INFINITY))
            continue;
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is not a finite number at pixel (%zu, %zu); write it "
                          "again without",
                          path, i / 4 % width, i / 4 / width);
    }
    return PBNDS_OK;
}

static enum pbnds_status load_maps(struct job *job, struct pbnds_error *error)
{
    for (int name = 0; name < MAPS; ++name) {
        if (!find_file(job, (enum map_name)name)) continue;
        PBNDS_TRY(load_map(job->paths[name], &job->maps[name], error));
        PBNDS_TRY(check_map(job, name, error));
    }
    if (job->maps[ALBEDO].rgba || job->maps[NORMAL].rgba) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: has neither albedo nor normal (.exr, .png, .jpg, .webp, "
                      ".hdr); name the maps so",
                      job->folder);
}

static struct pbnds_vec3 color_at(const struct map *map, size_t i)
{
    const float *p = map->rgba + 4 * i;
    if (!map->integer) return pbnds_vec3_make(p[0], p[1], p[2]);
    return pbnds_vec3_make(pbnds_srgb_decode(p[0]), pbnds_srgb_decode(p[1]),
                           pbnds_srgb_decode(p[2]));
}

static float value_at(const struct map *map, size_t i, float otherwise)
{
    return map->rgba ? pbnds_clamp(map->rgba[4 * i], 0.0f, 1.0f) : otherwise;
}

/* Metres; +inf: nothing. */
static float depth_at(const struct map *map, size_t i)
{
    if (!map->rgba) return 1.0f;
    const float metres = map->rgba[4 * i] * (map->integer ? 65.535f : 1.0f);
    return metres > 0.0f && metres < 1e10f ? metres : INFINITY;
}

static float mask_at(const struct job *job, size_t i)
{
    if (job->maps[MASK].rgba) return value_at(&job->maps[MASK], i, 1.0f);
    const struct map *albedo = &job->maps[ALBEDO];
    return albedo->rgba ? pbnds_clamp(albedo->rgba[4 * i + 3], 0.0f, 1.0f) : 1.0f;
}

static struct pbnds_vec3 normal_at(const struct map *map, size_t i,
                                   struct pbnds_vec3 wo)
{
    struct pbnds_vec3 n = {0.0f, 0.0f, 1.0f};
    if (map->rgba) {
        const float *p = map->rgba + 4 * i;
        const float scale = map->integer ? 2.0f : 1.0f,
                    off = map->integer ? 1.0f : 0.0f;
        n = pbnds_vec3_make(scale * p[0] - off, scale * p[1] - off, scale * p[2] - off);
    }
    const float square = pbnds_dot(n, n);
    n = square > 1e-6f && square < 1e30f ? pbnds_scale(n, 1.0f / sqrtf(square)) : wo;
    return pbnds_face_eye(n, wo);
}

static void store(float *const planes[3], size_t i, struct pbnds_vec3 v)
{
    planes[0][i] = v.x;
    planes[1][i] = v.y;
    planes[2][i] = v.z;
}

static struct pbnds_vec3 clamp3(struct pbnds_vec3 v, float most)
{
    return pbnds_vec3_make(pbnds_clamp(v.x, 0.0f, most), pbnds_clamp(v.y, 0.0f, most),
                           pbnds_clamp(v.z, 0.0f, most));
}

static void fill_material(const struct job *job, size_t i)
{
    struct pbnds_gbuffer *g = job->gbuffer;
    const struct map *maps = job->maps;
    const struct pbnds_vec3 color = maps[ALBEDO].rgba
                                        ? clamp3(color_at(&maps[ALBEDO], i), 1.0f)
                                        : pbnds_splat(0.5f);
    store(g->albedo, i, color);
    const float metallic = value_at(&maps[METALLIC], i, 0.0f);
    g->metallic[i] = metallic;
    g->roughness[i] = value_at(&maps[ROUGHNESS], i, 0.5f);
    g->specular[i] =
        value_at(&maps[SPECULAR], i,
                 0.04f * (1.0f - metallic) + metallic * pbnds_luminance(color));
    if (maps[EMISSION].rgba)
        store(g->emission, i, clamp3(color_at(&maps[EMISSION], i), 1e20f));
    if (g->ao) g->ao[i] = value_at(&maps[AO], i, 1.0f);
}

static void fill_pixel(const struct job *job, const struct pbnds_camera_view *view,
                       int x, int y)
{
    struct pbnds_gbuffer *g = job->gbuffer;
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    const float depth = depth_at(&job->maps[DEPTH], i), mask = mask_at(job, i);
    if (isinf(depth) || mask == 0.0f) {
        g->depth[i] = INFINITY;
        g->object_id[i] = UINT32_MAX;
        return;
    }
    const struct pbnds_ray ray =
        pbnds_camera_view_ray(view, (float)x + 0.5f, (float)y + 0.5f);
    const struct pbnds_vec3 wo = pbnds_scale(ray.direction, -1.0f);
    const struct pbnds_vec3 n = normal_at(&job->maps[NORMAL], i, wo);
    store(g->normal, i, n);
    store(g->geometric_normal, i, n);
    fill_material(job, i);
    g->coverage[i] = mask;
    g->depth[i] = depth;
    const float t = depth / pbnds_dot(ray.direction, view->forward);
    store(g->position, i, pbnds_mad(ray.origin, ray.direction, t));
    g->object_id[i] = 0;
}

static void note_maps(const struct job *job, const struct pbnds_camera *camera)
{
    static const char *const defaults[MAPS] = {"0.5 everywhere",
                                               "faces the camera's plane everywhere",
                                               "0.5 everywhere",
                                               "0 everywhere",
                                               "0.04, albedo where metallic",
                                               "1 m everywhere",
                                               "albedo's alpha",
                                               "0",
                                               NULL};
    for (int name = 0; name < MAPS; ++name) {
        const struct map *map = &job->maps[name];
        if (map->rgba) {
            const char *slash = strrchr(job->paths[name], '/');
            pbnds_import_note(job->notes, "%s: from %.120s", map_names[name],
                              slash ? slash + 1 : job->paths[name]);
        } else if (defaults[name]) {
            pbnds_import_note(job->notes, "%s: %s, there is no such map",
                              map_names[name],
                              name == MASK && !job->maps[ALBEDO].rgba ? "1 everywhere"
                                                                      : defaults[name]);
        }
    }
    pbnds_import_note(job->notes,
                      "camera: at the origin, looks along -z, %.2f degrees vertically",
                      (double)(camera->yfov * 180.0f / PBNDS_PI));
}

static enum pbnds_status fill(struct job *job,
                              const struct pbnds_import_options *options,
                              struct pbnds_error *error)
{
    PBNDS_TRY(load_maps(job, error));
    const struct map *size = &job->maps[job->maps[ALBEDO].rgba ? ALBEDO : NORMAL];
    const struct pbnds_import_options straight = {.yfov = options->yfov};
    const struct pbnds_camera camera = pbnds_import_camera(&straight);
    PBNDS_TRY(pbnds_gbuffer_allocate(job->gbuffer, size->width, size->height,
                                     job->maps[AO].rgba ? PBNDS_OPTIONAL_AO : 0u, false,
                                     error));
    job->gbuffer->camera = camera;
    const struct pbnds_camera_view view =
        pbnds_camera_view(&camera, size->width, size->height);
    for (int y = 0; y < size->height; ++y) {
        for (int x = 0; x < size->width; ++x)
            fill_pixel(job, &view, x, y);
    }
    note_maps(job, &camera);
    return PBNDS_OK;
}

enum pbnds_status pbnds_import_images(const char *folder,
                                      const struct pbnds_import_options *options,
                                      struct pbnds_gbuffer *gbuffer,
                                      struct pbnds_import_notes *notes,
                                      struct pbnds_error *error)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    memset(notes, 0, sizeof *notes);
    struct stat info;
    if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode)) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "%s: is no folder that can be read; give one with the maps",
                          folder);
    }
    struct job *job = calloc(1, sizeof *job);
    if (!job) return fail_memory(folder, error);
    job->folder = folder;
    job->gbuffer = gbuffer;
    job->notes = notes;
    const enum pbnds_status status = fill(job, options, error);
    for (int name = 0; name < MAPS; ++name)
        free(job->maps[name].rgba);
    free(job);
    return status;
}
