#include "engine/core/report.h"

#include <signal.h>
#include <string.h>

#include "tests/test.h"

struct heard {
    char sentence[2000], stage[64];
    double done, total;
    int warnings, steps;
};

static void hear_warning(void *user, const char *sentence)
{
    struct heard *h = user;
    strncpy(h->sentence, sentence, sizeof h->sentence - 1);
    ++h->warnings;
}

static void hear_progress(void *user, const char *stage, double done, double total)
{
    struct heard *h = user;
    strncpy(h->stage, stage, sizeof h->stage - 1);
    h->done = done;
    h->total = total;
    ++h->steps;
}

static void test_callbacks(void **state)
{
    (void)state;
    struct heard h = {.warnings = 0};
    const struct pbnds_report report = {hear_warning, hear_progress, &h};
    pbnds_warn(&report, "%s: %d of %s", "a.glb", 3, "textures");
    assert_string_equal(h.sentence, "a.glb: 3 of textures");
    pbnds_progress(&report, "render", 2.0, 8.0);
    assert_string_equal(h.stage, "render");
    assert_near(h.done, 2.0, 0.0);
    assert_near(h.total, 8.0, 0.0);
    assert_int_equal(h.warnings, 1);
    assert_int_equal(h.steps, 1);
}

static void test_silence(void **state)
{
    (void)state;
    const struct pbnds_report deaf = {NULL, NULL, NULL};
    pbnds_warn(NULL, "nobody %d", 1);
    pbnds_warn(&deaf, "nobody %d", 1);
    pbnds_progress(NULL, "x", 0.0, 0.0);
    pbnds_progress(&deaf, "x", 0.0, 0.0);
}

static void test_long_warning_is_cut(void **state)
{
    (void)state;
    struct heard h = {.warnings = 0};
    const struct pbnds_report report = {hear_warning, NULL, &h};
    char text[1800];
    memset(text, 'w', sizeof text);
    text[sizeof text - 1] = 0;
    pbnds_warn(&report, "%s", text);
    assert_int_equal(strlen(h.sentence), 1023);
}

static void handler(int number)
{
    (void)number;
    pbnds_request_stop();
}

/* Last: the flag stays up. */
static void test_stop_from_a_signal_handler(void **state)
{
    (void)state;
    assert_false(pbnds_stop_requested());
    (void)signal(SIGUSR1, handler);
    assert_int_equal(raise(SIGUSR1), 0);
    assert_true(pbnds_stop_requested());
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_fail_interrupted(&error), PBNDS_ERROR_INTERRUPTED);
    assert_string_equal(error.message, "interrupted");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_callbacks),
        cmocka_unit_test(test_silence),
        cmocka_unit_test(test_long_warning_is_cut),
        cmocka_unit_test(test_stop_from_a_signal_handler),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
