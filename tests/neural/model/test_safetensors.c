/* neural/model/safetensors.c: round trips, a file written by hand, and damaged ones. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "neural/model/safetensors.h"

/* Length, JSON and data as one block; *size receives how long it is. */
static uint8_t *make_file(const char *json, const void *data, size_t data_size,
                          size_t *size)
{
    const size_t length = strlen(json);
    uint8_t *bytes = malloc(8 + length + data_size + 1);
    assert_non_null(bytes);
    for (size_t i = 0; i < 8; ++i)
        bytes[i] = (uint8_t)((uint64_t)length >> (8 * i));
    memcpy(bytes + 8, json, length);
    if (data_size) memcpy(bytes + 8 + length, data, data_size);
    *size = 8 + length + data_size;
    return bytes;
}

static enum pbnds_status parse(const char *json, size_t data_size,
                               struct pbnds_safetensors *file)
{
    static const float data[64];
    struct pbnds_error error = {""};
    size_t size;
    uint8_t *bytes = make_file(json, data, data_size, &size);
    const enum pbnds_status status =
        pbnds_safetensors_parse(bytes, size, "weights.test", file, &error);
    free(bytes);
    if (status != PBNDS_OK) {
        assert_non_null(strstr(error.message, "weights.test"));
        assert_null(file->storage);
        assert_int_equal(file->tensor_count, 0);
    }
    return status;
}

static void refuses(const char *json, size_t data_size, enum pbnds_status expected)
{
    struct pbnds_safetensors file;
    const enum pbnds_status status = parse(json, data_size, &file);
    if (status != expected)
        fail_msg("status %d, expected %d: %s", status, expected, json);
}

static void a_file_written_by_hand_is_read(void **state)
{
    (void)state;
    const float data[] = {1.5f, -2.0f, 3.0f, 4.0f, 0.25f, 7.0f, 42.0f};
    /* data order differs from header order; the header has an odd length on purpose */
    const char *json =
        "{\"b\":{\"dtype\":\"F32\",\"shape\":[],\"data_offsets\":[24,28]},"
        "\"__metadata__\":{\"k\":\"v\\u00e9\"},"
        "\"a.w\":{\"shape\":[2,3],\"data_offsets\":[0,24],\"dtype\":\"F32\"}}"
        "  ";
    for (int pad = 0; pad < 4; ++pad) { /* every alignment of the data */
        char text[512];
        (void)snprintf(text, sizeof text, "%s%*s", json, pad, "");
        struct pbnds_safetensors file;
        struct pbnds_error error;
        size_t size;
        uint8_t *bytes = make_file(text, data, sizeof data, &size);
        assert_int_equal(pbnds_safetensors_parse(bytes, size, "x", &file, &error), 0);
        free(bytes);
        assert_int_equal(file.tensor_count, 2);
        const struct pbnds_safetensor *a = pbnds_safetensors_find(&file, "a.w");
        const struct pbnds_safetensor *b = pbnds_safetensors_find(&file, "b");
        assert_non_null(a);
        assert_non_null(b);
        assert_null(pbnds_safetensors_find(&file, "a"));
        assert_int_equal(a->rank, 2);
        assert_int_equal(a->shape[0], 2);
        assert_int_equal(a->shape[1], 3);
        assert_int_equal(a->count, 6);
        assert_int_equal((uintptr_t)a->data % sizeof(float), 0);
        assert_memory_equal(a->data, data, 24);
        assert_int_equal(b->rank, 0);
        assert_int_equal(b->count, 1);
        assert_near((double)b->data[0], 42.0, 0.0);
        assert_string_equal(pbnds_safetensors_metadata(&file, "k"), "v\xc3\xa9");
        assert_null(pbnds_safetensors_metadata(&file, "v"));
        pbnds_safetensors_free(&file);
    }
}

static void what_is_written_is_read_back(void **state)
{
    (void)state;
    float w[24], b[3] = {INFINITY, -0.0f, 1e-42f};
    for (int i = 0; i < 24; ++i)
        w[i] = (float)i / 7.0f;
    struct pbnds_safetensor tensors[] = {
        {"layer.0.weight", {2, 3, 2, 2}, 4, 24, w},
        {"quote\"\\\n\xc3\xa9", {3}, 1, 3, b},
        {"empty", {0, 5}, 2, 0, NULL},
    };
    struct pbnds_metadata metadata[] = {{"model", "pbnds+"}, {"tab\t", "{\"a\":[1]}"}};
    const struct pbnds_safetensors file = {tensors, 3, metadata, 2, NULL};
    struct pbnds_safetensors back;
    struct pbnds_error error = {""};
    const char *path = "test_safetensors.tmp";
    if (pbnds_safetensors_write(path, &file, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    if (pbnds_safetensors_read(path, &back, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    assert_int_equal(back.tensor_count, 3);
    for (int i = 0; i < 3; ++i) {
        const struct pbnds_safetensor *t = &back.tensors[i];
        assert_string_equal(t->name, tensors[i].name);
        assert_int_equal(t->rank, tensors[i].rank);
        assert_memory_equal(t->shape, tensors[i].shape, sizeof t->shape);
        assert_int_equal(t->count, tensors[i].count);
        if (t->count) assert_memory_equal(t->data, tensors[i].data, 4 * t->count);
    }
    assert_int_equal(back.metadata_count, 2);
    for (int i = 0; i < 2; ++i) {
        assert_string_equal(back.metadata[i].key, metadata[i].key);
        assert_string_equal(back.metadata[i].value, metadata[i].value);
    }
    /* the length is little-endian and the data start on a multiple of 8 */
    uint8_t *bytes;
    size_t size;
    assert_int_equal(pbnds_file_read(path, 1 << 20, &bytes, &size, &error), PBNDS_OK);
    const size_t length = bytes[0] + 256u * bytes[1];
    assert_int_equal(length % 8, 0);
    assert_int_equal(size, 8 + length + 4 * 27);
    free(bytes);
    pbnds_safetensors_free(&back);
    (void)remove(path);
}

static void every_cut_is_refused(void **state)
{
    (void)state;
    const char *json =
        "{\"__metadata__\":{\"k\":\"v\"},"
        "\"a\":{\"dtype\":\"F32\",\"shape\":[4],\"data_offsets\":[0,16]}}";
    const float data[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    struct pbnds_safetensors file;
    struct pbnds_error error;
    size_t size;
    uint8_t *bytes = make_file(json, data, sizeof data, &size);
    for (size_t cut = 0; cut < size; ++cut) {
        uint8_t *part =
            malloc(cut + 1); /* of its own, so that a sanitizer sees its end */
        assert_non_null(part);
        memcpy(part, bytes, cut);
        assert_int_equal(pbnds_safetensors_parse(part, cut, "x", &file, &error),
                         PBNDS_ERROR_FORMAT);
        free(part);
    }
    assert_int_equal(pbnds_safetensors_parse(bytes, size, "x", &file, &error),
                     PBNDS_OK);
    pbnds_safetensors_free(&file);
    free(bytes);
}

#define F32(shape, begin, end)                                                         \
    "{\"dtype\":\"F32\",\"shape\":" shape ",\"data_offsets\":[" begin "," end "]}"

static void damaged_headers_are_refused(void **state)
{
    (void)state;
    const enum pbnds_status bad = PBNDS_ERROR_FORMAT, other = PBNDS_ERROR_UNSUPPORTED;
    refuses("{\"a\":" F32("[2]", "0", "8") "}", 4, bad);   /* outside */
    refuses("{\"a\":" F32("[2]", "0", "8") "}", 12, bad);  /* rest */
    refuses("{\"a\":" F32("[3]", "0", "8") "}", 8, bad);   /* shape */
    refuses("{\"a\":" F32("[2]", "8", "0") "}", 8, bad);   /* reversed */
    refuses("{\"a\":" F32("[-2]", "0", "8") "}", 8, bad);  /* negative */
    refuses("{\"a\":" F32("[1.5]", "0", "6") "}", 6, bad); /* fraction */
    refuses("{\"a\":" F32("[2147483647,2147483647,2147483647,4]", "0", "16") "}", 16,
            bad);
    refuses("{\"a\":" F32("[65536,65536,65536,65536]", "0", "0") "}", 0,
            bad); /* 2^64 */
    refuses("{\"a\":" F32("[1e300]", "0", "0") "}", 0, bad);
    refuses("{\"a\":" F32("[2]", "0", "18446744073709551624") "}", 8, bad);
    refuses("{\"a\":" F32("[2]", "0", "8") ",\"b\":" F32("[2]", "4", "12") "}", 12,
            bad);
    refuses("{\"a\":" F32("[1]", "0", "4") ",\"b\":" F32("[1]", "8", "12") "}", 12,
            bad);
    refuses("{\"a\":" F32("[1]", "0", "4") ",\"b\":" F32("[1]", "0", "4") "}", 4, bad);
    refuses("{\"a\":" F32("[1]", "0", "4") ",\"a\":" F32("[1]", "4", "8") "}", 8, bad);
    refuses("{\"a\":" F32("[0]", "0", "0") ",\"\\u0061\":" F32("[0]", "0", "0") "}", 0,
            bad);
    refuses("{\"__metadata__\":{\"k\":\"v\",\"k\":\"w\"}}", 0, bad);
    refuses("{\"__metadata__\":{\"k\":1}}", 0, bad);
    refuses("{\"__metadata__\":[\"k\"]}", 0, bad);
    refuses("{\"a\\u0000b\":" F32("[0]", "0", "0") "}", 0, bad);
    refuses("{\"a\xff\":" F32("[0]", "0", "0") "}", 0, bad);
    refuses("{\"a\xed\xa0\x80\":" F32("[0]", "0", "0") "}", 0, bad); /* surrogate */
    refuses("{\"a\":{\"dtype\":\"F32\",\"shape\":[0]}}", 0, bad);
    refuses("{\"a\":{\"shape\":[0],\"data_offsets\":[0,0]}}", 0, bad);
    refuses("{\"a\":{\"dtype\":\"F32\",\"data_offsets\":[0,0]}}", 0, bad);
    refuses("{\"a\":{\"dtype\":\"F32\",\"dtype\":\"F32\",\"shape\":[0],"
            "\"data_offsets\":[0,0]}}",
            0, bad);
    refuses("{\"a\":{\"dtype\":\"F32\",\"shape\":[0],\"data_offsets\":[0,0],\"x\":1}}",
            0, bad);
    refuses("{\"a\":{\"dtype\":\"F32\",\"shape\":[0],\"data_offsets\":[0,0,0]}}", 0,
            bad);
    refuses("{\"a\":7}", 0, bad);
    refuses("{\"a\":" F32("[0]", "0", "0") "} x", 0, bad);
    refuses("{\"a\":" F32("[0]", "0", "0"), 0, bad);
    refuses("[]", 0, bad);
    refuses("", 0, bad);
    refuses("{\"a\":[[[[[[[[]]]]]]]]}", 0, bad);
    refuses("{\"a\":" F32("[1,1,1,1,1]", "0", "4") "}", 4, other);
    refuses("{\"a\":{\"dtype\":\"BF16\",\"shape\":[2],\"data_offsets\":[0,4]}}", 4,
            other);
    refuses("{\"\":" F32("[0]", "0", "0") "}", 0, other);
    char name[400];
    (void)snprintf(name, sizeof name, "{\"%096d\":%s}", 0, F32("[0]", "0", "0"));
    refuses(name, 0, other);
}

/* No JSON library may be trusted with a header of nothing but brackets or commas. */
static void hostile_headers_are_refused_at_once(void **state)
{
    (void)state;
    const size_t length = 4u << 20;
    char *json = malloc(length + 1);
    assert_non_null(json);
    for (int kind = 0; kind < 2; ++kind) {
        memset(json, kind == 0 ? '[' : ',', length);
        memcpy(json, "{\"a\":[", 6);
        json[length] = 0;
        refuses(json, 0, PBNDS_ERROR_FORMAT);
    }
    free(json);
    struct pbnds_safetensors file;
    struct pbnds_error error;
    uint8_t huge[16] = {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, '{', '}'};
    assert_int_equal(pbnds_safetensors_parse(huge, sizeof huge, "x", &file, &error),
                     PBNDS_ERROR_FORMAT);
    memset(huge, 0, 8);
    huge[4] = 1; /* 4 GiB of header */
    assert_int_equal(pbnds_safetensors_parse(huge, sizeof huge, "x", &file, &error),
                     PBNDS_ERROR_FORMAT);
}

static void what_cannot_be_read_back_is_not_written(void **state)
{
    (void)state;
    const float data[4] = {0};
    struct pbnds_error error;
    const char *path = "test_safetensors_refused.tmp";
    struct pbnds_safetensor tensors[2] = {{"a", {4}, 1, 4, data},
                                          {"b", {4}, 1, 4, data}};
    struct pbnds_metadata metadata[2] = {{"k", "v"}, {"l", "v"}};
    const struct pbnds_safetensors file = {tensors, 2, metadata, 2, NULL};
    const struct pbnds_safetensor good = tensors[1];
    const enum pbnds_status refused = PBNDS_ERROR_ARGUMENT;
    tensors[1].name[0] = 'a';
    assert_int_equal(pbnds_safetensors_write(path, &file, &error), refused);
    tensors[1] = good;
    tensors[1].count = 3;
    assert_int_equal(pbnds_safetensors_write(path, &file, &error), refused);
    tensors[1] = good;
    memset(tensors[1].name, 'x', sizeof tensors[1].name);
    assert_int_equal(pbnds_safetensors_write(path, &file, &error), refused);
    tensors[1] = good;
    tensors[1].name[0] = (char)0xff;
    assert_int_equal(pbnds_safetensors_write(path, &file, &error), refused);
    tensors[1] = good;
    (void)strcpy(tensors[1].name, "__metadata__");
    assert_int_equal(pbnds_safetensors_write(path, &file, &error), refused);
    tensors[1] = good;
    metadata[1].key = metadata[0].key;
    assert_int_equal(pbnds_safetensors_write(path, &file, &error), refused);
    assert_int_not_equal(access(path, F_OK), 0);
    metadata[1].key = metadata[0].value;
    assert_int_equal(pbnds_safetensors_write("no/such/folder/x", &file, &error),
                     PBNDS_ERROR_IO);
    struct pbnds_safetensors back;
    assert_int_equal(pbnds_safetensors_read("no/such/file", &back, &error),
                     PBNDS_ERROR_IO);
    assert_null(back.storage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_written_by_hand_is_read),
        cmocka_unit_test(what_is_written_is_read_back),
        cmocka_unit_test(every_cut_is_refused),
        cmocka_unit_test(damaged_headers_are_refused),
        cmocka_unit_test(hostile_headers_are_refused_at_once),
        cmocka_unit_test(what_cannot_be_read_back_is_not_written),
    };
    return cmocka_run_group_tests_name("neural/model/safetensors", tests, NULL, NULL);
}
