#include "engine/image/size.h"

#include <stdbool.h>
#include <string.h>

enum { SIDE_MAX = 16384 };
static const uint64_t BYTES_MAX = (uint64_t)1 << 30;

/** What a header says, in 64 bits so that nothing overflows. */
struct header {
    int64_t width, height;
    bool deep;      /* more than 8 bits a sample: decoded to floats */
    uint64_t least; /* the bytes that so many pixels take at least  */
    const char *fault;
};

static uint32_t big_u32(const uint8_t *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static uint32_t little_u32(const uint8_t *p)
{
    return (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
}

static uint32_t little_u24(const uint8_t *p)
{
    return (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
}

static bool starts(const uint8_t *bytes, size_t size, size_t at, const char *magic)
{
    const size_t length = strlen(magic);
    return size >= at + length && memcmp(bytes + at, magic, length) == 0;
}

static struct header damaged(const char *fault)
{
    return (struct header){.fault = fault};
}

/* Deflate makes at most 1032 bytes of one: 258 of two bits, RFC 1951. */
static struct header png_header(const uint8_t *p, size_t size)
{
    static const uint8_t samples[7] = {1, 0, 3, 1, 2, 0, 4};
    if (size < 26 || !starts(p, size, 12, "IHDR")) return damaged("it has no header");
    struct header h = {.width = big_u32(p + 16), .height = big_u32(p + 20)};
    if (h.width > INT32_MAX || h.height > INT32_MAX) {
        return damaged("its size is not valid");
    }
    const unsigned depth = p[24], colour = p[25] < 7 ? p[25] : 1;
    h.deep = depth > 8;
    const uint64_t row = ((uint64_t)h.width * samples[colour] * depth + 7) / 8 + 1;
    h.least = row / 1032 * (uint64_t)h.height;
    return h;
}

/* A Huffman code has at least one bit, and a block of 8 x 8 samples at least one code. */
static struct header jpeg_header(const uint8_t *p, size_t size)
{
    for (size_t at = 2; size - at >= 4;) {
        if (p[at] != 0xff) return damaged("a marker is missing");
        const unsigned marker = p[at + 1];
        if (marker == 0xff) {
            ++at;
            continue;
        }
        if (marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7)) {
            at += 2;
            continue;
        }
        const size_t length = (size_t)p[at + 2] << 8 | p[at + 3];
        if (length < 2 || length > size - at - 2) break;
        if (marker == 0xda || marker == 0xd9 || marker == 0xd8) break;
        const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 &&
                           marker != 0xc8 && marker != 0xcc;
        if (frame && length >= 8) {
            struct header h = {.height = p[at + 5] << 8 | p[at + 6],
                               .width = p[at + 7] << 8 | p[at + 8]};
            h.deep = p[at + 4] > 8;
            if (marker <= 0xc2) h.least = (uint64_t)(h.width * h.height) / 64 / 8;
            return h;
        }
        at += 2 + length;
    }
    return damaged("it has no frame");
}

static struct header webp_header(const uint8_t *p, size_t size)
{
    struct header h = {0};
    if (size < 30) return damaged("it is cut short");
    if (starts(p, size, 12, "VP8X")) {
        h.width = little_u24(p + 24) + 1;
        h.height = little_u24(p + 27) + 1;
    } else if (starts(p, size, 12, "VP8L")) {
        const uint32_t bits = little_u32(p + 21);
        h.width = (bits & 0x3fff) + 1;
        h.height = (bits >> 14 & 0x3fff) + 1;
    } else if (starts(p, size, 12, "VP8 ")) {
        h.width = (p[27] & 0x3f) << 8 | p[26];
        h.height = (p[29] & 0x3f) << 8 | p[28];
    } else {
        return damaged("it does not begin with a picture");
    }
    return h;
}

/** A number of up to nine digits; -1 where there is none. */
static int64_t number_at(const uint8_t *p, size_t size, size_t *at)
{
    int64_t value = 0;
    const size_t start = *at;
    for (; *at < size && p[*at] >= '0' && p[*at] <= '9' && *at - start < 9; ++*at)
        value = value * 10 + (p[*at] - '0');
    return *at > start ? value : -1;
}

/* Lines of text, an empty one, "-Y 512 +X 1024", then scan lines of at least four bytes. */
static struct header hdr_header(const uint8_t *p, size_t size)
{
    size_t at = 0;
    while (at + 1 < size && !(p[at] == '\n' && p[at + 1] == '\n'))
        ++at;
    at += 2;
    int64_t side[2] = {-1, -1};
    bool rows_first = false;
    for (int i = 0; i < 2; ++i) {
        if (size < 3 || at > size - 3 || (p[at] != '-' && p[at] != '+')) break;
        if (i == 0) rows_first = p[at + 1] == 'Y';
        at += 3;
        side[i] = number_at(p, size, &at);
        if (at < size && p[at] == ' ') ++at;
    }
    if (side[0] < 0 || side[1] < 0) return damaged("its resolution is missing");
    return (struct header){.height = rows_first ? side[0] : side[1],
                           .width = rows_first ? side[1] : side[0],
                           .deep = true,
                           .least = 4 * (uint64_t)side[0]};
}

/** What the attributes of an OpenEXR header say. */
struct exr {
    int64_t box[4]; /* of the data window: x, y, x, y */
    bool has_box, tiled;
    int64_t tile[2];
    unsigned compression;
};

static void see_attribute(struct exr *e, const uint8_t *name, const uint8_t *value,
                          size_t size)
{
    const char *text = (const char *)name;
    if (strcmp(text, "dataWindow") == 0 && size == 16) {
        for (int i = 0; i < 4; ++i)
            e->box[i] = (int32_t)little_u32(value + 4 * (size_t)i);
        e->has_box = true;
    } else if (strcmp(text, "tiles") == 0 && size == 9) {
        e->tile[0] = little_u32(value);
        e->tile[1] = little_u32(value + 4);
        e->tiled = true;
    } else if (strcmp(text, "compression") == 0 && size == 1) {
        e->compression = value[0];
    }
}

/** The end of a text that begins at `at`, or 0. */
static size_t text_end(const uint8_t *p, size_t size, size_t at)
{
    const uint8_t *end = at < size ? memchr(p + at, 0, size - at) : NULL;
    return end ? (size_t)(end - p) : 0;
}

/** Every block of pixels has an entry of 8 bytes in a table, and is 8 bytes long itself. */
static uint64_t exr_least(const struct exr *e, int64_t width, int64_t height)
{
    static const uint8_t lines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 0 /* 256 */};
    if (width < 1 || height < 1) return 0;
    if (e->tiled) {
        if (e->tile[0] < 1 || e->tile[1] < 1) return 0;
        return 16 * (uint64_t)((width + e->tile[0] - 1) / e->tile[0]) *
               (uint64_t)((height + e->tile[1] - 1) / e->tile[1]);
    }
    const int64_t rows = e->compression < 9 ? lines[e->compression] : (int64_t)256;
    return 16 * (uint64_t)((height + rows - 1) / rows);
}

static struct header exr_header(const uint8_t *p, size_t size)
{
    struct exr e = {{0}, false, false, {0, 0}, 0};
    size_t at = 8;
    while (at < size && p[at]) {
        const size_t name = at, type = text_end(p, size, at) + 1;
        const size_t value = type > 1 ? text_end(p, size, type) + 1 : 1;
        if (value == 1 || value > size || size - value < 4) {
            return damaged("its header is cut short");
        }
        const uint32_t length = little_u32(p + value);
        if (length > size - value - 4) return damaged("its header is cut short");
        see_attribute(&e, p + name, p + value + 4, length);
        at = value + 4 + length;
    }
    if (!e.has_box) return damaged("it has no data window");
    struct header h = {.width = e.box[2] - e.box[0] + 1,
                       .height = e.box[3] - e.box[1] + 1,
                       .deep = true};
    h.least = exr_least(&e, h.width, h.height);
    return h;
}

static bool read_header(const uint8_t *p, size_t size, struct header *h)
{
    if (starts(p, size, 0, "\x89PNG\r\n\x1a\n")) {
        *h = png_header(p, size);
    } else if (starts(p, size, 0, "\xff\xd8\xff")) {
        *h = jpeg_header(p, size);
    } else if (starts(p, size, 0, "RIFF") && starts(p, size, 8, "WEBP")) {
        *h = webp_header(p, size);
    } else if (starts(p, size, 0, "#?RADIANCE") || starts(p, size, 0, "#?RGBE")) {
        *h = hdr_header(p, size);
    } else if (starts(p, size, 0, "\x76\x2f\x31\x01")) {
        *h = exr_header(p, size);
    } else {
        return false;
    }
    return true;
}

enum pbnds_status pbnds_image_measure(const uint8_t *bytes, size_t size,
                                      const char *name,
                                      const struct pbnds_image_limits *limits,
                                      struct pbnds_image_size *out,
                                      struct pbnds_error *error)
{
    const int side = limits && limits->side ? limits->side : SIDE_MAX;
    const uint64_t most = limits && limits->bytes ? limits->bytes : BYTES_MAX;
    struct header h = {0};
    *out = (struct pbnds_image_size){0, 0, 0};
    if (size == 0) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: the image is empty", name);
    }
    if (!read_header(bytes, size, &h)) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: not an image that can be read here, convert it to PNG, "
                          "JPEG, Radiance HDR or OpenEXR",
                          name);
    }
    if (h.fault) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: image is damaged: %s", name,
                          h.fault);
    }
    if (h.width < 1 || h.height < 1) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: image of %lld x %lld pixels",
                          name, (long long)h.width, (long long)h.height);
    }
    if (h.width > side || h.height > side) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: %lld x %lld pixels are more than %d a side, scale the "
                          "image down (or see --max-image-side)",
                          name, (long long)h.width, (long long)h.height, side);
    }
    out->width = (int)h.width;
    out->height = (int)h.height;
    out->bytes = (uint64_t)h.width * (uint64_t)h.height * (h.deep ? 16u : 4u);
    if (out->bytes > most) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: %d x %d pixels take more than %.0f MiB in memory, scale "
                          "the image down (or see --max-images)",
                          name, out->width, out->height, (double)most / 1048576.0);
    }
    if (h.least > size) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: image is damaged: %zu bytes are too few for %d x %d "
                          "pixels",
                          name, size, out->width, out->height);
    }
    return PBNDS_OK;
}
