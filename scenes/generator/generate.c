#include "scenes/generator/generate.h"

#include <stdlib.h>

#include "scenes/generator/layout.h"
#include "scenes/generator/sky.h"

enum pbnds_status pbnds_world_generate(uint64_t seed, uint64_t index, uint8_t **glb,
                                       size_t *size, struct pbnds_error *error)
{
    *glb = NULL;
    *size = 0;
    struct gen_bytes file = {.size = 0};
    struct gen_world *w = calloc(1, sizeof *w);
    if (!w) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a world");
    gen_random_world(w, seed, index);
    const bool made = gen_glb_make(w, &file);
    gen_world_free(w);
    free(w);
    if (!made) {
        gen_bytes_free(&file);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "world %llu of seed %llu: no memory for it",
                          (unsigned long long)index, (unsigned long long)seed);
    }
    *glb = file.data;
    *size = file.size;
    return PBNDS_OK;
}

void pbnds_sky_generate(uint64_t seed, uint64_t index, int width, int height,
                        float *rgb)
{
    struct gen_sky sky;
    gen_random_sky(&sky, seed, index);
    gen_sky_render(&sky, width, height, rgb);
}
