/**
 * @file hdr.h
 * Writer of Radiance pictures (.hdr, RGBE, run-length encoded scanlines).
 */
#ifndef PBNDS_SCENES_HDR_H
#define PBNDS_SCENES_HDR_H

#include "engine/core/error.h"

/** rgb: linear, row 0 on top; width 8 to 32767. Written atomically. */
enum pbnds_status gen_hdr_write(const char *path, const float *rgb, int width,
                                int height, struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_SCENES_HDR_H */
