/**
 * @file exr_description.h
 * What struct pbnds_exr says of a file, without the library that reads and writes it:
 * limits, look-up, and whether it can be written. For exr.c alone.
 */
#ifndef PBNDS_ENGINE_IMAGE_EXR_DESCRIPTION_H
#define PBNDS_ENGINE_IMAGE_EXR_DESCRIPTION_H

#include <stdbool.h>

#include "engine/image/exr.h"

enum { PBNDS_EXR_SIDE_MAX = 65535, PBNDS_EXR_CHANNELS_MAX = 1024 };

enum pbnds_exr_attribute_fate {
    PBNDS_EXR_ATTRIBUTE_WRITTEN,
    PBNDS_EXR_ATTRIBUTE_IMPLIED, /**< follows from the planes: left out          */
    PBNDS_EXR_ATTRIBUTE_REFUSED, /**< no name of its own, no end, or the planes' */
};

/** -1: no channel of that name. */
int pbnds_exr_channel_index(const struct pbnds_exr *exr, const char *name);
/** Of one plane in memory. */
size_t pbnds_exr_plane_bytes(const struct pbnds_exr *exr);
enum pbnds_status pbnds_exr_fail_memory(const char *path, struct pbnds_error *error);

/** Can it be written? Errors: ARGUMENT. */
enum pbnds_status pbnds_exr_check(const char *path, const struct pbnds_exr *exr,
                                  struct pbnds_error *error) PBNDS_NODISCARD;
enum pbnds_exr_attribute_fate
pbnds_exr_attribute_fate(const struct pbnds_exr_attribute *a);
/** Names of 32 characters and more need a flag that old readers do not know. */
bool pbnds_exr_has_long_names(const struct pbnds_exr *exr);

#endif /* PBNDS_ENGINE_IMAGE_EXR_DESCRIPTION_H */
