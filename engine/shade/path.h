/**
 * @file path.h
 * One path of light, from the eye: what a sample of the reference is made of.
 *
 * At each surface one light is drawn by the light table (map, punctual, emitting triangle)
 * and asked by a shadow ray; one direction is drawn from the BRDF, and its ray finds the
 * next surface, or the map. Light of the map and of emitting triangles is found both ways
 * and each way counts by the balance heuristic, p_i / (p_light + p_brdf) (Veach 1997, eq.
 * 9.8), with p_light = p(choice) p(point). Punctual lights are found by the first way
 * alone, unlit surfaces by the second alone. From the fourth surface on a path goes on
 * with probability min(max throughput, 0.95) and is weighed by its inverse.
 *
 * Normals. Light that comes from below the shading normal or below the face is none. So
 * that what a smooth surface mirrors is not lost there, pbnds_scene_surface() has bent the
 * normal until its mirror direction leaves the face; the same normal is in the G-buffer,
 * and every shader has it. It depends on wo: the BSDF is reciprocal, a bent point is not.
 *
 * The one bias: a path visits at most max_bounces surfaces after the first. Of a closed
 * room whose walls reflect a share a of the light, a^(max_bounces + 1) is missing. Nothing
 * is clamped.
 *
 * Every ray of a scene that blends (pbnds_accel_blends) meets transparent surfaces by
 * chance, with a seed of its own, so that the layers of two rays are independent.
 */
#ifndef PBNDS_ENGINE_SHADE_PATH_H
#define PBNDS_ENGINE_SHADE_PATH_H

#include "engine/scene/accel.h"
#include "engine/scene/envmap.h"
#include "engine/shade/bsdf.h"
#include "engine/shade/light_table.h"
#include "engine/shade/sampler.h"

/** What all paths of a picture share. Borrowed, immutable. */
struct pbnds_path_world {
    const struct pbnds_scene *scene;
    const struct pbnds_accel *accel;
    const struct pbnds_envmap *envmap; /**< or NULL */
    const struct pbnds_light_table *lights;
    int max_bounces;
    bool blends; /**< pbnds_accel_blends() */
};

/** The surface point that a path has come to. */
struct pbnds_path_vertex {
    struct pbnds_vec3 position, ng, wo;
    struct pbnds_bsdf bsdf;
};

/** Radiance toward the eye, W m^-2 sr^-1. */
struct pbnds_path_light {
    struct pbnds_vec3 total;
    struct pbnds_vec3
        direct; /**< that which came to the first surface from no other one:
                                   of the map and of punctual lights                    */
};

#ifdef __cplusplus
extern "C" {
#endif

/** A path that starts at a known surface, whose own emission is not counted. */
void pbnds_path_trace(const struct pbnds_path_world *world,
                      const struct pbnds_path_vertex *first,
                      const struct pbnds_sampler *sampler,
                      struct pbnds_path_light *light);
/** A path that starts at the eye. The texture footprint of the first surface, at distance
 *  t, is cone[0] t + cone[1]. Its emission counts, in both sums. false: the ray leaves the
 *  scene, and there is no light. */
bool pbnds_path_trace_camera(const struct pbnds_path_world *world,
                             const struct pbnds_ray *ray, const float cone[2],
                             const struct pbnds_sampler *sampler,
                             struct pbnds_path_light *light);

/** What a walk tells of a surface that it came to. */
struct pbnds_path_visit {
    const struct pbnds_path_vertex *vertex;
    struct pbnds_vec3 throughput; /**< of what leaves the vertex toward the path     */
    int bounce;                   /**< surfaces before it                            */
};
/** The same paths for those who gather light along them themselves: calls `visit` at every
 *  surface, the first one with it, and neither asks lights nor counts emission. Decisions
 *  are those of pbnds_path_trace() to the bit. */
void pbnds_path_walk(const struct pbnds_path_world *world,
                     const struct pbnds_path_vertex *first,
                     const struct pbnds_sampler *sampler,
                     void (*visit)(void *context, const struct pbnds_path_visit *visit),
                     void *context);
/** false: the ray leaves the scene, and nothing was visited. */
bool pbnds_path_walk_camera(
    const struct pbnds_path_world *world, const struct pbnds_ray *ray,
    const float cone[2], const struct pbnds_sampler *sampler,
    void (*visit)(void *context, const struct pbnds_path_visit *visit), void *context);
/** n.wi, or 0 where the surface itself is in the way: below either of its normals. */
float pbnds_path_cosine(const struct pbnds_path_vertex *vertex, struct pbnds_vec3 wi);
/** Set of the sampler for the position within the pixel. */
enum { PBNDS_PATH_SET_PIXEL = 0x7fffffff };

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_PATH_H */
