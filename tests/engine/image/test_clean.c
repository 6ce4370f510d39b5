#include "engine/image/clean.h"

#include <stdlib.h>
#include <string.h>

#include "tests/engine/image/png_fixture.h"
#include "tests/test.h"

typedef enum pbnds_status (*cleaner)(const uint8_t *, size_t, const char *, uint8_t **,
                                     size_t *, struct pbnds_error *);

/* Cleans an exact copy, so that a sanitizer sees every read beyond its end. */
static enum pbnds_status run(cleaner clean, const struct bytes *in, struct bytes *out)
{
    struct pbnds_error error = {""};
    uint8_t *copy = malloc(in->size ? in->size : 1), *result;
    size_t size;
    assert_non_null(copy);
    memcpy(copy, in->data, in->size);
    const enum pbnds_status status =
        clean(copy, in->size, "picture", &result, &size, &error);
    free(copy);
    out->size = 0;
    if (status == PBNDS_OK) {
        put(out, result, size);
    } else {
        assert_null(result);
        assert_int_equal(size, 0);
        assert_non_null(strstr(error.message, "picture"));
    }
    free(result);
    return status;
}

static void assert_same(const struct bytes *a, const struct bytes *b)
{
    assert_int_equal(a->size, b->size);
    assert_memory_equal(a->data, b->data, a->size);
}

static struct bytes in, out, expected;

/* ---- PNG ---- */

static const uint8_t grey[4] = {0, 85, 170, 255};

static void begin_png(struct bytes *b, unsigned depth, unsigned colour)
{
    put_signature(b);
    put_header(b, 2, 2, depth, colour);
}

static void end_png(struct bytes *b)
{
    put_pixels(b, grey, 2, 2);
    put_end(b);
}

static void test_png_keeps_what_makes_the_picture(void **state)
{
    (void)state;
    begin_png(&expected, 8, 3);
    put_chunk(&expected, "PLTE", "abcdef", 6);
    put_chunk(&expected, "tRNS", "\x80", 1);
    put_pixels(&expected, grey, 1, 2);
    put_pixels(&expected, grey, 1, 2);
    put_end(&expected);
    begin_png(&in, 8, 3);
    put_chunk(&in, "iCCP", "a bad profile", 13);
    put_chunk(&in, "gAMA", "\0\0\0\1", 4);
    put_chunk(&in, "PLTE", "abcdef", 6);
    put_chunk(&in, "tRNS", "\x80", 1);
    put_chunk(&in, "tEXt", "k\0v", 3);
    put_pixels(&in, grey, 1, 2);
    put_pixels(&in, grey, 1, 2);
    put_chunk(&in, "eXIf", "x", 1);
    put_end(&in);
    put(&in, "something behind", 16);
    assert_int_equal(run(pbnds_clean_png, &in, &out), PBNDS_OK);
    assert_same(&out, &expected);
    assert_int_equal(run(pbnds_clean_png, &out, &in), PBNDS_OK); /* again: no change */
    assert_same(&in, &expected);
}

static void test_png_drops_what_has_no_meaning(void **state)
{
    (void)state;
    begin_png(&expected, 8, 0);
    end_png(&expected);
    begin_png(&in, 8, 0);
    put_chunk(&in, "PLTE", "abc", 3);    /* greys have no palette */
    put_chunk(&in, "tRNS", "\0\1\2", 3); /* and two bytes of transparency */
    end_png(&in);
    assert_int_equal(run(pbnds_clean_png, &in, &out), PBNDS_OK);
    assert_same(&out, &expected);
}

static void test_png_structure(void **state)
{
    (void)state;
    for (int i = 0; i < 12; ++i) {
        put_signature(&in);
        if (i != 0) put_header(&in, i == 1 ? 0 : 2, 2, i == 2 ? 3 : 8, i == 3 ? 5 : 3);
        if (i == 4) put_header(&in, 2, 2, 8, 3);
        if (i == 5) put_chunk(&in, "PLTE", "abcd", 4);
        if (i != 6) put_chunk(&in, "PLTE", "abc", 3);
        if (i == 7) put_chunk(&in, "PLTE", "abc", 3);
        if (i != 8) put_pixels(&in, grey, 2, 2);
        if (i == 9) put_chunk(&in, "tIME", "1234567", 7);
        if (i == 9) put_pixels(&in, grey, 2, 2);
        if (i == 10) in.data[40] ^= 1; /* checksum of the palette */
        put_end(&in);
        assert_int_equal(run(pbnds_clean_png, &in, &out),
                         i < 11 ? PBNDS_ERROR_FORMAT : PBNDS_OK);
    }
}

static void test_png_too_large_or_too_new(void **state)
{
    (void)state;
    put_signature(&in);
    put_header(&in, 2000000, 2, 8, 0);
    end_png(&in);
    assert_int_equal(run(pbnds_clean_png, &in, &out), PBNDS_ERROR_MEMORY);
    begin_png(&in, 8, 0);
    put_chunk(&in, "CgBI", "", 0);
    end_png(&in);
    assert_int_equal(run(pbnds_clean_png, &in, &out), PBNDS_ERROR_UNSUPPORTED);
}

static void test_png_depths(void **state)
{
    (void)state;
    /* Table 11.1 of the specification: allowed depths of each colour type. */
    static const unsigned allowed[8] = {0x10116, 0, 0x10100, 0x116,
                                        0x10100, 0, 0x10100, 0};
    for (unsigned colour = 0; colour < 8; ++colour) {
        for (unsigned depth = 0; depth <= 17; ++depth) {
            begin_png(&in, depth, colour);
            if (colour == 3) put_chunk(&in, "PLTE", "abc", 3);
            end_png(&in);
            assert_int_equal(run(pbnds_clean_png, &in, &out),
                             allowed[colour] >> depth & 1u ? PBNDS_OK
                                                           : PBNDS_ERROR_FORMAT);
        }
    }
}

static void test_png_truncated_and_flipped(void **state)
{
    (void)state;
    begin_png(&expected, 8, 0);
    end_png(&expected);
    for (size_t n = 0; n < expected.size; ++n) {
        in = expected;
        in.size = n;
        assert_int_equal(run(pbnds_clean_png, &in, &out), PBNDS_ERROR_FORMAT);
        in = expected;
        in.data[n] ^= 0x40; /* CRC and signature leave no byte unchecked */
        assert_int_not_equal(run(pbnds_clean_png, &in, &out), PBNDS_OK);
    }
}

/* ---- JPEG ---- */

static void put_segment(struct bytes *b, unsigned marker, const void *data, size_t size)
{
    put_u8(b, 0xff);
    put_u8(b, marker);
    put_u8(b, (size + 2) >> 8 & 255u);
    put_u8(b, (size + 2) & 255u);
    put(b, data, size);
}

static void put_scan(struct bytes *b)
{
    put_segment(b, 0xda, "\1\1\0\0\x3f\0", 6);
    put(b, "coded\xff\0data\xff\xd0more\xff\xd7\xff\0", 19);
}

static const char frame[] = "\x8\0\2\0\3\1\1\x11"; /* 3 x 2 pixels, grey */

static void put_jpeg(struct bytes *b)
{
    b->size = 0;
    put(b, "\xff\xd8", 2);
    put_segment(b, 0xe0, "JFIF\0\1\1\0\0\1\0\1\0\0", 14);
    put_segment(b, 0xdb, "table", 5);
    put_segment(b, 0xee, "Adobe\0\x64\0\0\0\0\1", 12);
    put_segment(b, 0xc2, frame, 8);
    put_segment(b, 0xc4, "codes", 5);
    put_scan(b);
    put_segment(b, 0xc4, "other codes", 11);
    put_scan(b);
    put(b, "\xff\xd9", 2);
}

static void test_jpeg_keeps_what_makes_the_picture(void **state)
{
    (void)state;
    put_jpeg(&expected);
    in.size = 0;
    put(&in, "\xff\xd8", 2);
    put_segment(&in, 0xe0, "JFIF\0\1\1\0\0\1\0\1\0\0", 14);
    put_segment(&in, 0xe0, "JFXX\0 thumbnail \xff\xd9", 18);
    put_segment(&in, 0xe1, "Exif\0\0\xff\xda\xff\xd9", 10);
    put_segment(&in, 0xe2, "ICC_PROFILE", 11);
    put_segment(&in, 0xed,
                "Photoshop 3.0\0"
                "8BIM\4\4",
                20);
    put_segment(&in, 0xee, "not Adobe", 9);
    put_segment(&in, 0xfe, "a comment", 9);
    put_segment(&in, 0xdb, "table", 5);
    put(&in, "\xff\xff\xff", 3); /* fill bytes before a marker */
    put_segment(&in, 0xee, "Adobe\0\x64\0\0\0\0\1", 12);
    put_segment(&in, 0xc2, frame, 8);
    put_segment(&in, 0xc4, "codes", 5);
    put_scan(&in);
    put_segment(&in, 0xc4, "other codes", 11);
    put_segment(&in, 0xfe, "in between", 10);
    put_scan(&in);
    put(&in, "\xff\xd9 a second picture \xff\xd8", 21);
    assert_int_equal(run(pbnds_clean_jpeg, &in, &out), PBNDS_OK);
    assert_same(&out, &expected);
}

static void test_jpeg_truncated(void **state)
{
    (void)state;
    put_jpeg(&expected);
    for (size_t n = 0; n < expected.size; ++n) {
        in = expected;
        in.size = n;
        assert_int_equal(run(pbnds_clean_jpeg, &in, &out), PBNDS_ERROR_FORMAT);
    }
}

static void test_jpeg_structure(void **state)
{
    (void)state;
    for (int i = 0; i < 8; ++i) {
        in.size = 0;
        put(&in, "\xff\xd8", 2);
        if (i == 0) put(&in, "\xff\xd8", 2);     /* begins twice */
        if (i == 1) put(&in, "\xff\xdb\0\1", 4); /* a length below 2 */
        if (i == 2) put(&in, "stray", 5);
        if (i == 3) put_segment(&in, 0xc0, "\x8\0\0\0\3\1\1\x11", 8); /* 3 x 0 */
        if (i == 4) put_segment(&in, 0xc0, "\x8\0\2\0\0\1\1\x11", 8); /* 0 x 2 */
        if (i == 5) put_segment(&in, 0xc0, "\x8\0\2", 3);
        if (i < 3 || i == 7) put_segment(&in, 0xc0, frame, 8);
        put_scan(&in); /* without a frame in case 6 */
        put(&in, "\xff\xd9", 2);
        assert_int_equal(run(pbnds_clean_jpeg, &in, &out),
                         i < 7 ? PBNDS_ERROR_FORMAT : PBNDS_OK);
    }
    in.size = 0;
    put(&in, "\xff\xd8\xff\xd9", 4); /* nothing in it */
    assert_int_equal(run(pbnds_clean_jpeg, &in, &out), PBNDS_ERROR_FORMAT);
}

/* ---- WebP ---- */

static void put_riff(struct bytes *b, const char *tag, const void *data, size_t size)
{
    put(b, tag, 4);
    for (unsigned k = 0; k < 4; ++k)
        put_u8(b, size >> 8 * k & 255u);
    put(b, data, size);
    if (size & 1u) put_u8(b, 0);
}

static void begin_webp(struct bytes *b)
{
    b->size = 0;
    put(b, "RIFF\0\0\0\0WEBP", 12);
}

static void end_webp(struct bytes *b)
{
    for (unsigned k = 0; k < 4; ++k)
        b->data[4 + k] = (uint8_t)((b->size - 8) >> 8 * k);
}

static void test_webp_keeps_what_makes_the_picture(void **state)
{
    (void)state;
    begin_webp(&expected);
    put_riff(&expected, "VP8X", "\x10\0\0\0\1\0\0\1\0\0", 10);
    put_riff(&expected, "ALPH", "alpha", 5);
    put_riff(&expected, "VP8 ", "image", 5);
    end_webp(&expected);
    begin_webp(&in);
    put_riff(&in, "VP8X", "\x3c\0\0\0\1\0\0\1\0\0", 10); /* profile, alpha, Exif, XMP */
    put_riff(&in, "ICCP", "profile", 7);
    put_riff(&in, "ALPH", "alpha", 5);
    put_riff(&in, "VP8 ", "image", 5);
    put_riff(&in, "EXIF", "exif", 4);
    put_riff(&in, "XMP ", "xmp", 3);
    end_webp(&in);
    put(&in, "behind", 6);
    assert_int_equal(run(pbnds_clean_webp, &in, &out), PBNDS_OK);
    assert_same(&out, &expected);
}

static void test_webp_structure(void **state)
{
    (void)state;
    for (int i = 0; i < 6; ++i) {
        begin_webp(&in);
        if (i == 0) put_riff(&in, "VP8X", "\0\0\0\0", 4);
        if (i == 1) put_riff(&in, "VP8X", "\2\0\0\0\0\0\0\0\0\0", 10);
        if (i == 2) put_riff(&in, "ANMF", "frame", 5);
        if (i != 3) put_riff(&in, "VP8L", "image", 5);
        if (i == 4) put_riff(&in, "VP8L", "image", 5);
        end_webp(&in);
        const enum pbnds_status expect = i == 1 || i == 2 ? PBNDS_ERROR_UNSUPPORTED
                                         : i == 5         ? PBNDS_OK
                                                          : PBNDS_ERROR_FORMAT;
        assert_int_equal(run(pbnds_clean_webp, &in, &out), expect);
    }
    expected = in; /* the sound one */
    for (size_t n = 0; n < expected.size; ++n) {
        in = expected;
        in.size = n;
        assert_int_equal(run(pbnds_clean_webp, &in, &out), PBNDS_ERROR_FORMAT);
    }
    in = expected;
    memset(in.data + 16, 0xff, 4); /* a chunk of 4 GiB */
    assert_int_equal(run(pbnds_clean_webp, &in, &out), PBNDS_ERROR_FORMAT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_png_keeps_what_makes_the_picture),
        cmocka_unit_test(test_png_drops_what_has_no_meaning),
        cmocka_unit_test(test_png_structure),
        cmocka_unit_test(test_png_too_large_or_too_new),
        cmocka_unit_test(test_png_depths),
        cmocka_unit_test(test_png_truncated_and_flipped),
        cmocka_unit_test(test_jpeg_keeps_what_makes_the_picture),
        cmocka_unit_test(test_jpeg_truncated),
        cmocka_unit_test(test_jpeg_structure),
        cmocka_unit_test(test_webp_keeps_what_makes_the_picture),
        cmocka_unit_test(test_webp_structure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
