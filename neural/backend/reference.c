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

static size_t weight_index(const struct pbnds_conv *c, int o, int i, int ky, int kx)
{
    const size_t outer = (size_t)(c->transposed ? i : o);
    const size_t inner = (size_t)(c->transposed ? o : i);
    const size_t inners = (size_t)(c->transposed ? c->out : c->in);
    return ((outer * inners + inner) * (size_t)c->kernel + (size_t)ky) *
               (size_t)c->kernel +
           (size_t)kx;
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

struct visit {
    const struct pbnds_conv *c;
    size_t in_pixel, out_pixel;
    int ky, kx;
};

/** Calls fn for every pair of input and output pixel that a tap joins. */
static void for_each_tap(const struct pbnds_conv *c,
                         void (*fn)(const struct visit *v, void *context),
                         void *context)
{
    const int oh = pbnds_conv_out_h(c), ow = pbnds_conv_out_w(c);
    const size_t taps = (size_t)(c->kernel * c->kernel);
    for (int b = 0; b < c->n; ++b) {
        for (size_t i = 0; i < (size_t)oh * (size_t)ow * taps; ++i) {
            const int ky = (int)(i % taps) / c->kernel,
                      kx = (int)(i % taps) % c->kernel;
            const int oy = (int)(i / taps / (size_t)ow),
                      ox = (int)(i / taps % (size_t)ow);
            int y, x;
            if (!tap(c, oy, ox, ky, kx, &y, &x)) continue;
            const struct visit v = {c, pixel(c->h, c->w, b, y, x),
                                    pixel(oh, ow, b, oy, ox), ky, kx};
            fn(&v, context);
        }
    }
}

struct operands {
    const void *x, *dy;
    const float *weight;
    double *sum; /**< y, dx or dw, by the call */
};

static void visit_forward(const struct visit *v, void *context)
{
    const struct operands *a = context;
    const struct pbnds_conv *c = v->c;
    for (int o = 0; o < c->out; ++o) {
        for (int i = 0; i < c->in; ++i) {
            a->sum[v->out_pixel * (size_t)c->out + (size_t)o] +=
                (double)a->weight[weight_index(c, o, i, v->ky, v->kx)] *
                load(c->dtype, a->x, v->in_pixel * (size_t)c->in + (size_t)i);
        }
    }
}

static void visit_data(const struct visit *v, void *context)
{
    const struct operands *a = context;
    const struct pbnds_conv *c = v->c;
    for (int o = 0; o < c->out; ++o) {
        for (int i = 0; i < c->in; ++i) {
            a->sum[v->in_pixel * (size_t)c->in + (size_t)i] +=
                (double)a->weight[weight_index(c, o, i, v->ky, v->kx)] *
                load(c->dtype, a->dy, v->out_pixel * (size_t)c->out + (size_t)o);
        }
    }
}

static void visit_weights(const struct visit *v, void *context)
{
    const struct operands *a = context;
    const struct pbnds_conv *c = v->c;
    for (int o = 0; o < c->out; ++o) {
        for (int i = 0; i < c->in; ++i) {
            a->sum[weight_index(c, o, i, v->ky, v->kx)] +=
                load(c->dtype, a->x, v->in_pixel * (size_t)c->in + (size_t)i) *
                load(c->dtype, a->dy, v->out_pixel * (size_t)c->out + (size_t)o);
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

static enum pbnds_status sums(size_t count, double **sum, struct pbnds_error *error)
{
    *sum = calloc(count, sizeof **sum);
    if (*sum) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                      "reference convolution: no memory for %zu sums", count);
}

static enum pbnds_status forward(struct pbnds_backend *b, const struct pbnds_conv *c,
                                 const void *x, const float *weight, const float *bias,
                                 void *y, struct pbnds_error *error)
{
    (void)b;
    struct operands a = {x, NULL, weight, NULL};
    PBNDS_TRY(pbnds_conv_check(c, error));
    PBNDS_TRY(sums(out_count(c), &a.sum, error));
    for_each_tap(c, visit_forward, &a);
    for (size_t k = 0; k < out_count(c); ++k) {
        const double v = a.sum[k] + (double)bias[k % (size_t)c->out];
        store(c->dtype, y, k, c->relu && v < 0.0 ? 0.0 : v);
    }
    free(a.sum);
    return PBNDS_OK;
}

static enum pbnds_status backward_data(struct pbnds_backend *b,
                                       const struct pbnds_conv *c, const void *dy,
                                       const float *weight, void *dx,
                                       struct pbnds_error *error)
{
    (void)b;
    struct operands a = {NULL, dy, weight, NULL};
    PBNDS_TRY(pbnds_conv_check(c, error));
    PBNDS_TRY(sums(in_count(c), &a.sum, error));
    for_each_tap(c, visit_data, &a);
    for (size_t k = 0; k < in_count(c); ++k)
        store(c->dtype, dx, k, a.sum[k]);
    free(a.sum);
    return PBNDS_OK;
}

static enum pbnds_status backward_weights(struct pbnds_backend *b,
                                          const struct pbnds_conv *c, const void *x,
                                          const void *dy, float *dweight, float *dbias,
                                          struct pbnds_error *error)
{
    (void)b;
    const size_t weights = pbnds_conv_weight_count(c), channels = (size_t)c->out;
    struct operands a = {x, dy, NULL, NULL};
    PBNDS_TRY(pbnds_conv_check(c, error));
    PBNDS_TRY(sums(weights + channels, &a.sum, error));
    for_each_tap(c, visit_weights, &a);
    for (size_t k = 0; k < out_count(c); ++k) {
        a.sum[weights + k % channels] += load(c->dtype, dy, k);
    }
    for (size_t k = 0; k < weights; ++k)
        dweight[k] += (float)a.sum[k];
    for (size_t k = 0; k < channels; ++k)
        dbias[k] += (float)a.sum[weights + k];
    free(a.sum);
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
