/**
 * @file clean.h
 * What a decoder needs of a picture file and nothing else. The libraries behind
 * OpenImageIO are at their weakest where no pixel is concerned: its IPTC reader runs
 * over the end of a damaged block, libpng prints complaints about colour profiles on
 * stderr. So they are only shown files whose structure is sound, without colour
 * profiles, EXIF, IPTC, XMP, text or anything behind the picture.
 *
 * Each function checks a file held in memory and makes a copy of what counts: *clean is
 * malloc'd and the caller's to free(). `name` is for messages. Errors: FORMAT (damaged,
 * cut short, no pixels), UNSUPPORTED, MEMORY.
 */
#ifndef PBNDS_ENGINE_IMAGE_CLEAN_H
#define PBNDS_ENGINE_IMAGE_CLEAN_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** IHDR, PLTE, tRNS, IDAT and IEND, with their CRCs checked. */
enum pbnds_status pbnds_clean_png(const uint8_t *bytes, size_t size, const char *name,
                                  uint8_t **clean, size_t *clean_size,
                                  struct pbnds_error *error) PBNDS_NODISCARD;
/** Tables, frame and scans up to the end marker, the JFIF and the Adobe header. */
enum pbnds_status pbnds_clean_jpeg(const uint8_t *bytes, size_t size, const char *name,
                                   uint8_t **clean, size_t *clean_size,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
/** The image and its alpha plane; animations are UNSUPPORTED. */
enum pbnds_status pbnds_clean_webp(const uint8_t *bytes, size_t size, const char *name,
                                   uint8_t **clean, size_t *clean_size,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_IMAGE_CLEAN_H */
