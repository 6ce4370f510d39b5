#include "engine/core/color.h"

#include "tests/test.h"

/* IEC 61966-2-1 in double precision. */
static double encode(double x)
{
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

static void test_known_values(void **state)
{
    (void)state;
    assert_near((double)pbnds_srgb_encode(0.5f), 0.735356983052449, 1e-6);
    assert_near((double)pbnds_srgb_encode(0.18f), 0.461356129500442, 1e-6);
    assert_near((double)pbnds_srgb_encode(0.001f), 0.01292, 1e-8);
    assert_near((double)pbnds_srgb_decode(0.5f), 0.214041140482232, 1e-6);
    assert_near((double)pbnds_srgb_decode(0.04f), 0.04 / 12.92, 1e-8);
}

static void test_exact_ends_and_clamps(void **state)
{
    (void)state;
    assert_true(pbnds_srgb_encode(0.0f) == 0.0f);
    assert_true(pbnds_srgb_encode(1.0f) == 1.0f);
    assert_true(pbnds_srgb_encode(-3.0f) == 0.0f);
    assert_true(pbnds_srgb_encode(7.0f) == 1.0f);
    assert_true(pbnds_srgb_encode(INFINITY) == 1.0f);
    assert_true(pbnds_srgb_encode(NAN) == 0.0f);
    assert_true(pbnds_srgb_decode(0.0f) == 0.0f);
    assert_true(pbnds_srgb_decode(1.0f) == 1.0f);
}

static void test_against_double(void **state)
{
    (void)state;
    float last = 0.0f;
    for (int i = 1; i < 100000; ++i) {
        const float x = (float)i / 100000.0f;
        const float y = pbnds_srgb_encode(x);
        assert_near((double)y, encode((double)x), 5e-7);
        assert_true(y > last); /* monotonic, over the seam too */
        last = y;
    }
}

static void test_round_trip(void **state)
{
    (void)state;
    for (int bits = 8; bits <= 16; bits += 8) {
        const int top = (1 << bits) - 1;
        for (int i = 0; i <= top; ++i) {
            const float code = (float)i / (float)top;
            const float back = pbnds_srgb_encode(pbnds_srgb_decode(code));
            assert_int_equal(lrintf(back * (float)top), i);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known_values),
        cmocka_unit_test(test_exact_ends_and_clamps),
        cmocka_unit_test(test_against_double),
        cmocka_unit_test(test_round_trip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
