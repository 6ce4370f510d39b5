/* G-buffers from OpenEXR files: ours, and those of others that have our channels. */
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/shade/cryptomatte.h"
#include "engine/shade/gbuffer_channels.h"
#include "engine/shade/gbuffer_header.h"
#include "engine/shade/gbuffer_planes.h"

/* Blender writes 1e10 where nothing was hit. */
#define DEPTH_NOTHING 1e10f

/* The planes of a file by what they mean; optional ones may be NULL. */
struct sources {
    const float *albedo[3], *normal[3], *depth, *roughness;
    const float *specular, *metallic, *coverage, *position[3], *emission[3];
    const float *f0[3], *f90, *ao, *uv[2], *motion[2];
    const uint32_t *object_id, *material_id;
};

/* A file while it is read. */
struct reading {
    const char *path;
    const struct pbnds_exr *exr;
    struct pbnds_gbuffer *gbuffer;
    struct pbnds_gbuffer_origin origin;
    struct sources from;
};

static const float *float_plane(const struct pbnds_exr *exr, const char *name)
{
    const struct pbnds_exr_channel *c = pbnds_exr_find(exr, name);
    return c && c->type != PBNDS_EXR_UINT ? c->data : NULL;
}

static const uint32_t *uint_plane(const struct pbnds_exr *exr, const char *name)
{
    const struct pbnds_exr_channel *c = pbnds_exr_find(exr, name);
    return c && c->type == PBNDS_EXR_UINT ? c->data : NULL;
}

/* All planes of a layer, or none. */
static void float_layer(const struct pbnds_exr *exr, const char *layer,
                        const char *parts, const float *planes[])
{
    bool all = true;
    for (int c = 0; parts[c]; ++c) {
        char name[64];
        snprintf(name, sizeof name, "%s.%c", layer, parts[c]);
        planes[c] = float_plane(exr, name);
        all = all && planes[c];
    }
    for (int c = 0; parts[c] && !all; ++c)
        planes[c] = NULL;
}

/* One sentence with every channel that is missing. */
static enum pbnds_status check_channels(const struct reading *r,
                                        struct pbnds_error *error)
{
    char names[256] = "";
    int missing = 0;
    for (int i = 0; i < pbnds_gbuffer_channel_count(); ++i) {
        const struct pbnds_gbuffer_channel *c = pbnds_gbuffer_channel_at(i);
        if (!c->required || float_plane(r->exr, c->name)) continue;
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", missing ? ", " : "",
                 c->name);
        ++missing;
    }
    if (missing == 0) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: not a G-buffer: the channel%s %s %s missing (or not half or "
                      "float); add %s and try again",
                      r->path, missing > 1 ? "s" : "", names,
                      missing > 1 ? "are" : "is", missing > 1 ? "them" : "it");
}

static void find_sources(struct reading *r)
{
    struct sources *s = &r->from;
    const struct pbnds_exr *exr = r->exr;
    float_layer(exr, "albedo", "RGB", s->albedo);
    float_layer(exr, "normal", "XYZ", s->normal);
    float_layer(exr, "position", "XYZ", s->position);
    float_layer(exr, "emission", "RGB", s->emission);
    float_layer(exr, "f0", "RGB", s->f0);
    float_layer(exr, "uv", "UV", s->uv);
    float_layer(exr, "motion", "UV", s->motion);
    s->depth = float_plane(exr, "Z");
    s->roughness = float_plane(exr, "roughness.R");
    s->specular = float_plane(exr, "specular.R");
    s->metallic = float_plane(exr, "metallic.R");
    s->coverage = float_plane(exr, "coverage.A");
    s->ao = float_plane(exr, "ao.R");
    s->f90 = float_plane(exr, "f90.R");
    s->object_id = uint_plane(exr, "object_id");
    s->material_id = uint_plane(exr, "material_id");
}

static unsigned optional_planes(const struct sources *s)
{
    return (s->ao ? PBNDS_OPTIONAL_AO : 0u) | (s->uv[0] ? PBNDS_OPTIONAL_UV : 0u) |
           (s->motion[0] ? PBNDS_OPTIONAL_MOTION : 0u) |
           (s->material_id ? PBNDS_OPTIONAL_MATERIAL_ID : 0u);
}

static enum pbnds_status fail_value(const struct reading *r, const char *channel,
                                    size_t i, float value, struct pbnds_error *error)
{
    const size_t width = (size_t)r->exr->width;
    return pbnds_fail(
        error, PBNDS_ERROR_FORMAT, "%s: channel %s is %g at pixel (%zu, %zu); %s",
        r->path, channel, (double)value, i % width, i / width,
        strcmp(channel, "Z") == 0 ? "depth must be positive, +inf where nothing was hit"
                                  : "write finite numbers only");
}

static bool is_hit(const struct reading *r, size_t i)
{
    if (r->from.coverage && r->from.coverage[i] == 0.0f) return false;
    return r->from.depth[i] < DEPTH_NOTHING;
}

/* Required channels and coverage everywhere, the others where something was hit. */
static enum pbnds_status check_channel(const struct reading *r,
                                       const struct pbnds_gbuffer_channel *c,
                                       struct pbnds_error *error)
{
    const float *plane = float_plane(r->exr, c->name);
    if (!plane || c->kind == PBNDS_CHANNEL_ID) return PBNDS_OK;
    const bool everywhere = c->required || plane == r->from.coverage;
    const bool depth = plane == r->from.depth;
    const size_t count = (size_t)r->exr->width * (size_t)r->exr->height;
    for (size_t i = 0; i < count; ++i) {
        if (isfinite(plane[i]) || (depth && plane[i] > 0.0f)) continue;
        if (everywhere || is_hit(r, i))
            return fail_value(r, c->name, i, plane[i], error);
    }
    return PBNDS_OK;
}

static enum pbnds_status check_values(const struct reading *r,
                                      struct pbnds_error *error)
{
    const size_t count = (size_t)r->exr->width * (size_t)r->exr->height;
    for (int c = 0; c < pbnds_gbuffer_channel_count(); ++c)
        PBNDS_TRY(check_channel(r, pbnds_gbuffer_channel_at(c), error));
    for (size_t i = 0; i < count; ++i) {
        if (is_hit(r, i) && !(r->from.depth[i] > 0.0f)) {
            return fail_value(r, "Z", i, r->from.depth[i], error);
        }
    }
    return PBNDS_OK;
}

static struct pbnds_vec3 at(const float *const planes[3], size_t i)
{
    return pbnds_vec3_make(planes[0][i], planes[1][i], planes[2][i]);
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

/* A world normal as the contract wants it: unit, facing the eye. A float normal of ours
 * passes unchanged; half ones and those of other writers are mended, and where there is
 * no direction at all the surface is taken to face the eye. */
static struct pbnds_vec3 read_normal(const struct reading *r, size_t i,
                                     struct pbnds_vec3 wo)
{
    struct pbnds_vec3 n = at(r->from.normal, i);
    if (r->origin.normal_space == PBNDS_NORMAL_CAMERA)
        n = pbnds_mat4_vector(&r->gbuffer->camera.world_from_camera, n);
    const float square = pbnds_dot(n, n);
    if (!(square > 1e-12f && square < 1e30f)) return wo;
    if (fabsf(square - 1.0f) > 4e-6f) n = pbnds_scale(n, 1.0f / sqrtf(square));
    return pbnds_face_eye(n, wo);
}

static float unit_value(const float *plane, size_t i, float otherwise)
{
    return plane ? pbnds_clamp(plane[i], 0.0f, 1.0f) : otherwise;
}

/* Base colour, and what it reflects at normal incidence. */
static void read_material(const struct reading *r, size_t i)
{
    struct pbnds_gbuffer *g = r->gbuffer;
    store(g->albedo, i, clamp3(at(r->from.albedo, i), 1.0f));
    g->roughness[i] = unit_value(r->from.roughness, i, 1.0f);
    g->metallic[i] = unit_value(r->from.metallic, i, 0.0f);
    /* of what has been clamped: the file may hold any number */
    const float metal =
        fminf(pbnds_luminance(clamp3(at(r->from.albedo, i), 1.0f)), 1.0f);
    g->specular[i] = unit_value(
        r->from.specular, i, 0.04f * (1.0f - g->metallic[i]) + g->metallic[i] * metal);
    if (r->from.emission[0])
        store(g->emission, i, clamp3(at(r->from.emission, i), 1e20f));
    if (g->f90) {
        store(g->f0, i, clamp3(at(r->from.f0, i), 1.0f));
        g->f90[i] = unit_value(r->from.f90, i, 1.0f);
    }
}

static void read_place(const struct reading *r, const struct pbnds_camera_view *view,
                       const struct pbnds_ray *ray, size_t i)
{
    struct pbnds_gbuffer *g = r->gbuffer;
    const float cosine = pbnds_dot(ray->direction, view->forward);
    const bool distance = r->origin.depth == PBNDS_DEPTH_DISTANCE;
    const float t = distance ? r->from.depth[i] : r->from.depth[i] / cosine;
    g->depth[i] = distance ? fmaxf(t * cosine, FLT_MIN) : r->from.depth[i];
    if (r->from.position[0]) {
        store(g->position, i, at(r->from.position, i));
    } else {
        store(g->position, i, pbnds_mad(ray->origin, ray->direction, t));
    }
    const struct pbnds_vec3 n = read_normal(r, i, pbnds_scale(ray->direction, -1.0f));
    store(g->normal, i, n);
    store(g->geometric_normal, i, n);
}

static void read_pixel(const struct reading *r, const struct pbnds_camera_view *view,
                       int x, int y)
{
    struct pbnds_gbuffer *g = r->gbuffer;
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    if (!is_hit(r, i)) {
        g->depth[i] = INFINITY;
        g->object_id[i] = UINT32_MAX;
        if (g->material_id) g->material_id[i] = UINT32_MAX;
        return;
    }
    const struct pbnds_ray ray =
        pbnds_camera_view_ray(view, (float)x + 0.5f, (float)y + 0.5f);
    read_material(r, i);
    read_place(r, view, &ray, i);
    g->coverage[i] = unit_value(r->from.coverage, i, 1.0f);
    g->object_id[i] = r->from.object_id ? r->from.object_id[i] : 0;
    if (g->material_id) g->material_id[i] = r->from.material_id[i];
    if (g->ao) g->ao[i] = unit_value(r->from.ao, i, 1.0f);
    for (int c = 0; c < 2 && g->uv[0]; ++c)
        g->uv[c][i] = r->from.uv[c][i];
    for (int c = 0; c < 2 && g->motion[0]; ++c)
        g->motion[c][i] = r->from.motion[c][i];
}

static enum pbnds_status read_radiance(const struct reading *r,
                                       struct pbnds_image *radiance,
                                       struct pbnds_error *error)
{
    const struct pbnds_exr *exr = r->exr;
    const float *const planes[3] = {float_plane(exr, "R"), float_plane(exr, "G"),
                                    float_plane(exr, "B")};
    if (!planes[0] || !planes[1] || !planes[2]) return PBNDS_OK;
    PBNDS_TRY(pbnds_image_init(radiance, exr->width, exr->height, 3, error));
    const size_t count = (size_t)exr->width * (size_t)exr->height;
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            if (!isfinite(planes[c][i])) {
                static const char *const names[] = {"R", "G", "B"};
                return fail_value(r, names[c], i, planes[c][i], error);
            }
            radiance->data[3 * i + c] = planes[c][i];
        }
    }
    return PBNDS_OK;
}

/* The planes of one rank; false where the file has them not, or not as float: an id that
 * went through half is no id. */
static bool matte_rank(const struct pbnds_exr *exr, const char *layer, int rank,
                       const struct pbnds_exr_channel *planes[2])
{
    static const char parts[] = {'R', 'G', 'B', 'A'};
    for (int k = 0; k < 2; ++k) {
        char name[64];
        snprintf(name, sizeof name, "%.31s%02d.%c", layer, rank / 2,
                 parts[2 * (rank % 2) + k]);
        planes[k] = pbnds_exr_find(exr, name);
        if (!planes[k] || planes[k]->type != PBNDS_EXR_FLOAT) return false;
    }
    return true;
}

static char *copy_text(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy) memcpy(copy, text, size);
    return copy;
}

/* The mattes of a file that has both of our layers; those of others stay raw channels. */
static enum pbnds_status read_mattes(const struct reading *r, struct pbnds_error *error)
{
    const struct pbnds_exr_channel *planes[2];
    const size_t size = (size_t)r->exr->width * (size_t)r->exr->height * sizeof(float);
    for (int rank = 0; rank < PBNDS_CRYPTOMATTE_RANKS; ++rank) {
        if (!matte_rank(r->exr, "CryptoObject", rank, planes) ||
            !matte_rank(r->exr, "CryptoMaterial", rank, planes)) {
            return PBNDS_OK;
        }
    }
    struct pbnds_cryptomatte **mattes = &r->gbuffer->cryptomatte;
    PBNDS_TRY(pbnds_cryptomatte_create(r->exr->width, r->exr->height, mattes, error));
    for (int l = 0; l < PBNDS_CRYPTOMATTE_LAYERS; ++l) {
        struct pbnds_cryptomatte_layer *layer = &(*mattes)->layers[l];
        for (int rank = 0; rank < PBNDS_CRYPTOMATTE_RANKS; ++rank) {
            if (!matte_rank(r->exr, layer->name, rank, planes)) continue;
            memcpy(layer->id[rank], planes[0]->data, size);
            memcpy(layer->share[rank], planes[1]->data, size);
        }
        char key[64];
        pbnds_header_matte_key(layer->name, "manifest", key);
        const char *manifest = pbnds_header_string(r->exr, key, NULL);
        if (!manifest) continue;
        layer->manifest = copy_text(manifest);
        if (!layer->manifest) {
            return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                              "%s: no memory for the names of its mattes", r->path);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status read_planes(struct reading *r, struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_header_origin(r->exr, r->path, &r->origin, error));
    PBNDS_TRY(check_channels(r, error));
    find_sources(r);
    PBNDS_TRY(check_values(r, error));
    struct pbnds_camera camera;
    int samples = 1;
    enum pbnds_through through = PBNDS_THROUGH_FIRST;
    PBNDS_TRY(pbnds_header_camera(r->exr, r->path, &camera, error));
    PBNDS_TRY(pbnds_header_sampling(r->exr, r->path, &samples, &through, error));
    PBNDS_TRY(pbnds_gbuffer_allocate(r->gbuffer, r->exr->width, r->exr->height,
                                     optional_planes(&r->from), r->from.f0[0] != NULL,
                                     error));
    r->gbuffer->camera = camera;
    r->gbuffer->samples = samples;
    r->gbuffer->through = through;
    const struct pbnds_camera_view view =
        pbnds_camera_view(&camera, r->exr->width, r->exr->height);
    for (int y = 0; y < r->exr->height; ++y) {
        for (int x = 0; x < r->exr->width; ++x)
            read_pixel(r, &view, x, y);
    }
    return read_mattes(r, error);
}

/* Takes `file` over. */
static enum pbnds_status take(const char *path, struct pbnds_exr *file,
                              struct pbnds_gbuffer *gbuffer,
                              struct pbnds_gbuffer_origin *origin,
                              struct pbnds_image *radiance, struct pbnds_exr *exr,
                              struct pbnds_error *error)
{
    struct reading r = {.path = path, .exr = file, .gbuffer = gbuffer};
    enum pbnds_status status = read_planes(&r, error);
    if (status == PBNDS_OK && radiance) status = read_radiance(&r, radiance, error);
    if (status != PBNDS_OK) {
        if (radiance) pbnds_image_free(radiance);
        pbnds_gbuffer_free(gbuffer);
        pbnds_exr_free(file);
        return status;
    }
    if (origin) *origin = r.origin;
    if (exr) {
        *exr = *file;
    } else {
        pbnds_exr_free(file);
    }
    return PBNDS_OK;
}

static void empty(struct pbnds_gbuffer *gbuffer, struct pbnds_image *radiance,
                  struct pbnds_exr *exr)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    if (radiance) memset(radiance, 0, sizeof *radiance);
    if (exr) memset(exr, 0, sizeof *exr);
}

enum pbnds_status pbnds_gbuffer_read(const char *path, struct pbnds_gbuffer *gbuffer,
                                     struct pbnds_gbuffer_origin *origin,
                                     struct pbnds_image *radiance,
                                     struct pbnds_exr *exr, struct pbnds_error *error)
{
    struct pbnds_exr file;
    empty(gbuffer, radiance, exr);
    PBNDS_TRY(pbnds_exr_read(path, &file, error));
    return take(path, &file, gbuffer, origin, radiance, exr, error);
}

enum pbnds_status pbnds_gbuffer_read_memory(const char *name, const uint8_t *bytes,
                                            size_t size, struct pbnds_gbuffer *gbuffer,
                                            struct pbnds_gbuffer_origin *origin,
                                            struct pbnds_image *radiance,
                                            struct pbnds_exr *exr,
                                            struct pbnds_error *error)
{
    struct pbnds_exr file;
    empty(gbuffer, radiance, exr);
    PBNDS_TRY(pbnds_exr_read_memory(name, bytes, size, &file, error));
    return take(name, &file, gbuffer, origin, radiance, exr, error);
}
