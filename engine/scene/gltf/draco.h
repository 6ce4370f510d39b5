/**
 * @file draco.h
 * One mesh of KHR_draco_mesh_compression: triangles and attributes by their unique ids.
 * gltf/draco.cpp is the only file that includes libdraco. Private to the loader.
 *
 * The data may be hostile: what they claim is weighed before anything is allocated for
 * it, and nothing that the library throws comes out of here.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_DRACO_H
#define PBNDS_ENGINE_SCENE_GLTF_DRACO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

#ifdef __cplusplus
extern "C" {
#endif

struct pbnds_draco;

/** What is expected of the data, and what they may take. */
struct pbnds_draco_limits {
    uint64_t triangles; /**< exactly so many; UINT64_MAX: any number */
    uint64_t vertices;  /**< exactly so many; UINT64_MAX: any number */
    uint64_t bytes;     /**< at most so much memory while decoding   */
};

/** Decodes. Free with pbnds_draco_free(). `name` is for messages.
 *  Errors: FORMAT (damaged, other counts than expected), UNSUPPORTED (a point cloud, an
 *  older bit stream than 2.2, the one that the extension names), MEMORY. */
enum pbnds_status pbnds_draco_decode(const uint8_t *bytes, size_t size,
                                     const char *name,
                                     const struct pbnds_draco_limits *limits,
                                     struct pbnds_draco **mesh,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_draco_free(struct pbnds_draco *mesh);

uint64_t pbnds_draco_triangles(const struct pbnds_draco *mesh);
uint64_t pbnds_draco_vertices(const struct pbnds_draco *mesh);

/** 3 * triangles unsigned integers of 1, 2 or 4 bytes. False where one does not fit. */
bool pbnds_draco_indices(const struct pbnds_draco *mesh, size_t bytes, void *out);

/** The attribute with that unique id, for every vertex: `width` components of a type
 *  of glTF (`component`, its GL constant), packed. False where there is none, or it has
 *  another width, or values that do not fit the type. */
bool pbnds_draco_attribute(const struct pbnds_draco *mesh, int64_t id, int width,
                           int component, void *out);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_GLTF_DRACO_H */
