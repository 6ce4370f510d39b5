#include "engine/image/tonemap.h"

#include <string.h>

#include "engine/core/color.h"
#include "engine/core/rng.h"
#include "tests/test.h"

static const struct pbnds_display neutral = {0.0f, PBNDS_TONEMAP_PBR_NEUTRAL};
static const struct pbnds_display reinhard = {0.0f, PBNDS_TONEMAP_REINHARD};
static const struct pbnds_display plain = {0.0f, PBNDS_TONEMAP_NONE};

static double encode(double x)
{
    x = fmin(fmax(x, 0.0), 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

/* The specification's shader, line by line, in double. */
static void khronos(const double in[3], double out[3])
{
    const double start = 0.8 - 0.04, desaturation = 0.15;
    const double x = fmin(in[0], fmin(in[1], in[2]));
    const double offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
    double peak = 0.0;
    for (int c = 0; c < 3; ++c) {
        out[c] = in[c] - offset;
        peak = fmax(peak, out[c]);
    }
    if (peak < start) return;
    const double d = 1.0 - start;
    const double new_peak = 1.0 - d * d / (peak + d - start);
    const double g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    for (int c = 0; c < 3; ++c) {
        out[c] = out[c] * new_peak / peak;
        out[c] = out[c] * (1.0 - g) + new_peak * g;
    }
}

static void assert_color(struct pbnds_vec3 c, double x, double y, double z,
                         double tolerance)
{
    assert_near((double)c.x, x, tolerance);
    assert_near((double)c.y, y, tolerance);
    assert_near((double)c.z, z, tolerance);
}

static void test_neutral_known_values(void **state)
{
    (void)state;
    /* Grey 0.18 loses 0.04; 0.04 becomes 6.25 x 0.04^2; both below the compression. */
    assert_color(pbnds_display_color(&neutral, pbnds_splat(0.18f)), encode(0.14),
                 encode(0.14), encode(0.14), 1e-6);
    assert_color(pbnds_display_color(&neutral, pbnds_splat(0.04f)), encode(0.01),
                 encode(0.01), encode(0.01), 1e-6);
    /* Peak 1.04 - 0.04 = 1: new peak 1 - 0.24^2 / 0.48 = 0.88. */
    assert_color(pbnds_display_color(&neutral, pbnds_splat(1.04f)), encode(0.88),
                 encode(0.88), encode(0.88), 1e-6);
    /* (4.04, 2.04, 1.04): peak 4, new peak 1 - 0.0576 / 3.48, g = 1 - 1/1.447... */
    const double in[3] = {4.04, 2.04, 1.04};
    double out[3];
    khronos(in, out);
    assert_color(pbnds_display_color(&neutral, pbnds_vec3_make(4.04f, 2.04f, 1.04f)),
                 encode(out[0]), encode(out[1]), encode(out[2]), 1e-6);
}

static void test_neutral_against_double(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(1, 0, 0);
    for (int i = 0; i < 20000; ++i) {
        const float size = exp2f(16.0f * pbnds_rng_float(&r) - 8.0f);
        const float x = size * pbnds_rng_float(&r), y = size * pbnds_rng_float(&r);
        const struct pbnds_vec3 c = {x, y, size * pbnds_rng_float(&r)};
        const double in[3] = {(double)c.x, (double)c.y, (double)c.z};
        double out[3];
        khronos(in, out);
        assert_color(pbnds_display_color(&neutral, c), encode(out[0]), encode(out[1]),
                     encode(out[2]), 2e-5);
    }
}

static void test_grey_is_monotonic(void **state)
{
    (void)state;
    const struct pbnds_display *const all[] = {&neutral, &reinhard, &plain};
    for (int k = 0; k < 3; ++k) {
        float last = 0.0f;
        for (int i = 0; i < 4000; ++i) {
            const float x = exp2f((float)i / 100.0f - 20.0f);
            const struct pbnds_vec3 c = pbnds_display_color(all[k], pbnds_splat(x));
            assert_true(c.x >= last - 1e-6f);
            assert_true(c.x <= 1.0f);
            assert_true(c.x == c.y && c.y == c.z); /* grey stays grey */
            last = c.x;
        }
        assert_near((double)last, 1.0, 1e-3);
    }
}

static void test_other_curves(void **state)
{
    (void)state;
    assert_color(pbnds_display_color(&reinhard, pbnds_vec3_make(1, 3, 0)), encode(0.5),
                 encode(0.75), 0.0, 1e-6);
    assert_color(pbnds_display_color(&plain, pbnds_vec3_make(0.5f, 3, 0.001f)),
                 encode(0.5), 1.0, 0.01292, 1e-6);
}

static void test_exposure_is_a_gain(void **state)
{
    (void)state;
    const struct pbnds_vec3 c = {0.3f, 0.7f, 0.05f};
    for (int k = 0; k < 3; ++k) {
        const struct pbnds_display up = {2.0f, (enum pbnds_tonemap)k};
        const struct pbnds_display zero = {0.0f, (enum pbnds_tonemap)k};
        const struct pbnds_vec3 a = pbnds_display_color(&up, c);
        const struct pbnds_vec3 b = pbnds_display_color(&zero, pbnds_scale(c, 4.0f));
        assert_memory_equal(&a, &b, sizeof a);
    }
}

static void test_numbers_that_are_none(void **state)
{
    (void)state;
    const struct pbnds_display *const all[] = {&neutral, &reinhard, &plain};
    for (int k = 0; k < 3; ++k) {
        const struct pbnds_vec3 nan = pbnds_display_color(all[k], pbnds_splat(NAN));
        assert_color(nan, 0, 0, 0, 0.0);
        const struct pbnds_vec3 inf =
            pbnds_display_color(all[k], pbnds_splat(INFINITY));
        assert_color(inf, 1, 1, 1, 1e-6);
        const struct pbnds_vec3 below = pbnds_display_color(all[k], pbnds_splat(-5.0f));
        assert_color(below, 0, 0, 0, 0.0);
        const struct pbnds_vec3 mixed =
            pbnds_display_color(all[k], pbnds_vec3_make(INFINITY, NAN, -1.0f));
        assert_true(mixed.x >= 0.0f && mixed.x <= 1.0f);
        assert_true(mixed.y >= 0.0f && mixed.y <= 1.0f);
        assert_true(mixed.z >= 0.0f && mixed.z <= 1.0f);
    }
}

static void test_image_in_place(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_image a, b;
    assert_int_equal(pbnds_image_init(&a, 7, 3, 3, &error), PBNDS_OK);
    assert_int_equal(pbnds_image_init(&b, 7, 3, 3, &error), PBNDS_OK);
    for (int i = 0; i < 63; ++i)
        a.data[i] = (float)i * 0.05f;
    pbnds_display_image(&neutral, &a, &b);
    for (int i = 0; i < 21; ++i) {
        const float *in = a.data + 3 * i;
        const struct pbnds_vec3 c =
            pbnds_display_color(&neutral, pbnds_vec3_make(in[0], in[1], in[2]));
        assert_memory_equal(b.data + 3 * i, &c, sizeof c);
    }
    pbnds_display_image(&neutral, &a, &a);
    assert_memory_equal(a.data, b.data, 63 * sizeof(float));
    pbnds_image_free(&a);
    pbnds_image_free(&b);
}

static void test_names(void **state)
{
    (void)state;
    for (int k = 0; k < 3; ++k) {
        enum pbnds_tonemap back;
        assert_true(
            pbnds_tonemap_parse(pbnds_tonemap_name((enum pbnds_tonemap)k), &back));
        assert_int_equal(back, k);
    }
    enum pbnds_tonemap t = PBNDS_TONEMAP_REINHARD;
    assert_true(pbnds_tonemap_parse("none", &t));
    assert_int_equal(t, PBNDS_TONEMAP_NONE);
    assert_false(pbnds_tonemap_parse("filmic", &t));
    assert_false(pbnds_tonemap_parse("", &t));
    assert_false(pbnds_tonemap_parse("pbr-neutral ", &t));
    assert_int_equal(t, PBNDS_TONEMAP_NONE); /* untouched */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_neutral_known_values),
        cmocka_unit_test(test_neutral_against_double),
        cmocka_unit_test(test_grey_is_monotonic),
        cmocka_unit_test(test_other_curves),
        cmocka_unit_test(test_exposure_is_a_gain),
        cmocka_unit_test(test_numbers_that_are_none),
        cmocka_unit_test(test_image_in_place),
        cmocka_unit_test(test_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
