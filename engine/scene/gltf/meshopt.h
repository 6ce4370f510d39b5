/**
 * @file meshopt.h
 * One compressed range of EXT_meshopt_compression. gltf/meshopt.c is the only file that
 * includes libmeshoptimizer. Private to the loader.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_MESHOPT_H
#define PBNDS_ENGINE_SCENE_GLTF_MESHOPT_H

#include <stddef.h>
#include <stdint.h>

/** Decodes `count` elements of `stride` bytes into `out`, which has room for them and may
 *  be larger. `mode` and `filter` are the names of the extension. Damaged data are safe:
 *  what comes out of them may be anything, and is to be checked like what a file holds.
 *  @return NULL, or why it cannot be done: rules of the extension are broken, the bytes
 *          are not what the mode says */
const char *pbnds_meshopt_decode(const char *mode, const char *filter,
                                 const uint8_t *bytes, size_t size, size_t count,
                                 size_t stride, uint8_t *out);

#endif /* PBNDS_ENGINE_SCENE_GLTF_MESHOPT_H */
