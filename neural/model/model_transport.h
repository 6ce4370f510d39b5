/** @file model_transport.h  Channel counts that the transport table and its features
 * share. */
#ifndef PBNDS_NEURAL_MODEL_MODEL_TRANSPORT_H
#define PBNDS_NEURAL_MODEL_MODEL_TRANSPORT_H

#include "neural/model/model.h"

enum {
    PBNDS_TRANSPORT_VIEW_CHANNELS = 20,
    PBNDS_TRANSPORT_LIGHT_CHANNELS = 8,
    PBNDS_TRANSPORT_OUT_CHANNELS = 4, /**< visibility logit, indirect R, G, B */
};

extern const struct pbnds_model pbnds_model_transport;

#endif /* PBNDS_NEURAL_MODEL_MODEL_TRANSPORT_H */
