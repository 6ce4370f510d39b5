/* The size of an image file from its header: known answers, limits, and files that claim
 * more pixels than so many bytes can hold. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/image/oiio.h"
#include "engine/image/size.h"
#include "tests/test.h"

static struct pbnds_error fault;

/** A header and zeros behind it. */
static enum pbnds_status measure(const void *head, size_t head_size, size_t size,
                                 const struct pbnds_image_limits *limits,
                                 struct pbnds_image_size *out)
{
    uint8_t *file = calloc(size > head_size ? size : head_size, 1);
    memcpy(file, head, head_size);
    const enum pbnds_status status = pbnds_image_measure(
        file, size > head_size ? size : head_size, "bomb", limits, out, &fault);
    free(file);
    if (status != PBNDS_OK) assert_non_null(strstr(fault.message, "bomb"));
    return status;
}

static size_t png(uint8_t *p, uint32_t width, uint32_t height, int depth, int colour)
{
    memcpy(p, "\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR", 16);
    for (int i = 0; i < 4; ++i) {
        p[16 + i] = (uint8_t)(width >> (24 - 8 * i));
        p[20 + i] = (uint8_t)(height >> (24 - 8 * i));
    }
    memcpy(p + 24, (const uint8_t[]){(uint8_t)depth, (uint8_t)colour, 0, 0, 0}, 5);
    return 29;
}

static size_t jpeg(uint8_t *p, int frame, int width, int height)
{
    const uint8_t head[] = {0xff, 0xd8, 0xff,           0xe0, 0,  4, 0,
                            0,    0xff, (uint8_t)frame, 0,    11, 8};
    memcpy(p, head, sizeof head);
    p[13] = (uint8_t)(height >> 8);
    p[14] = (uint8_t)height;
    p[15] = (uint8_t)(width >> 8);
    p[16] = (uint8_t)width;
    p[17] = 1;
    return 21;
}

static size_t attribute(uint8_t *p, const char *name, const char *type,
                        const void *value, uint32_t size)
{
    size_t n = strlen(name) + 1;
    memcpy(p, name, n);
    memcpy(p + n, type, strlen(type) + 1);
    n += strlen(type) + 1;
    for (int i = 0; i < 4; ++i)
        p[n + (size_t)i] = (uint8_t)(size >> (8 * i));
    memcpy(p + n + 4, value, size);
    return n + 4 + size;
}

/** tile 0: scan lines, compressed as `compression`. */
static size_t exr(uint8_t *p, int32_t x, int32_t y, int32_t width, int32_t height,
                  uint32_t tile, uint8_t compression)
{
    memcpy(p, "\x76\x2f\x31\x01\x02\0\0\0", 8);
    const int32_t box[4] = {x, y, (int32_t)((int64_t)x + width - 1),
                            (int32_t)((int64_t)y + height - 1)};
    uint8_t tiles[9] = {0};
    memcpy(tiles, &tile, 4);
    memcpy(tiles + 4, &tile, 4);
    size_t n = 8;
    n += attribute(p + n, "compression", "compression", &compression, 1);
    n += attribute(p + n, "dataWindow", "box2i", box, 16);
    if (tile) n += attribute(p + n, "tiles", "tiledesc", tiles, 9);
    p[n] = 0;
    return n + 1;
}

static void sizes_are_read(void **state)
{
    (void)state;
    uint8_t p[300];
    struct pbnds_image_size s;
    assert_int_equal(measure(p, png(p, 300, 20, 8, 6), 200, NULL, &s), PBNDS_OK);
    assert_true(s.width == 300 && s.height == 20 && s.bytes == 300 * 20 * 4);
    assert_int_equal(measure(p, png(p, 300, 20, 16, 2), 200, NULL, &s), PBNDS_OK);
    assert_true(s.bytes == 300 * 20 * 16);
    assert_int_equal(measure(p, jpeg(p, 0xc0, 640, 480), 2000, NULL, &s), PBNDS_OK);
    assert_true(s.width == 640 && s.height == 480 && s.bytes == 640 * 480 * 4);
    assert_int_equal(measure(p, exr(p, -5, 7, 33, 44, 0, 0), 2000, NULL, &s), PBNDS_OK);
    assert_true(s.width == 33 && s.height == 44 && s.bytes == 33 * 44 * 16);
    static const char hdr[] = "#?RADIANCE\nX=1\n\n-Y 50 +X 60\n";
    assert_int_equal(measure(hdr, sizeof hdr - 1, 400, NULL, &s), PBNDS_OK);
    assert_true(s.width == 60 && s.height == 50);
    static const char turned[] = "#?RGBE\n\n+X 60 -Y 50\n";
    assert_int_equal(measure(turned, sizeof turned - 1, 400, NULL, &s), PBNDS_OK);
    assert_true(s.width == 60 && s.height == 50);
    /* 16383 x 2, of the lossless kind: fourteen bits each. */
    static const uint8_t webp[] =
        "RIFF\0\0\0\0WEBPVP8L\0\0\0\0\x2f\xfe\x7f\0\0\0\0\0\0";
    assert_int_equal(measure(webp, 30, 30, NULL, &s), PBNDS_OK);
    assert_true(s.width == 16383 && s.height == 2);
    assert_int_equal(measure("GIF89a", 6, 50, NULL, &s), PBNDS_ERROR_UNSUPPORTED);
    assert_int_equal(pbnds_image_measure(p, 0, "bomb", NULL, &s, &fault),
                     PBNDS_ERROR_FORMAT);
}

/* A few bytes that claim many pixels: nothing is allocated for them. */
static void bombs_are_cut_short(void **state)
{
    (void)state;
    uint8_t p[300];
    struct pbnds_image_size s;
    assert_int_equal(measure(p, png(p, 16384, 16384, 8, 6), 1000000, NULL, &s),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(measure(p, png(p, 16384, 16384, 8, 6), 1 << 21, NULL, &s),
                     PBNDS_OK);
    assert_int_equal(measure(p, jpeg(p, 0xc2, 16384, 16384), 1 << 18, NULL, &s),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(measure(p, jpeg(p, 0xc2, 16384, 16384), 1 << 19, NULL, &s),
                     PBNDS_OK);
    /* Arithmetic codes have no least length. */
    assert_int_equal(measure(p, jpeg(p, 0xc9, 16384, 16384), 100, NULL, &s), PBNDS_OK);
    /* 4 x 4 tiles are four million blocks. */
    assert_int_equal(measure(p, exr(p, 0, 0, 8192, 8192, 4, 3), 1 << 20, NULL, &s),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(measure(p, exr(p, 0, 0, 8192, 8192, 512, 3), 1 << 20, NULL, &s),
                     PBNDS_OK);
    assert_int_equal(measure(p, exr(p, 0, 0, 4096, 16384, 0, 0), 100000, NULL, &s),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(measure(p, exr(p, 0, 0, 4096, 16384, 0, 9), 2000, NULL, &s),
                     PBNDS_OK);
    static const char hdr[] = "#?RADIANCE\n\n-Y 10000 +X 10\n";
    assert_int_equal(measure(hdr, sizeof hdr - 1, 39999, NULL, &s), PBNDS_ERROR_FORMAT);
    assert_int_equal(measure(hdr, sizeof hdr - 1, 40000, NULL, &s), PBNDS_OK);
    assert_non_null(strstr(fault.message, "too few"));
}

static void limits_are_held(void **state)
{
    (void)state;
    uint8_t p[300];
    struct pbnds_image_size s;
    const size_t n = png(p, 20000, 10, 8, 0);
    assert_int_equal(measure(p, n, 9000, NULL, &s), PBNDS_ERROR_MEMORY);
    assert_non_null(strstr(fault.message, "--max-image-side"));
    const struct pbnds_image_limits wide = {.side = 20000};
    assert_int_equal(measure(p, n, 9000, &wide, &s), PBNDS_OK);
    const struct pbnds_image_limits small = {.side = 20000, .bytes = 799999};
    assert_int_equal(measure(p, n, 9000, &small, &s), PBNDS_ERROR_MEMORY);
    assert_non_null(strstr(fault.message, "--max-images"));
    const struct pbnds_image_limits enough = {.side = 20000, .bytes = 800000};
    assert_int_equal(measure(p, n, 9000, &enough, &s), PBNDS_OK);
    /* No product of these fits 64 bits, no difference fits 32. */
    assert_int_equal(measure(p, png(p, 0x7fffffff, 0x7fffffff, 16, 6), 0, NULL, &s),
                     PBNDS_ERROR_MEMORY);
    assert_int_equal(measure(p, png(p, 0x80000000u, 1, 8, 6), 0, NULL, &s),
                     PBNDS_ERROR_FORMAT);
    const int32_t box[4] = {INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX};
    const size_t head = exr(p, 0, 0, 1, 1, 1, 0);
    for (size_t i = 0; i + 16 < head; ++i) {
        if (memcmp(p + i, "box2i", 6) == 0) memcpy(p + i + 10, box, 16);
    }
    assert_int_equal(measure(p, head, 0, NULL, &s), PBNDS_ERROR_MEMORY);
    assert_int_equal(measure(p, exr(p, 5, 5, 0, 9, 0, 0), 0, NULL, &s),
                     PBNDS_ERROR_FORMAT);
}

/* Cut anywhere, a header gives an answer or a sentence, and reads no byte beyond. */
static void every_cut_is_survived(void **state)
{
    (void)state;
    uint8_t p[300];
    struct pbnds_image_size s;
    for (int kind = 0; kind < 4; ++kind) {
        memset(p, 0, sizeof p);
        size_t n = 0;
        if (kind == 0) n = png(p, 3, 3, 8, 2);
        if (kind == 1) n = jpeg(p, 0xc0, 3, 3);
        if (kind == 2) n = exr(p, 0, 0, 3, 3, 2, 3);
        if (kind == 3) n = (size_t)sprintf((char *)p, "#?RADIANCE\n\n-Y 3 +X 3\n");
        int fine = 0;
        for (size_t cut = 1; cut <= n; ++cut) {
            uint8_t *exact = malloc(cut);
            memcpy(exact, p, cut);
            fine +=
                pbnds_image_measure(exact, cut, "cut", NULL, &s, &fault) == PBNDS_OK;
            free(exact);
        }
        assert_true(fine <= 10);
    }
}

/* What is measured is what decoding gives. */
static void measured_is_what_is_decoded(void **state)
{
    (void)state;
    static const char *const names[] = {"s8.png",    "s16.png",    "s.jpg",
                                        "s.webp",    "rgb.exr",    "tiled.exr",
                                        "small.hdr", "one_bit.png"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char path[600];
        uint8_t *bytes = NULL;
        size_t size = 0;
        (void)snprintf(path, sizeof path, "%s/tests/fuzz/corpus/image/%s",
                       PBNDS_SOURCE_DIR, names[i]);
        assert_int_equal(pbnds_file_read(path, 1 << 20, &bytes, &size, &fault),
                         PBNDS_OK);
        struct pbnds_image_size s;
        struct pbnds_pixels pixels;
        assert_int_equal(pbnds_image_measure(bytes, size, path, NULL, &s, &fault),
                         PBNDS_OK);
        assert_int_equal(pbnds_pixels_decode(bytes, size, path, &pixels, &fault),
                         PBNDS_OK);
        assert_int_equal(s.width, pixels.width);
        assert_int_equal(s.height, pixels.height);
        assert_int_equal(s.bytes,
                         (uint64_t)(s.width * s.height) * (pixels.f32 ? 16u : 4u));
        pbnds_pixels_free(&pixels);
        const struct pbnds_image_limits less = {.bytes = s.bytes - 1};
        assert_int_equal(
            pbnds_pixels_decode_within(bytes, size, path, &less, &pixels, &fault),
            PBNDS_ERROR_MEMORY);
        free(bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_are_read),
        cmocka_unit_test(bombs_are_cut_short),
        cmocka_unit_test(limits_are_held),
        cmocka_unit_test(every_cut_is_survived),
        cmocka_unit_test(measured_is_what_is_decoded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
