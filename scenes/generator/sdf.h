/**
 * @file sdf.h
 * Solids as signed distance functions (negative inside): a list of primitives combined
 * one after the other, meshed with vertices on the surface and its gradient as normals.
 */
#ifndef PBNDS_SCENES_SDF_H
#define PBNDS_SCENES_SDF_H

#include "scenes/generator/mesh.h"
#include "scenes/generator/random.h"

enum gen_sdf_kind {
    GEN_SDF_ELLIPSOID, /**< size: radii                                        */
    GEN_SDF_BOX,       /**< size: halves; round: radius of its edges           */
    GEN_SDF_CONE,      /**< round cone from a (radius size.x) to b (size.y)    */
    GEN_SDF_TORUS,     /**< about the local y; size.x radius, size.y tube      */
    GEN_SDF_CYLINDER,  /**< about the local y; size.x radius, size.y half height */
    GEN_SDF_GYROID,    /**< |gyroid| sheet; size.x cell, size.y half thickness */
};

enum gen_sdf_combine { GEN_UNION, GEN_CUT, GEN_INTERSECT };

/** Blends are smooth over the width `blend` (Quilez's polynomial smooth minimum). */
struct gen_sdf_op {
    enum gen_sdf_kind kind;
    enum gen_sdf_combine combine;
    float blend;
    struct pbnds_vec3 a, b; /**< a: centre */
    struct pbnds_vec4 turn; /**< local to world, unit quaternion */
    struct pbnds_vec3 size;
    float round;
    bool mirror; /**< there is another one at -x */
};

enum { GEN_SDF_MAX = 48 };

struct gen_sdf {
    struct gen_sdf_op ops[GEN_SDF_MAX];
    int count;
    float relief, relief_frequency; /**< fractal noise added to the distance */
    uint32_t seed;
};

/** Appends an operation with everything at rest: union, no turn, no mirror; NULL never:
 *  when the list is full the last one is reused. */
struct gen_sdf_op *gen_sdf_add(struct gen_sdf *s, enum gen_sdf_kind kind,
                               struct pbnds_vec3 centre, struct pbnds_vec3 size,
                               float blend);
struct gen_sdf_op *gen_sdf_cone(struct gen_sdf *s, struct pbnds_vec3 a,
                                struct pbnds_vec3 b, float radius_a, float radius_b,
                                float blend);

/** A ball about an operation's primitive: outside of it the distance is at least
 *  (|p - centre| - radius) / stretch. */
struct gen_sdf_ball {
    struct pbnds_vec3 centre;
    float radius, stretch;
};

/** A finished list, made ready for many evaluations. */
struct gen_sdf_field {
    const struct gen_sdf *sdf; /**< borrowed; must not change */
    struct gen_sdf_ball balls[GEN_SDF_MAX];
};

void gen_sdf_prepare(struct gen_sdf_field *field, const struct gen_sdf *s);
float gen_sdf_eval(const struct gen_sdf_field *field, struct pbnds_vec3 p);
/** Box around all unions (what cuts and intersections take away is not looked at). */
void gen_sdf_bounds(const struct gen_sdf *s, struct pbnds_vec3 *lo,
                    struct pbnds_vec3 *hi);
/** Appends the surface within the box [lo, hi], `cells` cells on its longest side, with
 *  normals and box texture coordinates (one repeat a metre). */
void gen_sdf_mesh(const struct gen_sdf *s, struct pbnds_vec3 lo, struct pbnds_vec3 hi,
                  int cells, struct gen_mesh *m);

#endif /* PBNDS_SCENES_SDF_H */
