/**
 * @file deform.h
 * Bends whole meshes; normals must be made afterwards.
 */
#ifndef PBNDS_SCENES_DEFORM_H
#define PBNDS_SCENES_DEFORM_H

#include "scenes/generator/mesh.h"
#include "scenes/generator/random.h"

enum gen_relief { GEN_ROLLING, GEN_RIDGED, GEN_CRATERED };

/** Moves each point along its smooth normal by up to `height`. */
void gen_displace(struct gen_mesh *m, enum gen_relief relief, float frequency,
                  float height, int octaves, uint32_t seed);
/** Turns about y by `turn` radians per metre of height. */
void gen_twist(struct gen_mesh *m, float turn);
/** Scales x and z by 1 + rate y. */
void gen_taper(struct gen_mesh *m, float rate);
/** Bends the y axis into an arc of the given curvature in the xy plane. */
void gen_bend(struct gen_mesh *m, float curvature);

#endif /* PBNDS_SCENES_DEFORM_H */
