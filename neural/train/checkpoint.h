/**
 * @file checkpoint.h
 * The state of a training run between two steps, as one safetensors file: parameters,
 * Adam's moments, the average of the parameters where there is one, and in the metadata the
 * step, the best validation so far, the losses since the last row of the curve and the
 * options that must not change. Everything else of a step follows from (seed, step), so
 * a run resumed from a checkpoint goes on as if it had not been stopped.
 */
#ifndef PBNDS_NEURAL_TRAIN_CHECKPOINT_H
#define PBNDS_NEURAL_TRAIN_CHECKPOINT_H

#include "neural/layers/net.h"
#include "neural/train/adam.h"
#include "neural/train/ema.h"

struct pbnds_checkpoint {
    uint64_t step;    /**< steps done */
    uint64_t stocked; /**< last step that was validated and entered in the curve */
    double best;      /**< lowest validation loss so far, +inf for none */
    double seconds;   /**< training time so far */
    double loss_sum, mse_sum; /**< since that entry */
    uint64_t loss_count, mse_count;
    char recipe[640]; /**< model, data hash and options; compared on resume */
};

#ifdef __cplusplus
extern "C" {
#endif

enum pbnds_status pbnds_checkpoint_save(const char *path,
                                        const struct pbnds_checkpoint *checkpoint,
                                        struct pbnds_net *net,
                                        const struct pbnds_adam *adam,
                                        const struct pbnds_ema *ema,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
/** checkpoint->recipe holds the expected recipe on entry. Errors: IO, FORMAT, and
 * ARGUMENT when the file belongs to a run with other options. */
enum pbnds_status pbnds_checkpoint_load(const char *path,
                                        struct pbnds_checkpoint *checkpoint,
                                        struct pbnds_net *net, struct pbnds_adam *adam,
                                        struct pbnds_ema *ema,
                                        struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_CHECKPOINT_H */
