/* The planes of a G-buffer: one block of memory, laid out here and nowhere else. */
#include "engine/shade/gbuffer.h"

#include <stdlib.h>
#include <string.h>

#include "engine/shade/cryptomatte.h"
#include "engine/shade/gbuffer_planes.h"

enum { ALIGN = 64 /* of each plane, bytes */ };

/* The planes that a G-buffer has, in the order in which they lie in storage. */
struct layout {
    float **real[PBNDS_PLANES_MAX];
    uint32_t **id[PBNDS_PLANES_MAX];
    int reals, ids;
};

static void add(struct layout *layout, float **plane, int count)
{
    for (int c = 0; c < count; ++c)
        layout->real[layout->reals++] = plane + c;
}

static struct layout list_planes(struct pbnds_gbuffer *g, unsigned optional,
                                 bool fresnel)
{
    struct layout layout = {.reals = 0};
    add(&layout, g->albedo, 3);
    add(&layout, g->normal, 3);
    add(&layout, &g->specular, 1);
    add(&layout, &g->roughness, 1);
    add(&layout, &g->metallic, 1);
    add(&layout, &g->depth, 1);
    add(&layout, &g->coverage, 1);
    add(&layout, g->position, 3);
    add(&layout, g->emission, 3);
    add(&layout, g->geometric_normal, 3);
    if (fresnel) add(&layout, g->f0, 3);
    if (fresnel) add(&layout, &g->f90, 1);
    if (optional & PBNDS_OPTIONAL_AO) add(&layout, &g->ao, 1);
    if (optional & PBNDS_OPTIONAL_UV) add(&layout, g->uv, 2);
    if (optional & PBNDS_OPTIONAL_MOTION) add(&layout, g->motion, 2);
    layout.id[layout.ids++] = &g->object_id;
    if (optional & PBNDS_OPTIONAL_MATERIAL_ID)
        layout.id[layout.ids++] = &g->material_id;
    return layout;
}

enum pbnds_status pbnds_gbuffer_reserve(struct pbnds_gbuffer *gbuffer, int width,
                                         int height, unsigned optional, bool fresnel,
                                         struct pbnds_error *error)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    if (width < 1 || width > 65535 || height < 1 || height > 65535) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "a G-buffer of %d x %d pixels cannot be; sides go from 1 to 65535", width,
            height);
    }
    const struct layout layout = list_planes(gbuffer, optional, fresnel);
    const uint64_t count = (uint64_t)width * (uint64_t)height;
    /* A pixel of all planes is written at once. Were a plane a whole number of pages, as
     * it is at 1920 x 1080, all of these would fall into one set of the first cache. */
    const uint64_t page = 4096, step = 5 * ALIGN;
    const uint64_t plane = (count * sizeof(float) + page - 1) / page * page + step;
    const uint64_t total = plane * (uint64_t)(layout.reals + layout.ids) + ALIGN;
    if (total <= SIZE_MAX / 2) gbuffer->storage = malloc((size_t)total);
    if (!gbuffer->storage) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "a G-buffer of %d x %d pixels needs %llu MB of memory; use a "
                          "smaller size",
                          width, height, (unsigned long long)(total >> 20));
    }
    char *at = gbuffer->storage;
    at += (ALIGN - (uintptr_t)at % ALIGN) % ALIGN;
    for (int i = 0; i < layout.reals; ++i, at += plane)
        *layout.real[i] = (float *)(void *)at;
    for (int i = 0; i < layout.ids; ++i, at += plane)
        *layout.id[i] = (uint32_t *)(void *)at;
    gbuffer->width = width;
    gbuffer->height = height;
    gbuffer->samples = 1;
    return PBNDS_OK;
}

enum pbnds_status pbnds_gbuffer_allocate(struct pbnds_gbuffer *gbuffer, int width,
                                         int height, unsigned optional, bool fresnel,
                                         struct pbnds_error *error)
{
    PBNDS_TRY(
        pbnds_gbuffer_reserve(gbuffer, width, height, optional, fresnel, error));
    char *planes[PBNDS_PLANES_MAX];
    const int count = pbnds_gbuffer_list(gbuffer, planes);
    for (int i = 0; i < count; ++i)
        memset(planes[i], 0, 4 * (size_t)width * (size_t)height);
    return PBNDS_OK;
}

int pbnds_gbuffer_list(const struct pbnds_gbuffer *gbuffer,
                       char *planes[PBNDS_PLANES_MAX])
{
    /* The layout names the fields of a copy, with every optional plane. */
    struct pbnds_gbuffer copy = *gbuffer;
    const struct layout all = list_planes(&copy, ~0u, true);
    int count = 0;
    for (int i = 0; i < all.reals; ++i) {
        if (*all.real[i]) planes[count++] = (char *)*all.real[i];
    }
    for (int i = 0; i < all.ids; ++i) {
        if (*all.id[i]) planes[count++] = (char *)*all.id[i];
    }
    return count;
}

void pbnds_gbuffer_point_into(struct pbnds_gbuffer *gbuffer, void *memory, size_t bytes)
{
    const struct layout all = list_planes(gbuffer, ~0u, true);
    char *at = memory;
    for (int i = 0; i < all.reals; ++i) {
        if (!*all.real[i]) continue;
        *all.real[i] = (float *)(void *)at;
        at += bytes;
    }
    for (int i = 0; i < all.ids; ++i) {
        if (!*all.id[i]) continue;
        *all.id[i] = (uint32_t *)(void *)at;
        at += bytes;
    }
}

enum pbnds_status pbnds_gbuffer_init(struct pbnds_gbuffer *gbuffer, int width,
                                     int height, struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_gbuffer_allocate(gbuffer, width, height, 0, false, error));
    const size_t count = (size_t)width * (size_t)height;
    for (size_t i = 0; i < count; ++i) {
        gbuffer->depth[i] = INFINITY;
        gbuffer->object_id[i] = UINT32_MAX;
    }
    gbuffer->camera.world_from_camera = pbnds_mat4_identity();
    return PBNDS_OK;
}

void pbnds_gbuffer_free(struct pbnds_gbuffer *gbuffer)
{
    pbnds_cryptomatte_free(gbuffer->cryptomatte);
    free(gbuffer->storage);
    memset(gbuffer, 0, sizeof *gbuffer);
}

struct pbnds_vec3 pbnds_gbuffer_wo(const struct pbnds_gbuffer *gbuffer, int x, int y)
{
    const struct pbnds_ray ray =
        pbnds_camera_ray(&gbuffer->camera, gbuffer->width, gbuffer->height,
                         (float)x + 0.5f, (float)y + 0.5f);
    return pbnds_scale(ray.direction, -1.0f);
}
