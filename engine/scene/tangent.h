/**
 * @file tangent.h
 * Tangents for normal maps where a file brings none.
 */
#ifndef PBNDS_ENGINE_SCENE_TANGENT_H
#define PBNDS_ENGINE_SCENE_TANGENT_H

#include "engine/core/error.h"
#include "engine/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Fills mesh->tangent (newly allocated) by MikkTSpace, as glTF 2.0, section 3.7.2.1 says,
 * from positions, unit normals and UV set `set`, which must be there. w is the handedness:
 * bitangent = cross(normal, tangent) * w points to -v, as glTF normal maps want.
 *
 * A vertex whose triangles disagree, as on a mirrored seam, becomes several: all
 * attributes follow. Without normals every triangle gets three vertices of its own, for
 * the tangents of flat faces. Vertices without usable UVs get any tangent.
 *
 * @param origin  if not NULL, *origin is set to an array (the caller frees it) of which
 *                vertex each vertex was before, or to NULL where none was added. On failure
 *                it is NULL and the mesh is still sound, with or without tangents
 * Errors: MEMORY.
 */
enum pbnds_status pbnds_mesh_tangents(struct pbnds_mesh *mesh, int set,
                                      uint32_t **origin, const char *name,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

/** Bytes that pbnds_mesh_tangents() needs at most beyond what the mesh has: its work, and
 *  the vertices it may add. */
uint64_t pbnds_mesh_tangents_need(const struct pbnds_mesh *mesh);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_TANGENT_H */
