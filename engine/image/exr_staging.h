/**
 * @file exr_staging.h
 * Half channels are floats in memory: one chunk of each is converted on its way. For exr.c
 * alone.
 */
#ifndef PBNDS_ENGINE_IMAGE_EXR_STAGING_H
#define PBNDS_ENGINE_IMAGE_EXR_STAGING_H

#include "engine/image/exr.h"

/** One chunk of every half channel. */
struct pbnds_exr_staging {
    uint16_t *halves; /**< owned: free() it */
    size_t plane;     /**< elements a channel */
};

/** For chunks of `lines` rows. */
enum pbnds_status pbnds_exr_staging_init(struct pbnds_exr_staging *st,
                                         const struct pbnds_exr *exr, int lines,
                                         const char *path,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
/** Rows [row, row + lines) of every half channel: chunk to plane, plane to chunk. */
void pbnds_exr_unpack_halves(const struct pbnds_exr *exr,
                             const struct pbnds_exr_staging *st, int row, int lines);
void pbnds_exr_pack_halves(const struct pbnds_exr *exr,
                           const struct pbnds_exr_staging *st, int row, int lines);

#endif /* PBNDS_ENGINE_IMAGE_EXR_STAGING_H */
