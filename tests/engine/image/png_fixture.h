/* PNG files built by hand: chunks with their CRC, pixels in stored (uncompressed)
 * blocks. */
#ifndef PBNDS_TEST_PNG_FIXTURE_H
#define PBNDS_TEST_PNG_FIXTURE_H

#include <stdint.h>
#include <string.h>

struct bytes {
    uint8_t data[70000];
    size_t size;
};

static inline void put(struct bytes *b, const void *data, size_t size)
{
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static inline void put_u8(struct bytes *b, unsigned value)
{
    b->data[b->size++] = (uint8_t)value;
}

static inline void put_be32(struct bytes *b, uint32_t value)
{
    for (int shift = 24; shift >= 0; shift -= 8)
        put_u8(b, value >> shift & 255u);
}

/* Bit by bit, as the definition has it. */
static inline uint32_t crc_of(const uint8_t *p, size_t size)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; ++i) {
        crc ^= p[i];
        for (int k = 0; k < 8; ++k)
            crc = crc >> 1 ^ (crc & 1u ? 0xedb88320u : 0u);
    }
    return ~crc;
}

static inline void put_chunk(struct bytes *b, const char *tag, const void *data,
                             size_t size)
{
    put_be32(b, (uint32_t)size);
    const size_t begin = b->size;
    put(b, tag, 4);
    if (size) put(b, data, size);
    put_be32(b, crc_of(b->data + begin, size + 4));
}

static inline void put_signature(struct bytes *b)
{
    b->size = 0;
    put(b, "\x89PNG\r\n\x1a\n", 8);
}

static inline void put_header(struct bytes *b, uint32_t width, uint32_t height,
                              unsigned depth, unsigned colour)
{
    struct bytes h = {.size = 0};
    put_be32(&h, width);
    put_be32(&h, height);
    put_u8(&h, depth);
    put_u8(&h, colour);
    put_be32(&h, 0);
    h.size = 13; /* compression, filter, interlace */
    put_chunk(b, "IHDR", h.data, h.size);
}

/* Rows of `stride` bytes, each with filter 0, as one stored zlib block (RFC 1950,
 * 1951). */
static inline void put_pixels(struct bytes *b, const uint8_t *rows, size_t stride,
                              size_t count)
{
    static struct bytes z, raw;
    raw.size = 0;
    for (size_t y = 0; y < count; ++y) {
        put_u8(&raw, 0);
        put(&raw, rows + y * stride, stride);
    }
    uint32_t s1 = 1, s2 = 0; /* Adler-32 */
    for (size_t i = 0; i < raw.size; ++i) {
        s1 = (s1 + raw.data[i]) % 65521u;
        s2 = (s2 + s1) % 65521u;
    }
    z.size = 0;
    put(&z, "\x78\x01\x01", 3);
    put_u8(&z, raw.size & 255u);
    put_u8(&z, raw.size >> 8 & 255u);
    put_u8(&z, ~raw.size & 255u);
    put_u8(&z, ~raw.size >> 8 & 255u);
    put(&z, raw.data, raw.size);
    put_be32(&z, s2 << 16 | s1);
    put_chunk(b, "IDAT", z.data, z.size);
}

static inline void put_end(struct bytes *b)
{
    put_chunk(b, "IEND", NULL, 0);
}

#endif /* PBNDS_TEST_PNG_FIXTURE_H */
