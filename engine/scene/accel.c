/*
 * Embree 3 behind accel.h. Debian's build of it keeps its assertions: a ray that
 * upstream would merely answer wrongly ends the process. So every ray is checked before
 * it goes in, and the lanes that are not used hold a finite dummy.
 */
#include "engine/scene/accel.h"

#include <embree3/rtcore.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/lanes.h"
#include "engine/core/parallel.h"
#include "engine/core/rng.h"

/* Embree takes coordinates below 1.84e18 (FLT_LARGE, the root of the float range). */
#define LARGEST_COORDINATE 1e18f

/* What the alpha filter of one mesh needs. */
struct cutout {
    const struct pbnds_scene *scene;
    uint32_t mesh;
    float cutoff;
    bool blend;
};

struct pbnds_accel {
    RTCDevice device;
    RTCScene scene;
    struct cutout *cutouts; /* one a mesh; only those of filtered meshes are used */
    bool *one_sided; /* one a mesh                                               */
    bool culls;      /* some mesh is one-sided                                   */
    bool blends;     /* some BLEND surface is not solid */
    atomic_int_least64_t bytes; /* that Embree holds                      */
    char fault[256];            /* Embree's own words on its first error */
    enum RTCError code;
};

/* Queries. */

static bool usable(const struct pbnds_ray *ray)
{
    /* Written so that NaN is refused. */
    return fabsf(ray->origin.x) <= LARGEST_COORDINATE &&
           fabsf(ray->origin.y) <= LARGEST_COORDINATE &&
           fabsf(ray->origin.z) <= LARGEST_COORDINATE &&
           fabsf(ray->direction.x) <= LARGEST_COORDINATE &&
           fabsf(ray->direction.y) <= LARGEST_COORDINATE &&
           fabsf(ray->direction.z) <= LARGEST_COORDINATE;
}

static void fill_ray(struct RTCRay *out, const struct pbnds_ray *ray, float min_t,
                     float max_t)
{
    out->org_x = ray->origin.x;
    out->org_y = ray->origin.y;
    out->org_z = ray->origin.z;
    out->tnear = min_t;
    out->dir_x = ray->direction.x;
    out->dir_y = ray->direction.y;
    out->dir_z = ray->direction.z;
    out->time = 0.0f;
    out->tfar = max_t;
    out->mask = ~0u;
    out->id = 0;
    out->flags = 0;
}

/* Fills sixteen lanes, and valid[] with -1 where the lane holds a ray to trace. */
static void fill_packet(struct RTCRay16 *out, int *valid, const struct pbnds_ray *rays,
                        int count, float max_t)
{
    for (int i = 0; i < PBNDS_PACKET; ++i) {
        const bool used = i < count && usable(&rays[i]);
        static const struct pbnds_ray dummy = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
        const struct pbnds_ray *ray = used ? &rays[i] : &dummy;
        valid[i] = used ? -1 : 0;
        out->org_x[i] = ray->origin.x;
        out->org_y[i] = ray->origin.y;
        out->org_z[i] = ray->origin.z;
        out->dir_x[i] = ray->direction.x;
        out->dir_y[i] = ray->direction.y;
        out->dir_z[i] = ray->direction.z;
    }
    for (int i = 0; i < PBNDS_PACKET; ++i) {
        out->tnear[i] = 0.0f;
        out->time[i] = 0.0f;
        out->tfar[i] = max_t;
        out->mask[i] = ~0u;
        out->id[i] = 0;
        out->flags[i] = 0;
    }
}

static const struct pbnds_query culling = {.max_t = INFINITY, .cull = true};
static const struct pbnds_hit miss = {INFINITY, 0.0f, 0.0f, UINT32_MAX, UINT32_MAX};

/* The context of our queries: what the alpha filter needs to know of the ray. */
struct context {
    struct RTCIntersectContext embree; /* first, so that the two can be cast */
    const struct pbnds_query *query;   /* NULL: the plain rule */
    const bool *one_sided;             /* a mesh; for cull_filter()                  */
};

static void cull_filter(const struct RTCFilterFunctionNArguments *args);

/* Is the surface of a hit seen from the side that its material does not have? */
static bool is_behind(const struct pbnds_accel *accel, uint32_t mesh, float ng_dot_ray)
{
    return ng_dot_ray > 0.0f && accel->one_sided[mesh];
}

void pbnds_accel_intersect_query(const struct pbnds_accel *accel,
                                 const struct pbnds_ray *ray,
                                 const struct pbnds_query *how, struct pbnds_hit *hit)
{
    *hit = miss;
    if (!usable(ray) || !(how->max_t > how->min_t)) return;
    struct context context = {.query = how, .one_sided = accel->one_sided};
    rtcInitIntersectContext(&context.embree);
    if (how->cull && accel->culls) context.embree.filter = cull_filter;
    struct RTCRayHit query;
    fill_ray(&query.ray, ray, how->min_t, how->max_t);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.primID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(accel->scene, &context.embree, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
    hit->t = query.ray.tfar;
    hit->u = query.hit.u;
    hit->v = query.hit.v;
    hit->mesh = query.hit.geomID;
    hit->triangle = query.hit.primID;
}

bool pbnds_accel_occluded_query(const struct pbnds_accel *accel,
                                const struct pbnds_ray *ray,
                                const struct pbnds_query *how)
{
    if (!usable(ray) || !(how->max_t > how->min_t)) return false;
    struct context context = {.query = how};
    rtcInitIntersectContext(&context.embree);
    struct RTCRay query;
    fill_ray(&query, ray, how->min_t, how->max_t);
    rtcOccluded1(accel->scene, &context.embree, &query);
    return query.tfar < 0.0f; /* Embree says so with -inf */
}

void pbnds_accel_intersect(const struct pbnds_accel *accel, const struct pbnds_ray *ray,
                           struct pbnds_hit *hit)
{
    const struct pbnds_query plain = {.max_t = INFINITY};
    pbnds_accel_intersect_query(accel, ray, &plain, hit);
}

bool pbnds_accel_occluded(const struct pbnds_accel *accel, const struct pbnds_ray *ray,
                          float max_t)
{
    const struct pbnds_query plain = {.max_t = max_t};
    return pbnds_accel_occluded_query(accel, ray, &plain);
}

bool pbnds_accel_blends(const struct pbnds_accel *accel)
{
    return accel->blends;
}

/* Only where a surface faces away is a second look needed; it is rare. */
PBNDS_LANES_CODE
static void ng_dot_rays(const struct RTCRayHit16 *query, float side[PBNDS_PACKET])
{
    for (int i = 0; i < PBNDS_PACKET; ++i)
        side[i] = query->hit.Ng_x[i] * query->ray.dir_x[i] +
                  query->hit.Ng_y[i] * query->ray.dir_y[i] +
                  query->hit.Ng_z[i] * query->ray.dir_z[i];
}

void pbnds_accel_intersect_packet(const struct pbnds_accel *accel,
                                  const struct pbnds_ray *rays, int count,
                                  struct pbnds_hit *hits)
{
    struct RTCRayHit16 query;
    int valid[PBNDS_PACKET] __attribute__((aligned(64)));
    fill_packet(&query.ray, valid, rays, count, INFINITY);
    for (int i = 0; i < PBNDS_PACKET; ++i) {
        query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        query.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    struct context context = {.query = NULL};
    rtcInitIntersectContext(&context.embree);
    context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, accel->scene, &context.embree, &query);
    float side[PBNDS_PACKET];
    ng_dot_rays(&query, side);
    for (int i = 0; i < count && i < PBNDS_PACKET; ++i) {
        if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) {
            hits[i] = miss;
        } else if (is_behind(accel, query.hit.geomID[i], side[i])) {
            pbnds_accel_intersect_query(accel, &rays[i], &culling, &hits[i]);
        } else {
            hits[i] =
                (struct pbnds_hit){query.ray.tfar[i], query.hit.u[i], query.hit.v[i],
                                   query.hit.geomID[i], query.hit.primID[i]};
        }
    }
}

/* Copies in full vectors, so that Embree's loads, as wide, find them at once. @return the
 * lanes that hold a ray to trace, as valid[] says, -1 or 0 */
PBNDS_LANES_CODE
static void fill_lanes(struct RTCRayHit16 *query, int *valid,
                       const struct pbnds_ray_packet *rays)
{
    struct RTCRay16 *ray = &query->ray;
    float *const to[6] = {ray->org_x, ray->org_y, ray->org_z,
                          ray->dir_x, ray->dir_y, ray->dir_z};
    float sum[PBNDS_PACKET];
    int used[PBNDS_PACKET];
    for (int i = 0; i < PBNDS_PACKET; ++i) /* NaN where one is NaN, and so refused */
        sum[i] = fabsf(rays->origin[0][i]) + fabsf(rays->origin[1][i]) +
                 fabsf(rays->origin[2][i]) + fabsf(rays->direction[0][i]) +
                 fabsf(rays->direction[1][i]) + fabsf(rays->direction[2][i]);
    for (int i = 0; i < PBNDS_PACKET; ++i)
        used[i] = sum[i] <= LARGEST_COORDINATE ? -1 : 0;
    for (int i = 0; i < PBNDS_PACKET; ++i)
        valid[i] = used[i];
    for (int c = 0; c < 6; ++c) {
        const float *from = c < 3 ? rays->origin[c] : rays->direction[c - 3];
        const float dummy = c == 5 ? 1.0f : 0.0f;
        for (int i = 0; i < PBNDS_PACKET; ++i)
            to[c][i] = used[i] ? from[i] : dummy;
    }
    for (int i = 0; i < PBNDS_PACKET; ++i)
        ray->tnear[i] = 0.0f;
    for (int i = 0; i < PBNDS_PACKET; ++i)
        ray->time[i] = 0.0f;
    for (int i = 0; i < PBNDS_PACKET; ++i)
        ray->tfar[i] = INFINITY;
    for (int i = 0; i < PBNDS_PACKET; ++i)
        ray->mask[i] = ~0u;
    for (int i = 0; i < PBNDS_PACKET; ++i)
        ray->id[i] = 0;
    for (int i = 0; i < PBNDS_PACKET; ++i)
        ray->flags[i] = 0;
    for (int i = 0; i < PBNDS_PACKET; ++i)
        query->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
}

PBNDS_LANES_CODE
static void take_lanes(const struct RTCRayHit16 *query, struct pbnds_hit_packet *hits)
{
    /* UINT32_MAX is what both sides call nothing. */
    memcpy(hits->t, query->ray.tfar, sizeof hits->t);
    memcpy(hits->u, query->hit.u, sizeof hits->u);
    memcpy(hits->v, query->hit.v, sizeof hits->v);
    memcpy(hits->mesh, query->hit.geomID, sizeof hits->mesh);
    memcpy(hits->triangle, query->hit.primID, sizeof hits->triangle);
}

void pbnds_accel_intersect_lanes(const struct pbnds_accel *accel,
                                 const struct pbnds_ray_packet *rays,
                                 struct pbnds_hit_packet *hits)
{
    struct RTCRayHit16 query;
    int valid[PBNDS_PACKET] __attribute__((aligned(64)));
    fill_lanes(&query, valid, rays);
    struct context context = {.query = NULL};
    rtcInitIntersectContext(&context.embree);
    context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, accel->scene, &context.embree, &query);
    take_lanes(&query, hits);
    if (!accel->culls) return;
    float side[PBNDS_PACKET];
    ng_dot_rays(&query, side);
    for (int i = 0; i < PBNDS_PACKET; ++i) {
        if (side[i] <= 0.0f || hits->mesh[i] == UINT32_MAX) continue;
        if (!is_behind(accel, hits->mesh[i], side[i])) continue;
        const struct pbnds_ray ray = {
            {rays->origin[0][i], rays->origin[1][i], rays->origin[2][i]},
            {rays->direction[0][i], rays->direction[1][i], rays->direction[2][i]}};
        struct pbnds_hit hit;
        pbnds_accel_intersect_query(accel, &ray, &culling, &hit);
        hits->t[i] = hit.t;
        hits->u[i] = hit.u;
        hits->v[i] = hit.v;
        hits->mesh[i] = hit.mesh;
        hits->triangle[i] = hit.triangle;
    }
}

void pbnds_accel_occluded_packet(const struct pbnds_accel *accel,
                                 const struct pbnds_ray *rays, int count, float max_t,
                                 bool *occluded)
{
    if (!(max_t > 0.0f)) {
        for (int i = 0; i < count && i < PBNDS_PACKET; ++i)
            occluded[i] = false;
        return;
    }
    struct RTCRay16 query;
    int valid[PBNDS_PACKET] __attribute__((aligned(64)));
    fill_packet(&query, valid, rays, count, max_t);
    struct context context = {.query = NULL};
    rtcInitIntersectContext(&context.embree);
    context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded16(valid, accel->scene, &context.embree, &query);
    for (int i = 0; i < count && i < PBNDS_PACKET; ++i) {
        occluded[i] = valid[i] && query.tfar[i] < 0.0f;
    }
}

/* Measuring sticks. */

enum { BARE_TILE = 16, BARE_BLOCK = 4 };

struct bare {
    const struct pbnds_accel *accel;
    const struct pbnds_camera_view *view;
    int width, height;
    size_t tiles_across;
    atomic_uint_least64_t hits;
};

/* A perspective ray through each pixel of a block, in the order of its lanes. */
static void bare_rays(const struct bare *job, int x0, int y0, struct RTCRay16 *ray)
{
    const struct pbnds_camera_view *v = job->view;
    for (int i = 0; i < PBNDS_PACKET; ++i) {
        const float x = (float)(x0 + i % BARE_BLOCK) + 0.5f,
                    y = (float)(y0 + i / BARE_BLOCK) + 0.5f;
        const float sx = (x - v->center_x) * v->pixel;
        const float sy = (v->center_y - y) * v->pixel;
        ray->org_x[i] = v->eye.x;
        ray->org_y[i] = v->eye.y;
        ray->org_z[i] = v->eye.z;
        ray->tnear[i] = 0.0f;
        ray->dir_x[i] = v->forward.x + v->right.x * sx + v->up.x * sy;
        ray->dir_y[i] = v->forward.y + v->right.y * sx + v->up.y * sy;
        ray->dir_z[i] = v->forward.z + v->right.z * sx + v->up.z * sy;
        ray->time[i] = 0.0f;
        ray->tfar[i] = INFINITY;
        ray->mask[i] = ~0u;
        ray->id[i] = 0;
        ray->flags[i] = 0;
    }
}

static void bare_tile(void *context, size_t tile, int thread)
{
    (void)thread;
    struct bare *job = context;
    const int x0 = (int)(tile % job->tiles_across) * BARE_TILE;
    const int y0 = (int)(tile / job->tiles_across) * BARE_TILE;
    int valid[PBNDS_PACKET] __attribute__((aligned(64)));
    for (int i = 0; i < PBNDS_PACKET; ++i)
        valid[i] = -1;
    struct context rules = {.query = NULL};
    rtcInitIntersectContext(&rules.embree);
    rules.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    uint_least64_t hits = 0;
    for (int y = y0; y < y0 + BARE_TILE && y < job->height; y += BARE_BLOCK) {
        for (int x = x0; x < x0 + BARE_TILE && x < job->width; x += BARE_BLOCK) {
            struct RTCRayHit16 query;
            bare_rays(job, x, y, &query.ray);
            for (int i = 0; i < PBNDS_PACKET; ++i)
                query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect16(valid, job->accel->scene, &rules.embree, &query);
            for (int i = 0; i < PBNDS_PACKET; ++i)
                hits += query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        }
    }
    atomic_fetch_add(&job->hits, hits);
}

uint64_t pbnds_accel_bare_primary(const struct pbnds_accel *accel,
                                  const struct pbnds_camera_view *view, int width,
                                  int height)
{
    struct bare job = {.accel = accel, .view = view, .width = width, .height = height};
    job.tiles_across = ((size_t)width + BARE_TILE - 1) / BARE_TILE;
    atomic_init(&job.hits, 0);
    pbnds_parallel_for(job.tiles_across *
                           (((size_t)height + BARE_TILE - 1) / BARE_TILE),
                       bare_tile, &job);
    return atomic_load(&job.hits);
}

struct bare_paths {
    struct bare image;
    int paths, bounces;
};

/* Uniform on the half sphere about n. */
static struct pbnds_vec3 bare_direction(struct pbnds_rng *rng, struct pbnds_vec3 n)
{
    struct pbnds_vec3 d;
    do {
        d.x = 2.0f * pbnds_rng_float(rng) - 1.0f;
        d.y = 2.0f * pbnds_rng_float(rng) - 1.0f;
        d.z = 2.0f * pbnds_rng_float(rng) - 1.0f;
    } while (!(pbnds_dot(d, d) < 1.0f && pbnds_dot(d, d) > 1e-4f));
    d = pbnds_normalize(d);
    return pbnds_dot(d, n) < 0.0f ? pbnds_scale(d, -1.0f) : d;
}

/* @return how many rays it took */
static uint64_t bare_path(const struct bare_paths *job, struct pbnds_ray ray,
                          struct pbnds_rng *rng)
{
    struct context rules = {.query = NULL};
    rtcInitIntersectContext(&rules.embree);
    uint64_t rays = 0;
    for (int bounce = 0; bounce <= job->bounces; ++bounce) {
        struct RTCRayHit query;
        fill_ray(&query.ray, &ray, 0.0f, INFINITY);
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(job->image.accel->scene, &rules.embree, &query);
        ++rays;
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) break;
        struct pbnds_vec3 n = {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z};
        if (pbnds_dot(n, ray.direction) > 0.0f) n = pbnds_scale(n, -1.0f);
        const float square = pbnds_dot(n, n);
        if (!(square > 0.0f)) break;
        const struct pbnds_vec3 p =
            pbnds_mad(ray.origin, ray.direction, query.ray.tfar);
        ray.origin = pbnds_offset_origin(p, pbnds_scale(n, 1.0f / sqrtf(square)));
        ray.direction = bare_direction(rng, n);
        struct RTCRay shadow;
        fill_ray(&shadow, &ray, 0.0f, INFINITY);
        rtcOccluded1(job->image.accel->scene, &rules.embree, &shadow);
        ++rays;
        ray.direction = bare_direction(rng, n);
    }
    return rays;
}

static void bare_paths_row(void *context, size_t y, int thread)
{
    (void)thread;
    struct bare_paths *job = context;
    uint_least64_t rays = 0;
    for (int x = 0; x < job->image.width; ++x) {
        const struct pbnds_ray ray =
            pbnds_camera_view_ray(job->image.view, (float)x + 0.5f, (float)y + 0.5f);
        for (int i = 0; i < job->paths; ++i) {
            const size_t pixel = y * (size_t)job->image.width + (size_t)x;
            struct pbnds_rng rng = pbnds_rng_make(1, pixel, (uint64_t)i);
            rays += bare_path(job, ray, &rng);
        }
    }
    atomic_fetch_add(&job->image.hits, rays);
}

uint64_t pbnds_accel_bare_paths(const struct pbnds_accel *accel,
                                const struct pbnds_camera_view *view, int width,
                                int height, int paths, int bounces)
{
    struct bare_paths job = {.paths = paths, .bounces = bounces};
    job.image.accel = accel;
    job.image.view = view;
    job.image.width = width;
    job.image.height = height;
    atomic_init(&job.image.hits, 0); /* of rays, here */
    pbnds_parallel_for((size_t)height, bare_paths_row, &job);
    return atomic_load(&job.image.hits);
}

static uint64_t hash_position(struct pbnds_vec3 p)
{
    const float zero = 0.0f; /* -0 is 0 */
    const float at[3] = {p.x + zero, p.y + zero, p.z + zero};
    uint32_t bits[3];
    memcpy(bits, at, sizeof bits);
    return pbnds_rng_make(bits[0], bits[1], bits[2]).key;
}

/* What a layer is known by. A ray that meets the edge of two triangles, or the corner of
 * several, hits each of them (the BVH is robust), though there is one layer: there the
 * corners stand for all. Close to them they do as well, which changes nothing. */
static uint64_t layer_key(const struct cutout *cutout, const struct pbnds_hit *hit)
{
    const float close = 1e-6f;
    const bool on[3] = {hit->u + hit->v<1.0f - close, hit->u> close, hit->v > close};
    if (on[0] && on[1] && on[2]) return hit->triangle;
    const struct pbnds_mesh *mesh = &cutout->scene->meshes[hit->mesh];
    uint64_t key = 1ull << 32; /* apart from the triangles; the order must not matter */
    for (size_t k = 0; k < 3; ++k)
        if (on[k])
            key += hash_position(
                mesh->position[mesh->index[3 * (size_t)hit->triangle + k]]);
    return key;
}

/* A number in [0, 1) that depends on nothing but the ray's seed and the layer. */
static float chance(uint32_t seed, uint32_t mesh, uint64_t layer)
{
    struct pbnds_rng rng = pbnds_rng_make(seed, mesh, layer);
    return pbnds_rng_float(&rng);
}

static bool stops(const struct cutout *cutout, const struct pbnds_query *query,
                  const struct pbnds_hit *hit)
{
    const float alpha = pbnds_scene_alpha(cutout->scene, hit);
    if (cutout->blend && query && query->stochastic)
        return chance(query->seed, hit->mesh, layer_key(cutout, hit)) < alpha;
    if (cutout->blend && query && query->blend_solid) return alpha > 0.0f;
    return alpha >= cutout->cutoff;
}

/* Called for every candidate hit of a mesh with cut-outs; refuses the transparent ones.
 */
static void alpha_filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct cutout *cutout = args->geometryUserPtr;
    /* RTCHitN is Ng_x, Ng_y, Ng_z, u, v, primID, ...: N values each. Embree has names
     * for them in C++ only. */
    const float *u = (const float *)(const void *)args->hit + 3 * (size_t)args->N;
    const float *v = u + args->N;
    const unsigned *triangle = (const unsigned *)(const void *)(v + args->N);
    const struct context *context = (const struct context *)(const void *)args->context;
    const struct pbnds_query *query = context->query;
    for (unsigned i = 0; i < args->N; ++i) {
        if (!args->valid[i]) continue;
        struct pbnds_hit hit;
        hit.t = 0.0f;
        hit.u = u[i];
        hit.v = v[i];
        hit.mesh = cutout->mesh;
        hit.triangle = triangle[i];
        if (!stops(cutout, query, &hit)) args->valid[i] = 0;
    }
}

/* Called for every candidate hit of a query that culls; refuses back faces. */
static void cull_filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct context *context = (const struct context *)(const void *)args->context;
    const size_t n = args->N;
    /* RTCRayN is org_x, org_y, org_z, tnear, dir_x, ...; RTCHitN ends with geomID. */
    const float *ray = (const float *)(const void *)args->ray;
    const float *hit = (const float *)(const void *)args->hit;
    const unsigned *mesh = (const unsigned *)(const void *)(hit + 6 * n);
    for (size_t i = 0; i < n; ++i) {
        if (!args->valid[i] || !context->one_sided[mesh[i]]) continue;
        const float away = hit[i] * ray[4 * n + i] + hit[n + i] * ray[5 * n + i] +
                           hit[2 * n + i] * ray[6 * n + i];
        if (away > 0.0f) args->valid[i] = 0;
    }
}

/* Building. */

static void note_fault(void *user, enum RTCError code, const char *text)
{
    struct pbnds_accel *accel = user;
    if (accel->code != RTC_ERROR_NONE) return; /* the first one is the cause */
    accel->code = code;
    snprintf(accel->fault, sizeof accel->fault, "%s", text ? text : "");
}

static enum pbnds_status fail_embree(const struct pbnds_accel *accel, const char *step,
                                     struct pbnds_error *error)
{
    if (accel->code == RTC_ERROR_OUT_OF_MEMORY) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "Embree ran out of memory while it %s; use a smaller scene",
                          step);
    }
    return pbnds_fail(error, PBNDS_ERROR_BACKEND,
                      "Embree failed while it %s: error %d, %s", step, (int)accel->code,
                      accel->fault[0] ? accel->fault : "no reason given");
}

/* Is alpha below the cutoff possible anywhere on the mesh? */
static bool needs_filter(const struct pbnds_mesh *mesh, const struct pbnds_material *m,
                         float cutoff)
{
    if (m->alpha_mode == PBNDS_ALPHA_OPAQUE) return false;
    return mesh->color || m->base_color_texture.texture >= 0 ||
           !(m->base_color.w >= cutoff);
}

static enum pbnds_status check_mesh(const struct pbnds_mesh *mesh,
                                    struct pbnds_error *error)
{
    if (mesh->vertex_count > UINT32_MAX || mesh->triangle_count > UINT32_MAX / 3) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "mesh \"%s\": %zu triangles of %zu vertices are more than the "
            "ray caster can hold; split the mesh",
            mesh->name, mesh->triangle_count, mesh->vertex_count);
    }
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        if (mesh->index[i] < mesh->vertex_count) continue;
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "mesh \"%s\": index %zu is %lu, past its %zu vertices; the mesh "
            "is damaged",
            mesh->name, i, (unsigned long)mesh->index[i], mesh->vertex_count);
    }
    return PBNDS_OK;
}

static enum pbnds_status add_mesh(struct pbnds_accel *accel,
                                  const struct pbnds_scene *scene, uint32_t id,
                                  struct pbnds_error *error)
{
    const struct pbnds_mesh *mesh = &scene->meshes[id];
    if (mesh->triangle_count == 0) return PBNDS_OK;
    PBNDS_TRY(check_mesh(mesh, error));

    RTCGeometry geometry = rtcNewGeometry(accel->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return fail_embree(accel, "made a geometry", error);
    /* A copy, because Embree reads sixteen bytes from each twelve-byte vertex; it pads
     * its own buffers for that. Indices may be shared. */
    struct pbnds_vec3 *vertices =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                sizeof *vertices, mesh->vertex_count);
    if (vertices) {
        memcpy(vertices, mesh->position, mesh->vertex_count * sizeof *vertices);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   mesh->index, 0, 3 * sizeof *mesh->index,
                                   mesh->triangle_count);
        const struct pbnds_material *m = &scene->materials[mesh->material];
        struct cutout *cutout = &accel->cutouts[id];
        accel->one_sided[id] = !m->double_sided;
        accel->culls = accel->culls || !m->double_sided;
        cutout->scene = scene;
        cutout->mesh = id;
        cutout->cutoff = m->alpha_mode == PBNDS_ALPHA_MASK ? m->alpha_cutoff : 0.5f;
        cutout->blend = m->alpha_mode == PBNDS_ALPHA_BLEND;
        if (needs_filter(mesh, m, cutout->blend ? 1.0f : cutout->cutoff)) {
            accel->blends = accel->blends || cutout->blend;
            rtcSetGeometryUserData(geometry, cutout);
            rtcSetGeometryIntersectFilterFunction(geometry, alpha_filter);
            rtcSetGeometryOccludedFilterFunction(geometry, alpha_filter);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(accel->scene, geometry, id);
    }
    rtcReleaseGeometry(geometry); /* the scene holds it now */
    if (!vertices || accel->code != RTC_ERROR_NONE) {
        return fail_embree(accel, "took in a mesh", error);
    }
    return PBNDS_OK;
}

static bool note_memory(void *user, ssize_t bytes, bool done)
{
    (void)done;
    struct pbnds_accel *accel = user;
    atomic_fetch_add(&accel->bytes, (int_least64_t)bytes);
    return true; /* go on */
}

static enum pbnds_status build(struct pbnds_accel *accel,
                               const struct pbnds_scene *scene,
                               const struct pbnds_accel_flags *flags,
                               struct pbnds_error *error)
{
    char config[32];
    snprintf(config, sizeof config, "threads=%d", pbnds_threads());
    accel->device = rtcNewDevice(config);
    if (!accel->device) {
        accel->code = rtcGetDeviceError(NULL);
        return fail_embree(accel, "started", error);
    }
    rtcSetDeviceErrorFunction(accel->device, note_fault, accel);
    rtcSetDeviceMemoryMonitorFunction(accel->device, note_memory, accel);
    accel->scene = rtcNewScene(accel->device);
    if (!accel->scene) return fail_embree(accel, "made a scene", error);
    rtcSetSceneFlags(accel->scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION |
                                       (flags->robust ? RTC_SCENE_FLAG_ROBUST : 0) |
                                       (flags->compact ? RTC_SCENE_FLAG_COMPACT : 0));
    rtcSetSceneBuildQuality(accel->scene, RTC_BUILD_QUALITY_MEDIUM);
    for (int i = 0; i < scene->mesh_count; ++i) {
        PBNDS_TRY(add_mesh(accel, scene, (uint32_t)i, error));
    }
    rtcCommitScene(accel->scene);
    if (accel->code != RTC_ERROR_NONE)
        return fail_embree(accel, "built the tree", error);
    return PBNDS_OK;
}

enum pbnds_status pbnds_accel_create_as(const struct pbnds_scene *scene,
                                        const struct pbnds_accel_flags *flags,
                                        struct pbnds_accel **accel,
                                        struct pbnds_error *error)
{
    *accel = NULL;
    struct pbnds_accel *made = calloc(1, sizeof *made);
    if (!made)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "the ray caster: out of memory");
    const size_t count = scene->mesh_count > 0 ? (size_t)scene->mesh_count : 1;
    made->cutouts = calloc(count, sizeof *made->cutouts);
    made->one_sided = calloc(count, sizeof *made->one_sided);
    enum pbnds_status status =
        made->cutouts && made->one_sided
            ? build(made, scene, flags, error)
            : pbnds_fail(error, PBNDS_ERROR_MEMORY,
                         "the ray caster: out of memory for %zu meshes", count);
    if (status != PBNDS_OK) {
        pbnds_accel_free(made);
        return status;
    }
    *accel = made;
    return PBNDS_OK;
}

/* Robust, because without it rays slip through edges: holes in watertight meshes. Not
 * compact, because that saves memory and costs speed: `pbnds bench bvh` has the numbers. */
enum pbnds_status pbnds_accel_create(const struct pbnds_scene *scene,
                                     struct pbnds_accel **accel,
                                     struct pbnds_error *error)
{
    static const struct pbnds_accel_flags chosen = {.robust = true, .compact = false};
    return pbnds_accel_create_as(scene, &chosen, accel, error);
}

uint64_t pbnds_accel_bytes(const struct pbnds_accel *accel)
{
    const int_least64_t bytes = atomic_load(&accel->bytes);
    return bytes > 0 ? (uint64_t)bytes : 0;
}

void pbnds_accel_free(struct pbnds_accel *accel)
{
    if (!accel) return;
    if (accel->scene) rtcReleaseScene(accel->scene);
    if (accel->device) rtcReleaseDevice(accel->device);
    free(accel->cutouts);
    free(accel->one_sided);
    free(accel);
}

/* Secondary rays. */

static float offset_component(float p, float n)
{
    /* Steps of the representation scale with the coordinate; near zero, where they
     * vanish, a fixed distance takes over. Constants of the paper. */
    const float origin = 1.0f / 32.0f, float_scale = 1.0f / 65536.0f,
                int_scale = 256.0f;
    if (fabsf(p) < origin) return p + float_scale * n;
    const int32_t step = (int32_t)(int_scale * n);
    int32_t bits;
    memcpy(&bits, &p, sizeof bits);
    bits += p < 0.0f ? -step : step;
    float moved;
    memcpy(&moved, &bits, sizeof moved);
    return moved;
}

struct pbnds_vec3 pbnds_offset_origin(struct pbnds_vec3 p, struct pbnds_vec3 ng)
{
    return pbnds_vec3_make(offset_component(p.x, ng.x), offset_component(p.y, ng.y),
                           offset_component(p.z, ng.z));
}
