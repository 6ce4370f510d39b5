#include "engine/shade/gbuffer.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"

enum {
    TILE = 16,  /* pixels a side, the unit of work of a thread          */
    BLOCK = 4,  /* pixels a side of the square that one packet covers; BLOCK * BLOCK is
                   PBNDS_PACKET */
    ALIGN = 64, /* of each plane, bytes                                 */
};

/* Every float plane, in the order in which they lie in storage. */
enum { FLOAT_PLANES = 20 };

static void list_planes(struct pbnds_gbuffer *g, float **planes[FLOAT_PLANES])
{
    int n = 0;
    for (int c = 0; c < 3; ++c)
        planes[n++] = &g->albedo[c];
    for (int c = 0; c < 3; ++c)
        planes[n++] = &g->normal[c];
    planes[n++] = &g->specular;
    planes[n++] = &g->roughness;
    planes[n++] = &g->metallic;
    planes[n++] = &g->depth;
    planes[n++] = &g->coverage;
    for (int c = 0; c < 3; ++c)
        planes[n++] = &g->position[c];
    for (int c = 0; c < 3; ++c)
        planes[n++] = &g->emission[c];
    for (int c = 0; c < 3; ++c)
        planes[n++] = &g->geometric_normal[c];
}

/* Planes of zeros in one block; depth and ids are still to be filled in. */
static enum pbnds_status allocate(struct pbnds_gbuffer *gbuffer, int width, int height,
                                  struct pbnds_error *error)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    if (width < 1 || width > 65535 || height < 1 || height > 65535) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "a G-buffer of %d x %d pixels cannot be; sides go from 1 to 65535", width,
            height);
    }
    const uint64_t count = (uint64_t)width * (uint64_t)height;
    const uint64_t plane = (count * sizeof(float) + ALIGN - 1) / ALIGN * ALIGN;
    const uint64_t total = plane * (FLOAT_PLANES + 1) + ALIGN;
    /* calloc, not a loop: large blocks come zeroed and untouched from the system, and
     * each page is then first touched by the thread that fills it. */
    if (total <= SIZE_MAX / 2) gbuffer->storage = calloc(1, (size_t)total);
    if (!gbuffer->storage) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "a G-buffer of %d x %d pixels needs %llu MB of memory; use a "
                          "smaller size",
                          width, height, (unsigned long long)(total >> 20));
    }
    char *at = gbuffer->storage;
    at += (ALIGN - (uintptr_t)at % ALIGN) % ALIGN;
    float **planes[FLOAT_PLANES];
    list_planes(gbuffer, planes);
    for (int i = 0; i < FLOAT_PLANES; ++i, at += plane)
        *planes[i] = (float *)(void *)at;
    gbuffer->object_id = (uint32_t *)(void *)at;
    gbuffer->width = width;
    gbuffer->height = height;
    return PBNDS_OK;
}

enum pbnds_status pbnds_gbuffer_init(struct pbnds_gbuffer *gbuffer, int width,
                                     int height, struct pbnds_error *error)
{
    PBNDS_TRY(allocate(gbuffer, width, height, error));
    const size_t count = (size_t)width * (size_t)height;
    for (size_t i = 0; i < count; ++i) {
        gbuffer->depth[i] = INFINITY;
        gbuffer->object_id[i] = UINT32_MAX;
    }
    gbuffer->samples = 1;
    gbuffer->camera.world_from_camera = pbnds_mat4_identity();
    return PBNDS_OK;
}

void pbnds_gbuffer_free(struct pbnds_gbuffer *gbuffer)
{
    free(gbuffer->storage);
    memset(gbuffer, 0, sizeof *gbuffer);
}

static void store(float *const planes[3], size_t i, struct pbnds_vec3 v)
{
    planes[0][i] = v.x;
    planes[1][i] = v.y;
    planes[2][i] = v.z;
}

/* What one call of the parallel loop needs. */
struct raycast {
    const struct pbnds_scene *scene;
    const struct pbnds_accel *accel;
    struct pbnds_gbuffer *gbuffer;
    struct pbnds_camera_view view;
    size_t tiles_across;
};

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
        if (hits[k].mesh == UINT32_MAX) {
            g->depth[i] = INFINITY;
            g->object_id[i] = UINT32_MAX;
        } else {
            store_hit(job, i, &hits[k], rays[k].direction);
        }
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
    (void)options;
    PBNDS_TRY(allocate(gbuffer, width, height, error));
    gbuffer->camera = *camera;
    gbuffer->samples = 1;
    struct raycast job = {
        .scene = scene,
        .accel = accel,
        .gbuffer = gbuffer,
        .view = pbnds_camera_view(camera, width, height),
        .tiles_across = ((size_t)width + TILE - 1) / TILE,
    };
    const size_t tiles_down = ((size_t)height + TILE - 1) / TILE;
    pbnds_parallel_for(job.tiles_across * tiles_down, cast_tile, &job);
    if (pbnds_stop_requested()) {
        pbnds_gbuffer_free(gbuffer);
        return pbnds_fail_interrupted(error);
    }
    return PBNDS_OK;
}

struct pbnds_vec3 pbnds_gbuffer_wo(const struct pbnds_gbuffer *gbuffer, int x, int y)
{
    const struct pbnds_ray ray =
        pbnds_camera_ray(&gbuffer->camera, gbuffer->width, gbuffer->height,
                         (float)x + 0.5f, (float)y + 0.5f);
    return pbnds_scale(ray.direction, -1.0f);
}
