/**
 * @file train.h
 * One training loop for all models: AdamW, warm-up and cosine, gradient clipping,
 * averaged weights, augmentation (cut.h), checkpoint and exact resume, best on validation.
 *
 * Beside WEIGHTS.safetensors it keeps WEIGHTS.safetensors.checkpoint (parameters,
 * moments, step: removed when the run is finished), WEIGHTS.safetensors.csv and .png (the
 * loss curve, as numbers and as a plot) and .sheet.png (predictions beside references).
 * Neither an unfinished run nor finished weights are ever overwritten unasked.
 *
 * A step is the mean over batch x accumulate x ranks views. Several processes (ranks.h)
 * each take their part of them on a shared file system; they add up their gradients in the
 * order of the ranks, so the same number of ranks gives the same weights bit for bit, and
 * another number the same step to rounding. The first rank alone writes.
 */
#ifndef PBNDS_NEURAL_TRAIN_TRAIN_H
#define PBNDS_NEURAL_TRAIN_TRAIN_H

#include "engine/core/report.h"
#include "neural/backend/backend.h"

struct pbnds_train_options {
    const char *data;    /**< data set folder */
    const char *weights; /**< output file */
    const char *model;   /**< a name of pbnds_task_names() */
    const char *init;    /**< weights file to start from, or NULL */
    int steps;           /**< optimisation steps in all; 0: the model's default */
    int batch;           /**< views at once; 0: the model's default */
    int accumulate;      /**< batches a step, by each process; 0: 1 */
    int lights;          /**< lights a view; 0: the model's default */
    int crop;            /**< pixels; 0: 128 or the sample's size if smaller */
    double lr;           /**< peak learning rate; 0: the model's default */
    double weight_decay; /**< decoupled, of all parameters (adam.h) */
    double ema;          /**< decay of the averaged weights (ema.h); 0: none */
    bool augment;        /**< mirror half of the views, expose them by up to a stop */
    double seconds;      /**< stop at a checkpoint after this long; 0: no limit */
    double p_dark, lambda_zero; /**< pbnds+: energy regularisation; < 0: defaults */
    uint64_t seed;
    bool resume;          /**< go on from the checkpoint where there is one */
    int checkpoint_every; /**< steps; 0: only with each row of the curve */
    int sheet_every; /**< steps between contact sheets, the last at the end; 0: none */
    enum pbnds_dtype dtype;
    size_t max_memory; /**< bytes of samples to keep in memory; 0: all of them */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Errors: ARGUMENT, IO, FORMAT, MEMORY, BACKEND (NaN or divergence: the sentence says
 * the step; the last good checkpoint stays), INTERRUPTED (a checkpoint is written
 * first). */
enum pbnds_status pbnds_train(const struct pbnds_train_options *options,
                              const struct pbnds_report *report,
                              struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_TRAIN_H */
