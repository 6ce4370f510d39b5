/**
 * @file batch.h
 * One batch through the network and back: all views, lights in chunks. Memory does not
 * grow with N: where the lights do not fit at once, they are run forward without being
 * kept, and again, chunk by chunk, for the gradient (exact, since the image is a sum
 * over lights).
 */
#ifndef PBNDS_NEURAL_TRAIN_BATCH_H
#define PBNDS_NEURAL_TRAIN_BATCH_H

#include "neural/train/task.h"

/** Buffers of one run; zero to start with. */
struct pbnds_batch {
    const struct pbnds_task_ops *ops;
    struct pbnds_task task;
    struct pbnds_net *net;
    int views, crop; /**< B, and the side of the square windows */
    int chunk;       /**< lights at once */
    int step_views; /**< views of the whole step, of all its batches; 0: those of this */
    int first_view; /**< number of views[0] among them */
    double mse_sum; /**< of the views of the last run that have one */
    int mse_count;
    int out_channels, view_out_channels;
    float *view_input, *light_input, *out, *d_out, *view_out, *d_view_out, *part,
        *d_part;
};

#ifdef __cplusplus
extern "C" {
#endif

/** chunk 0: as many lights as fit into 1 GiB. */
enum pbnds_status pbnds_batch_init(struct pbnds_batch *batch,
                                   const struct pbnds_task_ops *ops,
                                   const struct pbnds_task *task, struct pbnds_net *net,
                                   int views, int crop, int chunk,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_batch_free(struct pbnds_batch *batch);

/** Mean loss of the views (batch->views of them, windows crop x crop); with `train` the
 *  gradients are added to the net's. Where a step has several batches, each one's is its
 *  share of the step's mean. */
enum pbnds_status pbnds_batch_run(struct pbnds_batch *batch,
                                  const struct pbnds_task_view *views, bool train,
                                  uint64_t key, struct pbnds_task_loss *loss,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_BATCH_H */
