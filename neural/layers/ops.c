#include "neural/layers/ops.h"

#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
#include "neural/backend/dtype.h"

/* One body serves both element types: a macro argument gives type, load and store. The
 * loops have no branch and no reordered sum, so they vectorise to the same bits. */
#define F32_TYPE          float
#define F32_LOAD(v)       (v)
#define F32_STORE(v)      (v)
#define BF16_TYPE         uint16_t
#define BF16_LOAD(v)      pbnds_bf16_to_f32(v)
#define BF16_STORE(v)     pbnds_f32_to_bf16(v)
#define FOR_TYPES(define) define(f32, F32) define(bf16, BF16)

enum { BLOCK = 1 << 14 }; /* elements in one call of a flat kernel */

/** relu; a NaN stays, so that a training that diverges is seen. */
static float positive(float v)
{
    return v < 0.0f ? 0.0f : v;
}

/* --- flat kernels ----------------------------------------------------------------- */

#define DEFINE_FLAT(name, T)                                                           \
    PBNDS_KERNEL static void add_##name(const T##_TYPE *a, const T##_TYPE *b,          \
                                        T##_TYPE *y, size_t n)                         \
    {                                                                                  \
        PBNDS_SIMD for (size_t i = 0; i < n; ++i)                                      \
        {                                                                              \
            y[i] = T##_STORE(T##_LOAD(a[i]) + T##_LOAD(b[i]));                         \
        }                                                                              \
    }                                                                                  \
    PBNDS_KERNEL static void add_relu_##name(const T##_TYPE *a, const T##_TYPE *b,     \
                                             T##_TYPE *y, size_t n)                    \
    {                                                                                  \
        PBNDS_SIMD for (size_t i = 0; i < n; ++i)                                      \
        {                                                                              \
            y[i] = T##_STORE(positive(T##_LOAD(a[i]) + T##_LOAD(b[i])));               \
        }                                                                              \
    }                                                                                  \
    PBNDS_KERNEL static void accumulate_f32_##name(const float *x, T##_TYPE *y,        \
                                                   size_t n)                           \
    {                                                                                  \
        PBNDS_SIMD for (size_t i = 0; i < n; ++i)                                      \
        {                                                                              \
            y[i] = T##_STORE(T##_LOAD(y[i]) + x[i]);                                   \
        }                                                                              \
    }                                                                                  \
    PBNDS_KERNEL static void sum_##name(const T##_TYPE *x, float *y, size_t n)         \
    {                                                                                  \
        PBNDS_SIMD for (size_t i = 0; i < n; ++i) y[i] += T##_LOAD(x[i]);              \
    }                                                                                  \
    PBNDS_KERNEL static void from_f32_##name(const float *x, T##_TYPE *y, size_t n)    \
    {                                                                                  \
        PBNDS_SIMD for (size_t i = 0; i < n; ++i) y[i] = T##_STORE(x[i]);              \
    }                                                                                  \
    PBNDS_KERNEL static void to_f32_##name(const T##_TYPE *x, float *y, size_t n)      \
    {                                                                                  \
        PBNDS_SIMD for (size_t i = 0; i < n; ++i) y[i] = T##_LOAD(x[i]);               \
    }                                                                                  \
    PBNDS_KERNEL static void dropout_##name(const T##_TYPE *x, T##_TYPE *y,            \
                                            size_t first, size_t n, uint64_t key,      \
                                            float rate)                                \
    {                                                                                  \
        const float scale = 1.0f / (1.0f - rate);                                      \
        const int64_t least = (int64_t)((double)rate * 0x1p24);                        \
        for (size_t i = 0; i < n; ++i) {                                               \
            const int64_t u = (int64_t)(pbnds_mix64(key ^ (first + i)) >> 40);         \
            y[i] = u >= least ? T##_STORE(T##_LOAD(x[i]) * scale) : (T##_TYPE)0;       \
        }                                                                              \
    }
FOR_TYPES(DEFINE_FLAT)

PBNDS_KERNEL
static void mask_f32(const float *y, float *dy, size_t n)
{
    PBNDS_SIMD
    for (size_t i = 0; i < n; ++i)
        dy[i] = y[i] > 0.0f ? dy[i] : 0.0f;
}

/** As integers: a positive bf16 is a positive 16-bit number. */
PBNDS_KERNEL
static void mask_bf16(const uint16_t *y, uint16_t *dy, size_t n)
{
    PBNDS_SIMD
    for (size_t i = 0; i < n; ++i) {
        const int16_t positive_y = (int16_t)y[i] > 0;
        dy[i] = (uint16_t)(dy[i] & (uint16_t)-positive_y);
    }
}

/** Arguments of a flat kernel over [0, count), cut into blocks. */
struct flat {
    enum pbnds_dtype dtype;
    size_t count;
    const void *x;
    void *y;
    uint64_t key;
    float rate;
    void (*block)(const struct flat *f, size_t first, size_t n);
};

static void flat_block(void *context, size_t i, int thread)
{
    const struct flat *f = context;
    const size_t first = i * BLOCK, left = f->count - first;
    (void)thread;
    f->block(f, first, left < BLOCK ? left : BLOCK);
}

static void run_flat(const struct flat *f)
{
    struct flat copy = *f;
    pbnds_parallel_for((f->count + BLOCK - 1) / BLOCK, flat_block, &copy);
}

static void from_f32_block(const struct flat *f, size_t first, size_t n)
{
    const float *x = (const float *)f->x + first;
    if (f->dtype == PBNDS_BF16) {
        from_f32_bf16(x, (uint16_t *)f->y + first, n);
    } else {
        from_f32_f32(x, (float *)f->y + first, n);
    }
}

static void to_f32_block(const struct flat *f, size_t first, size_t n)
{
    float *y = (float *)f->y + first;
    if (f->dtype == PBNDS_BF16) {
        to_f32_bf16((const uint16_t *)f->x + first, y, n);
    } else {
        to_f32_f32((const float *)f->x + first, y, n);
    }
}

static void accumulate_block(const struct flat *f, size_t first, size_t n)
{
    if (f->dtype == PBNDS_BF16) {
        uint16_t *y = (uint16_t *)f->y + first;
        add_bf16((const uint16_t *)f->x + first, y, y, n);
    } else {
        float *y = (float *)f->y + first;
        add_f32((const float *)f->x + first, y, y, n);
    }
}

static void accumulate_f32_block(const struct flat *f, size_t first, size_t n)
{
    const float *x = (const float *)f->x + first;
    if (f->dtype == PBNDS_BF16) {
        accumulate_f32_bf16(x, (uint16_t *)f->y + first, n);
    } else {
        accumulate_f32_f32(x, (float *)f->y + first, n);
    }
}

static void mask_block(const struct flat *f, size_t first, size_t n)
{
    if (f->dtype == PBNDS_BF16) {
        mask_bf16((const uint16_t *)f->x + first, (uint16_t *)f->y + first, n);
    } else {
        mask_f32((const float *)f->x + first, (float *)f->y + first, n);
    }
}

static void dropout_block(const struct flat *f, size_t first, size_t n)
{
    if (f->dtype == PBNDS_BF16) {
        dropout_bf16((const uint16_t *)f->x + first, (uint16_t *)f->y + first, first, n,
                     f->key, f->rate);
    } else {
        dropout_f32((const float *)f->x + first, (float *)f->y + first, first, n,
                    f->key, f->rate);
    }
}

void pbnds_from_f32(enum pbnds_dtype dtype, const float *from, void *to, size_t count)
{
    run_flat(&(struct flat){dtype, count, from, to, 0, 0.0f, from_f32_block});
}

void pbnds_to_f32(enum pbnds_dtype dtype, const void *from, float *to, size_t count)
{
    run_flat(&(struct flat){dtype, count, from, to, 0, 0.0f, to_f32_block});
}

void pbnds_accumulate(enum pbnds_dtype dtype, const void *x, void *y, size_t count)
{
    run_flat(&(struct flat){dtype, count, x, y, 0, 0.0f, accumulate_block});
}

void pbnds_accumulate_f32(enum pbnds_dtype dtype, const float *x, void *y, size_t count)
{
    run_flat(&(struct flat){dtype, count, x, y, 0, 0.0f, accumulate_f32_block});
}

void pbnds_relu_mask(enum pbnds_dtype dtype, const void *y, void *dy, size_t count)
{
    run_flat(&(struct flat){dtype, count, y, dy, 0, 0.0f, mask_block});
}

void pbnds_dropout(enum pbnds_dtype dtype, size_t count, uint64_t key, float rate,
                   const void *x, void *y)
{
    run_flat(&(struct flat){dtype, count, x, y, key, rate, dropout_block});
}

/* --- row kernels: one call for each row of pixels --------------------------------- */

struct rows {
    enum pbnds_dtype dtype;
    struct pbnds_shape shape;
    const char *a, *b;
    char *y;
    size_t repeat_a, repeat_b; /* repeat_b: N in a sum over lights */
    size_t whole_c, at;
    bool flag; /* relu, or add to what is there */
};

static void run_rows(const struct rows *r, void (*row)(void *, size_t, int))
{
    struct rows copy = *r;
    pbnds_parallel_for(r->shape.images * r->shape.h, row, &copy);
}

/** Byte offset of row `y` of image `k`, for pixels of c channels. */
static size_t row_at(const struct rows *r, size_t k, size_t y, size_t c)
{
    return (k * r->shape.h + y) * r->shape.w * c * pbnds_dtype_size(r->dtype);
}

static void add_row(void *context, size_t i, int thread)
{
    const struct rows *r = context;
    const size_t k = i / r->shape.h, y = i % r->shape.h, c = r->shape.c;
    const size_t n = r->shape.w * c;
    (void)thread;
    const void *a = r->a + row_at(r, k / r->repeat_a, y, c);
    const void *b = r->b + row_at(r, k / r->repeat_b, y, c);
    void *to = r->y + row_at(r, k, y, c);
    if (r->dtype == PBNDS_BF16) {
        (r->flag ? add_relu_bf16 : add_bf16)(a, b, to, n);
    } else {
        (r->flag ? add_relu_f32 : add_f32)(a, b, to, n);
    }
}

void pbnds_add_forward(enum pbnds_dtype dtype, struct pbnds_shape shape, const void *a,
                       size_t repeat_a, const void *b, size_t repeat_b, bool relu,
                       void *y)
{
    run_rows(&(struct rows){.dtype = dtype,
                            .shape = shape,
                            .a = a,
                            .b = b,
                            .y = y,
                            .repeat_a = repeat_a,
                            .repeat_b = repeat_b,
                            .flag = relu},
             add_row);
}

/** Copies `run` bytes a pixel between two rows of pixels. */
static void copy_pixels(const char *from, size_t from_step, char *to, size_t to_step,
                        size_t run, size_t pixels)
{
    for (size_t x = 0; x < pixels; ++x)
        memcpy(to + x * to_step, from + x * from_step, run);
}

static void insert_row(void *context, size_t i, int thread)
{
    const struct rows *r = context;
    const size_t k = i / r->shape.h, y = i % r->shape.h,
                 size = pbnds_dtype_size(r->dtype);
    (void)thread;
    copy_pixels(r->a + row_at(r, k / r->repeat_a, y, r->shape.c), r->shape.c * size,
                r->y + row_at(r, k, y, r->whole_c) + r->at * size, r->whole_c * size,
                r->shape.c * size, r->shape.w);
}

void pbnds_channels_insert(enum pbnds_dtype dtype, struct pbnds_shape part,
                           const void *from, size_t repeat, void *whole, size_t whole_c,
                           size_t at)
{
    run_rows(&(struct rows){.dtype = dtype,
                            .shape = part,
                            .a = from,
                            .y = whole,
                            .repeat_a = repeat,
                            .whole_c = whole_c,
                            .at = at},
             insert_row);
}

static void extract_row(void *context, size_t i, int thread)
{
    const struct rows *r = context;
    const size_t k = i / r->shape.h, y = i % r->shape.h,
                 size = pbnds_dtype_size(r->dtype);
    (void)thread;
    copy_pixels(r->a + row_at(r, k, y, r->whole_c) + r->at * size, r->whole_c * size,
                r->y + row_at(r, k, y, r->shape.c), r->shape.c * size,
                r->shape.c * size, r->shape.w);
}

void pbnds_channels_extract(enum pbnds_dtype dtype, struct pbnds_shape part,
                            const void *whole, size_t whole_c, size_t at, void *to)
{
    run_rows(&(struct rows){.dtype = dtype,
                            .shape = part,
                            .a = whole,
                            .y = to,
                            .whole_c = whole_c,
                            .at = at},
             extract_row);
}

static void sum_run(enum pbnds_dtype dtype, const char *x, float *y, size_t n)
{
    if (dtype == PBNDS_BF16) {
        sum_bf16((const void *)x, y, n);
    } else {
        sum_f32((const void *)x, y, n);
    }
}

static void sum_lights_row(void *context, size_t i, int thread)
{
    const struct rows *r = context;
    const size_t k = i / r->shape.h, y = i % r->shape.h, c = r->shape.c, w = r->shape.w;
    const size_t size = pbnds_dtype_size(r->dtype), lights = r->repeat_b;
    float *to = (float *)(void *)r->y + i * w * c;
    (void)thread;
    if (!r->flag) memset(to, 0, w * c * sizeof *to);
    for (size_t light = 0; light < lights; ++light) {
        const char *from = r->a + row_at(r, k * lights + light, y, r->whole_c);
        if (c == r->whole_c) {
            sum_run(r->dtype, from, to, w * c);
            continue;
        }
        for (size_t x = 0; x < w; ++x) {
            sum_run(r->dtype, from + (x * r->whole_c + r->at) * size, to + x * c, c);
        }
    }
}

void pbnds_sum_lights(enum pbnds_dtype dtype, struct pbnds_shape part, size_t lights,
                      const void *whole, size_t whole_c, size_t at, float *to, bool add)
{
    run_rows(&(struct rows){.dtype = dtype,
                            .shape = part,
                            .a = whole,
                            .y = (char *)to,
                            .repeat_b = lights,
                            .whole_c = whole_c,
                            .at = at,
                            .flag = add},
             sum_lights_row);
}

/* --- 2x2 kernels: a row of the small tensor and two of the large one -------------- */

#define DEFINE_2X2(name, T)                                                            \
    static void shuffle_##name(const T##_TYPE *x, T##_TYPE *y, size_t w, size_t c)     \
    {                                                                                  \
        T##_TYPE *below = y + 2 * w * c;                                               \
        for (size_t p = 0; p < w; ++p) {                                               \
            for (size_t o = 0; o < c; ++o) {                                           \
                y[2 * p * c + o] = x[4 * (p * c + o)];                                 \
                y[(2 * p + 1) * c + o] = x[4 * (p * c + o) + 1];                       \
                below[2 * p * c + o] = x[4 * (p * c + o) + 2];                         \
                below[(2 * p + 1) * c + o] = x[4 * (p * c + o) + 3];                   \
            }                                                                          \
        }                                                                              \
    }                                                                                  \
    static void unshuffle_##name(const T##_TYPE *y, T##_TYPE *x, size_t w, size_t c)   \
    {                                                                                  \
        const T##_TYPE *below = y + 2 * w * c;                                         \
        for (size_t p = 0; p < w; ++p) {                                               \
            for (size_t o = 0; o < c; ++o) {                                           \
                x[4 * (p * c + o)] = y[2 * p * c + o];                                 \
                x[4 * (p * c + o) + 1] = y[(2 * p + 1) * c + o];                       \
                x[4 * (p * c + o) + 2] = below[2 * p * c + o];                         \
                x[4 * (p * c + o) + 3] = below[(2 * p + 1) * c + o];                   \
            }                                                                          \
        }                                                                              \
    }                                                                                  \
    PBNDS_KERNEL static void pool_##name(const T##_TYPE *x, T##_TYPE *y, size_t w,     \
                                         size_t c)                                     \
    {                                                                                  \
        const T##_TYPE *below = x + 2 * w * c;                                         \
        for (size_t p = 0; p < w; ++p) {                                               \
            const T##_TYPE *up = x + 2 * p * c, *down = below + 2 * p * c;             \
            PBNDS_SIMD for (size_t o = 0; o < c; ++o)                                  \
            {                                                                          \
                const float sum = (T##_LOAD(up[o]) + T##_LOAD(up[c + o])) +            \
                                  (T##_LOAD(down[o]) + T##_LOAD(down[c + o]));         \
                y[p * c + o] = T##_STORE(0.25f * sum);                                 \
            }                                                                          \
        }                                                                              \
    }                                                                                  \
    PBNDS_KERNEL static void unpool_##name(const T##_TYPE *y, T##_TYPE *x, size_t w,   \
                                           size_t c)                                   \
    {                                                                                  \
        T##_TYPE *below = x + 2 * w * c;                                               \
        for (size_t p = 0; p < w; ++p) {                                               \
            T##_TYPE *up = x + 2 * p * c, *down = below + 2 * p * c;                   \
            PBNDS_SIMD for (size_t o = 0; o < c; ++o)                                  \
            {                                                                          \
                const T##_TYPE v = T##_STORE(0.25f * T##_LOAD(y[p * c + o]));          \
                up[o] = v;                                                             \
                up[c + o] = v;                                                         \
                down[o] = v;                                                           \
                down[c + o] = v;                                                       \
            }                                                                          \
        }                                                                              \
    }
FOR_TYPES(DEFINE_2X2)

/* shape is that of the small tensor, c the channels of the large one */

static void shuffle_row(void *context, size_t i, int thread)
{
    const struct rows *r = context;
    const size_t w = r->shape.w, c = r->shape.c / 4, n = 4 * w * c;
    (void)thread;
    if (r->dtype == PBNDS_BF16) {
        shuffle_bf16((const uint16_t *)(const void *)r->a + i * n,
                     (uint16_t *)(void *)r->y + i * n, w, c);
    } else {
        shuffle_f32((const float *)(const void *)r->a + i * n,
                    (float *)(void *)r->y + i * n, w, c);
    }
}

static void unshuffle_row(void *context, size_t i, int thread)
{
    const struct rows *r = context;
    const size_t w = r->shape.w, c = r->shape.c / 4, n = 4 * w * c;
    (void)thread;
    if (r->dtype == PBNDS_BF16) {
        unshuffle_bf16((const uint16_t *)(const void *)r->a + i * n,
                       (uint16_t *)(void *)r->y + i * n, w, c);
    } else {
        unshuffle_f32((const float *)(const void *)r->a + i * n,
                      (float *)(void *)r->y + i * n, w, c);
    }
}

static void pool_row(void *context, size_t i, int thread)
{
    const struct rows *r = context;
    const size_t w = r->shape.w, c = r->shape.c, n = w * c;
    (void)thread;
    if (r->dtype == PBNDS_BF16) {
        pool_bf16((const uint16_t *)(const void *)r->a + i * 4 * n,
                  (uint16_t *)(void *)r->y + i * n, w, c);
    } else {
        pool_f32((const float *)(const void *)r->a + i * 4 * n,
                 (float *)(void *)r->y + i * n, w, c);
    }
}

static void unpool_row(void *context, size_t i, int thread)
{
    const struct rows *r = context;
    const size_t w = r->shape.w, c = r->shape.c, n = w * c;
    (void)thread;
    if (r->dtype == PBNDS_BF16) {
        unpool_bf16((const uint16_t *)(const void *)r->a + i * n,
                    (uint16_t *)(void *)r->y + i * 4 * n, w, c);
    } else {
        unpool_f32((const float *)(const void *)r->a + i * n,
                   (float *)(void *)r->y + i * 4 * n, w, c);
    }
}

void pbnds_shuffle_forward(enum pbnds_dtype dtype, struct pbnds_shape in, const void *x,
                           void *y)
{
    run_rows(&(struct rows){.dtype = dtype, .shape = in, .a = x, .y = y}, shuffle_row);
}

void pbnds_shuffle_backward(enum pbnds_dtype dtype, struct pbnds_shape in,
                            const void *dy, void *dx)
{
    run_rows(&(struct rows){.dtype = dtype, .shape = in, .a = dy, .y = dx},
             unshuffle_row);
}

void pbnds_pool_forward(enum pbnds_dtype dtype, struct pbnds_shape out, const void *x,
                        void *y)
{
    run_rows(&(struct rows){.dtype = dtype, .shape = out, .a = x, .y = y}, pool_row);
}

void pbnds_pool_backward(enum pbnds_dtype dtype, struct pbnds_shape out, const void *dy,
                         void *dx)
{
    run_rows(&(struct rows){.dtype = dtype, .shape = out, .a = dy, .y = dx},
             unpool_row);
}
