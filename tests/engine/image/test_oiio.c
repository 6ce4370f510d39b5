#include "engine/image/oiio.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/color.h"
#include "engine/core/rng.h"
#include "engine/core/vec.h"
#include "engine/image/exr.h"
#include "tests/engine/core/scratch.h"
#include "tests/engine/image/png_fixture.h"

#define FOLDER "scratch_image_oiio"

static struct bytes in;

static int setup(void **state)
{
    (void)state;
    scratch_make(FOLDER);
    return 0;
}

/* Decodes an exact copy, so that a sanitizer sees every read beyond its end. */
static enum pbnds_status decode(const struct bytes *b, struct pbnds_pixels *pixels)
{
    struct pbnds_error error = {""};
    uint8_t *copy = malloc(b->size ? b->size : 1);
    assert_non_null(copy);
    memcpy(copy, b->data, b->size);
    const enum pbnds_status status =
        pbnds_pixels_decode(copy, b->size, "picture", pixels, &error);
    free(copy);
    if (status != PBNDS_OK) {
        assert_null(pixels->u8);
        assert_null(pixels->f32);
        assert_non_null(strstr(error.message, "picture"));
        assert_null(strchr(error.message, '\n'));
    }
    return status;
}

static void make_png(uint32_t width, uint32_t height, unsigned depth, unsigned colour,
                     const void *rows, size_t stride)
{
    put_signature(&in);
    put_header(&in, width, height, depth, colour);
    if (colour == 3) {
        put_chunk(&in, "PLTE", "\x0a\x14\x1e\xc8\x64\x32", 6);
        put_chunk(&in, "tRNS", "\x07", 1);
    }
    put_pixels(&in, rows, stride, height);
    put_end(&in);
}

static void assert_bytes(unsigned depth, unsigned colour, const char *row,
                         size_t stride, const char *expected)
{
    struct pbnds_pixels p;
    make_png(2, 1, depth, colour, row, stride);
    assert_int_equal(decode(&in, &p), PBNDS_OK);
    assert_int_equal(p.width, 2);
    assert_int_equal(p.height, 1);
    assert_int_equal(p.channels, 4);
    assert_non_null(p.u8);
    assert_null(p.f32);
    assert_memory_equal(p.u8, expected, 8);
    pbnds_pixels_free(&p);
    assert_null(p.u8);
}

/* Values as stored: no gamma, no premultiplication; grey is replicated. */
static void test_png_of_8_bits_and_less(void **state)
{
    (void)state;
    assert_bytes(8, 2, "\1\2\3\xf0\xf1\xf2", 6, "\1\2\3\xff\xf0\xf1\xf2\xff");
    assert_bytes(8, 6, "\xff\x80\1\0\x10\x20\x30\x40", 8,
                 "\xff\x80\1\0\x10\x20\x30\x40");
    assert_bytes(8, 0, "\5\xfe", 2, "\5\5\5\xff\xfe\xfe\xfe\xff");
    assert_bytes(8, 4, "\x63\0\x10\x80", 4, "\x63\x63\x63\0\x10\x10\x10\x80");
    assert_bytes(8, 3, "\0\1", 2, "\x0a\x14\x1e\x07\xc8\x64\x32\xff");
    assert_bytes(1, 3, "\x40", 1, "\x0a\x14\x1e\x07\xc8\x64\x32\xff");
    assert_bytes(1, 0, "\x40", 1, "\0\0\0\xff\xff\xff\xff\xff");
    assert_bytes(2, 0, "\x60", 1, "\x55\x55\x55\xff\xaa\xaa\xaa\xff");
    assert_bytes(4, 0, "\x3c", 1, "\x33\x33\x33\xff\xcc\xcc\xcc\xff");
}

static void test_png_of_16_bits(void **state)
{
    (void)state;
    struct pbnds_pixels p;
    make_png(1, 2, 16, 4, "\x12\x34\0\1\xff\xff\x80\0", 4);
    assert_int_equal(decode(&in, &p), PBNDS_OK);
    assert_null(p.u8);
    const double expected[8] = {0x1234, 0x1234, 0x1234, 1,
                                0xffff, 0xffff, 0xffff, 0x8000};
    for (int i = 0; i < 8; ++i) {
        assert_near((double)p.f32[i], expected[i] / 65535.0, 1e-7);
    }
    pbnds_pixels_free(&p);
}

/* RGBE of Ward: mantissa x 2^(e - 136); no runs. */
static void test_radiance(void **state)
{
    (void)state;
    in.size = 0;
    static const char head[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 3\n";
    put(&in, head, sizeof head - 1);
    put(&in, "\x80\x40\x20\x81", 4); /* 128, 64, 32 at 2^-7 */
    put(&in, "\xff\x00\x01\x90", 4); /* 255 and 1 at 2^8 */
    put(&in, "\0\0\0\0", 4);
    struct pbnds_pixels p;
    assert_int_equal(decode(&in, &p), PBNDS_OK);
    const double expected[3][4] = {{1, 0.5, 0.25, 1}, {65280, 0, 256, 1}, {0, 0, 0, 1}};
    for (int i = 0; i < 12; ++i) {
        const double e = expected[i / 4][i % 4];
        /* Some decoders add half a step to the mantissa. */
        assert_near((double)p.f32[i], e,
                    i % 4 == 3 ? 0.0 : 0.5 * (i < 4 ? 0.0079 : 256.0));
    }
    pbnds_pixels_free(&p);
}

/* A lossless WebP of one transparent black pixel. */
static void test_webp(void **state)
{
    (void)state;
    in.size = 0;
    put(&in,
        "RIFF\x1a\0\0\0WEBPVP8L\x0d\0\0\0\x2f\0\0\0\x10\x07\x10\x11\x11\x88\x88\xfe\x07"
        "\0",
        34);
    struct pbnds_pixels p;
    assert_int_equal(decode(&in, &p), PBNDS_OK);
    assert_int_equal(p.width, 1);
    assert_int_equal(p.height, 1);
    assert_memory_equal(p.u8, "\0\0\0\0", 4);
    pbnds_pixels_free(&p);
    struct pbnds_error error = {""};
    struct pbnds_image image; /* a texture format only */
    assert_int_equal(pbnds_file_write(FOLDER "/a.webp", in.data, in.size, &error),
                     PBNDS_OK);
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/a.webp", &image, &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_null(image.data);
}

static void test_what_is_no_picture(void **state)
{
    (void)state;
    struct pbnds_pixels p;
    static const char *const heads[] = {
        "GIF89a....", "II*\0\0\0\0\0..", "BM........",       "P6 1 1 255",
        "<svg />...", "\x89PNG......",   "\xff\xd8......  ", "qoif......"};
    for (size_t i = 0; i < sizeof heads / sizeof heads[0]; ++i) {
        in.size = 0;
        put(&in, heads[i], 10);
        assert_int_equal(decode(&in, &p), PBNDS_ERROR_UNSUPPORTED);
    }
    in.size = 0;
    assert_int_equal(decode(&in, &p), PBNDS_ERROR_FORMAT);
}

static void test_damaged(void **state)
{
    (void)state;
    struct pbnds_pixels p;
    static const uint8_t rows[64] = {1, 2, 3};
    make_png(4, 4, 8, 6, rows, 16);
    assert_int_equal(decode(&in, &p), PBNDS_OK);
    pbnds_pixels_free(&p);
    const size_t size = in.size;
    for (size_t n = 8; n < size; ++n) {
        in.size = n;
        assert_int_equal(decode(&in, &p), PBNDS_ERROR_FORMAT);
    }
    in.size = 0;
    static const char hdr[] =
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 9\n\1\2\3\4";
    for (size_t n = 10; n < sizeof hdr; ++n) { /* pixels are missing */
        in.size = 0;
        put(&in, hdr, n);
        assert_int_equal(decode(&in, &p), PBNDS_ERROR_FORMAT);
    }
}

static void test_sizes(void **state)
{
    (void)state;
    struct pbnds_pixels p;
    static const struct {
        uint32_t width, height, depth;
        enum pbnds_status expected;
    } sizes[] = {{0, 1, 8, PBNDS_ERROR_FORMAT},
                 {1, 0, 8, PBNDS_ERROR_FORMAT},
                 {16385, 1, 8, PBNDS_ERROR_MEMORY},
                 {1, 16385, 8, PBNDS_ERROR_MEMORY},
                 {16384, 16384, 16, PBNDS_ERROR_MEMORY}, /* 4 GiB as floats */
                 {0x7fffffff, 0x7fffffff, 8, PBNDS_ERROR_MEMORY},
                 {0xffffffff, 1, 8, PBNDS_ERROR_FORMAT}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        put_signature(&in);
        put_header(&in, sizes[i].width, sizes[i].height, sizes[i].depth, 0);
        put_pixels(&in, (const uint8_t *)"\0\0", 2, 1);
        put_end(&in);
        assert_int_equal(decode(&in, &p), sizes[i].expected);
    }
    static const char wide[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 20000 +X 9\n";
    in.size = 0;
    put(&in, wide, sizeof wide - 1);
    assert_int_equal(decode(&in, &p), PBNDS_ERROR_MEMORY);
}

/* ---- writing PNG ---- */

static void read_png(const char *path, struct pbnds_pixels *pixels)
{
    struct pbnds_error error = {""};
    uint8_t *bytes;
    size_t size;
    assert_int_equal(pbnds_file_read(path, 1 << 24, &bytes, &size, &error), PBNDS_OK);
    assert_int_equal(pbnds_pixels_decode(bytes, size, path, pixels, &error), PBNDS_OK);
    free(bytes);
}

/* Every code value and both sides of every threshold, for 1, 3 and 4 channels. */
static void test_png_write_rounds(void **state)
{
    (void)state;
    const int channels[] = {1, 3, 4};
    for (int k = 0; k < 3; ++k) {
        const int n = channels[k];
        struct pbnds_error error = {""};
        struct pbnds_image image;
        struct pbnds_pixels back;
        assert_int_equal(pbnds_image_init(&image, 256, 3, n, &error), PBNDS_OK);
        for (int i = 0; i < 256 * 3 * n; ++i) {
            const int code = (i / n + 50 * (i % n)) % 256, row = i / n / 256;
            image.data[i] = ((float)code + (float)(row - 1) * 0.499f) / 255.0f;
        }
        assert_int_equal(pbnds_png_write(FOLDER "/a.png", &image, &error), PBNDS_OK);
        assert_int_equal(scratch_count(FOLDER), 1);
        read_png(FOLDER "/a.png", &back);
        assert_int_equal(back.width, 256);
        assert_int_equal(back.height, 3);
        for (int i = 0; i < 256 * 3; ++i) {
            for (int c = 0; c < 4; ++c) {
                const int source = n == 1 ? 0 : c;
                const int expected = c < 3 || n == 4 ? (i + 50 * source) % 256 : 255;
                assert_int_equal(back.u8[4 * i + c], expected);
            }
        }
        pbnds_pixels_free(&back);
        pbnds_image_free(&image);
    }
}

static void test_png_write_clamps(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    float data[9] = {-1.0f, 2.0f, NAN, INFINITY, -INFINITY, 0.5f, 1.0f, 0.0f, 1e-9f};
    const struct pbnds_image image = {3, 1, 3, data};
    const uint8_t expected[12] = {0, 255, 0, 255, 255, 0, 128, 255, 255, 0, 0, 255};
    struct pbnds_pixels back;
    assert_int_equal(pbnds_png_write(FOLDER "/a.png", &image, &error), PBNDS_OK);
    read_png(FOLDER "/a.png", &back);
    assert_memory_equal(back.u8, expected, 12);
    pbnds_pixels_free(&back);
}

static void test_png_write_is_pure(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    float data[300];
    for (int i = 0; i < 300; ++i)
        data[i] = (float)(i % 17) / 17.0f;
    const struct pbnds_image image = {10, 10, 3, data};
    uint8_t *a, *b;
    size_t a_size, b_size;
    assert_int_equal(pbnds_png_write(FOLDER "/a.png", &image, &error), PBNDS_OK);
    assert_int_equal(pbnds_png_write(FOLDER "/b.png", &image, &error), PBNDS_OK);
    assert_int_equal(pbnds_file_read(FOLDER "/a.png", 1 << 20, &a, &a_size, &error), 0);
    assert_int_equal(pbnds_file_read(FOLDER "/b.png", 1 << 20, &b, &b_size, &error), 0);
    assert_int_equal(a_size, b_size);
    assert_memory_equal(a, b, a_size);
    free(a);
    free(b);
}

static void test_png_write_fails_cleanly(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    static float data[200 * 200 * 3];
    struct pbnds_rng r = pbnds_rng_make(1, 0, 0);
    for (int i = 0; i < 200 * 200 * 3; ++i)
        data[i] = pbnds_rng_float(&r);
    struct pbnds_image image = {200, 200, 3, data};
    assert_int_equal(pbnds_png_write(FOLDER "/none/a.png", &image, &error),
                     PBNDS_ERROR_IO);
    assert_non_null(strstr(error.message, FOLDER "/none/a.png"));
    const struct rlimit old = scratch_limit(10000);
    const enum pbnds_status full = pbnds_png_write(FOLDER "/a.png", &image, &error);
    scratch_unlimit(old);
    assert_int_equal(full, PBNDS_ERROR_IO);
    image.channels = 2;
    assert_int_equal(pbnds_png_write(FOLDER "/a.png", &image, &error),
                     PBNDS_ERROR_ARGUMENT);
    image = (struct pbnds_image){0, 0, 3, NULL};
    assert_int_equal(pbnds_png_write(FOLDER "/a.png", &image, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_int_equal(scratch_count(FOLDER), 0);
}

/* ---- light maps and pictures ---- */

static void test_picture_becomes_linear(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_image image;
    make_png(2, 1, 8, 6, "\x80\x40\xff\0\x01\0\xc8\x80", 8);
    assert_int_equal(pbnds_file_write(FOLDER "/a.png", in.data, in.size, &error),
                     PBNDS_OK);
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/a.png", &image, &error), PBNDS_OK);
    assert_int_equal(image.channels, 3);
    const unsigned codes[6] = {0x80, 0x40, 0xff, 1, 0, 0xc8};
    for (int i = 0; i < 6; ++i) {
        const double expected = (double)pbnds_srgb_decode((float)codes[i] / 255.0f);
        assert_near((double)image.data[i], expected, 1e-7); /* alpha changes nothing */
    }
    pbnds_image_free(&image);
    make_png(1, 1, 16, 0, "\x80\x00", 2);
    assert_int_equal(pbnds_file_write(FOLDER "/b.png", in.data, in.size, &error),
                     PBNDS_OK);
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/b.png", &image, &error), PBNDS_OK);
    const double middle = (double)pbnds_srgb_decode((float)0x8000 / 65535.0f);
    for (int i = 0; i < 3; ++i)
        assert_near((double)image.data[i], middle, 1e-6);
    pbnds_image_free(&image);
}

static void write_exr(const char *const *names, int count, float planes[][6],
                      enum pbnds_exr_type type)
{
    struct pbnds_error error = {""};
    struct pbnds_exr_channel channels[4];
    for (int c = 0; c < count; ++c) {
        channels[c] = (struct pbnds_exr_channel){"", type, planes[c]};
        strcpy(channels[c].name, names[c]);
    }
    const struct pbnds_exr file = {.width = 3,
                                   .height = 2,
                                   .compression = PBNDS_EXR_ZIP,
                                   .channels = channels,
                                   .channel_count = count};
    assert_int_equal(pbnds_exr_write(FOLDER "/a.exr", &file, &error), PBNDS_OK);
}

static void test_light_map_is_tamed(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_image image;
    static const char *const names[] = {"R", "G", "B", "Z"};
    float planes[4][6] = {{1, INFINITY, -3, NAN, 0.5f, 0},
                          {-INFINITY, 2, -0.0f, 70000, 0.25f, 1e-20f},
                          {5, -NAN, 6, 7, 8, 161008},
                          {1e9f, 1e9f, 1e9f, 1e9f, 1e9f, 1e9f}};
    const float expected[18] = {1, 0,     5, 161008, 2,     0, 0, 0,      6,
                                0, 70000, 7, 0.5f,   0.25f, 8, 0, 1e-20f, 161008};
    write_exr(names, 4, planes, PBNDS_EXR_FLOAT);
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/a.exr", &image, &error), PBNDS_OK);
    assert_int_equal(image.width, 3);
    assert_int_equal(image.height, 2);
    for (int i = 0; i < 18; ++i)
        assert_true(image.data[i] == expected[i]);
    pbnds_image_free(&image);
}

static void test_light_map_channels(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_image image;
    float planes[4][6] = {
        {1, 2, 3, 4, 5, 6}, {9, 9, 9, 9, 9, 9}, {7, 7, 7, 7, 7, 7}, {0}};
    static const char *const luminance[] = {"Y", "A"}, *const single[] = {"left"},
                             *const layers[] = {"albedo.B", "albedo.G", "albedo.R"};
    write_exr(luminance, 2, planes, PBNDS_EXR_HALF);
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/a.exr", &image, &error), PBNDS_OK);
    for (int i = 0; i < 18; ++i)
        assert_true(image.data[i] == planes[0][i / 3]);
    pbnds_image_free(&image);
    write_exr(single, 1, planes, PBNDS_EXR_FLOAT);
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/a.exr", &image, &error), PBNDS_OK);
    pbnds_image_free(&image);
    write_exr(layers, 3, planes, PBNDS_EXR_FLOAT); /* a G-buffer is no light map */
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/a.exr", &image, &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_null(image.data);
}

static void test_no_file(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_image image;
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/none.hdr", &image, &error),
                     PBNDS_ERROR_IO);
    assert_non_null(strstr(error.message, FOLDER "/none.hdr"));
    assert_int_equal(pbnds_image_read_rgb(FOLDER, &image, &error), PBNDS_ERROR_IO);
    assert_int_equal(pbnds_file_write(FOLDER "/a.hdr", "hello", 5, &error), PBNDS_OK);
    assert_int_equal(pbnds_image_read_rgb(FOLDER "/a.hdr", &image, &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_null(image.data);
}

/* ---- files that others made ---- */

static int for_each_file(const char *folder, void (*check)(const char *path))
{
    DIR *dir = opendir(folder);
    int count = 0;
    if (!dir) return 0;
    for (const struct dirent *e = readdir(dir); e; e = readdir(dir), ++count) {
        char path[1024];
        if (scratch_skip(e)) continue;
        (void)snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        check(path);
    }
    closedir(dir);
    return count;
}

static float brightest;

static void check_light_map(const char *path)
{
    struct pbnds_error error = {""};
    struct pbnds_image image;
    if (pbnds_image_read_rgb(path, &image, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    assert_int_equal(image.width, 1024);
    assert_int_equal(image.height, 512);
    float most = 0.0f;
    int sane = 1;
    for (int i = 0; i < 1024 * 512; ++i) {
        const float *p = image.data + 3 * i;
        sane = sane && p[0] >= 0.0f && p[1] >= 0.0f && p[2] >= 0.0f && p[0] < 1e6f &&
               p[1] < 1e6f && p[2] < 1e6f;
        most = fmaxf(most, pbnds_luminance(pbnds_vec3_make(p[0], p[1], p[2])));
    }
    if (!sane) fail_msg("%s holds NaN, infinity or less than 0", path);
    if (most < 6.5f) fail_msg("%s: nothing brighter than %g", path, (double)most);
    brightest = fmaxf(brightest, most);
    pbnds_image_free(&image);
}

/* Radiance HDR and DWAB OpenEXR. */
static void test_shared_light_maps(void **state)
{
    (void)state;
    if (for_each_file(PBNDS_SHARED_DATA "/hdri", check_light_map) == 0) skip();
    assert_near((double)brightest, 161008.0, 1.0);
}

static void check_png(const char *path)
{
    struct pbnds_pixels p;
    read_png(path, &p);
    const char *name = strrchr(path, '/') + 1;
    if (name[0] == 's' && strncmp(name, "s0", 2) == 0) {
        assert_int_equal(p.width, name[2] - '0'); /* s07...: 7 x 7 */
        assert_int_equal(p.height, name[2] - '0');
    } else if (name[0] != 's') {
        assert_int_equal(p.width, 32);
    }
    assert_true((p.f32 != NULL) == (strstr(name, "16.png") != NULL));
    pbnds_pixels_free(&p);
}

static void test_png_suite(void **state)
{
    (void)state;
    if (for_each_file(PBNDS_SHARED_DATA "/malformed/pngsuite_valid", check_png) == 0)
        skip();
}

/* Interlaced and plain versions of one picture hold the same pixels. */
static void test_png_suite_interlaced(void **state)
{
    (void)state;
    static const char *const kinds[] = {"0g01", "0g02", "0g04", "0g08", "0g16",
                                        "2c08", "2c16", "3p08", "4a08", "6a16"};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        char plain[1024], interlaced[1024];
        const char *folder = PBNDS_SHARED_DATA "/malformed/pngsuite_valid";
        struct pbnds_pixels a, b;
        (void)snprintf(plain, sizeof plain, "%s/basn%s.png", folder, kinds[i]);
        (void)snprintf(interlaced, sizeof interlaced, "%s/basi%s.png", folder,
                       kinds[i]);
        if (access(plain, R_OK) != 0) skip();
        read_png(plain, &a);
        read_png(interlaced, &b);
        if (a.u8) {
            assert_memory_equal(a.u8, b.u8, 32 * 32 * 4);
        } else {
            assert_memory_equal(a.f32, b.f32, 32 * 32 * 16);
        }
        pbnds_pixels_free(&a);
        pbnds_pixels_free(&b);
    }
}

/* A broken IPTC block, over whose end the library reads, does not get to it. */
static void test_jpeg(void **state)
{
    (void)state;
    const char *path =
        PBNDS_SHARED_DATA "/malformed/gltf-validator/data/image/cyan.jpg";
    struct pbnds_error error = {""};
    struct pbnds_pixels p;
    uint8_t *bytes;
    size_t size;
    if (access(path, R_OK) != 0) skip();
    assert_int_equal(pbnds_file_read(path, 60000, &bytes, &size, &error), PBNDS_OK);
    static const char iptc[] = "\xff\xed\0\x1c"
                               "Photoshop 3.0\0\x1c\2\x78\x7f\xff"
                               "cut off";
    in.size = 0;
    put(&in, bytes, 2);
    put(&in, iptc, 30);
    put(&in, bytes + 2, size - 2);
    free(bytes);
    assert_int_equal(decode(&in, &p), PBNDS_OK);
    assert_int_equal(p.width, 2);
    for (int i = 0; i < 4; ++i) {
        assert_in_range(p.u8[4 * i], 0, 3);
        assert_in_range(p.u8[4 * i + 1], 252, 255);
        assert_in_range(p.u8[4 * i + 2], 252, 255);
        assert_int_equal(p.u8[4 * i + 3], 255);
    }
    pbnds_pixels_free(&p);
    const size_t whole = in.size;
    for (size_t n = 3; n < whole; n += 7) {
        in.size = n;
        assert_int_equal(decode(&in, &p), PBNDS_ERROR_FORMAT);
    }
}

static void check_broken(const char *path)
{
    struct pbnds_error error = {""};
    struct pbnds_image image;
    const enum pbnds_status status = pbnds_image_read_rgb(path, &image, &error);
    assert_true((status == PBNDS_OK) == (image.data != NULL));
    assert_true(status == PBNDS_OK || strstr(error.message, path));
    pbnds_image_free(&image);
}

static void test_damaged_exr_collection(void **state)
{
    (void)state;
    const int count =
        for_each_file(PBNDS_SHARED_DATA "/malformed/openexr-damaged", check_broken);
    if (count == 0) skip();
    (void)for_each_file(PBNDS_SHARED_DATA "/malformed/tinyexr", check_broken);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_png_of_8_bits_and_less),
        cmocka_unit_test(test_png_of_16_bits),
        cmocka_unit_test(test_radiance),
        cmocka_unit_test_setup(test_webp, setup),
        cmocka_unit_test(test_what_is_no_picture),
        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test_setup(test_png_write_rounds, setup),
        cmocka_unit_test_setup(test_png_write_clamps, setup),
        cmocka_unit_test_setup(test_png_write_is_pure, setup),
        cmocka_unit_test_setup(test_png_write_fails_cleanly, setup),
        cmocka_unit_test_setup(test_picture_becomes_linear, setup),
        cmocka_unit_test_setup(test_light_map_is_tamed, setup),
        cmocka_unit_test_setup(test_light_map_channels, setup),
        cmocka_unit_test_setup(test_no_file, setup),
        cmocka_unit_test(test_shared_light_maps),
        cmocka_unit_test(test_png_suite),
        cmocka_unit_test(test_png_suite_interlaced),
        cmocka_unit_test(test_jpeg),
        cmocka_unit_test(test_damaged_exr_collection),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
