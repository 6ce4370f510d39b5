/* pbnds dataset: training samples from scenes and light maps. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/ranks.h"
#include "neural/data/dataset.h"
#include "neural/data/estimate.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/output.h"

/* `n` in tenths: the first split gets eight of them. */
static void share_out(int n, int counts[PBNDS_SPLIT_COUNT])
{
    counts[PBNDS_SPLIT_VAL] = counts[PBNDS_SPLIT_TEST] = n / 10;
    counts[PBNDS_SPLIT_TRAIN] = n - 2 * (n / 10);
}

static bool add_source(struct pbnds_dataset_source *to, const char *path)
{
    to->path = strdup(path);
    return to->path != NULL;
}

static enum pbnds_status copy_sources(const struct tool_options *options,
                                      struct pbnds_dataset_recipe *recipe,
                                      struct pbnds_error *error)
{
    const int scenes = options->input_count, envs = options->env_count;
    recipe->scenes = calloc((size_t)scenes + 1, sizeof *recipe->scenes);
    recipe->envs = calloc((size_t)envs + 1, sizeof *recipe->envs);
    bool ok = recipe->scenes && recipe->envs;
    for (int i = 0; i < scenes && ok; ++i)
        ok = add_source(&recipe->scenes[recipe->scene_count++], options->inputs[i]);
    for (int i = 0; i < envs && ok; ++i)
        ok = add_source(&recipe->envs[recipe->env_count++], options->envs[i]);
    return ok ? PBNDS_OK : pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory");
}

/* The recipe that the options spell out. */
static enum pbnds_status typed_recipe(const struct tool_options *options,
                                      struct pbnds_dataset_recipe *recipe,
                                      struct pbnds_error *error)
{
    const bool dark = options->env_count == 0 && options->skies == 0;
    const bool bare = options->input_count == 0 && options->worlds == 0;
    if (dark || bare || options->count == 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "dataset: %s is missing",
                          bare   ? "SCENE or --worlds N"
                          : dark ? "--envs DIR"
                                 : "--count N");
    }
    PBNDS_TRY(copy_sources(options, recipe, error));
    if (options->split >= 0) {
        recipe->count[options->split] = options->count;
        recipe->worlds[options->split] = options->worlds;
        recipe->skies[options->split] = options->skies;
    } else {
        pbnds_dataset_recipe_count(recipe, options->count);
        share_out(options->worlds, recipe->worlds);
        share_out(options->skies, recipe->skies);
    }
    if (options->size[0]) recipe->width = options->size[0];
    if (options->size[1]) recipe->height = options->size[1];
    if (options->spp) recipe->spp = options->spp;
    if (options->per_tar) recipe->per_tar = options->per_tar;
    recipe->seed = recipe->world_seed = options->seed;
    recipe->randomize_materials = options->randomize_materials;
    recipe->swap_textures = options->swap_textures;
    recipe->mix_lights = options->mix_lights;
    recipe->hard_lights = options->hard_lights;
    recipe->variance = options->variance;
    recipe->ao = options->ao;
    recipe->olat = options->olat;
    recipe->olat_spp = options->olat_spp;
    recipe->denoise = options->denoise;
    recipe->format = (enum pbnds_dataset_format)options->format;
    return PBNDS_OK;
}

/* Of what a recipe says, only the split may be narrowed on the command line. */
static enum pbnds_status file_recipe(const struct tool_options *options,
                                     struct pbnds_dataset_recipe *recipe,
                                     struct pbnds_error *error)
{
    if (options->input_count || options->env_count || options->count ||
        options->worlds || options->skies || options->size[0] || options->spp ||
        options->olat || options->seed || options->per_tar) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "dataset: --recipe says what is made; change %s and leave "
                          "the other options out",
                          options->recipe);
    }
    char root[4096];
    (void)snprintf(root, sizeof root, "%s",
                   options->root ? options->root : options->recipe);
    char *slash = options->root ? NULL : strrchr(root, '/');
    if (slash) {
        *slash = 0;
    } else if (!options->root) {
        root[0] = 0;
    }
    PBNDS_TRY(pbnds_dataset_recipe_load(options->recipe, root, recipe, error));
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        if (options->split >= 0 && s != options->split) recipe->count[s] = 0;
    }
    return PBNDS_OK;
}

static void print_cost(const struct tool_options *options,
                       const struct pbnds_dataset_cost *cost)
{
    const double hours = cost->core_seconds / 3600.0, gib = cost->bytes / 1073741824.0;
    if (options->json) {
        tool_json_result("dry run", 5, "count", (double)cost->count, "core_seconds",
                         cost->core_seconds, "core_seconds_error", cost->core_error,
                         "bytes", cost->bytes, "bytes_error", cost->bytes_error);
        return;
    }
    (void)printf("%d samples: %.3g core hours (%.3g s a sample), +-%.0f %%; %.3g GiB\n",
                 cost->count, hours, cost->core_seconds / cost->count,
                 100.0 * cost->core_error / cost->core_seconds, gib);
    if (cost->failed > 0) {
        (void)printf("%d of %d samples tried cannot be made\n", cost->failed,
                     cost->pilots);
    }
}

static enum pbnds_status dry_run(const struct tool_options *options,
                                 const struct pbnds_dataset_recipe *recipe,
                                 struct pbnds_error *error)
{
    struct pbnds_dataset_cost cost;
    const char *scratch = getenv("TMPDIR");
    PBNDS_TRY(pbnds_dataset_estimate(recipe, scratch ? scratch : "/tmp", tool_report(),
                                     &cost, error));
    print_cost(options, &cost);
    return PBNDS_OK;
}

/* What there is now, and what came of this run, over all ranks. */
static enum pbnds_status print_made(const struct tool_options *options,
                                    const struct pbnds_dataset_summary *summary,
                                    double seconds, struct pbnds_error *error)
{
    int there[PBNDS_SPLIT_COUNT];
    for (int split = 0; split < PBNDS_SPLIT_COUNT; ++split) {
        struct pbnds_sample_list list;
        PBNDS_TRY(
            pbnds_dataset_list(options->output, (enum pbnds_split)split, &list, error));
        there[split] = list.count;
        pbnds_sample_list_free(&list);
    }
    if (options->json) {
        tool_json_result(options->output, 9, "train", (double)there[PBNDS_SPLIT_TRAIN],
                         "val", (double)there[PBNDS_SPLIT_VAL], "test",
                         (double)there[PBNDS_SPLIT_TEST], "made", (double)summary->made,
                         "kept", (double)summary->kept, "quarantined",
                         (double)summary->quarantined, "busy", (double)summary->busy,
                         "seconds", seconds, "complete", (double)summary->complete);
        return PBNDS_OK;
    }
    (void)printf("%s: train %d, val %d, test %d samples", options->output,
                 there[PBNDS_SPLIT_TRAIN], there[PBNDS_SPLIT_VAL],
                 there[PBNDS_SPLIT_TEST]);
    if (summary->made > 0) {
        (void)printf("; %d made in %.1f s, %.3g a second", summary->made, seconds,
                     summary->made / seconds);
    }
    if (summary->quarantined > 0)
        (void)printf("; %d cannot be made, see quarantine/", summary->quarantined);
    if (summary->complete) {
        (void)printf("; hash %s\n", summary->hash);
    } else {
        (void)printf("; not complete yet\n");
    }
    return PBNDS_OK;
}

/* Adds up what the ranks did. */
static void sum_up(struct pbnds_dataset_summary *summary)
{
    double x[4] = {summary->made, summary->kept, summary->quarantined, summary->busy};
    pbnds_ranks_sum(x, 4);
    summary->made = (int)x[0];
    summary->kept = (int)x[1];
    summary->quarantined = (int)x[2];
    summary->busy = (int)x[3];
}

/* Every rank makes its part, waits for the others, and the first one tells. */
static enum pbnds_status make(const struct tool_options *options,
                              const struct pbnds_dataset_recipe *recipe,
                              struct pbnds_error *error)
{
    const int rank = pbnds_rank(), ranks = pbnds_rank_count();
    const struct pbnds_dataset_options how = {
        .shard = {options->shard[0] + options->shard[1] * rank,
                  options->shard[1] * ranks},
        .retry = options->retry};
    struct pbnds_dataset_summary summary = {0};
    const double start = tool_seconds();
    if (rank > 0) tool_console_no_progress();
    enum pbnds_status status = tool_folder_check(options->output, error);
    if (status == PBNDS_OK) {
        status = pbnds_dataset_make(recipe, &how, options->output, tool_report(),
                                    &summary, error);
    }
    const int worst = pbnds_ranks_max(status == PBNDS_OK ? 0 : 1);
    sum_up(&summary);
    /* The rank that came last wrote the manifest. */
    const bool complete = pbnds_ranks_max(summary.complete) != 0;
    if (status != PBNDS_OK) return status;
    if (rank > 0) return PBNDS_OK;
    if (worst != 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "%s: another process could not make its part",
                          options->output);
    }
    if (complete && !summary.complete) {
        summary.complete = true;
        PBNDS_TRY(pbnds_dataset_hash(options->output, summary.hash, error));
    }
    return print_made(options, &summary, tool_seconds() - start, error);
}

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    struct pbnds_dataset_recipe recipe;
    pbnds_dataset_recipe_init(&recipe);
    enum pbnds_status status = options->recipe ? file_recipe(options, &recipe, error)
                                               : typed_recipe(options, &recipe, error);
    if (status == PBNDS_OK && !options->output && !options->dry_run) {
        status = pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "dataset: -o is missing");
    }
    if (status == PBNDS_OK) {
        status = options->dry_run ? dry_run(options, &recipe, error)
                                  : make(options, &recipe, error);
    }
    pbnds_dataset_recipe_free(&recipe);
    return status;
}

const struct tool_command tool_dataset = {
    .name = "dataset",
    .mask = TOOL_DATASET,
    .min_inputs = 0,
    .max_inputs = -1,
    .usage = "dataset SCENE...|--recipe FILE -o DIR --envs DIR --count N [options]",
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
