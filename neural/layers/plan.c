/* What can be said of a pass before it is run: how far it sees, and what it takes.
 *
 * Reach is followed from the outputs to the inputs. A row whose cells [-before, n + behind)
 * about an aligned rectangle of n cells are wanted wants of its inputs
 *
 *     3x3                [-before - 1, n + behind + 1)
 *     2x2 stride 2       [-2 before, 2n + 2 behind)
 *     3x3 stride 2       [-2 before - 1, 2n + 2 behind)     taps at 2o - 1, 2o, 2o + 1
 *     up, depth to space [-ceil(before / 2), n / 2 + ceil(behind / 2))
 *     anything else      the same.
 *
 * In pixels reach only grows on this way, so that no row is wanted further out than the
 * inputs are. */
#include <stdint.h>
#include <stdlib.h>

#include "neural/backend/dtype.h"
#include "neural/layers/net_internal.h"

static void want(struct pbnds_row *in, int before, int behind)
{
    if (in->reach_before < before) in->reach_before = before;
    if (in->reach_behind < behind) in->reach_behind = behind;
}

static void follow(struct pbnds_net *net, const struct pbnds_row *row)
{
    const struct pbnds_layer *layer = row->layer;
    int before = row->reach_before, behind = row->reach_behind;
    switch (layer->op) {
    case PBNDS_OP_CONV:
        if (layer->stride == 2) {
            before = 2 * before + (layer->kernel == 3);
            behind = 2 * behind;
        } else {
            before += layer->kernel / 2;
            behind += layer->kernel / 2;
        }
        break;
    case PBNDS_OP_POOL:
        before *= 2;
        behind *= 2;
        break;
    case PBNDS_OP_UP:
    case PBNDS_OP_SHUFFLE:
        before = (before + 1) / 2;
        behind = (behind + 1) / 2;
        break;
    default:
        break;
    }
    for (int i = 0; i < row->inputs; ++i)
        want(&net->rows[layer->in[i]], before, behind);
}

void pbnds_table_reach(struct pbnds_net *net)
{
    for (int r = net->count - 1; r >= 0; --r) {
        if (net->rows[r].used) follow(net, &net->rows[r]);
    }
}

int pbnds_net_halo(const struct pbnds_net *net)
{
    int reach = 0;
    for (int r = 0; r < net->count; ++r) {
        const struct pbnds_row *row = &net->rows[r];
        if (!row->used || row->inputs > 0) continue;
        if (reach < row->reach_before) reach = row->reach_before;
        if (reach < row->reach_behind) reach = row->reach_behind;
    }
    const int unit = 1 << net->deepest;
    return (reach + unit - 1) / unit * unit;
}

/** A pass that takes and gives blocks as pass.c does, and computes nothing. */
struct rehearsal {
    const struct pbnds_net *net;
    const struct pbnds_pass *pass;
    struct pbnds_arena arena;
    int *slots;
    size_t up; /* the largest result of a transposed convolution */
};

static void give(struct rehearsal *p, int r)
{
    if (p->slots[r] >= 0) pbnds_arena_give(&p->arena, p->slots[r]);
    p->slots[r] = -1;
}

static void drop_scope(struct rehearsal *p, bool light)
{
    for (int r = 0; r < p->net->count; ++r) {
        if (p->net->rows[r].light == light) give(p, r);
    }
}

static size_t row_bytes(const struct rehearsal *p, int r)
{
    const struct pbnds_row *row = &p->net->rows[r];
    const size_t images =
        (size_t)p->pass->batch * (row->light ? (size_t)p->pass->lights : 1);
    return images * (size_t)(p->pass->h >> row->level) *
           (size_t)(p->pass->w >> row->level) * (size_t)row->channels *
           pbnds_dtype_size(p->net->dtype);
}

static bool rehearse(struct rehearsal *p, bool light)
{
    const struct pbnds_net *net = p->net;
    for (int r = 0; r < net->count; ++r) {
        const struct pbnds_row *row = &net->rows[r];
        if (!row->used || row->light != light) continue;
        if (pbnds_row_source(net, r, false) == r) {
            const size_t bytes = row_bytes(p, r);
            p->slots[r] = pbnds_arena_take(&p->arena, bytes);
            if (p->slots[r] < 0) return false;
            if (row->layer->op == PBNDS_OP_UP && bytes > p->up) p->up = bytes;
        }
        for (int i = 0; i <= r; ++i) {
            const struct pbnds_row *old = &net->rows[i];
            if (old->light == light && old->last_use[PBNDS_MODE_INFERENCE] <= r &&
                !old->keep[PBNDS_MODE_INFERENCE]) {
                give(p, i);
            }
        }
    }
    return true;
}

size_t pbnds_net_bytes(const struct pbnds_net *net, const struct pbnds_pass *pass)
{
    struct rehearsal p = {.net = net, .pass = pass, .arena = {.dry = true}};
    p.slots = malloc((size_t)net->count * sizeof *p.slots);
    if (!p.slots) return SIZE_MAX;
    for (int r = 0; r < net->count; ++r)
        p.slots[r] = -1;
    /* The second chunk and the second view find blocks that the first ones left. */
    bool ok = pass->h > 0 && pass->w > 0 && pass->batch > 0 && pass->lights > 0;
    for (int view = 0; ok && view < 2; ++view) {
        drop_scope(&p, true);
        drop_scope(&p, false);
        ok = rehearse(&p, false);
        for (int chunk = 0; ok && chunk < 2; ++chunk) {
            drop_scope(&p, true);
            ok = rehearse(&p, true);
        }
    }
    const size_t bytes = ok ? pbnds_arena_bytes(&p.arena) + p.up : SIZE_MAX;
    pbnds_arena_free(&p.arena);
    free(p.slots);
    return bytes;
}
