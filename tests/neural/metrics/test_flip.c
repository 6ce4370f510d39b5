/* neural/metrics/flip.c against its naive twin and against what FLIP must satisfy. */
#include "tests/test.h"

#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
#include "neural/metrics/metrics.h"
#include "tests/reference/flip_naive.h"

static struct pbnds_image constant(int width, int height, float r, float g, float b)
{
    struct pbnds_image image;
    assert_int_equal(pbnds_image_init(&image, width, height, 3, NULL), PBNDS_OK);
    for (int i = 0; i < width * height; ++i) {
        image.data[3 * i] = r;
        image.data[3 * i + 1] = g;
        image.data[3 * i + 2] = b;
    }
    return image;
}

/* Gradients, hard edges, saturated patches and noise. */
static struct pbnds_image picture(int width, int height, uint64_t seed, float noise)
{
    struct pbnds_image image = constant(width, height, 0.0f, 0.0f, 0.0f);
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float *p = pbnds_image_at(&image, x, y);
            p[0] = (float)x / (float)width;
            p[1] = (float)y / (float)height;
            p[2] = (x / 9 + y / 7) % 3 == 0 ? 1.0f : 0.2f;
            if (x > 2 * y) p[0] = 1.0f - p[0];
            for (int c = 0; c < 3; ++c) {
                p[c] += noise * (pbnds_rng_float(&rng) - 0.5f);
                p[c] = p[c] < 0.0f ? 0.0f : p[c] > 1.0f ? 1.0f : p[c];
            }
        }
    return image;
}

static struct pbnds_image flip_of(const struct pbnds_image *a,
                                  const struct pbnds_image *b)
{
    struct pbnds_image map;
    struct pbnds_error error = {""};
    if (pbnds_flip(a, b, &map, &error) != PBNDS_OK) fail_msg("%s", error.message);
    assert_int_equal(map.channels, 1);
    assert_int_equal(map.width, a->width);
    assert_int_equal(map.height, a->height);
    return map;
}

static double mean(const struct pbnds_image *map)
{
    double sum = 0.0;
    for (int i = 0; i < map->width * map->height; ++i) {
        assert_true(map->data[i] >= 0.0f && map->data[i] <= 1.0f);
        sum += (double)map->data[i];
    }
    return sum / (map->width * map->height);
}

static double constant_flip(const float a[3], const float b[3])
{
    struct pbnds_image x = constant(24, 24, a[0], a[1], a[2]);
    struct pbnds_image y = constant(24, 24, b[0], b[1], b[2]);
    struct pbnds_image map = flip_of(&x, &y);
    const double value = mean(&map);
    pbnds_image_free(&x);
    pbnds_image_free(&y);
    pbnds_image_free(&map);
    return value;
}

static void agrees_with_the_naive_twin(void **state)
{
    (void)state;
    static const int sizes[][2] = {{61, 43}, {1, 1}, {3, 40}, {33, 2}};
    static double expected[61 * 43];
    for (int k = 0; k < 4; ++k)
        for (uint64_t seed = 1; seed < 3; ++seed) {
            const int w = sizes[k][0], h = sizes[k][1];
            struct pbnds_image a = picture(w, h, seed, 0.05f);
            struct pbnds_image b = picture(w, h, seed + 10, seed == 1 ? 0.1f : 1.5f);
            struct pbnds_image map = flip_of(&a, &b);
            flip_naive(a.data, b.data, w, h, expected);
            for (int i = 0; i < w * h; ++i)
                assert_near((double)map.data[i], expected[i], 2e-4);
            double sum = 0.0;
            for (int i = 0; i < w * h; ++i)
                sum += expected[i] / (w * h);
            assert_near(mean(&map), sum, 2e-5);
            pbnds_image_free(&map);
            pbnds_image_free(&b);
            pbnds_image_free(&a);
        }
}

static void equal_images_have_no_error(void **state)
{
    (void)state;
    struct pbnds_image a = picture(70, 50, 1, 1.0f);
    struct pbnds_image map = flip_of(&a, &a);
    assert_near(mean(&map), 0.0, 0.0);
    pbnds_image_free(&map);
    pbnds_image_free(&a);
}

/* Of constants only the colour term is left, and that has closed forms. */
static void constants_have_their_closed_forms(void **state)
{
    (void)state;
    static const float black[3] = {0, 0, 0}, white[3] = {1, 1, 1},
                       grey[3] = {.5f, .5f, .5f};
    static const float green[3] = {0, 1, 0}, blue[3] = {0, 0, 1},
                       nearly[3] = {.51f, .5f, .5f};
    assert_near(constant_flip(green, blue), 1.0, 1e-5);
    assert_near(constant_flip(blue, green), 1.0, 1e-5);
    /* black against white: HyAB = 100, and c_max = HyAB(green, blue)^0.7 by hand:
       L*a*b* green 87.735 -86.183 83.180, blue 32.297 79.188 -107.860, a and b times
       L/100 */
    const double green_a = -86.183 * 0.87735, green_b = 83.180 * 0.87735;
    const double blue_a = 79.188 * 0.32297, blue_b = -107.860 * 0.32297;
    const double hyab = 87.735 - 32.297 + hypot(green_a - blue_a, green_b - blue_b);
    const double cmax = pow(hyab, 0.7), d = pow(100.0, 0.7);
    const double expected = 0.95 + (d - 0.4 * cmax) / (0.6 * cmax) * 0.05;
    assert_true(d > 0.4 * cmax);
    assert_near(constant_flip(black, white), expected, 1e-4);
    /* grey 0.5 is L* 53.389: below the knee of 0.4 c_max, on the steep part */
    const double half = pow(53.389, 0.7);
    assert_near(constant_flip(black, grey),
                half < 0.4 * cmax ? 0.95 * half / (0.4 * cmax)
                                  : 0.95 + (half - 0.4 * cmax) / (0.6 * cmax) * 0.05,
                1e-4);
    assert_true(constant_flip(grey, nearly) < 0.1);
    assert_true(constant_flip(grey, nearly) > 0.0);
}

static void is_symmetric(void **state)
{
    (void)state;
    struct pbnds_image a = picture(64, 40, 1, 0.2f), b = picture(64, 40, 2, 0.8f);
    struct pbnds_image ab = flip_of(&a, &b), ba = flip_of(&b, &a);
    assert_memory_equal(ab.data, ba.data, 64 * 40 * sizeof(float));
    pbnds_image_free(&ab);
    pbnds_image_free(&ba);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
}

/* Turned images give the turned map: no filter favours an axis or a side. */
static void turns_with_the_images(void **state)
{
    (void)state;
    enum { N = 40 };
    struct pbnds_image a = picture(N, N, 1, 0.2f), b = picture(N, N, 2, 0.8f);
    struct pbnds_image c = constant(N, N, 0, 0, 0), d = constant(N, N, 0, 0, 0);
    for (int y = 0; y < N; ++y)
        for (int x = 0; x < N; ++x) { /* transposed, then mirrored */
            memcpy(pbnds_image_at(&c, N - 1 - y, x), pbnds_image_at(&a, x, y), 12);
            memcpy(pbnds_image_at(&d, N - 1 - y, x), pbnds_image_at(&b, x, y), 12);
        }
    struct pbnds_image ab = flip_of(&a, &b), cd = flip_of(&c, &d);
    for (int y = 0; y < N; ++y)
        for (int x = 0; x < N; ++x)
            assert_near((double)*pbnds_image_at(&ab, x, y),
                        (double)*pbnds_image_at(&cd, N - 1 - y, x), 1e-4);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_image_free(&c);
    pbnds_image_free(&d);
    pbnds_image_free(&ab);
    pbnds_image_free(&cd);
}

/* A pattern too fine for the eye costs less than the same difference spread out. */
static void fine_patterns_are_seen_less(void **state)
{
    (void)state;
    struct pbnds_image flat = constant(64, 64, 0.5f, 0.5f, 0.5f);
    struct pbnds_image fine = constant(64, 64, 0.5f, 0.5f, 0.5f);
    struct pbnds_image coarse = constant(64, 64, 0.5f, 0.5f, 0.5f);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c) {
                pbnds_image_at(&fine, x, y)[c] += (x + y) % 2 ? 0.05f : -0.05f;
                pbnds_image_at(&coarse, x, y)[c] +=
                    (x / 16 + y / 16) % 2 ? 0.05f : -0.05f;
            }
    struct pbnds_image a = flip_of(&fine, &flat), b = flip_of(&coarse, &flat);
    assert_true(mean(&a) < 0.5 * mean(&b));
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_image_free(&flat);
    pbnds_image_free(&fine);
    pbnds_image_free(&coarse);
}

static void threads_do_not_change_a_bit(void **state)
{
    (void)state;
    struct pbnds_image a = picture(90, 70, 1, 0.2f), b = picture(90, 70, 2, 0.8f);
    pbnds_set_threads(1);
    struct pbnds_image one = flip_of(&a, &b);
    pbnds_set_threads(3);
    struct pbnds_image three = flip_of(&a, &b);
    pbnds_set_threads(0);
    assert_memory_equal(one.data, three.data, 90 * 70 * sizeof(float));
    pbnds_image_free(&one);
    pbnds_image_free(&three);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
}

static void bad_images_are_refused(void **state)
{
    (void)state;
    struct pbnds_error error;
    struct pbnds_image a = constant(8, 8, 0, 0, 0), b = constant(8, 7, 0, 0, 0), map;
    struct pbnds_image none = {0}, grey;
    assert_int_equal(pbnds_image_init(&grey, 8, 8, 1, NULL), PBNDS_OK);
    assert_int_equal(pbnds_flip(&a, &b, &map, &error), PBNDS_ERROR_ARGUMENT);
    assert_int_equal(pbnds_flip(&a, &none, &map, &error), PBNDS_ERROR_ARGUMENT);
    assert_int_equal(pbnds_flip(&a, &grey, &map, &error), PBNDS_ERROR_ARGUMENT);
    assert_null(map.data);
    pbnds_image_free(&b);
    b = constant(8, 8, 0, 0, 0);
    b.data[100] = NAN;
    assert_int_equal(pbnds_flip(&a, &b, &map, &error), PBNDS_ERROR_FORMAT);
    assert_null(map.data);
    assert_true(strlen(error.message) > 0);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_image_free(&grey);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_the_naive_twin),
        cmocka_unit_test(equal_images_have_no_error),
        cmocka_unit_test(constants_have_their_closed_forms),
        cmocka_unit_test(is_symmetric),
        cmocka_unit_test(turns_with_the_images),
        cmocka_unit_test(fine_patterns_are_seen_less),
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(bad_images_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
