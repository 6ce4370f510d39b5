#include "neural/pbnds_plus.h"

#include "engine/core/rng.h"

void pbnds_plus_draw_lights(const struct pbnds_envmap *envmap, uint64_t seed,
                            uint64_t stream, int count,
                            struct pbnds_light_source *lights)
{
    for (int i = 0; i < count; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(seed, stream, (uint64_t)i);
        const float z = 1.0f - 2.0f * pbnds_rng_float(&rng);
        const float phi = 2.0f * PBNDS_PI * pbnds_rng_float(&rng);
        const float r = sqrtf(fmaxf(1.0f - z * z, 0.0f));
        const struct pbnds_vec3 wi = {r * cosf(phi), r * sinf(phi), z};
        lights[i] = (struct pbnds_light_source){
            .wi = wi,
            .radiance = envmap ? pbnds_envmap_eval(envmap, wi) : pbnds_splat(0.0f)};
    }
}
