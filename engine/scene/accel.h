/**
 * @file accel.h
 * The BVH: Embree 3 behind a small interface (accel.c is the only file that includes it).
 * Queries are thread-safe.
 *
 * Back faces. Camera rays (packets, and queries with `cull`) do not see a surface from
 * behind unless its material is double sided (glTF 2.0, 3.9.6). Other rays do: light does
 * not pass through a wall that the camera looks through.
 *
 * Transparency, decided by an intersection filter. A ray without a seed sees a MASK
 * surface where alpha >= its cutoff and a BLEND surface where alpha >= 1/2, and nothing
 * of them elsewhere. A stochastic ray sees a BLEND surface with probability alpha: the
 * choice is a hash of (seed, mesh, layer), so that the mean over seeds is the
 * composite over all layers, in any order of traversal. Triangles that share the edge or
 * corner that a ray meets are one layer.
 */
#ifndef PBNDS_ENGINE_SCENE_ACCEL_H
#define PBNDS_ENGINE_SCENE_ACCEL_H

#include <stdbool.h>

#include "engine/scene/packet.h"
#include "engine/scene/scene.h"

struct pbnds_accel; /* opaque; borrows the scene, which must outlive it */

#ifdef __cplusplus
extern "C" {
#endif

/** How a tree is built: for the measurement that chose. */
struct pbnds_accel_flags {
    bool robust;  /**< no ray slips through the edge that two triangles share */
    bool compact; /**< triangles are looked up by index, not copied           */
};

/** Robust and not compact. Errors: MEMORY, BACKEND, ARGUMENT (an index past the vertices of its mesh). A scene without triangles is fine: every ray misses. */
enum pbnds_status pbnds_accel_create(const struct pbnds_scene *scene,
                                     struct pbnds_accel **accel,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
enum pbnds_status pbnds_accel_create_as(const struct pbnds_scene *scene,
                                        const struct pbnds_accel_flags *flags,
                                        struct pbnds_accel **accel,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_accel_free(struct pbnds_accel *accel);
/** Memory that Embree holds for it, its copy of the vertices included, bytes. */
uint64_t pbnds_accel_bytes(const struct pbnds_accel *accel);

/** Which part of a ray counts, and how it meets transparent surfaces. */
struct pbnds_query {
    float min_t,
        max_t;        /**< hits lie in (min_t, max_t); max_t may be INFINITY         */
    bool stochastic;  /**< BLEND by chance                                           */
    bool blend_solid; /**< BLEND and MASK surfaces stop the ray wherever alpha > 0
                             (MASK: >= cutoff); for callers that weigh layers themselves */
    bool cull;        /**< one-sided surfaces are not there from behind              */
    uint32_t seed;    /**< of a stochastic ray                                       */
};

/** Closest hit of the query; hit->mesh is UINT32_MAX on a miss. */
void pbnds_accel_intersect_query(const struct pbnds_accel *accel,
                                 const struct pbnds_ray *ray,
                                 const struct pbnds_query *query,
                                 struct pbnds_hit *hit);
bool pbnds_accel_occluded_query(const struct pbnds_accel *accel,
                                const struct pbnds_ray *ray,
                                const struct pbnds_query *query);
/** Has the scene any surface that a stochastic ray may pass through? */
bool pbnds_accel_blends(const struct pbnds_accel *accel);

/** Closest hit with t in (0, inf). hit->mesh is UINT32_MAX on a miss. */
void pbnds_accel_intersect(const struct pbnds_accel *accel, const struct pbnds_ray *ray,
                           struct pbnds_hit *hit);
/** Is anything in (0, max_t)? max_t may be INFINITY. */
bool pbnds_accel_occluded(const struct pbnds_accel *accel, const struct pbnds_ray *ray,
                          float max_t);
/** The same for `count` <= PBNDS_PACKET coherent camera rays at once: one-sided surfaces
 *  are not there from behind. */
void pbnds_accel_intersect_packet(const struct pbnds_accel *accel,
                                  const struct pbnds_ray *rays, int count,
                                  struct pbnds_hit *hits);
/** The same for a full packet in arrays. */
void pbnds_accel_intersect_lanes(const struct pbnds_accel *accel,
                                 const struct pbnds_ray_packet *rays,
                                 struct pbnds_hit_packet *hits);
void pbnds_accel_occluded_packet(const struct pbnds_accel *accel,
                                 const struct pbnds_ray *rays, int count, float max_t,
                                 bool *occluded);

/** A measuring stick: Embree with next to nothing around it. Makes the primary rays of an
 *  image by packets of 4 x 4 pixels in tiles, on every thread, asks for their closest
 *  hits and drops these. @return how many rays hit something */
uint64_t pbnds_accel_bare_primary(const struct pbnds_accel *accel,
                                  const struct pbnds_camera_view *view, int width,
                                  int height);

/** The same for paths: from a ray through each pixel's centre on, as often as `paths` says,
 *  up to `bounces` surfaces, each left along a random direction of the hemisphere about the
 *  face, with one shadow ray along another. @return how many rays were cast */
uint64_t pbnds_accel_bare_paths(const struct pbnds_accel *accel,
                                const struct pbnds_camera_view *view, int width,
                                int height, int paths, int bounces);

/** Start of a secondary ray: p moved off the surface along ng (which must face the new
 *  direction's side) by an amount scaled to float precision. Waechter and Binder 2019, "A
 *  Fast and Robust Method for Avoiding Self-Intersection". */
struct pbnds_vec3 pbnds_offset_origin(struct pbnds_vec3 p, struct pbnds_vec3 ng);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_ACCEL_H */
