/* Maps of materials, by path or in a folder; names, encodings and defaults are in import.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "engine/shade/gbuffer_planes.h"
#include "engine/shade/import.h"
#include "engine/shade/import_map.h"

enum {
    ALBEDO = PBNDS_IMPORT_ALBEDO,
    NORMAL = PBNDS_IMPORT_NORMAL,
    ROUGHNESS = PBNDS_IMPORT_ROUGHNESS,
    METALLIC = PBNDS_IMPORT_METALLIC,
    SPECULAR = PBNDS_IMPORT_SPECULAR,
    DEPTH = PBNDS_IMPORT_DEPTH,
    MASK = PBNDS_IMPORT_MASK,
    EMISSION = PBNDS_IMPORT_EMISSION,
    AO = PBNDS_IMPORT_AO,
    PHOTO = PBNDS_IMPORT_PHOTO,
    MAPS = PBNDS_IMPORT_MAPS,
};

static const char *const map_names[MAPS] = {
    "albedo", "normal", "roughness", "metallic", "specular",
    "depth",  "mask",   "emission",  "ao",       "photo"};

static const char *const extensions[] = {".exr",  ".png",  ".jpg",
                                         ".jpeg", ".webp", ".hdr"};

struct job {
    const struct pbnds_import_paths *paths;
    struct pbnds_import_map maps[MAPS];
    const struct pbnds_import_map
        *mask; /* whose channel says what is covered, or NULL */
    int mask_name, mask_channel;
    struct pbnds_gbuffer *gbuffer;
    struct pbnds_image *photo;
    struct pbnds_import_notes *notes;
    size_t no_depth; /* pixels that the mask covers and the depth does not */
};

static void find_file(const char *folder, int name, struct pbnds_import_paths *paths)
{
    const size_t room = sizeof paths->path[name];
    char *path = paths->path[name];
    for (size_t e = 0; e < sizeof extensions / sizeof extensions[0]; ++e) {
        struct stat info;
        const int n =
            snprintf(path, room, "%s/%s%s", folder, map_names[name], extensions[e]);
        if (n > 0 && (size_t)n < room && stat(path, &info) == 0 &&
            S_ISREG(info.st_mode))
            return;
    }
    path[0] = 0;
}

static enum pbnds_status fail_memory(const char *path, struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its pixels", path);
}

static enum pbnds_status check_map(const struct job *job, int name,
                                   struct pbnds_error *error)
{
    const struct pbnds_import_map *map = &job->maps[name];
    const char *path = job->paths->path[name];
    for (int other = 0; other < name; ++other) {
        const struct pbnds_import_map *m = &job->maps[other];
        if (!m->rgba || (m->width == map->width && m->height == map->height)) continue;
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "%s: is %d x %d pixels and %s %d x %d; give all maps one size", path,
            map->width, map->height, job->paths->path[other], m->width, m->height);
    }
    if (name == DEPTH && map->integer && map->bits == 8) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: 8 bits are too coarse for depth; store millimetres in "
                          "16 bits, or metres as .exr",
                          path);
    }
    /* depth may say "nothing" by infinity */
    return pbnds_import_map_finite(map, path, name == DEPTH, error);
}

static bool has_alpha(const struct pbnds_import_map *map)
{
    const size_t count = (size_t)map->width * (size_t)map->height;
    for (size_t i = 0; map->rgba && i < count; ++i) {
        if (map->rgba[4 * i + 3] < 1.0f) return true;
    }
    return false;
}

/* The mask, else the alpha of the photograph where it has one, else the albedo's. */
static void choose_mask(struct job *job)
{
    job->mask_channel = 3;
    job->mask_name = has_alpha(&job->maps[PHOTO]) ? PHOTO : ALBEDO;
    if (job->maps[MASK].rgba) {
        job->mask_channel = 0;
        job->mask_name = MASK;
    }
    job->mask = job->maps[job->mask_name].rgba ? &job->maps[job->mask_name] : NULL;
}

static enum pbnds_status load_maps(struct job *job, struct pbnds_error *error)
{
    for (int name = 0; name < MAPS; ++name) {
        if (!job->paths->path[name][0]) continue;
        PBNDS_TRY(
            pbnds_import_map_load(job->paths->path[name], &job->maps[name], error));
        PBNDS_TRY(check_map(job, name, error));
    }
    choose_mask(job);
    return PBNDS_OK;
}

static float value_at(const struct pbnds_import_map *map, size_t i, float otherwise)
{
    return map->rgba ? pbnds_clamp(map->rgba[4 * i], 0.0f, 1.0f) : otherwise;
}

/* Metres; +inf: nothing. */
static float depth_at(const struct pbnds_import_map *map, size_t i)
{
    if (!map->rgba) return 1.0f;
    const float metres = map->rgba[4 * i] * (map->integer ? 65.535f : 1.0f);
    return metres > 0.0f && metres < 1e10f ? metres : INFINITY;
}

static float mask_at(const struct job *job, size_t i)
{
    if (!job->mask) return 1.0f;
    return pbnds_clamp(job->mask->rgba[4 * i + (size_t)job->mask_channel], 0.0f, 1.0f);
}

static struct pbnds_vec3 normal_at(const struct pbnds_import_map *map, size_t i,
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
    const struct pbnds_import_map *maps = job->maps;
    const struct pbnds_vec3 color =
        maps[ALBEDO].rgba ? clamp3(pbnds_import_map_color(&maps[ALBEDO], i), 1.0f)
                          : pbnds_splat(0.5f);
    store(g->albedo, i, color);
    const float metallic = value_at(&maps[METALLIC], i, 0.0f);
    g->metallic[i] = metallic;
    g->roughness[i] = value_at(&maps[ROUGHNESS], i, 0.5f);
    g->specular[i] =
        value_at(&maps[SPECULAR], i,
                 0.04f * (1.0f - metallic) + metallic * pbnds_luminance(color));
    if (maps[EMISSION].rgba)
        store(g->emission, i,
              clamp3(pbnds_import_map_color(&maps[EMISSION], i), 1e20f));
    if (g->ao) g->ao[i] = value_at(&maps[AO], i, 1.0f);
}

static void fill_pixel(struct job *job, const struct pbnds_camera_view *view, int x,
                       int y)
{
    struct pbnds_gbuffer *g = job->gbuffer;
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    const float depth = depth_at(&job->maps[DEPTH], i), mask = mask_at(job, i);
    if (isinf(depth) || mask == 0.0f) {
        job->no_depth += mask > 0.0f;
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
    if (job->photo->data) {
        const struct pbnds_vec3 c =
            clamp3(pbnds_import_map_color(&job->maps[PHOTO], i), 1e20f);
        float *pixel = job->photo->data + 3 * i;
        pixel[0] = c.x;
        pixel[1] = c.y;
        pixel[2] = c.z;
    }
}

/* Is the depth of all that is covered one number, so that it says nothing? */
static bool depth_is_constant(const struct pbnds_gbuffer *g)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    float lo = INFINITY, hi = 0.0f;
    for (size_t i = 0; i < count; ++i) {
        if (isinf(g->depth[i])) continue;
        lo = fminf(lo, g->depth[i]);
        hi = fmaxf(hi, g->depth[i]);
    }
    return lo == hi;
}

static void note_depth(const struct job *job)
{
    if (!job->maps[DEPTH].rgba) return;
    if (depth_is_constant(job->gbuffer))
        pbnds_import_note(job->notes, "depth: is the same everywhere, so the positions "
                                      "lie in a plane");
    if (job->no_depth > 0)
        pbnds_import_note(job->notes,
                          "depth: %zu pixels that the mask covers have none and show "
                          "nothing",
                          job->no_depth);
}

static void note_photo(const struct job *job)
{
    if (job->photo->data)
        pbnds_import_note(job->notes, "photo: kept as R, G, B, %s",
                          job->maps[PHOTO].integer ? "display-referred"
                                                   : "linear radiance");
}

static void note_maps(const struct job *job, const struct pbnds_camera *camera)
{
    static const char *const defaults[MAPS] = {"0.5 everywhere",
                                               "faces the camera's plane everywhere",
                                               "0.5 everywhere",
                                               "0 everywhere",
                                               "0.04, albedo where metallic",
                                               "1 m everywhere",
                                               NULL,
                                               "0",
                                               NULL,
                                               NULL};
    for (int name = 0; name < MAPS; ++name) {
        const struct pbnds_import_map *map = &job->maps[name];
        if (map->rgba) {
            const char *slash = strrchr(job->paths->path[name], '/');
            pbnds_import_note(job->notes, "%s: from %.120s", map_names[name],
                              slash ? slash + 1 : job->paths->path[name]);
        } else if (name == MASK) {
            pbnds_import_note(job->notes, "mask: %s%s, there is no such map",
                              job->mask ? map_names[job->mask_name] : "1 everywhere",
                              job->mask ? "'s alpha" : "");
        } else if (defaults[name]) {
            pbnds_import_note(job->notes, "%s: %s, there is no such map",
                              map_names[name], defaults[name]);
        }
    }
    note_depth(job);
    note_photo(job);
    pbnds_import_note(job->notes,
                      "camera: at the origin, looks along -z, %.2f degrees vertically",
                      (double)(camera->yfov * 180.0f / PBNDS_PI));
}

static struct pbnds_camera camera_of(const struct pbnds_import_options *options,
                                     int width, int height)
{
    struct pbnds_import_options straight = {.yfov = options->yfov};
    if (options->xfov > 0.0f) {
        straight.yfov =
            2.0f * atanf(tanf(0.5f * options->xfov) * (float)height / (float)width);
    }
    return pbnds_import_camera(&straight);
}

static enum pbnds_status fill(struct job *job,
                              const struct pbnds_import_options *options,
                              struct pbnds_error *error)
{
    PBNDS_TRY(load_maps(job, error));
    const struct pbnds_import_map *size =
        &job->maps[job->maps[ALBEDO].rgba ? ALBEDO : NORMAL];
    const struct pbnds_camera camera = camera_of(options, size->width, size->height);
    PBNDS_TRY(pbnds_gbuffer_allocate(job->gbuffer, size->width, size->height,
                                     job->maps[AO].rgba ? PBNDS_OPTIONAL_AO : 0u, false,
                                     error));
    if (job->maps[PHOTO].rgba)
        PBNDS_TRY(pbnds_image_init(job->photo, size->width, size->height, 3, error));
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

enum pbnds_status pbnds_import_maps(
    const struct pbnds_import_paths *paths, const struct pbnds_import_options *options,
    struct pbnds_gbuffer *gbuffer, struct pbnds_image *photo, enum pbnds_target *target,
    struct pbnds_import_notes *notes, struct pbnds_error *error)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    memset(notes, 0, sizeof *notes);
    *photo = (struct pbnds_image){0, 0, 0, NULL};
    if (!paths->path[ALBEDO][0] && !paths->path[NORMAL][0]) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "neither albedo nor normal is given; one of them is needed");
    }
    struct job *job = calloc(1, sizeof *job);
    if (!job) return fail_memory("maps", error);
    job->paths = paths;
    job->gbuffer = gbuffer;
    job->photo = photo;
    job->notes = notes;
    const enum pbnds_status status = fill(job, options, error);
    *target = job->maps[PHOTO].integer ? PBNDS_TARGET_DISPLAY : PBNDS_TARGET_RADIANCE;
    for (int name = 0; name < MAPS; ++name)
        pbnds_import_map_free(&job->maps[name]);
    free(job);
    if (status != PBNDS_OK) {
        pbnds_gbuffer_free(gbuffer);
        pbnds_image_free(photo);
    }
    return status;
}

enum pbnds_status
pbnds_import_images(const char *folder, const struct pbnds_import_options *options,
                    struct pbnds_gbuffer *gbuffer, struct pbnds_image *photo,
                    enum pbnds_target *target, struct pbnds_import_notes *notes,
                    struct pbnds_error *error)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    memset(notes, 0, sizeof *notes);
    *photo = (struct pbnds_image){0, 0, 0, NULL};
    struct stat info;
    if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode)) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "%s: is no folder that can be read; give one with the maps",
                          folder);
    }
    struct pbnds_import_paths *paths = calloc(1, sizeof *paths);
    if (!paths) return fail_memory(folder, error);
    for (int name = 0; name < MAPS; ++name)
        find_file(folder, name, paths);
    enum pbnds_status status;
    if (paths->path[ALBEDO][0] || paths->path[NORMAL][0]) {
        status =
            pbnds_import_maps(paths, options, gbuffer, photo, target, notes, error);
    } else {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT,
                            "%s: has neither albedo nor normal (.exr, .png, .jpg, "
                            ".webp, .hdr); name the maps so",
                            folder);
    }
    free(paths);
    return status;
}
