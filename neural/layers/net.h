/**
 * @file net.h
 * A network is one table of layers. The same table serves forward, backward, parameter
 * names, shapes and count.
 *
 * Two scopes. The view scope holds what depends on the G-buffer alone, batch B; the light
 * scope holds one image a light, batch B N (view-major: b * N + i). A layer with a
 * light-scope input is in the light scope; view tensors entering it are broadcast over
 * the lights. So light-independent work is paid once a view.
 *
 * Layout: NHWC, level L of a tensor is its size h >> L, w >> L. Batch, height and width are
 * free at run time; height and width must be multiples of 1 << (deepest level).
 */
#ifndef PBNDS_NEURAL_LAYERS_NET_H
#define PBNDS_NEURAL_LAYERS_NET_H

#include "neural/backend/backend.h"

enum pbnds_op {
    PBNDS_OP_VIEW_INPUT, /**< channels; float32 supplied by the caller                     */
    PBNDS_OP_LIGHT_INPUT, /**< channels                                                     */
    PBNDS_OP_CONV, /**< kernel 1, 2 or 3, stride 1 or 2, bias, act                   */
    PBNDS_OP_UP,   /**< 2x2 stride-2 transposed convolution, bias, act               */
    PBNDS_OP_ADD,  /**< in[0] + in[1], broadcast over lights, act                    */
    PBNDS_OP_CONCAT, /**< channels of in[0], then of in[1], broadcast over lights      */
    PBNDS_OP_SHUFFLE, /**< depth to space x2: out[2y+dy, 2x+dx, c] = in[y, x, c*4+dy*2+dx]
                               (torch's PixelShuffle); channels of in[0] / 4                */
    PBNDS_OP_POOL, /**< mean over 2x2                                                */
    PBNDS_OP_DROPOUT, /**< in training, zeroes elements with probability `rate`, scales
                               the rest by 1 / (1 - rate); identity otherwise               */
};

enum pbnds_act { PBNDS_ACT_NONE, PBNDS_ACT_RELU };

/** One row. Inputs name earlier rows by index. */
struct pbnds_layer {
    const char *name; /**< unique; parameters are "<name>.weight" and "<name>.bias" */
    enum pbnds_op op;
    int in[2];    /**< row indices, -1 where unused                             */
    int channels; /**< of the output (INPUT, CONV, UP); else derived, leave 0   */
    int kernel, stride;
    enum pbnds_act act;
    float rate;       /**< dropout */
    float init_scale; /**< multiplies the Kaiming initial weights; 0 means 1        */
};

/** The table with what its ends mean. */
struct pbnds_net_table {
    const struct pbnds_layer *layers;
    int layer_count;
    int light_output; /**< row whose output is read per light, -1 for none */
    int view_output;  /**< row read once a view, -1 for none               */
};

/** A parameter tensor inside the flat parameter array. */
struct pbnds_param {
    char name[96];
    int shape[4]; /**< oihw (iohw for UP); biases {out, 0, 0, 0} */
    int rank;     /**< 4 or 1 */
    size_t offset, count;
};

struct pbnds_net;

#ifdef __cplusplus
extern "C" {
#endif

/** Checks the table and makes a net with zero parameters; the table is borrowed.
 *  Errors: ARGUMENT (the sentence names the row), MEMORY. */
enum pbnds_status pbnds_net_create(const struct pbnds_net_table *table,
                                   struct pbnds_backend *backend,
                                   enum pbnds_dtype dtype, struct pbnds_net **net,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_net_free(struct pbnds_net *net);

size_t pbnds_net_param_count(const struct pbnds_net *net);
int pbnds_net_tensor_count(const struct pbnds_net *net);
const struct pbnds_param *pbnds_net_param(const struct pbnds_net *net, int i);
/** Flat float32 arrays of param_count elements, owned by the net. Call
 *  pbnds_net_params_changed() after writing to params. */
float *pbnds_net_params(struct pbnds_net *net);
float *pbnds_net_grads(struct pbnds_net *net);
void pbnds_net_params_changed(struct pbnds_net *net);
void pbnds_net_zero_grads(struct pbnds_net *net);
/** Kaiming-normal weights (fan-in, gain sqrt 2 before ReLU, 1 otherwise), zero biases. */
void pbnds_net_init(struct pbnds_net *net, uint64_t seed);
/** Multiply-accumulates of one forward pass at h x w: once a view, and a light. */
void pbnds_net_macs(const struct pbnds_net *net, int h, int w, double *per_view,
                    double *per_light);
int pbnds_net_deepest_level(const struct pbnds_net *net);
enum pbnds_dtype pbnds_net_dtype(const struct pbnds_net *net);
/** Pixels on each side of a rectangle that the outputs inside it depend on, where the
 *  rectangle's corners are multiples of 1 << (deepest level); itself such a multiple. A
 *  pass over the rectangle with so much around it gives the same values inside as a pass
 *  over any larger one, for what zero padding brings in from the rim ends within it. */
int pbnds_net_halo(const struct pbnds_net *net);

/** What follows from the table for one of its rows. */
struct pbnds_row_facts {
    int channels, level; /**< of the output */
    bool light;          /**< scope */
    bool used;           /**< an output depends on it */
};
struct pbnds_row_facts pbnds_net_row_facts(const struct pbnds_net *net, int row);

/** How a pass is run. */
struct pbnds_pass {
    int batch;  /**< B views                                                        */
    int lights; /**< N lights in this chunk (may differ from call to call)          */
    int h, w;   /**< of the inputs                                                  */
    bool train; /**< keep activations for backward, apply dropout                   */
    int first_view; /**< number of the first view in its step: each view has dropout
                         masks of its own, wherever a step is cut into batches        */
    uint64_t dropout_key; /**< masks are a pure function of (key, layer, element); give
                               every chunk of lights its own key, the same in a re-run */
};

/** Bytes that inference by such passes takes at most: activations of the view scope and of
 *  one chunk of lights, and the work room of transposed convolutions; not weights, which
 *  no size changes, nor inputs and outputs, which are the caller's. SIZE_MAX: not known, for
 *  want of memory, or no valid pass. */
size_t pbnds_net_bytes(const struct pbnds_net *net, const struct pbnds_pass *pass);

/** Runs the view scope. view_input: [B, h, w, C] float32. Its activations stay valid for any
 *  number of light chunks. view_output (or NULL) receives [B, oh, ow, C'] float32. */
enum pbnds_status pbnds_net_forward_view(struct pbnds_net *net,
                                         const struct pbnds_pass *pass,
                                         const float *view_input, float *view_output,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
/** Runs the light scope for one chunk. light_input: [B N, h, w, C] float32 (at the level of
 *  the LIGHT_INPUT row: 0). light_output: [B N, oh, ow, C'] float32. */
enum pbnds_status pbnds_net_forward_light(struct pbnds_net *net,
                                          const struct pbnds_pass *pass,
                                          const float *light_input, float *light_output,
                                          struct pbnds_error *error) PBNDS_NODISCARD;
/** Backward of the chunk run last (train = true): adds to the parameter gradients and to the
 *  gradients of the view tensors it read. */
enum pbnds_status pbnds_net_backward_light(struct pbnds_net *net,
                                           const struct pbnds_pass *pass,
                                           const float *d_light_output,
                                           struct pbnds_error *error) PBNDS_NODISCARD;
/** After all chunks: backward of the view scope; d_view_output may be NULL (zero). */
enum pbnds_status pbnds_net_backward_view(struct pbnds_net *net,
                                          const struct pbnds_pass *pass,
                                          const float *d_view_output,
                                          struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_LAYERS_NET_H */
