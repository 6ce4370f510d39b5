/**
 * @file draw_random.h
 * Draws for samples. Each takes its numbers from the stream in a fixed order and is a
 * statement of its own: C does not say in which order the arguments of a call are
 * evaluated.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_RANDOM_H
#define PBNDS_NEURAL_DATA_DRAW_RANDOM_H

#include <stdbool.h>

#include "engine/core/rng.h"
#include "engine/core/vec.h"

static inline float pbnds_draw_uniform(struct pbnds_rng *rng, float lo, float hi)
{
    return lo + (hi - lo) * pbnds_rng_float(rng);
}
/** Uniform on a logarithmic scale; lo > 0. */
static inline float pbnds_draw_log_uniform(struct pbnds_rng *rng, float lo, float hi)
{
    return lo * powf(hi / lo, pbnds_rng_float(rng));
}
static inline bool pbnds_draw_chance(struct pbnds_rng *rng, double share)
{
    return (double)pbnds_rng_float(rng) < share;
}
/** 0 to n - 1. */
static inline int pbnds_draw_below(struct pbnds_rng *rng, int n)
{
    const int i = (int)(pbnds_rng_float(rng) * (float)n);
    return i < n ? i : n - 1;
}
/** Three numbers, each uniform. */
static inline struct pbnds_vec3 pbnds_draw_vec3(struct pbnds_rng *rng, float lo,
                                                float hi)
{
    struct pbnds_vec3 v;
    v.x = pbnds_draw_uniform(rng, lo, hi);
    v.y = pbnds_draw_uniform(rng, lo, hi);
    v.z = pbnds_draw_uniform(rng, lo, hi);
    return v;
}
/** About normal, mean 0 and standard deviation 1, within +-3: the sum of three uniform
 *  numbers. */
static inline float pbnds_draw_normal(struct pbnds_rng *rng)
{
    const struct pbnds_vec3 v = pbnds_draw_vec3(rng, -1.0f, 1.0f);
    return v.x + v.y + v.z;
}
/** Uniform on the sphere among heights y of [lowest, highest]. */
static inline struct pbnds_vec3 pbnds_draw_direction(struct pbnds_rng *rng,
                                                     float lowest, float highest)
{
    const float y = pbnds_draw_uniform(rng, lowest, highest);
    const float azimuth = pbnds_draw_uniform(rng, 0.0f, 2.0f * PBNDS_PI);
    const float r = sqrtf(fmaxf(0.0f, 1.0f - y * y));
    return pbnds_vec3_make(r * cosf(azimuth), y, r * sinf(azimuth));
}
#endif /* PBNDS_NEURAL_DATA_DRAW_RANDOM_H */
