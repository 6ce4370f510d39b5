/* pbnds dataset: training samples from scenes and light maps. */
#include <stdio.h>

#include "neural/data/dataset.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/output.h"

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    if (options->env_count == 0 || options->count == 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "dataset: --%s is missing",
                          options->env_count == 0 ? "envs DIR" : "count N");
    }
    const struct pbnds_dataset_recipe recipe = {
        .scenes = options->inputs,
        .scene_count = options->input_count,
        .envs = options->envs,
        .env_count = options->env_count,
        .count = options->count,
        .only_split = options->split,
        .width = options->size[0] ? options->size[0] : 256,
        .height = options->size[1] ? options->size[1] : 256,
        .spp = options->spp ? options->spp : 64,
        .seed = options->seed,
        .shard = options->shard[0],
        .shard_count = options->shard[1],
    };
    PBNDS_TRY(tool_folder_check(options->output, error));
    PBNDS_TRY(pbnds_dataset_make(&recipe, options->output, tool_report(), error));
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
