#include "engine/core/rng.h"

#include <string.h>

#include "tests/test.h"

enum { COUNT = 1 << 20, BINS = 256, GRID = 32 };

/* The four ways a renderer walks through the numbers: along the dimensions of one
 * stream, or over neighbouring pixels, samples and seeds at one dimension. */
enum walk { DIMENSION, PIXEL, SAMPLE, SEED, WALKS };

static float at(enum walk walk, uint64_t i)
{
    struct pbnds_rng r = pbnds_rng_make(walk == SEED ? i : 1, walk == PIXEL ? i : 77,
                                        walk == SAMPLE ? i : 5);
    r.dimension = walk == DIMENSION ? i : 3;
    return pbnds_rng_float(&r);
}

/* First outputs of SplitMix64 from seed 0 (Vigna's reference implementation). */
static void test_mixer_is_splitmix64(void **state)
{
    (void)state;
    const uint64_t gamma = 0x9e3779b97f4a7c15u;
    assert_true(pbnds_mix64(0) == 0xe220a8397b1dcdafu);
    assert_true(pbnds_mix64(gamma) == 0x6e789e6aa1b965f4u);
    assert_true(pbnds_mix64(2 * gamma) == 0x06c45d188009454fu);
}

static void test_deterministic(void **state)
{
    (void)state;
    struct pbnds_rng a = pbnds_rng_make(1, 2, 3), b = pbnds_rng_make(1, 2, 3);
    for (int i = 0; i < 100; ++i)
        assert_true(pbnds_rng_u64(&a) == pbnds_rng_u64(&b));
    /* A number is a function of its place, not of what was drawn before. */
    struct pbnds_rng jump = pbnds_rng_make(1, 2, 3);
    jump.dimension = 100;
    assert_true(pbnds_rng_u64(&jump) == pbnds_rng_u64(&a));
    /* Files of rendered data depend on these bits: they may not change. */
    struct pbnds_rng fixed = pbnds_rng_make(42, 7, 1);
    const uint64_t first = pbnds_rng_u64(&fixed);
    assert_true(first == pbnds_mix64(pbnds_mix64(pbnds_mix64(pbnds_mix64(42) ^ 7) ^ 1) ^
                                     pbnds_mix64(0)));
}

static void test_words_of_the_key_do_not_commute(void **state)
{
    (void)state;
    uint64_t keys[27];
    int n = 0;
    for (uint64_t s = 0; s < 3; ++s) {
        for (uint64_t p = 0; p < 3; ++p) {
            for (uint64_t i = 0; i < 3; ++i)
                keys[n++] = pbnds_rng_make(s, p, i).key;
        }
    }
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < i; ++k)
            assert_true(keys[i] != keys[k]);
    }
}

static void test_range(void **state)
{
    (void)state;
    struct pbnds_rng r = pbnds_rng_make(9, 0, 0);
    float lowest = 1.0f, highest = 0.0f;
    for (int i = 0; i < COUNT; ++i) {
        const float x = pbnds_rng_float(&r);
        assert_true(x >= 0.0f && x < 1.0f);
        lowest = fminf(lowest, x);
        highest = fmaxf(highest, x);
    }
    assert_true(lowest < 2e-5f && highest > 1.0f - 2e-5f);
}

static void test_mean_and_variance(void **state)
{
    (void)state;
    for (int w = 0; w < WALKS; ++w) {
        double sum = 0.0, square = 0.0;
        for (uint64_t i = 0; i < COUNT; ++i) {
            const double x = (double)at((enum walk)w, i);
            sum += x;
            square += x * x;
        }
        const double mean = sum / COUNT, variance = square / COUNT - mean * mean;
        assert_near(mean, 0.5, 5.0 * sqrt(1.0 / 12.0 / COUNT));
        assert_near(variance, 1.0 / 12.0, 5.0 * sqrt(1.0 / 180.0 / COUNT));
    }
}

static void assert_chi_squared(const unsigned *bins, int count, double total)
{
    const double expected = total / count, freedom = count - 1;
    double chi = 0.0;
    for (int i = 0; i < count; ++i) {
        const double d = bins[i] - expected;
        chi += d * d / expected;
    }
    /* Too even is as wrong as too uneven. */
    assert_near(chi, freedom, 5.0 * sqrt(2.0 * freedom));
}

static void test_uniform(void **state)
{
    (void)state;
    for (int w = 0; w < WALKS; ++w) {
        unsigned bins[BINS] = {0};
        for (uint64_t i = 0; i < COUNT; ++i) {
            ++bins[(int)(at((enum walk)w, i) * BINS)];
        }
        assert_chi_squared(bins, BINS, COUNT);
    }
}

/* Neighbours in every direction: no correlation, and pairs fill the square evenly. */
static void test_neighbours_are_independent(void **state)
{
    (void)state;
    for (int w = 0; w < WALKS; ++w) {
        static unsigned grid[GRID * GRID];
        memset(grid, 0, sizeof grid);
        double product = 0.0;
        for (uint64_t i = 0; i < COUNT; i += 2) {
            const float x = at((enum walk)w, i), y = at((enum walk)w, i + 1);
            product += ((double)x - 0.5) * ((double)y - 0.5) * 12.0;
            ++grid[(int)(x * GRID) * GRID + (int)(y * GRID)];
        }
        const double pairs = COUNT / 2;
        assert_near(product / pairs, 0.0, 5.0 / sqrt(pairs));
        assert_chi_squared(grid, GRID * GRID, pairs);
    }
}

/* Low bits are as good as high ones. */
static void test_every_bit_is_fair(void **state)
{
    (void)state;
    unsigned ones[64] = {0};
    struct pbnds_rng r = pbnds_rng_make(3, 1, 4);
    const int count = 1 << 16;
    for (int i = 0; i < count; ++i) {
        const uint64_t x = pbnds_rng_u64(&r);
        for (int b = 0; b < 64; ++b)
            ones[b] += (unsigned)(x >> b & 1u);
    }
    for (int b = 0; b < 64; ++b) {
        assert_near((double)ones[b], count / 2.0, 5.0 * sqrt(count / 4.0));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mixer_is_splitmix64),
        cmocka_unit_test(test_deterministic),
        cmocka_unit_test(test_words_of_the_key_do_not_commute),
        cmocka_unit_test(test_range),
        cmocka_unit_test(test_mean_and_variance),
        cmocka_unit_test(test_uniform),
        cmocka_unit_test(test_neighbours_are_independent),
        cmocka_unit_test(test_every_bit_is_fair),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
