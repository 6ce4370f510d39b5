#include "neural/data/draw.h"

#include <stdlib.h>

#include "engine/scene/gltf.h"
#include "neural/data/draw_camera.h"
#include "neural/data/draw_light.h"
#include "neural/data/draw_material.h"
#include "neural/data/draw_random.h"
#include "scenes/generator/generate.h"

struct pbnds_drawer {
    const struct pbnds_dataset_recipe *recipe;
    struct pbnds_asset_list scenes, envs;
    /* The scene loaded last: neighbours often want another, so this only helps small data
     * sets of large assets. */
    const struct pbnds_asset *loaded;
    struct pbnds_scene scene;
    struct pbnds_accel *accel;
    struct pbnds_subjects subjects;
    struct pbnds_material_store materials; /* those of the file */
};

enum pbnds_status pbnds_drawer_create(const struct pbnds_dataset_recipe *recipe,
                                      struct pbnds_drawer **drawer,
                                      struct pbnds_error *error)
{
    *drawer = NULL;
    PBNDS_TRY(pbnds_dataset_recipe_check(recipe, error));
    struct pbnds_drawer *d = calloc(1, sizeof *d);
    if (!d) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for assets");
    d->recipe = recipe;
    enum pbnds_status status =
        pbnds_assets_find(recipe, PBNDS_ASSET_SCENE, &d->scenes, error);
    if (status == PBNDS_OK)
        status = pbnds_assets_find(recipe, PBNDS_ASSET_LIGHT, &d->envs, error);
    for (int s = 0; s < PBNDS_SPLIT_COUNT && status == PBNDS_OK; ++s) {
        const enum pbnds_split split = (enum pbnds_split)s;
        const bool filled = pbnds_assets_pick(&d->scenes, split, 0.0) &&
                            pbnds_assets_pick(&d->envs, split, 0.0);
        if (pbnds_drawer_count(d, split) > 0 && !filled) {
            status = pbnds_fail(
                error, PBNDS_ERROR_ARGUMENT,
                "no scene or no light map belongs to split %s; put some below a "
                "folder of that name",
                pbnds_split_name(split));
        }
    }
    if (status != PBNDS_OK) {
        pbnds_drawer_free(d);
        return status;
    }
    *drawer = d;
    return PBNDS_OK;
}

static void unload(struct pbnds_drawer *d)
{
    pbnds_accel_free(d->accel);
    d->accel = NULL;
    pbnds_subjects_free(&d->subjects);
    pbnds_material_store_free(&d->materials);
    pbnds_scene_free(&d->scene);
    d->loaded = NULL;
}

void pbnds_drawer_free(struct pbnds_drawer *drawer)
{
    if (!drawer) return;
    unload(drawer);
    pbnds_assets_free(&drawer->scenes);
    pbnds_assets_free(&drawer->envs);
    free(drawer);
}

const struct pbnds_asset_list *pbnds_drawer_scenes(const struct pbnds_drawer *drawer)
{
    return &drawer->scenes;
}

const struct pbnds_asset_list *pbnds_drawer_envs(const struct pbnds_drawer *drawer)
{
    return &drawer->envs;
}

static bool is_filled(const struct pbnds_drawer *d, int split)
{
    return pbnds_assets_pick(&d->scenes, (enum pbnds_split)split, 0.0) &&
           pbnds_assets_pick(&d->envs, (enum pbnds_split)split, 0.0);
}

int pbnds_drawer_count(const struct pbnds_drawer *drawer, enum pbnds_split split)
{
    const int *count = drawer->recipe->count;
    if (!drawer->recipe->every_split) return count[split];
    if (split != PBNDS_SPLIT_TRAIN)
        return is_filled(drawer, (int)split) ? count[split] : 0;
    int sum = count[PBNDS_SPLIT_TRAIN];
    for (int s = PBNDS_SPLIT_VAL; s < PBNDS_SPLIT_COUNT; ++s)
        sum += is_filled(drawer, s) ? 0 : count[s];
    return sum;
}

struct pbnds_rng pbnds_draw_rng(const struct pbnds_dataset_recipe *recipe,
                                enum pbnds_split split, int index,
                                enum pbnds_draw_stream stream)
{
    return pbnds_rng_make(recipe->seed, (uint64_t)split << 32 | (uint64_t)index,
                          (uint64_t)stream);
}

static enum pbnds_status load_world(const struct pbnds_dataset_recipe *recipe,
                                    const struct pbnds_asset *asset,
                                    struct pbnds_scene *scene,
                                    struct pbnds_error *error)
{
    uint8_t *glb;
    size_t size;
    PBNDS_TRY(
        pbnds_world_generate(recipe->world_seed, asset->number, &glb, &size, error));
    const enum pbnds_status status =
        pbnds_gltf_load_memory(glb, size, asset->stem, NULL, NULL, NULL, scene, error);
    free(glb);
    return status;
}

static enum pbnds_status prepare_scene(struct pbnds_drawer *d,
                                       struct pbnds_error *error)
{
    /* A wall that stops light and that the camera looks through is nothing to learn from:
     * the G-buffer does not tell of it. */
    for (int i = 0; i < d->scene.material_count; ++i)
        d->scene.materials[i].double_sided = true;
    PBNDS_TRY(pbnds_accel_create(&d->scene, &d->accel, error));
    PBNDS_TRY(pbnds_materials_keep(&d->scene, &d->materials, error));
    if (!pbnds_subjects_find(&d->scene, d->accel, &d->subjects))
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a scene");
    return PBNDS_OK;
}

static enum pbnds_status load_scene(struct pbnds_drawer *d,
                                    const struct pbnds_asset *asset,
                                    struct pbnds_error *error)
{
    if (d->loaded == asset) return PBNDS_OK;
    unload(d);
    PBNDS_TRY(asset->path ? pbnds_gltf_load(asset->path, NULL, NULL, &d->scene, error)
                          : load_world(d->recipe, asset, &d->scene, error));
    const enum pbnds_status status = prepare_scene(d, error);
    if (status != PBNDS_OK) {
        unload(d);
        return status;
    }
    d->loaded = asset;
    return PBNDS_OK;
}

static void draw_materials(struct pbnds_drawer *d, struct pbnds_draw *draw)
{
    struct pbnds_rng rng =
        pbnds_draw_rng(d->recipe, draw->split, draw->index, PBNDS_DRAW_MATERIAL);
    const bool swap = pbnds_draw_chance(&rng, d->recipe->swap_textures);
    const bool randomize = pbnds_draw_chance(&rng, d->recipe->randomize_materials);
    pbnds_materials_restore(&d->materials, &d->scene);
    const int swapped = swap ? pbnds_materials_swap(&d->materials, &d->scene, &rng) : 0;
    if (swapped > 0) cJSON_AddNumberToObject(draw->notes, "swapped_textures", swapped);
    if (!randomize) return;
    pbnds_materials_randomize(&d->scene, d->subjects.upright, &rng);
    cJSON_AddTrueToObject(draw->notes, "randomized_materials");
}

static enum pbnds_status draw_camera(struct pbnds_drawer *d, struct pbnds_draw *draw,
                                     struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe *r = d->recipe;
    struct pbnds_rng rng =
        pbnds_draw_rng(r, draw->split, draw->index, PBNDS_DRAW_CAMERA);
    const float aspect = (float)r->width / (float)r->height;
    struct pbnds_shot shot;
    if (!pbnds_draw_camera(&d->scene, d->accel, &d->subjects, aspect, &rng, &shot)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: no camera found that sees enough of it",
                          draw->asset->path ? draw->asset->path : draw->asset->stem);
    }
    draw->camera = shot.camera;
    cJSON_AddStringToObject(draw->notes, "shot", pbnds_shot_name(shot.kind));
    if (shot.object != UINT32_MAX)
        cJSON_AddStringToObject(draw->notes, "object",
                                d->scene.objects[shot.object].name);
    cJSON_AddNumberToObject(draw->notes, "yfov_deg",
                            (double)(shot.camera.yfov * 180.0f / PBNDS_PI));
    cJSON_AddNumberToObject(draw->notes, "roll_deg", (double)shot.roll_deg);
    cJSON_AddNumberToObject(draw->notes, "camera_attempts", shot.attempts);
    return PBNDS_OK;
}

static enum pbnds_status draw_all(struct pbnds_drawer *d, struct pbnds_draw *draw,
                                  struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe *r = d->recipe;
    struct pbnds_rng choice =
        pbnds_draw_rng(r, draw->split, draw->index, PBNDS_DRAW_ASSET);
    struct pbnds_rng lamp =
        pbnds_draw_rng(r, draw->split, draw->index, PBNDS_DRAW_LIGHT);
    draw->asset =
        pbnds_assets_pick(&d->scenes, draw->split, (double)pbnds_rng_float(&choice));
    cJSON_AddStringToObject(draw->notes, "split", pbnds_split_name(draw->split));
    cJSON_AddNumberToObject(draw->notes, "index", draw->index);
    cJSON_AddStringToObject(draw->notes, "asset", draw->asset->stem);
    PBNDS_TRY(load_scene(d, draw->asset, error));
    draw->scene = &d->scene;
    draw->accel = d->accel;
    draw_materials(d, draw);
    PBNDS_TRY(draw_camera(d, draw, error));
    return pbnds_draw_light(r, &d->envs, &lamp, draw, error);
}

enum pbnds_status pbnds_draw(struct pbnds_drawer *drawer, enum pbnds_split split,
                             int index, struct pbnds_draw *draw,
                             struct pbnds_error *error)
{
    *draw = (struct pbnds_draw){.split = split, .index = index};
    draw->notes = cJSON_CreateObject();
    const enum pbnds_status status =
        draw->notes ? draw_all(drawer, draw, error)
                    : pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a sample");
    if (status != PBNDS_OK) pbnds_draw_free(draw);
    return status;
}

void pbnds_draw_free(struct pbnds_draw *draw)
{
    pbnds_image_free(&draw->light);
    cJSON_Delete(draw->notes);
    *draw = (struct pbnds_draw){0};
}
