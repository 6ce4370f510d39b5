#include <stdlib.h>
#include <sys/stat.h>

#include "tests/engine/core/scratch.h"

#define FOLDER "scratch_core_file"

static void assert_content(const char *path, const void *expected, size_t size)
{
    struct pbnds_error error = {""};
    uint8_t *data;
    size_t length;
    assert_int_equal(pbnds_file_read(path, 1 << 20, &data, &length, &error), PBNDS_OK);
    assert_int_equal(length, size);
    assert_memory_equal(data, expected, size);
    assert_int_equal(data[size], 0); /* the extra byte */
    free(data);
}

static void test_round_trip(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    static uint8_t bytes[200000]; /* more than the reader's first buffer */
    for (size_t i = 0; i < sizeof bytes; ++i)
        bytes[i] = (uint8_t)(i * 31 >> 3);
    const size_t sizes[] = {0, 1, 4095, 65536, sizeof bytes};
    for (size_t i = 0; i < 5; ++i) {
        assert_int_equal(pbnds_file_write(FOLDER "/a.bin", bytes, sizes[i], &error),
                         PBNDS_OK);
        assert_content(FOLDER "/a.bin", bytes, sizes[i]);
        assert_int_equal(scratch_count(FOLDER), 1);
    }
}

static void test_read_limit(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_file_write(FOLDER "/a", "0123456789", 10, &error), PBNDS_OK);
    uint8_t *data;
    size_t size;
    assert_int_equal(pbnds_file_read(FOLDER "/a", 10, &data, &size, &error), PBNDS_OK);
    free(data);
    assert_int_equal(pbnds_file_read(FOLDER "/a", 9, &data, &size, &error),
                     PBNDS_ERROR_MEMORY);
    assert_null(data);
    assert_int_equal(size, 0);
    assert_non_null(strstr(error.message, FOLDER "/a"));
}

static void test_read_what_is_not_there(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    uint8_t *data;
    size_t size;
    assert_int_equal(pbnds_file_read(FOLDER "/none", 10, &data, &size, &error),
                     PBNDS_ERROR_IO);
    assert_null(data);
    assert_non_null(strstr(error.message, FOLDER "/none"));
    assert_int_equal(pbnds_file_read(FOLDER, 10, &data, &size, &error), PBNDS_ERROR_IO);
    assert_null(data);
    assert_non_null(strstr(error.message, "folder"));
    assert_int_equal(pbnds_file_read(FOLDER "/none", 10, &data, &size, NULL),
                     PBNDS_ERROR_IO);
}

/* Until the commit the old content stays under the name. */
static void test_atomic(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    const char *path = FOLDER "/image.png";
    assert_int_equal(pbnds_file_write(path, "old", 3, &error), PBNDS_OK);
    struct pbnds_file_writer w;
    assert_int_equal(pbnds_file_begin(&w, path, &error), PBNDS_OK);
    assert_string_not_equal(w.temp, path);
    assert_string_equal(w.temp + strlen(w.temp) - 4, ".png"); /* writers look at it */
    assert_int_equal(strncmp(w.temp, FOLDER "/", sizeof FOLDER), 0); /* same folder */
    FILE *file = fopen(w.temp, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite("newer", 1, 5, file), 5);
    assert_int_equal(fclose(file), 0);
    assert_content(path, "old", 3);
    assert_int_equal(pbnds_file_commit(&w, &error), PBNDS_OK);
    assert_null(w.path);
    assert_null(w.temp);
    assert_content(path, "newer", 5);
    assert_int_equal(scratch_count(FOLDER), 1);
}

static void test_abort_leaves_the_old_file(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_file_write(FOLDER "/a", "old", 3, &error), PBNDS_OK);
    struct pbnds_file_writer w;
    assert_int_equal(pbnds_file_begin(&w, FOLDER "/a", &error), PBNDS_OK);
    assert_int_equal(scratch_count(FOLDER), 2);
    pbnds_file_abort(&w);
    pbnds_file_abort(&w); /* safe on an empty one */
    assert_int_equal(scratch_count(FOLDER), 1);
    assert_content(FOLDER "/a", "old", 3);
}

static void test_unwritable_folder(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    struct pbnds_file_writer w;
    const char *const paths[] = {FOLDER "/none/a", "/proc/pbnds-test"};
    for (size_t i = 0; i < 2; ++i) {
        error.message[0] = 0;
        assert_int_equal(pbnds_file_begin(&w, paths[i], &error), PBNDS_ERROR_IO);
        assert_null(w.temp);
        assert_null(w.path);
        assert_non_null(strstr(error.message, paths[i]));
        assert_int_equal(pbnds_file_write(paths[i], "x", 1, &error), PBNDS_ERROR_IO);
    }
    assert_int_equal(pbnds_file_write("", "x", 1, &error), PBNDS_ERROR_IO);
    assert_int_equal(pbnds_file_write(FOLDER "/", "x", 1, &error), PBNDS_ERROR_IO);
    if (geteuid() != 0) { /* the mode of a folder does not stop root */
        assert_int_equal(chmod(FOLDER, 0500), 0);
        assert_int_equal(pbnds_file_begin(&w, FOLDER "/a", &error), PBNDS_ERROR_IO);
        assert_int_equal(chmod(FOLDER, 0700), 0);
    }
    assert_int_equal(scratch_count(FOLDER), 0);
}

static void test_folder_under_the_name(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_make_folder(FOLDER "/a/b", &error), PBNDS_OK);
    assert_int_equal(pbnds_file_write(FOLDER "/a", "x", 1, &error), PBNDS_ERROR_IO);
    assert_non_null(strstr(error.message, FOLDER "/a"));
    assert_int_equal(scratch_count(FOLDER), 1); /* the folder, no temporary file */
    assert_int_equal(rmdir(FOLDER "/a/b"), 0);
}

static void test_full_disk(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    static const uint8_t bytes[100000];
    assert_int_equal(pbnds_file_write(FOLDER "/a", "old", 3, &error), PBNDS_OK);
    const struct rlimit old = scratch_limit(50000);
    const enum pbnds_status status =
        pbnds_file_write(FOLDER "/a", bytes, sizeof bytes, &error);
    scratch_unlimit(old);
    assert_int_equal(status, PBNDS_ERROR_IO);
    assert_content(FOLDER "/a", "old", 3);
    assert_int_equal(scratch_count(FOLDER), 1);
}

static void test_make_folder(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    struct pbnds_error error = {""};
    struct stat info;
    assert_int_equal(pbnds_make_folder(FOLDER "/p/q/r/", &error), PBNDS_OK);
    assert_int_equal(stat(FOLDER "/p/q/r", &info), 0);
    assert_true(S_ISDIR(info.st_mode));
    assert_int_equal(pbnds_make_folder(FOLDER "/p/q/r", &error), PBNDS_OK); /* again */
    assert_int_equal(pbnds_file_write(FOLDER "/f", "x", 1, &error), PBNDS_OK);
    assert_int_equal(pbnds_make_folder(FOLDER "/f", &error), PBNDS_ERROR_IO);
    assert_int_equal(pbnds_make_folder(FOLDER "/f/g", &error), PBNDS_ERROR_IO);
    assert_non_null(strstr(error.message, FOLDER "/f"));
    assert_int_equal(rmdir(FOLDER "/p/q/r") | rmdir(FOLDER "/p/q") | rmdir(FOLDER "/p"),
                     0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_read_limit),
        cmocka_unit_test(test_read_what_is_not_there),
        cmocka_unit_test(test_atomic),
        cmocka_unit_test(test_abort_leaves_the_old_file),
        cmocka_unit_test(test_unwritable_folder),
        cmocka_unit_test(test_folder_under_the_name),
        cmocka_unit_test(test_full_disk),
        cmocka_unit_test(test_make_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
