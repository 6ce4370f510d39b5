/**
 * @file adam.h
 * Adam, Kingma and Ba 2015, algorithm 1 with bias correction, and decoupled weight decay
 * (Loshchilov and Hutter 2019) when weight_decay > 0; gradient clipping by global norm.
 */
#ifndef PBNDS_NEURAL_TRAIN_ADAM_H
#define PBNDS_NEURAL_TRAIN_ADAM_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

struct pbnds_adam {
    float beta1, beta2, epsilon, weight_decay;
    uint64_t step; /**< steps done */
    size_t count;
    float *m, *v; /**< first and second moments, owned */
};

#ifdef __cplusplus
extern "C" {
#endif

/** beta 0.9, 0.999, epsilon 1e-8, no decay, zero moments. */
enum pbnds_status pbnds_adam_init(struct pbnds_adam *adam, size_t count,
                                  struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_adam_free(struct pbnds_adam *adam);
/** One step on params with learning rate lr. */
void pbnds_adam_step(struct pbnds_adam *adam, float lr, const float *grads,
                     float *params);
/** Scales grads so that their L2 norm is at most max_norm (when > 0). Returns the norm before;
 *  NaN or infinity is returned as it is and leaves grads alone. */
double pbnds_clip_norm(float *grads, size_t count, double max_norm);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_ADAM_H */
