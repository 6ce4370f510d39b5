/**
 * @file curve_plot.h
 * The loss curve of a run as a picture: loss of training and of validation against steps,
 * the loss on a logarithmic axis.
 */
#ifndef PBNDS_NEURAL_TRAIN_CURVE_PLOT_H
#define PBNDS_NEURAL_TRAIN_CURVE_PLOT_H

#include "engine/core/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Reads a curve (curve.h) and writes the PNG. Losses that are not positive and finite
 *  leave a gap. Errors: IO, MEMORY. */
enum pbnds_status pbnds_curve_plot(const char *csv, const char *png,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_CURVE_PLOT_H */
