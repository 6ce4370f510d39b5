#include "engine/core/vec.h"

#include "engine/core/rng.h"
#include "tests/test.h"

static void assert_vec(struct pbnds_vec3 v, double x, double y, double z,
                       double tolerance)
{
    assert_near((double)v.x, x, tolerance);
    assert_near((double)v.y, y, tolerance);
    assert_near((double)v.z, z, tolerance);
}

/* Uniform on the sphere. */
static struct pbnds_vec3 direction(struct pbnds_rng *r)
{
    const float z = 2.0f * pbnds_rng_float(r) - 1.0f;
    const float phi = 2.0f * PBNDS_PI * pbnds_rng_float(r);
    const float s = sqrtf(fmaxf(0.0f, 1.0f - z * z));
    return pbnds_normalize(pbnds_vec3_make(s * cosf(phi), s * sinf(phi), z));
}

static void test_arithmetic(void **state)
{
    (void)state;
    const struct pbnds_vec3 a = {1, 2, 3}, b = {-4, 5, 0.5f};
    assert_vec(pbnds_add(a, b), -3, 7, 3.5, 0.0);
    assert_vec(pbnds_sub(a, b), 5, -3, 2.5, 0.0);
    assert_vec(pbnds_mul(a, b), -4, 10, 1.5, 0.0);
    assert_vec(pbnds_scale(a, -2.0f), -2, -4, -6, 0.0);
    assert_vec(pbnds_mad(a, b, 2.0f), -7, 12, 4, 0.0);
    assert_vec(pbnds_lerp(a, b, 0.0f), 1, 2, 3, 0.0);
    assert_vec(pbnds_lerp(a, b, 1.0f), -4, 5, 0.5, 0.0);
    assert_vec(pbnds_lerp(a, b, 0.5f), -1.5, 3.5, 1.75, 0.0);
    assert_near((double)pbnds_dot(a, b), 7.5, 0.0);
    assert_near((double)pbnds_max3(b), 5.0, 0.0);
    assert_near((double)pbnds_length(pbnds_vec3_make(2, 3, 6)), 7.0, 0.0);
    assert_vec(pbnds_splat(0.25f), 0.25, 0.25, 0.25, 0.0);
    assert_near((double)pbnds_clamp(3.0f, -1.0f, 1.0f), 1.0, 0.0);
    assert_near((double)pbnds_clamp(-3.0f, -1.0f, 1.0f), -1.0, 0.0);
    assert_near((double)pbnds_luminance(pbnds_splat(1.0f)), 1.0, 1e-6);
}

static void test_cross_is_right_handed(void **state)
{
    (void)state;
    const struct pbnds_vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    assert_vec(pbnds_cross(x, y), 0, 0, 1, 0.0);
    assert_vec(pbnds_cross(y, z), 1, 0, 0, 0.0);
    assert_vec(pbnds_cross(z, x), 0, 1, 0, 0.0);
    assert_vec(pbnds_cross(pbnds_vec3_make(1, 2, 3), pbnds_vec3_make(4, 5, 6)), -3, 6,
               -3, 0.0);
}

static void assert_frame(struct pbnds_vec3 n)
{
    const struct pbnds_frame f = pbnds_frame_from_normal(n);
    assert_vec(f.n, (double)n.x, (double)n.y, (double)n.z, 0.0);
    assert_near((double)pbnds_dot(f.t, f.t), 1.0, 2e-6);
    assert_near((double)pbnds_dot(f.b, f.b), 1.0, 2e-6);
    assert_near((double)pbnds_dot(f.t, f.b), 0.0, 2e-6);
    assert_near((double)pbnds_dot(f.t, f.n), 0.0, 2e-6);
    assert_near((double)pbnds_dot(f.b, f.n), 0.0, 2e-6);
    const struct pbnds_vec3 c = pbnds_cross(f.t, f.b); /* right-handed */
    assert_vec(c, (double)n.x, (double)n.y, (double)n.z, 2e-6);
}

static void test_frame_is_orthonormal(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(1, 0, 0);
    for (int i = 0; i < 20000; ++i)
        assert_frame(direction(&r));
    const float s[] = {-1.0f, 1.0f};
    for (int i = 0; i < 2; ++i) {
        assert_frame(pbnds_vec3_make(s[i], 0, 0));
        assert_frame(pbnds_vec3_make(0, s[i], 0));
        assert_frame(pbnds_vec3_make(0, 0, s[i]));
        assert_frame(pbnds_vec3_make(s[i], 0, -0.0f));
        /* next to the pole where the older construction loses its digits */
        assert_frame(pbnds_normalize(pbnds_vec3_make(1e-4f, s[i] * 1e-5f, -1.0f)));
    }
}

static void test_to_local_and_back(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(2, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        const struct pbnds_vec3 n = direction(&r), v = direction(&r);
        const struct pbnds_frame f = pbnds_frame_from_normal(n);
        const struct pbnds_vec3 local = pbnds_to_local(&f, v);
        assert_near((double)local.z, (double)pbnds_dot(n, v), 1e-6);
        const struct pbnds_vec3 back = pbnds_to_world(&f, local);
        assert_vec(back, (double)v.x, (double)v.y, (double)v.z, 2e-6);
        const struct pbnds_vec3 up = pbnds_to_world(&f, pbnds_vec3_make(0, 0, 1));
        assert_vec(up, (double)n.x, (double)n.y, (double)n.z, 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arithmetic),
        cmocka_unit_test(test_cross_is_right_handed),
        cmocka_unit_test(test_frame_is_orthonormal),
        cmocka_unit_test(test_to_local_and_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
