/**
 * @file gbuffer_channels.h
 * The channels of the contract as one table: writer, reader and lint walk over it. Not for
 * shaders.
 */
#ifndef PBNDS_ENGINE_SHADE_GBUFFER_CHANNELS_H
#define PBNDS_ENGINE_SHADE_GBUFFER_CHANNELS_H

#include <stdbool.h>

#include "engine/shade/gbuffer.h"

/** What a channel holds, beyond numbers. */
enum pbnds_channel_kind {
    PBNDS_CHANNEL_UNIT,   /**< a share: [0, 1]                              */
    PBNDS_CHANNEL_AXIS,   /**< one component of a unit vector               */
    PBNDS_CHANNEL_LIGHT,  /**< radiance: [0, inf)                           */
    PBNDS_CHANNEL_METRES, /**< depth: (0, inf]                              */
    PBNDS_CHANNEL_REAL,   /**< any finite number                            */
    PBNDS_CHANNEL_ID,     /**< uint                                         */
};

struct pbnds_gbuffer_channel {
    const char *name;
    size_t plane; /**< offset of the plane's pointer in struct pbnds_gbuffer */
    enum pbnds_channel_kind kind;
    enum pbnds_exr_type
        type;          /**< as stored; HALF grows to FLOAT where a value leaves it */
    bool required;     /**< without it a file is no G-buffer                    */
    unsigned optional; /**< PBNDS_OPTIONAL_* bit, PBNDS_GBUFFER_FRESNEL, or 0: always */
};

/** f0 and f90 are asked for by no option. */
#define PBNDS_GBUFFER_FRESNEL (1u << 31)

#ifdef __cplusplus
extern "C" {
#endif

/** The i-th channel of the contract, NULL past the end. */
const struct pbnds_gbuffer_channel *pbnds_gbuffer_channel_at(int i);
/** Number of them. */
int pbnds_gbuffer_channel_count(void);

/** Its plane, NULL where this G-buffer has none. The first for all kinds but ID. */
float *pbnds_gbuffer_real(const struct pbnds_gbuffer *gbuffer,
                          const struct pbnds_gbuffer_channel *channel);
uint32_t *pbnds_gbuffer_id(const struct pbnds_gbuffer *gbuffer,
                           const struct pbnds_gbuffer_channel *channel);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_GBUFFER_CHANNELS_H */
