/* Making a data set: the manifest, then sample by sample. */
#include "neural/data/dataset.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "scenes/generator/generate.h"

struct maker {
    const struct pbnds_dataset_recipe *recipe;
    const char *dir;
    const struct pbnds_report *report;
    struct pbnds_drawer *drawer;
    struct pbnds_store *store;
    /* Files of the data set are being written: its errors are not an asset's. */
    bool writing;
};

static cJSON *assets_json(const struct pbnds_asset_list *list)
{
    cJSON *array = cJSON_CreateArray();
    for (int i = 0; i < list->count; ++i) {
        if (!list->items[i].path) continue; /* procedural: their number says it */
        cJSON *item = cJSON_CreateObject();
        char hash[24];
        (void)snprintf(hash, sizeof hash, "%016" PRIx64, list->items[i].hash);
        cJSON_AddStringToObject(item, "name", list->items[i].stem);
        cJSON_AddStringToObject(item, "split", pbnds_split_name(list->items[i].split));
        cJSON_AddStringToObject(item, "xxh64", hash);
        cJSON_AddItemToArray(array, item);
    }
    return array;
}

static void add_counts(cJSON *json, const char *name, const int *counts)
{
    cJSON *object = cJSON_AddObjectToObject(json, name);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        cJSON_AddNumberToObject(object, pbnds_split_name((enum pbnds_split)s),
                                counts[s]);
}

static bool uses_generator(const struct pbnds_dataset_recipe *recipe)
{
    int made = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        made |= recipe->worlds[s] | recipe->skies[s];
    return made != 0;
}

static cJSON *manifest_json(const struct maker *m)
{
    const struct pbnds_dataset_recipe *r = m->recipe;
    int count[PBNDS_SPLIT_COUNT];
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        count[s] = pbnds_drawer_count(m->drawer, (enum pbnds_split)s);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "format", 2);
    add_counts(json, "count", count);
    add_counts(json, "worlds", r->worlds);
    add_counts(json, "skies", r->skies);
    if (uses_generator(r))
        cJSON_AddNumberToObject(json, "world_version", PBNDS_WORLD_VERSION);
    cJSON_AddNumberToObject(json, "width", r->width);
    cJSON_AddNumberToObject(json, "height", r->height);
    cJSON_AddNumberToObject(json, "spp", r->spp);
    cJSON_AddNumberToObject(json, "seed", (double)r->seed);
    cJSON_AddItemToObject(json, "assets", assets_json(pbnds_drawer_scenes(m->drawer)));
    cJSON_AddItemToObject(json, "lights", assets_json(pbnds_drawer_envs(m->drawer)));
    return json;
}

/* Makes one sample and puts it into the store. */
static enum pbnds_status make_sample(struct maker *m, enum pbnds_split split, int index,
                                     struct pbnds_error *error)
{
    const char *folder;
    m->writing = true;
    PBNDS_TRY(pbnds_store_begin(m->store, split, index, &folder, error));
    m->writing = false;
    struct pbnds_draw draw;
    struct pbnds_targets targets = {0};
    enum pbnds_status status = pbnds_draw(m->drawer, split, index, &draw, error);
    if (status == PBNDS_OK) {
        status = pbnds_targets_render(m->recipe, &draw, &targets, error);
        if (status == PBNDS_OK) {
            m->writing = true;
            status = pbnds_sample_write(folder, m->recipe, &draw, &targets, error);
        }
        pbnds_targets_free(&targets);
        pbnds_draw_free(&draw);
    }
    if (status == PBNDS_OK) status = pbnds_store_commit(m->store, error);
    if (status != PBNDS_OK) pbnds_store_abort(m->store);
    return status;
}

/* What came of the samples so far. */
struct tally {
    int done, total, there, skipped;
    struct pbnds_error first; /* why the first one was left out */
    enum pbnds_status first_status;
};

/* One sample that fails is left out with its reason and the run goes on, unless the data
 * set itself cannot be written (a full disk). */
static enum pbnds_status make_one(struct maker *m, enum pbnds_split split, int index,
                                  struct tally *tally, struct pbnds_error *error)
{
    struct pbnds_error reason = {{0}};
    m->writing = false;
    const enum pbnds_status made = pbnds_store_has(m->store, split, index)
                                       ? PBNDS_OK
                                       : make_sample(m, split, index, &reason);
    if (pbnds_stop_requested()) return pbnds_fail_interrupted(error);
    if (made == PBNDS_OK) {
        ++tally->there;
        return PBNDS_OK;
    }
    if (made == PBNDS_ERROR_IO && m->writing) {
        if (error) *error = reason;
        return made;
    }
    pbnds_warn(m->report, "%s sample %d is left out: %s", pbnds_split_name(split),
               index, reason.message);
    if (++tally->skipped == 1) {
        tally->first = reason;
        tally->first_status = made;
    }
    return PBNDS_OK;
}

static enum pbnds_status make_all(struct maker *m,
                                  const struct pbnds_dataset_shard *shard,
                                  struct pbnds_error *error)
{
    struct tally tally = {0};
    int number = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        tally.total += pbnds_drawer_count(m->drawer, (enum pbnds_split)s);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        const enum pbnds_split split = (enum pbnds_split)s;
        const int count = pbnds_drawer_count(m->drawer, split);
        for (int i = 0; i < count; ++i, ++number) {
            if (number % shard->count != shard->index) continue;
            pbnds_progress(m->report, "dataset", number, tally.total);
            PBNDS_TRY(make_one(m, split, i, &tally, error));
        }
    }
    pbnds_progress(m->report, "dataset", tally.total, tally.total);
    if (tally.skipped > 0)
        pbnds_warn(m->report, "%s: %d samples left out", m->dir, tally.skipped);
    if (tally.skipped > 0 && tally.there == 0) {
        pbnds_store_abandon(m->store);
        return pbnds_fail(error, tally.first_status,
                          "no sample could be made; the first: %s",
                          tally.first.message);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_dataset_make(const struct pbnds_dataset_recipe *recipe,
                                     const struct pbnds_dataset_shard *shard,
                                     const char *dir, const struct pbnds_report *report,
                                     struct pbnds_error *error)
{
    const struct pbnds_dataset_shard whole = {0, 1};
    if (!shard) shard = &whole;
    if (shard->count < 1 || shard->index < 0 || shard->index >= shard->count) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "a shard is I/N with I from 0 to N - 1");
    }
    struct maker m = {.recipe = recipe, .dir = dir, .report = report};
    PBNDS_TRY(pbnds_drawer_create(recipe, &m.drawer, error));
    cJSON *manifest = manifest_json(&m);
    enum pbnds_status status =
        manifest ? pbnds_store_open(dir, recipe, manifest, &m.store, error)
                 : pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", dir);
    cJSON_Delete(manifest);
    if (status == PBNDS_OK) status = make_all(&m, shard, error);
    pbnds_store_free(m.store);
    pbnds_drawer_free(m.drawer);
    return status;
}
