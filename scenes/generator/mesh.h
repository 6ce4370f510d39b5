/**
 * @file mesh.h
 * Triangle meshes under construction. Builders put positions, texture coordinates and
 * counter-clockwise triangles; gen_mesh_shade() makes the normals afterwards, smooth
 * where the surface is smooth and split where it has an edge.
 */
#ifndef PBNDS_SCENES_MESH_H
#define PBNDS_SCENES_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/mat4.h"

/** Zero-initialise. `failed` is raised when memory runs out; later calls then do
 * nothing, so that builders need no checks. */
struct gen_mesh {
    size_t vertex_count, vertex_room;
    size_t index_count, index_room;
    struct pbnds_vec3 *position;
    struct pbnds_vec3 *normal;
    struct pbnds_vec2 *uv;
    struct pbnds_vec4 *tangent; /**< NULL until gen_mesh_tangents() */
    uint32_t *index;
    bool failed;
};

void gen_mesh_free(struct gen_mesh *m);
/** @return index of the new vertex */
uint32_t gen_mesh_vertex(struct gen_mesh *m, struct pbnds_vec3 p, struct pbnds_vec2 uv);
/** Triangles with two corners at one place are left out. */
void gen_mesh_triangle(struct gen_mesh *m, uint32_t a, uint32_t b, uint32_t c);
void gen_mesh_quad(struct gen_mesh *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d);
/** Appends a copy of `other`, transformed; a mirroring transform keeps the front
 * outside. */
void gen_mesh_append(struct gen_mesh *m, const struct gen_mesh *other,
                     const struct pbnds_mat4 *transform);
void gen_mesh_transform(struct gen_mesh *m, const struct pbnds_mat4 *transform);
/** Normals: at each corner the area- and angle-weighted mean over the faces around that
 *  point whose normals differ from the corner's own face by less than crease_deg.
 * Points are the same when their coordinates are, whatever their texture coordinates.
 */
void gen_mesh_shade(struct gen_mesh *m, float crease_deg);
/** Merges vertices that differ in nothing but texture coordinates. */
void gen_mesh_weld(struct gen_mesh *m);
/** Projects each triangle along its dominant axis; splits vertices at the seams. */
void gen_mesh_box_uv(struct gen_mesh *m, float repeats_per_metre);
/** Tangents as glTF wants them: xyz along +u, w such that cross(n, t) w points along
 * -v. */
void gen_mesh_tangents(struct gen_mesh *m);
void gen_mesh_bounds(const struct gen_mesh *m, struct pbnds_vec3 *lo,
                     struct pbnds_vec3 *hi);

/** Grid over the unit square: u to the right, v upwards, front where dp/du x dp/dv
 * points. wrap: the last column or row lies exactly on the first. */
struct gen_grid {
    int nu, nv;
    bool wrap_u, wrap_v;
    struct pbnds_vec3 (*point)(const void *context, float u, float v);
    const void *context;
};
void gen_mesh_grid(struct gen_mesh *m, const struct gen_grid *grid);

#endif /* PBNDS_SCENES_MESH_H */
