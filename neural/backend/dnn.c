/* oneDNN on the CPU. The only file that knows it; written against the v2 C API.
 *
 * Activations are NHWC. Weights go in the format that each primitive prefers ("any"):
 * copies are made once and kept until the weights change. Primitives are kept too, for
 * making one compiles code. The transposed convolution is run as a 1x1 to four times
 * the channels and a move of the taps to their pixels, because oneDNN's own
 * deconvolution runs at a fraction of the speed. */
#include <stdlib.h>
#include <string.h>

#include <oneapi/dnnl/dnnl.h>

#include "engine/core/parallel.h"
#include "neural/backend/conv.h"
#include "neural/backend/dtype.h"

#if DNNL_VERSION_MAJOR != 2
#error "neural/backend/dnn.c is written against oneDNN 2.x (descriptors went away in 3)"
#endif

enum kind { FORWARD, BACKWARD_DATA, BACKWARD_WEIGHTS };

enum {
    BUCKETS = 256,
    MAX_PRIMITIVES = 512, /* then all are dropped: they hold compiled code */
    ALIGNMENT = 64,
};

/** How oneDNN is asked for it. */
enum form {
    CONVOLUTION,
    PRODUCT, /**< weights gradient of a 1x1 as one matrix product              */
    SWAPPED, /**< data gradient of a 1x1 as the 1x1 with W transposed: forward
                  kernels are several times as fast as backward ones           */
};

/** A convolution primitive and the memory objects that its arguments are hung on. */
struct primitive {
    enum kind kind;
    struct pbnds_conv conv;
    int threads; /* baked in when it is made */
    enum form form;
    dnnl_primitive_t run;
    dnnl_memory_desc_t weights_desc;
    size_t scratchpad_size;
    dnnl_memory_t x, weights, bias, y, scratchpad; /* x and y, or their gradients */
    dnnl_primitive_t unblock; /* weights gradient -> plain, or NULL */
    dnnl_memory_t plain;
    struct primitive *next;
};

/** Weights in the format of some primitive. */
struct copy {
    const float *weight;
    bool transposed;
    enum form form;
    dnnl_memory_desc_t desc;
    uint64_t generation; /* of the weights it holds */
    dnnl_primitive_t reorder;
    dnnl_memory_t from, to;
    void *data;
    struct copy *next;
};

/** Room that grows and is kept. */
struct room {
    void *data;
    size_t size;
};

struct dnn {
    struct pbnds_backend base;
    dnnl_engine_t engine;
    dnnl_stream_t stream;
    struct primitive *primitives[BUCKETS];
    int primitive_count;
    struct copy *copies[BUCKETS];
    uint64_t generation;
    struct room scratchpad, deep, blocked, plain, bias;
};

static struct dnn *self(struct pbnds_backend *b)
{
    return (struct dnn *)b;
}

static enum pbnds_status refused(const struct pbnds_conv *c, const char *what,
                                 dnnl_status_t status, struct pbnds_error *error)
{
    const char *type = c->dtype == PBNDS_BF16 ? "bfloat16" : "float32";
    if (status == dnnl_unimplemented && c->dtype == PBNDS_BF16) {
        return pbnds_fail(
            error, PBNDS_ERROR_UNSUPPORTED,
            "oneDNN: this processor has no bfloat16 convolutions, use float32");
    }
    return pbnds_fail(
        error, status == dnnl_out_of_memory ? PBNDS_ERROR_MEMORY : PBNDS_ERROR_BACKEND,
        "oneDNN: %s refused (status %d) for a %s %dx%d convolution, %d to %d "
        "channels, of %d x %d x %d",
        what, (int)status, type, c->kernel, c->kernel, c->in, c->out, c->n, c->h, c->w);
}

static enum pbnds_status grow(struct room *room, size_t size, struct pbnds_error *error)
{
    if (room->size >= size && room->data) return PBNDS_OK;
    free(room->data);
    const size_t rounded = (size / ALIGNMENT + 1) * ALIGNMENT;
    room->data = aligned_alloc(ALIGNMENT, rounded);
    room->size = room->data ? rounded : 0;
    if (room->data) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "oneDNN: no memory for %zu work bytes",
                      size);
}

/* --- descriptors ------------------------------------------------------------------ */

static dnnl_data_type_t data_type(enum pbnds_dtype dtype)
{
    return dtype == PBNDS_BF16 ? dnnl_bf16 : dnnl_f32;
}

static dnnl_status_t activations_desc(dnnl_memory_desc_t *desc, enum pbnds_dtype dtype,
                                      int n, int channels, int h, int w)
{
    const dnnl_dims_t dims = {n, channels, h, w};
    return dnnl_memory_desc_init_by_tag(desc, 4, dims, data_type(dtype), dnnl_nhwc);
}

struct descs {
    dnnl_memory_desc_t x, weights, bias, y;
    dnnl_dims_t strides, before, after;
};

/** weights_type: that of the weights, or of their gradient. */
static dnnl_status_t describe(const struct pbnds_conv *c, dnnl_data_type_t weights_type,
                              struct descs *d)
{
    const int oh = pbnds_conv_out_h(c), ow = pbnds_conv_out_w(c),
              pad = pbnds_conv_pad(c);
    const dnnl_dims_t weights = {c->out, c->in, c->kernel, c->kernel}, bias = {c->out};
    d->strides[0] = d->strides[1] = c->stride;
    d->before[0] = d->before[1] = pad;
    d->after[0] = (oh - 1) * c->stride + c->kernel - pad - c->h;
    d->after[1] = (ow - 1) * c->stride + c->kernel - pad - c->w;
    dnnl_status_t s = activations_desc(&d->x, c->dtype, c->n, c->in, c->h, c->w);
    if (s == dnnl_success) s = activations_desc(&d->y, c->dtype, c->n, c->out, oh, ow);
    if (s == dnnl_success) {
        s = dnnl_memory_desc_init_by_tag(&d->weights, 4, weights, weights_type,
                                         dnnl_format_tag_any);
    }
    if (s == dnnl_success) {
        s = dnnl_memory_desc_init_by_tag(&d->bias, 1, bias, dnnl_f32, dnnl_x);
    }
    return s;
}

/** Attributes: our scratchpad (one for all primitives), and relu after the sum. */
static dnnl_status_t make_attributes(bool relu, dnnl_primitive_attr_t *attr)
{
    dnnl_post_ops_t post = NULL;
    dnnl_status_t s = dnnl_primitive_attr_create(attr);
    if (s == dnnl_success) {
        s = dnnl_primitive_attr_set_scratchpad_mode(*attr, dnnl_scratchpad_mode_user);
    }
    if (s == dnnl_success && relu) {
        s = dnnl_post_ops_create(&post);
        if (s == dnnl_success) {
            s = dnnl_post_ops_append_eltwise(post, 1.0f, dnnl_eltwise_relu, 0.0f, 0.0f);
        }
        if (s == dnnl_success) s = dnnl_primitive_attr_set_post_ops(*attr, post);
        if (post) dnnl_post_ops_destroy(post);
    }
    return s;
}

static dnnl_status_t describe_forward(struct dnn *dnn, const struct pbnds_conv *c,
                                      bool relu, bool bias, dnnl_primitive_desc_t *out)
{
    struct descs d;
    dnnl_convolution_desc_t op;
    dnnl_primitive_attr_t attr = NULL;
    dnnl_status_t s = describe(c, data_type(c->dtype), &d);
    if (s == dnnl_success) {
        s = dnnl_convolution_forward_desc_init(
            &op, dnnl_forward_training, dnnl_convolution_direct, &d.x, &d.weights,
            bias ? &d.bias : NULL, &d.y, d.strides, d.before, d.after);
    }
    if (s == dnnl_success) s = make_attributes(relu, &attr);
    if (s == dnnl_success) {
        s = dnnl_primitive_desc_create(out, &op, attr, dnn->engine, NULL);
    }
    if (attr) dnnl_primitive_attr_destroy(attr);
    return s;
}

static dnnl_status_t describe_backward(struct dnn *dnn, const struct pbnds_conv *c,
                                       enum kind kind, dnnl_primitive_desc_t *out)
{
    struct descs d;
    dnnl_convolution_desc_t op;
    dnnl_primitive_attr_t attr = NULL;
    dnnl_primitive_desc_t hint = NULL;
    const bool data = kind == BACKWARD_DATA;
    dnnl_status_t s = describe(c, data ? data_type(c->dtype) : dnnl_f32, &d);
    if (s == dnnl_success && data) {
        s = dnnl_convolution_backward_data_desc_init(&op, dnnl_convolution_direct, &d.x,
                                                     &d.weights, &d.y, d.strides,
                                                     d.before, d.after);
    } else if (s == dnnl_success) {
        s = dnnl_convolution_backward_weights_desc_init(&op, dnnl_convolution_direct,
                                                        &d.x, &d.weights, &d.bias, &d.y,
                                                        d.strides, d.before, d.after);
    }
    if (s == dnnl_success) s = make_attributes(false, &attr);
    if (s == dnnl_success) s = describe_forward(dnn, c, false, true, &hint);
    if (s == dnnl_success) {
        s = dnnl_primitive_desc_create(out, &op, attr, dnn->engine, hint);
    }
    if (hint) dnnl_primitive_desc_destroy(hint);
    if (attr) dnnl_primitive_attr_destroy(attr);
    return s;
}

/** dW[o, i] = sum_p dY[p, o] X[p, i]: the weights gradient of a 1x1 as one product. The
 *  "x" of the primitive is dY transposed by its strides, the "weights" X. */
static dnnl_status_t describe_product(struct dnn *dnn, const struct pbnds_conv *c,
                                      dnnl_primitive_desc_t *out)
{
    const dnnl_dim_t pixels = (dnnl_dim_t)c->n * c->h * c->w;
    const dnnl_dims_t a = {c->out, pixels}, b = {pixels, c->in}, to = {c->out, c->in};
    dnnl_memory_desc_t a_desc, b_desc, to_desc;
    dnnl_matmul_desc_t op;
    dnnl_primitive_attr_t attr = NULL;
    dnnl_status_t s =
        dnnl_memory_desc_init_by_tag(&a_desc, 2, a, data_type(c->dtype), dnnl_ba);
    if (s == dnnl_success) {
        s = dnnl_memory_desc_init_by_tag(&b_desc, 2, b, data_type(c->dtype), dnnl_ab);
    }
    if (s == dnnl_success) {
        s = dnnl_memory_desc_init_by_tag(&to_desc, 2, to, dnnl_f32, dnnl_ab);
    }
    if (s == dnnl_success) {
        s = dnnl_matmul_desc_init(&op, &a_desc, &b_desc, NULL, &to_desc);
    }
    if (s == dnnl_success) s = make_attributes(false, &attr);
    if (s == dnnl_success) {
        s = dnnl_primitive_desc_create(out, &op, attr, dnn->engine, NULL);
    }
    if (attr) dnnl_primitive_attr_destroy(attr);
    return s;
}

/* --- primitives ------------------------------------------------------------------- */

static void free_primitive(struct primitive *p)
{
    dnnl_memory_t memories[] = {p->x, p->weights,    p->bias,
                                p->y, p->scratchpad, p->plain};
    for (size_t i = 0; i < sizeof memories / sizeof *memories; ++i) {
        if (memories[i]) dnnl_memory_destroy(memories[i]);
    }
    if (p->unblock) dnnl_primitive_destroy(p->unblock);
    if (p->run) dnnl_primitive_destroy(p->run);
    free(p);
}

static void drop_primitives(struct dnn *dnn)
{
    for (int i = 0; i < BUCKETS; ++i) {
        for (struct primitive *p = dnn->primitives[i], *next; p; p = next) {
            next = p->next;
            free_primitive(p);
        }
        dnn->primitives[i] = NULL;
    }
    dnn->primitive_count = 0;
}

static dnnl_status_t make_memory(struct dnn *dnn, const dnnl_memory_desc_t *desc,
                                 dnnl_memory_t *memory)
{
    return dnnl_memory_create(memory, desc, dnn->engine, DNNL_MEMORY_NONE);
}

static dnnl_status_t make_queried(struct dnn *dnn, dnnl_primitive_desc_t desc,
                                  dnnl_query_t what, int index, dnnl_memory_t *memory)
{
    return make_memory(dnn, dnnl_primitive_desc_query_md(desc, what, index), memory);
}

static dnnl_status_t make_reorder(struct dnn *dnn, const dnnl_memory_desc_t *from,
                                  const dnnl_memory_desc_t *to,
                                  dnnl_primitive_t *reorder)
{
    dnnl_primitive_desc_t desc;
    dnnl_status_t s = dnnl_reorder_primitive_desc_create(&desc, from, dnn->engine, to,
                                                         dnn->engine, NULL);
    if (s != dnnl_success) return s;
    s = dnnl_primitive_create(reorder, desc);
    dnnl_primitive_desc_destroy(desc);
    return s;
}

/** Weights as the caller has them (or as the 1x1 of a transposed convolution), seen
 * with the dimensions of the primitive. */
static dnnl_status_t plain_weights_desc(const struct primitive *p,
                                        dnnl_memory_desc_t *d)
{
    const struct pbnds_conv *c = &p->conv;
    const dnnl_dims_t dims = {c->out, c->in, c->kernel, c->kernel};
    const dnnl_dims_t swapped = {c->in, c->out, 1, 1}, strides = {1, c->in, 1, 1};
    if (p->form == SWAPPED) {
        return dnnl_memory_desc_init_by_strides(d, 4, swapped, dnnl_f32, strides);
    }
    return dnnl_memory_desc_init_by_tag(d, 4, dims, dnnl_f32, dnnl_oihw);
}

/** The way back from the primitive's own format of a weights gradient. */
static dnnl_status_t make_unblock(struct dnn *dnn, struct primitive *p)
{
    dnnl_memory_desc_t plain;
    dnnl_status_t s = plain_weights_desc(p, &plain);
    if (s != dnnl_success || p->form == PRODUCT) return s;
    if (dnnl_memory_desc_equal(&plain, &p->weights_desc)) return s;
    s = make_memory(dnn, &plain, &p->plain);
    if (s == dnnl_success) s = make_reorder(dnn, &p->weights_desc, &plain, &p->unblock);
    return s;
}

/** Which row of the two tables of arguments: by kind, or by form. */
enum { PRODUCT_ROW = 3, SWAPPED_ROW = 4 };

static int argument_row(const struct primitive *p)
{
    return p->form == CONVOLUTION ? (int)p->kind
           : p->form == PRODUCT   ? PRODUCT_ROW
                                  : SWAPPED_ROW;
}

static dnnl_status_t make_arguments(struct dnn *dnn, struct primitive *p,
                                    dnnl_primitive_desc_t desc)
{
    static const struct {
        dnnl_query_t x, weights, bias, y;
    } of[] = {
        {dnnl_query_src_md, dnnl_query_weights_md, dnnl_query_weights_md,
         dnnl_query_dst_md},
        {dnnl_query_diff_src_md, dnnl_query_weights_md, dnnl_query_undef,
         dnnl_query_diff_dst_md},
        {dnnl_query_src_md, dnnl_query_diff_weights_md, dnnl_query_diff_weights_md,
         dnnl_query_diff_dst_md},
        [PRODUCT_ROW] = {dnnl_query_weights_md, dnnl_query_dst_md, dnnl_query_undef,
                         dnnl_query_src_md},
        [SWAPPED_ROW] = {dnnl_query_dst_md, dnnl_query_weights_md, dnnl_query_undef,
                         dnnl_query_src_md},
    };
    const int i = argument_row(p);
    p->weights_desc = *dnnl_primitive_desc_query_md(desc, of[i].weights, 0);
    const dnnl_memory_desc_t *scratchpad =
        dnnl_primitive_desc_query_md(desc, dnnl_query_scratchpad_md, 0);
    p->scratchpad_size = dnnl_memory_desc_get_size(scratchpad);
    dnnl_status_t s = make_queried(dnn, desc, of[i].x, 0, &p->x);
    if (s == dnnl_success) s = make_queried(dnn, desc, of[i].y, 0, &p->y);
    if (s == dnnl_success) s = make_queried(dnn, desc, of[i].weights, 0, &p->weights);
    if (s == dnnl_success && of[i].bias != dnnl_query_undef) {
        s = make_queried(dnn, desc, of[i].bias, 1, &p->bias);
    }
    if (s == dnnl_success) s = make_memory(dnn, scratchpad, &p->scratchpad);
    if (s == dnnl_success && p->kind == BACKWARD_WEIGHTS) s = make_unblock(dnn, p);
    return s;
}

static dnnl_status_t make_primitive(struct dnn *dnn, struct primitive *p)
{
    dnnl_primitive_desc_t desc = NULL;
    dnnl_status_t s = dnnl_success;
    if (p->form == PRODUCT) {
        s = describe_product(dnn, &p->conv, &desc);
    } else if (p->form == SWAPPED) {
        struct pbnds_conv swapped = p->conv;
        swapped.in = p->conv.out;
        swapped.out = p->conv.in;
        s = describe_forward(dnn, &swapped, false, false, &desc);
    } else if (p->kind == FORWARD) {
        s = describe_forward(dnn, &p->conv, p->conv.relu, true, &desc);
    } else {
        s = describe_backward(dnn, &p->conv, p->kind, &desc);
    }
    if (s != dnnl_success) return s;
    s = dnnl_primitive_create(&p->run, desc);
    if (s == dnnl_success) s = make_arguments(dnn, p, desc);
    dnnl_primitive_desc_destroy(desc);
    return s;
}

static bool same_primitive(const struct primitive *a, const struct primitive *b)
{
    const struct pbnds_conv *c = &a->conv, *d = &b->conv;
    return a->kind == b->kind && a->threads == b->threads && c->n == d->n &&
           c->h == d->h && c->w == d->w && c->in == d->in && c->out == d->out &&
           c->kernel == d->kernel && c->stride == d->stride && c->relu == d->relu &&
           c->dtype == d->dtype;
}

static size_t primitive_bucket(const struct primitive *p)
{
    const struct pbnds_conv *c = &p->conv;
    const int words[] = {(int)p->kind, p->threads, c->n,         c->h,
                         c->w,         c->in,      c->out,       c->kernel,
                         c->stride,    c->relu,    (int)c->dtype};
    uint64_t hash = UINT64_C(0xcbf29ce484222325); /* FNV-1a */
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        hash = (hash ^ (uint64_t)words[i]) * UINT64_C(0x100000001b3);
    }
    return (size_t)(hash >> 32) % BUCKETS;
}

/** Where the matrix product beat the convolution's weights gradient, as measured. */
static bool better_as_product(const struct pbnds_conv *c)
{
    return c->dtype == PBNDS_BF16 && c->kernel == 1 && c->out >= 64 && c->in >= 32;
}

static enum pbnds_status find_primitive(struct dnn *dnn, enum kind kind,
                                        const struct pbnds_conv *c,
                                        struct primitive **out,
                                        struct pbnds_error *error)
{
    struct primitive key = {.kind = kind, .conv = *c, .threads = pbnds_threads()};
    if (kind != FORWARD) key.conv.relu = false;
    if (kind == BACKWARD_DATA && c->kernel == 1) key.form = SWAPPED;
    if (kind == BACKWARD_WEIGHTS && better_as_product(c)) key.form = PRODUCT;
    const size_t bucket = primitive_bucket(&key);
    for (struct primitive *p = dnn->primitives[bucket]; p; p = p->next) {
        if (same_primitive(p, &key)) {
            *out = p;
            return PBNDS_OK;
        }
    }
    if (dnn->primitive_count >= MAX_PRIMITIVES) drop_primitives(dnn);
    struct primitive *p = malloc(sizeof *p);
    if (!p)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "oneDNN: no memory for a primitive");
    *p = key;
    const dnnl_status_t s = make_primitive(dnn, p);
    if (s != dnnl_success) {
        free_primitive(p);
        return refused(c, "making a primitive", s, error);
    }
    p->next = dnn->primitives[bucket];
    dnn->primitives[bucket] = p;
    ++dnn->primitive_count;
    *out = p;
    return PBNDS_OK;
}

/* --- weights ---------------------------------------------------------------------- */

static void free_copy(struct copy *c)
{
    if (c->reorder) dnnl_primitive_destroy(c->reorder);
    if (c->from) dnnl_memory_destroy(c->from);
    if (c->to) dnnl_memory_destroy(c->to);
    free(c->data);
    free(c);
}

/** Frees copies older than two changes of the weights: their network is gone. */
static void drop_stale_copies(struct dnn *dnn, uint64_t keep_from)
{
    for (int i = 0; i < BUCKETS; ++i) {
        for (struct copy **link = &dnn->copies[i]; *link;) {
            struct copy *c = *link;
            if (c->generation >= keep_from) {
                link = &c->next;
            } else {
                *link = c->next;
                free_copy(c);
            }
        }
    }
}

static enum pbnds_status make_copy(struct dnn *dnn, const struct primitive *p,
                                   const float *weight, bool transposed,
                                   struct copy **out, struct pbnds_error *error)
{
    struct copy *c = calloc(1, sizeof *c);
    if (!c)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "oneDNN: no memory for weights");
    c->weight = weight;
    c->transposed = transposed;
    c->form = p->form;
    c->desc = p->weights_desc;
    struct room room = {NULL, 0};
    const enum pbnds_status status =
        grow(&room, dnnl_memory_desc_get_size(&c->desc), error);
    c->data = room.data;
    if (status != PBNDS_OK) {
        free_copy(c);
        return status;
    }
    dnnl_memory_desc_t plain;
    dnnl_status_t s = plain_weights_desc(p, &plain);
    if (s == dnnl_success) s = make_memory(dnn, &plain, &c->from);
    if (s == dnnl_success) s = make_memory(dnn, &c->desc, &c->to);
    if (s == dnnl_success) s = dnnl_memory_set_data_handle(c->to, c->data);
    if (s == dnnl_success) s = make_reorder(dnn, &plain, &c->desc, &c->reorder);
    if (s != dnnl_success) {
        free_copy(c);
        return refused(&p->conv, "reordering weights", s, error);
    }
    *out = c;
    return PBNDS_OK;
}

static enum pbnds_status fill_copy(struct dnn *dnn, struct copy *c,
                                   const struct pbnds_conv *conv,
                                   struct pbnds_error *error)
{
    const float *from = c->weight;
    if (conv->transposed) {
        PBNDS_TRY(
            grow(&dnn->plain, pbnds_conv_weight_count(conv) * sizeof(float), error));
        pbnds_conv_up_weight_to_1x1(conv, c->weight, dnn->plain.data);
        from = dnn->plain.data;
    }
    /* The handle is not const, the reorder only reads it. */
    dnnl_status_t s = dnnl_memory_set_data_handle(c->from, (void *)(uintptr_t)from);
    const dnnl_exec_arg_t args[] = {{DNNL_ARG_FROM, c->from}, {DNNL_ARG_TO, c->to}};
    if (s == dnnl_success) s = dnnl_primitive_execute(c->reorder, dnn->stream, 2, args);
    if (s == dnnl_success) s = dnnl_stream_wait(dnn->stream);
    if (s != dnnl_success) return refused(conv, "reordering weights", s, error);
    c->generation = dnn->generation;
    return PBNDS_OK;
}

/** The weights in the primitive's format. `conv` is the caller's convolution. */
static enum pbnds_status find_weights(struct dnn *dnn, const struct primitive *p,
                                      const struct pbnds_conv *conv,
                                      const float *weight, void **data,
                                      struct pbnds_error *error)
{
    const size_t bucket = (size_t)((uintptr_t)weight / sizeof(float)) % BUCKETS;
    struct copy *c = dnn->copies[bucket];
    while (c && (c->weight != weight || c->transposed != conv->transposed ||
                 c->form != p->form ||
                 !dnnl_memory_desc_equal(&c->desc, &p->weights_desc))) {
        c = c->next;
    }
    if (!c) {
        drop_stale_copies(dnn, dnn->generation > 2 ? dnn->generation - 2 : 0);
        PBNDS_TRY(make_copy(dnn, p, weight, conv->transposed, &c, error));
        c->next = dnn->copies[bucket];
        dnn->copies[bucket] = c;
    }
    if (c->generation != dnn->generation) PBNDS_TRY(fill_copy(dnn, c, conv, error));
    *data = c->data;
    return PBNDS_OK;
}

static void weights_changed(struct pbnds_backend *b)
{
    ++self(b)->generation;
}

/* --- running ---------------------------------------------------------------------- */

/** Hangs the arguments on the primitive's memory objects and runs it. Those it only
 * reads lose their const: a memory object has none. */
static enum pbnds_status run(struct dnn *dnn, struct primitive *p, const void *x,
                             const void *weights, const void *bias, const void *y,
                             struct pbnds_error *error)
{
    static const int name[][4] = {
        {DNNL_ARG_SRC, DNNL_ARG_WEIGHTS, DNNL_ARG_BIAS, DNNL_ARG_DST},
        {DNNL_ARG_DIFF_SRC, DNNL_ARG_WEIGHTS, DNNL_ARG_BIAS, DNNL_ARG_DIFF_DST},
        {DNNL_ARG_SRC, DNNL_ARG_DIFF_WEIGHTS, DNNL_ARG_DIFF_BIAS, DNNL_ARG_DIFF_DST},
        [PRODUCT_ROW] = {DNNL_ARG_WEIGHTS, DNNL_ARG_DST, DNNL_ARG_BIAS, DNNL_ARG_SRC},
        [SWAPPED_ROW] = {DNNL_ARG_DST, DNNL_ARG_WEIGHTS, DNNL_ARG_BIAS, DNNL_ARG_SRC},
    };
    PBNDS_TRY(grow(&dnn->scratchpad, p->scratchpad_size, error));
    const int *names = name[argument_row(p)];
    const dnnl_memory_t memory[] = {p->x, p->weights, p->bias, p->y};
    const void *data[] = {x, weights, bias, y};
    dnnl_exec_arg_t args[5] = {{DNNL_ARG_SCRATCHPAD, p->scratchpad}};
    int count = 1;
    dnnl_status_t s = dnnl_memory_set_data_handle(p->scratchpad, dnn->scratchpad.data);
    for (int i = 0; i < 4 && s == dnnl_success; ++i) {
        if (!memory[i]) continue;
        s = dnnl_memory_set_data_handle(memory[i], (void *)(uintptr_t)data[i]);
        args[count].arg = names[i];
        args[count++].memory = memory[i];
    }
    if (s == dnnl_success) s = dnnl_primitive_execute(p->run, dnn->stream, count, args);
    if (s == dnnl_success) s = dnnl_stream_wait(dnn->stream);
    return s == dnnl_success ? PBNDS_OK : refused(&p->conv, "running", s, error);
}

static size_t out_bytes(const struct pbnds_conv *c)
{
    return (size_t)c->n * (size_t)pbnds_conv_out_h(c) * (size_t)pbnds_conv_out_w(c) *
           (size_t)c->out * pbnds_dtype_size(c->dtype);
}

static enum pbnds_status conv_forward(struct pbnds_backend *b,
                                      const struct pbnds_conv *c, const void *x,
                                      const float *weight, const float *bias, void *y,
                                      struct pbnds_error *error)
{
    struct dnn *dnn = self(b);
    struct pbnds_conv plain = *c;
    struct primitive *p;
    void *weights, *out = y;
    PBNDS_TRY(pbnds_conv_check(c, error));
    if (c->transposed) {
        plain = pbnds_conv_up_as_1x1(c);
        PBNDS_TRY(grow(&dnn->deep, out_bytes(c), error));
        PBNDS_TRY(grow(&dnn->bias, 4 * (size_t)c->out * sizeof(float), error));
        pbnds_conv_up_bias_to_1x1(c, bias, dnn->bias.data);
        bias = dnn->bias.data;
        out = dnn->deep.data;
    }
    PBNDS_TRY(find_primitive(dnn, FORWARD, &plain, &p, error));
    PBNDS_TRY(find_weights(dnn, p, c, weight, &weights, error));
    PBNDS_TRY(run(dnn, p, x, weights, bias, out, error));
    if (c->transposed) pbnds_conv_depth_to_space(c, out, y);
    return PBNDS_OK;
}

/** dy as the plain convolution wants it. */
static enum pbnds_status gather_dy(struct dnn *dnn, const struct pbnds_conv *c,
                                   const void **dy, struct pbnds_error *error)
{
    if (!c->transposed) return PBNDS_OK;
    PBNDS_TRY(grow(&dnn->deep, out_bytes(c), error));
    pbnds_conv_space_to_depth(c, *dy, dnn->deep.data);
    *dy = dnn->deep.data;
    return PBNDS_OK;
}

static enum pbnds_status conv_backward_data(struct pbnds_backend *b,
                                            const struct pbnds_conv *c, const void *dy,
                                            const float *weight, void *dx,
                                            struct pbnds_error *error)
{
    struct dnn *dnn = self(b);
    struct primitive *p;
    void *weights;
    PBNDS_TRY(pbnds_conv_check(c, error));
    const struct pbnds_conv plain = c->transposed ? pbnds_conv_up_as_1x1(c) : *c;
    PBNDS_TRY(gather_dy(dnn, c, &dy, error));
    PBNDS_TRY(find_primitive(dnn, BACKWARD_DATA, &plain, &p, error));
    PBNDS_TRY(find_weights(dnn, p, c, weight, &weights, error));
    return run(dnn, p, dx, weights, NULL, dy, error);
}

/** The gradient in plain oihw, from the primitive's own format. */
static enum pbnds_status unblock(struct dnn *dnn, struct primitive *p, const float **dw,
                                 struct pbnds_error *error)
{
    *dw = dnn->blocked.data;
    if (!p->unblock) return PBNDS_OK;
    PBNDS_TRY(
        grow(&dnn->plain, pbnds_conv_weight_count(&p->conv) * sizeof(float), error));
    const dnnl_exec_arg_t args[] = {{DNNL_ARG_FROM, p->weights},
                                    {DNNL_ARG_TO, p->plain}};
    dnnl_status_t s = dnnl_memory_set_data_handle(p->plain, dnn->plain.data);
    if (s == dnnl_success) s = dnnl_primitive_execute(p->unblock, dnn->stream, 2, args);
    if (s == dnnl_success) s = dnnl_stream_wait(dnn->stream);
    if (s != dnnl_success) return refused(&p->conv, "reordering a gradient", s, error);
    *dw = dnn->plain.data;
    return PBNDS_OK;
}

static enum pbnds_status conv_backward_weights(struct pbnds_backend *b,
                                               const struct pbnds_conv *c,
                                               const void *x, const void *dy,
                                               float *dweight, float *dbias,
                                               struct pbnds_error *error)
{
    struct dnn *dnn = self(b);
    struct primitive *p;
    const float *dw;
    PBNDS_TRY(pbnds_conv_check(c, error));
    const struct pbnds_conv plain = c->transposed ? pbnds_conv_up_as_1x1(c) : *c;
    const size_t bias_bytes = (size_t)plain.out * sizeof(float);
    PBNDS_TRY(gather_dy(dnn, c, &dy, error));
    PBNDS_TRY(find_primitive(dnn, BACKWARD_WEIGHTS, &plain, &p, error));
    PBNDS_TRY(grow(&dnn->blocked, dnnl_memory_desc_get_size(&p->weights_desc), error));
    PBNDS_TRY(grow(&dnn->bias, bias_bytes, error));
    float *db = dnn->bias.data;
    memset(db, 0, bias_bytes);
    PBNDS_TRY(run(dnn, p, x, dnn->blocked.data, db, dy, error));
    if (p->form == PRODUCT) {
        PBNDS_TRY(pbnds_conv_bias_gradient(dy, c->dtype,
                                           (size_t)c->n * (size_t)c->h * (size_t)c->w,
                                           plain.out, db, error));
    }
    PBNDS_TRY(unblock(dnn, p, &dw, error));
    if (c->transposed) {
        pbnds_conv_up_weight_from_1x1(c, dw, dweight);
        pbnds_conv_up_bias_from_1x1(c, db, dbias);
        return PBNDS_OK;
    }
    for (size_t k = 0; k < pbnds_conv_weight_count(c); ++k)
        dweight[k] += dw[k];
    for (int o = 0; o < c->out; ++o)
        dbias[o] += db[o];
    return PBNDS_OK;
}

/* --- the backend ------------------------------------------------------------------ */

static void destroy(struct pbnds_backend *b)
{
    struct dnn *dnn = self(b);
    drop_primitives(dnn);
    drop_stale_copies(dnn, UINT64_MAX);
    if (dnn->stream) dnnl_stream_destroy(dnn->stream);
    if (dnn->engine) dnnl_engine_destroy(dnn->engine);
    free(dnn->scratchpad.data);
    free(dnn->deep.data);
    free(dnn->blocked.data);
    free(dnn->plain.data);
    free(dnn->bias.data);
    free(dnn);
}

enum pbnds_status pbnds_backend_create_onednn(struct pbnds_backend **backend,
                                              struct pbnds_error *error)
{
    static const struct pbnds_backend_ops ops = {
        "onednn",        conv_forward, conv_backward_data, conv_backward_weights,
        weights_changed, destroy};
    *backend = NULL;
    struct dnn *dnn = calloc(1, sizeof *dnn);
    if (!dnn) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "oneDNN: no memory");
    dnn->base.ops = &ops;
    dnn->generation = 1; /* a fresh copy holds generation 0: nothing yet */
    dnnl_status_t s = dnnl_engine_create(&dnn->engine, dnnl_cpu, 0);
    if (s == dnnl_success) {
        s = dnnl_stream_create(&dnn->stream, dnn->engine, dnnl_stream_default_flags);
    }
    if (s != dnnl_success) {
        destroy(&dnn->base);
        return pbnds_fail(
            error, PBNDS_ERROR_BACKEND,
            "oneDNN: no CPU engine (status %d), use the reference backend", (int)s);
    }
    *backend = &dnn->base;
    return PBNDS_OK;
}

bool pbnds_backend_has_fast_bf16(void)
{
    return dnnl_get_effective_cpu_isa() >= dnnl_cpu_isa_avx512_core_amx &&
           dnnl_get_effective_cpu_isa() != dnnl_cpu_isa_avx2_vnni;
}
