/**
 * @file light_punctual.h
 * One light of the file (KHR_lights_punctual) as a point of a surface sees it.
 *
 *     E = I w(d) s(angle) / d^2                         point, spot
 *     E = I                                             directional
 *     w(d) = max(min(1 - (d / range)^4, 1), 0)          1 without a range
 *     s = clamp((cd - cos_outer) / max(0.001, cos_inner - cos_outer), 0, 1)^2,
 *         cd = cosine between the spot's axis and the way to the point; 1 for a point
 *
 * the recommended window and falloff of the extension's text ("Range Property", "Inner
 * and Outer Cone Angles"). With I in W sr^-1 (directional: W m^-2) E is the irradiance,
 * W m^-2, linear Rec. 709, of a surface that faces the light: these are delta lights, so
 * reflected radiance is f(wo, wi) E max(n.wi, 0), with neither density nor MIS weight.
 * `range` is an artist's cut, not physics.
 *
 * Threads: pure functions, safe from any thread.
 */
#ifndef PBNDS_ENGINE_SHADE_LIGHT_PUNCTUAL_H
#define PBNDS_ENGINE_SHADE_LIGHT_PUNCTUAL_H

#include <stdbool.h>

#include "engine/scene/scene.h"

struct pbnds_punctual {
    struct pbnds_vec3 wi; /**< unit, from the point to the light, world */
    float distance;       /**< metres; INFINITY for a directional light */
    /** Of a facing surface with nothing in between, W m^-2. */
    struct pbnds_vec3 irradiance;
};

#ifdef __cplusplus
extern "C" {
#endif

/** @return false: no light arrives from there (out of range or cone, black, at the very
 *  point); `out` is then undefined */
bool pbnds_light_punctual(const struct pbnds_light *light, struct pbnds_vec3 p,
                          struct pbnds_punctual *out);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_LIGHT_PUNCTUAL_H */
