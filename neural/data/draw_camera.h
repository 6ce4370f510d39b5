/**
 * @file draw_camera.h
 * Cameras of samples: on shells about the scene or about one of its objects, near to a
 * surface, inside a room, or near a camera of the file; such that they see enough, stand
 * in nothing and against nothing, and have their subject in the picture.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_CAMERA_H
#define PBNDS_NEURAL_DATA_DRAW_CAMERA_H

#include "engine/core/rng.h"
#include "engine/scene/accel.h"
#include "engine/scene/camera.h"
#include "engine/scene/scene.h"
#include "neural/data/draw_subject.h"

enum pbnds_shot_kind {
    PBNDS_SHOT_SCENE,    /**< all of it                                              */
    PBNDS_SHOT_OBJECT,   /**< one object, the others around it                       */
    PBNDS_SHOT_PORTRAIT, /**< one upright thing, from the front                      */
    PBNDS_SHOT_DETAIL,   /**< a piece of a surface, which may fill the picture       */
    PBNDS_SHOT_ROOM,     /**< from inside                                            */
    PBNDS_SHOT_FILE,     /**< a camera of the file, moved a little                   */
    PBNDS_SHOT_COUNT
};

/** A camera and how it was chosen. */
struct pbnds_shot {
    struct pbnds_camera camera;
    enum pbnds_shot_kind kind;
    uint32_t object; /**< of the subject, UINT32_MAX: not one object                 */
    float roll_deg;
    float focus;  /**< distance of what is looked at, metres                         */
    int attempts; /**< cameras that were tried, with this one                        */
};

#ifdef __cplusplus
extern "C" {
#endif

const char *pbnds_shot_name(enum pbnds_shot_kind kind);

/** @return false: none of the attempts was good */
bool pbnds_draw_camera(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                       const struct pbnds_subjects *subjects, float aspect,
                       struct pbnds_rng *rng, struct pbnds_shot *shot);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DRAW_CAMERA_H */
