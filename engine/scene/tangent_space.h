/**
 * @file tangent_space.h
 * MikkTSpace: which tangent every corner of every triangle has. Private to tangent.c.
 *
 * M. S. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", Master's thesis,
 * University of Copenhagen 2008, chapter 3, and the standard that grew out of it
 * (http://www.mikktspace.com), which glTF 2.0, section 3.7.2.1 asks for:
 *
 *  1. corners with the same position, normal and texture coordinates are one vertex;
 *  2. a triangle has the derivatives dP/du and dP/dv and an orientation, the sign of its
 *     area in the picture; where it has no area there it takes the orientation of the
 *     first group that reaches it;
 *  3. around a vertex, triangles that are linked by shared edges and have one orientation
 *     are a group;
 *  4. a group's tangent is the sum of its triangles' dP/du, each projected onto the plane
 *     of the vertex normal, made unit and weighted by the angle that the triangle takes
 *     up in that plane.
 *
 * The angular threshold is the standard's default of 180 degrees: it splits no group.
 */
#ifndef PBNDS_ENGINE_SCENE_TANGENT_SPACE_H
#define PBNDS_ENGINE_SCENE_TANGENT_SPACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/vec.h"

/** No group: the corner has no tangent of its own. */
#define PBNDS_NO_GROUP UINT32_MAX

/** Triangles; every number is finite, normals are unit, 3 * triangle_count < 2^32. */
struct pbnds_tangent_input {
    const struct pbnds_vec3 *position, *normal;
    const struct pbnds_vec2 *uv;
    size_t vertex_count;
    const uint32_t *index;
    size_t triangle_count;
};

struct pbnds_tangent_groups {
    uint32_t *group; /**< of each corner, 3 * triangle_count, or PBNDS_NO_GROUP       */
    struct pbnds_vec4
        *tangent; /**< of each group: xyz unit, or zero where the triangles cancel
                       out; w = +-1: bitangent = w cross(n, t) points to -v            */
    size_t group_count;
};

/** False when there is no memory. Groups are to be freed by pbnds_tangent_groups_free().
 */
bool pbnds_tangent_space(const struct pbnds_tangent_input *in,
                         struct pbnds_tangent_groups *out);
void pbnds_tangent_groups_free(struct pbnds_tangent_groups *groups);

#endif /* PBNDS_ENGINE_SCENE_TANGENT_SPACE_H */
