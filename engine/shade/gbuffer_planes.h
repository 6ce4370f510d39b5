/**
 * @file gbuffer_planes.h
 * How the files that fill a G-buffer get its memory. Not for shaders.
 */
#ifndef PBNDS_ENGINE_SHADE_GBUFFER_PLANES_H
#define PBNDS_ENGINE_SHADE_GBUFFER_PLANES_H

#include <stdbool.h>

#include "engine/shade/gbuffer.h"

enum { PBNDS_PLANES_MAX = 40 };

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

/** The same with planes that hold anything, for those who write every pixel of each. */
enum pbnds_status pbnds_gbuffer_reserve(struct pbnds_gbuffer *gbuffer, int width,
                                        int height, unsigned optional, bool fresnel,
                                        struct pbnds_error *error) PBNDS_NODISCARD;

/** The planes that a G-buffer has, in the order in which they lie. @return how many */
int pbnds_gbuffer_list(const struct pbnds_gbuffer *gbuffer,
                       char *planes[PBNDS_PLANES_MAX]);

/** Makes every plane of *gbuffer, which is a copy of another's fields, point into `memory`
 *  instead, `bytes` apart. */
void pbnds_gbuffer_point_into(struct pbnds_gbuffer *gbuffer, void *memory,
                              size_t bytes);

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
