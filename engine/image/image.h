/**
 * @file image.h
 * A float image, interleaved, row 0 on top: data[(y * width + x) * channels + c].
 * The unit and colour space are the owner's; HDRIs and renders are linear Rec. 709.
 */
#ifndef PBNDS_ENGINE_IMAGE_IMAGE_H
#define PBNDS_ENGINE_IMAGE_IMAGE_H

#include <stddef.h>

#include "engine/core/error.h"

struct pbnds_image {
    int width, height, channels;
    float *data; /**< owned; NULL in an empty image */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Zero-filled. Errors: ARGUMENT for sizes outside [1, 65535] or channels outside
 *  [1, 64], MEMORY. *image is empty on failure. */
enum pbnds_status pbnds_image_init(struct pbnds_image *image, int width, int height,
                                   int channels, struct pbnds_error *error) PBNDS_NODISCARD;
/** Frees and empties; safe on an empty image. */
void pbnds_image_free(struct pbnds_image *image);

/** Area-averaging resize (box filter, energy preserving), any target size. */
enum pbnds_status pbnds_image_resize(const struct pbnds_image *src, int width, int height,
                                     struct pbnds_image *dst,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

static inline float *pbnds_image_at(const struct pbnds_image *image, int x, int y)
{
    return image->data + ((size_t)y * (size_t)image->width + (size_t)x) *
                             (size_t)image->channels;
}

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_IMAGE_IMAGE_H */
