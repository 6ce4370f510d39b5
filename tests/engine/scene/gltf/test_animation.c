/* Animations: samplers, channels, which one, and where everything was before. */
#include <math.h>
#include <unistd.h>

#include "tests/engine/scene/gltf/builder.h"

/** A square on node 1, child of node 0, with one channel on node `node`. */
static void one_channel(const struct builder *b, int node, const char *path, int input,
                        int output, const char *interpolation,
                        const struct pbnds_gltf_options *options, struct pbnds_scene *s,
                        enum pbnds_status expected)
{
    char rest[1500];
    (void)snprintf(
        rest, sizeof rest,
        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1]},{\"mesh\":0}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},"
        "\"indices\":3}]}],"
        "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":%d,"
        "\"path\":\"%s\"}}],\"samplers\":[{\"input\":%d,\"output\":%d%s}]}]",
        node, path, input, output, interpolation);
    const enum pbnds_status status = load_built(b, rest, options, s);
    if (status != expected)
        fail_msg("%s %s at %g: %d, %s", path, interpolation, options->time, status,
                 status ? fault.message : "");
}

/** Where vertex 0 of the square is at `time` under a translation. */
static struct pbnds_vec3 origin_at(const struct builder *b, int input, int output,
                                   const char *interpolation, double time)
{
    const struct pbnds_gltf_options options = posed_at(time);
    struct pbnds_scene s;
    one_channel(b, 1, "translation", input, output, interpolation, &options, &s,
                PBNDS_OK);
    const struct pbnds_vec3 p = s.meshes[0].position[0];
    assert_string_equal(warnings, "");
    pbnds_scene_free(&s);
    return p;
}

static void linear_and_step_hold_at_the_ends(void **state)
{
    (void)state;
    struct builder b = build_square();
    static const float times[] = {1, 2, 4}, places[] = {0, 0, 0, 10, 0, 0, 10, 20, -6};
    const int input = add_floats(&b, times, 3, 1),
              output = add_floats(&b, places, 3, 3);
    static const struct {
        double time, linear[3], step[3];
    } cases[] = {
        {-5, {0, 0, 0}, {0, 0, 0}},
        {0, {0, 0, 0}, {0, 0, 0}},
        {1, {0, 0, 0}, {0, 0, 0}},
        {1.25, {2.5, 0, 0}, {0, 0, 0}},
        {2, {10, 0, 0}, {10, 0, 0}},
        {2.5, {10, 5, -1.5}, {10, 0, 0}},
        {3.999, {10, 19.99, -5.997}, {10, 0, 0}},
        {4, {10, 20, -6}, {10, 20, -6}},
        {1e9, {10, 20, -6}, {10, 20, -6}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double *l = cases[i].linear, *t = cases[i].step;
        assert_vec3(origin_at(&b, input, output, "", cases[i].time), l[0], l[1], l[2],
                    1e-4);
        assert_vec3(origin_at(&b, input, output, ",\"interpolation\":\"LINEAR\"",
                              cases[i].time),
                    l[0], l[1], l[2], 1e-4);
        assert_vec3(
            origin_at(&b, input, output, ",\"interpolation\":\"STEP\"", cases[i].time),
            t[0], t[1], t[2], 0);
    }
}

/** Times and places of which the file overwrites some: only those around the time are read,
 *  wherever the overwritten ones are. */
static void keys_may_be_sparse(void **state)
{
    (void)state;
    static const float times[] = {0, 9, 2, 3, 4}, places[15] = {0}, one[] = {1};
    static const float moved[] = {10, 20, 30, 40, 50, 60};
    static const uint8_t where[] = {1, 3};
    struct builder b = build_square();
    char more[300];
    const int at = add(&b, where, 2, UBYTE, "SCALAR", 2, "");
    const int t1 = add_floats(&b, one, 1, 1), values = add_floats(&b, moved, 2, 3);
    static const char sparse[] =
        ",\"sparse\":{\"count\":%d,\"indices\":{\"bufferView\":%d,\"componentType\":"
        "5121},\"values\":{\"bufferView\":%d}}";
    (void)snprintf(more, sizeof more, sparse, 1, at, t1);
    const int input = add(&b, times, 20, FLOAT, "SCALAR", 5, more);
    (void)snprintf(more, sizeof more, sparse, 2, at, values);
    const int output = add(&b, places, 60, FLOAT, "VEC3", 5, more);
    static const double expected[5][3] = {
        {0, 0, 0}, {10, 20, 30}, {0, 0, 0}, {40, 50, 60}, {0, 0, 0}};
    for (int i = 0; i < 16; ++i) {
        const double *from = expected[i / 4], *to = expected[i / 4 + 1];
        const double f = (i % 4) / 4.0;
        assert_vec3(origin_at(&b, input, output, "", i / 4.0),
                    from[0] + f * (to[0] - from[0]), from[1] + f * (to[1] - from[1]),
                    from[2] + f * (to[2] - from[2]), 1e-4);
    }
}

/* A cubic polynomial is its own Hermite spline: f(t) = t^3 - 2 t^2 + t + 5 and its
 * derivative at keys that are not one second apart. */
static double cubic(double t)
{
    return ((t - 2) * t + 1) * t + 5;
}
static double slope(double t)
{
    return (3 * t - 4) * t + 1;
}

static void a_cubic_spline_is_a_cubic(void **state)
{
    (void)state;
    static const float times[] = {0.5f, 1, 3};
    float parts[27] = {0}; /* in-tangent, value, out-tangent; x is f, y is -2 f */
    for (int k = 0; k < 3; ++k) {
        const double f = cubic((double)times[k]), d = slope((double)times[k]);
        for (int p = 0; p < 3; ++p) {
            parts[9 * k + 3 * p] = (float)(p == 1 ? f : d);
            parts[9 * k + 3 * p + 1] = (float)(-2 * (p == 1 ? f : d));
        }
    }
    /* Tangents outside of the keys play no part. */
    parts[0] = parts[24] = 1e6f;
    struct builder b = build_square();
    const int input = add_floats(&b, times, 3, 1), output = add_floats(&b, parts, 9, 3);
    for (int i = 0; i <= 20; ++i) {
        const double t = 0.5 + 2.5 * i / 20.0;
        const struct pbnds_vec3 p =
            origin_at(&b, input, output, ",\"interpolation\":\"CUBICSPLINE\"", t);
        assert_vec3(p, cubic(t), -2 * cubic(t), 0, 2e-5);
    }
    assert_vec3(origin_at(&b, input, output, ",\"interpolation\":\"CUBICSPLINE\"", 9),
                cubic(3), -2 * cubic(3), 0, 1e-5);
}

/** Angle about z by which the square is turned, degrees. */
static double turned(const struct pbnds_scene *s)
{
    const struct pbnds_vec3 x =
        pbnds_sub(s->meshes[0].position[1], s->meshes[0].position[0]);
    assert_near((double)pbnds_length(x), 1.0, 1e-5);
    return atan2((double)x.y, (double)x.x) * 180.0 / 3.14159265358979;
}

static void rotations_take_the_shorter_way(void **state)
{
    (void)state;
    static const float times[] = {0, 1};
    /* About z by 0 and by 80 degrees; the second time as -q, which is the same turn. */
    const float s40 = 0.642787610f, c40 = 0.766044443f;
    for (int sign = -1; sign <= 1; sign += 2) {
        struct builder b = build_square();
        const float f = (float)sign, turns[] = {0, 0, 0, 1, 0, 0, f * s40, f * c40};
        /* the same in normalised shorts and bytes */
        const int16_t shorts[] = {
            0, 0, 0, 32767, 0, 0, (int16_t)(sign * 21062), (int16_t)(sign * 25101)};
        const int8_t bytes[] = {
            0, 0, 0, 127, 0, 0, (int8_t)(sign * 82), (int8_t)(sign * 97)};
        const int input = add_floats(&b, times, 2, 1);
        const int outputs[] = {
            add_floats(&b, turns, 2, 4),
            add(&b, shorts, sizeof shorts, SHORT, "VEC4", 2, ",\"normalized\":true"),
            add(&b, bytes, sizeof bytes, BYTE, "VEC4", 2, ",\"normalized\":true")};
        static const double tolerance[] = {1e-4, 0.01, 1.0};
        for (int k = 0; k < 3; ++k) {
            for (int i = 0; i <= 4; ++i) {
                const struct pbnds_gltf_options options = posed_at(i / 4.0);
                struct pbnds_scene s;
                one_channel(&b, 0, "rotation", input, outputs[k], "", &options, &s,
                            PBNDS_OK);
                /* An even speed is what tells slerp from a mix. */
                assert_near(turned(&s), 20.0 * i, tolerance[k]);
                pbnds_scene_free(&s);
            }
        }
    }
}

static void a_spline_of_rotations_stays_unit(void **state)
{
    (void)state;
    static const float times[] = {0, 2};
    /* No tangents: halfway the sum of both, made unit, is half of the turn. */
    static const float parts[] = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0,
                                  0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
    struct builder b = build_square();
    const int input = add_floats(&b, times, 2, 1), output = add_floats(&b, parts, 6, 4);
    const struct pbnds_gltf_options options = posed_at(1);
    struct pbnds_scene s;
    one_channel(&b, 1, "rotation", input, output, ",\"interpolation\":\"CUBICSPLINE\"",
                &options, &s, PBNDS_OK);
    assert_near(turned(&s), 90, 1e-4);
    pbnds_scene_free(&s);
}

static void scales_and_mirrors_are_animated(void **state)
{
    (void)state;
    static const float times[] = {0, 1}, sizes[] = {1, 1, 1, -3, 5, 1};
    struct builder b = build_square();
    const int input = add_floats(&b, times, 2, 1), output = add_floats(&b, sizes, 2, 3);
    const struct pbnds_gltf_options options = posed_at(1);
    struct pbnds_scene s;
    one_channel(&b, 1, "scale", input, output, "", &options, &s, PBNDS_OK);
    assert_vec3(s.lo, -3, 0, 0, 1e-6);
    assert_vec3(s.hi, 0, 5, 0, 1e-6);
    assert_vec3(pbnds_normalize(face_normal(&s.meshes[0], 0)), 0, 0, 1, 1e-6);
    pbnds_scene_free(&s);
}

/* Two animations, one of them with two channels; a camera on the moving node. */
static const char two_animations[] =
    "\"scenes\":[{\"nodes\":[0,1,2]}],\"nodes\":[{\"mesh\":0,\"camera\":0},{\"mesh\":0,"
    "\"translation\":[0,0,7]},{\"mesh\":0,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,5,5,5,1]}"
    "],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},"
    "\"indices\":3}]}],\"animations\":["
    "{\"name\":\"walk\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
    "\"translation\"}}],\"samplers\":[{\"input\":4,\"output\":5}]},"
    "{\"name\":\"run\",\"channels\":[{\"sampler\":1,\"target\":{\"node\":0,\"path\":"
    "\"translation\"}},{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"scale\"}},"
    "{\"sampler\":0,\"target\":{\"path\":\"translation\"}},"
    "{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"pointer\"}}],"
    "\"samplers\":[{\"input\":4,\"output\":5},{\"input\":4,\"output\":6}]}]";

static struct builder two_paths(void)
{
    static const float times[] = {0, 1}, walk[] = {0, 0, 0, 1, 0, 0},
                       run[] = {0, 0, 0, 0, 9, 0};
    struct builder b = build_square();
    (void)add_floats(&b, times, 2, 1);
    (void)add_floats(&b, walk, 2, 3);
    (void)add_floats(&b, run, 2, 3);
    return b;
}

static void an_animation_is_chosen(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double x, y;
    } cases[] = {{NULL, 1, 0}, {"walk", 1, 0}, {"run", 0, 9}, {"0", 1, 0}, {"1", 0, 9}};
    const struct builder b = two_paths();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_gltf_options options = posed_at(1);
        struct pbnds_scene s;
        options.animation = cases[i].name;
        must_build(&b, two_animations, &options, &s);
        assert_vec3(s.meshes[0].position[0], cases[i].x, cases[i].y, 0, 1e-6);
        assert_vec3(s.meshes[1].position[0], 0, 0, 7, 0);
        assert_vec3(s.meshes[2].position[0], 5, 5, 5, 0); /* a matrix stays */
        assert_int_equal(strstr(warnings, "matrix") != NULL, cases[i].y > 0);
        pbnds_scene_free(&s);
    }
    static const char *const none[] = {"jump", "2",  "-1",
                                       "",     "1x", "99999999999999999999"};
    for (size_t i = 0; i < sizeof none / sizeof none[0]; ++i) {
        struct pbnds_gltf_options options = {.animation = none[i]};
        struct pbnds_scene s;
        assert_int_equal(load_built(&b, two_animations, &options, &s),
                         PBNDS_ERROR_ARGUMENT);
        assert_non_null(strstr(fault.message, "animation"));
    }
    struct pbnds_scene s; /* at rest, in silence */
    must_build(&b, two_animations, NULL, &s);
    assert_vec3(s.meshes[0].position[0], 0, 0, 0, 0);
    assert_null(strstr(warnings, "anim"));
    assert_null(s.previous_cameras);
    pbnds_scene_free(&s);
}

static void what_moved_is_remembered(void **state)
{
    (void)state;
    const struct builder b = two_paths();
    struct pbnds_gltf_options options = posed_at(0.75);
    options.motion = true;
    options.earlier = 0.25;
    struct pbnds_scene s;
    must_build(&b, two_animations, &options, &s);
    for (int i = 0; i < 4; ++i) {
        const float *p = square.position + 3 * i;
        assert_vec3(s.meshes[0].position[i], (double)p[0] + 0.75, (double)p[1], 0,
                    1e-6);
        assert_vec3(s.meshes[0].previous[i], (double)p[0] + 0.25, (double)p[1], 0,
                    1e-6);
    }
    assert_null(s.meshes[1].previous);
    assert_null(s.meshes[2].previous);
    assert_near((double)s.cameras[0].world_from_camera.m[12], 0.75, 1e-6);
    assert_near((double)s.previous_cameras[0].world_from_camera.m[12], 0.25, 1e-6);
    assert_string_equal(s.previous_cameras[0].name, s.cameras[0].name);
    pbnds_scene_free(&s);
    /* Both times after the end: nothing moved. */
    options.time = 5;
    options.earlier = 4;
    must_build(&b, two_animations, &options, &s);
    assert_null(s.meshes[0].previous);
    assert_non_null(s.previous_cameras);
    pbnds_scene_free(&s);
}

static void a_file_without_animations_says_so(void **state)
{
    (void)state;
    struct pbnds_gltf_options options = posed_at(1);
    options.motion = true;
    struct pbnds_scene s;
    const enum pbnds_status status =
        load_with(square_json, &square, sizeof square, &options, &s);
    assert_int_equal(status, PBNDS_OK);
    assert_non_null(strstr(warnings, "no animation"));
    assert_null(s.meshes[0].previous);
    pbnds_scene_free(&s);
    options.animation = "0";
    assert_int_equal(load_with(square_json, &square, sizeof square, &options, &s),
                     PBNDS_ERROR_ARGUMENT);
}

static void faulty_animations_are_told(void **state)
{
    (void)state;
    static const float times[] = {0, 1, 2}, nan_times[] = {0, NAN, 2};
    static const uint16_t integers[] = {0, 1, 2};
    static const float three[12] = {0};
    struct builder b = build_square();
    const int input = add_floats(&b, times, 3, 1);
    const int nans = add_floats(&b, nan_times, 3, 1);
    const int words = add(&b, integers, 6, USHORT, "SCALAR", 3, "");
    const int empty = add(&b, integers, 6, FLOAT, "SCALAR", 0, "");
    const int vec3 = add_floats(&b, three, 3, 3), vec4 = add_floats(&b, three, 3, 4);
    const int two = add_floats(&b, three, 2, 3);
    const struct {
        int node, input, output;
        const char *path, *interpolation;
        enum pbnds_status status;
    } cases[] = {
        {1, input, vec3, "translation", "", PBNDS_OK},
        {1, nans, vec3, "translation", "", PBNDS_ERROR_FORMAT},
        {1, words, vec3, "translation", "", PBNDS_ERROR_FORMAT},
        {1, empty, vec3, "translation", "", PBNDS_ERROR_FORMAT},
        {1, input, two, "translation", "", PBNDS_ERROR_FORMAT},
        {1, input, vec4, "translation", "", PBNDS_ERROR_FORMAT},
        {1, input, vec3, "rotation", "", PBNDS_ERROR_FORMAT},
        {1, input, vec4, "rotation", "", PBNDS_OK}, /* zero: no turn */
        {1, input, vec3, "translation", ",\"interpolation\":\"CUBICSPLINE\"",
         PBNDS_ERROR_FORMAT},
        {1, input, vec3, "translation", ",\"interpolation\":\"BEZIER\"",
         PBNDS_ERROR_FORMAT},
        {2, input, vec3, "translation", "", PBNDS_ERROR_FORMAT},
        {1, 99, vec3, "translation", "", PBNDS_ERROR_FORMAT},
        {1, input, 99, "translation", "", PBNDS_ERROR_FORMAT},
        {1, vec3, vec3, "translation", "", PBNDS_ERROR_FORMAT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const struct pbnds_gltf_options options = posed_at(1.5);
        struct pbnds_scene s;
        one_channel(&b, cases[i].node, cases[i].path, cases[i].input, cases[i].output,
                    cases[i].interpolation, &options, &s, cases[i].status);
        pbnds_scene_free(&s);
    }
}

/** CesiumMan walking, at two keys: bounds and mean of its 3273 vertices as Blender 3.4.1
 *  has them (importer, evaluated mesh, frames 19 and 40 of 24 a second). By hand, each
 *  vertex was within 5e-6 of one of Blender's. */
static void a_walk_is_as_blender_has_it(void **state)
{
    (void)state;
    static const struct {
        int frame;
        double lo[3], hi[3], mean[3];
    } cases[] = {
        {19,
         {-0.4900936, -0.01599665, -0.1911078},
         {0.4640938, 1.465989, 0.2238351},
         {0.02752939, 1.04773522, 0.01610597}},
        {40,
         {-0.4080961, 0.02478689, -0.1883485},
         {0.4512192, 1.474804, 0.2688504},
         {0.08052704, 1.05935463, 0.07889268}},
    };
    static const char path[] =
        PBNDS_SHARED_DATA "/models/objects/CesiumMan/CesiumMan.glb";
    if (access(path, R_OK) != 0) skip();
    for (size_t i = 0; i < 2; ++i) {
        const struct pbnds_gltf_options options = posed_at(cases[i].frame / 24.0);
        const double *lo = cases[i].lo, *hi = cases[i].hi;
        struct pbnds_scene s;
        assert_int_equal(pbnds_gltf_load(path, &options, &ear, &s, &fault), PBNDS_OK);
        assert_vec3(s.lo, lo[0], lo[1], lo[2], 2e-5);
        assert_vec3(s.hi, hi[0], hi[1], hi[2], 2e-5);
        const struct pbnds_mesh *m = &s.meshes[0];
        double sum[3] = {0, 0, 0};
        for (size_t k = 0; k < m->vertex_count; ++k) {
            sum[0] += (double)m->position[k].x;
            sum[1] += (double)m->position[k].y;
            sum[2] += (double)m->position[k].z;
        }
        assert_int_equal(m->vertex_count, 3273);
        for (int k = 0; k < 3; ++k)
            assert_near(sum[k] / 3273, cases[i].mean[k], 1e-5);
        pbnds_scene_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_and_step_hold_at_the_ends),
        cmocka_unit_test(keys_may_be_sparse),
        cmocka_unit_test(a_cubic_spline_is_a_cubic),
        cmocka_unit_test(rotations_take_the_shorter_way),
        cmocka_unit_test(a_spline_of_rotations_stays_unit),
        cmocka_unit_test(scales_and_mirrors_are_animated),
        cmocka_unit_test(an_animation_is_chosen),
        cmocka_unit_test(what_moved_is_remembered),
        cmocka_unit_test(a_file_without_animations_says_so),
        cmocka_unit_test(faulty_animations_are_told),
        cmocka_unit_test(a_walk_is_as_blender_has_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
