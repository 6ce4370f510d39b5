/* Primitives to triangles in world space. */
#include <math.h>

#include "tests/engine/scene/gltf/builder.h"

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

/* glTF 2.0, section 3.7.2.1: without normals, tangents are to be ignored. */
static void tangents_without_normals_are_ignored(void **state)
{
    (void)state;
    static const float tangents[16] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
    struct builder b = build_square();
    (void)add_floats(&b, tangents, 4, 4);
    for (int normals = 0; normals < 2; ++normals) {
        struct pbnds_scene s;
        must_build(
            &b,
            normals ? "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{"
                      "\"attributes\":{\"POSITION\":0,\"TANGENT\":4,\"NORMAL\":1}}]}]"
                    : "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{"
                      "\"attributes\":{\"POSITION\":0,\"TANGENT\":4}}]}]",
            NULL, &s);
        assert_int_equal(s.meshes[0].tangent != NULL, normals);
        assert_int_equal(s.meshes[0].normal != NULL, normals);
        pbnds_scene_free(&s);
    }
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_square_loads),
        cmocka_unit_test(not_indexed_and_without_normals),
        cmocka_unit_test(a_mirror_flips_tangents),
        cmocka_unit_test(tangents_without_normals_are_ignored),
        cmocka_unit_test(strips_and_fans_keep_their_front),
        cmocka_unit_test(points_and_lines_are_left_out),
        cmocka_unit_test(crushed_normals_are_repaired),
        cmocka_unit_test(long_names_are_cut_at_a_character),
        cmocka_unit_test(vertices_must_be_finite),
        cmocka_unit_test(indices_must_be_in_range),
        cmocka_unit_test(instances_cannot_fill_the_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
