/* Typed reads: component types, strides, sparse values, ranges. */
#include "tests/engine/scene/gltf/fixture.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes_may_be_interleaved_integers),
        cmocka_unit_test(sparse_accessors_overwrite),
        cmocka_unit_test(ranges_end_with_their_view),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
