#include "engine/shade/gbuffer_header.h"

#include <assert.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/shade/cryptomatte.h"

/* Metres: beyond, positions leave the range of float. */
#define FARTHEST 1e15f

static const char *const normal_spaces[] = {"camera", "world", NULL};
static const char *const depth_kinds[] = {"planar", "distance", NULL};
static const char *const targets[] = {"radiance", "display", NULL};
static const char *const policies[] = {"first", "alpha", NULL};

/* Writing. */

static struct pbnds_exr_attribute *add(struct pbnds_header *header, const char *name,
                                       enum pbnds_exr_attribute_type type)
{
    assert(header->count < PBNDS_HEADER_MAX);
    struct pbnds_exr_attribute *a = &header->items[header->count++];
    snprintf(a->name, sizeof a->name, "%s", name);
    a->type = type;
    return a;
}

static void add_string(struct pbnds_header *header, const char *name, const char *value)
{
    struct pbnds_exr_attribute *a = add(header, name, PBNDS_EXR_ATTRIBUTE_STRING);
    snprintf(a->value.string, sizeof a->value.string, "%s", value);
}

static void add_float(struct pbnds_header *header, const char *name, float value)
{
    add(header, name, PBNDS_EXR_ATTRIBUTE_FLOAT)->value.f = value;
}

static void add_int(struct pbnds_header *header, const char *name, int32_t value)
{
    add(header, name, PBNDS_EXR_ATTRIBUTE_INT)->value.i = value;
}

static void add_matrix(struct pbnds_header *header, const char *name,
                       const struct pbnds_mat4 *m)
{
    memcpy(add(header, name, PBNDS_EXR_ATTRIBUTE_M44F)->value.m44, m->m, sizeof m->m);
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

static void describe_camera(struct pbnds_header *header, const struct pbnds_gbuffer *g)
{
    const struct pbnds_camera *camera = &g->camera;
    const struct pbnds_mat4 view = camera_from_world(camera);
    const struct pbnds_mat4 projection = ndc_from_camera(camera, g->width, g->height);
    const struct pbnds_mat4 ndc = pbnds_mat4_mul(&projection, &view);
    add_matrix(header, "worldToCamera", &view);
    add_matrix(header, "worldToNDC", &ndc);
    add_string(header, "pbnds:camera", camera->name);
    add_string(header, "pbnds:projection",
               camera->orthographic ? "orthographic" : "perspective");
    add_float(header, "pbnds:yfov", camera->yfov);
    add_float(header, "pbnds:ymag", camera->ymag);
    add_matrix(header, "pbnds:worldFromCamera", &camera->world_from_camera);
}

static void describe_origin(struct pbnds_header *header,
                            const struct pbnds_gbuffer_origin *origin)
{
    char seed[32];
    snprintf(seed, sizeof seed, "%" PRIu64, origin->seed);
    add_string(header, "pbnds:env", origin->env);
    add_float(header, "pbnds:envYaw", origin->env_yaw_deg);
    add_float(header, "pbnds:envStrength", origin->env_strength);
    add_string(header, "pbnds:envConvention", origin->env_convention);
    add_string(header, "pbnds:seed", seed);
    add_string(header, "pbnds:arguments", origin->arguments);
    if (origin->target != PBNDS_TARGET_RADIANCE)
        add_string(header, "pbnds:target", targets[origin->target]);
}

void pbnds_header_matte_key(const char *layer, const char *field, char out[64])
{
    const uint32_t hash = pbnds_murmur3_32(layer, strlen(layer), 0);
    snprintf(out, 64, "cryptomatte/%07lx/%s", (unsigned long)(hash >> 4), field);
}

static void describe_matte(struct pbnds_header *header,
                           const struct pbnds_cryptomatte_layer *layer)
{
    char key[64];
    pbnds_header_matte_key(layer->name, "name", key);
    add_string(header, key, layer->name);
    pbnds_header_matte_key(layer->name, "hash", key);
    add_string(header, key, "MurmurHash3_32");
    pbnds_header_matte_key(layer->name, "conversion", key);
    add_string(header, key, "uint32_to_float32");
    if (!layer->manifest) return;
    pbnds_header_matte_key(layer->name, "manifest", key);
    add(header, key, PBNDS_EXR_ATTRIBUTE_TEXT)->value.text = layer->manifest;
}

void pbnds_header_describe(struct pbnds_header *header,
                           const struct pbnds_gbuffer *gbuffer,
                           const struct pbnds_gbuffer_origin *origin)
{
    header->count = 0;
    add_int(header, "pbnds:contract", PBNDS_GBUFFER_CONTRACT);
    add_string(header, "pbnds:version", PBNDS_VERSION);
    add_string(header, "pbnds:normalSpace",
               normal_spaces[origin ? origin->normal_space : PBNDS_NORMAL_CAMERA]);
    add_string(header, "pbnds:depth",
               depth_kinds[origin ? origin->depth : PBNDS_DEPTH_PLANAR]);
    add_int(header, "pbnds:samples", gbuffer->samples);
    add_string(header, "pbnds:through", policies[gbuffer->through]);
    describe_camera(header, gbuffer);
    if (origin) describe_origin(header, origin);
    for (int l = 0; gbuffer->cryptomatte && l < PBNDS_CRYPTOMATTE_LAYERS; ++l)
        describe_matte(header, &gbuffer->cryptomatte->layers[l]);
}

/* Reading. */

const char *pbnds_header_string(const struct pbnds_exr *exr, const char *name,
                                const char *otherwise)
{
    const struct pbnds_exr_attribute *a = pbnds_exr_find_attribute(exr, name);
    if (a && a->type == PBNDS_EXR_ATTRIBUTE_STRING) return a->value.string;
    if (a && a->type == PBNDS_EXR_ATTRIBUTE_TEXT) return a->value.text;
    return otherwise;
}

static float get_float(const struct pbnds_exr *exr, const char *name, float otherwise)
{
    const struct pbnds_exr_attribute *a = pbnds_exr_find_attribute(exr, name);
    return a && a->type == PBNDS_EXR_ATTRIBUTE_FLOAT && isfinite(a->value.f)
               ? a->value.f
               : otherwise;
}

static int32_t get_int(const struct pbnds_exr *exr, const char *name, int32_t otherwise)
{
    const struct pbnds_exr_attribute *a = pbnds_exr_find_attribute(exr, name);
    return a && a->type == PBNDS_EXR_ATTRIBUTE_INT ? a->value.i : otherwise;
}

/* Place of an attribute's word in a list of two; the first where it is absent. */
static enum pbnds_status get_choice(const struct pbnds_exr *exr, const char *path,
                                    const char *name, const char *const words[],
                                    int *choice, struct pbnds_error *error)
{
    const char *word = pbnds_header_string(exr, name, words[0]);
    for (*choice = 0; words[*choice]; ++*choice) {
        if (strcmp(word, words[*choice]) == 0) return PBNDS_OK;
    }
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: %s is \"%.40s\"; write \"%s\" or \"%s\"", path, name, word,
                      words[0], words[1]);
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

enum pbnds_status pbnds_header_camera(const struct pbnds_exr *exr, const char *path,
                                      struct pbnds_camera *camera,
                                      struct pbnds_error *error)
{
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
            path);
    }
    memcpy(camera->world_from_camera.m, m->value.m44, sizeof m->value.m44);
    snprintf(camera->name, sizeof camera->name, "%.63s",
             pbnds_header_string(exr, "pbnds:camera", ""));
    camera->orthographic =
        strcmp(pbnds_header_string(exr, "pbnds:projection", ""), "orthographic") == 0;
    camera->yfov = get_float(exr, "pbnds:yfov", camera->yfov);
    camera->ymag = get_float(exr, "pbnds:ymag", camera->ymag);
    const float *eye = camera->world_from_camera.m + 12;
    const float far_off = fmaxf(fabsf(eye[0]), fmaxf(fabsf(eye[1]), fabsf(eye[2])));
    const bool sane = camera->orthographic
                          ? camera->ymag > 0.0f && camera->ymag < FARTHEST
                          : camera->yfov > 0.0f && camera->yfov < PBNDS_PI;
    if (sane && far_off < FARTHEST) return PBNDS_OK;
    return pbnds_fail(
        error, PBNDS_ERROR_FORMAT,
        "%s: the camera sees nothing (pbnds:yfov %g, pbnds:ymag %g, %g m from the "
        "origin); mend these attributes",
        path, (double)camera->yfov, (double)camera->ymag, (double)far_off);
}

enum pbnds_status pbnds_header_origin(const struct pbnds_exr *exr, const char *path,
                                      struct pbnds_gbuffer_origin *origin,
                                      struct pbnds_error *error)
{
    memset(origin, 0, sizeof *origin);
    const int32_t contract = get_int(exr, "pbnds:contract", PBNDS_GBUFFER_CONTRACT);
    if (contract > PBNDS_GBUFFER_CONTRACT) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: written for version %d of the G-buffer contract, this "
                          "program knows up to %d; use a newer pbnds",
                          path, (int)contract, PBNDS_GBUFFER_CONTRACT);
    }
    int choice = 0;
    PBNDS_TRY(
        get_choice(exr, path, "pbnds:normalSpace", normal_spaces, &choice, error));
    origin->normal_space = (enum pbnds_normal_space)choice;
    PBNDS_TRY(get_choice(exr, path, "pbnds:depth", depth_kinds, &choice, error));
    origin->depth = (enum pbnds_depth_kind)choice;
    PBNDS_TRY(get_choice(exr, path, "pbnds:target", targets, &choice, error));
    origin->target = (enum pbnds_target)choice;
    snprintf(origin->env, sizeof origin->env, "%.255s",
             pbnds_header_string(exr, "pbnds:env", ""));
    snprintf(origin->env_convention, sizeof origin->env_convention, "%.15s",
             pbnds_header_string(exr, "pbnds:envConvention", ""));
    snprintf(origin->arguments, sizeof origin->arguments, "%.399s",
             pbnds_header_string(exr, "pbnds:arguments", ""));
    snprintf(origin->version, sizeof origin->version, "%.31s",
             pbnds_header_string(exr, "pbnds:version", ""));
    origin->env_yaw_deg = get_float(exr, "pbnds:envYaw", 0.0f);
    origin->env_strength = get_float(exr, "pbnds:envStrength", 1.0f);
    origin->seed = strtoull(pbnds_header_string(exr, "pbnds:seed", "0"), NULL, 10);
    return PBNDS_OK;
}

enum pbnds_status pbnds_header_sampling(const struct pbnds_exr *exr, const char *path,
                                        int *samples, enum pbnds_through *through,
                                        struct pbnds_error *error)
{
    int choice = 0;
    PBNDS_TRY(get_choice(exr, path, "pbnds:through", policies, &choice, error));
    *through = (enum pbnds_through)choice;
    *samples = get_int(exr, "pbnds:samples", 1);
    if (*samples >= 1) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: pbnds:samples is %d; at least one ray makes a pixel", path,
                      *samples);
}
