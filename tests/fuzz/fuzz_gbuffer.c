/* libFuzzer target: any bytes as an EXR file, and as a G-buffer. */
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/shade/gbuffer.h"
#include "tests/fuzz/scratch.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static volatile float sink; /* so that no read is optimised away */

/* What the contract promises of every G-buffer that was read. */
static void check_gbuffer(const struct pbnds_gbuffer *g)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(g->albedo[0][i]) || !isfinite(g->normal[2][i])) abort();
        if (!isfinite(g->roughness[i]) || isnan(g->depth[i])) abort();
        if (!isfinite(g->position[1][i]) || !isfinite(g->emission[0][i])) abort();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    if (!scratch_write(path, sizeof path, ".exr", data, size)) return 0;
    struct pbnds_exr exr;
    struct pbnds_error error;

    if (pbnds_exr_read(path, &exr, &error) == PBNDS_OK) {
        const size_t last = (size_t)exr.width * (size_t)exr.height - 1;
        for (int i = 0; i < exr.channel_count; ++i) {
            if (exr.channels[i].type == PBNDS_EXR_UINT) continue;
            sink += ((const float *)exr.channels[i].data)[last];
        }
        pbnds_exr_free(&exr);
    }
    struct pbnds_gbuffer gbuffer;
    struct pbnds_gbuffer_origin origin;
    struct pbnds_image radiance;
    if (pbnds_gbuffer_read(path, &gbuffer, &origin, &radiance, NULL, &error) ==
        PBNDS_OK) {
        check_gbuffer(&gbuffer);
        pbnds_gbuffer_free(&gbuffer);
        pbnds_image_free(&radiance);
    }
    (void)unlink(path);
    return 0;
}
