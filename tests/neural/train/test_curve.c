/* The loss curve: rows, what a kill left, and the plot. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/image/oiio.h"
#include "neural/train/curve.h"
#include "neural/train/curve_plot.h"

static const char *const CSV = "test_curve.csv", *const PNG = "test_curve.png";

static void start(int rows)
{
    assert_int_equal(pbnds_curve_start(CSV, 0, 0, NULL), PBNDS_OK);
    for (int i = 1; i <= rows; ++i) {
        const struct pbnds_curve_row row = {.step = (uint64_t)i * 100,
                                            .seconds = i,
                                            .lr = 1e-3 / i,
                                            .loss = 4.0 / i,
                                            .train_psnr = 20.0,
                                            .val_loss = 6.0 / i,
                                            .val_psnr = 21.5};
        assert_int_equal(pbnds_curve_append(CSV, &row, NULL), PBNDS_OK);
    }
}

static void append_text(const char *text)
{
    FILE *file = fopen(CSV, "ab");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static void rows_come_back(void **state)
{
    (void)state;
    start(5);
    append_text("600,1.0,0.1"); /* cut short by a kill */
    struct pbnds_curve_row *rows;
    int count;
    assert_int_equal(pbnds_curve_read(CSV, &rows, &count, NULL), PBNDS_OK);
    assert_int_equal(count, 5);
    assert_int_equal(rows[4].step, 500);
    assert_near(rows[3].loss, 1.0, 1e-5);
    assert_near(rows[1].val_loss, 3.0, 1e-5);
    assert_near(rows[1].val_psnr, 21.5, 1e-9);
    free(rows);
    /* resumed from step 300: the later rows are written again */
    assert_int_equal(pbnds_curve_start(CSV, 300, 1, NULL), PBNDS_OK);
    assert_int_equal(pbnds_curve_read(CSV, &rows, &count, NULL), PBNDS_OK);
    assert_int_equal(count, 3);
    free(rows);
    (void)unlink(CSV);
    assert_int_equal(pbnds_curve_read(CSV, &rows, &count, NULL), PBNDS_ERROR_IO);
}

static struct pbnds_pixels plot(void)
{
    uint8_t *bytes;
    size_t size;
    struct pbnds_pixels pixels;
    assert_int_equal(pbnds_curve_plot(CSV, PNG, NULL), PBNDS_OK);
    assert_int_equal(pbnds_file_read(PNG, 1u << 26, &bytes, &size, NULL), PBNDS_OK);
    assert_int_equal(pbnds_pixels_decode(bytes, size, PNG, &pixels, NULL), PBNDS_OK);
    free(bytes);
    return pixels;
}

/* Height of the first pixel from the top of column x that is reddish (validation) or bluish
 * (training); -1: none. Below the heading. */
static int find(const struct pbnds_pixels *pixels, int x, bool red)
{
    for (int y = 50; y < pixels->height; ++y) {
        const uint8_t *p = pixels->u8 + 4 * (y * pixels->width + x);
        if (red ? p[0] > p[2] + 60 : p[2] > p[0] + 60) return y;
    }
    return -1;
}

/* Both curves go like 1 / step, one 1.5 times the other: on a logarithmic axis they are the
 * same distance apart everywhere, and fall less and less. */
static void losses_are_on_a_logarithmic_axis(void **state)
{
    (void)state;
    start(40);
    struct pbnds_pixels pixels = plot();
    const int xs[] = {200, 400, 800};
    int val[3], train[3];
    for (int k = 0; k < 3; ++k) {
        val[k] = find(&pixels, xs[k], true);
        train[k] = find(&pixels, xs[k], false);
        assert_true(val[k] > 0 && train[k] > val[k]);
    }
    assert_near(train[1] - val[1], train[0] - val[0], 3.0);
    assert_near(train[2] - val[2], train[0] - val[0], 3.0);
    /* from step s to 2 s by ln 2, of 1.5 by ln 1.5; the axes begin at x = 96 */
    const double x0 = 96.0, expected = log((800.0 - x0) / (400.0 - x0)) / log(1.5);
    assert_near((val[2] - val[1]) / (double)(train[1] - val[1]), expected, 0.15);
    pbnds_pixels_free(&pixels);
    (void)unlink(CSV);
    (void)unlink(PNG);
}

static void odd_curves_are_plotted(void **state)
{
    (void)state;
    for (int rows = 0; rows <= 1; ++rows) {
        start(rows);
        struct pbnds_pixels pixels = plot();
        pbnds_pixels_free(&pixels);
    }
    static const char *const ROWS[] = {"200,1,1,nan,0,inf,0\n", "300,1,1,0,0,-1,0\n",
                                       "400,1,1,1e-300,0,1e300,0\n",
                                       "18446744073709551615,1,1,1,1,1,1\n"};
    for (size_t i = 0; i < sizeof ROWS / sizeof ROWS[0]; ++i) {
        append_text(ROWS[i]);
        struct pbnds_pixels pixels = plot();
        pbnds_pixels_free(&pixels);
    }
    (void)unlink(PNG);
    assert_int_equal(pbnds_curve_plot(CSV, "no/such/folder.png", NULL), PBNDS_ERROR_IO);
    (void)unlink(CSV);
    assert_int_equal(pbnds_curve_plot(CSV, PNG, NULL), PBNDS_ERROR_IO);
    assert_int_not_equal(access(PNG, F_OK), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_come_back),
        cmocka_unit_test(losses_are_on_a_logarithmic_axis),
        cmocka_unit_test(odd_curves_are_plotted),
    };
    return cmocka_run_group_tests_name("neural/train/curve", tests, NULL, NULL);
}
