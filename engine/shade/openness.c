#include "engine/shade/openness.h"

#include <math.h>

#include "engine/shade/sampler.h"
#include "engine/shade/tiles.h"

enum { TILE = 8 };

struct job {
    const struct pbnds_gbuffer *g;
    const struct pbnds_accel *accel;
    int rays;
    uint64_t seed;
    float *open;
};

/* Malley's method about n. */
static struct pbnds_vec3 cosine_direction(const struct pbnds_frame *frame,
                                          const float u[2])
{
    const float r = sqrtf(u[0]), phi = 2.0f * PBNDS_PI * u[1];
    const struct pbnds_vec3 w = {r * cosf(phi), r * sinf(phi), sqrtf(1.0f - u[0])};
    return pbnds_to_world(frame, w);
}

static float openness(const struct job *job, size_t i)
{
    const struct pbnds_gbuffer *g = job->g;
    const struct pbnds_vec3 ng = pbnds_gbuffer_vec3(g->geometric_normal, i);
    const struct pbnds_frame frame =
        pbnds_frame_from_normal(pbnds_gbuffer_vec3(g->normal, i));
    struct pbnds_ray ray = {
        .origin = pbnds_offset_origin(pbnds_gbuffer_vec3(g->position, i), ng)};
    int open = 0;
    for (int s = 0; s < job->rays; ++s) {
        const struct pbnds_sampler sampler =
            pbnds_sampler_make(job->seed, i, (uint32_t)s, (uint32_t)job->rays);
        float u[2];
        pbnds_sampler_get(&sampler, 0, 2, u);
        ray.direction = cosine_direction(&frame, u);
        if (pbnds_dot(ng, ray.direction) > 0.0f)
            open += !pbnds_accel_occluded(job->accel, &ray, INFINITY);
    }
    return (float)open / (float)job->rays;
}

static void open_tile(void *context, const struct pbnds_tile *tile)
{
    const struct job *job = context;
    for (int y = tile->y0; y < tile->y1 && !pbnds_stop_requested(); ++y) {
        for (int x = tile->x0; x < tile->x1; ++x) {
            const size_t i = (size_t)y * (size_t)job->g->width + (size_t)x;
            job->open[i] = isfinite(job->g->depth[i]) ? openness(job, i) : 0.0f;
        }
    }
}

enum pbnds_status pbnds_openness(const struct pbnds_gbuffer *gbuffer,
                                 const struct pbnds_accel *accel, int rays,
                                 uint64_t seed, float *open, struct pbnds_error *error)
{
    struct job job = {gbuffer, accel, rays, seed, open};
    return pbnds_for_tiles(gbuffer->width, gbuffer->height, TILE, NULL, "openness",
                           open_tile, &job, error);
}
