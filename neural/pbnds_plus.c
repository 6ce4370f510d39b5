#include "neural/pbnds_plus.h"

#include "engine/core/rng.h"

/* Uniform rotation: a unit quaternion after Shoemake 1992, as the images of the axes.
 */
static struct pbnds_mat4 random_rotation(uint64_t seed)
{
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
    const float u = pbnds_rng_float(&rng);
    const float a = 2.0f * PBNDS_PI * pbnds_rng_float(&rng);
    const float b = 2.0f * PBNDS_PI * pbnds_rng_float(&rng);
    const float r = sqrtf(1.0f - u), s = sqrtf(u);
    const struct pbnds_vec4 q = {r * sinf(a), r * cosf(a), s * sinf(b), s * cosf(b)};
    return pbnds_mat4_from_trs(pbnds_splat(0.0f), q, pbnds_splat(1.0f));
}

void pbnds_plus_draw_lights(const struct pbnds_envmap *envmap, uint64_t seed, int count,
                            struct pbnds_light_source *lights)
{
    const struct pbnds_mat4 rotation = random_rotation(seed);
    const float golden = 2.39996322972865332f; /* pi (3 - sqrt 5) */
    const float share = 4.0f * PBNDS_PI / (float)count;
    for (int i = 0; i < count; ++i) {
        const float z = 1.0f - (2.0f * (float)i + 1.0f) / (float)count;
        const float phi = golden * (float)i;
        const float r = sqrtf(fmaxf(1.0f - z * z, 0.0f));
        const struct pbnds_vec3 wi = pbnds_normalize(pbnds_mat4_vector(
            &rotation, pbnds_vec3_make(r * cosf(phi), r * sinf(phi), z)));
        lights[i] = (struct pbnds_light_source){
            .wi = wi,
            .radiance =
                envmap ? pbnds_envmap_eval_cone(envmap, wi, share) : pbnds_splat(0.0f)};
    }
}
