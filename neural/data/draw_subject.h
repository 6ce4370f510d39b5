/**
 * @file draw_subject.h
 * What there is to look at in a scene: all of it, and each of its objects but those that
 * are grounds and walls. Found from bounds and a few rays, of any glTF file whose
 * materials were made double sided: back faces must be seen to tell inside from outside.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_SUBJECT_H
#define PBNDS_NEURAL_DATA_DRAW_SUBJECT_H

#include "engine/scene/accel.h"
#include "engine/scene/scene.h"

struct pbnds_subject {
    struct pbnds_vec3 lo, hi; /**< bounds, world                                     */
    uint32_t object;          /**< of the scene; UINT32_MAX: all that is no backdrop */
};

struct pbnds_subjects {
    struct pbnds_subject *items; /**< items[0]: the whole; the others: objects worth a
                                      picture of their own; owned                    */
    int count;
    bool *backdrop;    /**< one an object: wide and flat, such as a ground; owned    */
    int backdrop_size; /**< objects                                                  */
    bool upright;      /**< one thing, as tall as it is wide and not flat: it may be a
                            head or a figure, which by custom faces +z               */
    float ground; /**< height of a ground, -INFINITY: none                           */
    bool room;    /**< closed: light comes in through nothing or through gaps   */
};

#ifdef __cplusplus
extern "C" {
#endif

/** @return false: no memory */
bool pbnds_subjects_find(const struct pbnds_scene *scene,
                         const struct pbnds_accel *accel,
                         struct pbnds_subjects *subjects);
void pbnds_subjects_free(struct pbnds_subjects *subjects);

/** Unit normal of the side that a triangle's winding shows; zero where it has no area. */
struct pbnds_vec3 pbnds_hit_normal(const struct pbnds_scene *scene,
                                   const struct pbnds_hit *hit);

/** A point's surroundings, by the first hits of rays in 14 directions. */
struct pbnds_surroundings {
    int front, back; /**< hits of that side of a surface */
    float nearest;   /**< metres, INFINITY: nothing      */
};

enum { PBNDS_SURROUNDING_RAYS = 14 };

struct pbnds_surroundings pbnds_look_around(const struct pbnds_scene *scene,
                                            const struct pbnds_accel *accel,
                                            struct pbnds_vec3 eye);
/** Inside of a closed surface: most of the rays see a back face. */
static inline bool pbnds_is_inside(const struct pbnds_surroundings *around)
{
    return 2 * around->back > PBNDS_SURROUNDING_RAYS;
}

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DRAW_SUBJECT_H */
