/**
 * @file gbuffer_planes.h
 * How the files that fill a G-buffer get its memory. Not for shaders.
 */
#ifndef PBNDS_ENGINE_SHADE_GBUFFER_PLANES_H
#define PBNDS_ENGINE_SHADE_GBUFFER_PLANES_H

#include <stdbool.h>

#include "engine/shade/gbuffer.h"

#ifdef __cplusplus
extern "C" {
#endif

/** All planes, with those of `optional` (PBNDS_OPTIONAL_* bits; Cryptomatte has no plane
 *  here) and, with `fresnel`, f0 and f90. Everything is zero: depth, object_id and
 *  material_id are still to be filled in by the caller, on any thread. samples is 1.
 *  Errors: ARGUMENT (sides outside [1, 65535]), MEMORY; the G-buffer is then empty. */
enum pbnds_status pbnds_gbuffer_allocate(struct pbnds_gbuffer *gbuffer, int width,
                                         int height, unsigned optional, bool fresnel,
                                         struct pbnds_error *error) PBNDS_NODISCARD;

/** Does `specular` say too little about some material that a mesh of the scene wears?
 *  True with a specular factor, a specular colour, specular-glossiness or unlit. */
bool pbnds_scene_needs_fresnel(const struct pbnds_scene *scene);

/** Image motion of a point in pixels, +x right, +y down: now minus before. Zero where it
 *  is or was behind the camera. */
struct pbnds_vec2 pbnds_image_motion(const struct pbnds_camera_view *now,
                                     const struct pbnds_camera_view *before,
                                     struct pbnds_vec3 position,
                                     struct pbnds_vec3 previous);

/** Does the cast take more than the surface at each pixel's centre? Then it is the one
 *  below. */
bool pbnds_raycast_is_antialiased(const struct pbnds_accel *accel,
                                  const struct pbnds_raycast_options *options);
/** Fills every plane of a G-buffer that was allocated and knows its camera and samples;
 *  makes the Cryptomatte. The sum over the layers of a ray through BLEND surfaces stops
 *  where less than 1/1000 of it is left, and at 64 layers. Errors: MEMORY, INTERRUPTED. */
enum pbnds_status pbnds_gbuffer_raycast_antialiased(
    const struct pbnds_scene *scene, const struct pbnds_accel *accel,
    const struct pbnds_raycast_options *options, struct pbnds_gbuffer *gbuffer,
    struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_GBUFFER_PLANES_H */
