/**
 * @file tangent.h
 * Tangents for normal maps where a file brings none.
 */
#ifndef PBNDS_ENGINE_SCENE_TANGENT_H
#define PBNDS_ENGINE_SCENE_TANGENT_H

#include "engine/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Fills mesh->tangent (newly allocated) from positions, normals (or faces) and UV set
 *  `set`: angle-weighted average over the triangles of a vertex, made orthogonal to its
 *  normal. w is the handedness: bitangent = cross(normal, tangent) * w points to -v, as
 *  glTF normal maps want. Vertices without usable UVs get any tangent. Errors: MEMORY.
 */
enum pbnds_status pbnds_mesh_tangents(struct pbnds_mesh *mesh, int set,
                                      const char *name,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_TANGENT_H */
