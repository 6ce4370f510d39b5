/**
 * @file draw_light.h
 * The light of a sample, by chance:
 *
 *     L(w) = 2^ev [(1 - t) M1(w) + t M2(w)]
 *
 * M1, M2: light maps of the split, or hard lights (draw_lamps.h), each turned by a yaw of
 * its own and scaled to the mean luminance 1 over the sphere; t is 0 but for the recipe's
 * mix_lights. A few are tilted about a horizontal axis as well. ev is uniform in [-2, 1];
 * in [-3, 0] for hard lights, which have all of it in one direction; 4 to 7 less in the recipe's dark_lights. So 2^ev is the mean luminance of what lights the scene.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_LIGHT_H
#define PBNDS_NEURAL_DATA_DRAW_LIGHT_H

#include "neural/data/draw.h"

/** Fills env, yaw_deg, strength and light of the draw, and its notes. `rng` decides all.
 *  Errors: of the light map's file; ARGUMENT (a map that is black); MEMORY. */
enum pbnds_status pbnds_draw_light(const struct pbnds_dataset_recipe *recipe,
                                   const struct pbnds_asset_list *envs,
                                   struct pbnds_rng *rng, struct pbnds_draw *draw,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_NEURAL_DATA_DRAW_LIGHT_H */
