/**
 * @file openness.h
 * Ambient occlusion, as openness: the share of the irradiance of a uniform sky that reaches
 * a visible surface,
 *
 *     A = 1/pi integral V(w) max(n.w, 0) dw,  1: open, 0: closed
 *
 * with n the shading normal, and V = 0 where a ray of any length hits something or w is
 * below the geometric surface. There is no greatest distance: it would be one more number
 * to choose, differently for each scene, and without one A is a transport: a Lambert
 * surface of albedo a under a uniform sky L reflects a A L of it directly. A closed room
 * is dark everywhere, as its surfaces see no sky.
 *
 * Estimated by `rays` directions of density n.w / pi, points of one Owen-scrambled sequence
 * a pixel (sampler.h). BLEND surfaces are in the way where their alpha is 1/2 or more
 * (accel.h).
 */
#ifndef PBNDS_ENGINE_SHADE_OPENNESS_H
#define PBNDS_ENGINE_SHADE_OPENNESS_H

#include "engine/shade/gbuffer.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Fills open[width * height] (the caller's, may be the G-buffer's ao); 0 where nothing was
 *  hit. `rays` is best a power of two. Errors: INTERRUPTED. */
enum pbnds_status pbnds_openness(const struct pbnds_gbuffer *gbuffer,
                                 const struct pbnds_accel *accel, int rays,
                                 uint64_t seed, float *open,
                                 struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_OPENNESS_H */
