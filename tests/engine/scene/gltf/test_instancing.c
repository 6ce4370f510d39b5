/* EXT_mesh_gpu_instancing. */
#include <math.h>

#include "tests/engine/scene/gltf/builder.h"

static const char mesh[] =
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},"
    "\"indices\":3},{\"attributes\":{\"POSITION\":0},\"indices\":3}]}]";

static enum pbnds_status load_instances(const struct builder *b, const char *attributes,
                                        const char *node,
                                        const struct pbnds_gltf_options *options,
                                        struct pbnds_scene *s)
{
    char rest[1500];
    (void)snprintf(rest, sizeof rest,
                   "\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"],"
                   "\"nodes\":[{},{\"mesh\":0%s,\"extensions\":{"
                   "\"EXT_mesh_gpu_instancing\":{\"attributes\":{%s}}}}],%s",
                   node, attributes, mesh);
    return load_built(b, rest, options, s);
}

static void instances_are_placed(void **state)
{
    (void)state;
    static const float places[] = {0, 0, 0, 5, 0, 0, 0, 7, 0};
    static const float sizes[] = {1, 1, 1, 2, 3, 1, -1, 1, 1};
    /* A quarter about z for the second: floats, normalised bytes and shorts. */
    static const float turns[] = {0,           0,           0, 1, 0, 0,
                                  0.70710678f, 0.70710678f, 0, 0, 0, 1};
    static const int8_t bytes[] = {0, 0, 0, 127, 0, 0, 90, 90, 0, 0, 0, 127};
    static const int16_t shorts[] = {0,     0,     0, 32767, 0, 0,
                                     23170, 23170, 0, 0,     0, 32767};
    for (int kind = 0; kind < 3; ++kind) {
        struct builder b = build_square();
        char attributes[200];
        const int t = add_floats(&b, places, 3, 3), s3 = add_floats(&b, sizes, 3, 3);
        const int r =
            kind == 0   ? add_floats(&b, turns, 3, 4)
            : kind == 1 ? add(&b, bytes, 12, BYTE, "VEC4", 3, ",\"normalized\":true")
                        : add(&b, shorts, 24, SHORT, "VEC4", 3, ",\"normalized\":true");
        (void)snprintf(attributes, sizeof attributes,
                       "\"TRANSLATION\":%d,\"ROTATION\":%d,\"SCALE\":%d,\"_ID\":0", t,
                       r, s3);
        struct pbnds_scene s;
        assert_int_equal(load_instances(&b, attributes,
                                        ",\"translation\":[0,0,9],\"scale\":[2,2,1]",
                                        NULL, &s),
                         PBNDS_OK);
        assert_int_equal(s.mesh_count, 6); /* two primitives, three times each */
        assert_int_equal(s.triangle_count, 12);
        for (int i = 0; i < 6; ++i) {
            const struct pbnds_mesh *m = &s.meshes[i];
            assert_int_equal(m->object_id, 1);
            assert_int_equal(m->material, 0);
            const struct pbnds_vec3 face = pbnds_normalize(face_normal(m, 1));
            assert_vec3(face, 0, 0, 1, 1e-5);           /* the mirrored one too */
            const struct pbnds_vec3 p = m->position[2]; /* (1, 1, 0) of the square */
            if (i % 3 == 0) assert_vec3(p, 2, 2, 9, 1e-5);
            if (i % 3 == 1) assert_vec3(p, 4, 4, 9, 1e-5); /* (2, 3) turned: (-3, 2) */
            if (i % 3 == 2) assert_vec3(p, -2, 16, 9, 1e-5);
        }
        assert_vec3(s.lo, -2, 0, 9, 1e-5);
        assert_vec3(s.hi, 10, 16, 9, 1e-5);
        pbnds_scene_free(&s);
    }
}

static void instances_move_with_their_node(void **state)
{
    (void)state;
    static const float places[] = {1, 0, 0, 2, 0, 0}, times[] = {0, 1};
    static const float path[] = {0, 0, 0, 0, 0, 8};
    struct builder b = build_square();
    const int t = add_floats(&b, places, 2, 3), input = add_floats(&b, times, 2, 1);
    const int output = add_floats(&b, path, 2, 3);
    char rest[1500];
    (void)snprintf(
        rest, sizeof rest,
        "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
        "\"attributes\":{\"TRANSLATION\":%d}}}}],\"animations\":[{"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
        "\"translation\"}}],\"samplers\":[{\"input\":%d,\"output\":%d}]}],%s",
        t, input, output, mesh);
    struct pbnds_gltf_options options = posed_at(0.5);
    options.motion = true;
    options.earlier = 0.25;
    struct pbnds_scene s;
    must_build(&b, rest, &options, &s);
    assert_int_equal(s.mesh_count, 4);
    for (int i = 0; i < 4; ++i) {
        assert_vec3(s.meshes[i].position[0], 1 + i % 2, 0, 4, 1e-6);
        assert_vec3(s.meshes[i].previous[0], 1 + i % 2, 0, 2, 1e-6);
    }
    pbnds_scene_free(&s);
}

static void faulty_instances_are_told(void **state)
{
    (void)state;
    static const float numbers[12] = {0};
    static const struct {
        const char *attributes;
        enum pbnds_status status;
    } cases[] = {
        {"\"TRANSLATION\":4", PBNDS_OK},
        {"", PBNDS_OK},                                        /* once */
        {"\"TRANSLATION\":4,\"SCALE\":5", PBNDS_ERROR_FORMAT}, /* 3 and 2 */
        {"\"TRANSLATION\":44", PBNDS_ERROR_FORMAT},
        {"\"TRANSLATION\":-1", PBNDS_ERROR_FORMAT},
        {"\"TRANSLATION\":\"4\"", PBNDS_ERROR_FORMAT},
        {"\"ROTATION\":4", PBNDS_ERROR_FORMAT}, /* VEC3 */
        {"\"TRANSLATION\":6", PBNDS_OK},        /* none at all */
    };
    struct builder b = build_square();
    (void)add_floats(&b, numbers, 3, 3);
    (void)add_floats(&b, numbers, 2, 3);
    (void)add(&b, numbers, 4, FLOAT, "VEC3", 0, "");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_scene s;
        const enum pbnds_status status =
            load_instances(&b, cases[i].attributes, "", NULL, &s);
        if (status != cases[i].status)
            fail_msg("%s: %d %s", cases[i].attributes, status, fault.message);
        if (i == 1) assert_int_equal(s.mesh_count, 2);
        if (i == 7) assert_int_equal(s.mesh_count, 0);
        pbnds_scene_free(&s);
    }
}

static void a_budget_is_kept(void **state)
{
    (void)state;
    /* 16 Mi instances that cost the file nothing. */
    struct builder b = build_square();
    append(b.accessors, sizeof b.accessors,
           ",{\"componentType\":5126,\"type\":\"VEC3\",\"count\":16777216}");
    struct pbnds_scene s;
    assert_int_equal(load_instances(&b, "\"TRANSLATION\":4", "", NULL, &s),
                     PBNDS_ERROR_MEMORY);
    assert_non_null(strstr(fault.message, "8192 MiB"));
    /* The same of a mesh that has nothing but lines, and so few that each is small. */
    assert_int_equal(load_built(&b,
                                "\"nodes\":[{\"mesh\":0,\"extensions\":{"
                                "\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
                                "\"TRANSLATION\":4}}}}],\"meshes\":[{\"primitives\":[{"
                                "\"mode\":1,\"attributes\":{\"POSITION\":0}}]}]",
                                &(struct pbnds_gltf_options){.max_geometry = 1u << 30},
                                &s),
                     PBNDS_ERROR_MEMORY);
    /* Three squares of two primitives: 96 + 24 and 48 + 24 bytes. What is asked for is
     * seen before and while it is built. */
    static const float numbers[9] = {0};
    struct builder c = build_square();
    (void)add_floats(&c, numbers, 3, 3);
    struct pbnds_gltf_options options = {.max_geometry = 3 * (120 + 72) - 1};
    assert_int_equal(load_instances(&c, "\"TRANSLATION\":4", "", &options, &s),
                     PBNDS_ERROR_MEMORY);
    options.max_geometry = 100000;
    assert_int_equal(load_instances(&c, "\"TRANSLATION\":4", "", &options, &s),
                     PBNDS_OK);
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(instances_are_placed),
        cmocka_unit_test(instances_move_with_their_node),
        cmocka_unit_test(faulty_instances_are_told),
        cmocka_unit_test(a_budget_is_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
