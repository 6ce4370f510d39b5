/**
 * @file sky.h
 * Procedural light maps: skies, studios, rooms, nights.
 *
 * Equirect in the gltf convention: column u = 0.5 + atan2(z, x) / 2 pi, row v =
 * acos(y) / pi, row 0 up. Radiance is linear Rec. 709 in units where the sky that ships
 * gives a horizontal white surface the radiance 1.
 *
 * Formula, for a direction w of height y = w.y:
 * - sky: S(w) = H + (Z - H) y^p + G exp(-k angle(w, sun)), for y >= 0
 * - clouds: S is mixed with white C by a smooth step of fractal noise on a plane above
 * - ground: A E / pi for y < 0, E the irradiance of all above on a horizontal surface,
 *   times 1 + noise where a relief is given
 * - lamps: discs and rectangles with smooth edges, in front of all this; a sun is a
 * disc whose radiance is its irradiance over its solid angle 2 pi (1 - cos radius)
 * - room: instead of sky and ground the walls of a box, lit by a lamp as a point
 *
 * The sky that ships (gen_default_sky): Z = (0.16, 0.34, 0.80), H = (0.80, 0.90, 1.00),
 * p = 0.45, G = (1.0, 0.8, 0.5), k = 6, A = (0.22, 0.19, 0.16), neither clouds nor
 * noise, sun of radius 2 degrees at (-0.50, 0.62, 0.60) normalised with colour (1,
 * 0.90, 0.72) and an irradiance (facing it) of 4.5 times that of the sky on the ground;
 * then scaled as said above.
 */
#ifndef PBNDS_SCENES_SKY_H
#define PBNDS_SCENES_SKY_H

#include <stddef.h>

#include "scenes/generator/random.h"

struct gen_lamp {
    struct pbnds_vec3 direction; /**< unit, to its centre             */
    struct pbnds_vec3 side, up;  /**< unit, of a rectangle            */
    float half_x, half_y;        /**< radians; disc: half_y 0, radius half_x */
    float softness;              /**< share of the size that fades    */
    struct pbnds_vec3 radiance;
};

enum { GEN_MAX_LAMPS = 32 };

struct gen_sky {
    struct pbnds_vec3 zenith, horizon, glow, ground_albedo;
    float power, glow_falloff;
    float cloud_cover, cloud_frequency; /**< cover 0: none */
    struct pbnds_vec3 cloud;
    float ground_relief; /**< amplitude of noise on the ground's albedo */
    uint32_t seed;
    bool room;
    struct pbnds_vec3 half, eye, lamp_at; /**< of the room, metres */
    struct pbnds_vec3 wall[6], lamp_power, ambient;
    struct gen_lamp lamps[GEN_MAX_LAMPS];
    int lamp_count;
    struct pbnds_vec3 ground; /**< radiance below; set by gen_sky_render() */
};

void gen_default_sky(struct gen_sky *sky);
/** A function of (seed, index) alone. */
void gen_random_sky(struct gen_sky *sky, uint64_t seed, uint64_t index);
/** Radiance of every texel, 16 directions each, into rgb[width * height * 3]. */
void gen_sky_render(struct gen_sky *sky, int width, int height, float *rgb);
/** Irradiance on a horizontal surface facing up, from a map of that size. */
struct pbnds_vec3 gen_sky_irradiance(const float *rgb, int width, int height);

#endif /* PBNDS_SCENES_SKY_H */
