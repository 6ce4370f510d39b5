/* Making a data set: the claim, then sample by sample, then the manifest. */
#include "neural/data/dataset.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/file.h"
#include "scenes/generator/generate.h"

/* So many samples in a row that cannot be written, and no other will. */
enum { FAILURES_MAX = 8 };

struct maker {
    const struct pbnds_dataset_recipe *recipe;
    const struct pbnds_dataset_options *options;
    const char *dir;
    const struct pbnds_report *report;
    struct pbnds_drawer *drawer;
    struct pbnds_store *store;
    struct pbnds_dataset_summary *sum;
    struct pbnds_error fault; /* the first that could not be written */
    int in_a_row;             /* of those, without one that could    */
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

static bool uses_generator(const struct pbnds_dataset_recipe *recipe)
{
    int made = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        made |= recipe->worlds[s] | recipe->skies[s];
    return made != 0;
}

static cJSON *claim_json(const struct maker *m, const int *count)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "version", 3);
    cJSON *counts = cJSON_AddObjectToObject(json, "count");
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        cJSON_AddNumberToObject(counts, pbnds_split_name((enum pbnds_split)s),
                                count[s]);
    pbnds_dataset_recipe_describe(m->recipe, json);
    if (uses_generator(m->recipe))
        cJSON_AddNumberToObject(json, "world_version", PBNDS_WORLD_VERSION);
    cJSON_AddItemToObject(json, "assets", assets_json(pbnds_drawer_scenes(m->drawer)));
    cJSON_AddItemToObject(json, "light_maps",
                          assets_json(pbnds_drawer_envs(m->drawer)));
    return json;
}

/* What became of one sample. */
enum outcome { MADE, QUARANTINED, FAILED };

/* The files of one sample, in a folder. A sample whose targets cannot be stored
 * (PBNDS_ERROR_FORMAT: they are not finite) is as hopeless as one that cannot be drawn. */
static enum outcome make_files(struct maker *m, struct pbnds_store_unit unit, int index,
                               const char *folder, enum pbnds_status *status,
                               struct pbnds_error *error)
{
    struct pbnds_draw draw;
    struct pbnds_targets targets = {0};
    enum outcome outcome = QUARANTINED;
    *status = pbnds_draw(m->drawer, unit.split, index, &draw, error);
    if (*status != PBNDS_OK) return outcome;
    *status = pbnds_targets_render(m->recipe, &draw, &targets, error);
    if (*status == PBNDS_OK) {
        *status = pbnds_sample_write(folder, m->recipe, &draw, &targets, error);
        outcome = *status == PBNDS_OK             ? MADE
                  : *status == PBNDS_ERROR_FORMAT ? QUARANTINED
                                                  : FAILED;
    }
    pbnds_targets_free(&targets);
    pbnds_draw_free(&draw);
    return outcome;
}

/* Makes one sample and puts it, or the reason why there is none, into the store. */
static enum outcome make_sample(struct maker *m, struct pbnds_store_unit unit,
                                int index, enum pbnds_status *status,
                                struct pbnds_error *error)
{
    const char *folder;
    *status = pbnds_store_begin(m->store, index, &folder, error);
    if (*status != PBNDS_OK) return FAILED;
    const bool sync = pbnds_file_set_sync(false); /* commit does it, once */
    enum outcome outcome = make_files(m, unit, index, folder, status, error);
    if (outcome == MADE) {
        *status = pbnds_store_commit(m->store, error);
        if (*status != PBNDS_OK) outcome = FAILED;
    }
    (void)pbnds_file_set_sync(sync);
    if (outcome == QUARANTINED && !pbnds_stop_requested()) {
        struct pbnds_error fault;
        const enum pbnds_status kept =
            pbnds_store_quarantine(m->store, error->message, &fault);
        if (kept != PBNDS_OK) {
            *error = fault;
            *status = kept;
            outcome = FAILED;
        }
    }
    if (outcome != MADE) pbnds_store_abort(m->store);
    return outcome;
}

static void note(struct maker *m, enum pbnds_status status,
                 const struct pbnds_error *reason)
{
    if (m->sum->status != PBNDS_OK) return;
    m->sum->status = status;
    (void)snprintf(m->sum->reason, sizeof m->sum->reason, "%s", reason->message);
}

/* Errors: INTERRUPTED; the one to stop at when nothing can be written. */
static enum pbnds_status failed(struct maker *m, int samples, enum pbnds_status status,
                                const struct pbnds_error *reason,
                                struct pbnds_error *error)
{
    note(m, status, reason);
    m->sum->failed += samples;
    if (!m->fault.message[0]) m->fault = *reason;
    if (++m->in_a_row < FAILURES_MAX) return PBNDS_OK;
    return pbnds_fail(error, status, "%s", reason->message);
}

/* One sample that fails is left out with its reason and the run goes on. */
static enum pbnds_status make_one(struct maker *m, struct pbnds_store_unit unit,
                                  int index, struct pbnds_error *error)
{
    const enum pbnds_store_state state = pbnds_store_state(m->store, index);
    if (state == PBNDS_STORE_THERE) {
        ++m->sum->kept;
        return PBNDS_OK;
    }
    if (state == PBNDS_STORE_QUARANTINED && !m->options->retry) {
        ++m->sum->quarantined;
        return PBNDS_OK;
    }
    struct pbnds_error reason = {{0}};
    enum pbnds_status status = PBNDS_OK;
    const enum outcome outcome = make_sample(m, unit, index, &status, &reason);
    if (outcome != MADE && pbnds_stop_requested()) return pbnds_fail_interrupted(error);
    if (outcome == MADE) {
        ++m->sum->made;
        m->in_a_row = 0;
        return PBNDS_OK;
    }
    pbnds_warn(m->report, "%s sample %d is left out: %s", pbnds_split_name(unit.split),
               index, reason.message);
    if (outcome == FAILED) return failed(m, 1, status, &reason, error);
    m->in_a_row = 0;
    note(m, status, &reason);
    ++m->sum->quarantined;
    return PBNDS_OK;
}

static enum pbnds_status make_unit(struct maker *m, int number,
                                   struct pbnds_error *error)
{
    const struct pbnds_store_unit unit = pbnds_store_unit(m->store, number);
    struct pbnds_error reason = {{0}};
    bool busy;
    const enum pbnds_status entered =
        pbnds_store_enter(m->store, number, &busy, &reason);
    if (busy) {
        m->sum->busy += unit.end - unit.first;
        return PBNDS_OK;
    }
    if (entered != PBNDS_OK) {
        pbnds_warn(m->report, "%s samples %d to %d are left out: %s",
                   pbnds_split_name(unit.split), unit.first, unit.end - 1,
                   reason.message);
        return failed(m, unit.end - unit.first, entered, &reason, error);
    }
    enum pbnds_status status = PBNDS_OK;
    for (int i = unit.first; i < unit.end && status == PBNDS_OK; ++i) {
        const struct pbnds_dataset_summary *s = m->sum;
        if (pbnds_stop_requested()) status = pbnds_fail_interrupted(error);
        pbnds_progress(m->report, "dataset",
                       s->made + s->kept + s->quarantined + s->failed + s->busy,
                       s->total);
        if (status == PBNDS_OK) status = make_one(m, unit, i, error);
    }
    const enum pbnds_status left = pbnds_store_leave(m->store, &reason);
    if (status != PBNDS_OK || left == PBNDS_OK) return status;
    /* Its samples wait for the next run, which needs no more than to pack them. */
    pbnds_warn(m->report, "%s", reason.message);
    return failed(m, 0, left, &reason, error);
}

static bool is_mine(const struct maker *m, int unit)
{
    const struct pbnds_dataset_shard *shard = &m->options->shard;
    return shard->count < 2 || unit % shard->count == shard->index;
}

static enum pbnds_status make_all(struct maker *m, struct pbnds_error *error)
{
    struct pbnds_dataset_summary *sum = m->sum;
    const int units = pbnds_store_units(m->store);
    for (int n = 0; n < units; ++n) {
        const struct pbnds_store_unit unit = pbnds_store_unit(m->store, n);
        if (is_mine(m, n)) sum->total += unit.end - unit.first;
    }
    for (int n = 0; n < units; ++n) {
        if (is_mine(m, n)) PBNDS_TRY(make_unit(m, n, error));
    }
    pbnds_progress(m->report, "dataset", sum->total, sum->total);
    if (sum->quarantined + sum->failed > 0) {
        pbnds_warn(m->report, "%s: %d samples left out", m->dir,
                   sum->quarantined + sum->failed);
    }
    if (sum->total > 0 && sum->made + sum->kept + sum->busy == 0 &&
        m->options->shard.count < 2 && sum->status != PBNDS_OK) {
        if (sum->failed == 0) pbnds_store_abandon(m->store);
        return pbnds_fail(error, sum->status, "no sample could be made; the first: %s",
                          sum->reason);
    }
    if (m->fault.message[0]) {
        return pbnds_fail(
            error, PBNDS_ERROR_IO,
            "%s: not all could be written, give the command again to have "
            "the rest; the first: %s",
            m->dir, m->fault.message);
    }
    PBNDS_TRY(pbnds_store_finish(m->store, &sum->complete, error));
    return sum->complete ? pbnds_dataset_hash(m->dir, sum->hash, error) : PBNDS_OK;
}

static enum pbnds_status open_store(struct maker *m, struct pbnds_error *error)
{
    int count[PBNDS_SPLIT_COUNT];
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        count[s] = pbnds_drawer_count(m->drawer, (enum pbnds_split)s);
    cJSON *claim = claim_json(m, count);
    const enum pbnds_status status =
        claim ? pbnds_store_open(m->dir, m->recipe, count, claim, &m->store, error)
              : pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", m->dir);
    cJSON_Delete(claim);
    return status;
}

enum pbnds_status pbnds_dataset_make(const struct pbnds_dataset_recipe *recipe,
                                     const struct pbnds_dataset_options *options,
                                     const char *dir, const struct pbnds_report *report,
                                     struct pbnds_dataset_summary *summary,
                                     struct pbnds_error *error)
{
    static const struct pbnds_dataset_options whole = {{0, 1}, false};
    struct pbnds_dataset_summary own;
    struct maker m = {.recipe = recipe,
                      .options = options ? options : &whole,
                      .dir = dir,
                      .report = report,
                      .sum = summary ? summary : &own};
    *m.sum = (struct pbnds_dataset_summary){0};
    const struct pbnds_dataset_shard *shard = &m.options->shard;
    if (shard->count < 0 || shard->index < 0 ||
        shard->index >= (shard->count > 0 ? shard->count : 1)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "a shard is I/N with I from 0 to N - 1");
    }
    PBNDS_TRY(pbnds_drawer_create(recipe, &m.drawer, error));
    enum pbnds_status status = open_store(&m, error);
    if (status == PBNDS_OK) status = make_all(&m, error);
    pbnds_store_free(m.store);
    pbnds_drawer_free(m.drawer);
    return status;
}
