/* Skins. */
#include "tests/engine/scene/gltf/builder.h"

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

/** The square on node 0; `joints` further nodes that no scene has, joint k at x = 10^k. */
static void load_skinned(const struct builder *b, const char *attributes, int joints,
                         const char *more, const struct pbnds_gltf_options *options,
                         struct pbnds_scene *s)
{
    char nodes[800] = "", list[100] = "", rest[2500];
    long x = 1;
    for (int k = 0; k < joints; ++k, x *= 10) {
        (void)sprintf(nodes + strlen(nodes), ",{\"translation\":[%ld,0,0]}", x);
        (void)sprintf(list + strlen(list), "%s%d", k ? "," : "", k + 1);
    }
    (void)snprintf(rest, sizeof rest,
                   "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"skin\":0,"
                   "\"translation\":[0,0,99],\"scale\":[-1,1,1]}%s],"
                   "\"skins\":[{\"joints\":[%s]}],\"meshes\":[{\"primitives\":[{"
                   "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,%s},\"indices\":3%s",
                   nodes, list, attributes, more);
    must_build(b, rest, options, s);
}

static void all_sets_and_types_count(void **state)
{
    (void)state;
    /* Vertex i: joint 0 half, joints 1 to 4 an eighth each, over two sets. In bytes and
     * shorts 0.5 is 128 of 255, so that the sum is not 1 and has to be made so. */
    static const uint8_t joints8[2][16] = {
        {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3},
        {4, 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0}};
    static const double expected = 0.5 * 1 + 0.125 * (10 + 100 + 1000 + 10000);
    for (int type = 0; type < 3; ++type) {
        struct builder b = build_square();
        int index[8]; /* JOINTS_0, WEIGHTS_0, JOINTS_1, WEIGHTS_1 */
        for (int set = 0; set < 2; ++set) {
            uint16_t j16[16], w16[16];
            uint8_t w8[16];
            float w[16];
            for (int i = 0; i < 16; ++i) {
                const double x =
                    set == 0 ? (i % 4 == 0 ? 0.5 : 0.125) : (i % 4 == 0 ? 0.125 : 0.0);
                j16[i] = joints8[set][i];
                w16[i] = (uint16_t)(x * 65528);
                w8[i] = (uint8_t)(x * 248);
                w[i] = (float)(x * 3);
            }
            const void *weights = type == 0 ? (void *)w8 : type == 1 ? (void *)w16 : w;
            const size_t size = type == 0 ? 16 : type == 1 ? 32 : 64;
            index[2 * set] = type == 0 ? add(&b, joints8[set], 16, UBYTE, "VEC4", 4, "")
                                       : add(&b, j16, 32, USHORT, "VEC4", 4, "");
            index[2 * set + 1] =
                add(&b, weights, size,
                    type == 0   ? UBYTE
                    : type == 1 ? USHORT
                                : FLOAT,
                    "VEC4", 4, type == 2 ? "" : ",\"normalized\":true");
        }
        char attributes[200];
        (void)snprintf(attributes, sizeof attributes,
                       "\"JOINTS_0\":%d,\"WEIGHTS_0\":%d,\"JOINTS_1\":%d,"
                       "\"WEIGHTS_1\":%d",
                       index[0], index[1], index[2], index[3]);
        struct pbnds_scene s;
        load_skinned(&b, attributes, 5, "}]}]", NULL, &s);
        for (int i = 0; i < 4; ++i) {
            const float *p = square.position + 3 * i;
            assert_vec3(s.meshes[0].position[i], expected + (double)p[0], (double)p[1],
                        0, 1e-3);
            assert_vec3(s.meshes[0].normal[i], 0, 0, 1, 1e-6);
        }
        /* The mirror is the node's, which does not count. */
        assert_vec3(pbnds_normalize(face_normal(&s.meshes[0], 0)), 0, 0, 1, 1e-6);
        assert_string_equal(warnings, "");
        pbnds_scene_free(&s);
    }
}

static void the_skin_comes_after_the_targets(void **state)
{
    (void)state;
    /* Joint 0 turns from rest to half a turn about z in a second; the target lifts x by
     * one: (x + 1, y) turned, not turned and then lifted. */
    static const uint8_t joints[16] = {0};
    static const float weights[16] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    static const float lift[12] = {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0};
    static const float times[] = {0, 1}, turns[] = {0, 0, 0, 1, 0, 0, 1, 0};
    struct builder b = build_square();
    const int j = add(&b, joints, 16, UBYTE, "VEC4", 4, "");
    const int w = add_floats(&b, weights, 4, 4), t = add_floats(&b, lift, 4, 3);
    const int input = add_floats(&b, times, 2, 1), output = add_floats(&b, turns, 2, 4);
    char attributes[100], more[600];
    (void)snprintf(attributes, sizeof attributes, "\"JOINTS_0\":%d,\"WEIGHTS_0\":%d", j,
                   w);
    (void)snprintf(
        more, sizeof more,
        ",\"targets\":[{\"POSITION\":%d}]}],\"weights\":[1]}],"
        "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,"
        "\"path\":\"rotation\"}}],\"samplers\":[{\"input\":%d,\"output\":%d}]}]",
        t, input, output);
    struct pbnds_gltf_options options = posed_at(1);
    options.motion = true;
    options.earlier = 0;
    struct pbnds_scene s;
    load_skinned(&b, attributes, 1, more, &options, &s);
    for (int i = 0; i < 4; ++i) {
        const double x = (double)square.position[3 * i] + 1;
        const double y = (double)square.position[3 * i + 1];
        /* the joint stands at x = 1 */
        assert_vec3(s.meshes[0].position[i], 1 - x, -y, 0, 1e-5);
        assert_vec3(s.meshes[0].previous[i], 1 + x, y, 0, 1e-5);
    }
    assert_vec3(s.lo, -1, -1, 0, 1e-5);
    assert_vec3(s.hi, 0, 0, 0, 1e-5);
    pbnds_scene_free(&s);
}

static void joints_may_mirror(void **state)
{
    (void)state;
    static const uint8_t joints[16] = {0};
    static const float weights[16] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0};
    struct builder b = build_square();
    char rest[800];
    const int j = add(&b, joints, 16, UBYTE, "VEC4", 4, "");
    const int w = add_floats(&b, weights, 4, 4);
    (void)snprintf(rest, sizeof rest,
                   "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"scale\":[-2,1,1]}],"
                   "\"skins\":[{\"joints\":[1]}],\"meshes\":[{\"primitives\":[{"
                   "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"JOINTS_0\":%d,"
                   "\"WEIGHTS_0\":%d},\"indices\":3}]}]",
                   j, w);
    struct pbnds_scene s;
    must_build(&b, rest, NULL, &s);
    assert_vec3(s.meshes[0].position[1], -2, 0, 0, 1e-6);
    assert_vec3(s.meshes[0].position[3], 0, 1, 0, 0); /* held by nothing: as it is */
    assert_vec3(pbnds_normalize(face_normal(&s.meshes[0], 0)), 0, 0, 1, 1e-6);
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(skins_take_their_rest_pose),
        cmocka_unit_test(all_sets_and_types_count),
        cmocka_unit_test(the_skin_comes_after_the_targets),
        cmocka_unit_test(joints_may_mirror),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
