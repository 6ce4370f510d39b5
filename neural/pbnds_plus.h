/**
 * @file pbnds_plus.h
 * The paper's light model: N directions, i.i.d. uniform over the sphere and the same
 * for all pixels; the network's outputs are averaged. It regresses display values, as
 * the paper does: y = sRGB(clamp(radiance, 0, 1)), so radiance comes back by the
 * inverse, never above 1.
 */
#ifndef PBNDS_NEURAL_PBNDS_PLUS_H
#define PBNDS_NEURAL_PBNDS_PLUS_H

#include "engine/scene/envmap.h"
#include "neural/features.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Draws `count` lights with the radiance of the map (NULL: black) in their direction.
 */
void pbnds_plus_draw_lights(const struct pbnds_envmap *envmap, uint64_t seed,
                            uint64_t stream, int count,
                            struct pbnds_light_source *lights);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_PBNDS_PLUS_H */
