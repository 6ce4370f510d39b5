/* Runs the table: forward of each scope, and backward in the reverse order.
 *
 * An activation is given back to the arena after its last reader, unless the backward
 * pass or the light scope wants it. Gradients exist from the first contribution to a
 * row until the row itself is differentiated. What light chunks add to a view tensor is
 * summed in float32 over lights and chunks, and enters once in the view's backward. */
#include <limits.h>
#include <stdint.h>
#include <string.h>

#include "engine/core/report.h"
#include "engine/core/rng.h"
#include "neural/backend/dtype.h"
#include "neural/layers/net_internal.h"

/** One run over one scope. */
struct run {
    struct pbnds_net *net;
    const struct pbnds_pass *pass;
    bool light;
    int images;      /* of the scope: B, or B N */
    int output;      /* row of the table, -1 for none */
    const float *in; /* of the input row */
    float *out;      /* of the output row, or NULL */
    struct pbnds_error *error;
};

static int mode_of(const struct pbnds_pass *pass)
{
    return pass->train ? PBNDS_MODE_TRAIN : PBNDS_MODE_INFERENCE;
}

static struct pbnds_shape row_shape(const struct run *run, int r)
{
    const struct pbnds_row *row = &run->net->rows[r];
    const int images = row->light ? run->images : run->pass->batch;
    return (struct pbnds_shape){(size_t)images, (size_t)(run->pass->h >> row->level),
                                (size_t)(run->pass->w >> row->level),
                                (size_t)row->channels};
}

/** How many images of this scope read one image of row r. */
static size_t repeat(const struct run *run, int r)
{
    return run->light && !run->net->rows[r].light ? (size_t)run->pass->lights : 1;
}

static void *block(const struct pbnds_net *net, int i)
{
    return i < 0 ? NULL : net->arena.blocks[i].data;
}

static void give(struct pbnds_net *net, int *slot)
{
    if (*slot >= 0) pbnds_arena_give(&net->arena, *slot);
    *slot = -1;
}

static enum pbnds_status take(const struct run *run, int r, size_t element, int *slot)
{
    const size_t size = pbnds_shape_count(row_shape(run, r)) * element;
    *slot = pbnds_arena_take(&run->net->arena, size);
    if (*slot >= 0) return PBNDS_OK;
    return pbnds_fail(
        run->error, PBNDS_ERROR_MEMORY,
        "network: no memory for %zu bytes of \"%s\", use fewer lights a chunk "
        "or smaller tiles",
        size, run->net->table->layers[r].name);
}

/** Activations of row r; in inference those of the row it is a copy of. */
static void *value(const struct run *run, int r)
{
    const struct pbnds_net *net = run->net;
    const bool train =
        net->rows[r].light ? net->light_pass.train : net->view_pass.train;
    return block(net, net->slots[pbnds_row_source(net, r, train)].value);
}

static void drop_scope(struct pbnds_net *net, bool light)
{
    for (int r = 0; r < net->count; ++r) {
        if (net->rows[r].light != light) continue;
        give(net, &net->slots[r].value);
        give(net, &net->slots[r].grad);
        give(net, &net->slots[r].light_sum);
    }
    if (light) {
        net->light_ready = false;
    } else {
        net->view_ready = false;
    }
}

static const float *weight_of(const struct pbnds_net *net, int r, const float *array)
{
    return array + net->list[net->rows[r].weight].offset;
}

static const float *bias_of(const struct pbnds_net *net, int r, const float *array)
{
    return array + net->list[net->rows[r].weight + 1].offset;
}

/** Every view has its own stream of dropout decisions in every layer. */
static void drop(const struct run *run, int r, const void *x, void *y)
{
    const struct pbnds_pass *pass = run->pass;
    const enum pbnds_dtype dtype = run->net->dtype;
    const size_t count = pbnds_shape_count(row_shape(run, r)) / (size_t)pass->batch;
    const size_t bytes = count * pbnds_dtype_size(dtype);
    for (int v = 0; v < pass->batch; ++v) {
        const uint64_t view = (uint64_t)(pass->first_view + v);
        const uint64_t key = pbnds_mix64(pass->dropout_key ^ view << 32);
        pbnds_dropout(dtype, count, pbnds_mix64(key ^ (uint64_t)r),
                      run->net->table->layers[r].rate,
                      (const char *)x + (size_t)v * bytes,
                      (char *)y + (size_t)v * bytes);
    }
}

/* --- forward ---------------------------------------------------------------------- */

static enum pbnds_status forward_input(const struct run *run, int r, void *y)
{
    if (!run->in) {
        return pbnds_fail(run->error, PBNDS_ERROR_ARGUMENT,
                          "network: input \"%s\" is missing",
                          run->net->table->layers[r].name);
    }
    pbnds_from_f32(run->net->dtype, run->in, y, pbnds_shape_count(row_shape(run, r)));
    return PBNDS_OK;
}

static enum pbnds_status forward_conv(const struct run *run, int r, void *y)
{
    struct pbnds_net *net = run->net;
    const struct pbnds_conv c =
        pbnds_row_conv(net, r, run->images, run->pass->h, run->pass->w);
    return net->backend->ops->conv_forward(
        net->backend, &c, value(run, net->rows[r].layer->in[0]),
        weight_of(net, r, net->params), bias_of(net, r, net->params), y, run->error);
}

static void forward_concat(const struct run *run, int r, void *y)
{
    const struct pbnds_net *net = run->net;
    size_t at = 0;
    for (int i = 0; i < 2; ++i) {
        const int in = net->rows[r].layer->in[i];
        struct pbnds_shape part = row_shape(run, in);
        part.images = (size_t)run->images;
        pbnds_channels_insert(net->dtype, part, value(run, in), repeat(run, in), y,
                              (size_t)net->rows[r].channels, at);
        at += part.c;
    }
}

static enum pbnds_status forward_row(const struct run *run, int r)
{
    struct pbnds_net *net = run->net;
    const struct pbnds_layer *layer = net->rows[r].layer;
    const enum pbnds_dtype dtype = net->dtype;
    const struct pbnds_shape shape = row_shape(run, r);
    PBNDS_TRY(take(run, r, pbnds_dtype_size(dtype), &net->slots[r].value));
    void *y = block(net, net->slots[r].value);
    const void *x = net->rows[r].inputs ? value(run, layer->in[0]) : NULL;
    switch (layer->op) {
    case PBNDS_OP_VIEW_INPUT:
    case PBNDS_OP_LIGHT_INPUT:
        return forward_input(run, r, y);
    case PBNDS_OP_CONV:
    case PBNDS_OP_UP:
        return forward_conv(run, r, y);
    case PBNDS_OP_ADD:
        pbnds_add_forward(dtype, shape, x, repeat(run, layer->in[0]),
                          value(run, layer->in[1]), repeat(run, layer->in[1]),
                          layer->act == PBNDS_ACT_RELU, y);
        break;
    case PBNDS_OP_CONCAT:
        forward_concat(run, r, y);
        break;
    case PBNDS_OP_SHUFFLE:
        pbnds_shuffle_forward(dtype, row_shape(run, layer->in[0]), x, y);
        break;
    case PBNDS_OP_POOL:
        pbnds_pool_forward(dtype, shape, x, y);
        break;
    case PBNDS_OP_DROPOUT:
        drop(run, r, x, y);
        break;
    }
    return PBNDS_OK;
}

/** Gives back what nobody reads after row r. */
static void release_after(const struct run *run, int r)
{
    struct pbnds_net *net = run->net;
    const int mode = mode_of(run->pass);
    for (int i = 0; i <= r; ++i) {
        const struct pbnds_row *row = &net->rows[i];
        if (row->light == run->light && row->last_use[mode] <= r && !row->keep[mode]) {
            give(net, &net->slots[i].value);
        }
    }
}

static enum pbnds_status forward_scope(const struct run *run)
{
    struct pbnds_net *net = run->net;
    for (int r = 0; r < net->count; ++r) {
        const struct pbnds_row *row = &net->rows[r];
        if (!row->used || row->light != run->light) continue;
        if (pbnds_row_source(net, r, run->pass->train) == r) {
            PBNDS_TRY(forward_row(run, r));
        }
        if (pbnds_stop_requested()) return pbnds_fail_interrupted(run->error);
        if (r == run->output && run->out) {
            pbnds_to_f32(net->dtype, value(run, r), run->out,
                         pbnds_shape_count(row_shape(run, r)));
        }
        release_after(run, r);
    }
    return PBNDS_OK;
}

/** Sizes are positive, divide by the deepest level and fit. */
static enum pbnds_status check_pass(const struct pbnds_net *net,
                                    const struct pbnds_pass *pass, bool light,
                                    struct pbnds_error *error)
{
    const int unit = 1 << net->deepest;
    if (pass->batch < 1 || pass->h < 1 || pass->w < 1 || (light && pass->lights < 1)) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "network: a pass of %d views, %d lights, %d x %d pixels is empty",
            pass->batch, pass->lights, pass->w, pass->h);
    }
    if (pass->h % unit || pass->w % unit) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "network: %d x %d pixels do not divide by %d", pass->w,
                          pass->h, unit);
    }
    const int64_t images = (int64_t)pass->batch * (light ? pass->lights : 1);
    const double pixels = (double)images * pass->h * pass->w;
    if (images > INT_MAX || pixels * 65536.0 * 4.0 > 0x1p61) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "network: %d views, %d lights, %d x %d pixels are too many",
                          pass->batch, pass->lights, pass->w, pass->h);
    }
    return PBNDS_OK;
}

static bool same_size(const struct pbnds_pass *a, const struct pbnds_pass *b)
{
    return a->batch == b->batch && a->h == b->h && a->w == b->w;
}

enum pbnds_status pbnds_net_forward_view(struct pbnds_net *net,
                                         const struct pbnds_pass *pass,
                                         const float *view_input, float *view_output,
                                         struct pbnds_error *error)
{
    PBNDS_TRY(check_pass(net, pass, false, error));
    drop_scope(net, true);
    drop_scope(net, false);
    if (!same_size(pass, &net->view_pass)) pbnds_arena_trim(&net->arena);
    net->view_pass = *pass;
    const struct run run = {.net = net,
                            .pass = &net->view_pass,
                            .light = false,
                            .images = pass->batch,
                            .output = net->table->view_output,
                            .in = view_input,
                            .out = view_output,
                            .error = error};
    const enum pbnds_status status = forward_scope(&run);
    if (status != PBNDS_OK) drop_scope(net, false);
    net->view_ready = status == PBNDS_OK;
    return status;
}

static enum pbnds_status check_view(const struct pbnds_net *net,
                                    const struct pbnds_pass *pass,
                                    struct pbnds_error *error)
{
    if (!net->has_light) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "network: it has no light scope");
    }
    if (!net->has_view || (net->view_ready && same_size(pass, &net->view_pass))) {
        return PBNDS_OK;
    }
    return pbnds_fail(
        error, PBNDS_ERROR_ARGUMENT,
        "network: run the view scope of %d views, %d x %d pixels before its "
        "lights",
        pass->batch, pass->w, pass->h);
}

enum pbnds_status pbnds_net_forward_light(struct pbnds_net *net,
                                          const struct pbnds_pass *pass,
                                          const float *light_input, float *light_output,
                                          struct pbnds_error *error)
{
    PBNDS_TRY(check_pass(net, pass, true, error));
    PBNDS_TRY(check_view(net, pass, error));
    drop_scope(net, true);
    net->light_pass = *pass;
    const struct run run = {.net = net,
                            .pass = &net->light_pass,
                            .light = true,
                            .images = pass->batch * pass->lights,
                            .output = net->table->light_output,
                            .in = light_input,
                            .out = light_output,
                            .error = error};
    const enum pbnds_status status = forward_scope(&run);
    if (status != PBNDS_OK) drop_scope(net, true);
    net->light_ready = status == PBNDS_OK;
    return status;
}

/* --- backward --------------------------------------------------------------------- */

/** Where a contribution to the gradient of row `row` is written: its first one into the
 *  gradient itself, a later one beside it and then added. */
struct sink {
    int row, slot;
    bool first;
    void *data;
};

static enum pbnds_status open_sink(const struct run *run, int row, struct sink *s)
{
    struct pbnds_net *net = run->net;
    s->row = row;
    s->first = net->slots[row].grad < 0;
    PBNDS_TRY(take(run, row, pbnds_dtype_size(net->dtype), &s->slot));
    s->data = block(net, s->slot);
    return PBNDS_OK;
}

static void close_sink(const struct run *run, struct sink *s)
{
    struct pbnds_net *net = run->net;
    if (s->first) {
        net->slots[s->row].grad = s->slot;
        return;
    }
    pbnds_accumulate(net->dtype, s->data, block(net, net->slots[s->row].grad),
                     pbnds_shape_count(row_shape(run, s->row)));
    give(net, &s->slot);
}

static bool wants_grad(const struct run *run, int row)
{
    return run->net->rows[row].needs_grad;
}

static enum pbnds_status backward_conv(const struct run *run, int r, const void *dy)
{
    struct pbnds_net *net = run->net;
    const int in = net->rows[r].layer->in[0];
    const struct pbnds_param *weight = &net->list[net->rows[r].weight];
    const struct pbnds_conv c =
        pbnds_row_conv(net, r, run->images, run->pass->h, run->pass->w);
    PBNDS_TRY(net->backend->ops->conv_backward_weights(
        net->backend, &c, value(run, in), dy, net->grads + weight[0].offset,
        net->grads + weight[1].offset, run->error));
    if (!wants_grad(run, in)) return PBNDS_OK;
    struct sink sink;
    PBNDS_TRY(open_sink(run, in, &sink));
    const enum pbnds_status status = net->backend->ops->conv_backward_data(
        net->backend, &c, dy, weight_of(net, r, net->params), sink.data, run->error);
    if (status != PBNDS_OK) {
        give(net, &sink.slot);
        return status;
    }
    close_sink(run, &sink);
    return PBNDS_OK;
}

/** dy over the channels [at, at + C) of input row `in` goes to that row: copied, or
 * summed over lights when it was broadcast. */
static enum pbnds_status backward_part(const struct run *run, int in, const void *dy,
                                       size_t dy_channels, size_t at)
{
    struct pbnds_net *net = run->net;
    const struct pbnds_shape part = row_shape(run, in);
    struct sink sink;
    if (!wants_grad(run, in)) return PBNDS_OK;
    if (run->light && !net->rows[in].light) {
        const bool add = net->slots[in].light_sum >= 0;
        if (!add) PBNDS_TRY(take(run, in, sizeof(float), &net->slots[in].light_sum));
        pbnds_sum_lights(net->dtype, part, (size_t)run->pass->lights, dy, dy_channels,
                         at, block(net, net->slots[in].light_sum), add);
        return PBNDS_OK;
    }
    PBNDS_TRY(open_sink(run, in, &sink));
    pbnds_channels_extract(net->dtype, part, dy, dy_channels, at, sink.data);
    close_sink(run, &sink);
    return PBNDS_OK;
}

/** Both inputs get dy; the first may have the block itself. */
static enum pbnds_status backward_add(const struct run *run, int r, const void *dy)
{
    struct pbnds_net *net = run->net;
    const int *in = net->rows[r].layer->in;
    const size_t channels = (size_t)net->rows[r].channels;
    PBNDS_TRY(backward_part(run, in[1], dy, channels, 0));
    const bool same_scope = net->rows[in[0]].light == net->rows[r].light;
    if (same_scope && wants_grad(run, in[0]) && net->slots[in[0]].grad < 0) {
        net->slots[in[0]].grad = net->slots[r].grad;
        net->slots[r].grad = -1;
        return PBNDS_OK;
    }
    return backward_part(run, in[0], dy, channels, 0);
}

static enum pbnds_status backward_concat(const struct run *run, int r, const void *dy)
{
    struct pbnds_net *net = run->net;
    const int *in = net->rows[r].layer->in;
    const size_t channels = (size_t)net->rows[r].channels;
    PBNDS_TRY(backward_part(run, in[0], dy, channels, 0));
    return backward_part(run, in[1], dy, channels, (size_t)net->rows[in[0]].channels);
}

/** The ops of one input without parameters. */
static enum pbnds_status backward_plain(const struct run *run, int r, const void *dy)
{
    struct pbnds_net *net = run->net;
    const struct pbnds_layer *layer = net->rows[r].layer;
    const int in = layer->in[0];
    struct sink sink;
    if (!wants_grad(run, in)) return PBNDS_OK;
    PBNDS_TRY(open_sink(run, in, &sink));
    if (layer->op == PBNDS_OP_SHUFFLE) {
        pbnds_shuffle_backward(net->dtype, row_shape(run, in), dy, sink.data);
    } else if (layer->op == PBNDS_OP_POOL) {
        pbnds_pool_backward(net->dtype, row_shape(run, r), dy, sink.data);
    } else {
        drop(run, r, dy, sink.data);
    }
    close_sink(run, &sink);
    return PBNDS_OK;
}

static enum pbnds_status backward_row(const struct run *run, int r)
{
    struct pbnds_net *net = run->net;
    const struct pbnds_layer *layer = net->rows[r].layer;
    void *dy = block(net, net->slots[r].grad);
    if (layer->act == PBNDS_ACT_RELU) {
        pbnds_relu_mask(net->dtype, value(run, r), dy,
                        pbnds_shape_count(row_shape(run, r)));
    }
    switch (layer->op) {
    case PBNDS_OP_VIEW_INPUT:
    case PBNDS_OP_LIGHT_INPUT:
        return PBNDS_OK;
    case PBNDS_OP_CONV:
    case PBNDS_OP_UP:
        return backward_conv(run, r, dy);
    case PBNDS_OP_ADD:
        return backward_add(run, r, dy);
    case PBNDS_OP_CONCAT:
        return backward_concat(run, r, dy);
    default:
        return backward_plain(run, r, dy);
    }
}

/** Adds what the light chunks found to the gradient of view row r. */
static enum pbnds_status add_light_sum(const struct run *run, int r)
{
    struct pbnds_net *net = run->net;
    const size_t count = pbnds_shape_count(row_shape(run, r));
    struct pbnds_slot *slot = &net->slots[r];
    if (slot->light_sum < 0) return PBNDS_OK;
    if (slot->grad >= 0) {
        pbnds_accumulate_f32(net->dtype, block(net, slot->light_sum),
                             block(net, slot->grad), count);
    } else {
        PBNDS_TRY(take(run, r, pbnds_dtype_size(net->dtype), &slot->grad));
        pbnds_from_f32(net->dtype, block(net, slot->light_sum), block(net, slot->grad),
                       count);
    }
    give(net, &slot->light_sum);
    return PBNDS_OK;
}

/** run->in is dL/d(output). */
static enum pbnds_status backward_scope(const struct run *run)
{
    struct pbnds_net *net = run->net;
    if (run->in && run->output >= 0 && wants_grad(run, run->output)) {
        struct sink sink;
        PBNDS_TRY(open_sink(run, run->output, &sink));
        pbnds_from_f32(net->dtype, run->in, sink.data,
                       pbnds_shape_count(row_shape(run, run->output)));
        close_sink(run, &sink);
    }
    for (int r = net->count - 1; r >= 0; --r) {
        if (net->rows[r].light != run->light) continue;
        PBNDS_TRY(add_light_sum(run, r));
        if (net->slots[r].grad >= 0) PBNDS_TRY(backward_row(run, r));
        if (pbnds_stop_requested()) return pbnds_fail_interrupted(run->error);
        give(net, &net->slots[r].grad);
        give(net, &net->slots[r].value);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_net_backward_light(struct pbnds_net *net,
                                           const struct pbnds_pass *pass,
                                           const float *d_light_output,
                                           struct pbnds_error *error)
{
    if (!net->light_ready || !net->light_pass.train ||
        !same_size(pass, &net->light_pass) || pass->lights != net->light_pass.lights ||
        (net->has_view && (!net->view_ready || !net->view_pass.train))) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "network: backward of %d lights without a forward of them with "
            "train set",
            pass->lights);
    }
    const struct run run = {.net = net,
                            .pass = &net->light_pass,
                            .light = true,
                            .images = pass->batch * pass->lights,
                            .output = net->table->light_output,
                            .in = d_light_output,
                            .error = error};
    const enum pbnds_status status = backward_scope(&run);
    drop_scope(net, true);
    return status;
}

enum pbnds_status pbnds_net_backward_view(struct pbnds_net *net,
                                          const struct pbnds_pass *pass,
                                          const float *d_view_output,
                                          struct pbnds_error *error)
{
    if (!net->view_ready || !net->view_pass.train ||
        !same_size(pass, &net->view_pass)) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "network: backward of %d views without a forward of them with "
            "train set",
            pass->batch);
    }
    drop_scope(net, true);
    const struct run run = {.net = net,
                            .pass = &net->view_pass,
                            .light = false,
                            .images = pass->batch,
                            .output = net->table->view_output,
                            .in = d_view_output,
                            .error = error};
    const enum pbnds_status status = backward_scope(&run);
    drop_scope(net, false);
    return status;
}
