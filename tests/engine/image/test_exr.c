#include "engine/image/exr.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "engine/image/oiio.h"
#include "tests/engine/core/scratch.h"

#define FOLDER "scratch_image_exr"
#define PATH   FOLDER "/a.exr"

static const enum pbnds_exr_compression compressions[] = {
    PBNDS_EXR_NONE, PBNDS_EXR_ZIPS, PBNDS_EXR_ZIP, PBNDS_EXR_PIZ};

static int setup(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    return 0;
}

/* ---- half floats, from the definition ---- */

static double half_value(unsigned half)
{
    const int exponent = (int)(half >> 10 & 31), mantissa = (int)(half & 1023);
    const double sign = half & 0x8000u ? -1.0 : 1.0;
    if (exponent == 31) return mantissa ? (double)NAN : sign * HUGE_VAL;
    if (exponent == 0) return sign * ldexp(mantissa, -24);
    return sign * ldexp(1024 + mantissa, exponent - 25);
}

static uint32_t float_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Writes floats as one half channel and reads them back. */
static void through_half(const float *in, float *out, int width, int height)
{
    struct pbnds_error error = {""};
    struct pbnds_exr_channel channel = {"Y", PBNDS_EXR_HALF, NULL};
    float *copy = malloc(sizeof(float) * (size_t)width * (size_t)height);
    assert_non_null(copy);
    memcpy(copy, in, sizeof(float) * (size_t)width * (size_t)height);
    channel.data = copy;
    const struct pbnds_exr file = {.width = width,
                                   .height = height,
                                   .compression = PBNDS_EXR_NONE,
                                   .channels = &channel,
                                   .channel_count = 1};
    assert_int_equal(pbnds_exr_write(PATH, &file, &error), PBNDS_OK);
    struct pbnds_exr back;
    assert_int_equal(pbnds_exr_read(PATH, &back, &error), PBNDS_OK);
    assert_int_equal(back.channels[0].type, PBNDS_EXR_HALF);
    memcpy(out, back.channels[0].data, sizeof(float) * (size_t)width * (size_t)height);
    pbnds_exr_free(&back);
    free(copy);
}

static void test_every_half(void **state)
{
    (void)state;
    static float in[65536], out[65536];
    for (unsigned h = 0; h < 65536; ++h)
        in[h] = (float)half_value(h);
    through_half(in, out, 256, 256);
    for (unsigned h = 0; h < 65536; ++h) {
        if (isnan(in[h])) {
            assert_true(isnan(out[h]));
        } else {
            assert_int_equal(float_bits(out[h]),
                             float_bits(in[h])); /* the sign of 0 too */
        }
    }
}

/* Between two neighbours: below the middle down, above it up, on it to the even one. */
static void test_half_rounds_to_nearest_even(void **state)
{
    (void)state;
    enum { N = 0x7bff };
    static float in[4 * N], out[4 * N];
    for (unsigned h = 0; h < N; ++h) {
        const float middle = (float)((half_value(h) + half_value(h + 1)) / 2.0);
        in[4 * h] = nextafterf(middle, 0.0f);
        in[4 * h + 1] = middle;
        in[4 * h + 2] = nextafterf(middle, INFINITY);
        in[4 * h + 3] = -middle;
    }
    through_half(in, out, 4, N);
    for (unsigned h = 0; h < N; ++h) {
        const float low = (float)half_value(h), high = (float)half_value(h + 1);
        const float even = h % 2 == 0 ? low : high;
        assert_true(out[4 * h] == low);
        assert_true(out[4 * h + 1] == even);
        assert_true(out[4 * h + 2] == high);
        assert_true(out[4 * h + 3] == -even);
    }
}

static void test_half_saturates(void **state)
{
    (void)state;
    const float in[] = {65504.0f,  65519.99f, 65520.0f, 1e30f,   -70000.0f, INFINITY,
                        -INFINITY, NAN,       1e-30f,   -1e-40f, 161008.0f, -NAN};
    float out[12];
    through_half(in, out, 12, 1);
    for (int i = 0; i < 4; ++i)
        assert_true(out[i] == 65504.0f);
    assert_true(out[4] == -65504.0f);
    assert_true(out[5] == INFINITY);
    assert_true(out[6] == -INFINITY);
    assert_true(isnan(out[7]));
    assert_int_equal(float_bits(out[8]), 0);
    assert_int_equal(float_bits(out[9]), 0x80000000u);
    assert_true(out[10] == 65504.0f);
    assert_true(isnan(out[11]));
}

/* ---- round trips ---- */

/* Five channels of the three types, not in the order of their names. */
enum { CHANNELS = 5 };

static void describe(struct pbnds_exr *file, struct pbnds_exr_channel *channels,
                     int width, int height, enum pbnds_exr_compression compression)
{
    static const char *const names[CHANNELS] = {"normal.Z", "Z", "albedo.R",
                                                "object_id", "albedo.B"};
    static const enum pbnds_exr_type types[CHANNELS] = {PBNDS_EXR_HALF, PBNDS_EXR_FLOAT,
                                                        PBNDS_EXR_HALF, PBNDS_EXR_UINT,
                                                        PBNDS_EXR_FLOAT};
    const size_t count = (size_t)width * (size_t)height;
    for (int c = 0; c < CHANNELS; ++c) {
        struct pbnds_rng r = pbnds_rng_make(4, (uint64_t)c, count);
        channels[c] = (struct pbnds_exr_channel){"", types[c], malloc(count * 4)};
        strcpy(channels[c].name, names[c]);
        assert_non_null(channels[c].data);
        for (size_t i = 0; i < count; ++i) {
            /* Smooth with some noise: compresses, but not to nothing. */
            const float x = (float)(i % 97) + pbnds_rng_float(&r);
            const uint32_t id = (uint32_t)pbnds_rng_u64(&r) >> (i % 32);
            const unsigned half = (unsigned)(i * 37u + (unsigned)c) % 0x7c00u;
            float value = types[c] == PBNDS_EXR_HALF ? (float)half_value(half) : x;
            if (c == 1 && i % 5 == 0) value = INFINITY; /* depth of the background */
            if (types[c] == PBNDS_EXR_UINT) {
                ((uint32_t *)channels[c].data)[i] = id;
            } else {
                ((float *)channels[c].data)[i] = value;
            }
        }
    }
    *file = (struct pbnds_exr){.width = width,
                               .height = height,
                               .compression = compression,
                               .channels = channels,
                               .channel_count = CHANNELS};
}

static void forget(struct pbnds_exr_channel *channels)
{
    for (int c = 0; c < CHANNELS; ++c)
        free(channels[c].data);
}

static void test_lossless(void **state)
{
    (void)state;
    const int sizes[][2] = {{1, 1}, {3, 17}, {129, 70}, {700, 2}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; ++s) {
        for (int k = 0; k < 4; ++k) {
            struct pbnds_error error = {""};
            struct pbnds_exr file, back;
            struct pbnds_exr_channel channels[CHANNELS];
            describe(&file, channels, sizes[s][0], sizes[s][1], compressions[k]);
            assert_int_equal(pbnds_exr_write(PATH, &file, &error), PBNDS_OK);
            assert_int_equal(pbnds_exr_read(PATH, &back, &error), PBNDS_OK);
            assert_int_equal(back.width, file.width);
            assert_int_equal(back.height, file.height);
            assert_int_equal(back.compression, compressions[k]);
            assert_int_equal(back.channel_count, CHANNELS);
            for (int c = 0; c < CHANNELS; ++c) {
                const struct pbnds_exr_channel *found =
                    pbnds_exr_find(&back, channels[c].name);
                assert_non_null(found);
                assert_int_equal(found->type, channels[c].type);
                assert_memory_equal(found->data, channels[c].data,
                                    4 * (size_t)file.width * (size_t)file.height);
            }
            assert_null(pbnds_exr_find(&back, "albedo.G"));
            pbnds_exr_free(&back);
            assert_null(back.channels);
            forget(channels);
        }
    }
    assert_int_equal(scratch_count(FOLDER), 1);
}

static void read_bytes(const char *path, uint8_t **bytes, size_t *size)
{
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_file_read(path, 1 << 28, bytes, size, &error), PBNDS_OK);
}

static void test_pure_and_sorted(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        struct pbnds_error error = {""};
        struct pbnds_exr file, back;
        struct pbnds_exr_channel channels[CHANNELS];
        uint8_t *first, *second;
        size_t first_size, second_size;
        describe(&file, channels, 65, 50, compressions[k]);
        assert_int_equal(pbnds_exr_write(PATH, &file, &error), PBNDS_OK);
        read_bytes(PATH, &first, &first_size);
        /* The order of the description does not matter either. */
        const struct pbnds_exr_channel kept = channels[0];
        channels[0] = channels[3];
        channels[3] = kept;
        assert_int_equal(pbnds_exr_write(FOLDER "/b.exr", &file, &error), PBNDS_OK);
        read_bytes(FOLDER "/b.exr", &second, &second_size);
        assert_int_equal(first_size, second_size);
        assert_memory_equal(first, second, first_size);
        assert_int_equal(pbnds_exr_read(PATH, &back, &error), PBNDS_OK);
        for (int c = 1; c < CHANNELS; ++c) {
            assert_true(strcmp(back.channels[c - 1].name, back.channels[c].name) < 0);
        }
        pbnds_exr_free(&back);
        free(first);
        free(second);
        forget(channels);
    }
}

static void test_attributes(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_exr file, back, again;
    struct pbnds_exr_channel channels[CHANNELS];
    struct pbnds_exr_attribute a[6] = {
        {.name = "normalSpace", .type = PBNDS_EXR_ATTRIBUTE_STRING},
        {.name = "pbnds:contractVersion",
         .type = PBNDS_EXR_ATTRIBUTE_INT,
         .value.i = -7},
        {.name = "envYaw", .type = PBNDS_EXR_ATTRIBUTE_FLOAT, .value.f = 12.625f},
        {.name = "worldToCamera", .type = PBNDS_EXR_ATTRIBUTE_M44F},
        {.name = "pbnds:aNameOfMoreThanThirtyOneCharacters",
         .type = PBNDS_EXR_ATTRIBUTE_STRING,
         .value.string = "caf\xc3\xa9"},
        {.name = "pixelAspectRatio",
         .type = PBNDS_EXR_ATTRIBUTE_FLOAT,
         .value.f = 1.5f},
    };
    memset(a[0].value.string, 's', 511);
    a[0].value.string[511] = 0;
    for (int i = 0; i < 16; ++i)
        a[3].value.m44[i] = (float)i + 0.5f;
    describe(&file, channels, 4, 4, PBNDS_EXR_ZIP);
    file.attributes = a;
    file.attribute_count = 6;
    assert_int_equal(pbnds_exr_write(PATH, &file, &error), PBNDS_OK);
    assert_int_equal(pbnds_exr_read(PATH, &back, &error), PBNDS_OK);
    assert_int_equal(pbnds_exr_write(PATH, &back, &error),
                     PBNDS_OK); /* what was read */
    assert_int_equal(pbnds_exr_read(PATH, &again, &error), PBNDS_OK);
    assert_int_equal(back.attribute_count, again.attribute_count);
    const struct pbnds_exr *const files[] = {&back, &again};
    for (int k = 0; k < 2; ++k) {
        const struct pbnds_exr_attribute *found[6];
        for (int i = 0; i < 6; ++i) {
            found[i] = pbnds_exr_find_attribute(files[k], a[i].name);
            assert_non_null(found[i]);
            assert_int_equal(found[i]->type, a[i].type);
        }
        assert_string_equal(found[0]->value.string, a[0].value.string);
        assert_int_equal(found[1]->value.i, -7);
        assert_true(found[2]->value.f == 12.625f);
        assert_memory_equal(found[3]->value.m44, a[3].value.m44, 64);
        assert_string_equal(found[4]->value.string, "caf\xc3\xa9");
        assert_true(found[5]->value.f == 1.5f);
        assert_null(pbnds_exr_find_attribute(files[k], "envyaw"));
    }
    pbnds_exr_free(&back);
    pbnds_exr_free(&again);
    forget(channels);
}

/* A second opinion: OpenImageIO reads what we write. */
static void test_foreign_reader_agrees(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    enum { W = 37, H = 21 };
    static float planes[4][W * H];
    struct pbnds_exr_channel channels[4] = {{"R", PBNDS_EXR_FLOAT, planes[0]},
                                            {"G", PBNDS_EXR_FLOAT, planes[1]},
                                            {"B", PBNDS_EXR_FLOAT, planes[2]},
                                            {"A", PBNDS_EXR_HALF, planes[3]}};
    struct pbnds_rng r = pbnds_rng_make(8, 0, 0);
    for (int i = 0; i < W * H; ++i) {
        for (int c = 0; c < 3; ++c)
            planes[c][i] = pbnds_rng_float(&r) * 100.0f;
        planes[3][i] = (float)(i % 2);
    }
    for (int k = 0; k < 4; ++k) {
        const struct pbnds_exr file = {.width = W,
                                       .height = H,
                                       .compression = compressions[k],
                                       .channels = channels,
                                       .channel_count = 4};
        assert_int_equal(pbnds_exr_write(PATH, &file, &error), PBNDS_OK);
        uint8_t *bytes;
        size_t size;
        struct pbnds_pixels pixels;
        read_bytes(PATH, &bytes, &size);
        assert_int_equal(pbnds_pixels_decode(bytes, size, PATH, &pixels, &error),
                         PBNDS_OK);
        assert_int_equal(pixels.width, W);
        assert_int_equal(pixels.height, H);
        for (int i = 0; i < W * H; ++i) {
            for (int c = 0; c < 4; ++c)
                assert_true(pixels.f32[4 * i + c] == planes[c][i]);
        }
        pbnds_pixels_free(&pixels);
        free(bytes);
    }
}

/* ---- writing where it cannot be ---- */

static void test_write_refuses(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_exr file, good;
    struct pbnds_exr_channel channels[CHANNELS];
    describe(&good, channels, 4, 4, PBNDS_EXR_ZIP);
    for (int i = 0; i < 10; ++i) {
        const struct pbnds_exr_channel kept = channels[2];
        struct pbnds_exr_attribute reserved = {.name = "dataWindow",
                                               .type = PBNDS_EXR_ATTRIBUTE_INT};
        file = good;
        if (i == 0) file.width = 0;
        if (i == 1) file.height = -1;
        if (i == 2) file.width = 65536;
        if (i == 3) file.channel_count = 0;
        if (i == 4) file.compression = (enum pbnds_exr_compression)8;
        if (i == 5) strcpy(channels[2].name, "Z"); /* twice */
        if (i == 6) channels[2].name[0] = 0;
        if (i == 7) channels[2].data = NULL;
        if (i == 8) channels[2].type = (enum pbnds_exr_type)3;
        if (i == 9) {
            file.attributes = &reserved;
            file.attribute_count = 1;
        }
        error.message[0] = 0;
        assert_int_equal(pbnds_exr_write(PATH, &file, &error), PBNDS_ERROR_ARGUMENT);
        assert_non_null(strstr(error.message, PATH));
        assert_int_equal(scratch_count(FOLDER), 0);
        channels[2] = kept;
    }
    forget(channels);
}

static void test_write_fails_cleanly(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_exr file;
    struct pbnds_exr_channel channels[CHANNELS];
    describe(&file, channels, 200, 200, PBNDS_EXR_NONE);
    assert_int_equal(pbnds_exr_write(FOLDER "/none/a.exr", &file, &error),
                     PBNDS_ERROR_IO);
    assert_int_equal(pbnds_exr_write("/proc/a.exr", &file, &error), PBNDS_ERROR_IO);
    assert_int_equal(pbnds_make_folder(FOLDER "/d.exr", &error), PBNDS_OK);
    assert_int_equal(pbnds_exr_write(FOLDER "/d.exr", &file, &error), PBNDS_ERROR_IO);
    assert_int_equal(rmdir(FOLDER "/d.exr"), 0);
    assert_int_equal(scratch_count(FOLDER), 0);
    /* A disk that fills up in the header, in the table, in the pixels, in the last
     * ones. */
    const rlim_t limits[] = {4, 300, 1000, 20000, 600000};
    assert_int_equal(pbnds_file_write(PATH, "old", 3, &error), PBNDS_OK);
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; ++i) {
        const struct rlimit old = scratch_limit(limits[i]);
        const enum pbnds_status status = pbnds_exr_write(PATH, &file, &error);
        scratch_unlimit(old);
        assert_int_equal(status, PBNDS_ERROR_IO);
        assert_non_null(strstr(error.message, PATH));
        assert_int_equal(scratch_count(FOLDER), 1);
    }
    uint8_t *bytes;
    size_t size;
    read_bytes(PATH, &bytes, &size);
    assert_int_equal(size, 3); /* the old one */
    free(bytes);
    forget(channels);
}

/* ---- reading what is not sound ---- */

static enum pbnds_status read_status(const uint8_t *bytes, size_t size)
{
    struct pbnds_error error = {""};
    (void)remove(FOLDER "/bad.exr"); /* truncating it would make the disk wait */
    FILE *f = fopen(FOLDER "/bad.exr", "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
    struct pbnds_exr exr;
    const enum pbnds_status status = pbnds_exr_read(FOLDER "/bad.exr", &exr, &error);
    if (status != PBNDS_OK) {
        assert_null(exr.channels);
        assert_null(exr.attributes);
        assert_int_equal(exr.channel_count, 0);
        assert_non_null(strstr(error.message, FOLDER "/bad.exr"));
    }
    pbnds_exr_free(&exr);
    return status;
}

/* A sound small file to damage. */
static void sound(uint8_t **bytes, size_t *size, enum pbnds_exr_compression compression)
{
    struct pbnds_error error = {""};
    struct pbnds_exr file;
    struct pbnds_exr_channel channels[CHANNELS];
    describe(&file, channels, 6, 20, compression);
    assert_int_equal(pbnds_exr_write(PATH, &file, &error), PBNDS_OK);
    forget(channels);
    read_bytes(PATH, bytes, size);
}

/* Where the value of an attribute begins: its name, its type, their zeros, its size. */
static uint8_t *value_of(uint8_t *bytes, size_t size, const char *name,
                         const char *type)
{
    const size_t n = strlen(name) + 1, t = strlen(type) + 1;
    for (size_t i = 8; i + n + t + 4 < size; ++i) {
        if (memcmp(bytes + i, name, n) == 0 && memcmp(bytes + i + n, type, t) == 0) {
            return bytes + i + n + t + 4;
        }
    }
    fail_msg("no attribute %s", name);
    return NULL;
}

static void put32(uint8_t *p, int32_t value)
{
    const uint32_t v = (uint32_t)value;
    for (int i = 0; i < 4; ++i)
        p[i] = (uint8_t)(v >> (8 * i));
}

static int32_t get32(const uint8_t *p)
{
    return (int32_t)((uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 |
                     p[0]);
}

static enum pbnds_status window_status(int x0, int y0, int x1, int y1)
{
    uint8_t *bytes;
    size_t size;
    sound(&bytes, &size, PBNDS_EXR_ZIP);
    uint8_t *window = value_of(bytes, size, "dataWindow", "box2i");
    put32(window, x0);
    put32(window + 4, y0);
    put32(window + 8, x1);
    put32(window + 12, y1);
    const enum pbnds_status status = read_status(bytes, size);
    free(bytes);
    return status;
}

static void test_absurd_sizes(void **state)
{
    (void)state;
    assert_int_equal(window_status(0, 0, 5, 19), PBNDS_OK);
    assert_int_equal(window_status(0, 0, -1, 19), PBNDS_ERROR_FORMAT); /* 0 x 20 */
    assert_int_equal(window_status(0, 0, -1, -1), PBNDS_ERROR_FORMAT);
    assert_int_equal(window_status(5, 0, 0, 19), PBNDS_ERROR_FORMAT);
    assert_int_equal(window_status(0, 0, 5, 40), PBNDS_ERROR_FORMAT); /* lacks rows */
    assert_int_equal(window_status(0, 0, 65534, 65534), PBNDS_ERROR_FORMAT);
    assert_int_not_equal(window_status(0, 0, 70000, 19), PBNDS_OK);
    assert_int_not_equal(window_status(0, 0, 0x7ffffffe, 0x7ffffffe), PBNDS_OK);
    assert_int_not_equal(window_status(-0x7fffffff, 0, 0x7fffffff, 19), PBNDS_OK);
    assert_int_not_equal(window_status(0, -0x7fffffff, 5, 0x7fffffff), PBNDS_OK);
}

/* Over 2^31 bytes of planes in a file that could hold the chunks. */
static void test_memory_cap(void **state)
{
    (void)state;
    uint8_t *bytes;
    size_t size;
    sound(&bytes, &size, PBNDS_EXR_ZIP);
    uint8_t *window = value_of(bytes, size, "dataWindow", "box2i");
    put32(window + 8, 59999);
    put32(window + 12, 59999);
    const size_t large = 1 << 20;
    bytes = realloc(bytes, large);
    assert_non_null(bytes);
    memset(bytes + size, 0, large - size);
    assert_int_equal(read_status(bytes, large), PBNDS_ERROR_MEMORY);
    free(bytes);
}

/* An image somewhere in the plane: windows do not start at 0, rows carry their y. */
static void test_offset_window(void **state)
{
    (void)state;
    uint8_t *bytes;
    size_t size;
    sound(&bytes, &size, PBNDS_EXR_ZIPS);
    struct pbnds_error error = {""};
    struct pbnds_exr before, after;
    assert_int_equal(pbnds_exr_read(PATH, &before, &error), PBNDS_OK);
    uint8_t *window = value_of(bytes, size, "dataWindow", "box2i");
    for (int i = 0; i < 4; ++i)
        put32(window + 4 * i, get32(window + 4 * i) - 1000 + i % 2);
    /* The table of 20 chunks is right before the first one, which its entry points to.
     */
    size_t table = 0;
    for (size_t i = 8; i + 160 < size && !table; ++i) {
        if ((size_t)get32(bytes + i) == i + 160 && get32(bytes + i + 4) == 0) table = i;
    }
    assert_true(table != 0);
    for (int row = 0; row < 20; ++row) {
        uint8_t *chunk = bytes + get32(bytes + table + 8 * (size_t)row);
        assert_int_equal(get32(chunk), row);
        put32(chunk, row - 999);
    }
    assert_int_equal(read_status(bytes, size), PBNDS_OK);
    assert_int_equal(pbnds_exr_read(FOLDER "/bad.exr", &after, &error), PBNDS_OK);
    assert_int_equal(after.width, 6);
    assert_int_equal(after.height, 20);
    for (int c = 0; c < CHANNELS; ++c) {
        assert_memory_equal(after.channels[c].data, before.channels[c].data,
                            4 * 6 * 20);
    }
    pbnds_exr_free(&before);
    pbnds_exr_free(&after);
    free(bytes);
}

static void test_every_truncation(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        uint8_t *bytes;
        size_t size;
        sound(&bytes, &size, compressions[k]);
        assert_int_equal(read_status(bytes, size), PBNDS_OK);
        for (size_t n = 0; n < size; n += n < 700 ? 1 : 13) {
            assert_int_equal(read_status(bytes, n), PBNDS_ERROR_FORMAT);
        }
        assert_int_equal(read_status(bytes, size - 1), PBNDS_ERROR_FORMAT);
        free(bytes);
    }
}

static void test_damage_never_crashes(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        uint8_t *bytes;
        size_t size;
        sound(&bytes, &size, compressions[k]);
        struct pbnds_rng r = pbnds_rng_make(11, (uint64_t)k, 0);
        int refused = 0;
        for (int i = 0; i < 600; ++i) {
            const size_t at = 4 + (size_t)(pbnds_rng_u64(&r) % (size - 4));
            const uint8_t kept = bytes[at];
            bytes[at] = (uint8_t)pbnds_rng_u64(&r);
            const enum pbnds_status status = read_status(bytes, size);
            assert_true(status == PBNDS_OK || status == PBNDS_ERROR_FORMAT ||
                        status == PBNDS_ERROR_UNSUPPORTED ||
                        status == PBNDS_ERROR_MEMORY);
            refused += status != PBNDS_OK;
            bytes[at] = kept;
        }
        assert_in_range(refused, 20, 600);
        free(bytes);
    }
}

static void test_unsupported_kinds(void **state)
{
    (void)state;
    uint8_t *bytes;
    size_t size;
    sound(&bytes, &size, PBNDS_EXR_ZIP);
    uint8_t *compression = value_of(bytes, size, "compression", "compression");
    for (uint8_t k = 0; k < 12; ++k) {
        if (k == 0 || (k >= 2 && k <= 4)) continue;
        *compression = k; /* RLE, PXR24, B44, B44A, DWAA, DWAB, and two that are none */
        assert_int_equal(read_status(bytes, size),
                         k < 10 ? PBNDS_ERROR_UNSUPPORTED : PBNDS_ERROR_FORMAT);
    }
    *compression = PBNDS_EXR_ZIP;
    assert_int_equal(read_status(bytes, size), PBNDS_OK);
    /* The first channel, Z: name, type, flags, then its sampling. */
    uint8_t *channel = value_of(bytes, size, "channels", "chlist");
    assert_string_equal((const char *)channel, "Z");
    channel += 2;
    put32(channel + 8, 2);
    assert_int_equal(read_status(bytes, size), PBNDS_ERROR_UNSUPPORTED);
    put32(channel + 8, 0);
    assert_int_equal(read_status(bytes, size), PBNDS_ERROR_FORMAT);
    put32(channel + 8, 1);
    put32(channel, 3); /* no such pixel type */
    assert_int_equal(read_status(bytes, size), PBNDS_ERROR_FORMAT);
    put32(channel, 2);
    assert_int_equal(read_status(bytes, size), PBNDS_OK);
    bytes[0] ^= 1; /* magic number */
    assert_int_equal(read_status(bytes, size), PBNDS_ERROR_FORMAT);
    free(bytes);
}

/* Two copies of the header, with the names and counts that a file of two parts needs.
 * The type of a part is in the header already. */
static void test_two_parts(void **state)
{
    (void)state;
    uint8_t *bytes;
    size_t size;
    sound(&bytes, &size, PBNDS_EXR_ZIP);
    const uint8_t *end = value_of(bytes, size, "dataWindow", "box2i");
    size_t header = (size_t)(end - bytes); /* walk to the end of the header from here */
    header += 16;
    while (bytes[header]) {
        header += strlen((const char *)bytes + header) + 1;
        header += strlen((const char *)bytes + header) + 1;
        header += 4 + (size_t)get32(bytes + header);
    }
    uint8_t out[4096] = {0};
    size_t n = 8;
    assert_true(header < 1500);
    memcpy(out, bytes, 8);
    out[5] |= 0x10; /* several parts */
    for (int part = 0; part < 2; ++part) {
        static const uint8_t name[] = "name\0string\0\1\0\0\0";
        static const uint8_t count[] = "chunkCount\0int\0\4\0\0\0\2\0\0\0";
        memcpy(out + n, bytes + 8, header - 8);
        n += header - 8;
        memcpy(out + n, name, sizeof name - 1);
        n += sizeof name - 1;
        out[n++] = (uint8_t)('a' + part);
        memcpy(out + n, count, sizeof count - 1);
        n += sizeof count - 1;
        out[n++] = 0;
    }
    out[n++] = 0;
    assert_int_equal(read_status(out, n + 400), PBNDS_ERROR_UNSUPPORTED);
    free(bytes);
}

static void test_no_file(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_exr exr;
    assert_int_equal(pbnds_exr_read(FOLDER "/none.exr", &exr, &error), PBNDS_ERROR_IO);
    assert_int_equal(pbnds_exr_read(FOLDER, &exr, &error), PBNDS_ERROR_IO);
    assert_null(exr.channels);
    assert_int_equal(read_status((const uint8_t *)"", 0), PBNDS_ERROR_FORMAT);
    assert_int_equal(read_status((const uint8_t *)"\x89PNG\r\n\x1a\n", 8),
                     PBNDS_ERROR_FORMAT);
}

/* ---- files that others made ---- */

static void test_damaged_collection(void **state)
{
    (void)state;
    const char *folder = PBNDS_SHARED_DATA "/malformed/openexr-damaged";
    DIR *dir = opendir(folder);
    if (!dir) skip();
    int count = 0;
    for (const struct dirent *e = readdir(dir); e; e = readdir(dir)) {
        char path[1024];
        struct pbnds_error error = {""};
        struct pbnds_exr exr;
        if (scratch_skip(e)) continue;
        (void)snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        const enum pbnds_status status = pbnds_exr_read(path, &exr, &error);
        assert_true(status == PBNDS_ERROR_FORMAT || status == PBNDS_ERROR_UNSUPPORTED);
        assert_non_null(strstr(error.message, path));
        for (const char *c = error.message; *c; ++c)
            assert_in_range(*c, 0x20, 0x7e);
        pbnds_exr_free(&exr);
        ++count;
    }
    closedir(dir);
    assert_true(count > 50);
}

/* Ours and OpenImageIO's reading of a foreign file: the same but for NaN and infinity.
 */
static void test_foreign_files(void **state)
{
    (void)state;
    static const char *const names[] = {"/exr_valid/AllHalfValues.exr",
                                        "/exr_valid/BrightRingsNanInf.exr",
                                        "/malformed/tinyexr/000-issue194.exr",
                                        "/malformed/tinyexr/issue-160-piz-decode.exr"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char path[1024];
        struct pbnds_error error = {""};
        struct pbnds_exr exr;
        struct pbnds_pixels pixels;
        uint8_t *bytes;
        size_t size;
        (void)snprintf(path, sizeof path, "%s%s", PBNDS_SHARED_DATA, names[i]);
        if (access(path, R_OK) != 0) skip();
        assert_int_equal(pbnds_exr_read(path, &exr, &error), PBNDS_OK);
        read_bytes(path, &bytes, &size);
        assert_int_equal(pbnds_pixels_decode(bytes, size, path, &pixels, &error),
                         PBNDS_OK);
        static const char *const rgb[] = {"R", "G", "B"};
        for (int c = 0; c < 3; ++c) {
            const struct pbnds_exr_channel *channel = pbnds_exr_find(&exr, rgb[c]);
            assert_non_null(channel);
            const float *ours = channel->data;
            for (int k = 0; k < exr.width * exr.height; ++k) {
                const float theirs = pixels.f32[4 * k + c];
                assert_true(ours[k] == theirs || (isnan(ours[k]) && isnan(theirs)));
            }
        }
        pbnds_exr_free(&exr);
        pbnds_pixels_free(&pixels);
        free(bytes);
    }
}

static void test_foreign_kinds_not_supported(void **state)
{
    (void)state;
    static const char *const names[] = {"/exr_valid/WavyLinesLatLong.exr", /* tiled */
                                        "/exr_valid/WideFloatRange.exr",   /* PXR24 */
                                        "/hdri/blender_city.exr"};         /* DWAB  */
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char path[1024];
        struct pbnds_error error = {""};
        struct pbnds_exr exr;
        (void)snprintf(path, sizeof path, "%s%s", PBNDS_SHARED_DATA, names[i]);
        if (access(path, R_OK) != 0) skip();
        assert_int_equal(pbnds_exr_read(path, &exr, &error), PBNDS_ERROR_UNSUPPORTED);
        assert_null(exr.channels);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_every_half, setup),
        cmocka_unit_test_setup(test_half_rounds_to_nearest_even, setup),
        cmocka_unit_test_setup(test_half_saturates, setup),
        cmocka_unit_test_setup(test_lossless, setup),
        cmocka_unit_test_setup(test_pure_and_sorted, setup),
        cmocka_unit_test_setup(test_attributes, setup),
        cmocka_unit_test_setup(test_foreign_reader_agrees, setup),
        cmocka_unit_test_setup(test_write_refuses, setup),
        cmocka_unit_test_setup(test_write_fails_cleanly, setup),
        cmocka_unit_test_setup(test_absurd_sizes, setup),
        cmocka_unit_test_setup(test_memory_cap, setup),
        cmocka_unit_test_setup(test_offset_window, setup),
        cmocka_unit_test_setup(test_every_truncation, setup),
        cmocka_unit_test_setup(test_damage_never_crashes, setup),
        cmocka_unit_test_setup(test_unsupported_kinds, setup),
        cmocka_unit_test_setup(test_two_parts, setup),
        cmocka_unit_test_setup(test_no_file, setup),
        cmocka_unit_test_setup(test_damaged_collection, setup),
        cmocka_unit_test_setup(test_foreign_files, setup),
        cmocka_unit_test_setup(test_foreign_kinds_not_supported, setup),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
