/**
 * @file oiio.h
 * Foreign images through OpenImageIO: textures, light maps, previews. The only door to
 * that library. Formats are restricted to PNG, JPEG, Radiance HDR, OpenEXR and, for
 * textures, WebP; sizes are held against limits (size.h) before anything is decoded: by
 * default at most 16384 pixels a side and 1 GiB of pixels, 4 GiB for a light map.
 */
#ifndef PBNDS_ENGINE_IMAGE_OIIO_H
#define PBNDS_ENGINE_IMAGE_OIIO_H

#include <stddef.h>
#include <stdint.h>

#include "engine/image/image.h"
#include "engine/image/size.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Pixels as stored: no colour conversion, no premultiplication, RGBA 8 bit or float. */
struct pbnds_pixels {
    int width, height;
    int channels; /**< always 4; grey is replicated, missing alpha is 1       */
    uint8_t *u8;  /**< 8-bit sources; else NULL                               */
    float *f32;   /**< 16-bit and float sources (integers scaled to [0, 1])   */
};

/** Decodes an image file held in memory (PNG, JPEG, WebP, ...). `name` is for messages.
 *  Errors: FORMAT (damaged, 0x0), UNSUPPORTED (format), MEMORY. */
enum pbnds_status pbnds_pixels_decode(const void *bytes, size_t size, const char *name,
                                      struct pbnds_pixels *pixels,
                                      struct pbnds_error *error) PBNDS_NODISCARD;
/** The same within other limits; NULL: the defaults. */
enum pbnds_status pbnds_pixels_decode_within(const void *bytes, size_t size,
                                             const char *name,
                                             const struct pbnds_image_limits *limits,
                                             struct pbnds_pixels *pixels,
                                             struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_pixels_free(struct pbnds_pixels *pixels);

/** Bytes of pixels (four floats each) that a light map may have by default: 16384 x 16384. */
#define PBNDS_LIGHT_MAP_BYTES ((uint64_t)4 << 30)

/** Reads a light map or picture as 3-channel float, as stored (linear for HDR and EXR; an
 *  8- or 16-bit picture is decoded from sRGB to linear). NaN, infinity and negatives are
 *  replaced: NaN and negative by 0, +inf by the largest finite value of the file.
 *  Errors: IO, FORMAT, UNSUPPORTED, MEMORY. */
enum pbnds_status pbnds_image_read_rgb(const char *path, struct pbnds_image *image,
                                       struct pbnds_error *error) PBNDS_NODISCARD;

/** The same within other limits; NULL: the defaults. */
enum pbnds_status
pbnds_image_read_rgb_within(const char *path, const struct pbnds_image_limits *limits,
                            struct pbnds_image *image,
                            struct pbnds_error *error) PBNDS_NODISCARD;

/** Writes an 8-bit PNG of 1, 3 or 4 channels, display-encoded values in [0, 1] (rounded,
 *  clamped, no dithering), atomically. */
enum pbnds_status pbnds_png_write(const char *path, const struct pbnds_image *image,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_IMAGE_OIIO_H */
