/*
 * G-buffers in OpenEXR files.
 *
 * What is stored as what: colours and the scalars of [0, 1] are half, whose step of
 * 2^-11 is finer than the 8-bit textures they come from. Depth and position are float,
 * and so are normals: half turns a normal by up to 3e-4 radian, a third of the
 * narrowest GGX lobe (alpha = 1e-3), which shows as facets in sharp reflections.
 * Emission becomes float when it leaves the range of half. Half normals of other
 * writers are read all the same.
 *
 * Matrices: OpenEXR multiplies row vectors from the left, p M, and stores rows; ours
 * are M p, stored by columns. The sixteen numbers are the same in both.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/shade/gbuffer.h"

#define HALF_MAX 65504.0f

/* Blender writes 1e10 where nothing was hit. */
#define DEPTH_NOTHING 1e10f

enum { OWN_CHANNELS = 22, MAX_ATTRIBUTES = 20 };

/* Writing. */

struct channel_list {
    struct pbnds_exr_channel *items;
    int count;
};

static void add_channel(struct channel_list *list, const char *name,
                        enum pbnds_exr_type type, void *data)
{
    struct pbnds_exr_channel *c = &list->items[list->count++];
    snprintf(c->name, sizeof c->name, "%s", name);
    c->type = type;
    c->data = data;
}

static void add_triple(struct channel_list *list, const char *layer, const char *parts,
                       enum pbnds_exr_type type, float *const planes[3])
{
    for (int c = 0; c < 3; ++c) {
        char name[64];
        snprintf(name, sizeof name, "%s.%c", layer, parts[c]);
        add_channel(list, name, type, planes[c]);
    }
}

struct attribute_list {
    struct pbnds_exr_attribute items[MAX_ATTRIBUTES];
    int count;
};

static struct pbnds_exr_attribute *add_attribute(struct attribute_list *list,
                                                 const char *name,
                                                 enum pbnds_exr_attribute_type type)
{
    struct pbnds_exr_attribute *a = &list->items[list->count++];
    snprintf(a->name, sizeof a->name, "%s", name);
    a->type = type;
    return a;
}

static void add_string(struct attribute_list *list, const char *name, const char *value)
{
    struct pbnds_exr_attribute *a =
        add_attribute(list, name, PBNDS_EXR_ATTRIBUTE_STRING);
    snprintf(a->value.string, sizeof a->value.string, "%s", value);
}

static void add_float(struct attribute_list *list, const char *name, float value)
{
    add_attribute(list, name, PBNDS_EXR_ATTRIBUTE_FLOAT)->value.f = value;
}

static void add_matrix(struct attribute_list *list, const char *name,
                       const struct pbnds_mat4 *m)
{
    memcpy(add_attribute(list, name, PBNDS_EXR_ATTRIBUTE_M44F)->value.m44, m->m,
           sizeof m->m);
}

/* Inverse of the rigid world_from_camera. */
static struct pbnds_mat4 camera_from_world(const struct pbnds_camera *camera)
{
    const float *m = camera->world_from_camera.m;
    const struct pbnds_vec3 eye = {m[12], m[13], m[14]};
    const struct pbnds_vec3 t = pbnds_camera_from_world_vector(camera, eye);
    return (struct pbnds_mat4){{m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6],
                                m[10], 0, -t.x, -t.y, -t.z, 1}};
}

/* Camera to normalised device coordinates: x right and y up in [-1, 1]. z runs from -1
 * at the near plane to 1 at infinity (perspective) or at the far plane. */
static struct pbnds_mat4 ndc_from_camera(const struct pbnds_camera *camera, int width,
                                         int height)
{
    const float near_plane = 0.01f, far_plane = 1000.0f;
    const float aspect = (float)width / (float)height;
    struct pbnds_mat4 p = {{0}};
    if (camera->orthographic) {
        p.m[0] = 1.0f / (camera->ymag * aspect);
        p.m[5] = 1.0f / camera->ymag;
        p.m[10] = -2.0f / (far_plane - near_plane);
        p.m[14] = -(far_plane + near_plane) / (far_plane - near_plane);
        p.m[15] = 1.0f;
    } else {
        const float f = 1.0f / tanf(0.5f * camera->yfov);
        p.m[0] = f / aspect;
        p.m[5] = f;
        p.m[10] = -1.0f;
        p.m[11] = -1.0f;
        p.m[14] = -2.0f * near_plane;
    }
    return p;
}

static void describe_camera(struct attribute_list *list, const struct pbnds_gbuffer *g)
{
    const struct pbnds_camera *camera = &g->camera;
    const struct pbnds_mat4 view = camera_from_world(camera);
    const struct pbnds_mat4 projection = ndc_from_camera(camera, g->width, g->height);
    const struct pbnds_mat4 ndc = pbnds_mat4_mul(&projection, &view);
    add_matrix(list, "worldToCamera", &view);
    add_matrix(list, "worldToNDC", &ndc);
    add_string(list, "pbnds:camera", camera->name);
    add_string(list, "pbnds:projection",
               camera->orthographic ? "orthographic" : "perspective");
    add_float(list, "pbnds:yfov", camera->yfov);
    add_float(list, "pbnds:ymag", camera->ymag);
    add_matrix(list, "pbnds:worldFromCamera", &camera->world_from_camera);
}

static void describe_origin(struct attribute_list *list,
                            const struct pbnds_gbuffer_origin *origin)
{
    char seed[32];
    snprintf(seed, sizeof seed, "%" PRIu64, origin->seed);
    add_string(list, "pbnds:env", origin->env);
    add_float(list, "pbnds:envYaw", origin->env_yaw_deg);
    add_float(list, "pbnds:envStrength", origin->env_strength);
    add_string(list, "pbnds:envConvention", origin->env_convention);
    add_string(list, "pbnds:seed", seed);
    add_string(list, "pbnds:arguments", origin->arguments);
}

static bool fits_half(float *const planes[3], size_t count)
{
    for (int c = 0; c < 3; ++c) {
        for (size_t i = 0; i < count; ++i) {
            if (!(fabsf(planes[c][i]) <= HALF_MAX)) return false;
        }
    }
    return true;
}

static void normals_to_camera(const struct pbnds_gbuffer *g, float *const out[3])
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    for (size_t i = 0; i < count; ++i) {
        const struct pbnds_vec3 n = pbnds_camera_from_world_vector(
            &g->camera,
            pbnds_vec3_make(g->normal[0][i], g->normal[1][i], g->normal[2][i]));
        out[0][i] = n.x;
        out[1][i] = n.y;
        out[2][i] = n.z;
    }
}

static void split_radiance(const struct pbnds_image *image, float *const out[3])
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c)
            out[c][i] = image->data[3 * i + (size_t)c];
    }
}

static void list_channels(const struct pbnds_gbuffer *g, float *const normal[3],
                          float *const radiance[3], struct channel_list *list)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    add_triple(list, "albedo", "RGB", PBNDS_EXR_HALF, g->albedo);
    add_triple(list, "normal", "XYZ", PBNDS_EXR_FLOAT, normal);
    add_channel(list, "specular.R", PBNDS_EXR_HALF, g->specular);
    add_channel(list, "roughness.R", PBNDS_EXR_HALF, g->roughness);
    add_channel(list, "metallic.R", PBNDS_EXR_HALF, g->metallic);
    add_channel(list, "Z", PBNDS_EXR_FLOAT, g->depth);
    add_channel(list, "coverage.A", PBNDS_EXR_HALF, g->coverage);
    add_triple(list, "position", "XYZ", PBNDS_EXR_FLOAT, g->position);
    add_triple(list, "emission", "RGB",
               fits_half(g->emission, count) ? PBNDS_EXR_HALF : PBNDS_EXR_FLOAT,
               g->emission);
    add_channel(list, "object_id", PBNDS_EXR_UINT, g->object_id);
    if (radiance[0]) {
        add_channel(list, "R", PBNDS_EXR_FLOAT, radiance[0]);
        add_channel(list, "G", PBNDS_EXR_FLOAT, radiance[1]);
        add_channel(list, "B", PBNDS_EXR_FLOAT, radiance[2]);
        add_channel(list, "A", PBNDS_EXR_HALF, g->coverage);
    }
}

static enum pbnds_status add_extra(const char *path, struct channel_list *list,
                                   const struct pbnds_exr_channel *extra,
                                   int extra_count, struct pbnds_error *error)
{
    for (int i = 0; i < extra_count; ++i) {
        for (int k = 0; k < list->count; ++k) {
            if (strcmp(list->items[k].name, extra[i].name) != 0) continue;
            return pbnds_fail(
                error, PBNDS_ERROR_ARGUMENT,
                "%s: the channel %s would be written twice; give the extra "
                "channel another name",
                path, extra[i].name);
        }
        list->items[list->count++] = extra[i];
    }
    return PBNDS_OK;
}

static void describe(const struct pbnds_gbuffer *g,
                     const struct pbnds_gbuffer_origin *origin,
                     struct attribute_list *list)
{
    add_attribute(list, "pbnds:contract", PBNDS_EXR_ATTRIBUTE_INT)->value.i =
        PBNDS_GBUFFER_CONTRACT;
    add_string(list, "pbnds:version", PBNDS_VERSION);
    add_string(list, "pbnds:normalSpace", "camera");
    describe_camera(list, g);
    if (origin) describe_origin(list, origin);
}

enum pbnds_status
pbnds_gbuffer_write(const char *path, const struct pbnds_gbuffer *gbuffer,
                    const struct pbnds_gbuffer_origin *origin,
                    const struct pbnds_image *radiance,
                    const struct pbnds_exr_channel *extra, int extra_count,
                    enum pbnds_exr_compression compression, struct pbnds_error *error)
{
    if (radiance && (radiance->width != gbuffer->width ||
                     radiance->height != gbuffer->height || radiance->channels != 3)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: the radiance is %d x %d with %d channels, the G-buffer "
                          "%d x %d; they must agree, with 3 channels",
                          path, radiance->width, radiance->height, radiance->channels,
                          gbuffer->width, gbuffer->height);
    }
    if (extra_count < 0) extra_count = 0;
    const size_t count = (size_t)gbuffer->width * (size_t)gbuffer->height;
    const size_t planes = radiance ? 6 : 3;
    float *scratch = malloc(planes * count * sizeof *scratch);
    struct attribute_list *attributes = calloc(1, sizeof *attributes);
    struct channel_list list = {
        calloc((size_t)OWN_CHANNELS + (size_t)extra_count, sizeof *list.items), 0};
    enum pbnds_status status;
    if (!scratch || !attributes || !list.items) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY,
                            "%s: out of memory while writing %d x %d pixels", path,
                            gbuffer->width, gbuffer->height);
        goto done;
    }
    float *const normal[3] = {scratch, scratch + count, scratch + 2 * count};
    float *color[3] = {NULL, NULL, NULL};
    normals_to_camera(gbuffer, normal);
    if (radiance) {
        for (size_t c = 0; c < 3; ++c)
            color[c] = scratch + (3 + c) * count;
        split_radiance(radiance, color);
    }
    list_channels(gbuffer, normal, color, &list);
    status = add_extra(path, &list, extra, extra_count, error);
    if (status != PBNDS_OK) goto done;
    describe(gbuffer, origin, attributes);

    const struct pbnds_exr exr = {.width = gbuffer->width,
                                  .height = gbuffer->height,
                                  .compression = compression,
                                  .channels = list.items,
                                  .channel_count = list.count,
                                  .attributes = attributes->items,
                                  .attribute_count = attributes->count};
    status = pbnds_exr_write(path, &exr, error);
done:
    free(list.items);
    free(attributes);
    free(scratch);
    return status;
}

/* Reading. */

/* The planes of a file by what they mean; optional ones may be NULL. */
struct sources {
    const float *albedo[3], *normal[3], *depth, *roughness;
    const float *specular, *metallic, *coverage, *position[3], *emission[3];
    const uint32_t *object_id;
};

/* A file while it is read. */
struct reading {
    const char *path;
    const struct pbnds_exr *exr;
    struct pbnds_gbuffer *gbuffer;
    struct sources from;
    bool normals_in_world;
};

static const float *float_plane(const struct pbnds_exr *exr, const char *name)
{
    const struct pbnds_exr_channel *c = pbnds_exr_find(exr, name);
    return c && c->type != PBNDS_EXR_UINT ? c->data : NULL;
}

/* All three planes of a layer, or none. */
static void float_triple(const struct pbnds_exr *exr, const char *layer,
                         const char *parts, const float *planes[3])
{
    for (int c = 0; c < 3; ++c) {
        char name[64];
        snprintf(name, sizeof name, "%s.%c", layer, parts[c]);
        planes[c] = float_plane(exr, name);
    }
    if (!planes[0] || !planes[1] || !planes[2])
        planes[0] = planes[1] = planes[2] = NULL;
}

static const char *const required[] = {"albedo.R", "albedo.G",   "albedo.B",
                                       "normal.X", "normal.Y",   "normal.Z",
                                       "Z",        "roughness.R"};
enum { REQUIRED = sizeof required / sizeof required[0] };

/* One sentence with every channel that is missing. */
static enum pbnds_status check_channels(const struct reading *r,
                                        struct pbnds_error *error)
{
    char names[256] = "";
    int missing = 0;
    for (int i = 0; i < REQUIRED; ++i) {
        if (float_plane(r->exr, required[i])) continue;
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", missing ? ", " : "",
                 required[i]);
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
    float_triple(r->exr, "albedo", "RGB", s->albedo);
    float_triple(r->exr, "normal", "XYZ", s->normal);
    float_triple(r->exr, "position", "XYZ", s->position);
    float_triple(r->exr, "emission", "RGB", s->emission);
    s->depth = float_plane(r->exr, "Z");
    s->roughness = float_plane(r->exr, "roughness.R");
    s->specular = float_plane(r->exr, "specular.R");
    s->metallic = float_plane(r->exr, "metallic.R");
    s->coverage = float_plane(r->exr, "coverage.A");
    const struct pbnds_exr_channel *id = pbnds_exr_find(r->exr, "object_id");
    if (id && id->type == PBNDS_EXR_UINT) s->object_id = id->data;
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

/* Required channels everywhere, the others where something was hit. */
static enum pbnds_status check_values(const struct reading *r,
                                      struct pbnds_error *error)
{
    static const char *const optional[] = {"specular.R", "metallic.R", "coverage.A",
                                           "position.X", "position.Y", "position.Z",
                                           "emission.R", "emission.G", "emission.B"};
    const size_t count = (size_t)r->exr->width * (size_t)r->exr->height;
    for (int c = 0; c < REQUIRED; ++c) {
        const float *plane = float_plane(r->exr, required[c]);
        if (!plane) continue; /* check_channels() has seen to that */
        const bool depth = plane == r->from.depth;
        for (size_t i = 0; i < count; ++i) {
            if (isfinite(plane[i]) || (depth && plane[i] > 0.0f)) continue;
            return fail_value(r, required[c], i, plane[i], error);
        }
    }
    for (size_t i = 0; i < count; ++i) {
        if (is_hit(r, i) && !(r->from.depth[i] > 0.0f)) {
            return fail_value(r, "Z", i, r->from.depth[i], error);
        }
    }
    for (size_t c = 0; c < sizeof optional / sizeof optional[0]; ++c) {
        const float *plane = float_plane(r->exr, optional[c]);
        if (!plane) continue;
        for (size_t i = 0; i < count; ++i) {
            if (isfinite(plane[i])) continue;
            if (plane == r->from.coverage || is_hit(r, i)) {
                return fail_value(r, optional[c], i, plane[i], error);
            }
        }
    }
    return PBNDS_OK;
}

static const char *string_attribute(const struct pbnds_exr *exr, const char *name,
                                    const char *otherwise)
{
    const struct pbnds_exr_attribute *a = pbnds_exr_find_attribute(exr, name);
    return a && a->type == PBNDS_EXR_ATTRIBUTE_STRING ? a->value.string : otherwise;
}

static float float_attribute(const struct pbnds_exr *exr, const char *name,
                             float otherwise)
{
    const struct pbnds_exr_attribute *a = pbnds_exr_find_attribute(exr, name);
    return a && a->type == PBNDS_EXR_ATTRIBUTE_FLOAT && isfinite(a->value.f)
               ? a->value.f
               : otherwise;
}

static enum pbnds_status check_header(struct reading *r, struct pbnds_error *error)
{
    const struct pbnds_exr_attribute *a =
        pbnds_exr_find_attribute(r->exr, "pbnds:contract");
    if (a && a->type == PBNDS_EXR_ATTRIBUTE_INT &&
        a->value.i > PBNDS_GBUFFER_CONTRACT) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: written for version %d of the G-buffer contract, this "
                          "program knows up to %d; use a newer pbnds",
                          r->path, (int)a->value.i, PBNDS_GBUFFER_CONTRACT);
    }
    const char *space = string_attribute(r->exr, "pbnds:normalSpace", "camera");
    r->normals_in_world = strcmp(space, "world") == 0;
    if (!r->normals_in_world && strcmp(space, "camera") != 0) {
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "%s: pbnds:normalSpace is \"%.40s\"; write \"camera\" or \"world\"",
            r->path, space);
    }
    return PBNDS_OK;
}

/* Are the columns unit, at right angles and right-handed, and all numbers finite? */
static bool is_rigid(const float m[16])
{
    for (int i = 0; i < 16; ++i) {
        if (!isfinite(m[i])) return false;
    }
    const struct pbnds_vec3 x = {m[0], m[1], m[2]}, y = {m[4], m[5], m[6]},
                            z = {m[8], m[9], m[10]};
    const struct pbnds_vec3 off = pbnds_sub(pbnds_cross(x, y), z);
    return fabsf(pbnds_dot(x, x) - 1.0f) < 1e-3f &&
           fabsf(pbnds_dot(y, y) - 1.0f) < 1e-3f && fabsf(pbnds_dot(x, y)) < 1e-3f &&
           pbnds_dot(off, off) < 1e-5f;
}

static enum pbnds_status read_camera(const struct reading *r,
                                     struct pbnds_camera *camera,
                                     struct pbnds_error *error)
{
    const struct pbnds_exr *exr = r->exr;
    memset(camera, 0, sizeof *camera);
    camera->world_from_camera = pbnds_mat4_identity();
    camera->yfov = 40.0f * PBNDS_PI / 180.0f;
    camera->ymag = 1.0f;
    const struct pbnds_exr_attribute *m =
        pbnds_exr_find_attribute(exr, "pbnds:worldFromCamera");
    if (!m || m->type != PBNDS_EXR_ATTRIBUTE_M44F) return PBNDS_OK;
    if (!is_rigid(m->value.m44)) {
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "%s: pbnds:worldFromCamera is not a rotation with a translation; "
            "remove the attribute or mend it",
            r->path);
    }
    memcpy(camera->world_from_camera.m, m->value.m44, sizeof m->value.m44);
    snprintf(camera->name, sizeof camera->name, "%.63s",
             string_attribute(exr, "pbnds:camera", ""));
    camera->orthographic =
        strcmp(string_attribute(exr, "pbnds:projection", ""), "orthographic") == 0;
    camera->yfov = float_attribute(exr, "pbnds:yfov", camera->yfov);
    camera->ymag = float_attribute(exr, "pbnds:ymag", camera->ymag);
    const bool sane = camera->orthographic
                          ? camera->ymag > 0.0f
                          : camera->yfov > 0.0f && camera->yfov < PBNDS_PI;
    if (!sane) {
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "%s: the camera sees nothing (pbnds:yfov %g, pbnds:ymag %g); mend "
            "these attributes",
            r->path, (double)camera->yfov, (double)camera->ymag);
    }
    return PBNDS_OK;
}

static void read_origin(const struct pbnds_exr *exr,
                        struct pbnds_gbuffer_origin *origin)
{
    memset(origin, 0, sizeof *origin);
    snprintf(origin->env, sizeof origin->env, "%.255s",
             string_attribute(exr, "pbnds:env", ""));
    snprintf(origin->env_convention, sizeof origin->env_convention, "%.15s",
             string_attribute(exr, "pbnds:envConvention", ""));
    snprintf(origin->arguments, sizeof origin->arguments, "%.399s",
             string_attribute(exr, "pbnds:arguments", ""));
    origin->env_yaw_deg = float_attribute(exr, "pbnds:envYaw", 0.0f);
    origin->env_strength = float_attribute(exr, "pbnds:envStrength", 1.0f);
    origin->seed = strtoull(string_attribute(exr, "pbnds:seed", "0"), NULL, 10);
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

/* A world normal as the contract wants it: unit, facing the eye. A float normal of ours
 * passes unchanged; half ones and those of other writers are mended, and where there is
 * no direction at all the surface is taken to face the eye. */
static struct pbnds_vec3 read_normal(const struct reading *r, size_t i,
                                     struct pbnds_vec3 wo)
{
    struct pbnds_vec3 n = at(r->from.normal, i);
    if (!r->normals_in_world)
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

static void read_pixel(const struct reading *r, const struct pbnds_camera_view *view,
                       int x, int y)
{
    struct pbnds_gbuffer *g = r->gbuffer;
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    if (!is_hit(r, i)) return; /* the planes say "nothing" already */
    const struct pbnds_ray ray =
        pbnds_camera_view_ray(view, (float)x + 0.5f, (float)y + 0.5f);

    const struct pbnds_vec3 albedo = at(r->from.albedo, i);
    store(g->albedo, i,
          pbnds_vec3_make(pbnds_clamp(albedo.x, 0.0f, 1.0f),
                          pbnds_clamp(albedo.y, 0.0f, 1.0f),
                          pbnds_clamp(albedo.z, 0.0f, 1.0f)));
    const struct pbnds_vec3 n = read_normal(r, i, pbnds_scale(ray.direction, -1.0f));
    store(g->normal, i, n);
    store(g->geometric_normal, i, n);
    g->roughness[i] = unit_value(r->from.roughness, i, 1.0f);
    g->metallic[i] = unit_value(r->from.metallic, i, 0.0f);
    const float dielectric = 0.04f * (1.0f - g->metallic[i]);
    g->specular[i] = unit_value(r->from.specular, i,
                                dielectric + g->metallic[i] * pbnds_luminance(at(r->from.albedo, i)));
    g->coverage[i] = unit_value(r->from.coverage, i, 1.0f);
    g->depth[i] = r->from.depth[i];
    if (r->from.position[0]) {
        store(g->position, i, at(r->from.position, i));
    } else {
        const float t = r->from.depth[i] / pbnds_dot(ray.direction, view->forward);
        store(g->position, i, pbnds_mad(ray.origin, ray.direction, t));
    }
    if (r->from.emission[0]) {
        const struct pbnds_vec3 e = at(r->from.emission, i);
        store(g->emission, i,
              pbnds_vec3_make(pbnds_clamp(e.x, 0.0f, 1e20f), pbnds_clamp(e.y, 0.0f, 1e20f),
                              pbnds_clamp(e.z, 0.0f, 1e20f)));
    }
    g->object_id[i] = r->from.object_id ? r->from.object_id[i] : 0;
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

static enum pbnds_status read_planes(struct reading *r, struct pbnds_error *error)
{
    PBNDS_TRY(check_header(r, error));
    PBNDS_TRY(check_channels(r, error));
    find_sources(r);
    PBNDS_TRY(check_values(r, error));
    struct pbnds_camera camera;
    PBNDS_TRY(read_camera(r, &camera, error));
    PBNDS_TRY(pbnds_gbuffer_init(r->gbuffer, r->exr->width, r->exr->height, error));
    r->gbuffer->camera = camera;
    const struct pbnds_camera_view view =
        pbnds_camera_view(&camera, r->exr->width, r->exr->height);
    for (int y = 0; y < r->exr->height; ++y) {
        for (int x = 0; x < r->exr->width; ++x)
            read_pixel(r, &view, x, y);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gbuffer_read(const char *path, struct pbnds_gbuffer *gbuffer,
                                     struct pbnds_gbuffer_origin *origin,
                                     struct pbnds_image *radiance,
                                     struct pbnds_exr *exr, struct pbnds_error *error)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    if (radiance) memset(radiance, 0, sizeof *radiance);
    if (exr) memset(exr, 0, sizeof *exr);

    struct pbnds_exr file;
    PBNDS_TRY(pbnds_exr_read(path, &file, error));
    struct reading r = {.path = path, .exr = &file, .gbuffer = gbuffer};
    enum pbnds_status status = read_planes(&r, error);
    if (status == PBNDS_OK && radiance) status = read_radiance(&r, radiance, error);
    if (status != PBNDS_OK) {
        if (radiance) pbnds_image_free(radiance);
        pbnds_gbuffer_free(gbuffer);
        pbnds_exr_free(&file);
        return status;
    }
    if (origin) read_origin(&file, origin);
    if (exr) {
        *exr = file;
    } else {
        pbnds_exr_free(&file);
    }
    return PBNDS_OK;
}
