#include "engine/core/error.h"

#include <string.h>

#include "tests/test.h"

static void test_sentence(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_fail(&error, PBNDS_ERROR_FORMAT, "%s: row %d", "a.exr", 7),
                     PBNDS_ERROR_FORMAT);
    assert_string_equal(error.message, "a.exr: row 7");
}

static void test_no_listener(void **state)
{
    (void)state;
    assert_int_equal(pbnds_fail(NULL, PBNDS_ERROR_IO, "%s", "x"), PBNDS_ERROR_IO);
}

static void test_long_sentence_is_cut_and_terminated(void **state)
{
    (void)state;
    char text[4000];
    memset(text, 'x', sizeof text);
    text[sizeof text - 1] = 0;
    struct {
        struct pbnds_error error;
        char guard[8];
    } e;
    memset(&e, 'g', sizeof e);
    (void)pbnds_fail(&e.error, PBNDS_ERROR_IO, "%s", text);
    assert_int_equal(strlen(e.error.message), sizeof e.error.message - 1);
    assert_memory_equal(e.guard, "gggggggg", 8);
}

static enum pbnds_status step(enum pbnds_status result, int *calls)
{
    ++*calls;
    return result;
}

static enum pbnds_status steps(enum pbnds_status first, int *calls)
{
    PBNDS_TRY(step(first, calls));
    PBNDS_TRY(step(PBNDS_OK, calls));
    return PBNDS_OK;
}

/* A file name or a member of a hostile file must not write to the terminal. */
static void test_no_control_characters(void **state)
{
    (void)state;
    struct pbnds_error error;
    (void)pbnds_fail(&error, PBNDS_ERROR_IO,
                     "%s: a\nb\x1b[2Jc\x7f\xc2\x9b"
                     "d \xc3\xa9",
                     "x\r.glb");
    assert_string_equal(error.message, "x?.glb: a?b?[2Jc???d \xc3\xa9");
}

static void test_try(void **state)
{
    (void)state;
    int calls = 0;
    assert_int_equal(steps(PBNDS_OK, &calls), PBNDS_OK);
    assert_int_equal(calls, 2);
    calls = 0;
    assert_int_equal(steps(PBNDS_ERROR_MEMORY, &calls), PBNDS_ERROR_MEMORY);
    assert_int_equal(calls, 1); /* evaluated once, and nothing after it */
}

/* Exit codes and files of other programs depend on the values. */
static void test_values_are_stable(void **state)
{
    (void)state;
    assert_int_equal(PBNDS_OK, 0);
    assert_int_equal(PBNDS_ERROR_ARGUMENT, 1);
    assert_int_equal(PBNDS_ERROR_IO, 2);
    assert_int_equal(PBNDS_ERROR_FORMAT, 3);
    assert_int_equal(PBNDS_ERROR_UNSUPPORTED, 4);
    assert_int_equal(PBNDS_ERROR_MEMORY, 5);
    assert_int_equal(PBNDS_ERROR_BACKEND, 6);
    assert_int_equal(PBNDS_ERROR_INTERRUPTED, 7);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sentence),
        cmocka_unit_test(test_no_listener),
        cmocka_unit_test(test_long_sentence_is_cut_and_terminated),
        cmocka_unit_test(test_no_control_characters),
        cmocka_unit_test(test_try),
        cmocka_unit_test(test_values_are_stable),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
