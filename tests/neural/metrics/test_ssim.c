/* neural/metrics/ssim.c against a two-dimensional twin in double precision and known
 * answers. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
#include "neural/metrics/metrics.h"

static struct pbnds_image noise(int width, int height, int channels, uint64_t seed)
{
    struct pbnds_image image;
    assert_int_equal(pbnds_image_init(&image, width, height, channels, NULL), PBNDS_OK);
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
    for (int i = 0; i < width * height * channels; ++i) {
        const float trend = (float)(i % (width * channels)) / (float)(width * channels);
        image.data[i] = 0.5f * trend + 0.5f * pbnds_rng_float(&rng);
    }
    return image;
}

/* Half-sample symmetric, by walking. */
static int reflected(int i, int n)
{
    while (i < 0 || i >= n)
        i = i < 0 ? -1 - i : 2 * n - 1 - i;
    return i;
}

static double pixel(const struct pbnds_image *image, const float *mask, int x, int y,
                    int c)
{
    if (mask && !(mask[y * image->width + x] > 0.0f)) return 0.0;
    return (double)pbnds_image_at(image, x, y)[c];
}

/* Central moments, window by window: mean first, then deviations from it. */
static double naive_at(const struct pbnds_image *a, const struct pbnds_image *b,
                       const float *mask, int x, int y, int c)
{
    double total = 0.0, mean_a = 0.0, mean_b = 0.0, var_a = 0.0, var_b = 0.0, cov = 0.0;
    for (int pass = 0; pass < 2; ++pass)
        for (int j = -5; j <= 5; ++j)
            for (int i = -5; i <= 5; ++i) {
                const double g = exp(-(i * i + j * j) / (2.0 * 1.5 * 1.5));
                const int u = reflected(x + i, a->width),
                          v = reflected(y + j, a->height);
                const double p = pixel(a, mask, u, v, c), q = pixel(b, mask, u, v, c);
                if (pass == 0) {
                    total += g;
                    mean_a += g * p;
                    mean_b += g * q;
                } else {
                    var_a += g / total * (p - mean_a / total) * (p - mean_a / total);
                    var_b += g / total * (q - mean_b / total) * (q - mean_b / total);
                    cov += g / total * (p - mean_a / total) * (q - mean_b / total);
                }
            }
    mean_a /= total;
    mean_b /= total;
    return (2.0 * mean_a * mean_b + 1e-4) * (2.0 * cov + 9e-4) /
           ((mean_a * mean_a + mean_b * mean_b + 1e-4) * (var_a + var_b + 9e-4));
}

static double naive_ssim(const struct pbnds_image *a, const struct pbnds_image *b,
                         const float *mask)
{
    double sum = 0.0;
    int counted = 0;
    for (int y = 0; y < a->height; ++y)
        for (int x = 0; x < a->width; ++x) {
            if (mask && !(mask[y * a->width + x] > 0.0f)) continue;
            for (int c = 0; c < a->channels; ++c)
                sum += naive_at(a, b, mask, x, y, c);
            counted += a->channels;
        }
    return sum / counted;
}

static void agrees_with_the_naive_twin(void **state)
{
    (void)state;
    static const int sizes[][3] = {{40, 31, 3}, {1, 1, 3}, {3, 20, 3}, {17, 2, 1}};
    for (int k = 0; k < 4; ++k) {
        const int w = sizes[k][0], h = sizes[k][1], n = sizes[k][2];
        struct pbnds_image a = noise(w, h, n, 1), b = noise(w, h, n, 2);
        for (int i = 0; i < w * h * n; ++i)
            b.data[i] = 0.7f * a.data[i] + 0.3f * b.data[i];
        const double expected = naive_ssim(&a, &b, NULL);
        assert_near(pbnds_ssim(&a, &b, NULL), expected, 1e-9);
        float *mask = malloc((size_t)(w * h) * sizeof *mask);
        assert_non_null(mask);
        for (int i = 0; i < w * h; ++i)
            mask[i] = i % 5 == 1 ? -1.0f : i % w < w / 3 ? 0.0f : 0.1f;
        assert_near(pbnds_ssim(&a, &b, mask), naive_ssim(&a, &b, mask), 1e-9);
        free(mask);
        pbnds_image_free(&a);
        pbnds_image_free(&b);
    }
}

static void has_its_closed_forms(void **state)
{
    (void)state;
    struct pbnds_image a = noise(30, 20, 3, 1), b = noise(30, 20, 3, 2);
    assert_near(pbnds_ssim(&a, &a, NULL), 1.0, 1e-12);
    for (int i = 0; i < 30 * 20 * 3; ++i) {
        a.data[i] = 0.25f;
        b.data[i] = 0.5f;
    }
    /* no structure: the luminance term alone */
    assert_near(pbnds_ssim(&a, &b, NULL), (0.25 + 1e-4) / (0.3125 + 1e-4), 1e-9);
    assert_near(pbnds_ssim(&b, &a, NULL), pbnds_ssim(&a, &b, NULL), 0.0);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
}

static void masked_pixels_do_not_matter(void **state)
{
    (void)state;
    struct pbnds_image a = noise(30, 20, 3, 1), b = noise(30, 20, 3, 2);
    float mask[30 * 20];
    for (int i = 0; i < 30 * 20; ++i)
        mask[i] = i % 30 > 10 ? 1.0f : 0.0f;
    const double before = pbnds_ssim(&a, &b, mask);
    for (int i = 0; i < 30 * 20; ++i)
        if (mask[i] <= 0.0f) a.data[3 * i] = i % 2 ? NAN : 1e30f;
    assert_near(pbnds_ssim(&a, &b, mask), before, 0.0);
    memset(mask, 0, sizeof mask);
    assert_true(isnan(pbnds_ssim(&a, &b, mask))); /* a mean of nothing */
    pbnds_image_free(&a);
    pbnds_image_free(&b);
}

static void threads_do_not_change_a_bit(void **state)
{
    (void)state;
    struct pbnds_image a = noise(90, 70, 3, 1), b = noise(90, 70, 3, 2);
    pbnds_set_threads(1);
    const double one = pbnds_ssim(&a, &b, NULL);
    pbnds_set_threads(3);
    assert_near(pbnds_ssim(&a, &b, NULL), one, 0.0);
    pbnds_set_threads(0);
    pbnds_image_free(&b);
    b = noise(90, 69, 3, 2);
    assert_true(isnan(pbnds_ssim(&a, &b, NULL)));
    pbnds_image_free(&a);
    pbnds_image_free(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_the_naive_twin),
        cmocka_unit_test(has_its_closed_forms),
        cmocka_unit_test(masked_pixels_do_not_matter),
        cmocka_unit_test(threads_do_not_change_a_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
