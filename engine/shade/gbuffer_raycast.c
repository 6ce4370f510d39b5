/* The ray cast of point-sampled G-buffers: packets in tiles, one ray a pixel. */
#include <string.h>
#if defined(__SSE__)
#include <immintrin.h>
#endif

#include "engine/core/lanes.h"
#include "engine/shade/gbuffer_planes.h"
#include "engine/shade/tiles.h"

enum {
    TILE = 32,            /* pixels a side, the unit of work of a thread           */
    BLOCK = 4,            /* pixels a side of the square that one packet covers;   */
    LANES = PBNDS_PACKET, /* BLOCK * BLOCK, row by row                   */
    STRIP = 16,           /* pixels of one plane in a cache line         */
    STRIP_BYTES = STRIP * BLOCK * 4
};

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

/* What one tile needs. */
struct raycast {
    const struct pbnds_scene *scene;
    const struct pbnds_accel *accel;
    struct pbnds_gbuffer *gbuffer;
    struct pbnds_camera_view view, previous_view;
    char *planes[PBNDS_PLANES_MAX]; /* all of them */
    int plane_count;
};

/* What a G-buffer holds beside the surface itself. */
struct derived {
    float specular[LANES], depth[LANES], coverage[LANES];
    float f0[3][LANES], f90[LANES]; /* of metal and non-metal together */
    uint32_t object_id[LANES], material_id[LANES];
};

static void make_rays_parallel(const struct pbnds_camera_view *view, int x0, int y0,
                               struct pbnds_ray_packet *rays)
{
    for (int k = 0; k < LANES; ++k) {
        const float x = (float)(x0 + k % BLOCK), y = (float)(y0 + k / BLOCK);
        const struct pbnds_ray ray = pbnds_camera_view_ray(view, x + 0.5f, y + 0.5f);
        rays->origin[0][k] = ray.origin.x;
        rays->origin[1][k] = ray.origin.y;
        rays->origin[2][k] = ray.origin.z;
        rays->direction[0][k] = ray.direction.x;
        rays->direction[1][k] = ray.direction.y;
        rays->direction[2][k] = ray.direction.z;
    }
}

/* pbnds_camera_view_ray() of a perspective camera, lane by lane. */
PBNDS_LANES_CODE
static void make_rays(const struct pbnds_camera_view *view, int x0, int y0,
                      struct pbnds_ray_packet *rays)
{
    static const int column[LANES] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
    static const int row[LANES] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
    const struct pbnds_camera_view v = *view; /* which nothing else can write to */
    struct pbnds_ray_packet made;
    for (int k = 0; k < LANES; ++k) {
        const float x = (float)(x0 + column[k]) + 0.5f, y = (float)(y0 + row[k]) + 0.5f;
        const float sx = (x - v.center_x) * v.pixel, sy = (v.center_y - y) * v.pixel;
        const struct pbnds_vec3 d =
            pbnds_normalize(pbnds_mad(pbnds_mad(v.forward, v.right, sx), v.up, sy));
        made.direction[0][k] = d.x;
        made.direction[1][k] = d.y;
        made.direction[2][k] = d.z;
    }
    for (int k = 0; k < LANES; ++k) {
        made.origin[0][k] = v.eye.x;
        made.origin[1][k] = v.eye.y;
        made.origin[2][k] = v.eye.z;
    }
    *rays = made;
}

/* Width of the cone that a pixel opens, at the hit: for the textures. */
PBNDS_LANES_CODE
static void make_footprints(const struct pbnds_camera_view *view,
                            const struct pbnds_ray_packet *rays,
                            const struct pbnds_hit_packet *hits, float footprint[LANES])
{
    const struct pbnds_vec3 forward = view->forward;
    const float pixel = view->pixel;
    const bool orthographic = view->orthographic;
    for (int k = 0; k < LANES; ++k) {
        const struct pbnds_vec3 direction = {
            rays->direction[0][k], rays->direction[1][k], rays->direction[2][k]};
        const float depth = hits->t[k] * pbnds_dot(direction, forward);
        footprint[k] = pixel * (orthographic ? 1.0f : depth);
    }
}

PBNDS_LANES_CODE
static void derive(const struct pbnds_camera_view *view,
                   const struct pbnds_hit_packet *hits,
                   const struct pbnds_surface_packet *s, struct derived *derived)
{
    const struct pbnds_vec3 eye = view->eye, forward = view->forward;
    struct derived d;
    float depth[LANES];
    for (int k = 0; k < LANES; ++k) {
        const float m = s->metallic[k];
        const struct pbnds_vec3 f0 =
            pbnds_lerp(pbnds_vec3_make(s->f0[0][k], s->f0[1][k], s->f0[2][k]),
                       pbnds_vec3_make(s->base_color[0][k], s->base_color[1][k],
                                       s->base_color[2][k]),
                       m);
        d.f0[0][k] = f0.x;
        d.f0[1][k] = f0.y;
        d.f0[2][k] = f0.z;
        d.f90[k] = s->f90[k] + m * (1.0f - s->f90[k]);
        d.specular[k] = pbnds_luminance(f0);
    }
    for (int k = 0; k < LANES; ++k) {
        const struct pbnds_vec3 p = {s->position[0][k], s->position[1][k],
                                     s->position[2][k]};
        depth[k] = pbnds_dot(pbnds_sub(p, eye), forward);
    }
    /* Where nothing was hit, the surface is all zero, and so is what follows from it but
     * for these. */
    for (int k = 0; k < LANES; ++k)
        d.depth[k] = hits->mesh[k] != UINT32_MAX ? depth[k] : INFINITY;
    for (int k = 0; k < LANES; ++k)
        d.coverage[k] = hits->mesh[k] != UINT32_MAX ? 1.0f : 0.0f;
    for (int k = 0; k < LANES; ++k)
        d.object_id[k] = hits->mesh[k] != UINT32_MAX ? s->object_id[k] : UINT32_MAX;
    for (int k = 0; k < LANES; ++k)
        d.material_id[k] = hits->mesh[k] != UINT32_MAX ? s->material[k] : UINT32_MAX;
    *derived = d;
}

/* Four packets side by side: rows as long as a cache line. What they find is gathered here
 * first, in a little G-buffer of its own, and then copied out line by line: writing 16
 * bytes at a time to some eighty places, each in another page, costs as much as casting
 * the rays. */
struct strip {
    struct pbnds_gbuffer planes;
    _Alignas(64) char memory[PBNDS_PLANES_MAX][STRIP_BYTES];
};

/* Float planes and id planes alike: four bytes a pixel. Packet after packet: write_strip()
 * makes rows of them. */
static inline void put(int column, void *plane, const void *lanes)
{
    memcpy((char *)plane + 4 * BLOCK * column, lanes, 4 * LANES);
}

static inline void put3(int column, float *const plane[3], const float lanes[3][LANES])
{
    for (int c = 0; c < 3; ++c)
        put(column, plane[c], lanes[c]);
}

static void put_motion(const struct raycast *job, int column,
                       const struct pbnds_gbuffer *g,
                       const struct pbnds_hit_packet *hits,
                       const struct pbnds_surface_packet *s)
{
    float motion[2][LANES] = {{0.0f}};
    for (int k = 0; k < LANES; ++k) {
        const struct pbnds_hit hit = {hits->t[k], hits->u[k], hits->v[k], hits->mesh[k],
                                      hits->triangle[k]};
        if (hit.mesh == UINT32_MAX) continue;
        const struct pbnds_vec2 m = pbnds_image_motion(
            &job->view, &job->previous_view,
            pbnds_vec3_make(s->position[0][k], s->position[1][k], s->position[2][k]),
            pbnds_scene_previous(job->scene, &hit));
        motion[0][k] = m.x;
        motion[1][k] = m.y;
    }
    put(column, g->motion[0], motion[0]);
    put(column, g->motion[1], motion[1]);
}

/* Puts a packet into a strip, from `column` on. */
PBNDS_LANES_CODE
static void put_packet(int column, const struct pbnds_gbuffer *g,
                       const struct pbnds_surface_packet *s, const struct derived *d)
{
    put3(column, g->albedo, s->base_color);
    put3(column, g->normal, s->n);
    put(column, g->specular, d->specular);
    put(column, g->roughness, s->roughness);
    put(column, g->metallic, s->metallic);
    put(column, g->depth, d->depth);
    put(column, g->coverage, d->coverage);
    put3(column, g->position, s->position);
    put3(column, g->emission, s->emission);
    put3(column, g->geometric_normal, s->ng);
    put(column, g->object_id, d->object_id);
    if (g->f90) {
        put3(column, g->f0, d->f0);
        put(column, g->f90, d->f90);
    }
    if (g->ao) put(column, g->ao, s->occlusion);
    if (g->uv[0]) {
        put(column, g->uv[0], s->uv[0]);
        put(column, g->uv[1], s->uv[1]);
    }
    if (g->material_id) put(column, g->material_id, d->material_id);
}

static void cast_block(const struct raycast *job, const struct pbnds_ray_packet *rays,
                       int column, const struct pbnds_gbuffer *strip)
{
    struct pbnds_hit_packet hits;
    struct pbnds_surface_packet surface;
    struct derived derived;
    float footprint[LANES];
    pbnds_accel_intersect_lanes(job->accel, rays, &hits);
    make_footprints(&job->view, rays, &hits, footprint);
    pbnds_scene_surface_packet(job->scene, rays, &hits, footprint, &surface);
    derive(&job->view, &hits, &surface, &derived);
    put_packet(column, strip, &surface, &derived);
    if (strip->motion[0]) put_motion(job, column, strip, &hits, &surface);
}

/* One row of a plane of a strip, BLOCK pixels of each packet: a cache line that nobody
 * reads soon. Past the caches where it is whole and the processor can, which saves reading
 * it first and keeps the tree and the textures in them. */
static inline void stream_row(char *to, const char *from)
{
#if defined(__SSE__)
    if (((uintptr_t)to & 63u) == 0) {
        for (int i = 0; i < STRIP / BLOCK; ++i)
            _mm_stream_ps((float *)(void *)to + BLOCK * i,
                          _mm_load_ps((const float *)(const void *)from + LANES * i));
        return;
    }
#endif
    for (int i = 0; i < STRIP / BLOCK; ++i)
        memcpy(to + 4 * BLOCK * i, from + 4 * LANES * i, 4 * BLOCK);
}

/* Copies a strip out; what of it is beyond the image is dropped. */
PBNDS_LANES_CODE
static void write_strip(const struct raycast *job, int x, int y,
                        const struct strip *strip)
{
    const int width = job->gbuffer->width, height = job->gbuffer->height;
    const int rows = height - y < BLOCK ? height - y : BLOCK;
    const int columns = width - x < STRIP ? width - x : STRIP;
    for (int p = 0; p < job->plane_count; ++p) {
        char *to = job->planes[p] + 4 * ((size_t)y * (size_t)width + (size_t)x);
        const char *from = strip->memory[p];
        for (int row = 0; row < rows; ++row) {
            if (columns == STRIP) stream_row(to, from);
            for (int k = 0; k < columns && columns < STRIP; ++k)
                memcpy(to + 4 * k, from + 4 * (k / BLOCK * LANES + k % BLOCK), 4);
            to += 4 * (size_t)width;
            from += 4 * BLOCK;
        }
    }
}

/* The strips whose first pixel is in the tile: where tiles begin and end changes nothing.
 * Packets at the edge of the image cast rays beyond it too. */
static void cast_tile(void *context, const struct pbnds_tile *tile)
{
    const struct raycast *job = context;
    struct strip strip;
    struct pbnds_ray_packet rays[STRIP / BLOCK];
    strip.planes = *job->gbuffer;
    pbnds_gbuffer_point_into(&strip.planes, strip.memory, sizeof strip.memory[0]);
    const int x0 = (tile->x0 + STRIP - 1) / STRIP * STRIP;
    const int y0 = (tile->y0 + BLOCK - 1) / BLOCK * BLOCK;
    for (int y = y0; y < tile->y1; y += BLOCK) {
        for (int x = x0; x < tile->x1; x += STRIP) {
            /* All rays first: roots and quotients take long, but not in a row. */
            for (int k = 0; k < STRIP / BLOCK; ++k)
                (job->view.orthographic ? make_rays_parallel : make_rays)(
                    &job->view, x + BLOCK * k, y, &rays[k]);
            for (int k = 0; k < STRIP && x + k < job->gbuffer->width; k += BLOCK)
                cast_block(job, &rays[k / BLOCK], k, &strip.planes);
            write_strip(job, x, y, &strip);
        }
    }
}

/* Has it the very planes that this cast fills, all of them written for every pixel? */
static bool can_refill(const struct pbnds_gbuffer *g, int width, int height,
                       unsigned optional, bool fresnel)
{
    return g->storage && g->width == width && g->height == height &&
           (g->f90 != NULL) == fresnel && !g->cryptomatte &&
           (g->ao != NULL) == ((optional & PBNDS_OPTIONAL_AO) != 0) &&
           (g->uv[0] != NULL) == ((optional & PBNDS_OPTIONAL_UV) != 0) &&
           (g->motion[0] != NULL) == ((optional & PBNDS_OPTIONAL_MOTION) != 0) &&
           (g->material_id != NULL) == ((optional & PBNDS_OPTIONAL_MATERIAL_ID) != 0) &&
           !(optional & PBNDS_OPTIONAL_CRYPTOMATTE);
}

enum pbnds_status
pbnds_gbuffer_recast(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                     const struct pbnds_camera *camera, int width, int height,
                     const struct pbnds_raycast_options *options,
                     struct pbnds_gbuffer *gbuffer, struct pbnds_error *error)
{
    static const struct pbnds_raycast_options plain = {.optional = 0};
    if (!options) options = &plain;
    const bool fresnel = pbnds_scene_needs_fresnel(scene);
    const bool antialiased = pbnds_raycast_is_antialiased(accel, options);
    if (antialiased ||
        !can_refill(gbuffer, width, height, options->optional, fresnel)) {
        pbnds_gbuffer_free(gbuffer);
        /* Every pixel of a point-sampled G-buffer is written; the others add up. */
        PBNDS_TRY((antialiased ? pbnds_gbuffer_allocate : pbnds_gbuffer_reserve)(
            gbuffer, width, height, options->optional, fresnel, error));
    }
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
    };
    job.plane_count = pbnds_gbuffer_list(gbuffer, job.planes);
    const enum pbnds_status status =
        antialiased
            ? pbnds_gbuffer_raycast_antialiased(scene, accel, options, gbuffer, error)
            : pbnds_for_tiles(width, height, TILE, NULL, "gbuffer", cast_tile, &job,
                              error);
    if (status != PBNDS_OK) pbnds_gbuffer_free(gbuffer);
    return status;
}

enum pbnds_status
pbnds_gbuffer_raycast(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                      const struct pbnds_camera *camera, int width, int height,
                      const struct pbnds_raycast_options *options,
                      struct pbnds_gbuffer *gbuffer, struct pbnds_error *error)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    return pbnds_gbuffer_recast(scene, accel, camera, width, height, options, gbuffer,
                                error);
}
