/** @file model_pbnds_plus.h  Channel counts that the PBNDS+ table and its features
 * share. */
#ifndef PBNDS_NEURAL_MODEL_MODEL_PBNDS_PLUS_H
#define PBNDS_NEURAL_MODEL_MODEL_PBNDS_PLUS_H

#include "neural/model/model.h"

enum {
    PBNDS_PLUS_BANDS = 8, /**< sin, cos at 2^0 .. 2^7         */
    PBNDS_PLUS_ENCODED = 1 + 2 * PBNDS_PLUS_BANDS, /**< channels an input becomes */
    PBNDS_PLUS_VIEW_CHANNELS = 11 * PBNDS_PLUS_ENCODED, /**< a, n, s, r, v */
    PBNDS_PLUS_LIGHT_CHANNELS = 3 * PBNDS_PLUS_ENCODED, /**< L_i <n.l> */
};

extern const struct pbnds_model pbnds_model_pbnds_plus;

#endif /* PBNDS_NEURAL_MODEL_MODEL_PBNDS_PLUS_H */
