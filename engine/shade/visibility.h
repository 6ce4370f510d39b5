/**
 * @file visibility.h
 * Which distant lights the visible surfaces see. A light below the geometric surface is
 * not seen. BLEND surfaces are in the way where their alpha is 1/2 or more (accel.h).
 */
#ifndef PBNDS_ENGINE_SHADE_VISIBILITY_H
#define PBNDS_ENGINE_SHADE_VISIBILITY_H

#include "engine/shade/gbuffer.h"

enum { PBNDS_VISIBILITY_LIGHTS = 32 };

#ifdef __cplusplus
extern "C" {
#endif

/** Sets bit k of bits[i] (width * height, the caller's) where pixel i sees wi[k], a unit
 *  vector to the light; pixels that hit nothing get 0. count is at most
 *  PBNDS_VISIBILITY_LIGHTS. Errors: INTERRUPTED. */
enum pbnds_status pbnds_visibility(const struct pbnds_gbuffer *gbuffer,
                                   const struct pbnds_accel *accel,
                                   const struct pbnds_vec3 *wi, int count,
                                   uint32_t *bits,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_VISIBILITY_H */
