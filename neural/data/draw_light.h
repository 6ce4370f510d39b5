/**
 * @file draw_light.h
 * The light of a sample: a light map turned and exposed by chance.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_LIGHT_H
#define PBNDS_NEURAL_DATA_DRAW_LIGHT_H

#include "neural/data/draw.h"

/** Fills env, yaw_deg, strength and light of the draw, and its notes. `rng` decides all.
 *  Errors: of the light map's file; MEMORY. */
enum pbnds_status pbnds_draw_light(const struct pbnds_dataset_recipe *recipe,
                                   const struct pbnds_asset_list *envs,
                                   struct pbnds_rng *rng, struct pbnds_draw *draw,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_NEURAL_DATA_DRAW_LIGHT_H */
