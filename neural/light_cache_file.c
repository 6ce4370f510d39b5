/* The file of a light cache: a head, then the arrays as they are in memory, little
 * endian. Nothing in it is believed: sizes are worked out and compared before anything
 * is pointed at, pixels must ascend within the image, floats must be finite, and the
 * bytes must have the hash that the head says. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <xxhash.h>

#include "engine/core/file.h"
#include "neural/light_cache.h"

enum { HEAD = 64, MAX_SIDE = 65535 };

struct head {
    char magic[8];
    uint32_t width, height, directions, looks;
    uint32_t covered, glossy;
    uint64_t weights, gbuffer, hash;
    uint64_t unused;
};
_Static_assert(sizeof(struct head) == HEAD, "the head has no gaps");
_Static_assert(sizeof(struct pbnds_cache_gloss) == 40, "nor has a lobe");

/* Of all bytes but its own. */
static uint64_t hash_of(const struct pbnds_light_cache *c, struct head head)
{
    head.hash = 0;
    return XXH64(c->storage + HEAD, c->size - HEAD, XXH64(&head, sizeof head, 0));
}

static const char MAGIC[8] = {'p', 'b', 'n', 'd', 's', 'L', 'C', '1'};

/* Sizes of the parts; cannot overflow: pixels < 2^32, directions <= 2^10. */
static size_t pixel_bytes(const struct pbnds_light_cache *c)
{
    return c->blocks * PBNDS_CACHE_BLOCK * sizeof(uint32_t);
}

static size_t scale_bytes(const struct pbnds_light_cache *c)
{
    return c->blocks * 3 * PBNDS_CACHE_BLOCK * sizeof(float);
}

static size_t transport_bytes(const struct pbnds_light_cache *c)
{
    return c->blocks * (size_t)c->directions * 3 * PBNDS_CACHE_BLOCK;
}

static size_t measure(struct pbnds_light_cache *c)
{
    c->blocks = (c->covered + PBNDS_CACHE_BLOCK - 1) / PBNDS_CACHE_BLOCK;
    return HEAD + pixel_bytes(c) + scale_bytes(c) + transport_bytes(c) +
           c->glossy * sizeof(struct pbnds_cache_gloss);
}

static void point(struct pbnds_light_cache *c)
{
    uint8_t *at = c->storage + HEAD;
    c->pixel = (uint32_t *)(void *)at;
    at += pixel_bytes(c);
    c->scale = (float *)(void *)at;
    at += scale_bytes(c);
    c->transport = at;
    at += transport_bytes(c);
    c->gloss = (struct pbnds_cache_gloss *)(void *)at;
}

enum pbnds_status pbnds_light_cache_allocate(struct pbnds_light_cache *cache,
                                             struct pbnds_error *error)
{
    cache->size = measure(cache);
    cache->storage = calloc(1, cache->size);
    if (!cache->storage) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "light cache: no memory for %zu bytes, use fewer directions",
                          cache->size);
    }
    point(cache);
    return PBNDS_OK;
}

void pbnds_light_cache_free(struct pbnds_light_cache *cache)
{
    free(cache->storage);
    *cache = (struct pbnds_light_cache){0};
}

enum pbnds_status pbnds_light_cache_write(const char *path,
                                          const struct pbnds_light_cache *cache,
                                          struct pbnds_error *error)
{
    struct head head = {.width = (uint32_t)cache->width,
                        .height = (uint32_t)cache->height,
                        .directions = (uint32_t)cache->directions,
                        .looks = PBNDS_CACHE_LOOKS,
                        .covered = (uint32_t)cache->covered,
                        .glossy = (uint32_t)cache->glossy,
                        .weights = cache->weights,
                        .gbuffer = cache->gbuffer};
    memcpy(head.magic, MAGIC, sizeof MAGIC);
    head.hash = hash_of(cache, head);
    memcpy(cache->storage, &head, sizeof head);
    return pbnds_file_write(path, cache->storage, cache->size, error);
}

static enum pbnds_status damaged(const char *name, const char *how,
                                 struct pbnds_error *error)
{
    return pbnds_fail(
        error, PBNDS_ERROR_FORMAT,
        "%s: is no sound light cache (%s); delete it to have it made anew", name, how);
}

static enum pbnds_status check_head(const char *name, const struct head *head,
                                    size_t size, struct pbnds_error *error)
{
    if (size < HEAD || memcmp(head->magic, MAGIC, sizeof MAGIC) != 0)
        return damaged(name, "it does not begin as one", error);
    if (head->width < 1 || head->width > MAX_SIDE || head->height < 1 ||
        head->height > MAX_SIDE || head->directions < 1 ||
        head->directions > PBNDS_CACHE_DIRECTIONS_MAX ||
        head->looks != PBNDS_CACHE_LOOKS || head->unused != 0) {
        return damaged(name, "its sizes are out of range", error);
    }
    const uint64_t pixels = (uint64_t)head->width * head->height;
    if (head->covered > pixels || head->glossy > head->covered)
        return damaged(name, "it has more pixels than its image", error);
    return PBNDS_OK;
}

static enum pbnds_status check_arrays(const char *name,
                                      const struct pbnds_light_cache *c,
                                      struct pbnds_error *error)
{
    const uint64_t pixels = (uint64_t)c->width * (uint64_t)c->height;
    int64_t last = -1;
    for (size_t i = 0; i < c->covered; ++i) {
        if ((int64_t)c->pixel[i] <= last || c->pixel[i] >= pixels)
            return damaged(name, "its pixels are not in order", error);
        last = c->pixel[i];
    }
    for (size_t i = 0; i < c->blocks * 3 * PBNDS_CACHE_BLOCK; ++i) {
        if (!(c->scale[i] >= 0.0f && isfinite(c->scale[i])))
            return damaged(name, "a number in it is not finite", error);
    }
    last = -1;
    for (size_t i = 0; i < c->glossy; ++i) {
        const struct pbnds_cache_gloss *g = &c->gloss[i];
        if ((int64_t)g->pixel <= last || g->pixel >= pixels)
            return damaged(name, "its pixels are not in order", error);
        last = g->pixel;
        if (!(isfinite(g->scale[0]) && isfinite(g->scale[1]) && isfinite(g->scale[2])))
            return damaged(name, "a number in it is not finite", error);
    }
    return PBNDS_OK;
}

static enum pbnds_status parse(const char *name, struct pbnds_light_cache *c,
                               struct pbnds_error *error)
{
    struct head head = {.width = 0};
    if (c->size >= HEAD) memcpy(&head, c->storage, sizeof head);
    PBNDS_TRY(check_head(name, &head, c->size, error));
    c->width = (int)head.width;
    c->height = (int)head.height;
    c->directions = (int)head.directions;
    c->covered = head.covered;
    c->glossy = head.glossy;
    c->weights = head.weights;
    c->gbuffer = head.gbuffer;
    if (measure(c) != c->size)
        return damaged(name, "its length is not that of its contents", error);
    point(c);
    PBNDS_TRY(check_arrays(name, c, error));
    if (hash_of(c, head) != head.hash)
        return damaged(name, "its bytes are not those that were written", error);
    return PBNDS_OK;
}

enum pbnds_status pbnds_light_cache_parse(const char *name, uint8_t *bytes, size_t size,
                                          struct pbnds_light_cache *cache,
                                          struct pbnds_error *error)
{
    *cache = (struct pbnds_light_cache){.storage = bytes, .size = size};
    const enum pbnds_status status = parse(name, cache, error);
    if (status != PBNDS_OK) pbnds_light_cache_free(cache);
    return status;
}

enum pbnds_status pbnds_light_cache_read(const char *path,
                                         struct pbnds_light_cache *cache,
                                         struct pbnds_error *error)
{
    uint8_t *bytes;
    size_t size;
    *cache = (struct pbnds_light_cache){0};
    PBNDS_TRY(pbnds_file_read(path, (size_t)1 << 40, &bytes, &size, error));
    return pbnds_light_cache_parse(path, bytes, size, cache, error);
}
