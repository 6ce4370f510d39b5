/* libFuzzer target: any bytes as an EXR file, as a G-buffer, and under the lint of one. */
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/shade/gbuffer.h"
#include "engine/shade/gbuffer_check.h"
#include "tests/fuzz/scratch.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static volatile float sink; /* so that no read is optimised away */

/* What the contract promises of every G-buffer that was read. */
static void check_gbuffer(const struct pbnds_gbuffer *g)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c) {
            if (!isfinite(g->albedo[c][i]) || !isfinite(g->normal[c][i])) abort();
            if (!isfinite(g->position[c][i]) || !isfinite(g->emission[c][i])) abort();
            if (g->f0[c] && !isfinite(g->f0[c][i])) abort();
        }
        if (!isfinite(g->roughness[i]) || isnan(g->depth[i])) abort();
        if (!isfinite(g->metallic[i]) || !isfinite(g->specular[i])) abort();
        if (!(g->coverage[i] >= 0.0f && g->coverage[i] <= 1.0f)) abort();
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
        static struct pbnds_findings findings;
        pbnds_gbuffer_check(&exr, path, &findings);
        sink += (float)pbnds_findings_faults(&findings);
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
