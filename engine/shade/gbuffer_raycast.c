/* The ray cast of point-sampled G-buffers: packets in tiles, one ray a pixel. */
#include "engine/core/parallel.h"
#include "engine/shade/gbuffer_planes.h"

enum {
    TILE = 16, /* pixels a side, the unit of work of a thread          */
    BLOCK = 4, /* pixels a side of the square that one packet covers; BLOCK * BLOCK is
                  PBNDS_PACKET */
};

static void store(float *const planes[3], size_t i, struct pbnds_vec3 v)
{
    planes[0][i] = v.x;
    planes[1][i] = v.y;
    planes[2][i] = v.z;
}

bool pbnds_scene_needs_fresnel(const struct pbnds_scene *scene)
{
    for (int i = 0; i < scene->mesh_count; ++i) {
        const struct pbnds_material *m = &scene->materials[scene->meshes[i].material];
        const struct pbnds_vec3 c = m->specular_color;
        const bool white = c.x == 1.0f && c.y == 1.0f && c.z == 1.0f;
        if (m->unlit || m->specular_glossiness || m->specular != 1.0f || !white ||
            m->specular_texture.texture >= 0 || m->specular_color_texture.texture >= 0)
            return true;
    }
    return false;
}

struct pbnds_vec2 pbnds_image_motion(const struct pbnds_camera_view *now,
                                     const struct pbnds_camera_view *before,
                                     struct pbnds_vec3 position,
                                     struct pbnds_vec3 previous)
{
    struct pbnds_vec2 motion = {0.0f, 0.0f}, p, q;
    if (pbnds_camera_view_project(now, position, &p.x, &p.y) &&
        pbnds_camera_view_project(before, previous, &q.x, &q.y)) {
        motion.x = p.x - q.x;
        motion.y = p.y - q.y;
    }
    return motion;
}

/* What one call of the parallel loop needs. */
struct raycast {
    const struct pbnds_scene *scene;
    const struct pbnds_accel *accel;
    struct pbnds_gbuffer *gbuffer;
    struct pbnds_camera_view view, previous_view;
    size_t tiles_across;
};

/* The planes that only some G-buffers have. */
static void store_optional(const struct raycast *job, size_t i,
                           const struct pbnds_hit *hit, const struct pbnds_surface *s,
                           struct pbnds_vec3 f0)
{
    struct pbnds_gbuffer *g = job->gbuffer;
    if (g->f90) {
        store(g->f0, i, f0);
        g->f90[i] = s->f90 + s->metallic * (1.0f - s->f90);
    }
    if (g->ao) g->ao[i] = s->occlusion;
    if (g->uv[0]) {
        g->uv[0][i] = s->uv.x;
        g->uv[1][i] = s->uv.y;
    }
    if (g->motion[0]) {
        const struct pbnds_vec2 m =
            pbnds_image_motion(&job->view, &job->previous_view, s->position,
                               pbnds_scene_previous(job->scene, hit));
        g->motion[0][i] = m.x;
        g->motion[1][i] = m.y;
    }
    if (g->material_id) g->material_id[i] = (uint32_t)s->material;
}

/* The planes of a pixel that was hit; all others keep their zeros. */
static void store_hit(const struct raycast *job, size_t i, const struct pbnds_hit *hit,
                      struct pbnds_vec3 direction)
{
    struct pbnds_gbuffer *g = job->gbuffer;
    struct pbnds_surface s;
    pbnds_scene_surface(job->scene, hit, pbnds_scale(direction, -1.0f), 0.0f, &s);
    const struct pbnds_vec3 f0 = pbnds_lerp(s.f0, s.base_color, s.metallic);
    store(g->albedo, i, s.base_color);
    store(g->normal, i, s.n);
    g->specular[i] = pbnds_luminance(f0);
    g->roughness[i] = s.roughness;
    g->metallic[i] = s.metallic;
    g->depth[i] = pbnds_dot(pbnds_sub(s.position, job->view.eye), job->view.forward);
    g->coverage[i] = 1.0f;
    store(g->position, i, s.position);
    store(g->emission, i, s.emission);
    store(g->geometric_normal, i, s.ng);
    g->object_id[i] = s.object_id;
    store_optional(job, i, hit, &s, f0);
}

static void store_miss(const struct pbnds_gbuffer *g, size_t i)
{
    g->depth[i] = INFINITY;
    g->object_id[i] = UINT32_MAX;
    if (g->material_id) g->material_id[i] = UINT32_MAX;
}

/* One packet. Blocks at the edge cast rays beyond it too, and drop what those hit. */
static void cast_block(const struct raycast *job, int x0, int y0)
{
    struct pbnds_gbuffer *g = job->gbuffer;
    struct pbnds_ray rays[PBNDS_PACKET];
    struct pbnds_hit hits[PBNDS_PACKET];
    for (int k = 0; k < PBNDS_PACKET; ++k) {
        const int x = x0 + k % BLOCK, y = y0 + k / BLOCK;
        rays[k] = pbnds_camera_view_ray(&job->view, (float)x + 0.5f, (float)y + 0.5f);
    }
    pbnds_accel_intersect_packet(job->accel, rays, PBNDS_PACKET, hits);
    for (int k = 0; k < PBNDS_PACKET; ++k) {
        const int x = x0 + k % BLOCK, y = y0 + k / BLOCK;
        if (x >= g->width || y >= g->height) continue;
        const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
        if (hits[k].mesh == UINT32_MAX)
            store_miss(g, i);
        else
            store_hit(job, i, &hits[k], rays[k].direction);
    }
}

static void cast_tile(void *context, size_t tile, int thread)
{
    (void)thread;
    const struct raycast *job = context;
    const int x0 = (int)(tile % job->tiles_across) * TILE;
    const int y0 = (int)(tile / job->tiles_across) * TILE;
    for (int y = y0; y < y0 + TILE && y < job->gbuffer->height; y += BLOCK) {
        for (int x = x0; x < x0 + TILE && x < job->gbuffer->width; x += BLOCK) {
            cast_block(job, x, y);
        }
    }
}

enum pbnds_status
pbnds_gbuffer_raycast(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                      const struct pbnds_camera *camera, int width, int height,
                      const struct pbnds_raycast_options *options,
                      struct pbnds_gbuffer *gbuffer, struct pbnds_error *error)
{
    static const struct pbnds_raycast_options plain = {.optional = 0};
    if (!options) options = &plain;
    PBNDS_TRY(pbnds_gbuffer_allocate(gbuffer, width, height, options->optional,
                                     pbnds_scene_needs_fresnel(scene), error));
    gbuffer->camera = *camera;
    gbuffer->samples = options->samples > 1 ? options->samples : 1;
    gbuffer->through = options->through;
    const struct pbnds_camera *before =
        options->previous_camera ? options->previous_camera : camera;
    struct raycast job = {
        .scene = scene,
        .accel = accel,
        .gbuffer = gbuffer,
        .view = pbnds_camera_view(camera, width, height),
        .previous_view = pbnds_camera_view(before, width, height),
        .tiles_across = ((size_t)width + TILE - 1) / TILE,
    };
    enum pbnds_status status = PBNDS_OK;
    if (pbnds_raycast_is_antialiased(accel, options)) {
        status =
            pbnds_gbuffer_raycast_antialiased(scene, accel, options, gbuffer, error);
    } else {
        const size_t tiles_down = ((size_t)height + TILE - 1) / TILE;
        pbnds_parallel_for(job.tiles_across * tiles_down, cast_tile, &job);
    }
    if (status == PBNDS_OK && pbnds_stop_requested())
        status = pbnds_fail_interrupted(error);
    if (status != PBNDS_OK) pbnds_gbuffer_free(gbuffer);
    return status;
}
