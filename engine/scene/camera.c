#include "engine/scene/camera.h"

#include <stddef.h>
#include <string.h>

static struct pbnds_vec3 column(const struct pbnds_mat4 *a, int c)
{
    const float *m = &a->m[(size_t)c * 4];
    return pbnds_vec3_make(m[0], m[1], m[2]);
}

struct pbnds_camera_view pbnds_camera_view(const struct pbnds_camera *camera, int width,
                                           int height)
{
    const struct pbnds_mat4 *m = &camera->world_from_camera;
    struct pbnds_camera_view view;
    view.right = column(m, 0);
    view.up = column(m, 1);
    view.forward = pbnds_scale(column(m, 2), -1.0f);
    view.eye = column(m, 3);
    view.center_x = 0.5f * (float)width;
    view.center_y = 0.5f * (float)height;
    view.orthographic = camera->orthographic;
    /* Pixels are square: the horizontal extent follows from the size of the image. */
    const float half = camera->orthographic ? camera->ymag : tanf(0.5f * camera->yfov);
    view.pixel = half / view.center_y;
    return view;
}

struct pbnds_ray pbnds_camera_ray(const struct pbnds_camera *camera, int width,
                                  int height, float x, float y)
{
    const struct pbnds_camera_view view = pbnds_camera_view(camera, width, height);
    return pbnds_camera_view_ray(&view, x, y);
}

float pbnds_camera_depth(const struct pbnds_camera *camera, struct pbnds_vec3 p)
{
    const struct pbnds_mat4 *m = &camera->world_from_camera;
    return -pbnds_dot(pbnds_sub(p, column(m, 3)), column(m, 2));
}

struct pbnds_vec3 pbnds_camera_from_world_vector(const struct pbnds_camera *camera,
                                                 struct pbnds_vec3 v)
{
    /* The matrix is rigid: the inverse of its rotation is the transpose. */
    const struct pbnds_mat4 *m = &camera->world_from_camera;
    return pbnds_vec3_make(pbnds_dot(column(m, 0), v), pbnds_dot(column(m, 1), v),
                           pbnds_dot(column(m, 2), v));
}

bool pbnds_camera_view_project(const struct pbnds_camera_view *view,
                               struct pbnds_vec3 p, float *x, float *y)
{
    const struct pbnds_vec3 d = pbnds_sub(p, view->eye);
    const float depth = pbnds_dot(d, view->forward);
    if (!(depth > 0.0f)) return false;
    const float scale = 1.0f / (view->pixel * (view->orthographic ? 1.0f : depth));
    *x = view->center_x + pbnds_dot(d, view->right) * scale;
    *y = view->center_y - pbnds_dot(d, view->up) * scale;
    return true;
}

bool pbnds_camera_project(const struct pbnds_camera *camera, int width, int height,
                          struct pbnds_vec3 p, float *x, float *y)
{
    const struct pbnds_camera_view view = pbnds_camera_view(camera, width, height);
    return pbnds_camera_view_project(&view, p, x, y);
}

struct pbnds_camera pbnds_camera_framing(struct pbnds_vec3 lo, struct pbnds_vec3 hi,
                                         float yaw_deg, float pitch_deg, float yfov_deg,
                                         float aspect)
{
    const float degree = PBNDS_PI / 180.0f;
    const struct pbnds_vec3 center = pbnds_scale(pbnds_add(lo, hi), 0.5f);
    float radius = 0.5f * pbnds_length(pbnds_sub(hi, lo));
    if (!(radius > 0.0f)) radius = 1.0f; /* a point, or bounds of nothing */

    struct pbnds_camera camera;
    memset(&camera, 0, sizeof camera);
    memcpy(camera.name, "framing", sizeof "framing");
    camera.yfov = pbnds_clamp(yfov_deg, 0.1f, 179.0f) * degree;

    /* The sphere touches the sides of the narrower field of view: sin(half) = r / d. */
    const float half_y = 0.5f * camera.yfov;
    const float half_x = atanf(tanf(half_y) * aspect);
    const float distance = radius / sinf(fminf(half_x, half_y));

    /* The axes come from the angles, so that looking straight down keeps its yaw. */
    const float cy = cosf(yaw_deg * degree), sy = sinf(yaw_deg * degree);
    const float cp = cosf(pitch_deg * degree), sp = sinf(pitch_deg * degree);
    const struct pbnds_vec3 x = {cy, 0.0f, -sy};
    const struct pbnds_vec3 y = {-sy * sp, cp, -cy * sp};
    const struct pbnds_vec3 z = {sy * cp, sp, cy * cp};
    const struct pbnds_vec3 eye = pbnds_mad(center, z, distance);
    camera.world_from_camera = (struct pbnds_mat4){
        {x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, eye.x, eye.y, eye.z, 1}};
    return camera;
}
