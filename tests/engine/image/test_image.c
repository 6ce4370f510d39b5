#include "engine/image/image.h"

#include "engine/core/rng.h"
#include "tests/test.h"

static struct pbnds_image noise(int width, int height, int channels)
{
    struct pbnds_image image;
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_image_init(&image, width, height, channels, &error),
                     PBNDS_OK);
    struct pbnds_rng r = pbnds_rng_make(1, (uint64_t)width, (uint64_t)height);
    for (int i = 0; i < width * height * channels; ++i) {
        image.data[i] = pbnds_rng_float(&r) * (i % 7 == 0 ? 1000.0f : 1.0f);
    }
    return image;
}

static double mean(const struct pbnds_image *image, int channel)
{
    double sum = 0.0;
    for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) {
            sum += (double)pbnds_image_at(image, x, y)[channel];
        }
    }
    return sum / ((double)image->width * image->height);
}

static void test_init(void **state)
{
    (void)state;
    struct pbnds_image image;
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_image_init(&image, 5, 3, 4, &error), PBNDS_OK);
    assert_int_equal(image.width, 5);
    assert_int_equal(image.height, 3);
    assert_int_equal(image.channels, 4);
    for (int i = 0; i < 60; ++i)
        assert_true(image.data[i] == 0.0f);
    assert_ptr_equal(pbnds_image_at(&image, 2, 1), image.data + (5 + 2) * 4);
    pbnds_image_free(&image);
    assert_null(image.data);
    assert_int_equal(image.width, 0);
    pbnds_image_free(&image); /* safe again */
}

static void test_init_refuses(void **state)
{
    (void)state;
    const int bad[][3] = {{0, 1, 1},     {1, 0, 1},     {1, 1, 0},  {-4, 4, 3},
                          {65536, 1, 1}, {1, 65536, 1}, {1, 1, 65}, {1, 1, -1}};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        struct pbnds_image image = {9, 9, 9, NULL};
        struct pbnds_error error = {""};
        assert_int_equal(
            pbnds_image_init(&image, bad[i][0], bad[i][1], bad[i][2], &error),
            PBNDS_ERROR_ARGUMENT);
        assert_null(image.data);
        assert_int_equal(image.width, 0);
        assert_true(error.message[0] != 0);
    }
    struct pbnds_image widest;
    assert_int_equal(pbnds_image_init(&widest, 65535, 1, 64, NULL), PBNDS_OK);
    pbnds_image_free(&widest);
}

/* Length of [a, a + 1) n / m inside [b, b + 1): share of source pixel b in target pixel
 * a of an axis resized from n to m pixels. */
static double overlap(int a, int b, int n, int m)
{
    const double scale = (double)n / m;
    const double left = fmax(a * scale, b), right = fmin((a + 1) * scale, b + 1.0);
    return right > left ? (right - left) / scale : 0.0;
}

/* Every target pixel over every source pixel. */
static double naive(const struct pbnds_image *src, int width, int height, int x, int y,
                    int c)
{
    double sum = 0.0;
    for (int v = 0; v < src->height; ++v) {
        for (int u = 0; u < src->width; ++u) {
            sum += overlap(x, u, src->width, width) *
                   overlap(y, v, src->height, height) *
                   (double)pbnds_image_at(src, u, v)[c];
        }
    }
    return sum;
}

static void test_resize_against_naive(void **state)
{
    (void)state;
    const int sizes[][4] = {{8, 6, 4, 3}, {8, 6, 3, 4}, {7, 5, 16, 11}, {1, 1, 5, 4},
                            {9, 4, 1, 1}, {6, 6, 6, 6}, {13, 3, 5, 3},  {5, 9, 5, 2}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; ++s) {
        struct pbnds_image src = noise(sizes[s][0], sizes[s][1], 3), dst;
        struct pbnds_error error = {""};
        const int w = sizes[s][2], h = sizes[s][3];
        assert_int_equal(pbnds_image_resize(&src, w, h, &dst, &error), PBNDS_OK);
        assert_int_equal(dst.width, w);
        assert_int_equal(dst.height, h);
        assert_int_equal(dst.channels, 3);
        for (int i = 0; i < w * h * 3; ++i) {
            const double expected = naive(&src, w, h, i / 3 % w, i / 3 / w, i % 3);
            assert_near((double)dst.data[i], expected, 1e-6 * (1.0 + fabs(expected)));
        }
        pbnds_image_free(&src);
        pbnds_image_free(&dst);
    }
}

/* A light map keeps its light at any size, the sun in one pixel too. */
static void test_resize_preserves_energy(void **state)
{
    (void)state;
    struct pbnds_image src = noise(101, 57, 2), dst;
    pbnds_image_at(&src, 77, 13)[0] = 1e6f;
    const int sizes[][2] = {{50, 28}, {33, 57}, {1, 1}, {202, 114}, {128, 64}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; ++s) {
        struct pbnds_error error = {""};
        assert_int_equal(
            pbnds_image_resize(&src, sizes[s][0], sizes[s][1], &dst, &error), PBNDS_OK);
        for (int c = 0; c < 2; ++c) {
            assert_near(mean(&dst, c) / mean(&src, c), 1.0, 1e-6);
        }
        pbnds_image_free(&dst);
    }
    pbnds_image_free(&src);
}

static void test_resize_keeps_constants_and_copies(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_image src, dst;
    assert_int_equal(pbnds_image_init(&src, 37, 23, 1, &error), PBNDS_OK);
    for (int i = 0; i < 37 * 23; ++i)
        src.data[i] = 0.7f;
    assert_int_equal(pbnds_image_resize(&src, 10, 31, &dst, &error), PBNDS_OK);
    for (int i = 0; i < 310; ++i)
        assert_near((double)dst.data[i], (double)0.7f, 1e-7);
    pbnds_image_free(&src);
    pbnds_image_free(&dst);
    src = noise(19, 11, 3);
    src.data[5] = INFINITY; /* touches its own pixel only */
    assert_int_equal(pbnds_image_resize(&src, 19, 11, &dst, &error), PBNDS_OK);
    assert_memory_equal(src.data, dst.data, 19 * 11 * 3 * sizeof(float));
    pbnds_image_free(&src);
    pbnds_image_free(&dst);
}

static void test_resize_refuses(void **state)
{
    (void)state;
    struct pbnds_error error = {""};
    struct pbnds_image src = noise(4, 4, 3), dst;
    assert_int_equal(pbnds_image_resize(&src, 0, 4, &dst, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_null(dst.data);
    assert_int_equal(pbnds_image_resize(&src, 4, 70000, &dst, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_null(dst.data);
    pbnds_image_free(&src);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_init),
        cmocka_unit_test(test_init_refuses),
        cmocka_unit_test(test_resize_against_naive),
        cmocka_unit_test(test_resize_preserves_energy),
        cmocka_unit_test(test_resize_keeps_constants_and_copies),
        cmocka_unit_test(test_resize_refuses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
