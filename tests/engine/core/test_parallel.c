#include "engine/core/parallel.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "engine/core/report.h"
#include "tests/test.h"

enum { COUNT = 10007 };

struct work {
    unsigned char calls[COUNT]; /* one byte an index: no two threads share one */
    int threads;
    int bad_thread;
    unsigned char seen[64]; /* threads that did something */
};

static void count_call(void *context, size_t i, int thread)
{
    struct work *w = context;
    ++w->calls[i];
    if (thread < 0 || thread >= w->threads) {
        w->bad_thread = 1;
    } else {
        w->seen[thread] = 1;
    }
}

static void test_each_index_once(void **state)
{
    (void)state;
    static struct work w;
    const int threads[] = {1, 2, 5};
    const size_t counts[] = {0, 1, 4, COUNT};
    for (int t = 0; t < 3; ++t) {
        pbnds_set_threads(threads[t]);
        assert_int_equal(pbnds_threads(), threads[t]);
        for (int c = 0; c < 4; ++c) {
            memset(&w, 0, sizeof w);
            w.threads = threads[t];
            pbnds_parallel_for(counts[c], count_call, &w);
            for (size_t i = 0; i < COUNT; ++i) {
                assert_int_equal(w.calls[i], i < counts[c] ? 1 : 0);
            }
            assert_false(w.bad_thread);
        }
    }
}

static void wait_a_little(void *context, size_t i, int thread)
{
    (void)i;
    ((struct work *)context)->seen[thread] = 1;
    const struct timespec moment = {0, 2000000};
    (void)nanosleep(&moment, NULL);
}

/* Work that waits is shared out: one thread cannot have done it all. */
static void test_threads_share(void **state)
{
    (void)state;
    static struct work w;
    memset(&w, 0, sizeof w);
    pbnds_set_threads(4);
    pbnds_parallel_for(40, wait_a_little, &w);
    int busy = 0;
    for (int t = 0; t < 64; ++t)
        busy += w.seen[t];
    assert_in_range(busy, 2, 4);
}

static void test_default_is_the_cores(void **state)
{
    (void)state;
    pbnds_set_threads(0);
    assert_in_range(pbnds_threads(), 1, sysconf(_SC_NPROCESSORS_ONLN));
    pbnds_set_threads(-3);
    assert_in_range(pbnds_threads(), 1, sysconf(_SC_NPROCESSORS_ONLN));
}

#if defined(__SSE__)
static void halve_denormal(void *context, size_t i, int thread)
{
    (void)thread;
    volatile float x = 2e-40f;
    volatile float *results = context;
    results[i] = x * 0.5f;
}
#endif

/* Embree wants denormals flushed in its threads; ours are as they were afterwards. */
static void test_flush_to_zero_inside_only(void **state)
{
    (void)state;
#if defined(__SSE__)
    float results[64];
    pbnds_set_threads(2);
    pbnds_parallel_for(64, halve_denormal, results);
    for (int i = 0; i < 64; ++i)
        assert_true(results[i] == 0.0f);
    halve_denormal(results, 0, 0);
    assert_true(results[0] > 0.0f);
#else
    skip();
#endif
}

static void stop_at_100(void *context, size_t i, int thread)
{
    count_call(context, i, thread);
    if (i == 100) pbnds_request_stop();
}

/* Last: the flag stays up. */
static void test_stop(void **state)
{
    (void)state;
    static struct work w;
    memset(&w, 0, sizeof w);
    w.threads = 1;
    pbnds_set_threads(1);
    pbnds_parallel_for(COUNT, stop_at_100, &w);
    int calls = 0;
    for (size_t i = 0; i < COUNT; ++i)
        calls += w.calls[i];
    assert_int_equal(calls, 101);
    assert_true(pbnds_stop_requested());
    w.threads = 5;
    pbnds_set_threads(5);
    pbnds_parallel_for(COUNT, count_call, &w);
    int more = 0;
    for (size_t i = 0; i < COUNT; ++i)
        more += w.calls[i];
    assert_int_equal(more, calls);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_index_once),
        cmocka_unit_test(test_threads_share),
        cmocka_unit_test(test_default_is_the_cores),
        cmocka_unit_test(test_flush_to_zero_inside_only),
        cmocka_unit_test(test_stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
