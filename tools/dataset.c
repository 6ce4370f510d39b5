/* pbnds dataset: training samples from scenes and light maps. */
#include <stdio.h>
#include <stdlib.h>

#include "neural/data/dataset.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/output.h"

static enum pbnds_status fill_recipe(const struct tool_options *options,
                                     struct pbnds_dataset_recipe *recipe,
                                     struct pbnds_dataset_source **sources,
                                     struct pbnds_error *error)
{
    const int scenes = options->input_count, envs = options->env_count;
    *sources = calloc((size_t)scenes + (size_t)envs, sizeof **sources);
    if (!*sources) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory");
    for (int i = 0; i < scenes; ++i)
        (*sources)[i].path = (char *)(uintptr_t)options->inputs[i];
    for (int i = 0; i < envs; ++i)
        (*sources)[scenes + i].path = (char *)(uintptr_t)options->envs[i];
    recipe->scenes = *sources;
    recipe->scene_count = scenes;
    recipe->envs = *sources + scenes;
    recipe->env_count = envs;
    if (options->split >= 0) {
        recipe->count[options->split] = options->count;
    } else {
        pbnds_dataset_recipe_count(recipe, options->count);
    }
    if (options->size[0]) recipe->width = options->size[0];
    if (options->size[1]) recipe->height = options->size[1];
    if (options->spp) recipe->spp = options->spp;
    recipe->seed = options->seed;
    return PBNDS_OK;
}

static enum pbnds_status make(const struct tool_options *options,
                              const struct pbnds_dataset_recipe *recipe,
                              struct pbnds_error *error)
{
    const struct pbnds_dataset_shard shard = {options->shard[0], options->shard[1]};
    PBNDS_TRY(tool_folder_check(options->output, error));
    PBNDS_TRY(
        pbnds_dataset_make(recipe, &shard, options->output, tool_report(), error));
    int made[PBNDS_SPLIT_COUNT];
    for (int split = 0; split < PBNDS_SPLIT_COUNT; ++split) {
        struct pbnds_sample_list list;
        PBNDS_TRY(
            pbnds_dataset_list(options->output, (enum pbnds_split)split, &list, error));
        made[split] = list.count;
        pbnds_sample_list_free(&list);
    }
    if (options->json) {
        tool_json_result(options->output, 3, "train", (double)made[PBNDS_SPLIT_TRAIN],
                         "val", (double)made[PBNDS_SPLIT_VAL], "test",
                         (double)made[PBNDS_SPLIT_TEST]);
    } else {
        (void)printf("%s: train %d, val %d, test %d samples\n", options->output,
                     made[PBNDS_SPLIT_TRAIN], made[PBNDS_SPLIT_VAL],
                     made[PBNDS_SPLIT_TEST]);
    }
    return PBNDS_OK;
}

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    if (options->env_count == 0 || options->count == 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "dataset: --%s is missing",
                          options->env_count == 0 ? "envs DIR" : "count N");
    }
    struct pbnds_dataset_recipe recipe;
    pbnds_dataset_recipe_init(&recipe);
    struct pbnds_dataset_source *sources = NULL;
    PBNDS_TRY(fill_recipe(options, &recipe, &sources, error));
    const enum pbnds_status status = make(options, &recipe, error);
    free(sources);
    return status;
}

const struct tool_command tool_dataset = {
    .name = "dataset",
    .mask = TOOL_DATASET,
    .min_inputs = 1,
    .max_inputs = -1,
    .needs_output = true,
    .usage = "dataset SCENE... -o DIR --envs DIR --count N [options]",
    .about = "makes training samples from scenes and light maps",
    .details =
        "SCENE is a .gltf or .glb file or a folder searched for them. Each sample is a "
        "G-buffer,\n"
        "a light map and the path-traced radiance, from a random camera, light map, "
        "yaw and\n"
        "exposure; a pure function of the seed and its number. A scene or light map "
        "below a\n"
        "folder named train, val or test belongs to that split; the others are split "
        "by the\n"
        "hash of their names, so that test scenes and test lights are both unseen.\n"
        "A run that was stopped goes on where it was: give the same command again.\n\n"
        "  pbnds dataset scenes/ -o data/ --envs hdri/ --count 1000 --size 256x256 "
        "--seed 1",
    .run = run,
};
