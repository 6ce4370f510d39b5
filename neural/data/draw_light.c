#include "neural/data/draw_light.h"

#include "engine/core/color.h"

static float uniform(struct pbnds_rng *rng, float lo, float hi)
{
    return lo + (hi - lo) * pbnds_rng_float(rng);
}

/* Mean luminance of the light after strength: an ordinary exposure most of the time,
 * with a few dark rooms. Log-uniform. */
static float draw_strength(const struct pbnds_dataset_recipe *recipe,
                           struct pbnds_rng *rng, float mean_luminance)
{
    const bool dark = (double)pbnds_rng_float(rng) < recipe->dark_lights;
    const float ev = uniform(rng, -2.0f, 1.0f) - (dark ? 4.0f : 0.0f);
    return mean_luminance > 1e-8f ? exp2f(ev) / mean_luminance : 1.0f;
}

enum pbnds_status pbnds_draw_light(const struct pbnds_dataset_recipe *recipe,
                                   const struct pbnds_asset_list *envs,
                                   struct pbnds_rng *rng, struct pbnds_draw *draw,
                                   struct pbnds_error *error)
{
    struct pbnds_envmap *env;
    draw->env = pbnds_assets_pick(envs, draw->split, (double)pbnds_rng_float(rng));
    PBNDS_TRY(
        pbnds_envmap_load(draw->env->path, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, error));
    const float mean = pbnds_luminance(pbnds_envmap_mean(env));
    pbnds_envmap_free(env);
    draw->yaw_deg = uniform(rng, 0.0f, 360.0f);
    draw->strength = draw_strength(recipe, rng, mean);
    PBNDS_TRY(pbnds_envmap_load(draw->env->path, PBNDS_ENV_GLTF, draw->yaw_deg,
                                draw->strength, &env, error));
    const enum pbnds_status status =
        pbnds_envmap_bake(env, PBNDS_DATASET_LIGHT_WIDTH, PBNDS_DATASET_LIGHT_WIDTH / 2,
                          &draw->light, error);
    pbnds_envmap_free(env);
    cJSON_AddStringToObject(draw->notes, "light", draw->env->stem);
    cJSON_AddNumberToObject(draw->notes, "yaw_deg", (double)draw->yaw_deg);
    cJSON_AddNumberToObject(draw->notes, "strength", (double)draw->strength);
    return status;
}
