#include "neural/data/draw_camera.h"

#include "engine/shade/gbuffer.h"

static float uniform(struct pbnds_rng *rng, float lo, float hi)
{
    return lo + (hi - lo) * pbnds_rng_float(rng);
}

/* Enough of the picture shows something, it is not all one plane (the back of a wall),
 * and the eye is not inside or against a surface. */
static bool camera_is_good(const struct pbnds_scene *scene,
                           const struct pbnds_accel *accel,
                           const struct pbnds_camera *camera, int width, int height)
{
    struct pbnds_gbuffer g;
    if (pbnds_gbuffer_raycast(scene, accel, camera, width, height, NULL, &g, NULL) !=
        PBNDS_OK) {
        return false;
    }
    const struct pbnds_vec3 size = pbnds_sub(scene->hi, scene->lo);
    const float too_near = 0.02f * pbnds_length(size);
    const size_t count = (size_t)width * (size_t)height;
    size_t covered = 0, near = 0;
    struct pbnds_vec3 normals = pbnds_splat(0.0f);
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(g.depth[i])) continue;
        ++covered;
        if (g.depth[i] < too_near) ++near;
        normals = pbnds_add(normals, pbnds_vec3_make(g.geometric_normal[0][i],
                                                     g.geometric_normal[1][i],
                                                     g.geometric_normal[2][i]));
    }
    pbnds_gbuffer_free(&g);
    const bool flat = pbnds_length(normals) > 0.93f * (float)covered;
    return covered * 100 >= 15 * count && near * 100 <= covered && !flat;
}

/* Cameras on a shell about the scene, looking near its centre. */
bool pbnds_draw_camera(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                       float aspect, struct pbnds_rng *rng, struct pbnds_camera *camera)
{
    for (int attempt = 0; attempt < 24; ++attempt) {
        const float yaw = uniform(rng, -180.0f, 180.0f);
        const float pitch = uniform(rng, -10.0f, 55.0f);
        const float fov = uniform(rng, 20.0f, 55.0f);
        const float closer = uniform(rng, 0.45f, 1.05f);
        const struct pbnds_vec3 shift = {uniform(rng, -0.15f, 0.15f),
                                         uniform(rng, -0.15f, 0.15f),
                                         uniform(rng, -0.15f, 0.15f)};
        *camera = pbnds_camera_framing(scene->lo, scene->hi, yaw, pitch, fov, aspect);
        float *eye = &camera->world_from_camera.m[12];
        const struct pbnds_vec3 centre =
            pbnds_scale(pbnds_add(scene->lo, scene->hi), 0.5f);
        const struct pbnds_vec3 extent = pbnds_sub(scene->hi, scene->lo);
        const struct pbnds_vec3 away =
            pbnds_sub(pbnds_vec3_make(eye[0], eye[1], eye[2]), centre);
        const struct pbnds_vec3 moved =
            pbnds_add(pbnds_mad(centre, away, closer),
                      pbnds_scale(pbnds_mul(shift, extent), 1.0f));
        eye[0] = moved.x;
        eye[1] = moved.y;
        eye[2] = moved.z;
        if (camera_is_good(scene, accel, camera, 32, 32)) return true;
    }
    return false;
}
