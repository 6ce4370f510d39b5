/**
 * @file pack.h
 * Growing byte buffer, PNG encoder and GLB container.
 */
#ifndef PBNDS_SCENES_PACK_H
#define PBNDS_SCENES_PACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

/** Zero-initialise; `failed` is raised when memory runs out. */
struct gen_bytes {
    uint8_t *data;
    size_t size, room;
    bool failed;
};

void gen_bytes_free(struct gen_bytes *b);
void gen_bytes_add(struct gen_bytes *b, const void *data, size_t size);
/** Fills up to a multiple of 4 with `fill`. */
void gen_bytes_align(struct gen_bytes *b, uint8_t fill);
void gen_bytes_print(struct gen_bytes *b, const char *format, ...) PBNDS_PRINTF(2, 3);

/** Appends an 8-bit RGB image, row 0 on top, as a PNG file. */
void gen_png(struct gen_bytes *b, const uint8_t *rgb, int width, int height);
/** The same picture, packed in a fraction of the time to a somewhat larger file. */
void gen_png_fast(struct gen_bytes *b, const uint8_t *rgb, int width, int height);

#endif /* PBNDS_SCENES_PACK_H */
