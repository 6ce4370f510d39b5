#include "engine/shade/visibility.h"

#include <assert.h>
#include <math.h>

#include "engine/shade/tiles.h"

enum { TILE = 16, BLOCK = 4 }; /* a packet is a block of pixels, for one light */

struct job {
    const struct pbnds_gbuffer *g;
    const struct pbnds_accel *accel;
    const struct pbnds_vec3 *wi;
    int count;
    uint32_t *bits;
};

/* The pixels of a block that hit something. */
struct block {
    size_t pixel[PBNDS_PACKET];
    struct pbnds_vec3 origin[PBNDS_PACKET], ng[PBNDS_PACKET];
    int count;
};

static void find_block(const struct job *job, int x0, int y0,
                       const struct pbnds_tile *tile, struct block *block)
{
    const struct pbnds_gbuffer *g = job->g;
    block->count = 0;
    for (int y = y0; y < y0 + BLOCK && y < tile->y1; ++y) {
        for (int x = x0; x < x0 + BLOCK && x < tile->x1; ++x) {
            const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
            job->bits[i] = 0;
            if (!isfinite(g->depth[i])) continue;
            const int n = block->count++;
            block->pixel[n] = i;
            block->ng[n] = pbnds_gbuffer_vec3(g->geometric_normal, i);
            block->origin[n] =
                pbnds_offset_origin(pbnds_gbuffer_vec3(g->position, i), block->ng[n]);
        }
    }
}

static void look(const struct job *job, const struct block *block, int light)
{
    struct pbnds_ray rays[PBNDS_PACKET];
    size_t pixel[PBNDS_PACKET];
    bool occluded[PBNDS_PACKET];
    int count = 0;
    for (int n = 0; n < block->count; ++n) {
        if (!(pbnds_dot(block->ng[n], job->wi[light]) > 0.0f)) continue;
        rays[count] = (struct pbnds_ray){block->origin[n], job->wi[light]};
        pixel[count++] = block->pixel[n];
    }
    if (count == 0) return;
    pbnds_accel_occluded_packet(job->accel, rays, count, INFINITY, occluded);
    for (int n = 0; n < count; ++n)
        if (!occluded[n]) job->bits[pixel[n]] |= 1u << light;
}

static void look_tile(void *context, const struct pbnds_tile *tile)
{
    const struct job *job = context;
    for (int y = tile->y0; y < tile->y1; y += BLOCK) {
        for (int x = tile->x0; x < tile->x1; x += BLOCK) {
            struct block block;
            find_block(job, x, y, tile, &block);
            for (int k = 0; k < job->count; ++k)
                look(job, &block, k);
        }
    }
}

enum pbnds_status pbnds_visibility(const struct pbnds_gbuffer *gbuffer,
                                   const struct pbnds_accel *accel,
                                   const struct pbnds_vec3 *wi, int count,
                                   uint32_t *bits, struct pbnds_error *error)
{
    assert(count <= PBNDS_VISIBILITY_LIGHTS);
    struct job job = {gbuffer, accel, wi, count, bits};
    return pbnds_for_tiles(gbuffer->width, gbuffer->height, TILE, NULL, "visibility",
                           look_tile, &job, error);
}
