#include "neural/backend/conv.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "neural/backend/dtype.h"

void pbnds_backend_free(struct pbnds_backend *backend)
{
    if (backend) backend->ops->destroy(backend);
}

/** Keeps every size product of a convolution inside 62 bits. */
static bool fits(const struct pbnds_conv *c)
{
    const int sizes[] = {c->n, c->h, c->w, c->in > c->out ? c->in : c->out, 64};
    uint64_t product = 1;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        if (product > (UINT64_C(1) << 62) / (uint64_t)sizes[i]) return false;
        product *= (uint64_t)sizes[i];
    }
    return true;
}

enum pbnds_status pbnds_conv_check(const struct pbnds_conv *c,
                                   struct pbnds_error *error)
{
    if (c->n < 1 || c->h < 1 || c->w < 1 || c->in < 1 || c->out < 1 || c->in > 65536 ||
        c->out > 65536 || !fits(c)) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "convolution: size %d x %d x %d with %d to %d channels is out of "
            "range",
            c->n, c->h, c->w, c->in, c->out);
    }
    const bool plain = (c->stride == 1 && (c->kernel == 1 || c->kernel == 3)) ||
                       (c->stride == 2 && (c->kernel == 2 || c->kernel == 3));
    const bool up = c->stride == 2 && c->kernel == 2;
    if (!(c->transposed ? up : plain)) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "convolution: %skernel %d with stride %d is not one of 1x1, 3x3, "
            "2x2 stride 2, 3x3 stride 2, transposed 2x2 stride 2",
            c->transposed ? "transposed " : "", c->kernel, c->stride);
    }
    if (!c->transposed && c->stride == 2 && (c->h % 2 || c->w % 2)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "convolution: stride 2 wants even sizes, not %d x %d", c->w,
                          c->h);
    }
    if (c->dtype != PBNDS_F32 && c->dtype != PBNDS_BF16) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "convolution: element type %d is neither float32 nor bfloat16",
            (int)c->dtype);
    }
    return PBNDS_OK;
}

int pbnds_conv_out_h(const struct pbnds_conv *c)
{
    return c->transposed ? 2 * c->h : c->h / c->stride;
}

int pbnds_conv_out_w(const struct pbnds_conv *c)
{
    return c->transposed ? 2 * c->w : c->w / c->stride;
}

int pbnds_conv_pad(const struct pbnds_conv *c)
{
    return c->kernel == 3 ? 1 : 0;
}

size_t pbnds_conv_weight_count(const struct pbnds_conv *c)
{
    return (size_t)c->in * (size_t)c->out * (size_t)(c->kernel * c->kernel);
}

struct pbnds_conv pbnds_conv_up_as_1x1(const struct pbnds_conv *up)
{
    struct pbnds_conv c = *up;
    c.transposed = false;
    c.out = 4 * up->out;
    c.kernel = c.stride = 1;
    return c;
}

void pbnds_conv_up_weight_to_1x1(const struct pbnds_conv *up, const float *weight,
                                 float *out)
{
    const size_t in = (size_t)up->in, channels = (size_t)up->out;
    for (size_t i = 0; i < in; ++i) {
        for (size_t o = 0; o < channels; ++o) {
            for (size_t tap = 0; tap < 4; ++tap) {
                out[(tap * channels + o) * in + i] =
                    weight[(i * channels + o) * 4 + tap];
            }
        }
    }
}

void pbnds_conv_up_bias_to_1x1(const struct pbnds_conv *up, const float *bias,
                               float *out)
{
    for (size_t tap = 0; tap < 4; ++tap) {
        memcpy(out + tap * (size_t)up->out, bias, (size_t)up->out * sizeof *bias);
    }
}

void pbnds_conv_up_weight_from_1x1(const struct pbnds_conv *up, const float *dw,
                                   float *dweight)
{
    const size_t in = (size_t)up->in, channels = (size_t)up->out;
    for (size_t i = 0; i < in; ++i) {
        for (size_t o = 0; o < channels; ++o) {
            for (size_t tap = 0; tap < 4; ++tap) {
                dweight[(i * channels + o) * 4 + tap] +=
                    dw[(tap * channels + o) * in + i];
            }
        }
    }
}

void pbnds_conv_up_bias_from_1x1(const struct pbnds_conv *up, const float *db,
                                 float *dbias)
{
    const size_t channels = (size_t)up->out;
    for (size_t o = 0; o < channels; ++o) {
        dbias[o] +=
            (db[o] + db[channels + o]) + (db[2 * channels + o] + db[3 * channels + o]);
    }
}

struct rearrange {
    const char *from;
    char *to;
    size_t w, run; /**< run: bytes of 2 C elements */
    bool widen;
};

/** One row of input pixels: each deep pixel is two runs, one for each output row. */
static void rearrange_row(void *context, size_t row, int thread)
{
    const struct rearrange *r = context;
    (void)thread;
    const size_t line = r->w * r->run; /* bytes of one wide row */
    for (size_t ky = 0; ky < 2; ++ky) {
        for (size_t x = 0; x < r->w; ++x) {
            const size_t deep = 2 * row * line + (2 * x + ky) * r->run;
            const size_t wide = (2 * row + ky) * line + x * r->run;
            if (r->widen) {
                memcpy(r->to + wide, r->from + deep, r->run);
            } else {
                memcpy(r->to + deep, r->from + wide, r->run);
            }
        }
    }
}

static void rearrange(const struct pbnds_conv *up, const void *from, void *to,
                      bool widen)
{
    struct rearrange r = {from, to, (size_t)up->w,
                          2 * (size_t)up->out * pbnds_dtype_size(up->dtype), widen};
    pbnds_parallel_for((size_t)up->n * (size_t)up->h, rearrange_row, &r);
}

void pbnds_conv_depth_to_space(const struct pbnds_conv *up, const void *deep,
                               void *wide)
{
    rearrange(up, deep, wide, true);
}

void pbnds_conv_space_to_depth(const struct pbnds_conv *up, const void *wide,
                               void *deep)
{
    rearrange(up, wide, deep, false);
}

enum { BIAS_BLOCK = 2048 }; /* pixels in one partial sum */

struct bias_sum {
    const void *dy;
    enum pbnds_dtype dtype;
    size_t pixels, channels;
    float *partial; /**< [blocks, channels] */
};

PBNDS_KERNEL
static void add_four_f32(const float *dy, size_t n, float *sum)
{
    PBNDS_SIMD
    for (size_t o = 0; o < n; ++o) {
        sum[o] += (dy[o] + dy[n + o]) + (dy[2 * n + o] + dy[3 * n + o]);
    }
}

PBNDS_KERNEL
static void add_four_bf16(const uint16_t *dy, size_t n, float *sum)
{
    PBNDS_SIMD
    for (size_t o = 0; o < n; ++o) {
        sum[o] += (pbnds_bf16_to_f32(dy[o]) + pbnds_bf16_to_f32(dy[n + o])) +
                  (pbnds_bf16_to_f32(dy[2 * n + o]) + pbnds_bf16_to_f32(dy[3 * n + o]));
    }
}

static void bias_block(void *context, size_t block, int thread)
{
    const struct bias_sum *s = context;
    (void)thread;
    const size_t first = block * BIAS_BLOCK, channels = s->channels;
    const size_t last = first + BIAS_BLOCK < s->pixels ? first + BIAS_BLOCK : s->pixels;
    float *sum = s->partial + block * channels;
    memset(sum, 0, channels * sizeof *sum);
    size_t p = first;
    for (; p + 4 <= last; p += 4) {
        if (s->dtype == PBNDS_BF16) {
            add_four_bf16((const uint16_t *)s->dy + p * channels, channels, sum);
        } else {
            add_four_f32((const float *)s->dy + p * channels, channels, sum);
        }
    }
    for (; p < last; ++p) {
        for (size_t o = 0; o < channels; ++o) {
            const size_t i = p * channels + o;
            sum[o] += s->dtype == PBNDS_BF16
                          ? pbnds_bf16_to_f32(((const uint16_t *)s->dy)[i])
                          : ((const float *)s->dy)[i];
        }
    }
}

enum pbnds_status pbnds_conv_bias_gradient(const void *dy, enum pbnds_dtype dtype,
                                           size_t pixels, int channels, float *dbias,
                                           struct pbnds_error *error)
{
    const size_t blocks = (pixels + BIAS_BLOCK - 1) / BIAS_BLOCK;
    struct bias_sum s = {dy, dtype, pixels, (size_t)channels, NULL};
    s.partial = calloc(blocks * s.channels, sizeof *s.partial);
    if (!s.partial) {
        return pbnds_fail(
            error, PBNDS_ERROR_MEMORY,
            "bias gradient: no memory for %zu partial sums of %d channels", blocks,
            channels);
    }
    pbnds_parallel_for(blocks, bias_block, &s);
    for (size_t b = 0; b < blocks; ++b) {
        for (size_t o = 0; o < s.channels; ++o)
            dbias[o] += s.partial[b * s.channels + o];
    }
    free(s.partial);
    return PBNDS_OK;
}
