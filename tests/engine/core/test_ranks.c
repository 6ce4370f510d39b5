/* Ranks: alone the calls are free and change nothing. Under mpirun (tests/tools/
 * test_ranks.sh) this program is started again as one of several. */
#include "tests/test.h"

#include <stdlib.h>

#include "engine/core/ranks.h"

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

int main(void)
{
    struct pbnds_error error = {{0}};
    if (pbnds_ranks_init(&error) != PBNDS_OK) return 3;
    const struct CMUnitTest tests[] = {cmocka_unit_test(collectives_agree)};
    const int failed =
        cmocka_run_group_tests_name("engine/core/ranks", tests, NULL, NULL);
    pbnds_ranks_finish();
    return failed;
}
