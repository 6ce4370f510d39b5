#include "engine/image/clean.h"

#include <stdlib.h>
#include <string.h>

/* WebP container specification (RFC 9649, section 2): RIFF chunks padded to even sizes.
 */

enum { RIFF = 12, HEAD = 8, EXTENDED = 10 };
enum { ANIMATION = 0x02, ALPHA = 0x10 }; /* flags of the extended header */

static uint32_t little_endian(const uint8_t *p)
{
    return (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
}

static int is(const uint8_t *chunk, const char *tag)
{
    return memcmp(chunk, tag, 4) == 0;
}

static enum pbnds_status damaged(const char *name, const char *fault,
                                 struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: WebP is damaged: %s", name,
                      fault);
}

static enum pbnds_status copy_chunks(const uint8_t *bytes, size_t end, const char *name,
                                     uint8_t *out, size_t *out_size,
                                     struct pbnds_error *error)
{
    int images = 0;
    for (size_t at = RIFF; at < end;) {
        if (end - at < HEAD) return damaged(name, "it is cut short", error);
        const uint8_t *chunk = bytes + at;
        const uint32_t length = little_endian(chunk + 4);
        if (length > end - at - HEAD) return damaged(name, "it is cut short", error);
        size_t whole = HEAD + (size_t)length + (length & 1u);
        if (whole > end - at) whole = end - at; /* no padding at the end */
        const int extended = is(chunk, "VP8X");
        if (is(chunk, "ANIM") || is(chunk, "ANMF") ||
            (extended && length >= EXTENDED && (chunk[HEAD] & ANIMATION))) {
            return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                              "%s: WebP is an animation, save one picture of it", name);
        }
        const int image = is(chunk, "VP8 ") || is(chunk, "VP8L");
        images += image;
        if (extended && (length != EXTENDED || at != RIFF)) {
            return damaged(name, "its header is not valid", error);
        }
        if (image || extended || is(chunk, "ALPH")) {
            memcpy(out + *out_size, chunk, whole);
            if (extended) out[*out_size + HEAD] &= ALPHA; /* the rest is left out */
            *out_size += whole;
        }
        at += whole;
    }
    return images == 1 ? PBNDS_OK : damaged(name, "it does not hold one image", error);
}

enum pbnds_status pbnds_clean_webp(const uint8_t *bytes, size_t size, const char *name,
                                   uint8_t **clean, size_t *clean_size,
                                   struct pbnds_error *error)
{
    *clean = NULL;
    *clean_size = 0;
    if (size < RIFF || !is(bytes, "RIFF") || !is(bytes + 8, "WEBP")) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not a WebP file", name);
    }
    const uint32_t riff = little_endian(bytes + 4);
    if (riff < 4 || riff > size - 8) return damaged(name, "it is cut short", error);
    uint8_t *out = malloc(size);
    if (!out) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for %zu bytes",
                          name, size);
    }
    memcpy(out, bytes, RIFF);
    size_t out_size = RIFF;
    const enum pbnds_status status =
        copy_chunks(bytes, 8 + (size_t)riff, name, out, &out_size, error);
    if (status != PBNDS_OK) {
        free(out);
        return status;
    }
    const size_t body = out_size - 8;
    for (unsigned k = 0; k < 4; ++k)
        out[4 + k] = (uint8_t)(body >> (8 * k) & 0xffu);
    *clean = out;
    *clean_size = out_size;
    return PBNDS_OK;
}
