/* How light is stored: what fits half, and what a rounded variance still says. */
#include "neural/data/pack.h"

#include "tests/test.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

static void ordinary_light_fits_half(void **state)
{
    (void)state;
    float values[3 * 64];
    for (int i = 0; i < 3 * 64; ++i)
        values[i] = 1e-3f * expf(0.08f * (float)i);
    assert_true(pbnds_pack_fits_half(values, 3 * 64));
    float copy[3 * 64];
    for (int i = 0; i < 3 * 64; ++i)
        copy[i] = values[i];
    pbnds_pack_round_half(copy, 3 * 64);
    for (int i = 0; i < 3 * 64; ++i)
        assert_true(fabsf(copy[i] - values[i]) <= 0x1p-11f * values[i]);
    assert_true(pbnds_pack_fits_half((const float[3]){0.0f, 0.0f, 0.0f}, 3));
    assert_true(pbnds_pack_fits_half((const float[2]){65504.0f, 1.0f}, 2));
}

static void what_half_cannot_hold_does_not_fit(void **state)
{
    (void)state;
    assert_false(pbnds_pack_fits_half((const float[2]){65505.0f, 1.0f}, 2));
    assert_false(pbnds_pack_fits_half((const float[2]){1.0f, INFINITY}, 2));
    assert_false(pbnds_pack_fits_half((const float[2]){NAN, 1.0f}, 2));
    assert_false(
        pbnds_pack_fits_half((const float[2]){1.3e-6f, 2.7e-6f}, 2)); /* dark */
    assert_false(pbnds_pack_fits_half((const float[1]){1e-9f}, 1)); /* would be lost */
}

static void a_short_number_keeps_eight_bits(void **state)
{
    (void)state;
    float values[] = {1.0f, 1.00390625f, 1.01171875f, 1e-20f, 3.3e11f, 0.0f, 3.4e38f};
    float before[7];
    for (int i = 0; i < 7; ++i)
        before[i] = values[i];
    pbnds_pack_round_short(values, 7);
    assert_true(values[0] == 1.0f);
    assert_true(values[1] == 1.0f);      /* half a step: to even, down */
    assert_true(values[2] == 1.015625f); /* and up                    */
    assert_true(values[5] == 0.0f);
    assert_true(isfinite(values[6]));
    for (int i = 0; i < 7; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        assert_int_equal(bits & 0xffffu, 0);
        assert_true(fabsf(values[i] - before[i]) <= 0x1p-8f * before[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ordinary_light_fits_half),
        cmocka_unit_test(what_half_cannot_hold_does_not_fit),
        cmocka_unit_test(a_short_number_keeps_eight_bits),
    };
    return cmocka_run_group_tests_name("neural/data/pack", tests, NULL, NULL);
}
