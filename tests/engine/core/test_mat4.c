#include "engine/core/mat4.h"

#include "engine/core/rng.h"
#include "tests/test.h"

static float range(struct pbnds_rng *r, float lo, float hi)
{
    return lo + (hi - lo) * pbnds_rng_float(r);
}

static struct pbnds_vec3 random_vec(struct pbnds_rng *r, float size)
{
    const float x = range(r, -size, size), y = range(r, -size, size);
    return pbnds_vec3_make(x, y, range(r, -size, size));
}

static struct pbnds_vec4 random_quaternion(struct pbnds_rng *r)
{
    struct pbnds_vec4 q;
    float norm;
    do {
        q.x = range(r, -1, 1);
        q.y = range(r, -1, 1);
        q.z = range(r, -1, 1);
        q.w = range(r, -1, 1);
        norm = sqrtf(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    } while (norm > 1.0f || norm < 0.1f);
    return (struct pbnds_vec4){q.x / norm, q.y / norm, q.z / norm, q.w / norm};
}

/* Non-uniform scale, mirrored in half of the cases. */
static struct pbnds_mat4 random_matrix(struct pbnds_rng *r)
{
    const struct pbnds_vec3 t = random_vec(r, 10.0f);
    const struct pbnds_vec4 q = random_quaternion(r);
    struct pbnds_vec3 s = {range(r, 0.2f, 4.0f), range(r, 0.2f, 4.0f),
                           range(r, 0.2f, 4.0f)};
    if (pbnds_rng_float(r) < 0.5f) s.x = -s.x;
    return pbnds_mat4_from_trs(t, q, s);
}

static void assert_vec(struct pbnds_vec3 a, struct pbnds_vec3 b, double tolerance)
{
    assert_near((double)a.x, (double)b.x, tolerance);
    assert_near((double)a.y, (double)b.y, tolerance);
    assert_near((double)a.z, (double)b.z, tolerance);
}

/* q v q*, by the rule of the quaternion product. */
static struct pbnds_vec3 rotate(struct pbnds_vec4 q, struct pbnds_vec3 v)
{
    const struct pbnds_vec3 u = {q.x, q.y, q.z};
    const struct pbnds_vec3 t = pbnds_scale(pbnds_cross(u, v), 2.0f);
    return pbnds_add(pbnds_mad(v, t, q.w), pbnds_cross(u, t));
}

static void test_trs_scales_then_rotates_then_moves(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(1, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        const struct pbnds_vec3 t = random_vec(&r, 5.0f), s = random_vec(&r, 3.0f);
        const struct pbnds_vec4 q = random_quaternion(&r);
        const struct pbnds_vec3 p = random_vec(&r, 2.0f);
        const struct pbnds_mat4 m = pbnds_mat4_from_trs(t, q, s);
        const struct pbnds_vec3 turned = rotate(q, pbnds_mul(s, p));
        assert_vec(pbnds_mat4_vector(&m, p), turned, 1e-5);
        assert_vec(pbnds_mat4_point(&m, p), pbnds_add(turned, t), 1e-5);
    }
    /* A quarter turn about +y takes +z to +x. */
    const float h = sqrtf(0.5f);
    const struct pbnds_mat4 quarter = pbnds_mat4_from_trs(
        pbnds_splat(0), (struct pbnds_vec4){0, h, 0, h}, pbnds_splat(1));
    assert_vec(pbnds_mat4_vector(&quarter, pbnds_vec3_make(0, 0, 1)),
               pbnds_vec3_make(1, 0, 0), 1e-6);
}

static void test_product_applies_the_right_one_first(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(2, 0, 0);
    const struct pbnds_mat4 identity = pbnds_mat4_identity();
    for (int i = 0; i < 1000; ++i) {
        const struct pbnds_mat4 a = random_matrix(&r), b = random_matrix(&r);
        const struct pbnds_vec3 p = random_vec(&r, 2.0f);
        const struct pbnds_mat4 ab = pbnds_mat4_mul(&a, &b);
        assert_vec(pbnds_mat4_point(&ab, p),
                   pbnds_mat4_point(&a, pbnds_mat4_point(&b, p)), 5e-4);
        const struct pbnds_mat4 same = pbnds_mat4_mul(&identity, &a);
        for (int k = 0; k < 16; ++k)
            assert_true(same.m[k] == a.m[k]);
    }
}

static void test_inverse(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(3, 0, 0);
    const struct pbnds_mat4 identity = pbnds_mat4_identity();
    for (int i = 0; i < 1000; ++i) {
        const struct pbnds_mat4 a = random_matrix(&r);
        struct pbnds_mat4 inverse;
        assert_true(pbnds_mat4_inverse(&a, &inverse));
        const struct pbnds_mat4 left = pbnds_mat4_mul(&inverse, &a);
        const struct pbnds_mat4 right = pbnds_mat4_mul(&a, &inverse);
        for (int k = 0; k < 16; ++k) {
            assert_near((double)left.m[k], (double)identity.m[k], 2e-5);
            assert_near((double)right.m[k], (double)identity.m[k], 2e-5);
        }
    }
}

/* Zero pivots on the diagonal: only row exchanges solve this one. */
static void test_inverse_exchanges_rows(void **state)
{
    (void)state;
    const struct pbnds_mat4 a = {{0, 2, 0, 0, 0, 0, 4, 0, 8, 0, 0, 0, 0, 0, 0, 1}};
    struct pbnds_mat4 b;
    assert_true(pbnds_mat4_inverse(&a, &b));
    const struct pbnds_mat4 expected = {
        {0, 0, 0.125f, 0, 0.5f, 0, 0, 0, 0, 0.25f, 0, 0, 0, 0, 0, 1}};
    for (int k = 0; k < 16; ++k)
        assert_true(b.m[k] == expected.m[k]);
}

static void test_tiny_scales_invert_and_singular_ones_do_not(void **state)
{
    (void)state;
    const struct pbnds_vec4 q = {0, 0, 0, 1};
    struct pbnds_mat4 out = pbnds_mat4_identity();
    struct pbnds_mat4 m = pbnds_mat4_from_trs(pbnds_splat(1), q, pbnds_splat(1e-6f));
    assert_true(pbnds_mat4_inverse(&m, &out));
    assert_near((double)out.m[0], 1e6, 1.0);
    const struct pbnds_mat4 before = out;
    m = pbnds_mat4_from_trs(pbnds_splat(1), q, pbnds_vec3_make(1, 0, 1));
    assert_false(pbnds_mat4_inverse(&m, &out));
    m.m[5] = NAN;
    assert_false(pbnds_mat4_inverse(&m, &out));
    const struct pbnds_mat4 rank = {{1, 2, 3, 4, 2, 4, 6, 8, 1, 1, 1, 1, 0, 1, 0, 1}};
    assert_false(pbnds_mat4_inverse(&rank, &out));
    assert_memory_equal(&out, &before, sizeof out); /* untouched */
}

static void test_determinant(void **state)
{
    (void)state;
    const struct pbnds_vec4 q = {0.5f, -0.5f, 0.5f, 0.5f};
    const struct pbnds_mat4 a =
        pbnds_mat4_from_trs(pbnds_splat(9), q, pbnds_vec3_make(2, 3, 4));
    const struct pbnds_mat4 b =
        pbnds_mat4_from_trs(pbnds_splat(9), q, pbnds_vec3_make(2, -3, 4));
    assert_near((double)pbnds_mat4_det3(&a), 24.0, 1e-4);
    assert_near((double)pbnds_mat4_det3(&b), -24.0, 1e-4);
}

/* cof(M) (a x b) = M a x M b for any M: the normal of a transformed surface. */
static void test_normals_stay_normal(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(4, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        const struct pbnds_mat4 m = random_matrix(&r);
        const struct pbnds_vec3 a = random_vec(&r, 1.0f), b = random_vec(&r, 1.0f);
        const struct pbnds_vec3 n = pbnds_mat4_normal(&m, pbnds_cross(a, b));
        const struct pbnds_vec3 expected =
            pbnds_cross(pbnds_mat4_vector(&m, a), pbnds_mat4_vector(&m, b));
        assert_vec(n, expected, 2e-4);
    }
}

static void test_look_at(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(5, 0, 0);
    const struct pbnds_vec3 up = {0, 1, 0};
    for (int i = 0; i < 1000; ++i) {
        const struct pbnds_vec3 eye = random_vec(&r, 5.0f),
                                target = random_vec(&r, 5.0f);
        const struct pbnds_mat4 m = pbnds_mat4_look_at(eye, target, up);
        assert_vec(pbnds_mat4_point(&m, pbnds_splat(0)), eye, 0.0);
        const float distance = pbnds_length(pbnds_sub(target, eye));
        assert_vec(pbnds_mat4_point(&m, pbnds_vec3_make(0, 0, -distance)), target,
                   1e-4);
        assert_near((double)pbnds_mat4_det3(&m), 1.0, 1e-5);
        const struct pbnds_vec3 right = pbnds_mat4_vector(&m, pbnds_vec3_make(1, 0, 0));
        assert_near((double)right.y, 0.0, 1e-6); /* the horizon is level */
        assert_true(pbnds_mat4_vector(&m, up).y >= 0.0f);
    }
}

static void test_look_straight_up_and_down(void **state)
{
    (void)state;
    const struct pbnds_vec3 eye = {1, 2, 3}, up = {0, 1, 0};
    const float ways[] = {-1.0f, 1.0f};
    for (int i = 0; i < 2; ++i) {
        const struct pbnds_vec3 target = {1, 2 + ways[i], 3};
        const struct pbnds_mat4 m = pbnds_mat4_look_at(eye, target, up);
        assert_near((double)pbnds_mat4_det3(&m), 1.0, 1e-6);
        assert_vec(pbnds_mat4_point(&m, pbnds_vec3_make(0, 0, -1)), target, 1e-6);
    }
    const struct pbnds_vec3 z = {0, 0, 1};
    const struct pbnds_mat4 m = pbnds_mat4_look_at(z, pbnds_splat(0), z);
    assert_near((double)pbnds_mat4_det3(&m), 1.0, 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_trs_scales_then_rotates_then_moves),
        cmocka_unit_test(test_product_applies_the_right_one_first),
        cmocka_unit_test(test_inverse),
        cmocka_unit_test(test_inverse_exchanges_rows),
        cmocka_unit_test(test_tiny_scales_invert_and_singular_ones_do_not),
        cmocka_unit_test(test_determinant),
        cmocka_unit_test(test_normals_stay_normal),
        cmocka_unit_test(test_look_at),
        cmocka_unit_test(test_look_straight_up_and_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
