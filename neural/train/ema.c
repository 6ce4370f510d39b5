#include "neural/train/ema.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum pbnds_status pbnds_ema_init(struct pbnds_ema *ema, double decay, size_t count,
                                 const float *params, struct pbnds_error *error)
{
    *ema = (struct pbnds_ema){.decay = decay, .count = count};
    if (!(decay > 0.0)) return PBNDS_OK;
    ema->mean = malloc((count ? count : 1) * sizeof *ema->mean);
    if (!ema->mean) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "no memory for the average of %zu parameters", count);
    }
    memcpy(ema->mean, params, count * sizeof *ema->mean);
    return PBNDS_OK;
}

void pbnds_ema_free(struct pbnds_ema *ema)
{
    free(ema->mean);
    *ema = (struct pbnds_ema){.decay = 0.0};
}

void pbnds_ema_update(struct pbnds_ema *ema, uint64_t step, const float *params)
{
    if (!ema->mean) return;
    const double t = (double)step;
    const float rate = (float)(1.0 - fmin(ema->decay, (1.0 + t) / (10.0 + t)));
    float *restrict mean = ema->mean;
    for (size_t i = 0; i < ema->count; ++i)
        mean[i] += rate * (params[i] - mean[i]);
}

void pbnds_ema_swap(struct pbnds_ema *ema, float *params)
{
    if (!ema->mean) return;
    for (size_t i = 0; i < ema->count; ++i) {
        const float mean = ema->mean[i];
        ema->mean[i] = params[i];
        params[i] = mean;
    }
}
