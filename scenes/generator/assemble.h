/**
 * @file assemble.h
 * Small tools of the object builders: pieces put together to meshes, points to tubes,
 * outlines to solids.
 */
#ifndef PBNDS_SCENES_ASSEMBLE_H
#define PBNDS_SCENES_ASSEMBLE_H

#include "scenes/generator/objects.h"

/** The quaternion that turns nothing. */
extern const struct pbnds_vec4 GEN_REST;
extern const struct pbnds_vec3 GEN_X, GEN_Y, GEN_Z;

/** Moves `piece` into `whole` at a pose and empties it. */
void gen_put(struct gen_mesh *whole, struct gen_mesh *piece, struct pbnds_vec3 t,
             struct pbnds_vec4 q);
void gen_put_block(struct gen_mesh *whole, struct pbnds_vec3 half, float bevel,
                   struct pbnds_vec3 t, struct pbnds_vec4 q);
void gen_put_frustum(struct gen_mesh *whole, float bottom, float top, float half,
                     struct pbnds_vec3 t, struct pbnds_vec4 q, int segments);
void gen_put_ball(struct gen_mesh *whole, struct pbnds_vec3 centre,
                  struct pbnds_vec3 radii, int segments);
/** Makes the normals and moves the mesh into the object opened last; empty meshes are
 *  left out. */
void gen_finish(const struct gen_maker *k, struct gen_mesh *m, float crease,
                int material);
/** A material for sheets, which are seen from both sides. */
int gen_sheet_material(const struct gen_maker *k);
/** Rotation that takes +y to the unit vector d by the shortest way. */
struct pbnds_vec4 gen_aim(struct pbnds_vec3 d);

/** A tube along a polyline of at least 2 points (3 when closed). */
struct gen_tube {
    const struct pbnds_vec3 *points;
    int count;
    bool closed;
    const float *radius; /**< at each point; NULL: `thickness` everywhere     */
    float thickness;
    float flat; /**< 1 round; less: a ribbon                         */
    int sides;  /**< 3 or more                                       */
};
/** Frames are carried along without a twist (parallel transport); ends are capped. */
void gen_tube(struct gen_mesh *m, const struct gen_tube *tube);

enum { GEN_OUTLINE_MAX = 256 };

/** A plate in the xy plane: outline counter-clockwise and star-shaped about the origin,
 *  2 half thick, optionally with a hole of the same number of points. */
struct gen_plate {
    struct pbnds_vec2 outline[GEN_OUTLINE_MAX];
    int count;
    float half, bevel;
    float hole; /**< share of the outline that is cut out of the middle; 0: none */
    float twist, taper; /**< turn (radians) and change of size from back to front   */
    int steps;          /**< layers; 1 where neither twisted nor tapered            */
};
void gen_plate(struct gen_mesh *m, const struct gen_plate *plate);

/** Catmull-Rom curve through `knots` points, `steps` points a span, into out[]; open:
 *  (knots - 1) steps + 1 points, closed: knots steps. @return their number */
int gen_curve(const struct pbnds_vec3 *knot, int knots, bool closed, int steps,
              struct pbnds_vec3 *out);

#endif /* PBNDS_SCENES_ASSEMBLE_H */
