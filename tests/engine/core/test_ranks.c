/* Ranks: alone the calls are free and change nothing. Under mpirun (tests/tools/
 * test_ranks.sh) this program is started again as one of several. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/ranks.h"

static float part_of(int rank, size_t i)
{
    const float sign = (i + (size_t)rank) % 2 ? 1.0f : -1.0f;
    return sign * (1.0f + (float)i) * (rank % 3 == 1 ? 1e8f : 1.0f + (float)rank);
}

static void collectives_agree(void **state)
{
    (void)state;
    const int count = pbnds_rank_count(), rank = pbnds_rank();
    const char *wanted = getenv("PBNDS_TEST_RANKS");
    assert_int_equal(count, wanted ? atoi(wanted) : 1);
    assert_true(rank >= 0 && rank < count);
    double x[3] = {1.0, rank, 0.25 * rank};
    pbnds_ranks_sum(x, 3);
    const double triangle = 0.5 * count * (count - 1);
    assert_true(x[0] == count && x[1] == triangle && x[2] == 0.25 * triangle);
    assert_int_equal(pbnds_ranks_max(rank * 3), 3 * (count - 1));
    pbnds_ranks_barrier();
}

/* Values whose float sum depends on the order: every rank gets that of the ranks' order,
 * rounded once. A prime count, so that the parts differ; one more than a block. */
static void sums_of_floats_are_in_order(void **state)
{
    (void)state;
    static const size_t COUNTS[] = {0, 1, 3, 10007, (1u << 22) + 5u};
    const int ranks = pbnds_rank_count();
    for (size_t k = 0; k < sizeof COUNTS / sizeof COUNTS[0]; ++k) {
        const size_t count = COUNTS[k];
        float *x = malloc((count + 1) * sizeof *x);
        assert_non_null(x);
        for (size_t i = 0; i <= count; ++i)
            x[i] = part_of(pbnds_rank(), i);
        assert_int_equal(pbnds_ranks_sum_in_order(x, count, NULL), PBNDS_OK);
        for (size_t i = 0; i < count; ++i) {
            double sum = 0.0;
            for (int r = 0; r < ranks; ++r)
                sum += (double)part_of(r, i);
            if (memcmp(&x[i], &(float){(float)sum}, sizeof x[i]) != 0)
                fail_msg("%zu of %zu: %.9g, not %.9g", i, count, (double)x[i], sum);
        }
        assert_true(x[count] == part_of(pbnds_rank(), count));
        free(x);
    }
}

int main(void)
{
    struct pbnds_error error = {{0}};
    if (pbnds_ranks_init(&error) != PBNDS_OK) return 3;
    const struct CMUnitTest tests[] = {cmocka_unit_test(collectives_agree),
                                       cmocka_unit_test(sums_of_floats_are_in_order)};
    const int failed =
        cmocka_run_group_tests_name("engine/core/ranks", tests, NULL, NULL);
    pbnds_ranks_finish();
    return failed;
}
