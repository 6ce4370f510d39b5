#include "engine/shade/path_start.h"

#include <math.h>

struct pbnds_path_lens pbnds_path_lens_make(const struct pbnds_gbuffer *gbuffer,
                                            const struct pbnds_path_world *world)
{
    return (struct pbnds_path_lens){
        gbuffer, world,
        pbnds_camera_view(&gbuffer->camera, gbuffer->width, gbuffer->height)};
}

/* Is the first surface of a pixel, of whatever opacity, one that lets nothing through?
 * It is the one of the G-buffer then. */
static bool starts_opaque(const struct pbnds_path_lens *lens, int x, int y)
{
    const struct pbnds_ray ray =
        pbnds_camera_view_ray(&lens->view, (float)x + 0.5f, (float)y + 0.5f);
    const struct pbnds_query how = {
        .max_t = INFINITY, .blend_solid = true, .cull = true};
    struct pbnds_hit hit;
    pbnds_accel_intersect_query(lens->world->accel, &ray, &how, &hit);
    if (hit.mesh == UINT32_MAX) return false;
    const struct pbnds_scene *scene = lens->world->scene;
    const int material = scene->meshes[hit.mesh].material;
    return scene->materials[material].alpha_mode != PBNDS_ALPHA_BLEND ||
           pbnds_scene_alpha(scene, &hit) >= 1.0f;
}

enum pbnds_path_start pbnds_path_start_of(const struct pbnds_path_lens *lens, int x,
                                          int y, struct pbnds_path_vertex *first)
{
    const struct pbnds_gbuffer *g = lens->gbuffer;
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    if (g->samples > 1) return PBNDS_PATH_CAMERA;
    if (lens->world->blends && !starts_opaque(lens, x, y)) return PBNDS_PATH_CAMERA;
    if (!(g->coverage[i] > 0.0f)) return PBNDS_PATH_NOWHERE;
    first->position = pbnds_gbuffer_vec3(g->position, i);
    first->ng = pbnds_gbuffer_vec3(g->geometric_normal, i);
    first->wo = pbnds_gbuffer_wo(g, x, y);
    first->bsdf = pbnds_bsdf_from_gbuffer(g, i);
    return PBNDS_PATH_SURFACE;
}

/* Width of a centre ray's cone, as the G-buffer has it: times distance, plus. Rays all over
 * the pixel average textures by their number. */
static void find_cone(const struct pbnds_path_lens *lens, const struct pbnds_ray *ray,
                      float cone[2])
{
    const struct pbnds_camera_view *view = &lens->view;
    cone[0] = cone[1] = 0.0f;
    if (lens->gbuffer->samples > 1) return;
    if (view->orthographic)
        cone[1] = view->pixel;
    else
        cone[0] = view->pixel * pbnds_dot(ray->direction, view->forward);
}

struct pbnds_ray pbnds_path_start_ray(const struct pbnds_path_lens *lens, int x, int y,
                                      const struct pbnds_sampler *sampler,
                                      float cone[2])
{
    float u[2] = {0.5f, 0.5f};
    if (lens->gbuffer->samples > 1)
        pbnds_sampler_get(sampler, PBNDS_PATH_SET_PIXEL, 2, u);
    const struct pbnds_ray ray =
        pbnds_camera_view_ray(&lens->view, (float)x + u[0], (float)y + u[1]);
    find_cone(lens, &ray, cone);
    return ray;
}
