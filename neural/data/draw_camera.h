/**
 * @file draw_camera.h
 * Cameras of samples: on shells about the scene, looking near its centre, that see enough
 * of it and stand in nothing.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_CAMERA_H
#define PBNDS_NEURAL_DATA_DRAW_CAMERA_H

#include "engine/core/rng.h"
#include "engine/scene/accel.h"
#include "engine/scene/camera.h"
#include "engine/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/** @return false: none of the attempts was good */
bool pbnds_draw_camera(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                       float aspect, struct pbnds_rng *rng,
                       struct pbnds_camera *camera);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DRAW_CAMERA_H */
