/* Ward, "Real Pixels", Graphics Gems II, and the "new" run-length form of Radiance 2.
 */
#include "scenes/generator/hdr.h"

#include <math.h>
#include <stdlib.h>

#include "engine/core/file.h"
#include "scenes/generator/pack.h"

/* Shared exponent: the largest channel gets its 8 bits, rounded to nearest. */
static void encode(const float rgb[3], uint8_t rgbe[4])
{
    const float largest = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
    int exponent = 0;
    for (int i = 0; i < 4; ++i)
        rgbe[i] = 0;
    if (!(largest > 1e-32f)) return;
    (void)frexpf(largest, &exponent);
    if (lrintf(ldexpf(largest, 8 - exponent)) > 255) ++exponent;
    for (int i = 0; i < 3; ++i) {
        rgbe[i] = (uint8_t)lrintf(ldexpf(fmaxf(rgb[i], 0.0f), 8 - exponent));
    }
    rgbe[3] = (uint8_t)(exponent + 128);
}

static int run_length(const uint8_t *line, int from, int width)
{
    int n = 1;
    while (from + n < width && n < 127 && line[from + n] == line[from])
        ++n;
    return n;
}

/* Runs of four and more as (128 + n, value), the rest as (n, values). */
static void pack_line(struct gen_bytes *out, const uint8_t *line, int width)
{
    for (int x = 0; x < width;) {
        int n = run_length(line, x, width);
        if (n >= 4) {
            const uint8_t run[2] = {(uint8_t)(128 + n), line[x]};
            gen_bytes_add(out, run, 2);
            x += n;
            continue;
        }
        int end = x;
        while (end < width && end - x < 128 && run_length(line, end, width) < 4)
            ++end;
        const uint8_t count = (uint8_t)(end - x);
        gen_bytes_add(out, &count, 1);
        gen_bytes_add(out, line + x, (size_t)count);
        x = end;
    }
}

enum pbnds_status gen_hdr_write(const char *path, const float *rgb, int width,
                                int height, struct pbnds_error *error)
{
    struct gen_bytes out = {.size = 0};
    uint8_t *planes = malloc((size_t)width * 4);
    enum pbnds_status status = PBNDS_OK;
    gen_bytes_print(&out, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", height,
                    width);
    for (int y = 0; y < height && planes; ++y) {
        for (int x = 0; x < width; ++x) {
            uint8_t rgbe[4];
            encode(rgb + 3 * ((size_t)y * (size_t)width + (size_t)x), rgbe);
            for (int c = 0; c < 4; ++c)
                planes[c * width + x] = rgbe[c];
        }
        const uint8_t start[4] = {2, 2, (uint8_t)(width >> 8), (uint8_t)(width & 255)};
        gen_bytes_add(&out, start, 4);
        for (int c = 0; c < 4; ++c)
            pack_line(&out, planes + c * width, width);
    }
    if (!planes || out.failed) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for the picture",
                            path);
    } else {
        status = pbnds_file_write(path, out.data, out.size, error);
    }
    free(planes);
    gen_bytes_free(&out);
    return status;
}
