/**
 * @file light_emissive.h
 * Surfaces that emit, as lights: a list of the triangles of every material with emission,
 * and points on them.
 *
 * A point is uniform on the triangle's area; seen from p at distance d its density in
 * solid angle is d^2 / (A |cos_l|), cos_l between the way and the triangle's normal. Both
 * sides emit, as a ray that hits either sees it (scene.h). Unlit surfaces are not in the
 * list: their colour is a picture, not a light; a ray that happens to hit one sees it.
 *
 * Units: metres, 1/sr, W m^-2 sr^-1 linear Rec. 709. Threads: immutable once made.
 */
#ifndef PBNDS_ENGINE_SHADE_LIGHT_EMISSIVE_H
#define PBNDS_ENGINE_SHADE_LIGHT_EMISSIVE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"
#include "engine/scene/scene.h"

struct pbnds_emissive_triangle {
    uint32_t mesh, triangle;
    float area;  /**< m^2 */
    float power; /**< W, luminance, of both sides. An estimate, good for choosing only:
                      of a textured triangle a few points stand for the mean */
};

struct pbnds_emissive {
    const struct pbnds_scene *scene; /**< borrowed */
    struct pbnds_emissive_triangle *triangles;
    size_t count;
    size_t
        *first; /**< one a mesh: index of its triangle 0, SIZE_MAX: it does not emit */
};

/** A point of an emitter as it is seen from elsewhere. */
struct pbnds_emissive_sample {
    struct pbnds_hit hit;    /**< t: distance                                        */
    struct pbnds_vec3 wi;    /**< unit, to the point                                 */
    float pdf;               /**< 1/sr, of the point on its own triangle             */
    struct pbnds_vec3 reach; /**< the point, moved off its surface to this side: where
                                  a shadow ray may end                               */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Errors: MEMORY. A scene without emitters gives an empty list. */
enum pbnds_status pbnds_emissive_create(const struct pbnds_scene *scene,
                                        struct pbnds_emissive *emissive,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_emissive_free(struct pbnds_emissive *emissive);

/** Index of a triangle of the scene in the list; SIZE_MAX: it is not in it. */
size_t pbnds_emissive_find(const struct pbnds_emissive *emissive, uint32_t mesh,
                           uint32_t triangle);
/** Density of the point that a ray hit at distance t and cosine cos_l, 1/sr. */
float pbnds_emissive_pdf(const struct pbnds_emissive *emissive, size_t index, float t,
                         float cos_l);
/** u1, u2 uniform in [0, 1). false: the triangle is edge on or too small to tell. */
bool pbnds_emissive_sample(const struct pbnds_emissive *emissive, size_t index,
                           struct pbnds_vec3 from, float u1, float u2,
                           struct pbnds_emissive_sample *out);
/** What the point sends along -wi: its emission times its opacity (MASK: 0 or 1). */
struct pbnds_vec3 pbnds_emissive_radiance(const struct pbnds_emissive *emissive,
                                          const struct pbnds_emissive_sample *sample);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_LIGHT_EMISSIVE_H */
