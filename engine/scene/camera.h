/**
 * @file camera.h
 * Pinhole and orthographic cameras as in glTF 2.0: looks down its local -z, +y up.
 * Pixel centres at +0.5, row 0 on top.
 */
#ifndef PBNDS_ENGINE_SCENE_CAMERA_H
#define PBNDS_ENGINE_SCENE_CAMERA_H

#include <stdbool.h>

#include "engine/core/mat4.h"

struct pbnds_camera {
    char name[64];
    struct pbnds_mat4 world_from_camera; /**< rigid: rotation and translation       */
    bool orthographic;
    float yfov; /**< vertical field of view, radians (perspective)                 */
    float ymag; /**< half the height of the view, metres (orthographic)            */
};

struct pbnds_ray {
    struct pbnds_vec3 origin, direction; /**< direction is unit */
};

/** A camera and an image size with the trigonometry done: for loops over pixels. */
struct pbnds_camera_view {
    struct pbnds_vec3 eye, right, up, forward; /**< world; axes are unit          */
    float center_x, center_y;                  /**< middle of the image, pixels   */
    float pixel;       /**< side of a pixel: metres, at depth 1 when perspective  */
    bool orthographic;
};

/** pbnds_camera_ray() with the view worked out before; the very same bits. Inline for
 *  loops over packets. */
static inline struct pbnds_ray pbnds_camera_view_ray(const struct pbnds_camera_view *view, float x,
                                       float y)
{
    const float sx = (x - view->center_x) * view->pixel;
    const float sy = (view->center_y - y) * view->pixel;
    struct pbnds_ray ray;
    if (view->orthographic) {
        ray.origin = pbnds_mad(pbnds_mad(view->eye, view->right, sx), view->up, sy);
        ray.direction = view->forward;
    } else {
        ray.origin = view->eye;
        ray.direction = pbnds_normalize(
            pbnds_mad(pbnds_mad(view->forward, view->right, sx), view->up, sy));
    }
    return ray;
}

#ifdef __cplusplus
extern "C" {
#endif

struct pbnds_camera_view pbnds_camera_view(const struct pbnds_camera *camera, int width,
                                           int height);
/** pbnds_camera_project() with the view worked out before; the very same bits. */
bool pbnds_camera_view_project(const struct pbnds_camera_view *view,
                               struct pbnds_vec3 p, float *x, float *y);
/** Ray through image position (x, y) in pixels, e.g. (0.5, 0.5) for the first pixel. */
struct pbnds_ray pbnds_camera_ray(const struct pbnds_camera *camera, int width, int height,
                                  float x, float y);
/** Planar depth of a world point: its distance along the view axis, metres. */
float pbnds_camera_depth(const struct pbnds_camera *camera, struct pbnds_vec3 p);
/** World to camera rotation of a direction. */
struct pbnds_vec3 pbnds_camera_from_world_vector(const struct pbnds_camera *camera,
                                                 struct pbnds_vec3 v);
/** World to image position in pixels; false behind the camera. */
bool pbnds_camera_project(const struct pbnds_camera *camera, int width, int height,
                          struct pbnds_vec3 p, float *x, float *y);
/** Frames a bounding box: looks at its centre from yaw, pitch (degrees; 0,0 looks along
 *  -z from +z; positive yaw moves the eye to +x, positive pitch above) so that its
 *  bounding sphere fits the smaller side of the image. */
struct pbnds_camera pbnds_camera_framing(struct pbnds_vec3 lo, struct pbnds_vec3 hi,
                                         float yaw_deg, float pitch_deg, float yfov_deg,
                                         float aspect);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_CAMERA_H */
