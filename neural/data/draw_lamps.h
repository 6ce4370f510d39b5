/**
 * @file draw_lamps.h
 * Hard lights, which photographs rarely show: small suns, single lamps, near-dark. Drawn
 * straight into an equirect map (gltf convention, linear Rec. 709 radiance), with the
 * energy that their shape and radiance have.
 *
 * A lamp that faces the sphere's centre and covers the solid angle O with the radiance L
 * gives a surface that faces it the irradiance E = L O (small O). A map holds it as texels
 * of radiance L_i = E w_i / sum(w_j O_j), w_i the share of texel i that the lamp covers
 * and O_i its solid angle: sum(L_i O_i) = E whatever the resolution, also for a sun that
 * is smaller than a texel.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_LAMPS_H
#define PBNDS_NEURAL_DATA_DRAW_LAMPS_H

#include <cjson/cJSON.h>
#include <stdbool.h>

#include "engine/core/rng.h"
#include "engine/core/vec.h"
#include "engine/image/image.h"

struct pbnds_lamp {
    struct pbnds_vec3 direction; /**< unit, to its centre                            */
    struct pbnds_vec3 side;      /**< unit, across it; of a rectangle                */
    float half_x, half_y;        /**< radians; half_y 0: a disc of radius half_x     */
    struct pbnds_vec3 power;     /**< integral of its radiance over the sphere       */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Adds the lamp to a 3-channel map. */
void pbnds_lamp_add(const struct pbnds_lamp *lamp, struct pbnds_image *map);
/** Solid angle of a texel of row y of an equirect map, sr. */
float pbnds_texel_solid_angle(int width, int height, int y);
/** Mean luminance over the sphere. */
float pbnds_map_luminance(const struct pbnds_image *map);
/** Linear Rec. 709 colour of luminance 1 of a black body, 1000 to 40000 K. */
struct pbnds_vec3 pbnds_black_body(float kelvin);

/** Draws lamps and what is around them into an empty map of mean luminance 1, and tells
 *  of them in `notes`. */
void pbnds_draw_lamps(struct pbnds_rng *rng, struct pbnds_image *map, cJSON *notes);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DRAW_LAMPS_H */
