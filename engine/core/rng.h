/**
 * @file rng.h
 * Counter-based random numbers: a pure function of (seed, pixel, sample, dimension), so
 * that one seed gives one image at any thread count, tile size or rank. Bits come from
 * the 64-bit finaliser of Steele, Lea and Flood 2014 (SplitMix64) applied per key word.
 */
#ifndef PBNDS_ENGINE_CORE_RNG_H
#define PBNDS_ENGINE_CORE_RNG_H

#include <stdint.h>

static inline uint64_t pbnds_mix64(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/** A stream of numbers for one (seed, pixel, sample); `dimension` counts up. */
struct pbnds_rng {
    uint64_t key;
    uint64_t dimension;
};

static inline struct pbnds_rng pbnds_rng_make(uint64_t seed, uint64_t pixel, uint64_t sample)
{
    struct pbnds_rng r;
    r.key = pbnds_mix64(pbnds_mix64(pbnds_mix64(seed) ^ pixel) ^ sample);
    r.dimension = 0;
    return r;
}

static inline uint64_t pbnds_rng_u64(struct pbnds_rng *r)
{
    return pbnds_mix64(r->key ^ pbnds_mix64(r->dimension++));
}

/** Uniform in [0, 1): 24 bits, never 1. */
static inline float pbnds_rng_float(struct pbnds_rng *r)
{
    return (float)(pbnds_rng_u64(r) >> 40) * 0x1p-24f;
}
#endif /* PBNDS_ENGINE_CORE_RNG_H */
