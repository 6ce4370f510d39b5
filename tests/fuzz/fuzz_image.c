/* libFuzzer target: any bytes as a texture, and as a light map. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/image/oiio.h"
#include "tests/fuzz/scratch.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static volatile float sink; /* so that no read is optimised away */

/* Files are opened by their names, so the bytes get the name that fits them. */
static const char *extension_of(const uint8_t *data, size_t size)
{
    static const uint8_t exr[] = {0x76, 0x2f, 0x31, 0x01};
    if (size >= 4 && memcmp(data, exr, 4) == 0) return ".exr";
    if (size >= 2 && memcmp(data, "#?", 2) == 0) return ".hdr";
    if (size >= 4 && memcmp(data, "RIFF", 4) == 0) return ".webp";
    if (size >= 2 && data[0] == 0xff && data[1] == 0xd8) return ".jpg";
    return ".png";
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    /* A bomb must be refused, not survived. */
    const struct pbnds_image_limits limits = {.side = 2048, .bytes = 16 << 20};
    struct pbnds_error error;
    struct pbnds_pixels pixels;

    if (pbnds_pixels_decode_within(data, size, "fuzz", &limits, &pixels, &error) ==
        PBNDS_OK) {
        const size_t last = 4 * (size_t)pixels.width * (size_t)pixels.height - 1;
        sink += pixels.u8 ? (float)pixels.u8[last] : pixels.f32[last];
        pbnds_pixels_free(&pixels);
    }
    char path[64];
    if (!scratch_write(path, sizeof path, extension_of(data, size), data, size))
        return 0;
    struct pbnds_image image;
    if (pbnds_image_read_rgb_within(path, &limits, &image, &error) == PBNDS_OK) {
        const size_t count = 3 * (size_t)image.width * (size_t)image.height;
        for (size_t i = 0; i < count; ++i) {
            if (!isfinite(image.data[i]) || image.data[i] < 0.0f) abort();
        }
        pbnds_image_free(&image);
    }
    (void)unlink(path);
    return 0;
}
