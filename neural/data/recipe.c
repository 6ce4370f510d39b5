#include "neural/data/recipe.h"

#include <string.h>

const char *pbnds_split_name(enum pbnds_split split)
{
    static const char *const NAMES[] = {"train", "val", "test"};
    return split < PBNDS_SPLIT_COUNT ? NAMES[split] : "?";
}

void pbnds_dataset_recipe_init(struct pbnds_dataset_recipe *recipe)
{
    *recipe = (struct pbnds_dataset_recipe){
        .width = 256,
        .height = 256,
        .spp = 64,
        .dark_lights = 0.04,
        .per_tar = 100,
    };
}

void pbnds_dataset_recipe_count(struct pbnds_dataset_recipe *recipe, int count)
{
    const int tenth = count / 10;
    recipe->every_split = true;
    recipe->count[PBNDS_SPLIT_TRAIN] = count - 2 * tenth;
    recipe->count[PBNDS_SPLIT_VAL] = tenth;
    recipe->count[PBNDS_SPLIT_TEST] = tenth;
}

static bool is_share(double x)
{
    return x >= 0.0 && x <= 1.0;
}

enum pbnds_status pbnds_dataset_recipe_check(const struct pbnds_dataset_recipe *r,
                                             struct pbnds_error *error)
{
    int64_t total = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        if (r->count[s] < 0) total = INT64_MIN;
        total += r->count[s];
    }
    if (total < 1 || r->spp < 1 || r->width < 8 || r->height < 8 || r->per_tar < 1) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "a data set needs a count, spp and size of at least 1, 1 and "
                          "8x8");
    }
    if (r->olat < 0 || r->olat > 32 || r->olat_spp < 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "a data set has 0 to 32 lights one at a time, and samples of "
                          "at least 0 for each");
    }
    if (!is_share(r->randomize_materials) || !is_share(r->swap_textures) ||
        !is_share(r->mix_lights) || !is_share(r->hard_lights) ||
        !is_share(r->dark_lights) || !is_share(r->world_share) ||
        !is_share(r->sky_share)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "a share of samples is a number from 0 to 1");
    }
    return PBNDS_OK;
}
