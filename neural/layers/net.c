/* A network's parameters: making, naming, initialising and counting them. */
#include "neural/layers/net.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "neural/layers/net_internal.h"

enum { MAX_ROWS = 4096 };

static void add_param(struct pbnds_net *net, int r, const char *what, int rank,
                      const int *shape)
{
    struct pbnds_param *p = &net->list[net->list_count++];
    (void)snprintf(p->name, sizeof p->name, "%s.%s", net->table->layers[r].name, what);
    p->rank = rank;
    p->offset = net->param_count;
    p->count = 1;
    for (int i = 0; i < rank; ++i) {
        p->shape[i] = shape[i];
        p->count *= (size_t)shape[i];
    }
    net->param_count += p->count;
}

/** Weight, then bias, of each row that has them, in the order of the table. */
static void list_params(struct pbnds_net *net)
{
    for (int r = 0; r < net->count; ++r) {
        const enum pbnds_op op = net->table->layers[r].op;
        if (op != PBNDS_OP_CONV && op != PBNDS_OP_UP) continue;
        const struct pbnds_conv c = pbnds_row_conv(net, r, 1, 1, 1);
        const int weight[] = {c.transposed ? c.in : c.out, c.transposed ? c.out : c.in,
                              c.kernel, c.kernel};
        net->rows[r].weight = net->list_count;
        add_param(net, r, "weight", 4, weight);
        add_param(net, r, "bias", 1, &c.out);
    }
}

static enum pbnds_status make_net(struct pbnds_net *net, struct pbnds_error *error)
{
    const size_t rows = (size_t)net->count;
    net->rows = calloc(rows, sizeof *net->rows);
    net->slots = calloc(rows, sizeof *net->slots);
    net->list = calloc(2 * rows, sizeof *net->list);
    if (!net->rows || !net->slots || !net->list) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "network: no memory for %zu rows",
                          rows);
    }
    for (size_t i = 0; i < rows; ++i)
        net->slots[i] = (struct pbnds_slot){-1, -1, -1};
    PBNDS_TRY(pbnds_table_derive(net, error));
    list_params(net);
    net->params = calloc(net->param_count + 1, sizeof *net->params);
    net->grads = calloc(net->param_count + 1, sizeof *net->grads);
    if (!net->params || !net->grads) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "network: no memory for %zu parameters", net->param_count);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_net_create(const struct pbnds_net_table *table,
                                   struct pbnds_backend *backend,
                                   enum pbnds_dtype dtype, struct pbnds_net **net,
                                   struct pbnds_error *error)
{
    *net = NULL;
    if (!table->layers || table->layer_count < 1 || table->layer_count > MAX_ROWS) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "network table: %d rows, 1 to %d are wanted",
                          table->layer_count, (int)MAX_ROWS);
    }
    if (dtype != PBNDS_F32 && dtype != PBNDS_BF16) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "network: element type %d is neither float32 nor bfloat16",
                          (int)dtype);
    }
    struct pbnds_net *made = calloc(1, sizeof *made);
    if (!made) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "network: no memory");
    made->table = table;
    made->backend = backend;
    made->dtype = dtype;
    made->count = table->layer_count;
    const enum pbnds_status status = make_net(made, error);
    if (status != PBNDS_OK) {
        pbnds_net_free(made);
        return status;
    }
    /* an earlier network's weights may have lain at these addresses */
    pbnds_net_params_changed(made);
    *net = made;
    return PBNDS_OK;
}

void pbnds_net_free(struct pbnds_net *net)
{
    if (!net) return;
    pbnds_arena_free(&net->arena);
    free(net->rows);
    free(net->slots);
    free(net->list);
    free(net->params);
    free(net->grads);
    free(net);
}

size_t pbnds_net_param_count(const struct pbnds_net *net)
{
    return net->param_count;
}

int pbnds_net_tensor_count(const struct pbnds_net *net)
{
    return net->list_count;
}

const struct pbnds_param *pbnds_net_param(const struct pbnds_net *net, int i)
{
    return i >= 0 && i < net->list_count ? &net->list[i] : NULL;
}

float *pbnds_net_params(struct pbnds_net *net)
{
    return net->params;
}

float *pbnds_net_grads(struct pbnds_net *net)
{
    return net->grads;
}

void pbnds_net_params_changed(struct pbnds_net *net)
{
    net->backend->ops->weights_changed(net->backend);
}

void pbnds_net_zero_grads(struct pbnds_net *net)
{
    memset(net->grads, 0, net->param_count * sizeof *net->grads);
}

/** Standard normal number i of a row: Box and Muller 1958, one of the pair. */
static double normal(uint64_t seed, int row, size_t i)
{
    struct pbnds_rng rng = pbnds_rng_make(seed, (uint64_t)row, i);
    const double u = 1.0 - (double)pbnds_rng_float(&rng); /* (0, 1] */
    const double v = (double)pbnds_rng_float(&rng);
    return sqrt(-2.0 * log(u)) * cos(2.0 * 3.14159265358979323846 * v);
}

/** He et al. 2015: deviation gain / sqrt(fan-in), where the fan-in is the number of
 * terms of one output sum; each output of the transposed 2x2 stride-2 convolution has C
 * terms. */
static void init_row(struct pbnds_net *net, int r, uint64_t seed)
{
    const struct pbnds_layer *layer = &net->table->layers[r];
    const struct pbnds_conv c = pbnds_row_conv(net, r, 1, 1, 1);
    const struct pbnds_param *weight = &net->list[net->rows[r].weight];
    const struct pbnds_param *bias = weight + 1;
    const double fan_in = (double)c.in * (c.transposed ? 1.0 : c.kernel * c.kernel);
    const double gain = layer->act == PBNDS_ACT_RELU ? 2.0 : 1.0;
    const double scale = layer->init_scale == 0.0f ? 1.0 : (double)layer->init_scale;
    const double deviation = scale * sqrt(gain / fan_in);
    for (size_t i = 0; i < weight->count; ++i) {
        net->params[weight->offset + i] = (float)(deviation * normal(seed, r, i));
    }
    memset(net->params + bias->offset, 0, bias->count * sizeof *net->params);
}

void pbnds_net_init(struct pbnds_net *net, uint64_t seed)
{
    for (int r = 0; r < net->count; ++r) {
        if (net->rows[r].weight >= 0) init_row(net, r, seed);
    }
    pbnds_net_params_changed(net);
}

void pbnds_net_macs(const struct pbnds_net *net, int h, int w, double *per_view,
                    double *per_light)
{
    *per_view = *per_light = 0.0;
    for (int r = 0; r < net->count; ++r) {
        const struct pbnds_row *row = &net->rows[r];
        if (!row->used || row->weight < 0) continue;
        const struct pbnds_conv c = pbnds_row_conv(net, r, 1, h, w);
        const double taps = c.transposed ? 1.0 : c.kernel * c.kernel;
        const double outputs =
            (double)(h >> row->level) * (double)(w >> row->level) * (double)c.out;
        *(row->light ? per_light : per_view) += outputs * (double)c.in * taps;
    }
}

int pbnds_net_deepest_level(const struct pbnds_net *net)
{
    return net->deepest;
}

struct pbnds_row_facts pbnds_net_row_facts(const struct pbnds_net *net, int row)
{
    const struct pbnds_row *r = &net->rows[row];
    return (struct pbnds_row_facts){r->channels, r->level, r->light, r->used};
}

enum pbnds_dtype pbnds_net_dtype(const struct pbnds_net *net)
{
    return net->dtype;
}
