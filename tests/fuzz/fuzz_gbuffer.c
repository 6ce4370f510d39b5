/* libFuzzer target: any bytes as an EXR file, as a G-buffer (read, linted, written again)
 * and as a file of Blender's. */
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/shade/cryptomatte.h"
#include "engine/shade/gbuffer_channels.h"
#include "engine/shade/gbuffer_check.h"
#include "engine/shade/import.h"
#include "tests/fuzz/scratch.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static volatile float sink; /* so that no read is optimised away */

/* What the contract promises of every G-buffer that was read, plane by plane. */
static void check_gbuffer(const struct pbnds_gbuffer *g)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    for (int c = 0; c < pbnds_gbuffer_channel_count(); ++c) {
        const struct pbnds_gbuffer_channel *channel = pbnds_gbuffer_channel_at(c);
        if (channel->kind == PBNDS_CHANNEL_ID) continue;
        const float *plane = pbnds_gbuffer_real(g, channel);
        for (size_t i = 0; plane && i < count; ++i) {
            if (isnan(plane[i])) abort();
            if (isinf(plane[i]) && channel->kind != PBNDS_CHANNEL_METRES) abort();
            if (channel->kind == PBNDS_CHANNEL_UNIT &&
                !(plane[i] >= 0.0f && plane[i] <= 1.0f))
                abort();
        }
    }
    if (g->samples < 1) abort();
    if (g->cryptomatte) {
        sink += g->cryptomatte->layers[1].share[PBNDS_CRYPTOMATTE_RANKS - 1][count - 1];
    }
}

/* What can be read can be written, and comes back. */
static void write_again(const char *path, const struct pbnds_gbuffer *g,
                        const struct pbnds_gbuffer_origin *origin)
{
    struct pbnds_error error;
    struct pbnds_gbuffer again;
    if (pbnds_gbuffer_write(path, g, origin, NULL, NULL, 0, PBNDS_EXR_ZIPS, &error) !=
        PBNDS_OK)
        abort();
    if (pbnds_gbuffer_read(path, &again, NULL, NULL, NULL, &error) != PBNDS_OK) abort();
    check_gbuffer(&again);
    pbnds_gbuffer_free(&again);
}

static void lint(const char *path)
{
    static struct pbnds_findings found;
    struct pbnds_exr exr;
    struct pbnds_error error;
    if (pbnds_exr_read(path, &exr, &error) != PBNDS_OK) return;
    const size_t last = (size_t)exr.width * (size_t)exr.height - 1;
    for (int i = 0; i < exr.channel_count; ++i) {
        if (exr.channels[i].type == PBNDS_EXR_UINT) continue;
        sink += ((const float *)exr.channels[i].data)[last];
    }
    pbnds_gbuffer_check(&exr, path, &found);
    sink += (float)pbnds_findings_faults(&found);
    pbnds_exr_free(&exr);
}

static void from_blender(const char *path)
{
    const struct pbnds_import_options options = {.yfov = 0.0f};
    static struct pbnds_import_notes notes;
    struct pbnds_gbuffer g;
    struct pbnds_image radiance;
    struct pbnds_error error;
    if (pbnds_import_blender(path, &options, &g, &radiance, &notes, &error) != PBNDS_OK)
        return;
    check_gbuffer(&g);
    pbnds_gbuffer_free(&g);
    pbnds_image_free(&radiance);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    if (!scratch_write(path, sizeof path, ".exr", data, size)) return 0;
    struct pbnds_error error;
    lint(path);
    from_blender(path);
    struct pbnds_gbuffer gbuffer;
    struct pbnds_gbuffer_origin origin;
    struct pbnds_image radiance;
    if (pbnds_gbuffer_read(path, &gbuffer, &origin, &radiance, NULL, &error) ==
        PBNDS_OK) {
        check_gbuffer(&gbuffer);
        write_again(path, &gbuffer, &origin);
        pbnds_gbuffer_free(&gbuffer);
        pbnds_image_free(&radiance);
    }
    (void)unlink(path);
    return 0;
}
