#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/rng.h"
#include "engine/scene/gltf.h"
#include "engine/scene/tangent.h"
#include "tests/test.h"

static struct pbnds_error fault;
static char warnings[8192];

static void hear(void *user, const char *sentence)
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
static char *edit(const char *text, const char *from, const char *to)
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

static void put_u32(uint8_t *p, size_t x)
{
    for (int i = 0; i < 4; ++i)
        p[i] = (uint8_t)(x >> (8 * i));
}

static uint8_t *make_glb(const char *json, const void *bin, size_t bin_size,
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

static enum pbnds_status load(const char *json, const void *bin, size_t bin_size,
                              struct pbnds_scene *scene)
{
    size_t size = 0;
    uint8_t *glb = make_glb(json, bin, bin_size, &size);
    warnings[0] = 0;
    fault.message[0] = 0;
    const enum pbnds_status status =
        pbnds_gltf_load_memory(glb, size, "test.glb", NULL, NULL, &ear, scene, &fault);
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

static void must_load(const char *json, const void *bin, size_t bin_size,
                      struct pbnds_scene *scene)
{
    const enum pbnds_status status = load(json, bin, bin_size, scene);
    if (status != PBNDS_OK) fail_msg("%d: %s", status, fault.message);
}

/** The square's document with one edit, loaded. */
static void load_edit(const char *from, const char *to, struct pbnds_scene *scene)
{
    char *json = edit(square_json, from, to);
    must_load(json, &square, sizeof square, scene);
    free(json);
}

static void assert_vec3(struct pbnds_vec3 v, double x, double y, double z,
                        double tolerance)
{
    assert_near((double)v.x, x, tolerance);
    assert_near((double)v.y, y, tolerance);
    assert_near((double)v.z, z, tolerance);
}

static struct pbnds_vec3 face_normal(const struct pbnds_mesh *m, size_t triangle)
{
    const uint32_t *t = m->index + 3 * triangle;
    const struct pbnds_vec3 a = m->position[t[0]];
    return pbnds_cross(pbnds_sub(m->position[t[1]], a),
                       pbnds_sub(m->position[t[2]], a));
}

/* ---- geometry ---------------------------------------------------------------- */

static void a_square_loads(void **state)
{
    (void)state;
    struct pbnds_scene s;
    must_load(square_json, &square, sizeof square, &s);
    assert_int_equal(s.mesh_count, 1);
    assert_int_equal(s.triangle_count, 2);
    assert_int_equal(s.camera_count, 0);
    assert_string_equal(s.meshes[0].name, "square");
    assert_int_equal(s.meshes[0].vertex_count, 4);
    assert_memory_equal(s.meshes[0].position, square.position, sizeof square.position);
    assert_memory_equal(s.meshes[0].normal, square.normal, sizeof square.normal);
    assert_memory_equal(s.meshes[0].uv[0], square.uv, sizeof square.uv);
    for (int i = 0; i < 6; ++i)
        assert_int_equal(s.meshes[0].index[i], square.index[i]);
    assert_null(s.meshes[0].uv[1]);
    assert_null(s.meshes[0].tangent);
    assert_null(s.meshes[0].color);
    assert_vec3(s.lo, 0, 0, 0, 0);
    assert_vec3(s.hi, 1, 1, 0, 0);
    /* The default material of glTF. */
    assert_int_equal(s.material_count, 1);
    assert_int_equal(s.meshes[0].material, 0);
    assert_true(s.materials[0].metallic == 1.0f && s.materials[0].roughness == 1.0f);
    assert_near((double)s.materials[0].ior_f0, 0.04, 1e-7);
    assert_string_equal(warnings, "");
    pbnds_scene_free(&s);
    pbnds_scene_free(&s);
}

static void not_indexed_and_without_normals(void **state)
{
    (void)state;
    struct pbnds_scene s;
    char *json = edit(square_json, ",\"indices\":3", "");
    char *flat = edit(json, "\"NORMAL\":1,", "");
    char *three =
        edit(flat, "\"count\":4,\"type\":\"VEC3\"", "\"count\":3,\"type\":\"VEC3\"");
    char *uv =
        edit(three, "\"count\":4,\"type\":\"VEC2\"", "\"count\":3,\"type\":\"VEC2\"");
    must_load(uv, &square, sizeof square, &s);
    assert_int_equal(s.triangle_count, 1);
    assert_null(s.meshes[0].normal);
    assert_int_equal(s.meshes[0].index[2], 2);
    pbnds_scene_free(&s);
    free(json);
    free(flat);
    free(three);
    free(uv);
}

/** M^-T n by Cramer's rule in double, unit length. */
static void naive_normal(const double m[9], const double n[3], double out[3])
{
    /* rows of m are m[0..2], ...; cof(m) / det(m) * n */
    double c[9], length = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, p = (j + 1) % 3,
                      q = (j + 2) % 3;
            c[3 * i + j] = m[3 * a + p] * m[3 * b + q] - m[3 * a + q] * m[3 * b + p];
        }
    }
    const double det = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
    for (int i = 0; i < 3; ++i) {
        out[i] = (c[3 * i] * n[0] + c[3 * i + 1] * n[1] + c[3 * i + 2] * n[2]) / det;
        length += out[i] * out[i];
    }
    for (int i = 0; i < 3; ++i)
        out[i] /= sqrt(length);
}

static void check_transform(const double m[9])
{
    char matrix[400];
    (void)snprintf(
        matrix, sizeof matrix,
        "{\"mesh\":0,\"matrix\":[%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,"
        "0,1,2,3,1]}",
        m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]);
    struct pbnds_scene s;
    load_edit("{\"mesh\":0}", matrix, &s);
    const struct pbnds_mesh *mesh = &s.meshes[0];
    const double up[3] = {0, 0, 1};
    double n[3];
    naive_normal(m, up, n);
    for (int i = 0; i < 4; ++i) {
        const float *p = square.position + 3 * i;
        double q[3];
        for (int k = 0; k < 3; ++k) {
            q[k] = m[3 * k] * (double)p[0] + m[3 * k + 1] * (double)p[1] +
                   m[3 * k + 2] * (double)p[2] + k + 1;
        }
        assert_vec3(mesh->position[i], q[0], q[1], q[2], 1e-5);
        assert_vec3(mesh->normal[i], n[0], n[1], n[2], 1e-5);
    }
    /* Front stays front: the face looks where the vertex normals look. */
    for (size_t i = 0; i < 2; ++i) {
        const struct pbnds_vec3 face = pbnds_normalize(face_normal(mesh, i));
        assert_vec3(face, n[0], n[1], n[2], 1e-5);
    }
    pbnds_scene_free(&s);
}

static void transforms_agree_with_the_inverse_transpose(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(1, 2, 3);
    int mirrored = 0;
    for (int i = 0; i < 40;) {
        double m[9];
        for (int k = 0; k < 9; ++k)
            m[k] = 4.0 * (double)pbnds_rng_float(&rng) - 2.0;
        const double det = m[0] * (m[4] * m[8] - m[5] * m[7]) -
                           m[1] * (m[3] * m[8] - m[5] * m[6]) +
                           m[2] * (m[3] * m[7] - m[4] * m[6]);
        if (fabs(det) < 0.5) continue;
        mirrored += det < 0;
        check_transform(m);
        ++i;
    }
    assert_in_range(mirrored, 5, 35);
}

static void a_mirror_flips_tangents(void **state)
{
    (void)state;
    /* TANGENT along +x, w = 1: the bitangent is +y. */
    struct {
        struct square square;
        float tangent[16];
    } bin = {square, {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}};
    char *a = edit(square_json, "\"NORMAL\":1", "\"NORMAL\":1,\"TANGENT\":4");
    char *b = edit(a, "\"byteLength\":144", "\"byteLength\":208");
    char *c = edit(b, "\"byteOffset\":128,\"byteLength\":12}",
                   "\"byteOffset\":128,\"byteLength\":12},"
                   "{\"buffer\":0,\"byteOffset\":144,\"byteLength\":64}");
    char *d = edit(c, "\"type\":\"SCALAR\"}",
                   "\"type\":\"SCALAR\"},{\"bufferView\":2,\"componentType\":5126,"
                   "\"count\":4,\"type\":\"VEC4\"}");
    for (int mirror = 0; mirror < 2; ++mirror) {
        char *json = edit(d, "{\"mesh\":0}",
                          mirror ? "{\"mesh\":0,\"scale\":[-2,3,1]}"
                                 : "{\"mesh\":0,\"scale\":[2,3,1]}");
        struct pbnds_scene s;
        must_load(json, &bin, sizeof bin, &s);
        const struct pbnds_vec4 t = s.meshes[0].tangent[2];
        const struct pbnds_vec3 direction = {t.x, t.y, t.z};
        assert_vec3(direction, mirror ? -1 : 1, 0, 0, 1e-6);
        const struct pbnds_vec3 bitangent =
            pbnds_scale(pbnds_cross(s.meshes[0].normal[2], direction), t.w);
        assert_vec3(bitangent, 0, 1, 0, 1e-6);
        pbnds_scene_free(&s);
        free(json);
    }
    free(a);
    free(b);
    free(c);
    free(d);
}

static void nodes_make_a_tree(void **state)
{
    (void)state;
    struct pbnds_scene s;
    /* Node 0 turns a quarter about z and moves; its child 2 scales. Node 1 is in no
     * scene.
     */
    load_edit("\"nodes\":[{\"mesh\":0}]",
              "\"nodes\":[{\"children\":[2],\"translation\":[10,0,0],"
              "\"rotation\":[0,0,0.70710678,0.70710678]},{\"mesh\":0},"
              "{\"mesh\":0,\"scale\":[2,3,1],\"name\":\"leaf\"}]",
              &s);
    assert_int_equal(s.mesh_count, 1);
    assert_int_equal(s.meshes[0].object_id, 2);
    assert_vec3(s.meshes[0].position[1], 10, 2, 0,
                1e-5); /* (1,0,0) -> (2,0,0) -> (0,2,0) */
    assert_vec3(s.meshes[0].position[3], 7, 0, 0, 1e-5);
    assert_vec3(s.lo, 7, 0, 0, 1e-5);
    assert_vec3(s.hi, 10, 2, 0, 1e-5);
    pbnds_scene_free(&s);
    /* Without scenes every root is shown. */
    load_edit("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]",
              "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[5,0,0]}]", &s);
    assert_int_equal(s.mesh_count, 2);
    assert_int_equal(s.meshes[1].object_id, 1);
    assert_vec3(s.hi, 6, 1, 0, 1e-6);
    pbnds_scene_free(&s);
    /* The scene that is named, not the first. */
    load_edit("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]",
              "\"scene\":1,\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1]}],"
              "\"nodes\":[{},{\"mesh\":0,\"translation\":[5,0,0]}]",
              &s);
    assert_int_equal(s.mesh_count, 1);
    assert_vec3(s.lo, 5, 0, 0, 1e-6);
    pbnds_scene_free(&s);
}

static void a_deep_tree_needs_no_stack(void **state)
{
    (void)state;
    enum { DEPTH = 50000 };
    char *nodes = malloc((size_t)DEPTH * 40 + 100);
    size_t at = (size_t)sprintf(nodes, "\"nodes\":[");
    for (int i = 0; i < DEPTH; ++i) {
        at += (size_t)sprintf(nodes + at, "{\"children\":[%d]},", i + 1);
    }
    (void)sprintf(nodes + at, "{\"mesh\":0}]");
    struct pbnds_scene s;
    load_edit("\"nodes\":[{\"mesh\":0}]", nodes, &s);
    assert_int_equal(s.meshes[0].object_id, DEPTH);
    pbnds_scene_free(&s);
    free(nodes);
}

static void strips_and_fans_keep_their_front(void **state)
{
    (void)state;
    static const struct {
        const char *mode;
        uint16_t index[6];
        const char *count;
    } cases[] = {
        {"\"indices\":3,\"mode\":5",
         {0, 1, 3, 2, 0, 0},
         "\"count\":4,\"type\":\"SCALAR\""},
        {"\"indices\":3,\"mode\":6",
         {0, 1, 2, 3, 0, 0},
         "\"count\":4,\"type\":\"SCALAR\""},
        /* a strip with a repeated index: two triangles without area fall out */
        {"\"indices\":3,\"mode\":5",
         {0, 1, 3, 3, 2, 1},
         "\"count\":6,\"type\":\"SCALAR\""},
    };
    for (size_t i = 0; i < 3; ++i) {
        struct square bin = square;
        memcpy(bin.index, cases[i].index, sizeof bin.index);
        char *a = edit(square_json, "\"indices\":3", cases[i].mode);
        char *json = edit(a, "\"count\":6,\"type\":\"SCALAR\"", cases[i].count);
        struct pbnds_scene s;
        must_load(json, &bin, sizeof bin, &s);
        assert_int_equal(s.triangle_count, 2);
        for (size_t k = 0; k < 2; ++k) {
            const struct pbnds_vec3 n = face_normal(&s.meshes[0], k);
            if (i < 2)
                assert_vec3(n, 0, 0, 1, 1e-6); /* half the square, facing +z */
            else
                assert_near(fabs((double)n.z), 1, 1e-6);
        }
        pbnds_scene_free(&s);
        free(a);
        free(json);
    }
}

static void points_and_lines_are_left_out(void **state)
{
    (void)state;
    for (int mode = 0; mode < 4; ++mode) {
        char text[40];
        (void)snprintf(text, sizeof text, "\"indices\":3,\"mode\":%d", mode);
        struct pbnds_scene s;
        load_edit("\"indices\":3", text, &s);
        assert_int_equal(s.mesh_count, 0);
        assert_non_null(strstr(warnings, "left out"));
        assert_non_null(strstr(warnings, "no triangles"));
        assert_vec3(s.hi, 0, 0, 0, 0);
        pbnds_scene_free(&s);
    }
}

static void attributes_may_be_interleaved_integers(void **state)
{
    (void)state;
    /* Stride 24: position short3 (quantised), pad, uv ubyte2 normalised, pad, colour
     * ushort3 normalised, pad. */
    struct vertex {
        int16_t position[3];
        uint16_t pad;
        uint8_t uv[4];
        uint16_t color[4];
        uint8_t joint[4];
    };
    assert_int_equal(sizeof(struct vertex), 24);
    const struct vertex bin[3] = {
        {{0, 0, 0}, 0, {0, 255, 0, 0}, {65535, 0, 13107, 0}, {0}},
        {{300, 0, 0}, 0, {51, 0, 0, 0}, {0, 65535, 0, 0}, {0}},
        {{0, -5, 7}, 0, {255, 255, 0, 0}, {1, 2, 3, 0}, {0}},
    };
    const char *json =
        "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],"
        "\"extensionsRequired\":[\"KHR_mesh_quantization\"],"
        "\"extensionsUsed\":[\"KHR_mesh_quantization\"],"
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
        "{\"POSITION\":0,\"TEXCOORD_1\":1,\"COLOR_0\":2}}]}],"
        "\"buffers\":[{\"byteLength\":72}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":72,\"byteStride\":24}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5122,\"count\":3,"
        "\"type\":\"VEC3\"},"
        "{\"bufferView\":0,\"byteOffset\":8,\"componentType\":5121,\"normalized\":true,"
        "\"count\":3,\"type\":\"VEC2\"},"
        "{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5123,\"normalized\":"
        "true,"
        "\"count\":3,\"type\":\"VEC3\"}]}";
    struct pbnds_scene s;
    must_load(json, bin, sizeof bin, &s);
    const struct pbnds_mesh *m = &s.meshes[0];
    assert_vec3(m->position[1], 300, 0, 0, 0);
    assert_vec3(m->position[2], 0, -5, 7, 0);
    assert_null(m->uv[0]);
    assert_near((double)m->uv[1][0].y, 1.0, 0);
    assert_near((double)m->uv[1][1].x, 0.2, 1e-7);
    assert_near((double)m->color[0].z, 0.2, 1e-7);
    assert_near((double)m->color[2].y, 2.0 / 65535.0, 1e-9);
    assert_true(m->color[0].w == 1.0f);
    assert_string_equal(m->name, "mesh 0");
    pbnds_scene_free(&s);
}

static void sparse_accessors_overwrite(void **state)
{
    (void)state;
    struct {
        struct square square;
        uint8_t at[4];
        float values[6];
    } bin = {square, {1, 3, 0, 0}, {7, 8, 9, -1, -2, -3}};
    char *a = edit(square_json, "\"byteLength\":144", "\"byteLength\":172");
    char *b = edit(a, "\"byteLength\":12}",
                   "\"byteLength\":12},"
                   "{\"buffer\":0,\"byteOffset\":144,\"byteLength\":2},"
                   "{\"buffer\":0,\"byteOffset\":148,\"byteLength\":24}");
    const char *sparse =
        "\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":2,\"indices\":"
        "{\"bufferView\":2,\"componentType\":5121},\"values\":"
        "{\"bufferView\":3}}";
    char *c = edit(b, "\"count\":4,\"type\":\"VEC3\"", sparse);
    struct pbnds_scene s;
    must_load(c, &bin, sizeof bin, &s);
    assert_vec3(s.meshes[0].position[0], 0, 0, 0, 0);
    assert_vec3(s.meshes[0].position[1], 7, 8, 9, 0);
    assert_vec3(s.meshes[0].position[2], 1, 1, 0, 0);
    assert_vec3(s.meshes[0].position[3], -1, -2, -3, 0);
    pbnds_scene_free(&s);
    /* On top of zeros. */
    char *d = edit(c, "\"accessors\":[{\"bufferView\":0,", "\"accessors\":[{");
    must_load(d, &bin, sizeof bin, &s);
    assert_vec3(s.meshes[0].position[2], 0, 0, 0, 0);
    assert_vec3(s.meshes[0].position[3], -1, -2, -3, 0);
    pbnds_scene_free(&s);
    bin.at[1] = 4; /* beyond the accessor */
    assert_int_equal(load(c, &bin, sizeof bin, &s), PBNDS_ERROR_FORMAT);
    free(a);
    free(b);
    free(c);
    free(d);
}

static void skins_take_their_rest_pose(void **state)
{
    (void)state;
    /* Joint 1 at x = 10, joint 2 turned a half about z; inverse bind matrices move by
     * -1 in x. The node's own translation must not count. */
    struct {
        struct square square;
        uint8_t joints[16];
        float weights[16];
        float bind[32];
    } bin = {
        square,
        {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0},
        {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1, 0, 0, 2, 0, 0, 0},
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1,
         1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1},
    };
    char *a = edit(square_json, "\"NORMAL\":1",
                   "\"NORMAL\":1,\"JOINTS_0\":4,\"WEIGHTS_0\":5");
    char *b = edit(a, "\"byteLength\":144", "\"byteLength\":352");
    char *c = edit(b, "\"byteLength\":12}",
                   "\"byteLength\":12},"
                   "{\"buffer\":0,\"byteOffset\":144,\"byteLength\":208}");
    char *d =
        edit(c, "\"type\":\"SCALAR\"}",
             "\"type\":\"SCALAR\"},"
             "{\"bufferView\":2,\"componentType\":5121,\"count\":4,\"type\":\"VEC4\"},"
             "{\"bufferView\":2,\"byteOffset\":16,\"componentType\":5126,\"count\":4,"
             "\"type\":\"VEC4\"},"
             "{\"bufferView\":2,\"byteOffset\":80,\"componentType\":5126,\"count\":2,"
             "\"type\":\"MAT4\"}");
    char *json = edit(d, "\"nodes\":[{\"mesh\":0}]",
                      "\"nodes\":[{\"mesh\":0,\"skin\":0,\"translation\":[0,0,99]},"
                      "{\"translation\":[10,0,0]},{\"rotation\":[0,0,1,0]}],"
                      "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":6}]");
    struct pbnds_scene s;
    must_load(json, &bin, sizeof bin, &s);
    const struct pbnds_mesh *m = &s.meshes[0];
    assert_vec3(m->position[0], 9, 0, 0, 1e-5); /* (0,0,0) -> (-1,0,0) -> +10 */
    assert_vec3(m->position[1], 5, 0, 0,
                1e-5); /* (0,0,0): mean of (10,0,0) and itself */
    assert_vec3(m->position[2], 0, -1, 0, 1e-5); /* (0,1,0) turned */
    assert_vec3(m->position[3], 9, 1, 0, 1e-5);  /* weights are normalised */
    assert_vec3(m->normal[2], 0, 0, 1, 1e-5);
    pbnds_scene_free(&s);
    bin.joints[0] = 2; /* the skin has two */
    assert_int_equal(load(json, &bin, sizeof bin, &s), PBNDS_ERROR_FORMAT);
    free(a);
    free(b);
    free(c);
    free(d);
    free(json);
}

static void tangents_of_a_picture(void **state)
{
    (void)state;
    /* An upright picture on the square: tangent +x, bitangent (up in the picture) +y.
     * Mirrored uv turn both the tangent and the handedness. */
    for (int mirror = 0; mirror < 2; ++mirror) {
        struct square bin = square;
        for (int i = 0; mirror && i < 4; ++i)
            bin.uv[2 * i] = 1.0f - bin.uv[2 * i];
        struct pbnds_scene s;
        char *a = edit(square_json, "\"indices\":3", "\"indices\":3,\"material\":0");
        char *json =
            edit(a, "\"buffers\"",
                 "\"materials\":[{\"normalTexture\":{\"index\":0,\"scale\":0.5}}],"
                 "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":"
                 "\"data:image/png;base64," PNG_BASE64 "\"}],\"buffers\"");
        must_load(json, &bin, sizeof bin, &s);
        assert_near((double)s.materials[0].normal_scale, 0.5, 0);
        for (int i = 0; i < 4; ++i) {
            const struct pbnds_vec4 t = s.meshes[0].tangent[i];
            const struct pbnds_vec3 direction = {t.x, t.y, t.z};
            assert_vec3(direction, mirror ? -1 : 1, 0, 0, 1e-6);
            assert_vec3(pbnds_scale(pbnds_cross(s.meshes[0].normal[i], direction), t.w),
                        0, 1, 0, 1e-6);
        }
        pbnds_scene_free(&s);
        free(a);
        free(json);
    }
}

static void degenerate_uv_give_unit_tangents(void **state)
{
    (void)state;
    struct pbnds_scene s;
    must_load(square_json, &square, sizeof square, &s);
    for (int i = 0; i < 4; ++i)
        s.meshes[0].uv[0][i] = (struct pbnds_vec2){0.5f, 0.5f};
    assert_int_equal(pbnds_mesh_tangents(&s.meshes[0], 0, "x", &fault), PBNDS_OK);
    for (int i = 0; i < 4; ++i) {
        const struct pbnds_vec4 t = s.meshes[0].tangent[i];
        assert_near(hypot(hypot((double)t.x, (double)t.y), (double)t.z), 1.0, 1e-6);
        assert_near((double)t.z, 0.0, 1e-6);
    }
    pbnds_scene_free(&s);
}

static void crushed_normals_are_repaired(void **state)
{
    (void)state;
    /* Zero normals in the file; and a scale of zero that leaves no normal at all. */
    struct square bin = square;
    memset(bin.normal, 0, sizeof bin.normal);
    struct pbnds_scene s;
    must_load(square_json, &bin, sizeof bin, &s);
    for (int i = 0; i < 4; ++i)
        assert_vec3(s.meshes[0].normal[i], 0, 0, 1, 1e-6);
    pbnds_scene_free(&s);
    load_edit("{\"mesh\":0}", "{\"mesh\":0,\"scale\":[0,0,0]}", &s);
    for (int i = 0; i < 4; ++i)
        assert_near((double)pbnds_length(s.meshes[0].normal[i]), 1, 0);
    pbnds_scene_free(&s);
}

/* ---- materials, textures, cameras ---------------------------------------------- */

static void materials_are_read(void **state)
{
    (void)state;
    struct pbnds_scene s;
    char *a = edit(square_json, "\"indices\":3", "\"indices\":3,\"material\":1");
    char *json = edit(
        a, "\"buffers\"",
        "\"materials\":[{},{\"name\":\"gold\",\"pbrMetallicRoughness\":{"
        "\"baseColorFactor\":"
        "[0.1,0.2,0.3,0.4],\"metallicFactor\":0.5,\"roughnessFactor\":0.25,"
        "\"baseColorTexture\":{\"index\":1,\"texCoord\":1},"
        "\"metallicRoughnessTexture\":{\"index\":0}},"
        "\"emissiveFactor\":[1,0.5,0],\"emissiveTexture\":{\"index\":2},"
        "\"alphaMode\":\"MASK\",\"alphaCutoff\":0.75,"
        "\"doubleSided\":true,\"extensions\":{\"KHR_materials_emissive_strength\":"
        "{\"emissiveStrength\":8},\"KHR_materials_ior\":{\"ior\":2},"
        "\"KHR_materials_specular\":{\"specularFactor\":0.5}}},"
        "{\"alphaMode\":\"BLEND\",\"extensions\":{\"KHR_materials_ior\":{\"ior\":0}}}],"
        "\"textures\":[{\"source\":0},{\"source\":0,\"sampler\":0},{\"source\":1},{"
        "\"source\":"
        "1}],\"samplers\":[{\"wrapS\":33071,\"wrapT\":33648,\"magFilter\":9728}],"
        "\"images\":[{\"uri\":\"data:image/png;base64," PNG_BASE64 "\"},"
        "{\"uri\":\"data:;base64," PNG_BASE64 "\"}],"
        "\"extensionsUsed\":[\"KHR_materials_ior\",\"KHR_lights_punctual\"],"
        "\"buffers\"");
    must_load(json, &square, sizeof square, &s);
    assert_int_equal(s.material_count, 4); /* the default at the end */
    assert_int_equal(s.meshes[0].material, 1);
    const struct pbnds_material *m = &s.materials[1];
    assert_string_equal(m->name, "gold");
    assert_near((double)m->base_color.w, 0.4, 1e-7);
    assert_near((double)m->metallic, 0.5, 0);
    assert_near((double)m->roughness, 0.25, 0);
    assert_near((double)m->ior_f0, 1.0 / 9.0, 1e-7);
    assert_near((double)m->specular, 0.5, 0);
    assert_vec3(m->emissive, 8, 4, 0, 0);
    assert_int_equal(m->alpha_mode, PBNDS_ALPHA_MASK);
    assert_near((double)m->alpha_cutoff, 0.75, 0);
    assert_true(m->double_sided);
    assert_int_equal(m->normal_texture.texture, -1);
    assert_int_equal(m->base_color_texture.texcoord, 1);
    assert_int_equal(s.materials[2].alpha_mode, PBNDS_ALPHA_BLEND);
    assert_near((double)s.materials[2].ior_f0, 1.0, 0);
    assert_near((double)s.materials[3].roughness, 1.0, 0);
    /* Three of four textures are used, both images decoded once. */
    assert_int_equal(s.texture_count, 3);
    assert_int_equal(s.image_count, 2);
    const struct pbnds_texture *t = &s.textures[m->base_color_texture.texture];
    assert_int_equal(t->wrap_u, PBNDS_WRAP_CLAMP);
    assert_int_equal(t->wrap_v, PBNDS_WRAP_MIRROR);
    assert_true(t->nearest);
    assert_ptr_equal(t->pixels,
                     s.textures[m->metallic_roughness_texture.texture].pixels);
    assert_ptr_not_equal(t->pixels, s.textures[m->emissive_texture.texture].pixels);
    const struct pbnds_vec4 c =
        pbnds_texture_sample(t, (struct pbnds_vec2){0.75f, 0.5f}, true);
    assert_near((double)c.x, 0, 0);
    assert_near((double)c.y, 1, 0);
    assert_near((double)c.w, 128.0 / 255.0, 1e-7);
    assert_non_null(strstr(warnings, "KHR_lights_punctual"));
    assert_null(strstr(warnings, "KHR_materials_ior"));
    pbnds_scene_free(&s);
    free(a);
    free(json);
}

static void cameras_are_rigid(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_edit(
        "\"nodes\":[{\"mesh\":0}]",
        "\"cameras\":[{\"type\":\"perspective\",\"name\":\"eye\",\"perspective\":"
        "{\"yfov\":0.7,\"znear\":0.1}},"
        "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":2.5,"
        "\"znear\":0,"
        "\"zfar\":9}}],"
        "\"nodes\":[{\"children\":[1,2],\"scale\":[2,-3,4],\"translation\":[1,2,3]},"
        "{\"camera\":0,\"rotation\":[0,0.70710678,0,0.70710678],"
        "\"translation\":[1,1,1]},{\"camera\":1,\"name\":\"from "
        "above\"},{\"camera\":0}]",
        &s);
    assert_int_equal(s.camera_count, 2); /* node 3 is in no scene */
    assert_string_equal(s.cameras[0].name, "eye");
    assert_string_equal(s.cameras[1].name, "from above");
    assert_false(s.cameras[0].orthographic);
    assert_true(s.cameras[1].orthographic);
    assert_near((double)s.cameras[0].yfov, 0.7, 1e-7);
    assert_near((double)s.cameras[1].ymag, 2.5, 1e-7);
    for (int i = 0; i < 2; ++i) {
        const struct pbnds_mat4 *m = &s.cameras[i].world_from_camera;
        assert_near((double)pbnds_mat4_det3(m), 1.0, 1e-5);
        for (int c = 0; c < 9; ++c) {
            double dot = 0;
            for (int r = 0; r < 3; ++r) {
                dot += (double)m->m[4 * (c / 3) + r] * (double)m->m[4 * (c % 3) + r];
            }
            assert_near(dot, c / 3 == c % 3 ? 1.0 : 0.0, 1e-5);
        }
    }
    const struct pbnds_mat4 *m = &s.cameras[0].world_from_camera;
    assert_vec3(pbnds_vec3_make(m->m[12], m->m[13], m->m[14]), 3, -1, 7, 1e-5);
    /* A quarter about y takes the local z axis to +x. */
    assert_vec3(pbnds_vec3_make(m->m[8], m->m[9], m->m[10]), 1, 0, 0, 1e-5);
    pbnds_scene_free(&s);
}

static void long_names_are_cut_at_a_character(void **state)
{
    (void)state;
    char name[300] = "\"name\":\"";
    for (int i = 0; i < 31; ++i)
        strcat(name, "\xc3\xa4"); /* 62 bytes of two each */
    strcat(name, "x\xc3\xa4\"");  /* byte 63 and beyond  */
    struct pbnds_scene s;
    load_edit("\"name\":\"square\"", name, &s);
    assert_int_equal(strlen(s.meshes[0].name), 63);
    assert_int_equal(s.meshes[0].name[62], 'x');
    pbnds_scene_free(&s);
}

/* ---- bad input ------------------------------------------------------------------- */

static void faults_are_told(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to;
        enum pbnds_status status;
    } cases[] = {
        {"\"POSITION\":0", "\"POSITION\":4", PBNDS_ERROR_FORMAT},
        {"\"POSITION\":0", "\"POSITION\":-1", PBNDS_ERROR_FORMAT},
        {"\"POSITION\":0", "\"POSITION\":4294967296", PBNDS_ERROR_FORMAT},
        {"\"POSITION\":0", "\"POSITION\":2", PBNDS_ERROR_FORMAT}, /* VEC2 */
        {"\"POSITION\":0", "\"POSITION\":0.5", PBNDS_ERROR_FORMAT},
        {"\"NORMAL\":1", "\"NORMAL\":3", PBNDS_ERROR_FORMAT},
        {"\"NORMAL\":1", "\"COLOR_0\":2", PBNDS_ERROR_FORMAT},
        {"\"indices\":3", "\"indices\":4", PBNDS_ERROR_FORMAT},
        {"\"indices\":3", "\"indices\":0", PBNDS_ERROR_FORMAT},
        {"\"indices\":3", "\"indices\":3,\"material\":0", PBNDS_ERROR_FORMAT},
        {"\"indices\":3", "\"indices\":3,\"mode\":7", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":1", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"skin\":0", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"camera\":0", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"children\":[0]", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"children\":[1]", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"children\":[-1]", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"matrix\":[1,2,3]", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"scale\":[1e39,1,1]", PBNDS_ERROR_FORMAT},
        {"{\"mesh\":0}", "{},{\"children\":[2]},{\"children\":[1]}",
         PBNDS_ERROR_FORMAT},
        {"{\"mesh\":0}", "{\"children\":[1,2]},{\"children\":[2]},{}",
         PBNDS_ERROR_FORMAT},
        {"\"scene\":0", "\"scene\":1", PBNDS_ERROR_FORMAT},
        {"\"nodes\":[0]", "\"nodes\":[1]", PBNDS_ERROR_FORMAT},
        {"\"nodes\":[0]", "\"nodes\":[-1]", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"byteLength\":148", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"byteLength\":-1", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"byteLength\":18446744073709551615",
         PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"byteLength\":\"144\"", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"uri\":7,\"byteLength\":144", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":128", "\"byteLength\":145", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":128", "\"byteLength\":128,\"byteStride\":8",
         PBNDS_ERROR_FORMAT},
        {"\"byteLength\":128", "\"byteLength\":128,\"byteStride\":44",
         PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":128", "\"byteOffset\":133", PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":128", "\"byteOffset\":2147483647", PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":48", "\"byteOffset\":81", PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":48", "\"byteOffset\":120", PBNDS_ERROR_FORMAT},
        {"{\"nodes\":[0]}],\"nodes\":[{",
         "{\"nodes\":[1]}],\"nodes\":[{\"children\":[1]},{",
         PBNDS_ERROR_FORMAT}, /* a scene of a node that is no root */
        {"\"bufferView\":1", "\"bufferView\":2", PBNDS_ERROR_FORMAT},
        {"\"buffer\":0", "\"buffer\":1", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":5", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":2147483647", PBNDS_ERROR_FORMAT},
        {"\"count\":6", "\"count\":2147483647", PBNDS_ERROR_FORMAT},
        {"\"componentType\":5123", "\"componentType\":5126", PBNDS_ERROR_FORMAT},
        {"\"componentType\":5123", "\"componentType\":5122", PBNDS_ERROR_FORMAT},
        {"\"componentType\":5126", "\"componentType\":5130", PBNDS_ERROR_FORMAT},
        {"\"version\":\"2.0\"", "\"version\":\"1.0\"", PBNDS_ERROR_UNSUPPORTED},
        {"\"version\":\"2.0\"", "\"version\":\"x\"", PBNDS_ERROR_FORMAT},
        {"\"version\":\"2.0\"", "\"version\":\"2.0\",\"minVersion\":\"2.9\"",
         PBNDS_ERROR_UNSUPPORTED},
        {"\"asset\"", "\"atlas\"", PBNDS_ERROR_FORMAT},
        {"\"buffers\"",
         "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"buffers\"",
         PBNDS_ERROR_UNSUPPORTED},
        {"\"buffers\"", "\"buffers\":[],\"buffers\"", PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"materials\":[{\"alphaMode\":\"GLASS\"}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"materials\":[{\"normalTexture\":{\"index\":0}}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"materials\":[{\"emissiveFactor\":[-1,0,0]}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"textures\":[{\"source\":0}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"textures\":[{\"sampler\":0}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"skins\":[{\"joints\":[1]}],\"buffers\"", PBNDS_ERROR_FORMAT},
        {"\"buffers\"",
         "\"images\":[{\"bufferView\":0}],\"textures\":[{\"source\":0}],"
         "\"materials\":[{\"normalTexture\":{\"index\":0}}],\"buffers\"",
         PBNDS_ERROR_UNSUPPORTED}, /* of no known picture format */
        {"\"buffers\"",
         "\"images\":[{\"uri\":\"data:image/png;base64,####\"}],\"textures\":"
         "[{\"source\":0}],\"materials\":[{\"normalTexture\":{\"index\":0}}],"
         "\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"",
         "\"images\":[{\"uri\":\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAI\"}],"
         "\"textures\":[{\"source\":0}],\"materials\":[{\"normalTexture\":{\"index\":0}"
         "}],"
         "\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"",
         "\"images\":[{\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}],"
         "\"materials\":[{\"normalTexture\":{\"index\":0}}],\"buffers\"",
         PBNDS_ERROR_IO}, /* from memory no file may be opened */
        {"\"indices\":3}]}],", "\"indices\":3}]},", PBNDS_ERROR_FORMAT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_scene s;
        char *json = edit(square_json, cases[i].from, cases[i].to);
        const enum pbnds_status status = load(json, &square, sizeof square, &s);
        if (status != cases[i].status) {
            fail_msg("%s -> %s gives %d, not %d: %s", cases[i].from, cases[i].to,
                     status, cases[i].status, fault.message);
        }
        free(json);
    }
}

static void ranges_end_with_their_view(void **state)
{
    (void)state;
    /* Views end at 128: an offset so near to it that not one element fits. */
    for (int offset = 81; offset < 140; ++offset) {
        char text[40];
        (void)snprintf(text, sizeof text, "\"byteOffset\":%d", offset);
        char *json = edit(square_json, "\"byteOffset\":48", text);
        struct pbnds_scene s;
        assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(fault.message, "beyond the end of bufferView 0"));
        free(json);
    }
}

static void numbers_in_extras_are_free(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_edit("\"mesh\":0", "\"mesh\":0,\"extras\":{\"count\":-1,\"mesh\":1e300}", &s);
    pbnds_scene_free(&s);
}

static void vertices_must_be_finite(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * 32; ++i) {
        struct square bin = square;
        ((float *)&bin)[i / 3] = bad[i % 3]; /* positions, normals, uv in turn */
        struct pbnds_scene s;
        assert_int_equal(load(square_json, &bin, sizeof bin, &s), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(fault.message, "finite"));
    }
}

static void indices_must_be_in_range(void **state)
{
    (void)state;
    for (int i = 0; i < 6; ++i) {
        struct square bin = square;
        struct pbnds_scene s;
        bin.index[i] = 4;
        assert_int_equal(load(square_json, &bin, sizeof bin, &s), PBNDS_ERROR_FORMAT);
        bin.index[i] = 65535;
        assert_int_equal(load(square_json, &bin, sizeof bin, &s), PBNDS_ERROR_FORMAT);
    }
}

static void truncation_at_every_byte_is_told(void **state)
{
    (void)state;
    size_t size = 0;
    uint8_t *glb = make_glb(square_json, &square, sizeof square, &size);
    for (size_t n = 0; n < size; ++n) {
        uint8_t *part = malloc(n + 1); /* its own block: a read beyond it is seen */
        struct pbnds_scene s;
        memcpy(part, glb, n);
        const enum pbnds_status status =
            pbnds_gltf_load_memory(part, n, "part.glb", NULL, NULL, NULL, &s, &fault);
        if (status != PBNDS_ERROR_FORMAT)
            fail_msg("%zu of %zu bytes: %d", n, size, status);
        free(part);
    }
    /* The JSON alone, as .gltf, cut at every byte. */
    for (size_t n = 0; n + 1 < sizeof square_json; ++n) {
        struct pbnds_scene s;
        const enum pbnds_status status = pbnds_gltf_load_memory(
            square_json, n, "part.gltf", NULL, NULL, NULL, &s, &fault);
        if (status != PBNDS_ERROR_FORMAT) fail_msg("%zu bytes of JSON: %d", n, status);
    }
    free(glb);
}

/** Is what a load gives sound enough for a ray caster? */
static void assert_sound(const struct pbnds_scene *s)
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

static void damage_at_every_byte_is_survived(void **state)
{
    (void)state;
    static const uint8_t damage[] = {0x00, 0xff, '9', '"', '-', '['};
    size_t size = 0;
    uint8_t *glb = make_glb(square_json, &square, sizeof square, &size);
    int loaded = 0;
    for (size_t i = 0; i < size; ++i) {
        for (size_t k = 0; k < sizeof damage; ++k) {
            const uint8_t kept = glb[i];
            struct pbnds_scene s;
            glb[i] = damage[k];
            if (pbnds_gltf_load_memory(glb, size, "bad.glb", NULL, NULL, NULL, &s,
                                       &fault) == PBNDS_OK) {
                assert_sound(&s);
                ++loaded;
            } else {
                assert_non_null(strstr(fault.message, "bad.glb"));
            }
            pbnds_scene_free(&s);
            glb[i] = kept;
        }
    }
    assert_true(loaded > 0); /* e.g. in names */
    free(glb);
}

static void deep_json_is_refused(void **state)
{
    (void)state;
    enum { DEPTH = 200000 };
    char *deep = malloc(2 * DEPTH + 100);
    const char *head = "\"mesh\":0,\"extras\":";
    strcpy(deep, head);
    memset(deep + strlen(head), '[', DEPTH);
    memset(deep + strlen(head) + DEPTH, ']', DEPTH);
    deep[strlen(head) + 2 * DEPTH] = 0;
    char *json = edit(square_json, "\"mesh\":0", deep);
    struct pbnds_scene s;
    assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(fault.message, "deep"));
    free(deep);
    free(json);
}

static void instances_cannot_fill_the_memory(void **state)
{
    (void)state;
    /* 16 Mi vertices that cost no byte, in 64 nodes. */
    char nodes[2000] = "\"nodes\":[{\"mesh\":0}", list[400] = "{\"nodes\":[0";
    for (int i = 1; i < 64; ++i) {
        strcat(nodes, ",{\"mesh\":0}");
        (void)sprintf(list + strlen(list), ",%d", i);
    }
    strcat(nodes, "]");
    strcat(list, "]}");
    char *a = edit(square_json, "\"nodes\":[{\"mesh\":0}]", nodes);
    char *b = edit(a, "{\"nodes\":[0]}", list);
    static const char head[] = "{\"bufferView\":0,\"componentType\":5126,\"count\":4";
    char *c = edit(b, head, "{\"componentType\":5126,\"count\":16777216");
    struct pbnds_scene s;
    assert_int_equal(load(c, &square, sizeof square, &s), PBNDS_ERROR_MEMORY);
    /* One accessor without data has a limit of its own. */
    char *d = edit(square_json, head, "{\"componentType\":5126,\"count\":16777217");
    assert_int_equal(load(d, &square, sizeof square, &s), PBNDS_ERROR_UNSUPPORTED);
    free(a);
    free(b);
    free(c);
    free(d);
}

/* ---- containers and files ---------------------------------------------------------
 */

static void write_file(const char *path, const void *data, size_t size)
{
    assert_int_equal(pbnds_file_write(path, data, size, &fault), PBNDS_OK);
}

/** Writes the square as a .gltf whose buffer is `uri`, and loads it. */
static enum pbnds_status load_uri(const char *folder, const char *uri,
                                  struct pbnds_scene *s)
{
    char path[300], buffer[400];
    (void)snprintf(path, sizeof path, "%s/square.gltf", folder);
    (void)snprintf(buffer, sizeof buffer, "{\"byteLength\":144,\"uri\":\"%s\"}", uri);
    char *json = edit(square_json, "{\"byteLength\":144}", buffer);
    write_file(path, json, strlen(json));
    free(json);
    return pbnds_gltf_load(path, NULL, &ear, s, &fault);
}

static void uris_stay_below_the_folder(void **state)
{
    (void)state;
    static const struct {
        const char *uri;
        enum pbnds_status status;
    } cases[] = {
        {"a.bin", PBNDS_OK},
        {"./a.bin", PBNDS_OK},
        {"sub/a.bin", PBNDS_OK},
        {"sub//a.bin", PBNDS_OK},
        {"with%20space.bin", PBNDS_OK},
        {"with space.bin", PBNDS_OK},
        {"one+one.bin", PBNDS_OK},
        {"100%.bin", PBNDS_OK},
        {"\\u0061.bin", PBNDS_OK},
        {"sub\\/a.bin", PBNDS_OK},
        {"long.bin", PBNDS_OK},   /* longer than byteLength is fine */
        {"inside.bin", PBNDS_OK}, /* a link that stays inside */
        {"short.bin", PBNDS_ERROR_FORMAT},
        {"empty.bin", PBNDS_ERROR_FORMAT},
        {"none.bin", PBNDS_ERROR_IO},
        {"sub", PBNDS_ERROR_IO},
        {"pipe", PBNDS_ERROR_IO}, /* must not block */
        {"", PBNDS_ERROR_FORMAT},
        {"../jail-outside.bin", PBNDS_ERROR_FORMAT},
        {"sub/../a.bin", PBNDS_ERROR_FORMAT},
        {"%2e%2e/jail-outside.bin", PBNDS_ERROR_FORMAT},
        {"sub/%2E%2E/%2e%2e/jail-outside.bin", PBNDS_ERROR_FORMAT},
        {"..\\\\jail-outside.bin", PBNDS_ERROR_FORMAT},
        {"a.bin%00.png", PBNDS_ERROR_FORMAT},
        {"/etc/passwd", PBNDS_ERROR_FORMAT},
        {"//etc/passwd", PBNDS_ERROR_FORMAT},
        {"%2fetc/passwd", PBNDS_ERROR_FORMAT},
        {"file:a.bin", PBNDS_ERROR_FORMAT},
        {"file:///etc/passwd", PBNDS_ERROR_FORMAT},
        {"http://localhost/a.bin", PBNDS_ERROR_FORMAT},
        {"outside.bin", PBNDS_ERROR_FORMAT},         /* a link out */
        {"up/jail-outside.bin", PBNDS_ERROR_FORMAT}, /* through a linked folder */
        {"data:application/octet-stream;base64,AAAA", PBNDS_ERROR_FORMAT}, /* 3 bytes */
        {"data:application/octet-stream", PBNDS_ERROR_FORMAT},
    };
    assert_int_equal(pbnds_make_folder("jail/sub", &fault), PBNDS_OK);
    static const char *const full[] = {"jail/a.bin",          "jail/sub/a.bin",
                                       "jail/with space.bin", "jail/one+one.bin",
                                       "jail/100%.bin",       "jail-outside.bin"};
    for (size_t i = 0; i < 6; ++i)
        write_file(full[i], &square, sizeof square);
    uint8_t longer[200] = {0};
    memcpy(longer, &square, sizeof square);
    write_file("jail/long.bin", longer, sizeof longer);
    write_file("jail/short.bin", longer, 143);
    write_file("jail/empty.bin", longer, 0);
    (void)unlink("jail/outside.bin");
    (void)unlink("jail/inside.bin");
    (void)unlink("jail/up");
    (void)unlink("jail/pipe");
    assert_int_equal(symlink("../jail-outside.bin", "jail/outside.bin"), 0);
    assert_int_equal(symlink("sub/a.bin", "jail/inside.bin"), 0);
    assert_int_equal(symlink("..", "jail/up"), 0);
    assert_int_equal(mkfifo("jail/pipe", 0600), 0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_scene s;
        const enum pbnds_status status = load_uri("jail", cases[i].uri, &s);
        if (status != cases[i].status) {
            fail_msg("%s gives %d, not %d: %s", cases[i].uri, status, cases[i].status,
                     status ? fault.message : "");
        }
        if (status == PBNDS_OK) assert_int_equal(s.triangle_count, 2);
        pbnds_scene_free(&s);
    }
}

static void a_file_needs_no_folder(void **state)
{
    (void)state;
    struct pbnds_scene s;
    size_t size = 0;
    uint8_t *glb = make_glb(square_json, &square, sizeof square, &size);
    write_file("square.glb", glb, size);
    free(glb);
    assert_int_equal(pbnds_gltf_load("square.glb", NULL, NULL, &s, NULL), PBNDS_OK);
    pbnds_scene_free(&s);
    assert_int_equal(pbnds_gltf_load("no-such.glb", NULL, NULL, &s, &fault),
                     PBNDS_ERROR_IO);
    assert_non_null(strstr(fault.message, "no-such.glb"));
    assert_int_equal(pbnds_gltf_load(".", NULL, NULL, &s, &fault), PBNDS_ERROR_IO);
    write_file("empty.glb", "", 0);
    assert_int_equal(pbnds_gltf_load("empty.glb", NULL, NULL, &s, &fault),
                     PBNDS_ERROR_FORMAT);
    write_file("magic.glb", "GLTF\2\0\0\0\24\0\0\0\0\0\0\0JSON", 20);
    assert_int_equal(pbnds_gltf_load("magic.glb", NULL, NULL, &s, &fault),
                     PBNDS_ERROR_FORMAT);
}

static void other_chunks_are_passed_over(void **state)
{
    (void)state;
    size_t size = 0;
    uint8_t *glb = make_glb(square_json, &square, sizeof square, &size);
    uint8_t *more = malloc(size + 20);
    struct pbnds_scene s;
    memcpy(more, glb, size);
    memcpy(more + size, "\4\0\0\0XTRAabcdtail....", 20);
    put_u32(more + 8, size + 12); /* a third chunk, and bytes after the end */
    assert_int_equal(pbnds_gltf_load_memory(more, size + 20, "more.glb", NULL, NULL,
                                            NULL, &s, &fault),
                     PBNDS_OK);
    assert_int_equal(s.triangle_count, 2);
    pbnds_scene_free(&s);
    /* A BIN chunk that claims more than there is, in a header that claims no more. */
    put_u32(glb + size - sizeof square - 8, sizeof square + 4);
    assert_int_equal(
        pbnds_gltf_load_memory(glb, size, "chunk.glb", NULL, NULL, NULL, &s, &fault),
        PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(fault.message, "chunk 1"));
    free(glb);
    free(more);
}

/* ---- the shared models --------------------------------------------------------------
 */

static int files_seen, files_loaded;

static bool ends_with(const char *path, const char *end)
{
    const size_t a = strlen(path), b = strlen(end);
    return a >= b && strcmp(path + a - b, end) == 0;
}

static int try_file(const char *path, const struct stat *info, int type,
                    struct FTW *ftw)
{
    (void)info;
    (void)ftw;
    if (type != FTW_F || (!ends_with(path, ".glb") && !ends_with(path, ".gltf")))
        return 0;
    struct pbnds_scene s;
    warnings[0] = 0;
    const enum pbnds_status status = pbnds_gltf_load(path, NULL, &ear, &s, &fault);
    ++files_seen;
    if (status == PBNDS_OK) {
        ++files_loaded;
        assert_sound(&s);
    } else {
        assert_true(status == PBNDS_ERROR_FORMAT || status == PBNDS_ERROR_UNSUPPORTED ||
                    status == PBNDS_ERROR_IO);
        assert_non_null(strstr(fault.message, path));
        assert_null(strchr(fault.message, '\n'));
    }
    pbnds_scene_free(&s);
    return 0;
}

static void walk(const char *folder)
{
    files_seen = files_loaded = 0;
    if (access(folder, R_OK) != 0) skip();
    assert_int_equal(nftw(folder, try_file, 16, FTW_PHYS), 0);
}

static void shared_models_load(void **state)
{
    (void)state;
    walk(PBNDS_SHARED_DATA "/models");
    assert_true(files_seen > 10);
    assert_int_equal(files_loaded, files_seen);
}

static void malformed_files_are_survived(void **state)
{
    (void)state;
    walk(PBNDS_SHARED_DATA "/malformed");
    assert_true(files_seen > 100);
}

static void known_models_have_known_counts(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        size_t triangles;
        int meshes, cameras, images;
        double height;
    } cases[] = {
        {"BoxVertexColors/BoxVertexColors.glb", 12, 1, 0, 0, 1.0},
        {"Avocado/Avocado.gltf", 682, 1, 0, 3, 0.0629},
        {"CesiumMan/CesiumMan.glb", 4672, 1, 0, 1, 1.5066}, /* a man lying as stored */
        {"CornellBox/cornellBox.glb", 4006, 7, 1, 0, 3.0},
    };
    if (access(PBNDS_SHARED_DATA "/models/objects", R_OK) != 0) skip();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char path[1000];
        struct pbnds_scene s;
        (void)snprintf(path, sizeof path, "%s/models/objects/%s", PBNDS_SHARED_DATA,
                       cases[i].path);
        assert_int_equal(pbnds_gltf_load(path, NULL, NULL, &s, &fault), PBNDS_OK);
        assert_int_equal(s.triangle_count, cases[i].triangles);
        assert_int_equal(s.mesh_count, cases[i].meshes);
        assert_int_equal(s.camera_count, cases[i].cameras);
        assert_int_equal(s.image_count, cases[i].images);
        assert_near((double)(s.hi.y - s.lo.y), cases[i].height, 1e-3);
        pbnds_scene_free(&s);
    }
}

/** Tangents that a baker wrote agree with ours nearly everywhere. */
static void tangents_agree_with_a_baked_model(void **state)
{
    (void)state;
    struct pbnds_scene s;
    if (access(PBNDS_SHARED_DATA "/models/objects/Avocado", R_OK) != 0) skip();
    assert_int_equal(pbnds_gltf_load(PBNDS_SHARED_DATA
                                     "/models/objects/Avocado/Avocado.gltf",
                                     NULL, NULL, &s, &fault),
                     PBNDS_OK);
    struct pbnds_mesh *m = &s.meshes[0];
    struct pbnds_vec4 *baked = m->tangent;
    assert_int_equal(pbnds_mesh_tangents(m, 0, "avocado", &fault), PBNDS_OK);
    size_t alike = 0;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const struct pbnds_vec4 a = baked[i], b = m->tangent[i];
        alike += a.w == b.w && a.x * b.x + a.y * b.y + a.z * b.z > 0.99f;
    }
    assert_true(alike * 100 > m->vertex_count * 98);
    free(baked);
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_square_loads),
        cmocka_unit_test(not_indexed_and_without_normals),
        cmocka_unit_test(transforms_agree_with_the_inverse_transpose),
        cmocka_unit_test(a_mirror_flips_tangents),
        cmocka_unit_test(nodes_make_a_tree),
        cmocka_unit_test(a_deep_tree_needs_no_stack),
        cmocka_unit_test(strips_and_fans_keep_their_front),
        cmocka_unit_test(points_and_lines_are_left_out),
        cmocka_unit_test(attributes_may_be_interleaved_integers),
        cmocka_unit_test(sparse_accessors_overwrite),
        cmocka_unit_test(skins_take_their_rest_pose),
        cmocka_unit_test(tangents_of_a_picture),
        cmocka_unit_test(degenerate_uv_give_unit_tangents),
        cmocka_unit_test(crushed_normals_are_repaired),
        cmocka_unit_test(materials_are_read),
        cmocka_unit_test(cameras_are_rigid),
        cmocka_unit_test(long_names_are_cut_at_a_character),
        cmocka_unit_test(faults_are_told),
        cmocka_unit_test(ranges_end_with_their_view),
        cmocka_unit_test(numbers_in_extras_are_free),
        cmocka_unit_test(vertices_must_be_finite),
        cmocka_unit_test(indices_must_be_in_range),
        cmocka_unit_test(truncation_at_every_byte_is_told),
        cmocka_unit_test(damage_at_every_byte_is_survived),
        cmocka_unit_test(deep_json_is_refused),
        cmocka_unit_test(instances_cannot_fill_the_memory),
        cmocka_unit_test(uris_stay_below_the_folder),
        cmocka_unit_test(a_file_needs_no_folder),
        cmocka_unit_test(other_chunks_are_passed_over),
        cmocka_unit_test(shared_models_load),
        cmocka_unit_test(malformed_files_are_survived),
        cmocka_unit_test(known_models_have_known_counts),
        cmocka_unit_test(tangents_agree_with_a_baked_model),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
