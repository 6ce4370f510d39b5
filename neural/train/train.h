/**
 * @file train.h
 * One training loop for all models: Adam, warm-up and cosine, gradient clipping,
 * checkpoint and exact resume, best on validation.
 *
 * Beside WEIGHTS.safetensors it keeps WEIGHTS.safetensors.checkpoint (parameters,
 * moments, step: removed when the run is finished) and WEIGHTS.safetensors.csv (the loss
 * curve). Neither an unfinished run nor finished weights are ever overwritten unasked.
 */
#ifndef PBNDS_NEURAL_TRAIN_TRAIN_H
#define PBNDS_NEURAL_TRAIN_TRAIN_H

#include "engine/core/report.h"
#include "neural/backend/backend.h"

struct pbnds_train_options {
    const char *data;    /**< data set folder */
    const char *weights; /**< output file */
    const char *model;   /**< "pbnds+" or "transport" */
    const char *init;    /**< weights file to start from, or NULL */
    int steps;           /**< optimisation steps in all; 0: the model's default */
    int batch;           /**< views a step; 0: the model's default */
    int lights;          /**< lights a view; 0: the model's default */
    int crop;            /**< pixels; 0: 128 or the sample's size if smaller */
    double lr;           /**< peak learning rate; 0: the model's default */
    double seconds;      /**< stop at a checkpoint after this long; 0: no limit */
    double p_dark, lambda_zero; /**< pbnds+: energy regularisation; < 0: defaults */
    uint64_t seed;
    bool resume; /**< go on from the checkpoint where there is one */
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
