/**
 * @file size.h
 * How large an image file becomes, from its header alone: asked before anything is decoded
 * or allocated, because a file of a hundred bytes can claim billions of pixels.
 *
 * PNG (W3C 2003, 11.2.2), JPEG (ITU-T T.81, B.2.2), WebP (RFC 9649), Radiance HDR,
 * OpenEXR (file layout 2.0; first part).
 */
#ifndef PBNDS_ENGINE_IMAGE_SIZE_H
#define PBNDS_ENGINE_IMAGE_SIZE_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What a decoded image may be. Zeros are the defaults. */
struct pbnds_image_limits {
    int side;       /**< pixels; 0: 16384                                  */
    uint64_t bytes; /**< four channels, 8 bit or float, decoded; 0: 1 GiB  */
};

struct pbnds_image_size {
    int width, height;
    uint64_t bytes; /**< decoded to RGBA: 4 a pixel, or 16 for 16-bit and float files */
};

/**
 * Reads the size and holds it against the limits (NULL: the defaults). Also holds it
 * against the length of the file, where the format tells how many pixels that many bytes
 * can hold at most: what claims more is cut short. `name` is for messages.
 * Errors: FORMAT (damaged, no pixels, cut short), UNSUPPORTED (none of the formats),
 * MEMORY (beyond a limit).
 */
enum pbnds_status pbnds_image_measure(const uint8_t *bytes, size_t size,
                                      const char *name,
                                      const struct pbnds_image_limits *limits,
                                      struct pbnds_image_size *out,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_IMAGE_SIZE_H */
