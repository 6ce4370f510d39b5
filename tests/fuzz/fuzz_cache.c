/* libFuzzer target: any bytes as a light cache. What is sound lights a view. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "neural/light_cache.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pbnds_light_cache cache;
    struct pbnds_error error;
    uint8_t *bytes = malloc(size + 1);
    if (!bytes) return 0;
    memcpy(bytes, data, size);
    if (pbnds_light_cache_parse("fuzz", bytes, size, &cache, &error) != PBNDS_OK)
        return 0;
    struct pbnds_gbuffer g;
    struct pbnds_image radiance;
    if ((size_t)cache.width * (size_t)cache.height <= 1u << 16 &&
        pbnds_gbuffer_init(&g, cache.width, cache.height, &error) == PBNDS_OK) {
        const struct pbnds_shade_job job = {.gbuffer = &g};
        if (pbnds_light_cache_shade(&cache, &job, &radiance, &error) == PBNDS_OK)
            pbnds_image_free(&radiance);
        pbnds_gbuffer_free(&g);
    }
    pbnds_light_cache_free(&cache);
    return 0;
}
