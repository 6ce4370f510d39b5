/**
 * @file ema.h
 * Exponential moving average of the parameters, which is what is validated and written:
 * the noise of the last steps averages out (Polyak and Juditsky 1992).
 *
 *     mean += (1 - d) (params - mean),  d = min(decay, (1 + t) / (10 + t))
 *
 * at step t = 1, 2, ...: the average is short while the parameters still move far.
 */
#ifndef PBNDS_NEURAL_TRAIN_EMA_H
#define PBNDS_NEURAL_TRAIN_EMA_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

struct pbnds_ema {
    double decay; /**< 0: off, and all calls do nothing */
    size_t count;
    float *mean; /**< owned; NULL when off */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Begins at params. Errors: MEMORY. */
enum pbnds_status pbnds_ema_init(struct pbnds_ema *ema, double decay, size_t count,
                                 const float *params,
                                 struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_ema_free(struct pbnds_ema *ema);
/** After step `step` (from 1). */
void pbnds_ema_update(struct pbnds_ema *ema, uint64_t step, const float *params);
/** Puts the mean into params and keeps these; a second call puts them back. */
void pbnds_ema_swap(struct pbnds_ema *ema, float *params);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_EMA_H */
