/* Checks a table of layers and derives shapes, scopes and lifetimes from it. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "neural/layers/net_internal.h"

enum { MAX_CHANNELS = 65536, MAX_LEVEL = 16, MAX_NAME = 80 };

PBNDS_PRINTF(4, 5)
static enum pbnds_status fault(const struct pbnds_net *net, int r,
                               struct pbnds_error *error, const char *format, ...)
{
    char text[512];
    const char *name = net->table->layers[r].name;
    va_list args;
    va_start(args, format);
    (void)vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                      "network table: row %d \"%.80s\": %s", r, name ? name : "", text);
}

static bool is_input(enum pbnds_op op)
{
    return op == PBNDS_OP_VIEW_INPUT || op == PBNDS_OP_LIGHT_INPUT;
}

static bool has_weights(enum pbnds_op op)
{
    return op == PBNDS_OP_CONV || op == PBNDS_OP_UP;
}

static enum pbnds_status check_name(const struct pbnds_net *net, int r,
                                    struct pbnds_error *error)
{
    const char *name = net->table->layers[r].name;
    if (!name || !*name || strlen(name) > MAX_NAME) {
        return fault(net, r, error, "a name of 1 to %d bytes is wanted", (int)MAX_NAME);
    }
    for (int i = 0; i < r; ++i) {
        if (!strcmp(name, net->table->layers[i].name)) {
            return fault(net, r, error, "row %d has the same name", i);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status check_inputs(const struct pbnds_net *net, int r,
                                      struct pbnds_error *error)
{
    const struct pbnds_layer *layer = &net->table->layers[r];
    for (int i = 0; i < net->rows[r].inputs; ++i) {
        if (layer->in[i] < 0 || layer->in[i] >= r) {
            return fault(net, r, error, "input %d is row %d, which is not before it", i,
                         layer->in[i]);
        }
    }
    if (!is_input(layer->op)) return PBNDS_OK;
    for (int i = 0; i < r; ++i) {
        if (net->table->layers[i].op == layer->op) {
            return fault(net, r, error, "row %d is that input already", i);
        }
    }
    return PBNDS_OK;
}

/** Level and channels of a row that has weights. */
static enum pbnds_status derive_weighted(struct pbnds_net *net, int r,
                                         struct pbnds_error *error)
{
    struct pbnds_row *row = &net->rows[r];
    const struct pbnds_layer *layer = row->layer;
    const int k = layer->kernel, s = layer->stride;
    if (!(isfinite(layer->init_scale))) {
        return fault(net, r, error, "init_scale is not finite");
    }
    if (layer->op == PBNDS_OP_UP) {
        if ((k != 0 && k != 2) || (s != 0 && s != 2)) {
            return fault(net, r, error,
                         "kernel %d, stride %d: an UP is 2x2 with stride 2", k, s);
        }
        --row->level;
        return PBNDS_OK;
    }
    if (!(s == 1 && (k == 1 || k == 3)) && !(s == 2 && (k == 2 || k == 3))) {
        return fault(net, r, error,
                     "kernel %d with stride %d is none of 1x1, 3x3, 2x2 stride 2, 3x3 "
                     "stride 2",
                     k, s);
    }
    row->level += s == 2;
    return PBNDS_OK;
}

/** Level and channels of a row of two inputs. */
static enum pbnds_status derive_pair(struct pbnds_net *net, int r,
                                     struct pbnds_error *error)
{
    struct pbnds_row *row = &net->rows[r];
    const struct pbnds_row *a = &net->rows[row->layer->in[0]];
    const struct pbnds_row *b = &net->rows[row->layer->in[1]];
    if (a->level != b->level) {
        return fault(net, r, error, "inputs \"%s\" and \"%s\" are at levels %d and %d",
                     a->layer->name, b->layer->name, a->level, b->level);
    }
    if (row->layer->op == PBNDS_OP_CONCAT) {
        row->channels = a->channels + b->channels;
    } else if (a->channels != b->channels) {
        return fault(net, r, error, "inputs \"%s\" and \"%s\" have %d and %d channels",
                     a->layer->name, b->layer->name, a->channels, b->channels);
    }
    return PBNDS_OK;
}

static enum pbnds_status derive_plain(struct pbnds_net *net, int r,
                                      struct pbnds_error *error)
{
    struct pbnds_row *row = &net->rows[r];
    switch (row->layer->op) {
    case PBNDS_OP_POOL:
        ++row->level;
        break;
    case PBNDS_OP_SHUFFLE:
        if (row->channels % 4) {
            return fault(net, r, error, "%d channels do not divide by 4",
                         row->channels);
        }
        row->channels /= 4;
        --row->level;
        break;
    case PBNDS_OP_DROPOUT:
        if (!(row->layer->rate >= 0.0f && row->layer->rate < 1.0f)) {
            return fault(net, r, error, "dropout rate %g is not in [0, 1)",
                         (double)row->layer->rate);
        }
        break;
    default:
        return derive_pair(net, r, error);
    }
    return PBNDS_OK;
}

static enum pbnds_status derive_row(struct pbnds_net *net, int r,
                                    struct pbnds_error *error)
{
    struct pbnds_row *row = &net->rows[r];
    const struct pbnds_layer *layer = row->layer;
    const enum pbnds_op op = layer->op;
    if ((int)op < 0 || op > PBNDS_OP_DROPOUT) {
        return fault(net, r, error, "there is no op %d", (int)op);
    }
    row->inputs = is_input(op)                                  ? 0
                  : op == PBNDS_OP_ADD || op == PBNDS_OP_CONCAT ? 2
                                                                : 1;
    PBNDS_TRY(check_inputs(net, r, error));
    row->light = op == PBNDS_OP_LIGHT_INPUT;
    row->needs_grad = has_weights(op);
    for (int i = 0; i < row->inputs; ++i) {
        row->light |= net->rows[layer->in[i]].light;
        row->needs_grad |= net->rows[layer->in[i]].needs_grad;
    }
    if (row->inputs) {
        row->level = net->rows[layer->in[0]].level;
        row->channels = net->rows[layer->in[0]].channels;
    }
    if (is_input(op) || has_weights(op)) {
        row->channels = layer->channels;
        if (row->channels < 1) return fault(net, r, error, "channels are missing");
    }
    if (has_weights(op)) {
        PBNDS_TRY(derive_weighted(net, r, error));
    } else if (!is_input(op)) {
        PBNDS_TRY(derive_plain(net, r, error));
    }
    if (layer->channels != 0 && layer->channels != row->channels) {
        return fault(net, r, error, "channels are %d, not %d (leave them 0)",
                     row->channels, layer->channels);
    }
    if (row->channels > MAX_CHANNELS) {
        return fault(net, r, error, "%d channels are more than %d", row->channels,
                     (int)MAX_CHANNELS);
    }
    if (row->level < 0)
        return fault(net, r, error, "it would be larger than the inputs");
    if (row->level > MAX_LEVEL) {
        return fault(net, r, error, "level %d is deeper than %d", row->level,
                     (int)MAX_LEVEL);
    }
    if (layer->act != PBNDS_ACT_NONE &&
        !(layer->act == PBNDS_ACT_RELU && (has_weights(op) || op == PBNDS_OP_ADD))) {
        return fault(net, r, error, "activation %d does not go with this op",
                     (int)layer->act);
    }
    return PBNDS_OK;
}

static enum pbnds_status check_output(const struct pbnds_net *net, int r, bool light,
                                      struct pbnds_error *error)
{
    if (r == -1) return PBNDS_OK;
    if (r < 0 || r >= net->count) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "network table: output row %d is outside of its %d rows", r,
                          net->count);
    }
    if (net->rows[r].light == light) return PBNDS_OK;
    return fault(net, r, error, "it is the %s output but in the %s scope",
                 light ? "light" : "view", light ? "view" : "light");
}

/** Rows that no output depends on are not run. */
static void mark_used(struct pbnds_net *net)
{
    const int outputs[] = {net->table->light_output, net->table->view_output};
    for (int i = 0; i < 2; ++i) {
        if (outputs[i] >= 0) net->rows[outputs[i]].used = true;
    }
    for (int r = net->count - 1; r >= 0; --r) {
        struct pbnds_row *row = &net->rows[r];
        if (!row->used) continue;
        for (int i = 0; i < row->inputs; ++i)
            net->rows[row->layer->in[i]].used = true;
        if (row->level > net->deepest) net->deepest = row->level;
        if (row->light) {
            net->has_light = true;
        } else {
            net->has_view = true;
        }
    }
}

int pbnds_row_source(const struct pbnds_net *net, int row, bool train)
{
    while (!train && net->table->layers[row].op == PBNDS_OP_DROPOUT) {
        row = net->table->layers[row].in[0];
    }
    return row;
}

static void mark_lifetimes(struct pbnds_net *net, bool train)
{
    const int mode = train ? PBNDS_MODE_TRAIN : PBNDS_MODE_INFERENCE;
    const int outputs[] = {net->table->light_output, net->table->view_output};
    for (int r = 0; r < net->count; ++r) {
        const struct pbnds_row *row = &net->rows[r];
        if (!row->used) continue;
        net->rows[r].last_use[mode] = r;
        /* backward wants the sign of a relu's output and the input of a convolution */
        if (train && row->layer->act == PBNDS_ACT_RELU) net->rows[r].keep[mode] = true;
        for (int i = 0; i < row->inputs; ++i) {
            struct pbnds_row *in =
                &net->rows[pbnds_row_source(net, row->layer->in[i], train)];
            if (in->light == row->light) {
                in->last_use[mode] = r;
            } else {
                in->keep[mode] = true;
            }
            if (train && has_weights(row->layer->op)) in->keep[mode] = true;
        }
    }
    for (int i = 0; i < 2; ++i) {
        if (outputs[i] < 0) continue;
        struct pbnds_row *row = &net->rows[pbnds_row_source(net, outputs[i], train)];
        if (row->last_use[mode] < outputs[i]) row->last_use[mode] = outputs[i];
    }
}

enum pbnds_status pbnds_table_derive(struct pbnds_net *net, struct pbnds_error *error)
{
    for (int r = 0; r < net->count; ++r) {
        net->rows[r].layer = &net->table->layers[r];
        net->rows[r].weight = -1;
        PBNDS_TRY(check_name(net, r, error));
        PBNDS_TRY(derive_row(net, r, error));
    }
    PBNDS_TRY(check_output(net, net->table->light_output, true, error));
    PBNDS_TRY(check_output(net, net->table->view_output, false, error));
    mark_used(net);
    mark_lifetimes(net, false);
    mark_lifetimes(net, true);
    pbnds_table_reach(net);
    return PBNDS_OK;
}

struct pbnds_conv pbnds_row_conv(const struct pbnds_net *net, int r, int images, int h,
                                 int w)
{
    const struct pbnds_row *row = &net->rows[r], *in = &net->rows[row->layer->in[0]];
    const bool up = row->layer->op == PBNDS_OP_UP;
    return (struct pbnds_conv){.n = images,
                               .h = h >> in->level,
                               .w = w >> in->level,
                               .in = in->channels,
                               .out = row->channels,
                               .kernel = up ? 2 : row->layer->kernel,
                               .stride = up ? 2 : row->layer->stride,
                               .transposed = up,
                               .relu = row->layer->act == PBNDS_ACT_RELU,
                               .dtype = net->dtype};
}
