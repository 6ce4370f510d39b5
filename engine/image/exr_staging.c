#include "engine/image/exr_staging.h"

#include <stdlib.h>

#include "engine/image/exr_description.h"
#include "engine/image/half.h"

enum pbnds_status pbnds_exr_staging_init(struct pbnds_exr_staging *st,
                                         const struct pbnds_exr *exr, int lines,
                                         const char *path, struct pbnds_error *error)
{
    st->plane = (size_t)exr->width * (size_t)lines;
    st->halves = calloc(st->plane * (size_t)exr->channel_count, sizeof *st->halves);
    return st->halves ? PBNDS_OK : pbnds_exr_fail_memory(path, error);
}

void pbnds_exr_unpack_halves(const struct pbnds_exr *exr,
                             const struct pbnds_exr_staging *st, int row, int lines)
{
    const size_t count = (size_t)exr->width * (size_t)lines;
    for (int i = 0; i < exr->channel_count; ++i) {
        if (exr->channels[i].type != PBNDS_EXR_HALF) continue;
        const uint16_t *in = st->halves + (size_t)i * st->plane;
        float *out = (float *)exr->channels[i].data + (size_t)row * (size_t)exr->width;
        for (size_t k = 0; k < count; ++k)
            out[k] = pbnds_float_from_half(in[k]);
    }
}

void pbnds_exr_pack_halves(const struct pbnds_exr *exr,
                           const struct pbnds_exr_staging *st, int row, int lines)
{
    const size_t count = (size_t)exr->width * (size_t)lines;
    for (int i = 0; i < exr->channel_count; ++i) {
        if (exr->channels[i].type != PBNDS_EXR_HALF) continue;
        const float *in =
            (const float *)exr->channels[i].data + (size_t)row * (size_t)exr->width;
        uint16_t *out = st->halves + (size_t)i * st->plane;
        for (size_t k = 0; k < count; ++k)
            out[k] = pbnds_half_from_float(in[k]);
    }
}
