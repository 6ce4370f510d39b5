/**
 * @file shapes.h
 * Elementary surfaces with texture coordinates, closed and counter-clockwise outside,
 * centred at the origin; call gen_mesh_shade() afterwards. `segments` is the number of
 * segments around (at least 3).
 */
#ifndef PBNDS_SCENES_SHAPES_H
#define PBNDS_SCENES_SHAPES_H

#include "scenes/generator/mesh.h"

void gen_ellipsoid(struct gen_mesh *m, struct pbnds_vec3 radii, int segments);
/** Barr 1981: exponents 1 give an ellipsoid, towards 0 a box, 2 an octahedron. */
void gen_superquadric(struct gen_mesh *m, float e_north, float e_east,
                      struct pbnds_vec3 radii, int segments);
void gen_torus(struct gen_mesh *m, float radius, float tube, int segments);
/** Tube along the (p, q) torus knot; flat < 1 makes a ribbon of it. */
void gen_knot(struct gen_mesh *m, int p, int q, float radius, float swing, float tube,
              float flat, int segments);
/** Spring about y; turns may be any number, the ends are rounded. */
void gen_spring(struct gen_mesh *m, float radius, float tube, float height, float turns,
                int segments);
/** Box with edges rounded by `radius`: radius = all halves gives a sphere. */
void gen_rounded_box(struct gen_mesh *m, struct pbnds_vec3 half, float radius,
                     int bevel_segments, int flat_segments);
/** Turns a profile (x: radius >= 0, y: height, from below to above along the outside)
 * about y. flutes > 0 carves that many grooves of relative depth flute_depth. */
void gen_lathe(struct gen_mesh *m, const struct pbnds_vec2 *profile, int count,
               int segments, int flutes, float flute_depth);
/** Cylinder or cone frustum (top 0: cone) with edges rounded by `bevel`, height 2 half.
 */
void gen_frustum(struct gen_mesh *m, float bottom, float top, float half, float bevel,
                 int segments);
void gen_capsule(struct gen_mesh *m, float radius, float half, int segments);
/** Flat rectangle in xz, facing +y. */
void gen_plane(struct gen_mesh *m, float half_x, float half_z, int segments);
/** Geodesic sphere of 6 x n x n quads on a cube, without poles. */
void gen_cube_sphere(struct gen_mesh *m, float radius, int n);

#endif /* PBNDS_SCENES_SHAPES_H */
