/* The naive twin: the sums of backend.h written as loops, accumulated in double. It
 * exists to be compared with, so nothing here is clever. */
#include <stdlib.h>

#include "neural/backend/conv.h"
#include "neural/backend/dtype.h"

static double load(enum pbnds_dtype dtype, const void *p, size_t i)
{
    return (double)(dtype == PBNDS_BF16 ? pbnds_bf16_to_f32(((const uint16_t *)p)[i])
                                        : ((const float *)p)[i]);
}

static void store(enum pbnds_dtype dtype, void *p, size_t i, double v)
{
    if (dtype == PBNDS_BF16) {
        ((uint16_t *)p)[i] = pbnds_f32_to_bf16((float)v);
    } else {
        ((float *)p)[i] = (float)v;
    }
}

/** For output pixel (oy, ox) and tap (ky, kx): the input pixel, or false where the tap
 *  reads padding (or, transposed, where it writes another output pixel). */
static bool tap(const struct pbnds_conv *c, int oy, int ox, int ky, int kx, int *y,
                int *x)
{
    if (c->transposed) {
        *y = oy / 2;
        *x = ox / 2;
        return oy % 2 == ky && ox % 2 == kx;
    }
    *y = oy * c->stride + ky - pbnds_conv_pad(c);
    *x = ox * c->stride + kx - pbnds_conv_pad(c);
    return *y >= 0 && *y < c->h && *x >= 0 && *x < c->w;
}

static size_t pixel(int h, int w, int b, int y, int x)
{
    return ((size_t)b * (size_t)h + (size_t)y) * (size_t)w + (size_t)x;
}

/** One tap that joins an input pixel and an output pixel. */
struct visit {
    size_t x, y;           /**< first channel of the two pixels            */
    size_t weight;         /**< of the tap, at output and input channel 0  */
    size_t step_o, step_i; /**< from channel to channel in the weights     */
};

struct operands {
    const struct pbnds_conv *c;
    double *x, *dy;
    const float *weight;
    double *sum; /**< y, dx or dw, by the call */
};

static void for_each_tap(struct operands *a,
                         void (*fn)(const struct operands *a, const struct visit *v))
{
    const struct pbnds_conv *c = a->c;
    const int oh = pbnds_conv_out_h(c), ow = pbnds_conv_out_w(c);
    const size_t taps = (size_t)(c->kernel * c->kernel);
    const size_t in = (size_t)c->in, out = (size_t)c->out;
    struct visit v = {.step_o = c->transposed ? taps : in * taps,
                      .step_i = c->transposed ? out * taps : taps};
    for (int b = 0; b < c->n; ++b) {
        for (size_t i = 0; i < (size_t)oh * (size_t)ow * taps; ++i) {
            const int ky = (int)(i % taps) / c->kernel,
                      kx = (int)(i % taps) % c->kernel;
            const int oy = (int)(i / taps / (size_t)ow),
                      ox = (int)(i / taps % (size_t)ow);
            int y, x;
            if (!tap(c, oy, ox, ky, kx, &y, &x)) continue;
            v.x = pixel(c->h, c->w, b, y, x) * in;
            v.y = pixel(oh, ow, b, oy, ox) * out;
            v.weight = i % taps;
            fn(a, &v);
        }
    }
}

static void visit_forward(const struct operands *a, const struct visit *v)
{
    for (int o = 0; o < a->c->out; ++o) {
        const float *w = a->weight + v->weight + (size_t)o * v->step_o;
        double sum = 0.0;
        for (int i = 0; i < a->c->in; ++i) {
            sum += (double)w[(size_t)i * v->step_i] * a->x[v->x + (size_t)i];
        }
        a->sum[v->y + (size_t)o] += sum;
    }
}

static void visit_data(const struct operands *a, const struct visit *v)
{
    for (int o = 0; o < a->c->out; ++o) {
        const float *w = a->weight + v->weight + (size_t)o * v->step_o;
        for (int i = 0; i < a->c->in; ++i) {
            a->sum[v->x + (size_t)i] +=
                (double)w[(size_t)i * v->step_i] * a->dy[v->y + (size_t)o];
        }
    }
}

static void visit_weights(const struct operands *a, const struct visit *v)
{
    for (int o = 0; o < a->c->out; ++o) {
        double *dw = a->sum + v->weight + (size_t)o * v->step_o;
        for (int i = 0; i < a->c->in; ++i) {
            dw[(size_t)i * v->step_i] +=
                a->x[v->x + (size_t)i] * a->dy[v->y + (size_t)o];
        }
    }
}

static size_t in_count(const struct pbnds_conv *c)
{
    return (size_t)c->n * (size_t)c->h * (size_t)c->w * (size_t)c->in;
}

static size_t out_count(const struct pbnds_conv *c)
{
    return (size_t)c->n * (size_t)pbnds_conv_out_h(c) * (size_t)pbnds_conv_out_w(c) *
           (size_t)c->out;
}

/** The operands in double; x, dy and sums where their counts are not 0. */
static enum pbnds_status open_operands(struct operands *a, const struct pbnds_conv *c,
                                       const void *x, const void *dy, size_t sums,
                                       struct pbnds_error *error)
{
    const size_t xs = x ? in_count(c) : 0, dys = dy ? out_count(c) : 0;
    *a = (struct operands){.c = c};
    a->x = malloc((xs + dys) * sizeof *a->x);
    a->sum = calloc(sums, sizeof *a->sum);
    if (!a->x || !a->sum) {
        free(a->x);
        free(a->sum);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "reference convolution: no memory for %zu numbers",
                          xs + dys + sums);
    }
    a->dy = a->x + xs;
    for (size_t i = 0; i < xs; ++i)
        a->x[i] = load(c->dtype, x, i);
    for (size_t i = 0; i < dys; ++i)
        a->dy[i] = load(c->dtype, dy, i);
    return PBNDS_OK;
}

static void close_operands(struct operands *a)
{
    free(a->x);
    free(a->sum);
}

static enum pbnds_status forward(struct pbnds_backend *b, const struct pbnds_conv *c,
                                 const void *x, const float *weight, const float *bias,
                                 void *y, struct pbnds_error *error)
{
    (void)b;
    struct operands a;
    PBNDS_TRY(pbnds_conv_check(c, error));
    PBNDS_TRY(open_operands(&a, c, x, NULL, out_count(c), error));
    a.weight = weight;
    for_each_tap(&a, visit_forward);
    for (size_t k = 0; k < out_count(c); ++k) {
        const double v = a.sum[k] + (double)bias[k % (size_t)c->out];
        store(c->dtype, y, k, c->relu && v < 0.0 ? 0.0 : v);
    }
    close_operands(&a);
    return PBNDS_OK;
}

static enum pbnds_status backward_data(struct pbnds_backend *b,
                                       const struct pbnds_conv *c, const void *dy,
                                       const float *weight, void *dx,
                                       struct pbnds_error *error)
{
    (void)b;
    struct operands a;
    PBNDS_TRY(pbnds_conv_check(c, error));
    PBNDS_TRY(open_operands(&a, c, NULL, dy, in_count(c), error));
    a.weight = weight;
    for_each_tap(&a, visit_data);
    for (size_t k = 0; k < in_count(c); ++k)
        store(c->dtype, dx, k, a.sum[k]);
    close_operands(&a);
    return PBNDS_OK;
}

static enum pbnds_status backward_weights(struct pbnds_backend *b,
                                          const struct pbnds_conv *c, const void *x,
                                          const void *dy, float *dweight, float *dbias,
                                          struct pbnds_error *error)
{
    (void)b;
    const size_t weights = pbnds_conv_weight_count(c), channels = (size_t)c->out;
    struct operands a;
    PBNDS_TRY(pbnds_conv_check(c, error));
    PBNDS_TRY(open_operands(&a, c, x, dy, weights + channels, error));
    for_each_tap(&a, visit_weights);
    for (size_t k = 0; k < out_count(c); ++k)
        a.sum[weights + k % channels] += a.dy[k];
    for (size_t k = 0; k < weights; ++k)
        dweight[k] += (float)a.sum[k];
    for (size_t k = 0; k < channels; ++k)
        dbias[k] += (float)a.sum[weights + k];
    close_operands(&a);
    return PBNDS_OK;
}

static void weights_changed(struct pbnds_backend *b)
{
    (void)b; /* nothing is cached */
}

static void destroy(struct pbnds_backend *b)
{
    free(b);
}

enum pbnds_status pbnds_backend_create_reference(struct pbnds_backend **backend,
                                                 struct pbnds_error *error)
{
    static const struct pbnds_backend_ops ops = {"reference",     forward,
                                                 backward_data,   backward_weights,
                                                 weights_changed, destroy};
    *backend = malloc(sizeof **backend);
    if (!*backend) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "reference backend: no memory");
    }
    (*backend)->ops = &ops;
    return PBNDS_OK;
}
