/**
 * @file noise.h
 * Band-limited noise: gradient noise (Perlin 1985, quintic fade of 2002) and cells
 * (Worley 1996). With a period the lattice wraps, so that textures tile.
 */
#ifndef PBNDS_SCENES_NOISE_H
#define PBNDS_SCENES_NOISE_H

#include <stdint.h>

#include "engine/core/vec.h"

/** About [-1, 1], mean 0. period: lattice cells after which x, y and z repeat; 0:
 * never. */
float gen_noise(struct pbnds_vec3 p, int period, uint32_t seed);
/** Sum of octaves with halving amplitude, about [-1, 1]. */
float gen_fbm(struct pbnds_vec3 p, int octaves, int period, uint32_t seed);

struct gen_cell {
    float f1, f2; /**< distance to the nearest and second nearest point, in cells */
    float id;     /**< [0, 1), constant over a cell                               */
};
/** n x n jittered points that tile the unit square. */
struct gen_cell gen_cells(float u, float v, int n, float jitter, uint32_t seed);

uint32_t gen_hash(uint32_t x, uint32_t y, uint32_t z, uint32_t seed);

#endif /* PBNDS_SCENES_NOISE_H */
