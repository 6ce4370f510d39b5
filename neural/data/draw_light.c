#include "neural/data/draw_light.h"

#include "neural/data/draw_lamps.h"
#include "neural/data/draw_random.h"
#include "scenes/generator/generate.h"

enum { WIDTH = PBNDS_DATASET_LIGHT_WIDTH, HEIGHT = PBNDS_DATASET_LIGHT_WIDTH / 2 };

static const double TILTED_SHARE = 0.04;

/* Hard lights have no file. */
static const struct pbnds_asset lamps_asset = {.stem = "lamps"};

static enum pbnds_status load_env(const struct pbnds_dataset_recipe *recipe,
                                  const struct pbnds_asset *asset, float yaw_deg,
                                  struct pbnds_envmap **env, struct pbnds_error *error)
{
    if (asset->path) {
        return pbnds_envmap_load(asset->path, PBNDS_ENV_GLTF, yaw_deg, 1.0f, env,
                                 error);
    }
    struct pbnds_image sky;
    PBNDS_TRY(pbnds_image_init(&sky, WIDTH, HEIGHT, 3, error));
    pbnds_sky_generate(recipe->world_seed, asset->number, sky.width, sky.height,
                       sky.data);
    const enum pbnds_status status =
        pbnds_envmap_create(&sky, PBNDS_ENV_GLTF, yaw_deg, 1.0f, env, error);
    pbnds_image_free(&sky);
    return status;
}

static void scale_image(struct pbnds_image *image, float scale)
{
    const size_t n = 3 * (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < n; ++i)
        image->data[i] *= scale;
}

/* A light map of the split, turned, of mean luminance 1. `notes` tells of it. */
static enum pbnds_status draw_map(const struct pbnds_dataset_recipe *recipe,
                                  const struct pbnds_asset *asset, float yaw_deg,
                                  struct pbnds_image *light, float *strength,
                                  struct pbnds_error *error)
{
    struct pbnds_envmap *env;
    PBNDS_TRY(load_env(recipe, asset, yaw_deg, &env, error));
    const enum pbnds_status baked = pbnds_envmap_bake(env, WIDTH, HEIGHT, light, error);
    pbnds_envmap_free(env);
    PBNDS_TRY(baked);
    const float mean = pbnds_map_luminance(light);
    if (!(mean > 1e-12f && mean < INFINITY)) {
        pbnds_image_free(light);
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: this light map is black; take it out",
                          asset->path ? asset->path : asset->stem);
    }
    *strength = 1.0f / mean;
    scale_image(light, *strength);
    return PBNDS_OK;
}

/* L'(w) = L(R w), R a turn about a horizontal axis; each texel the mean of 4 x 4 points. */
static enum pbnds_status tilt(struct pbnds_image *light, struct pbnds_vec3 axis,
                              float angle, struct pbnds_error *error)
{
    struct pbnds_envmap *env;
    PBNDS_TRY(pbnds_envmap_create(light, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, error));
    const float c = cosf(angle), s = sinf(angle);
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            struct pbnds_vec3 sum = pbnds_splat(0.0f);
            for (int i = 0; i < 16; ++i) {
                const float u = ((float)x + ((float)(i % 4) + 0.5f) / 4.0f) / WIDTH;
                const float v = ((float)y + ((float)(i / 4) + 0.5f) / 4.0f) / HEIGHT;
                const float azimuth = 2.0f * PBNDS_PI * (u - 0.5f);
                const float r = sinf(PBNDS_PI * v);
                const struct pbnds_vec3 w = {r * cosf(azimuth), cosf(PBNDS_PI * v),
                                             r * sinf(azimuth)};
                /* Rodrigues' rotation */
                const struct pbnds_vec3 turned = pbnds_normalize(
                    pbnds_mad(pbnds_mad(pbnds_scale(w, c), pbnds_cross(axis, w), s),
                              axis, pbnds_dot(axis, w) * (1.0f - c)));
                sum = pbnds_add(sum, pbnds_envmap_eval(env, turned));
            }
            float *p = pbnds_image_at(light, x, y);
            p[0] = sum.x / 16.0f;
            p[1] = sum.y / 16.0f;
            p[2] = sum.z / 16.0f;
        }
    }
    pbnds_envmap_free(env);
    scale_image(light, 1.0f / pbnds_map_luminance(light));
    return PBNDS_OK;
}

/* Adds another map of the split: light = (1 - t) light + t other. */
static enum pbnds_status mix(const struct pbnds_dataset_recipe *recipe,
                             const struct pbnds_asset *asset, float yaw_deg, float t,
                             struct pbnds_draw *draw, struct pbnds_error *error)
{
    struct pbnds_image other;
    float strength;
    PBNDS_TRY(draw_map(recipe, asset, yaw_deg, &other, &strength, error));
    const size_t n = 3 * (size_t)WIDTH * HEIGHT;
    for (size_t i = 0; i < n; ++i)
        draw->light.data[i] = (1.0f - t) * draw->light.data[i] + t * other.data[i];
    pbnds_image_free(&other);
    cJSON *notes = cJSON_AddObjectToObject(draw->notes, "mixed_light");
    cJSON_AddStringToObject(notes, "light", asset->stem);
    cJSON_AddNumberToObject(notes, "yaw_deg", (double)yaw_deg);
    cJSON_AddNumberToObject(notes, "share", (double)t);
    return PBNDS_OK;
}

/* All that is drawn, whatever becomes of it: one choice does not move the next. */
struct choices {
    const struct pbnds_asset *first, *second;
    bool hard, mixed, dark, tilted;
    float yaw[2], t, exposure, darker, axis, angle;
};

/* Whole texels: procedural maps, made at the size of the light, stay as sharp. */
static float draw_yaw(struct pbnds_rng *rng)
{
    return 360.0f / WIDTH * (float)pbnds_draw_below(rng, WIDTH);
}

static struct choices draw_choices(const struct pbnds_dataset_recipe *recipe,
                                   const struct pbnds_asset_list *envs,
                                   enum pbnds_split split, struct pbnds_rng *rng)
{
    struct choices c;
    c.first = pbnds_assets_pick(envs, split, (double)pbnds_rng_float(rng));
    c.second = pbnds_assets_pick(envs, split, (double)pbnds_rng_float(rng));
    c.hard = pbnds_draw_chance(rng, recipe->hard_lights);
    c.mixed = pbnds_draw_chance(rng, recipe->mix_lights);
    c.dark = pbnds_draw_chance(rng, recipe->dark_lights);
    c.tilted = pbnds_draw_chance(rng, TILTED_SHARE);
    c.yaw[0] = draw_yaw(rng);
    c.yaw[1] = draw_yaw(rng);
    c.t = pbnds_rng_float(rng);
    c.exposure = pbnds_rng_float(rng);
    c.darker = pbnds_draw_uniform(rng, 4.0f, 7.0f);
    c.axis = pbnds_draw_uniform(rng, 0.0f, 2.0f * PBNDS_PI);
    c.angle = pbnds_draw_uniform(rng, 0.1f, 0.8f * PBNDS_PI);
    return c;
}

static enum pbnds_status make_map(const struct pbnds_dataset_recipe *recipe,
                                  const struct choices *c, struct pbnds_draw *draw,
                                  struct pbnds_error *error)
{
    draw->env = c->first;
    draw->yaw_deg = c->yaw[0];
    cJSON_AddStringToObject(draw->notes, "light", draw->env->stem);
    cJSON_AddNumberToObject(draw->notes, "yaw_deg", (double)draw->yaw_deg);
    PBNDS_TRY(
        draw_map(recipe, c->first, c->yaw[0], &draw->light, &draw->strength, error));
    if (c->mixed) PBNDS_TRY(mix(recipe, c->second, c->yaw[1], c->t, draw, error));
    if (!c->tilted) return PBNDS_OK;
    cJSON_AddNumberToObject(draw->notes, "tilt_deg",
                            (double)(c->angle * 180.0f / PBNDS_PI));
    cJSON_AddNumberToObject(draw->notes, "tilt_axis_deg",
                            (double)(c->axis * 180.0f / PBNDS_PI));
    return tilt(&draw->light, pbnds_vec3_make(cosf(c->axis), 0.0f, sinf(c->axis)),
                c->angle, error);
}

static enum pbnds_status make_lamps(struct pbnds_rng *rng, struct pbnds_draw *draw,
                                    struct pbnds_error *error)
{
    draw->env = &lamps_asset;
    draw->yaw_deg = 0.0f;
    draw->strength = 1.0f;
    cJSON_AddStringToObject(draw->notes, "light", draw->env->stem);
    cJSON_AddNumberToObject(draw->notes, "yaw_deg", 0.0);
    PBNDS_TRY(pbnds_image_init(&draw->light, WIDTH, HEIGHT, 3, error));
    pbnds_draw_lamps(rng, &draw->light, draw->notes);
    return PBNDS_OK;
}

enum pbnds_status pbnds_draw_light(const struct pbnds_dataset_recipe *recipe,
                                   const struct pbnds_asset_list *envs,
                                   struct pbnds_rng *rng, struct pbnds_draw *draw,
                                   struct pbnds_error *error)
{
    const struct choices c = draw_choices(recipe, envs, draw->split, rng);
    PBNDS_TRY(c.hard ? make_lamps(rng, draw, error)
                     : make_map(recipe, &c, draw, error));
    const float ev = (c.hard ? -3.0f + 3.0f * c.exposure : -2.0f + 3.0f * c.exposure) -
                     (c.dark ? c.darker : 0.0f);
    scale_image(&draw->light, exp2f(ev));
    draw->strength *= exp2f(ev);
    cJSON_AddNumberToObject(draw->notes, "strength", (double)draw->strength);
    cJSON_AddNumberToObject(draw->notes, "mean_luminance", (double)exp2f(ev));
    return PBNDS_OK;
}
