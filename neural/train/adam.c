#include "neural/train/adam.h"

#include <math.h>
#include <stdlib.h>

enum pbnds_status pbnds_adam_init(struct pbnds_adam *adam, size_t count,
                                  struct pbnds_error *error)
{
    *adam = (struct pbnds_adam){
        .beta1 = 0.9f, .beta2 = 0.999f, .epsilon = 1e-8f, .count = count};
    adam->m = calloc(count ? count : 1, sizeof *adam->m);
    adam->v = calloc(count ? count : 1, sizeof *adam->v);
    if (!adam->m || !adam->v) {
        pbnds_adam_free(adam);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "Adam: no memory for the moments of %zu parameters", count);
    }
    return PBNDS_OK;
}

void pbnds_adam_free(struct pbnds_adam *adam)
{
    free(adam->m);
    free(adam->v);
    *adam = (struct pbnds_adam){.step = 0};
}

void pbnds_adam_step(struct pbnds_adam *adam, float lr, const float *grads,
                     float *params)
{
    const double t = (double)++adam->step;
    const double b1 = (double)adam->beta1, b2 = (double)adam->beta2;
    /* Corrections in double: 1 - beta2^t loses digits in float at small t. */
    const float rate = (float)((double)lr / (1.0 - pow(b1, t)));
    const float root = (float)(1.0 / sqrt(1.0 - pow(b2, t)));
    const float keep = 1.0f - lr * adam->weight_decay; /* decoupled: AdamW */
    const float beta1 = adam->beta1, beta2 = adam->beta2, epsilon = adam->epsilon;
    float *restrict m = adam->m, *restrict v = adam->v;
    const float *restrict g = grads;
    float *restrict p = params;
    for (size_t i = 0; i < adam->count; ++i) {
        m[i] = beta1 * m[i] + (1.0f - beta1) * g[i];
        v[i] = beta2 * v[i] + (1.0f - beta2) * g[i] * g[i];
        p[i] = p[i] * keep - rate * m[i] / (sqrtf(v[i]) * root + epsilon);
    }
}

double pbnds_clip_norm(float *grads, size_t count, double max_norm)
{
    double sum = 0.0; /* one thread, fixed order: the same bits at any thread count */
    for (size_t i = 0; i < count; ++i)
        sum += (double)grads[i] * (double)grads[i];
    const double norm = sqrt(sum);
    if (max_norm > 0.0 && isfinite(norm) && norm > max_norm) {
        const float scale = (float)(max_norm / norm);
        for (size_t i = 0; i < count; ++i)
            grads[i] *= scale;
    }
    return norm;
}
