/* engine/image/exr.c with several threads: the same file, planes and messages. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "engine/core/report.h"
#include "engine/core/rng.h"
#include "engine/image/exr.h"

enum { W = 83, H = 211, N = W * H };

static const enum pbnds_exr_compression compressions[] = {
    PBNDS_EXR_NONE, PBNDS_EXR_ZIPS, PBNDS_EXR_ZIP, PBNDS_EXR_PIZ};

static float planes[3][N];
static struct pbnds_exr_channel channels[3] = {{"a.R", PBNDS_EXR_HALF, planes[0]},
                                               {"b.R", PBNDS_EXR_FLOAT, planes[1]},
                                               {"c", PBNDS_EXR_UINT, planes[2]}};

static struct pbnds_exr describe(enum pbnds_exr_compression compression)
{
    struct pbnds_rng rng = pbnds_rng_make(3, 0, 0);
    for (int i = 0; i < N; ++i) {
        planes[0][i] = (float)(i % 1000) / 64.0f;
        planes[1][i] = (float)(i % W) + pbnds_rng_float(&rng);
        planes[2][i] = (float)(i / 40);
    }
    return (struct pbnds_exr){
        W, H, compression, channels, 3, NULL, 0,
    };
}

static uint8_t *bytes_of(const char *path, size_t *size)
{
    uint8_t *bytes = NULL;
    struct pbnds_error error;
    assert_int_equal(pbnds_file_read(path, (size_t)1 << 26, &bytes, size, &error),
                     PBNDS_OK);
    return bytes;
}

static uint8_t *written(const struct pbnds_exr *exr, size_t *size)
{
    const char *path = "exr_parallel.exr";
    struct pbnds_error error = {""};
    if (pbnds_exr_write(path, exr, &error) != PBNDS_OK) fail_msg("%s", error.message);
    return bytes_of(path, size);
}

static void threads_change_no_byte(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const struct pbnds_exr exr = describe(compressions[k]);
        size_t size = 0, other = 0;
        pbnds_set_threads(1);
        uint8_t *want = written(&exr, &size);
        static const int counts[] = {2, 3, 5, 40};
        for (int c = 0; c < 4; ++c) {
            pbnds_set_threads(counts[c]);
            uint8_t *got = written(&exr, &other);
            assert_int_equal(size, other);
            assert_memory_equal(want, got, size);
            free(got);
            struct pbnds_exr back;
            struct pbnds_error error;
            assert_int_equal(pbnds_exr_read("exr_parallel.exr", &back, &error),
                             PBNDS_OK);
            for (int i = 0; i < 3; ++i) {
                assert_memory_equal(pbnds_exr_find(&back, channels[i].name)->data,
                                    planes[i], sizeof planes[i]);
            }
            pbnds_exr_free(&back);
        }
        free(want);
    }
    remove("exr_parallel.exr");
}

/* Several chunks are bad: the sentence is that of the first, whoever meets his first. */
static void threads_change_no_sentence(void **state)
{
    (void)state;
    const char *path = "exr_parallel_bad.exr";
    const struct pbnds_exr exr = describe(PBNDS_EXR_ZIP);
    size_t size = 0;
    pbnds_set_threads(1);
    uint8_t *bytes = written(&exr, &size);
    struct pbnds_error error, want = {""};
    for (size_t i = size / 3; i < size; i += size / 16)
        bytes[i] ^= 0x55;
    assert_int_equal(pbnds_file_write(path, bytes, size, &error), PBNDS_OK);
    struct pbnds_exr back;
    assert_int_equal(pbnds_exr_read(path, &back, &want), PBNDS_ERROR_FORMAT);
    for (int i = 0; i < 40; ++i) {
        pbnds_set_threads(2 + i % 4);
        struct pbnds_error got = {""};
        assert_int_equal(pbnds_exr_read(path, &back, &got), PBNDS_ERROR_FORMAT);
        assert_string_equal(got.message, want.message);
        assert_null(back.channels);
    }
    free(bytes);
    remove(path);
    remove("exr_parallel.exr");
}

/* Manifests of Cryptomatte run to many kilobytes. */
static void long_strings_come_back(void **state)
{
    (void)state;
    const char *path = "exr_parallel_text.exr";
    static char text[100000];
    memset(text, 'x', sizeof text - 1);
    struct pbnds_exr_attribute a[2] = {
        {.name = "long", .type = PBNDS_EXR_ATTRIBUTE_TEXT, .value.text = text},
        {.name = "short", .type = PBNDS_EXR_ATTRIBUTE_TEXT, .value.text = "brief"}};
    struct pbnds_exr exr = describe(PBNDS_EXR_PIZ), back;
    exr.attributes = a;
    exr.attribute_count = 2;
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_exr_write(path, &exr, &error), PBNDS_OK);
    assert_int_equal(pbnds_exr_read(path, &back, &error), PBNDS_OK);
    const struct pbnds_exr_attribute *found = pbnds_exr_find_attribute(&back, "long");
    assert_non_null(found);
    assert_int_equal(found->type, PBNDS_EXR_ATTRIBUTE_TEXT);
    assert_string_equal(found->value.text, text);
    found = pbnds_exr_find_attribute(&back, "short");
    assert_int_equal(found->type, PBNDS_EXR_ATTRIBUTE_STRING);
    assert_string_equal(found->value.string, "brief");
    pbnds_exr_free(&back);
    a[1].value.text = NULL;
    assert_int_equal(pbnds_exr_write(path, &exr, &error), PBNDS_ERROR_ARGUMENT);
    remove(path);
}

/* The last test: the flag stays up. What was begun is finished, and is the same. */
static void a_stop_leaves_whole_files(void **state)
{
    (void)state;
    const struct pbnds_exr exr = describe(PBNDS_EXR_ZIP);
    size_t size = 0, other = 0;
    pbnds_set_threads(2);
    uint8_t *want = written(&exr, &size);
    pbnds_request_stop();
    uint8_t *got = written(&exr, &other);
    assert_int_equal(size, other);
    assert_memory_equal(want, got, size);
    struct pbnds_exr back;
    struct pbnds_error error;
    assert_int_equal(pbnds_exr_read("exr_parallel.exr", &back, &error), PBNDS_OK);
    assert_memory_equal(pbnds_exr_find(&back, "b.R")->data, planes[1],
                        sizeof planes[1]);
    pbnds_exr_free(&back);
    free(got);
    free(want);
    remove("exr_parallel.exr");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_change_no_byte),
        cmocka_unit_test(threads_change_no_sentence),
        cmocka_unit_test(long_strings_come_back),
        cmocka_unit_test(a_stop_leaves_whole_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
