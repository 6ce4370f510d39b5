/* neural/metrics/metrics.c: known answers, mask semantics, bad input. */
#include "tests/test.h"

#include <string.h>

#include "engine/core/report.h"
#include "engine/core/rng.h"
#include "neural/metrics/metrics.h"

enum { W = 40, H = 30, N = W * H };

static struct pbnds_image noise(uint64_t seed)
{
    struct pbnds_image image;
    assert_int_equal(pbnds_image_init(&image, W, H, 3, NULL), PBNDS_OK);
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
    for (int i = 0; i < 3 * N; ++i)
        image.data[i] = pbnds_rng_float(&rng);
    return image;
}

static struct pbnds_metrics compare(const struct pbnds_image *a,
                                    const struct pbnds_image *b, const float *mask,
                                    struct pbnds_image *map)
{
    struct pbnds_metrics m;
    struct pbnds_error error = {""};
    if (pbnds_metrics_compare(a, b, a, b, mask, &m, map, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    return m;
}

static void a_known_difference_has_known_measures(void **state)
{
    (void)state;
    struct pbnds_image a = noise(1), b = noise(1), linear = noise(3), dim = noise(3);
    for (int i = 0; i < 3 * N; ++i) {
        a.data[i] = 0.5f;
        b.data[i] = i % 3 == 0 ? 0.75f : 0.5f; /* mse 0.0625 / 3 */
        linear.data[i] = 3.0f;
        dim.data[i] = i < 3 * N / 2 ? 1.0f : 2.0f;
    }
    struct pbnds_metrics m;
    struct pbnds_image map, direct;
    assert_int_equal(pbnds_metrics_compare(&a, &b, &linear, &dim, NULL, &m, &map, NULL),
                     PBNDS_OK);
    assert_near(m.mse, 0.0625 / 3.0, 1e-12);
    assert_near(m.psnr, 10.0 * log10(48.0), 1e-9);
    assert_near(m.relmse, 0.5 * (4.0 / 1.01 + 1.0 / 4.01), 1e-9);
    assert_near(m.ssim, pbnds_ssim(&a, &b, NULL), 0.0);
    assert_int_equal(pbnds_flip(&a, &b, &direct, NULL), PBNDS_OK);
    assert_memory_equal(map.data, direct.data, N * sizeof(float));
    double sum = 0.0;
    for (int i = 0; i < N; ++i)
        sum += (double)direct.data[i] / N;
    assert_near(m.flip, sum, 1e-9);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_image_free(&linear);
    pbnds_image_free(&dim);
    pbnds_image_free(&map);
    pbnds_image_free(&direct);
}

static void equal_images_are_perfect(void **state)
{
    (void)state;
    struct pbnds_image a = noise(1);
    const struct pbnds_metrics m = compare(&a, &a, NULL, NULL);
    assert_near(m.mse, 0.0, 0.0);
    assert_true(isinf(m.psnr) && m.psnr > 0.0);
    assert_near(m.ssim, 1.0, 1e-12);
    assert_near(m.flip, 0.0, 0.0);
    assert_near(m.relmse, 0.0, 0.0);
    pbnds_image_free(&a);
}

/* What is masked out may hold anything and changes nothing; what is left is averaged
   over its own number, on images whose other pixels are black. */
static void the_mask_excludes(void **state)
{
    (void)state;
    struct pbnds_image a = noise(1), b = noise(2), map, black_a = noise(1),
                       black_b = noise(2);
    struct pbnds_image expected;
    float mask[N];
    int counted = 0;
    double square = 0.0;
    for (int i = 0; i < N; ++i) {
        const int keep = i % W > 12 && i / W < 20;
        mask[i] = keep ? 0.3f : i % 2 ? 0.0f : -1.0f;
        counted += keep;
        for (int c = 3 * i; c < 3 * i + 3; ++c) {
            const double d = (double)a.data[c] - (double)b.data[c];
            if (keep) square += d * d;
            if (!keep) black_a.data[c] = black_b.data[c] = 0.0f;
            if (!keep) a.data[c] = c % 2 ? NAN : INFINITY;
            if (!keep) b.data[c] = -5.0f;
        }
    }
    const struct pbnds_metrics m = compare(&a, &b, mask, &map);
    assert_near(m.mse, square / (3.0 * counted), 1e-12);
    assert_near(m.ssim, pbnds_ssim(&black_a, &black_b, mask), 0.0);
    assert_int_equal(pbnds_flip(&black_a, &black_b, &expected, NULL), PBNDS_OK);
    double sum = 0.0;
    for (int i = 0; i < N; ++i) {
        const float e = mask[i] > 0.0f ? expected.data[i] : 0.0f;
        assert_near((double)map.data[i], (double)e, 0.0);
        sum += (double)e;
    }
    assert_near(m.flip, sum / counted, 1e-9);
    /* a mask of ones is no mask */
    for (int i = 0; i < N; ++i)
        mask[i] = 1.0f;
    const struct pbnds_metrics full = compare(&black_a, &black_b, mask, NULL);
    const struct pbnds_metrics none = compare(&black_a, &black_b, NULL, NULL);
    assert_memory_equal(&full, &none, sizeof full);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_image_free(&map);
    pbnds_image_free(&black_a);
    pbnds_image_free(&black_b);
    pbnds_image_free(&expected);
}

static void bad_input_is_refused(void **state)
{
    (void)state;
    struct pbnds_image a = noise(1), b = noise(2), small, grey, empty = {0}, map;
    struct pbnds_metrics m = {0};
    struct pbnds_error error;
    float mask[N] = {0};
    assert_int_equal(pbnds_image_init(&small, W, H - 1, 3, NULL), PBNDS_OK);
    assert_int_equal(pbnds_image_init(&grey, W, H, 1, NULL), PBNDS_OK);
    const struct pbnds_image *bad[] = {&small, &grey, &empty, NULL};
    for (int k = 0; k < 4; ++k)
        for (int at = 0; at < 4; ++at) {
            const struct pbnds_image *in[4] = {&a, &b, &a, &b};
            in[at] = bad[k];
            if (at == 0 && k < 2) in[1] = in[2] = in[3] = &a;
            assert_int_equal(pbnds_metrics_compare(in[0], in[1], in[2], in[3], NULL, &m,
                                                   &map, &error),
                             PBNDS_ERROR_ARGUMENT);
            assert_null(map.data);
        }
    assert_int_equal(pbnds_metrics_compare(&a, &b, &a, &b, mask, &m, &map, &error),
                     PBNDS_ERROR_FORMAT);
    for (int at = 0; at < 4; ++at) {
        struct pbnds_image broken = noise(3);
        const struct pbnds_image *in[4] = {&a, &b, &a, &b};
        in[at] = &broken;
        broken.data[3 * (W * 7 + 5) + 1] = at % 2 ? NAN : -INFINITY;
        assert_int_equal(
            pbnds_metrics_compare(in[0], in[1], in[2], in[3], NULL, &m, &map, &error),
            PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, "pixel 5, 7"));
        pbnds_image_free(&broken);
    }
    assert_near(m.mse + m.flip, 0.0, 0.0); /* left alone on failure */
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_image_free(&small);
    pbnds_image_free(&grey);
}

/* The flag cannot be lowered again, so this runs last. */
static void a_stop_is_reported_not_hidden(void **state)
{
    (void)state;
    struct pbnds_image a = noise(1), b = noise(2), map;
    struct pbnds_metrics m;
    pbnds_request_stop();
    assert_int_equal(pbnds_metrics_compare(&a, &b, &a, &b, NULL, &m, &map, NULL),
                     PBNDS_ERROR_INTERRUPTED);
    assert_null(map.data);
    assert_int_equal(pbnds_flip(&a, &b, &map, NULL), PBNDS_ERROR_INTERRUPTED);
    assert_null(map.data);
    assert_true(isnan(pbnds_ssim(&a, &b, NULL)));
    pbnds_image_free(&a);
    pbnds_image_free(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_known_difference_has_known_measures),
        cmocka_unit_test(equal_images_are_perfect),
        cmocka_unit_test(the_mask_excludes),
        cmocka_unit_test(bad_input_is_refused),
        cmocka_unit_test(a_stop_is_reported_not_hidden),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
