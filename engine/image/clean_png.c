#include "engine/image/clean.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* PNG (Portable Network Graphics) Specification, second edition, W3C 2003: 5.3 chunk
 * layout, 11.2 critical chunks, 11.3.2.1 tRNS, annex D the CRC. */

enum { SIGNATURE = 8, FRAME = 12, HEADER = 13 };

#define TAG(a, b, c, d)                                                                \
    ((uint32_t)(a) << 24 | (uint32_t)(b) << 16 | (uint32_t)(c) << 8 | (uint32_t)(d))

static const uint32_t IHDR = TAG('I', 'H', 'D', 'R'), PLTE = TAG('P', 'L', 'T', 'E'),
                      TRNS = TAG('t', 'R', 'N', 'S'), IDAT = TAG('I', 'D', 'A', 'T'),
                      IEND = TAG('I', 'E', 'N', 'D');

struct chunk {
    uint32_t tag, length;
    const uint8_t *data;
};

/* What has been seen so far. */
struct walk {
    uint8_t depth, colour; /* of IHDR */
    uint32_t palette;      /* entries */
    bool transparency, image, image_ended;
    bool huge;         /* more pixels a side than decoders take */
    const char *fault; /* why the file is damaged */
};

static uint32_t big_endian(const uint8_t *p)
{
    return TAG(p[0], p[1], p[2], p[3]);
}

static uint32_t crc32(const uint32_t table[256], const uint8_t *p, size_t size)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; ++i)
        crc = table[(crc ^ p[i]) & 0xffu] ^ crc >> 8;
    return ~crc;
}

static void crc_table(uint32_t table[256])
{
    for (uint32_t n = 0; n < 256; ++n) {
        uint32_t c = n;
        for (int k = 0; k < 8; ++k)
            c = c & 1u ? 0xedb88320u ^ c >> 1 : c >> 1;
        table[n] = c;
    }
}

static bool depth_allowed(unsigned colour, unsigned depth)
{
    switch (colour) {
    case 0: /* grey */
        return depth == 1 || depth == 2 || depth == 4 || depth == 8 || depth == 16;
    case 3: /* palette */
        return depth == 1 || depth == 2 || depth == 4 || depth == 8;
    case 2: /* colour */
    case 4: /* grey and alpha */
    case 6: /* colour and alpha */
        return depth == 8 || depth == 16;
    default:
        return false;
    }
}

static const char *see_header(struct walk *w, const struct chunk *c)
{
    if (c->tag != IHDR || c->length != HEADER) return "it does not begin with a header";
    const uint32_t width = big_endian(c->data), height = big_endian(c->data + 4);
    if (width == 0 || height == 0) return "it has no pixels";
    if (width > 0x7fffffffu || height > 0x7fffffffu) return "its size is not valid";
    w->huge = width > 1000000u || height > 1000000u;
    w->depth = c->data[8];
    w->colour = c->data[9];
    if (!depth_allowed(w->colour, w->depth)) return "its colour type is not valid";
    if (c->data[10] != 0 || c->data[11] != 0 || c->data[12] > 1) {
        return "its compression, filter or interlace method is not valid";
    }
    return NULL;
}

static const char *see_palette(struct walk *w, const struct chunk *c)
{
    if (w->palette || w->image || w->transparency) return "its palette is out of place";
    if (c->length == 0 || c->length % 3 != 0 || c->length > 768 ||
        (w->colour == 3 && c->length / 3 > 1u << w->depth)) {
        return "its palette has a wrong size";
    }
    w->palette = c->length / 3;
    return NULL;
}

/* Whether this tRNS chunk means something; one that does not is left out. */
static bool transparency_fits(const struct walk *w, const struct chunk *c)
{
    if (w->transparency || w->image) return false;
    if (w->colour == 3) return c->length >= 1 && c->length <= w->palette;
    return (w->colour == 0 && c->length == 2) || (w->colour == 2 && c->length == 6);
}

/* Takes note of a chunk. @return whether it belongs to the clean file */
static bool see(struct walk *w, const struct chunk *c)
{
    if (w->image && c->tag != IDAT) w->image_ended = true;
    if (c->tag == PLTE) {
        w->fault = see_palette(w, c);
        return w->colour != 0 && w->colour != 4; /* greys must have none */
    }
    if (c->tag == TRNS) {
        const bool fits = transparency_fits(w, c);
        if (fits) w->transparency = true;
        return fits;
    }
    if (c->tag == IDAT) {
        if (w->image_ended) w->fault = "its image data are interrupted";
        if (w->colour == 3 && !w->palette) w->fault = "it lacks a palette";
        w->image = true;
        return true;
    }
    if (c->tag == IEND && !w->image) w->fault = "it has no image data";
    if (c->tag == IHDR) w->fault = "it has two headers";
    return c->tag == IEND;
}

static bool is_critical(uint32_t tag)
{
    return !(tag >> 24 & 0x20u) && tag != IHDR && tag != PLTE && tag != IDAT &&
           tag != IEND;
}

static enum pbnds_status damaged(const char *name, const char *fault,
                                 struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: PNG is damaged: %s", name, fault);
}

/* Walks the chunks and appends the ones that count to `out`, which has room for all. */
static enum pbnds_status copy_chunks(const uint8_t *bytes, size_t size,
                                     const char *name, uint8_t *out, size_t *out_size,
                                     struct pbnds_error *error)
{
    uint32_t table[256];
    crc_table(table);
    struct walk w = {0};
    struct chunk c = {0};
    for (size_t at = SIGNATURE; c.tag != IEND; at += FRAME + (size_t)c.length) {
        if (size - at < FRAME) return damaged(name, "it is cut short", error);
        c.length = big_endian(bytes + at);
        c.tag = big_endian(bytes + at + 4);
        c.data = bytes + at + 8;
        if (c.length > size - at - FRAME)
            return damaged(name, "it is cut short", error);
        if (crc32(table, bytes + at + 4, (size_t)c.length + 4) !=
            big_endian(c.data + c.length)) {
            return damaged(name, "a checksum is wrong", error);
        }
        bool keep = true;
        if (at == SIGNATURE) {
            w.fault = see_header(&w, &c);
        } else if (is_critical(c.tag)) {
            return pbnds_fail(
                error, PBNDS_ERROR_UNSUPPORTED,
                "%s: PNG needs an extension that is not supported, save it "
                "as plain PNG",
                name);
        } else {
            keep = see(&w, &c);
        }
        if (w.fault) return damaged(name, w.fault, error);
        if (w.huge) {
            return pbnds_fail(
                error, PBNDS_ERROR_MEMORY,
                "%s: has more than a million pixels a side, scale it down", name);
        }
        if (!keep) continue;
        memcpy(out + *out_size, bytes + at, FRAME + (size_t)c.length);
        *out_size += FRAME + (size_t)c.length;
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_clean_png(const uint8_t *bytes, size_t size, const char *name,
                                  uint8_t **clean, size_t *clean_size,
                                  struct pbnds_error *error)
{
    static const uint8_t signature[SIGNATURE] = {0x89, 'P',  'N',  'G',
                                                 '\r', '\n', 0x1a, '\n'};
    *clean = NULL;
    *clean_size = 0;
    if (size < SIGNATURE || memcmp(bytes, signature, SIGNATURE) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not a PNG file", name);
    }
    uint8_t *out = malloc(size);
    if (!out) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for %zu bytes",
                          name, size);
    }
    memcpy(out, signature, SIGNATURE);
    size_t out_size = SIGNATURE;
    const enum pbnds_status status =
        copy_chunks(bytes, size, name, out, &out_size, error);
    if (status != PBNDS_OK) {
        free(out);
        return status;
    }
    *clean = out;
    *clean_size = out_size;
    return PBNDS_OK;
}
