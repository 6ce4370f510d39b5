/* neural/metrics/colormap.c: ordered, even, in gamut, and safe with any value. */
#include "tests/test.h"

#include "neural/metrics/metrics.h"

enum { N = 1001 };

static double linear(float s)
{
    return s <= 0.04045f ? (double)s / 12.92 : pow(((double)s + 0.055) / 1.055, 2.4);
}

static double root(double t)
{
    return t > 0.008856451679 ? cbrt(t) : 7.787037037 * t + 4.0 / 29.0;
}

static void lab_of(const float *rgb, double lab[3])
{
    const double r = linear(rgb[0]), g = linear(rgb[1]), b = linear(rgb[2]);
    const double x = root((0.4123866 * r + 0.3575915 * g + 0.1804505 * b) / 0.9504285);
    const double y = root(0.2126368 * r + 0.7151830 * g + 0.0721802 * b);
    const double z = root((0.0193306 * r + 0.1191972 * g + 0.9503726 * b) / 1.0889004);
    lab[0] = 116.0 * y - 16.0;
    lab[1] = 500.0 * (x - y);
    lab[2] = 200.0 * (y - z);
}

static struct pbnds_image ramp(void)
{
    struct pbnds_image map, image;
    assert_int_equal(pbnds_image_init(&map, N, 1, 1, NULL), PBNDS_OK);
    for (int i = 0; i < N; ++i)
        map.data[i] = (float)i / (N - 1);
    assert_int_equal(pbnds_colorize(&map, &image, NULL), PBNDS_OK);
    assert_int_equal(image.channels, 3);
    pbnds_image_free(&map);
    return image;
}

static void goes_from_black_to_cream(void **state)
{
    (void)state;
    struct pbnds_image image = ramp();
    const float *end = pbnds_image_at(&image, N - 1, 0);
    for (int c = 0; c < 3; ++c)
        assert_near((double)image.data[c], 0.0, 1e-6);
    assert_true(end[0] > 0.95f && end[1] > 0.9f && end[2] > 0.6f && end[2] < end[1]);
    pbnds_image_free(&image);
}

/* Equal steps of the value: lightness rises at each, and the colour difference is the
   same. A colour outside sRGB would be clipped and break the second. */
static void is_ordered_and_even(void **state)
{
    (void)state;
    struct pbnds_image image = ramp();
    double before[3], lab[3], shortest = 1e9, longest = 0.0;
    enum { STEP = 20 };
    lab_of(image.data, before);
    for (int i = STEP; i < N; i += STEP) {
        lab_of(pbnds_image_at(&image, i, 0), lab);
        assert_true(lab[0] > before[0] + 0.5);
        const double d = sqrt(pow(lab[0] - before[0], 2) + pow(lab[1] - before[1], 2) +
                              pow(lab[2] - before[2], 2));
        shortest = fmin(shortest, d);
        longest = fmax(longest, d);
        for (int c = 0; c < 3; ++c)
            before[c] = lab[c];
    }
    assert_true(longest < 1.05 * shortest);
    pbnds_image_free(&image);
}

static void any_value_has_a_colour(void **state)
{
    (void)state;
    static const float values[] = {NAN, -INFINITY, -1.0f, INFINITY, 2.0f, 1.0f};
    struct pbnds_image map, image, full = ramp();
    assert_int_equal(pbnds_image_init(&map, 6, 1, 1, NULL), PBNDS_OK);
    for (int i = 0; i < 6; ++i)
        map.data[i] = values[i];
    assert_int_equal(pbnds_colorize(&map, &image, NULL), PBNDS_OK);
    for (int i = 0; i < 6; ++i)
        assert_memory_equal(pbnds_image_at(&image, i, 0),
                            pbnds_image_at(&full, i < 3 ? 0 : N - 1, 0), 12);
    pbnds_image_free(&image);
    assert_int_equal(pbnds_colorize(&full, &image, NULL), PBNDS_ERROR_ARGUMENT);
    assert_null(image.data);
    pbnds_image_free(&map);
    pbnds_image_free(&full);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(goes_from_black_to_cream),
        cmocka_unit_test(is_ordered_and_even),
        cmocka_unit_test(any_value_has_a_colour),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
