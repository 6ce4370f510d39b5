/**
 * @file net_internal.h
 * What the files of this folder know of a network: the table with everything derived
 * from it, and the state of the passes.
 */
#ifndef PBNDS_NEURAL_LAYERS_NET_INTERNAL_H
#define PBNDS_NEURAL_LAYERS_NET_INTERNAL_H

#include "neural/layers/arena.h"
#include "neural/layers/net.h"
#include "neural/layers/ops.h"

enum { PBNDS_MODE_INFERENCE, PBNDS_MODE_TRAIN, PBNDS_MODES };

/** A row of the table with what follows from the rows before it. */
struct pbnds_row {
    const struct pbnds_layer *layer;
    int inputs;      /**< how many of layer->in are read                             */
    int channels;    /**< of the output                                              */
    int level;       /**< of the output                                              */
    bool light;      /**< scope                                                      */
    bool used;       /**< an output depends on it                                    */
    bool needs_grad; /**< it depends on parameters                                   */
    int weight;      /**< index of its weight among the parameters, the bias is next;
                          -1 without                                                 */
    /** Row of its scope after which nobody reads it; by mode. */
    int last_use[PBNDS_MODES];
    /** Held until the scope's backward or next forward; by mode. */
    bool keep[PBNDS_MODES];
    /** Cells of this row before and behind an aligned rectangle that the outputs inside
     *  the rectangle depend on. */
    int reach_before, reach_behind;
};

/** Blocks of the arena that hold a row's tensors, -1 for none. */
struct pbnds_slot {
    int value;     /**< activations                                                  */
    int grad;      /**< dL/d(output), in the net's type                              */
    int light_sum; /**< view rows: what the light chunks have added to it, float32   */
};

struct pbnds_net {
    const struct pbnds_net_table *table;
    struct pbnds_backend *backend;
    enum pbnds_dtype dtype;
    struct pbnds_row *rows;
    struct pbnds_slot *slots;
    int count;
    bool has_view, has_light; /**< used rows in the scope */
    int deepest;
    struct pbnds_param *list; /**< parameters by name */
    int list_count;
    size_t param_count;
    float *params, *grads;
    struct pbnds_arena arena;
    struct pbnds_pass view_pass, light_pass; /**< that the activations belong to */
    bool view_ready, light_ready;
};

/** Input `i` of a row, seen through layers that are the identity in this mode. */
int pbnds_row_source(const struct pbnds_net *net, int row, bool train);

/** Checks the table and fills net->rows. */
enum pbnds_status pbnds_table_derive(struct pbnds_net *net, struct pbnds_error *error);

/** Fills the rows' reach; the rest of net->rows is there. */
void pbnds_table_reach(struct pbnds_net *net);

/** The convolution that row r of CONV or UP is, on `images` images of a pass of h x w.
 */
struct pbnds_conv pbnds_row_conv(const struct pbnds_net *net, int r, int images, int h,
                                 int w);

#endif /* PBNDS_NEURAL_LAYERS_NET_INTERNAL_H */
