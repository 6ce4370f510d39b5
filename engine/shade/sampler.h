/**
 * @file sampler.h
 * Low-discrepancy numbers for the samples of one pixel: Owen-scrambled Sobol points,
 * padded by independent shuffles. Any set of `count` samples of one pixel covers each
 * decision (a light direction, a bounce) evenly, which is what a Monte Carlo mean
 * wants; different pixels and different decisions are independent.
 *
 * Burley 2020, "Practical Hash-based Owen Scrambling"; the scrambling hash is the one
 * of Laine and Karras 2011 with the constants of Vegdahl 2021. Direction numbers: Joe
 * and Kuo 2008. Keys come from rng.h, so that one seed gives one image.
 */
#ifndef PBNDS_ENGINE_SHADE_SAMPLER_H
#define PBNDS_ENGINE_SHADE_SAMPLER_H

#include <stdint.h>

struct pbnds_sampler {
    uint64_t key;
    uint32_t index, mask;
};

#ifdef __cplusplus
extern "C" {
#endif

/** @param sample  in [0, count); count is best a power of two */
struct pbnds_sampler pbnds_sampler_make(uint64_t seed, uint64_t pixel, uint32_t sample,
                                        uint32_t count);
/** `dimensions` (1 to 3) numbers in [0, 1) for the decision named `set`: a pure
 * function. */
void pbnds_sampler_get(const struct pbnds_sampler *sampler, uint32_t set,
                       int dimensions, float *u);
/** The same points at full resolution, in units of 2^-32. */
void pbnds_sampler_get_bits(const struct pbnds_sampler *sampler, uint32_t set,
                            int dimensions, uint32_t *bits);
static inline float pbnds_sampler_unit(uint32_t bits)
{
    return (float)(bits >> 8) * 0x1p-24f;
}
/** A plain hash of (seed, pixel, sample, set), independent of the points above: the seed
 *  of a ray that meets transparency by chance (accel.h). */
uint32_t pbnds_sampler_hash(const struct pbnds_sampler *sampler, uint32_t set);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_SAMPLER_H */
