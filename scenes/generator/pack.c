#include "scenes/generator/pack.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

void gen_bytes_free(struct gen_bytes *b)
{
    free(b->data);
    *b = (struct gen_bytes){.size = 0};
}

void gen_bytes_add(struct gen_bytes *b, const void *data, size_t size)
{
    if (b->failed) return;
    if (b->size + size > b->room) {
        size_t room = b->room ? b->room : 4096;
        while (room < b->size + size)
            room *= 2;
        uint8_t *grown = realloc(b->data, room);
        if (!grown) {
            b->failed = true;
            return;
        }
        b->data = grown;
        b->room = room;
    }
    if (size > 0) memcpy(b->data + b->size, data, size);
    b->size += size;
}

void gen_bytes_align(struct gen_bytes *b, uint8_t fill)
{
    while (b->size % 4 != 0 && !b->failed)
        gen_bytes_add(b, &fill, 1);
}

void gen_bytes_print(struct gen_bytes *b, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    const int n = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (n < 0 || (size_t)n >= sizeof text) {
        b->failed = true;
        return;
    }
    gen_bytes_add(b, text, (size_t)n);
}

/* ---- PNG (W3C Portable Network Graphics, third edition) ---- */

static void big_endian(uint8_t out[4], uint32_t x)
{
    for (int i = 0; i < 4; ++i)
        out[i] = (uint8_t)(x >> (24 - 8 * i));
}

static void png_chunk(struct gen_bytes *b, const char type[5], const uint8_t *data,
                      size_t size)
{
    uint8_t word[4];
    big_endian(word, (uint32_t)size);
    gen_bytes_add(b, word, 4);
    gen_bytes_add(b, type, 4);
    gen_bytes_add(b, data, size);
    uLong crc = crc32(0, (const Bytef *)type, 4);
    if (size > 0) crc = crc32(crc, data, (uInt)size);
    big_endian(word, (uint32_t)crc);
    gen_bytes_add(b, word, 4);
}

static int paeth(int a, int b, int c)
{
    const int p = a + b - c, pa = abs(p - a), pb = abs(p - b), pc = abs(p - c);
    return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

/* Filters one row; returns the sum of magnitudes that the filter choice goes by. */
static long png_filter(int kind, const uint8_t *row, const uint8_t *above, size_t size,
                       uint8_t *out)
{
    long cost = 0;
    out[0] = (uint8_t)kind;
    for (size_t i = 0; i < size; ++i) {
        const int a = i >= 3 ? row[i - 3] : 0, b = above ? above[i] : 0;
        const int c = above && i >= 3 ? above[i - 3] : 0;
        const int guess[5] = {0, a, b, (a + b) / 2, paeth(a, b, c)};
        out[i + 1] = (uint8_t)(row[i] - guess[kind]);
        cost += out[i + 1] < 128 ? out[i + 1] : 256 - out[i + 1];
    }
    return cost;
}

/* Each row by the filter that leaves the least. */
static void filter_best(const uint8_t *rgb, size_t row, int height, uint8_t *raw,
                        uint8_t *trial)
{
    for (int y = 0; y < height; ++y) {
        const uint8_t *line = rgb + row * (size_t)y;
        const uint8_t *above = y > 0 ? line - row : NULL;
        uint8_t *out = raw + (row + 1) * (size_t)y;
        long best = png_filter(0, line, above, row, out);
        for (int kind = 1; kind < 5; ++kind) {
            const long cost = png_filter(kind, line, above, row, trial);
            if (cost >= best) continue;
            best = cost;
            memcpy(out, trial, row + 1);
        }
    }
}

/* Every row by the difference to the one above. */
static void filter_up(const uint8_t *rgb, size_t row, int height, uint8_t *raw)
{
    for (int y = 0; y < height; ++y) {
        const uint8_t *line = rgb + row * (size_t)y;
        const uint8_t *above = y > 0 ? line - row : line;
        uint8_t *out = raw + (row + 1) * (size_t)y;
        out[0] = y > 0 ? 2 : 0;
        for (size_t i = 0; i < row; ++i)
            out[i + 1] = y > 0 ? (uint8_t)(line[i] - above[i]) : line[i];
    }
}

static void encode(struct gen_bytes *b, const uint8_t *rgb, int width, int height,
                   bool fast)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const size_t row = (size_t)width * 3, raw_size = (row + 1) * (size_t)height;
    uint8_t *raw = malloc(raw_size), *trial = malloc(row + 1);
    uLongf packed_size = compressBound((uLong)raw_size);
    uint8_t *packed = malloc(packed_size);
    if (!raw || !trial || !packed) {
        b->failed = true;
        goto done;
    }
    if (fast) {
        filter_up(rgb, row, height, raw);
    } else {
        filter_best(rgb, row, height, raw, trial);
    }
    if (compress2(packed, &packed_size, raw, (uLong)raw_size, fast ? 1 : 6) != Z_OK) {
        b->failed = true;
        goto done;
    }
    uint8_t header[13] = {0};
    big_endian(header, (uint32_t)width);
    big_endian(header + 4, (uint32_t)height);
    header[8] = 8; /* bits */
    header[9] = 2; /* RGB  */
    gen_bytes_add(b, signature, sizeof signature);
    png_chunk(b, "IHDR", header, sizeof header);
    png_chunk(b, "IDAT", packed, packed_size);
    png_chunk(b, "IEND", NULL, 0);
done:
    free(raw);
    free(trial);
    free(packed);
}

void gen_png(struct gen_bytes *b, const uint8_t *rgb, int width, int height)
{
    encode(b, rgb, width, height, false);
}

void gen_png_fast(struct gen_bytes *b, const uint8_t *rgb, int width, int height)
{
    encode(b, rgb, width, height, true);
}
