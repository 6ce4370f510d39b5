#include "engine/image/sheet.h"

#include <string.h>

#include "engine/image/font.h"
#include "tests/test.h"

static const float fill_value = 0.5f; /* neither the background nor the ink */

static struct pbnds_image picture(int width, int height)
{
    struct pbnds_image image;
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_image_init(&image, width, height, 3, &error), PBNDS_OK);
    for (int i = 0; i < width * height * 3; ++i)
        image.data[i] = fill_value;
    return image;
}

static int is_picture(const struct pbnds_image *sheet, int x, int y)
{
    return pbnds_image_at(sheet, x, y)[0] == fill_value;
}

static int is_ink(const struct pbnds_image *sheet, int x, int y)
{
    return pbnds_image_at(sheet, x, y)[1] > 0.8f;
}

struct box {
    int x0, y0, x1, y1, count;
};

/* Bounds of the ink (or of the pictures) within columns [x0, x1). */
static struct box bounds(const struct pbnds_image *sheet, int x0, int x1,
                         int (*inside)(const struct pbnds_image *, int, int))
{
    struct box b = {sheet->width, sheet->height, -1, -1, 0};
    for (int y = 0; y < sheet->height; ++y) {
        for (int x = x0; x < x1; ++x) {
            if (!inside(sheet, x, y)) continue;
            b.x0 = x < b.x0 ? x : b.x0;
            b.y0 = y < b.y0 ? y : b.y0;
            b.x1 = x > b.x1 ? x : b.x1;
            b.y1 = y > b.y1 ? y : b.y1;
            ++b.count;
        }
    }
    return b;
}

static struct pbnds_image make(const struct pbnds_sheet_cell *cells, int count,
                               int columns)
{
    struct pbnds_image sheet;
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_sheet_make(cells, count, columns, &sheet, &error), PBNDS_OK);
    assert_int_equal(sheet.channels, 3);
    return sheet;
}

static void test_font_covers_ascii(void **state)
{
    (void)state;
    const int count = PBNDS_FONT_LAST - PBNDS_FONT_FIRST + 1;
    assert_int_equal(count, 95);
    for (int i = 0; i < count; ++i) {
        int ink = 0;
        for (int r = 0; r < PBNDS_FONT_HEIGHT; ++r) {
            assert_true(pbnds_font[i][r] < 1 << PBNDS_FONT_WIDTH);
            ink += pbnds_font[i][r] != 0;
        }
        assert_true(i == 0 ? ink == 0 : ink > 0);
        for (int k = 0; k < i; ++k) { /* all tell apart */
            assert_true(memcmp(pbnds_font[i], pbnds_font[k], PBNDS_FONT_HEIGHT) != 0);
        }
    }
}

/* Nothing lost, nothing scaled: as many picture pixels as were put in. */
static void test_pictures_are_copied(void **state)
{
    (void)state;
    struct pbnds_image a = picture(20, 10), b = picture(7, 16), c = picture(3, 3);
    for (int i = 0; i < 9; ++i)
        c.data[3 * i] = 0.25f + 0.01f * (float)i;
    const struct pbnds_sheet_cell cells[] = {
        {&a, NULL}, {&b, NULL}, {NULL, NULL}, {&c, NULL}, {&a, NULL}};
    struct pbnds_image sheet = make(cells, 5, 3);
    assert_true(sheet.width >= 3 * 20 && sheet.height >= 2 * 16);
    int pixels = 0;
    for (int i = 0; i < sheet.width * sheet.height; ++i) {
        pixels += sheet.data[3 * i + 2] == fill_value;
    }
    assert_int_equal(pixels, 2 * 20 * 10 + 7 * 16 + 3 * 3);
    int found = 0;
    for (int y = 0; y + 2 < sheet.height; ++y) {
        for (int x = 0; x + 2 < sheet.width; ++x) {
            if (pbnds_image_at(&sheet, x, y)[0] != 0.25f) continue;
            ++found;
            for (int k = 0; k < 3; ++k) {
                assert_memory_equal(pbnds_image_at(&sheet, x, y + k),
                                    pbnds_image_at(&c, 0, k), 9 * sizeof(float));
            }
            assert_true(y >=
                        16); /* fourth of three columns: second row, first column */
            assert_true(x < sheet.width / 3);
        }
    }
    assert_int_equal(found, 1);
    pbnds_image_free(&sheet);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_image_free(&c);
}

static void test_label_is_under_its_picture(void **state)
{
    (void)state;
    struct pbnds_image a = picture(64, 20);
    const struct pbnds_sheet_cell cells[] = {{&a, "gpq|"}, {&a, NULL}};
    struct pbnds_image sheet = make(cells, 2, 2);
    const struct box p = bounds(&sheet, 0, sheet.width / 2, is_picture);
    const struct box t = bounds(&sheet, 0, sheet.width / 2, is_ink);
    assert_int_equal(p.count, 64 * 20);
    assert_true(t.count > 30);
    assert_true(t.y0 > p.y1);
    assert_true(t.x0 >= p.x0 && t.x1 <= p.x1);
    assert_true(t.y1 < sheet.height - 1);
    assert_int_equal(bounds(&sheet, sheet.width / 2, sheet.width, is_ink).count, 0);
    pbnds_image_free(&sheet);
    pbnds_image_free(&a);
}

/* The glyphs of a label, read back from the sheet. */
static void test_label_is_legible(void **state)
{
    (void)state;
    const char *text = "Ab9~";
    struct pbnds_image a = picture(64, 4);
    const struct pbnds_sheet_cell cell = {&a, text};
    struct pbnds_image sheet = make(&cell, 1, 1);
    const struct box p = bounds(&sheet, 0, sheet.width, is_picture);
    const struct box t = bounds(&sheet, 0, sheet.width, is_ink);
    for (int i = 0; text[i]; ++i) {
        for (int r = 0; r < PBNDS_FONT_HEIGHT; ++r) {
            for (int c = 0; c < PBNDS_FONT_WIDTH; ++c) {
                const int expected =
                    pbnds_font[text[i] - PBNDS_FONT_FIRST][r] >> (4 - c) & 1;
                assert_int_equal(is_ink(&sheet, p.x0 + 6 * i + c, t.y0 + r), expected);
            }
        }
    }
    pbnds_image_free(&sheet);
    pbnds_image_free(&a);
}

static void test_second_line_and_scale(void **state)
{
    (void)state;
    struct pbnds_image small = picture(100, 8), large = picture(300, 8);
    struct pbnds_sheet_cell cell = {&small, "H"};
    struct pbnds_image one = make(&cell, 1, 1);
    cell.label = "H\nH";
    struct pbnds_image two = make(&cell, 1, 1);
    cell.image = &large;
    struct pbnds_image big = make(&cell, 1, 1);
    const int ink = bounds(&one, 0, one.width, is_ink).count;
    assert_int_equal(ink, 17); /* an H of 5 x 7 */
    assert_int_equal(bounds(&two, 0, two.width, is_ink).count, 2 * ink);
    assert_true(two.height > one.height);
    assert_int_equal(bounds(&big, 0, big.width, is_ink).count, 4 * 2 * ink);
    pbnds_image_free(&one);
    pbnds_image_free(&two);
    pbnds_image_free(&big);
    pbnds_image_free(&small);
    pbnds_image_free(&large);
}

static void test_long_and_odd_labels_stay_in_their_cell(void **state)
{
    (void)state;
    struct pbnds_image a = picture(40, 10);
    char text[600];
    memset(text, 'M', sizeof text);
    text[sizeof text - 1] = 0;
    const struct pbnds_sheet_cell cells[] = {
        {&a, text}, {&a, ""}, {&a, "\xc3\xa9\t\x01\x7f"}, {&a, "\n\n\n"}};
    struct pbnds_image sheet = make(cells, 4, 2);
    const struct box left = bounds(&sheet, 0, sheet.width / 2, is_picture);
    const struct box right = bounds(&sheet, sheet.width / 2, sheet.width, is_ink);
    assert_int_equal(right.count, 0);
    assert_true(bounds(&sheet, 0, sheet.width / 2, is_ink).x1 <= left.x1);
    pbnds_image_free(&sheet);
    struct pbnds_image tiny = picture(1, 1);
    const struct pbnds_sheet_cell cell = {&tiny, "label"};
    sheet = make(&cell, 1, 9);
    pbnds_image_free(&sheet);
    pbnds_image_free(&tiny);
    pbnds_image_free(&a);
}

static void test_refuses(void **state)
{
    (void)state;
    struct pbnds_image a = picture(4, 4), grey, sheet;
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_image_init(&grey, 4, 4, 1, &error), PBNDS_OK);
    struct pbnds_sheet_cell cells[2] = {{&a, NULL}, {&grey, NULL}};
    assert_int_equal(pbnds_sheet_make(cells, 0, 1, &sheet, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_int_equal(pbnds_sheet_make(cells, 1, 0, &sheet, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_int_equal(pbnds_sheet_make(cells, 2, 2, &sheet, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_null(sheet.data);
    struct pbnds_image wide = {60000, 1, 3,
                               a.data}; /* two are wider than an image may be */
    cells[0].image = cells[1].image = &wide;
    assert_int_equal(pbnds_sheet_make(cells, 2, 2, &sheet, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_null(sheet.data);
    pbnds_image_free(&a);
    pbnds_image_free(&grey);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_font_covers_ascii),
        cmocka_unit_test(test_pictures_are_copied),
        cmocka_unit_test(test_label_is_under_its_picture),
        cmocka_unit_test(test_label_is_legible),
        cmocka_unit_test(test_second_line_and_scale),
        cmocka_unit_test(test_long_and_odd_labels_stay_in_their_cell),
        cmocka_unit_test(test_refuses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
