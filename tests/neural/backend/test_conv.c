/* oneDNN against its naive twin for every kind of convolution, and the twin against the
 * definition: derivatives by central differences, and sums done by hand. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
#include "neural/backend/backend.h"
#include "neural/backend/conv.h"
#include "neural/backend/dtype.h"

/** Everything one convolution reads and writes. */
struct problem {
    struct pbnds_conv c;
    size_t xs, ys, ws;
    void *x, *y, *dy, *dx;
    float *w, *b, *dw, *db;
};

static void fill(float *p, size_t count, uint64_t seed)
{
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
    for (size_t i = 0; i < count; ++i)
        p[i] = 2.0f * pbnds_rng_float(&rng) - 1.0f;
}

static void fill_typed(enum pbnds_dtype dtype, void *p, size_t count, uint64_t seed)
{
    float *f = malloc(count * sizeof *f);
    fill(f, count, seed);
    if (dtype == PBNDS_F32) memcpy(p, f, count * sizeof *f);
    for (size_t i = 0; dtype == PBNDS_BF16 && i < count; ++i) {
        ((uint16_t *)p)[i] = pbnds_f32_to_bf16(f[i]);
    }
    free(f);
}

static double get(enum pbnds_dtype dtype, const void *p, size_t i)
{
    return (double)(dtype == PBNDS_BF16 ? pbnds_bf16_to_f32(((const uint16_t *)p)[i])
                                        : ((const float *)p)[i]);
}

static struct problem make(const struct pbnds_conv *c)
{
    struct problem p = {.c = *c};
    const size_t oh = (size_t)pbnds_conv_out_h(c), ow = (size_t)pbnds_conv_out_w(c);
    p.xs = (size_t)c->n * (size_t)c->h * (size_t)c->w * (size_t)c->in;
    p.ys = (size_t)c->n * oh * ow * (size_t)c->out;
    p.ws = pbnds_conv_weight_count(c);
    p.x = malloc(p.xs * 4);
    p.dx = malloc(p.xs * 4);
    p.y = malloc(p.ys * 4);
    p.dy = malloc(p.ys * 4);
    p.w = malloc(p.ws * 4);
    p.dw = malloc(p.ws * 4);
    p.b = malloc((size_t)c->out * 4);
    p.db = malloc((size_t)c->out * 4);
    fill_typed(c->dtype, p.x, p.xs, 1);
    fill_typed(c->dtype, p.dy, p.ys, 2);
    fill(p.w, p.ws, 3);
    fill(p.b, (size_t)c->out, 4);
    fill(p.dw, p.ws, 5); /* gradients are added to what is there */
    fill(p.db, (size_t)c->out, 6);
    return p;
}

static void clear(struct problem *p)
{
    free(p->x);
    free(p->dx);
    free(p->y);
    free(p->dy);
    free(p->w);
    free(p->dw);
    free(p->b);
    free(p->db);
}

static void run_all(struct pbnds_backend *b, struct problem *p)
{
    struct pbnds_error error = {""};
    if (b->ops->conv_forward(b, &p->c, p->x, p->w, p->b, p->y, &error) ||
        b->ops->conv_backward_data(b, &p->c, p->dy, p->w, p->dx, &error) ||
        b->ops->conv_backward_weights(b, &p->c, p->x, p->dy, p->dw, p->db, &error)) {
        fail_msg("%s", error.message);
    }
}

/** Largest difference, as a part of the root mean square of the expected values. */
static double difference(enum pbnds_dtype dtype, const void *a, const void *b,
                         size_t count)
{
    double worst = 0.0, square = 0.0;
    for (size_t i = 0; i < count; ++i) {
        const double d = fabs(get(dtype, a, i) - get(dtype, b, i));
        if (!(d <= worst)) worst = d;
        square += get(dtype, b, i) * get(dtype, b, i);
    }
    return worst / sqrt(square / (double)count + 1e-30);
}

static struct pbnds_backend *onednn(void)
{
    struct pbnds_error error;
    struct pbnds_backend *b;
    if (pbnds_backend_create_onednn(&b, &error)) fail_msg("%s", error.message);
    return b;
}

static struct pbnds_backend *reference(void)
{
    struct pbnds_error error;
    struct pbnds_backend *b;
    if (pbnds_backend_create_reference(&b, &error)) fail_msg("%s", error.message);
    return b;
}

static bool runs_bf16(struct pbnds_backend *b)
{
    const struct pbnds_conv c = {1, 4, 4, 16, 16, 3, 1, false, false, PBNDS_BF16};
    struct problem p = make(&c);
    struct pbnds_error error;
    const enum pbnds_status s = b->ops->conv_forward(b, &c, p.x, p.w, p.b, p.y, &error);
    clear(&p);
    return s == PBNDS_OK;
}

static const struct {
    int kernel, stride;
    bool transposed;
} shapes[] = {{1, 1, false}, {3, 1, false}, {2, 2, false}, {3, 2, false}, {2, 2, true}};
static const int channels[][2] = {{1, 1},   {3, 5},   {16, 3},  {4, 17},
                                  {32, 32}, {33, 20}, {64, 16}, {32, 64}};

static void compare(struct pbnds_backend *dnn, struct pbnds_backend *ref,
                    const struct pbnds_conv *c)
{
    struct problem a = make(c), b = make(c);
    run_all(dnn, &a);
    run_all(ref, &b);
    /* bf16 rounds weights too: 2^-9 each, and the result; the sums are float32. */
    const double tolerance = c->dtype == PBNDS_BF16 ? 0.04 : 2e-5;
    const double y = difference(c->dtype, a.y, b.y, a.ys);
    const double dx = difference(c->dtype, a.dx, b.dx, a.xs);
    const double dw = difference(PBNDS_F32, a.dw, b.dw, a.ws);
    const double db = difference(PBNDS_F32, a.db, b.db, (size_t)c->out);
    if (!(y < tolerance && dx < tolerance && dw < 2e-4 && db < 2e-4)) {
        fail_msg("%d to %d, kernel %d stride %d%s%s %s: y %g dx %g dw %g db %g", c->in,
                 c->out, c->kernel, c->stride, c->transposed ? " transposed" : "",
                 c->relu ? " relu" : "", c->dtype == PBNDS_BF16 ? "bf16" : "f32", y, dx,
                 dw, db);
    }
    clear(&a);
    clear(&b);
}

static void compare_all(enum pbnds_dtype dtype)
{
    struct pbnds_backend *dnn = onednn(), *ref = reference();
    if (dtype == PBNDS_BF16 && !runs_bf16(dnn)) {
        pbnds_backend_free(dnn);
        pbnds_backend_free(ref);
        skip();
    }
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; ++s) {
        for (size_t k = 0; k < sizeof channels / sizeof *channels; ++k) {
            for (int relu = 0; relu < 2; ++relu) {
                const struct pbnds_conv c = {2,
                                             6,
                                             10,
                                             channels[k][0],
                                             channels[k][1],
                                             shapes[s].kernel,
                                             shapes[s].stride,
                                             shapes[s].transposed,
                                             relu == 1,
                                             dtype};
                compare(dnn, ref, &c);
                dnn->ops->weights_changed(dnn);
            }
        }
    }
    pbnds_backend_free(dnn);
    pbnds_backend_free(ref);
}

static void test_f32_equals_the_twin(void **state)
{
    (void)state;
    compare_all(PBNDS_F32);
}

static void test_bf16_equals_the_twin(void **state)
{
    (void)state;
    compare_all(PBNDS_BF16);
}

/** L = sum_k dy_k y_k, so dL/dx and dL/dw are what backward returns for dy. y is linear
 * in x, w and b, so a large step has no truncation error. */
static double loss(struct pbnds_backend *b, struct problem *p)
{
    struct pbnds_error error;
    if (b->ops->conv_forward(b, &p->c, p->x, p->w, p->b, p->y, &error)) {
        fail_msg("%s", error.message);
    }
    double sum = 0.0;
    for (size_t i = 0; i < p->ys; ++i) {
        sum += (double)((float *)p->y)[i] * (double)((float *)p->dy)[i];
    }
    return sum;
}

static double central(struct pbnds_backend *b, struct problem *p, float *at)
{
    const float old = *at;
    *at = old + 0.5f;
    const double up = loss(b, p);
    *at = old - 0.5f;
    const double down = loss(b, p);
    *at = old;
    return up - down;
}

static void test_twin_has_the_derivatives_of_its_forward(void **state)
{
    (void)state;
    struct pbnds_backend *b = reference();
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; ++s) {
        const struct pbnds_conv c = {2,
                                     4,
                                     6,
                                     3,
                                     2,
                                     shapes[s].kernel,
                                     shapes[s].stride,
                                     shapes[s].transposed,
                                     false,
                                     PBNDS_F32};
        struct problem p = make(&c);
        memset(p.dw, 0, p.ws * 4);
        memset(p.db, 0, 2 * 4);
        run_all(b, &p);
        for (size_t i = 0; i < p.xs; i += 5) {
            assert_near(((float *)p.dx)[i], central(b, &p, (float *)p.x + i), 2e-5);
        }
        for (size_t i = 0; i < p.ws; ++i) {
            assert_near(p.dw[i], central(b, &p, p.w + i), 1e-4);
        }
        for (size_t i = 0; i < 2; ++i) {
            assert_near(p.db[i], central(b, &p, p.b + i), 1e-4);
        }
        clear(&p);
    }
    pbnds_backend_free(b);
}

/** Sums small enough for paper, on a 4x4 image of 1, 2, ... 16 with one channel. */
static void test_known_answers(void **state)
{
    (void)state;
    struct pbnds_backend *both[] = {onednn(), reference()};
    float x[16], w[9] = {1, 10, 100, 1000, 0, 0, 0, 0, 0}, bias = 0.5f, y[64];
    for (int i = 0; i < 16; ++i)
        x[i] = (float)(i + 1);
    for (int k = 0; k < 2; ++k) {
        struct pbnds_backend *b = both[k];
        struct pbnds_error error = {""};
        struct pbnds_conv c = {1, 4, 4, 1, 1, 3, 1, false, false, PBNDS_F32};
        assert_int_equal(b->ops->conv_forward(b, &c, x, w, &bias, y, &error), PBNDS_OK);
        assert_near(y[0], 0.5, 0); /* only padding above and to the left */
        assert_near(y[5], 1 + 20 + 300 + 5000 + 0.5, 0);
        c.stride = 2; /* centres 0 and 2, padding above and to the left only */
        assert_int_equal(b->ops->conv_forward(b, &c, x, w, &bias, y, &error), PBNDS_OK);
        assert_near(y[0], 0.5, 0);
        assert_near(y[3], 6 + 70 + 800 + 10000 + 0.5, 0);
        c.kernel = 2;
        b->ops->weights_changed(b);
        assert_int_equal(b->ops->conv_forward(b, &c, x, w, &bias, y, &error), PBNDS_OK);
        assert_near(y[0], 1 + 20 + 500 + 6000 + 0.5, 0);
        assert_near(y[3], 11 + 120 + 1500 + 16000 + 0.5, 0);
        c.transposed = true;
        b->ops->weights_changed(b);
        assert_int_equal(b->ops->conv_forward(b, &c, x, w, &bias, y, &error), PBNDS_OK);
        assert_near(y[2], 2 + 0.5, 0);
        assert_near(y[3], 20 + 0.5, 0);
        assert_near(y[8 + 2], 200 + 0.5, 0);
        assert_near(y[8 + 3], 2000 + 0.5, 0);
        pbnds_backend_free(b);
    }
}

/** Blocks, the last of them short, and a tail that is not a multiple of four. */
static void test_bias_gradient_sums_all_pixels(void **state)
{
    (void)state;
    enum { PIXELS = 2 * 2048 + 7, CHANNELS = 5 };
    float *dy = malloc(PIXELS * CHANNELS * sizeof *dy);
    for (int dtype = 0; dtype < 2; ++dtype) {
        const enum pbnds_dtype type = dtype ? PBNDS_BF16 : PBNDS_F32;
        float sum[CHANNELS] = {1, 2, 3, 4, 5};
        double expected[CHANNELS] = {1, 2, 3, 4, 5};
        struct pbnds_error error;
        fill_typed(type, dy, PIXELS * CHANNELS, 8);
        for (size_t i = 0; i < PIXELS * CHANNELS; ++i) {
            expected[i % CHANNELS] += get(type, dy, i);
        }
        assert_int_equal(
            pbnds_conv_bias_gradient(dy, type, PIXELS, CHANNELS, sum, &error),
            PBNDS_OK);
        for (int o = 0; o < CHANNELS; ++o)
            assert_near((double)sum[o], expected[o], 1e-3);
    }
    free(dy);
}

/** Cached copies of weights must go when the weights change, and must not be mixed up
 *  between the two directions of a square 1x1. */
static void test_weights_cache(void **state)
{
    (void)state;
    struct pbnds_backend *dnn = onednn(), *ref = reference();
    const struct pbnds_conv c = {1, 4, 4, 32, 32, 1, 1, false, false, PBNDS_F32};
    struct problem a = make(&c), b = make(&c);
    for (uint64_t round = 0; round < 4; ++round) {
        fill(a.w, a.ws, 100 + round);
        memcpy(b.w, a.w, a.ws * 4);
        dnn->ops->weights_changed(dnn);
        run_all(dnn, &a);
        run_all(ref, &b);
        assert_true(difference(PBNDS_F32, a.y, b.y, a.ys) < 2e-5);
        assert_true(difference(PBNDS_F32, a.dx, b.dx, a.xs) < 2e-5);
    }
    clear(&a);
    clear(&b);
    pbnds_backend_free(dnn);
    pbnds_backend_free(ref);
}

/** The same input and thread count give the same bits; forward at any thread count. */
static void test_determinism(void **state)
{
    (void)state;
    for (int dtype = 0; dtype < 2; ++dtype) {
        struct pbnds_backend *b = onednn();
        if (dtype == 1 && !runs_bf16(b)) {
            pbnds_backend_free(b);
            continue;
        }
        const struct pbnds_conv c = {
            3, 24, 40, 32, 32, 3, 1, false, false, dtype ? PBNDS_BF16 : PBNDS_F32};
        const size_t size = pbnds_dtype_size(c.dtype);
        struct problem p = make(&c), q = make(&c), r = make(&c);
        pbnds_set_threads(2);
        run_all(b, &p);
        run_all(b, &q);
        pbnds_set_threads(1);
        run_all(b, &r);
        pbnds_set_threads(1);
        assert_memory_equal(p.y, q.y, p.ys * size);
        assert_memory_equal(p.dx, q.dx, p.xs * size);
        assert_memory_equal(p.dw, q.dw, p.ws * 4);
        assert_memory_equal(p.db, q.db, (size_t)c.out * 4);
        assert_memory_equal(p.y, r.y, p.ys * size);
        assert_memory_equal(p.dx, r.dx, p.xs * size);
        assert_true(difference(PBNDS_F32, p.dw, r.dw, p.ws) < 1e-4);
        clear(&p);
        clear(&q);
        clear(&r);
        pbnds_backend_free(b);
    }
}

static void test_bad_convolutions_are_refused(void **state)
{
    (void)state;
    struct pbnds_conv bad[] = {
        {0, 4, 4, 1, 1, 1, 1, false, false, PBNDS_F32},
        {1, 4, 4, 0, 1, 1, 1, false, false, PBNDS_F32},
        {1, 4, 4, 1, 1, 5, 1, false, false, PBNDS_F32},
        {1, 4, 4, 1, 1, 2, 1, false, false, PBNDS_F32},
        {1, 4, 4, 1, 1, 1, 2, false, false, PBNDS_F32},
        {1, 5, 4, 1, 1, 3, 2, false, false, PBNDS_F32},
        {1, 4, 4, 1, 1, 3, 2, true, false, PBNDS_F32},
        {1 << 30, 1 << 30, 1 << 30, 1, 1, 1, 1, false, false, PBNDS_F32},
    };
    struct pbnds_backend *both[] = {onednn(), reference()};
    for (size_t k = 0; k < 2; ++k) {
        for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
            struct pbnds_error error = {""};
            float some[64] = {0};
            assert_int_equal(both[k]->ops->conv_forward(both[k], &bad[i], some, some,
                                                        some, some, &error),
                             PBNDS_ERROR_ARGUMENT);
            assert_true(strlen(error.message) > 10);
        }
        pbnds_backend_free(both[k]);
    }
    pbnds_backend_free(NULL);
}

static void test_bf16_rounds_to_nearest_even(void **state)
{
    (void)state;
    assert_int_equal(pbnds_f32_to_bf16(1.0f), 0x3f80);
    assert_int_equal(pbnds_f32_to_bf16(1.0f + 0x1p-8f), 0x3f80); /* tie, to even */
    assert_int_equal(pbnds_f32_to_bf16(1.0f + 0x3p-8f), 0x3f82); /* tie, to even */
    assert_int_equal(pbnds_f32_to_bf16(1.0f + 0x1.01p-8f), 0x3f81);
    assert_int_equal(pbnds_f32_to_bf16(-INFINITY), 0xff80);
    assert_int_equal(pbnds_f32_to_bf16(3.4e38f), 0x7f80); /* rounds up to infinity */
    assert_true(isnan(pbnds_bf16_to_f32(pbnds_f32_to_bf16(NAN))));
    for (uint32_t b = 0; b < 0x7f80; ++b) {
        assert_int_equal(pbnds_f32_to_bf16(pbnds_bf16_to_f32((uint16_t)b)), b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_f32_equals_the_twin),
        cmocka_unit_test(test_bf16_equals_the_twin),
        cmocka_unit_test(test_twin_has_the_derivatives_of_its_forward),
        cmocka_unit_test(test_known_answers),
        cmocka_unit_test(test_bias_gradient_sums_all_pixels),
        cmocka_unit_test(test_weights_cache),
        cmocka_unit_test(test_determinism),
        cmocka_unit_test(test_bad_convolutions_are_refused),
        cmocka_unit_test(test_bf16_rounds_to_nearest_even),
    };
    pbnds_set_threads(1); /* other tests run beside this one */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
