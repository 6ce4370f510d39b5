/** What the tests of the glTF loader share: a small document, edits of it, loads. */
#ifndef PBNDS_TESTS_SCENE_GLTF_FIXTURE_H
#define PBNDS_TESTS_SCENE_GLTF_FIXTURE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf.h"
#include "tests/test.h"

static struct pbnds_error fault;
static char warnings[8192];

static inline void hear(void *user, const char *sentence)
{
    (void)user;
    const size_t used = strlen(warnings);
    (void)snprintf(warnings + used, sizeof warnings - used, "%s\n", sentence);
}

static const struct pbnds_report ear = {.warn = hear};

/* A unit square in z = 0 facing +z, picture upright, as a BIN chunk. */
struct square {
    float position[12], normal[12], uv[8];
    uint16_t index[6];
    uint8_t pad[4];
};

static const struct square square = {
    {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0},
    {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
    {0, 1, 1, 1, 1, 0, 0, 0},
    {0, 1, 2, 0, 2, 3},
    {0},
};

/* The document of the square; tests edit it. */
static const char square_json[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"nodes\":[{\"mesh\":0}],"
    "\"meshes\":[{\"name\":\"square\",\"primitives\":[{\"attributes\":{\"POSITION\":0,"
    "\"NORMAL\":1,\"TEXCOORD_0\":2},\"indices\":3}]}],"
    "\"buffers\":[{\"byteLength\":144}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":128},"
    "{\"buffer\":0,\"byteOffset\":128,\"byteLength\":12}],"
    "\"accessors\":["
    "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
    "{\"bufferView\":0,\"byteOffset\":48,\"componentType\":5126,\"count\":4,"
    "\"type\":\"VEC3\"},"
    "{\"bufferView\":0,\"byteOffset\":96,\"componentType\":5126,\"count\":4,"
    "\"type\":\"VEC2\"},"
    "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}]}";

/* 2 x 1: red opaque, green with alpha 128. */
#define PNG_BASE64                                                                     \
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+"                                      \
    "KAAAAD0lEQVR42mP4z8DwHwgbABB5A37EGHKQAAAA"                                        \
    "AElFTkSuQmCC"

/** Replaces the first `from`, which must be there. */
static inline char *edit(const char *text, const char *from, const char *to)
{
    const char *at = strstr(text, from);
    if (!at) fail_msg("no %s in the document", from);
    char *out = malloc(strlen(text) + strlen(to) + 1);
    const size_t head = (size_t)(at - text);
    memcpy(out, text, head);
    strcpy(out + head, to);
    strcat(out, at + strlen(from));
    return out;
}

static inline void put_u32(uint8_t *p, size_t x)
{
    for (int i = 0; i < 4; ++i)
        p[i] = (uint8_t)(x >> (8 * i));
}

static inline uint8_t *make_glb(const char *json, const void *bin, size_t bin_size,
                                size_t *size)
{
    const size_t padded = (strlen(json) + 3) / 4 * 4;
    *size = 20 + padded + (bin_size ? 8 + bin_size : 0);
    uint8_t *out = malloc(*size);
    memcpy(out, "glTF", 4);
    put_u32(out + 4, 2);
    put_u32(out + 8, *size);
    put_u32(out + 12, padded);
    memcpy(out + 16, "JSON", 4);
    memset(out + 20, ' ', padded);
    memcpy(out + 20, json, strlen(json));
    if (bin_size) {
        put_u32(out + 20 + padded, bin_size);
        memcpy(out + 24 + padded, "BIN\0", 4);
        memcpy(out + 28 + padded, bin, bin_size);
    }
    return out;
}

/** Loads a document with its BIN chunk; checks what every failure promises. */
static inline enum pbnds_status load_with(const char *json, const void *bin,
                                          size_t bin_size,
                                          const struct pbnds_gltf_options *options,
                                          struct pbnds_scene *scene)
{
    size_t size = 0;
    uint8_t *glb = make_glb(json, bin, bin_size, &size);
    warnings[0] = 0;
    fault.message[0] = 0;
    const enum pbnds_status status = pbnds_gltf_load_memory(
        glb, size, "test.glb", NULL, options, &ear, scene, &fault);
    free(glb);
    if (status != PBNDS_OK) {
        assert_null(scene->meshes);
        assert_int_equal(scene->mesh_count, 0);
        /* The sentence names the file and ends there: no second line. */
        assert_non_null(strstr(fault.message, "test.glb"));
        assert_null(strchr(fault.message, '\n'));
    }
    return status;
}

static inline enum pbnds_status load(const char *json, const void *bin, size_t bin_size,
                                     struct pbnds_scene *scene)
{
    return load_with(json, bin, bin_size, NULL, scene);
}

static inline void must_load(const char *json, const void *bin, size_t bin_size,
                             struct pbnds_scene *scene)
{
    const enum pbnds_status status = load(json, bin, bin_size, scene);
    if (status != PBNDS_OK) fail_msg("%d: %s", status, fault.message);
}

/** The square's document with one edit, loaded. */
static inline void load_edit(const char *from, const char *to,
                             struct pbnds_scene *scene)
{
    char *json = edit(square_json, from, to);
    must_load(json, &square, sizeof square, scene);
    free(json);
}

static inline void assert_vec3(struct pbnds_vec3 v, double x, double y, double z,
                               double tolerance)
{
    assert_near((double)v.x, x, tolerance);
    assert_near((double)v.y, y, tolerance);
    assert_near((double)v.z, z, tolerance);
}

static inline struct pbnds_vec3 face_normal(const struct pbnds_mesh *m, size_t triangle)
{
    const uint32_t *t = m->index + 3 * triangle;
    const struct pbnds_vec3 a = m->position[t[0]];
    return pbnds_cross(pbnds_sub(m->position[t[1]], a),
                       pbnds_sub(m->position[t[2]], a));
}

/** Is what a load gives sound enough for a ray caster? */
static inline void assert_sound(const struct pbnds_scene *s)
{
    size_t triangles = 0;
    for (int i = 0; i < s->mesh_count; ++i) {
        const struct pbnds_mesh *m = &s->meshes[i];
        triangles += m->triangle_count;
        assert_in_range(m->material, 0, s->material_count - 1);
        assert_true(m->triangle_count > 0 && m->position);
        for (size_t k = 0; k < 3 * m->triangle_count; ++k) {
            assert_true(m->index[k] < m->vertex_count);
        }
        for (size_t k = 0; k < m->vertex_count; ++k) {
            const struct pbnds_vec3 p = m->position[k];
            assert_true(p.x >= s->lo.x && p.y >= s->lo.y && p.z >= s->lo.z);
            assert_true(p.x <= s->hi.x && p.y <= s->hi.y && p.z <= s->hi.z);
            if (m->normal) assert_near((double)pbnds_length(m->normal[k]), 1.0, 1e-4);
            if (m->tangent) {
                const struct pbnds_vec4 t = m->tangent[k];
                const struct pbnds_vec3 d = {t.x, t.y, t.z};
                assert_near((double)pbnds_length(d), 1.0, 1e-4);
                assert_true(t.w == 1.0f || t.w == -1.0f);
            }
        }
    }
    assert_int_equal(triangles, s->triangle_count);
    assert_true(s->material_count >= 1);
    for (int i = 0; i < s->material_count; ++i) {
        const struct pbnds_material *m = &s->materials[i];
        assert_true(m->base_color_texture.texture < s->texture_count);
        assert_true(m->normal_texture.texture < s->texture_count);
    }
    for (int i = 0; i < s->texture_count; ++i) {
        const struct pbnds_pixels *p = s->textures[i].pixels;
        assert_true(p && p->width > 0 && p->height > 0 && (p->u8 || p->f32));
    }
}

#endif /* PBNDS_TESTS_SCENE_GLTF_FIXTURE_H */
