/* Typed reads: component types, strides, sparse values, ranges. */
#include <math.h>

#include "tests/engine/scene/gltf/builder.h"

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

/** COLOR_0 of three and four components, floats and normalised integers. */
static void colours_of_all_types(void **state)
{
    (void)state;
    static const double value[4][4] = {
        {0, 0.2, 0.4, 1}, {1, 0, 0, 0.6}, {0, 1, 0, 0.8}, {0.6, 0.6, 0.6, 0}};
    for (int type = 0; type < 3; ++type) {
        for (size_t width = 3; width <= 4; ++width) {
            struct builder b = build_square();
            float f[16];
            uint8_t bytes[16];
            uint16_t words[16];
            for (size_t i = 0; i < 4 * width; ++i) {
                const double x = value[i / width][i % width];
                f[i] = (float)x;
                bytes[i] = (uint8_t)lround(x * 255);
                words[i] = (uint16_t)lround(x * 65535);
            }
            const char *kind = width == 3 ? "VEC3" : "VEC4";
            static const char normalized[] = ",\"normalized\":true";
            const int color =
                type == 0   ? add_floats(&b, f, 4, (int)width)
                : type == 1 ? add(&b, bytes, 4 * width, UBYTE, kind, 4, normalized)
                            : add(&b, words, 8 * width, USHORT, kind, 4, normalized);
            char rest[400];
            (void)snprintf(rest, sizeof rest,
                           "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{"
                           "\"attributes\":{\"POSITION\":0,\"COLOR_0\":%d},"
                           "\"indices\":3}]}]",
                           color);
            struct pbnds_scene s;
            must_build(&b, rest, NULL, &s);
            for (int i = 0; i < 4; ++i) {
                const struct pbnds_vec4 c = s.meshes[0].color[i];
                assert_vec3(pbnds_vec3_make(c.x, c.y, c.z), value[i][0], value[i][1],
                            value[i][2], 1e-5);
                assert_near((double)c.w, width == 3 ? 1 : value[i][3], 1e-5);
            }
            pbnds_scene_free(&s);
        }
    }
}

/** KHR_mesh_quantization: positions, normals, tangents and UVs of small integers, with the
 *  node that scales them back. */
static void quantised_attributes_are_decoded(void **state)
{
    (void)state;
    static const int8_t position8[] = {-127, -127, 0, 0, 127,  -127, 0, 0,
                                       127,  127,  0, 0, -127, 127,  0, 0};
    static const uint16_t position16[] = {0,     0,     7, 0, 65535, 0,     7, 0,
                                          65535, 65535, 7, 0, 0,     65535, 7, 0};
    static const int8_t normal[] = {0, 0, 127, 0, 0, 0, 127, 0,
                                    0, 0, 127, 0, 0, 0, 127, 0};
    static const int16_t tangent[] = {32767, 0, 0, -32767, 32767, 0, 0, -32767,
                                      32767, 0, 0, -32767, 32767, 0, 0, -32767};
    static const int16_t uv[] = {-3, 4, 5, -6, 700, 8, 9, 10};
    struct builder b = build_square();
    static const char normalized[] = ",\"normalized\":true";
    const int p8 = add(&b, position8, 16, BYTE, "VEC3", 4, normalized);
    const int p16 = add(&b, position16, 32, USHORT, "VEC3", 4, "");
    const int n = add(&b, normal, 16, BYTE, "VEC3", 4, normalized);
    const int t = add(&b, tangent, 32, SHORT, "VEC4", 4, normalized);
    const int u = add(&b, uv, 16, SHORT, "VEC2", 4, "");
    /* VEC3 of bytes and shorts start at multiples of four: strides 4 and 8. */
    static const char *const steps[4][2] = {
        {"\"byteLength\":16}", "\"byteLength\":16,\"byteStride\":4}"},
        {"\"byteLength\":16}", "\"byteLength\":16,\"byteStride\":4}"},
        {"\"byteLength\":32}", "\"byteLength\":32,\"byteStride\":8}"}, /* the uv */
        {"\"byteLength\":32}", "\"byteLength\":32,\"byteStride\":8}"},
    };
    for (int i = 0; i < 4; ++i) {
        char *changed = edit(b.views, steps[i][0], steps[i][1]);
        (void)snprintf(b.views, sizeof b.views, "%s", changed);
        free(changed);
    }
    for (int kind = 0; kind < 2; ++kind) {
        char rest[600];
        (void)snprintf(rest, sizeof rest,
                       "\"extensionsRequired\":[\"KHR_mesh_quantization\"],\"nodes\":[{"
                       "\"mesh\":0,\"scale\":[%s]}],\"meshes\":[{\"primitives\":[{"
                       "\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"TANGENT\":%d,"
                       "\"TEXCOORD_0\":%d},\"indices\":3}]}]",
                       kind ? "0.0000152590219,0.0000152590219,1" : "1,1,1",
                       kind ? p16 : p8, n, t, u);
        struct pbnds_scene s;
        must_build(&b, rest, NULL, &s);
        const struct pbnds_mesh *m = &s.meshes[0];
        assert_vec3(m->position[0], kind ? 0 : -1, kind ? 0 : -1, kind ? 7 : 0, 1e-6);
        assert_vec3(m->position[2], 1, 1, kind ? 7 : 0, 1e-6);
        assert_vec3(m->normal[1], 0, 0, 1, 1e-6);
        assert_near((double)m->tangent[3].x, 1, 1e-6);
        assert_true(m->tangent[3].w == -1.0f);
        assert_true(m->uv[0][0].x == -3.0f && m->uv[0][2].x == 700.0f);
        pbnds_scene_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes_may_be_interleaved_integers),
        cmocka_unit_test(sparse_accessors_overwrite),
        cmocka_unit_test(colours_of_all_types),
        cmocka_unit_test(quantised_attributes_are_decoded),
        cmocka_unit_test(ranges_end_with_their_view),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
