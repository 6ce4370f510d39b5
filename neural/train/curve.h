/**
 * @file curve.h
 * The loss curve of a run as CSV: step,seconds,lr,loss,train_psnr,val_loss,val_psnr.
 */
#ifndef PBNDS_NEURAL_TRAIN_CURVE_H
#define PBNDS_NEURAL_TRAIN_CURVE_H

#include <stdint.h>

#include "engine/core/error.h"

struct pbnds_curve_row {
    uint64_t step;
    double seconds, lr, loss, train_psnr, val_loss, val_psnr;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Starts the file anew, or keeps its rows up to and including `keep_step` (a resumed
 * run writes the later ones again). */
enum pbnds_status pbnds_curve_start(const char *path, uint64_t keep_step, int resume,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** The rows so far, the caller's to free(); a row cut short ends them. */
enum pbnds_status pbnds_curve_read(const char *path, struct pbnds_curve_row **rows,
                                   int *count,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
enum pbnds_status pbnds_curve_append(const char *path,
                                     const struct pbnds_curve_row *row,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_CURVE_H */
