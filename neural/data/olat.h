/**
 * @file olat.h
 * Which lights are lit one at a time. Half of them are those of the sample's own light map
 * that are brightest, so that what throws its hard shadows is among them; the others are
 * spread over the whole sphere, so that every direction has its turn.
 *
 * From the map: of its PBNDS_DATASET_LIGHTS cluster lights (envmap.h) by falling luminance
 * of their power, each at least 10 degrees from those taken before. Where there are not
 * enough, the others are more. Over the sphere: n points of the Fibonacci lattice
 * z_i = 1 - (2 i + 1) / n, phi_i = i pi (3 - sqrt 5), turned by a random rotation
 * (Shoemake 1992, "Uniform Random Rotations").
 */
#ifndef PBNDS_NEURAL_DATA_OLAT_H
#define PBNDS_NEURAL_DATA_OLAT_H

#include "engine/core/rng.h"
#include "engine/scene/envmap.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Fills wi[count]: unit, to the lights, world; those of the map come first. @return how many these are */
int pbnds_olat_choose(const struct pbnds_envmap *envmap, int count,
                      struct pbnds_rng *rng, struct pbnds_vec3 *wi);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_OLAT_H */
