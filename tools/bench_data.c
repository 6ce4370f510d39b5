#include "tools/bench_data.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/core/parallel.h"
#include "neural/data/sample.h"
#include "tools/console.h"

enum { SAMPLES = 8, SIDE = 128, SPP = 256, OLAT = 8, OLAT_SPP = 32 };

/* Seconds of all samples so far: by the clock, and in each part. */
struct cost {
    double draw, render, write, path;
};

static struct pbnds_dataset_recipe full_recipe(const struct tool_options *options)
{
    struct pbnds_dataset_recipe recipe;
    pbnds_dataset_recipe_init(&recipe);
    recipe.worlds[PBNDS_SPLIT_TRAIN] = recipe.skies[PBNDS_SPLIT_TRAIN] = SAMPLES;
    recipe.count[PBNDS_SPLIT_TRAIN] = SAMPLES;
    recipe.width = options->size[0] ? options->size[0] : SIDE;
    recipe.height = options->size[1] ? options->size[1] : SIDE;
    recipe.spp = SPP;
    recipe.seed = options->seed;
    recipe.variance = recipe.ao = true;
    recipe.olat = OLAT;
    recipe.olat_spp = OLAT_SPP;
    return recipe;
}

static enum pbnds_status make_sample(const struct pbnds_dataset_recipe *recipe,
                                     struct pbnds_drawer *drawer, int index,
                                     const char *folder, struct cost *cost,
                                     struct pbnds_error *error)
{
    struct pbnds_draw draw;
    struct pbnds_targets targets = {0};
    const double start = tool_seconds();
    PBNDS_TRY(pbnds_draw(drawer, PBNDS_SPLIT_TRAIN, index, &draw, error));
    const double drawn = tool_seconds();
    enum pbnds_status status = pbnds_targets_render(recipe, &draw, &targets, error);
    const double rendered = tool_seconds();
    if (status == PBNDS_OK)
        status = pbnds_sample_write(folder, recipe, &draw, &targets, error);
    cost->draw += drawn - start;
    cost->render += rendered - drawn;
    cost->write += tool_seconds() - rendered;
    cost->path += targets.path_seconds;
    pbnds_targets_free(&targets);
    pbnds_draw_free(&draw);
    return status;
}

static void sweep(const char *folder)
{
    for (int i = 0; pbnds_sample_file(i); ++i) {
        char path[128];
        (void)snprintf(path, sizeof path, "%s/%s", folder, pbnds_sample_file(i));
        (void)unlink(path);
    }
    (void)rmdir(folder);
}

static void print(const struct pbnds_dataset_recipe *recipe, const struct cost *cost)
{
    const double sum = cost->draw + cost->render + cost->write;
    (void)printf("stage=dataset size=%dx%d spp=%d olat=%dx%d threads=%d samples=%d "
                 "samples_per_s=%.4f path_s=%.3f draw_s=%.3f other_targets_s=%.3f "
                 "write_s=%.3f added=%.4f\n",
                 recipe->width, recipe->height, recipe->spp, recipe->olat,
                 recipe->olat_spp, pbnds_threads(), SAMPLES, SAMPLES / sum, cost->path,
                 cost->draw, cost->render - cost->path, cost->write,
                 (sum - cost->path) / cost->path);
    (void)fflush(stdout);
}

enum pbnds_status tool_bench_data(const struct tool_options *options,
                                  struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe recipe = full_recipe(options);
    struct pbnds_drawer *drawer = NULL;
    struct cost cost = {0};
    char folder[] = "pbnds-bench-XXXXXX";
    if (!mkdtemp(folder)) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "no folder can be made here; the samples are written to one "
                          "for a moment");
    }
    enum pbnds_status status = pbnds_drawer_create(&recipe, &drawer, error);
    for (int i = 0; i < SAMPLES && status == PBNDS_OK; ++i) {
        status = make_sample(&recipe, drawer, i, folder, &cost, error);
        if (status == PBNDS_OK) status = tool_check_stop(error);
    }
    pbnds_drawer_free(drawer);
    sweep(folder);
    if (status == PBNDS_OK) print(&recipe, &cost);
    return status;
}
