/* engine/shade/sampler.c: the points must be nets, whatever the scrambling. */
#include "tests/test.h"

#include <stdbool.h>
#include <string.h>

#include "engine/shade/sampler.h"

enum { COUNT = 256, SETS = 4 };

static void points_of(uint64_t pixel, uint32_t set, int dimensions, float (*u)[3])
{
    for (uint32_t s = 0; s < COUNT; ++s) {
        const struct pbnds_sampler sampler = pbnds_sampler_make(3, pixel, s, COUNT);
        pbnds_sampler_get(&sampler, set, dimensions, u[s]);
        for (int d = 0; d < dimensions; ++d)
            assert_true(u[s][d] >= 0.0f && u[s][d] < 1.0f);
    }
}

/* Every box of 2^-a x 2^-b (x 2^-c) holds `expected` of the first `count` points. */
static void assert_boxes(float (*u)[3], int count, const int *bits, int dimensions,
                         int expected)
{
    int cells[COUNT];
    int total = 0;
    memset(cells, 0, sizeof cells);
    for (int s = 0; s < count; ++s) {
        int cell = 0;
        for (int d = 0; d < dimensions; ++d)
            cell = (cell << bits[d]) | (int)(u[s][d] * (float)(1 << bits[d]));
        ++cells[cell];
    }
    for (int d = 0; d < dimensions; ++d)
        total += bits[d];
    for (int c = 0; c < 1 << total; ++c)
        assert_int_equal(cells[c], expected);
}

static void two_dimensions_are_a_net(void **state)
{
    (void)state;
    float u[COUNT][3];
    for (uint32_t set = 0; set < SETS; ++set) {
        points_of(11, set, 2, u);
        for (int a = 0; a <= 8; ++a)
            assert_boxes(u, COUNT, (int[]){a, 8 - a}, 2, 1);
        /* a prefix of 2^k samples is one as well */
        for (int a = 0; a <= 5; ++a)
            assert_boxes(u, 32, (int[]){a, 5 - a}, 2, 1);
    }
}

/* The first three Sobol dimensions have t = 1: boxes of volume 2^-(m-1) hold two. */
static void three_dimensions_are_a_net(void **state)
{
    (void)state;
    float u[COUNT][3];
    for (uint32_t set = 0; set < SETS; ++set) {
        points_of(5, set, 3, u);
        for (int a = 0; a <= 7; ++a)
            for (int b = 0; a + b <= 7; ++b)
                assert_boxes(u, COUNT, (int[]){a, b, 7 - a - b}, 3, 2);
        for (int d = 0; d < 3; ++d) {
            int bits[3] = {0, 0, 0};
            bits[d] = 8;
            assert_boxes(u, COUNT, bits, 3, 1);
        }
    }
}

static double correlation(float (*p)[3], float (*q)[3])
{
    double sum = 0.0;
    for (int s = 0; s < COUNT; ++s)
        sum += ((double)p[s][0] - 0.5) * ((double)q[s][0] - 0.5);
    return 12.0 * sum / COUNT;
}

/* Independent permutations would have a mean square correlation of 1/256; nested
 * shuffles tie neighbours together, which makes it 1.6/256. Dependent sets would come
 * near 1. */
static void sets_and_pixels_are_independent(void **state)
{
    (void)state;
    float p[COUNT][3], q[COUNT][3];
    double sets = 0.0, pixels = 0.0;
    for (uint32_t i = 0; i < 64; ++i) {
        points_of(1, i, 2, p);
        points_of(1, i + 64, 2, q);
        sets += correlation(p, q) * correlation(p, q) / 64.0;
        points_of(i + 1000, 0, 2, p);
        points_of(i + 1001, 0, 2, q);
        pixels += correlation(p, q) * correlation(p, q) / 64.0;
    }
    assert_near(sets, 1.6 / COUNT, 1.0 / COUNT);
    assert_near(pixels, 1.6 / COUNT, 1.0 / COUNT);
}

/* Counts that are no power of two still give one cell of a finer net to each sample. */
static void odd_counts_do_not_repeat(void **state)
{
    (void)state;
    bool seen[128] = {false};
    for (uint32_t s = 0; s < 100; ++s) {
        const struct pbnds_sampler sampler = pbnds_sampler_make(3, 9, s, 100);
        float u[1];
        pbnds_sampler_get(&sampler, 2, 1, u);
        const int cell = (int)(u[0] * 128.0f);
        assert_false(seen[cell]);
        seen[cell] = true;
    }
}

static void same_key_same_number(void **state)
{
    (void)state;
    float a[3], b[3], c[3];
    const struct pbnds_sampler one = pbnds_sampler_make(1, 2, 3, 64);
    const struct pbnds_sampler other = pbnds_sampler_make(2, 2, 3, 64);
    pbnds_sampler_get(&one, 4, 3, a);
    pbnds_sampler_get(&one, 4, 3, b);
    pbnds_sampler_get(&other, 4, 3, c);
    assert_memory_equal(a, b, sizeof a);
    assert_memory_not_equal(a, c, sizeof a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_dimensions_are_a_net),
        cmocka_unit_test(three_dimensions_are_a_net),
        cmocka_unit_test(sets_and_pixels_are_independent),
        cmocka_unit_test(odd_counts_do_not_repeat),
        cmocka_unit_test(same_key_same_number),
    };
    return cmocka_run_group_tests_name("engine/shade/sampler", tests, NULL, NULL);
}
