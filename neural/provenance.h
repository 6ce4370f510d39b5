/**
 * @file provenance.h
 * Where trained weights come from, as metadata of their file (model.h has the list), so
 * that they can be made again from the file alone.
 */
#ifndef PBNDS_NEURAL_PROVENANCE_H
#define PBNDS_NEURAL_PROVENANCE_H

#include <stdint.h>

#include "neural/model/model.h"

struct pbnds_provenance {
    const struct pbnds_model *model;
    int lights;         /**< N a view */
    const char *data;   /**< hash of the data set */
    const char *recipe; /**< model, data and options in words */
    uint64_t step, steps, seed;
    enum pbnds_dtype dtype; /**< of the passes; the weights are float32 in any case */
    double validation_psnr; /**< dB, display image */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Atomic; the same run gives the same bytes. Errors: IO, MEMORY. */
enum pbnds_status pbnds_weights_save_trained(const char *path,
                                             const struct pbnds_net *net,
                                             const struct pbnds_provenance *provenance,
                                             struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_PROVENANCE_H */
