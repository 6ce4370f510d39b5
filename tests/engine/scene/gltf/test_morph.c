/* Morph targets. */
#include <math.h>

#include "tests/engine/scene/gltf/builder.h"

/** The square with two targets: 0 lifts every vertex by its number and leans the normals
 *  to +x, 1 (sparse, without a bufferView) moves vertex 2 alone. */
struct morphed {
    struct builder b;
    char mesh[600];
};

static struct morphed make(void)
{
    static const float lift[12] = {0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3};
    static const float lean[12] = {1, 0, -1, 1, 0, -1, 1, 0, -1, 1, 0, -1};
    static const float tangents[16] = {1, 0, 0, -1, 1, 0, 0, -1,
                                       1, 0, 0, -1, 1, 0, 0, -1};
    static const float turn[12] = {-1, 1, 0, -1, 1, 0, -1, 1, 0, -1, 1, 0};
    static const float alone[3] = {10, 20, 30};
    static const uint16_t where[] = {2};
    struct morphed m = {.b = build_square()};
    const int tangent = add_floats(&m.b, tangents, 4, 4);
    const int t0 = add_floats(&m.b, lift, 4, 3), n0 = add_floats(&m.b, lean, 4, 3);
    const int d0 = add_floats(&m.b, turn, 4, 3);
    const int at = add(&m.b, where, 2, USHORT, "SCALAR", 1, "");
    const int values = add_floats(&m.b, alone, 1, 3);
    char text[400];
    (void)snprintf(text, sizeof text,
                   ",{\"componentType\":5126,\"type\":\"VEC3\",\"count\":4,\"sparse\":{"
                   "\"count\":1,\"indices\":{\"bufferView\":%d,\"componentType\":5123},"
                   "\"values\":{\"bufferView\":%d}}}",
                   at, values);
    append(m.b.accessors, sizeof m.b.accessors, text);
    /* It has no view of its own: what is added now would not match. */
    (void)snprintf(
        m.mesh, sizeof m.mesh,
        "{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":%d},"
        "\"indices\":3,\"targets\":[{\"POSITION\":%d,\"NORMAL\":%d,\"TANGENT\":%d},"
        "{\"POSITION\":%d}]}]",
        tangent, t0, n0, d0, m.b.count);
    return m;
}

static void load_morphed(const struct morphed *m, const char *weights, const char *node,
                         struct pbnds_scene *s)
{
    char rest[1200];
    (void)snprintf(rest, sizeof rest,
                   "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0%s}],"
                   "\"meshes\":[%s%s}]",
                   node, m->mesh, weights);
    must_build(&m->b, rest, NULL, s);
    assert_string_equal(warnings, "");
}

/** Is vertex i at its base plus w0 and w1 of the targets? */
static void check(const struct pbnds_scene *s, double w0, double w1)
{
    for (int i = 0; i < 4; ++i) {
        const float *p = square.position + 3 * i;
        const double alone = i == 2 ? w1 : 0.0;
        assert_vec3(s->meshes[0].position[i], (double)p[0] + 10 * alone,
                    (double)p[1] + 20 * alone, w0 * i + 30 * alone, 1e-5);
        const double length = hypot(w0, 1 - w0);
        assert_vec3(s->meshes[0].normal[i], w0 / length, 0, (1 - w0) / length, 1e-6);
        /* (1, 0, 0) goes to (0, 1, 0); its handedness stays */
        const struct pbnds_vec4 t = s->meshes[0].tangent[i];
        assert_vec3(pbnds_vec3_make(t.x, t.y, t.z), (1 - w0) / length, w0 / length, 0,
                    1e-6);
        assert_true(t.w == -1.0f);
    }
}

static void targets_are_weighed(void **state)
{
    (void)state;
    const struct morphed m = make();
    static const struct {
        const char *mesh, *node;
        double w0, w1;
    } cases[] = {
        {"", "", 0, 0},
        {",\"weights\":[0.5,0]", "", 0.5, 0},
        {",\"weights\":[0.25,1]", "", 0.25, 1},
        {",\"weights\":[0.25,1]", ",\"weights\":[0,-0.5]", 0,
         -0.5}, /* the node's win */
        {"", ",\"weights\":[1.5,2]", 1.5, 2},
        {",\"weights\":[0.5]", "", 0.5, 0}, /* too few: zeros */
        {",\"weights\":[0.5,0,7]", "", 0.5, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_scene s;
        load_morphed(&m, cases[i].mesh, cases[i].node, &s);
        check(&s, cases[i].w0, cases[i].w1);
        if (cases[i].w1 == 1.0) assert_vec3(s.hi, 11, 21, 30.5, 1e-4);
        pbnds_scene_free(&s);
    }
}

/** Weights animated by floats and by normalised bytes, with CUBICSPLINE too. */
static void weights_are_animated(void **state)
{
    (void)state;
    static const float times[] = {0, 2}, linear[] = {0, 1, 0.5f, 0};
    static const uint8_t bytes[] = {0, 255, 128, 0};
    /* in-tangents of both targets, values, out-tangents: a straight line of slope 1/4 */
    static const float spline[] = {0, 0, 0, 0, 0.25f, 0, 0.25f, 0, 0.5f, 0, 0, 0};
    static const float targets[12] = {0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3};
    for (int kind = 0; kind < 3; ++kind) {
        struct builder b = build_square();
        const int first = add_floats(&b, targets, 4, 3);
        const int input = add_floats(&b, times, 2, 1);
        const int output =
            kind == 0   ? add_floats(&b, linear, 4, 1)
            : kind == 1 ? add(&b, bytes, 4, UBYTE, "SCALAR", 4, ",\"normalized\":true")
                        : add_floats(&b, spline, 12, 1);
        char rest[1200];
        (void)snprintf(
            rest, sizeof rest,
            "\"nodes\":[{\"mesh\":0,\"weights\":[9,9]}],\"meshes\":[{\"primitives\":[{"
            "\"attributes\":{\"POSITION\":0},\"indices\":3,\"targets\":[{\"POSITION\":%"
            "d},"
            "{\"POSITION\":1}]}]}],\"animations\":[{\"channels\":[{\"sampler\":0,"
            "\"target\":{\"node\":0,\"path\":\"weights\"}}],\"samplers\":[{\"input\":%"
            "d,"
            "\"output\":%d%s}]}]",
            first, input, output,
            kind == 2 ? ",\"interpolation\":\"CUBICSPLINE\"" : "");
        struct pbnds_gltf_options options = posed_at(1);
        options.motion = true;
        options.earlier = 0;
        struct pbnds_scene s;
        must_build(&b, rest, &options, &s);
        /* Target 1 is (0, 0, 1) everywhere. */
        const double w0 = 0.25, w1 = kind == 2 ? 0 : 0.5;
        for (int i = 0; i < 4; ++i) {
            const struct pbnds_mesh *m = &s.meshes[0];
            assert_near((double)m->position[i].z, w0 * i + w1, kind == 1 ? 0.01 : 1e-6);
            assert_near((double)m->previous[i].z, kind == 2 ? 0 : 1, 1e-6);
        }
        pbnds_scene_free(&s);
    }
}

static void displacements_follow_split_vertices(void **state)
{
    (void)state;
    /* A sheet of two triangles whose picture is mirrored on one of them, with a normal
     * map and no tangents: both vertices of the seam become two, and each copy goes with
     * the target of the vertex it was. */
    static const float uv[8] = {1, 0, 0, 0, 1, 1, 0, 1};
    static const float up[12] = {0, 0, 5, 0, 0, 6, 0, 0, 7, 0, 0, 8};
    struct builder b = build_square();
    const int map = add_floats(&b, uv, 4, 2), target = add_floats(&b, up, 4, 3);
    char rest[1500];
    (void)snprintf(
        rest, sizeof rest,
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"weights\":[1],\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":%d},\"indices\":3,"
        "\"material\":0,\"targets\":[{\"POSITION\":%d}]}]}],"
        "\"materials\":[{\"normalTexture\":{\"index\":0}}],\"textures\":[{\"source\":0}"
        "],"
        "\"images\":[{\"uri\":\"data:image/png;base64," PNG_BASE64 "\"}]",
        map, target);
    struct pbnds_scene s;
    must_build(&b, rest, NULL, &s);
    const struct pbnds_mesh *m = &s.meshes[0];
    assert_int_equal(m->vertex_count, 6);
    for (size_t i = 0; i < 6; ++i) {
        const struct pbnds_vec3 p = m->position[i];
        const int from = p.y == 0.0f ? (p.x == 0.0f ? 0 : 1) : (p.x == 0.0f ? 3 : 2);
        assert_true(p.z == 5.0f + (float)from);
        assert_true(m->uv[0][i].x == uv[2 * from] && m->uv[0][i].y == uv[2 * from + 1]);
    }
    for (int t = 0; t < 2; ++t) {
        const float w = m->tangent[m->index[3 * t]].w;
        for (int k = 0; k < 3; ++k)
            assert_true(m->tangent[m->index[3 * t + k]].w == w);
    }
    assert_true(m->tangent[m->index[0]].w != m->tangent[m->index[3]].w);
    pbnds_scene_free(&s);
}

static void faulty_targets_are_told(void **state)
{
    (void)state;
    static const char *const cases[] = {
        /* a target that does not exist, has too few elements, the wrong type */
        "\"targets\":[{\"POSITION\":77}]}]",
        "\"targets\":[{\"POSITION\":4}]}]",
        "\"targets\":[{\"POSITION\":2}]}]",
        /* different numbers of targets */
        "\"targets\":[{\"POSITION\":0}]},{\"attributes\":{\"POSITION\":0}}]",
    };
    static const float few[9] = {0};
    struct builder b = build_square();
    (void)add_floats(&b, few, 3, 3);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char rest[600];
        struct pbnds_scene s;
        (void)snprintf(rest, sizeof rest,
                       "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"weights\":[1],"
                       "\"primitives\":[{\"attributes\":{\"POSITION\":0},%s}]",
                       cases[i]);
        assert_int_equal(load_built(&b, rest, NULL, &s), PBNDS_ERROR_FORMAT);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(targets_are_weighed),
        cmocka_unit_test(weights_are_animated),
        cmocka_unit_test(displacements_follow_split_vertices),
        cmocka_unit_test(faulty_targets_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
