/**
 * @file generate.h
 * Procedural worlds and light maps, in memory: the public side of the generator. Data for
 * training without limit; nothing is read, nothing but memory is used, any number of
 * threads may call at the same time.
 *
 * What comes out is a pure function of (seed, index) and of PBNDS_WORLD_VERSION, in any
 * order and on any thread; between machines it is the same where the C mathematics library
 * is.
 *
 *     uint8_t *glb;
 *     size_t size;
 *     PBNDS_TRY(pbnds_world_generate(1, 42, &glb, &size, error));
 *     status = pbnds_gltf_load_memory(glb, size, "world 42", NULL, NULL, report, &scene, error);
 *     free(glb);
 */
#ifndef PBNDS_SCENES_GENERATE_H
#define PBNDS_SCENES_GENERATE_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

/** Goes up with every change that makes other worlds or light maps of the same (seed,
 *  index): a data set records it, and goes on only with the same. */
enum { PBNDS_WORLD_VERSION = 3 };

#if defined(__GNUC__)
#define PBNDS_GENERATE_API __attribute__((visibility("default")))
#else
#define PBNDS_GENERATE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** World `index` of `seed`: a binary glTF 2.0 file without references to others (meshes,
 *  materials, PNG textures; +y up, metres; the radius of its bounds is 0.5 to 2, their
 *  centre the origin; no camera, no light but surfaces that glow). *glb is malloc'd and the
 *  caller's to free(); NULL on failure. Errors: MEMORY. */
PBNDS_GENERATE_API enum pbnds_status
pbnds_world_generate(uint64_t seed, uint64_t index, uint8_t **glb, size_t *size,
                     struct pbnds_error *error) PBNDS_NODISCARD;

/** Light map `index` of `seed` into rgb[width * height * 3], which the caller owns: linear
 *  Rec. 709 radiance, equirect, gltf convention, row 0 up (sky.h gives the formula).
 *  width and height are at least 1; width = 2 height gives square texels. */
PBNDS_GENERATE_API void pbnds_sky_generate(uint64_t seed, uint64_t index, int width,
                                           int height, float *rgb);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_SCENES_GENERATE_H */
