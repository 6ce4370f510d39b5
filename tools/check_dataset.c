#include "tools/check_dataset.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/shade/gbuffer_check.h"
#include "neural/data/dataset.h"
#include "neural/data/store_manifest.h"
#include "neural/data/store_read.h"
#include "tools/console.h"
#include "tools/output.h"

enum { FAULTS_SHOWN = 50, SENTENCE = 700 };

/* A scene or light map that a sample was made of. */
struct use {
    char *name;
    bool light;
    enum pbnds_split split;
};

struct checker {
    const char *dir;
    char *faults[FAULTS_SHOWN];
    int fault_count;
    struct use *uses;
    size_t use_count, use_capacity;
    int samples, quarantined, done;
    struct pbnds_findings *findings; /* of one G-buffer */
    cJSON *claim, *manifest;         /* NULL: there is none */
};

static void fault(struct checker *c, const char *format, ...) PBNDS_PRINTF(2, 3);

static void fault(struct checker *c, const char *format, ...)
{
    if (c->fault_count++ >= FAULTS_SHOWN) return;
    char *text = malloc(SENTENCE);
    if (!text) return;
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, SENTENCE, format, arguments);
    va_end(arguments);
    pbnds_plain_text(text);
    c->faults[c->fault_count - 1] = text;
}

/* ---- the whole ---- */

static const char *text_of(const cJSON *object, const char *key)
{
    const char *text =
        cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, key));
    return text ? text : "";
}

static int number_of(const cJSON *object, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    return cJSON_IsNumber(item) ? item->valueint : -1;
}

/* -1: none of the three. */
static int split_of(const cJSON *object)
{
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        if (strcmp(text_of(object, "split"), pbnds_split_name((enum pbnds_split)s)) ==
            0)
            return s;
    }
    return -1;
}

static enum pbnds_status read_claim(struct checker *c, struct pbnds_error *error)
{
    struct pbnds_store_bytes bytes;
    char hash[17];
    PBNDS_TRY(pbnds_store_read(c->dir, "dataset.json", &bytes, error));
    pbnds_store_hash(bytes.data, bytes.size, hash);
    c->claim = cJSON_ParseWithLength((const char *)bytes.data, bytes.size);
    free(bytes.data);
    if (!c->claim) fault(c, "%s: is not JSON", bytes.name);
    if (c->manifest && strcmp(text_of(c->manifest, "dataset"), hash) != 0)
        fault(c, "%s: was changed: the manifest was written for another one",
              bytes.name);
    return PBNDS_OK;
}

static enum pbnds_status read_manifest(struct checker *c)
{
    struct pbnds_error reason = {{0}};
    if (!pbnds_store_holds(c->dir, "manifest.json")) {
        fault(c,
              "%s/manifest.json: is not there: the data set was not finished; give the "
              "command that makes it again",
              c->dir);
    } else if (pbnds_manifest_read(c->dir, &c->manifest, &reason) != PBNDS_OK) {
        fault(c, "%s", reason.message);
    }
    return PBNDS_OK;
}

/* A list of dataset.json: the same bytes or name in two splits. */
static void check_assets(struct checker *c, const char *key)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(c->claim, key), *a;
    cJSON_ArrayForEach(a, list)
    {
        for (const cJSON *b = a->next; b; b = b->next) {
            if (strcmp(text_of(a, "split"), text_of(b, "split")) != 0 &&
                (strcmp(text_of(a, "xxh64"), text_of(b, "xxh64")) == 0 ||
                 strcmp(text_of(a, "name"), text_of(b, "name")) == 0)) {
                fault(c, "%s/dataset.json: %s of %s is %s of %s", c->dir,
                      text_of(a, "name"), text_of(a, "split"), text_of(b, "name"),
                      text_of(b, "split"));
            }
        }
    }
}

/* ---- one sample ---- */

static bool add_use(struct checker *c, const char *name, bool light,
                    enum pbnds_split split)
{
    if (c->use_count == c->use_capacity) {
        const size_t capacity = c->use_capacity ? 2 * c->use_capacity : 256;
        struct use *grown = realloc(c->uses, capacity * sizeof *grown);
        if (!grown) return false;
        c->uses = grown;
        c->use_capacity = capacity;
    }
    c->uses[c->use_count] = (struct use){strdup(name), light, split};
    if (!c->uses[c->use_count].name) return false;
    ++c->use_count;
    return true;
}

/* "asset" and "light", wherever they stand: a mixed light has its own object. */
static bool add_uses(struct checker *c, const cJSON *json, enum pbnds_split split)
{
    for (const cJSON *at = json ? json->child : NULL; at; at = at->next) {
        const bool light = at->string && strcmp(at->string, "light") == 0;
        const bool asset = at->string && strcmp(at->string, "asset") == 0;
        if (cJSON_IsString(at) && (light || asset) &&
            !add_use(c, at->valuestring, light, split))
            return false;
        if (cJSON_IsObject(at) && !add_uses(c, at, split)) return false;
    }
    return true;
}

/* Channels that are light: finite, and not below zero. Those of the G-buffer's contract
 * have rules of their own. */
static bool is_light(const char *channel)
{
    static const char *const PREFIXES[] = {"direct.", "indirect.", "variance.", "olat.",
                                           NULL};
    if (strcmp(channel, "R") == 0 || strcmp(channel, "G") == 0 ||
        strcmp(channel, "B") == 0)
        return true;
    for (int i = 0; PREFIXES[i]; ++i) {
        if (strncmp(channel, PREFIXES[i], strlen(PREFIXES[i])) == 0) return true;
    }
    return false;
}

static void check_light(struct checker *c, const char *name,
                        const struct pbnds_exr *exr)
{
    const size_t pixels = (size_t)exr->width * (size_t)exr->height;
    for (int k = 0; k < exr->channel_count; ++k) {
        const struct pbnds_exr_channel *channel = &exr->channels[k];
        const float *plane = channel->data;
        if (channel->type == PBNDS_EXR_UINT || !is_light(channel->name)) continue;
        size_t i = 0;
        while (i < pixels && isfinite(plane[i]) && plane[i] >= 0.0f)
            ++i;
        if (i == pixels) continue;
        fault(c, "%s: %s is %g at pixel (%d, %d); light is finite and not negative",
              name, channel->name, (double)plane[i], (int)(i % (size_t)exr->width),
              (int)(i / (size_t)exr->width));
    }
}

static void check_gbuffer(struct checker *c, const char *name,
                          const struct pbnds_exr *exr)
{
    pbnds_gbuffer_check(exr, name, c->findings);
    for (int i = 0; i < c->findings->count; ++i) {
        const struct pbnds_finding *f = &c->findings->items[i];
        if (!f->fault) continue;
        if (f->x < 0) {
            fault(c, "%s: %s: %s", name, f->channel, f->wants);
        } else {
            fault(c, "%s: %s is %g at pixel (%d, %d): %s", name, f->channel, f->value,
                  f->x, f->y, f->wants);
        }
    }
}

static void check_image(struct checker *c, const char *file,
                        const struct pbnds_store_bytes *bytes)
{
    struct pbnds_exr exr;
    struct pbnds_error reason = {{0}};
    if (pbnds_exr_read_memory(bytes->name, bytes->data, bytes->size, &exr, &reason) !=
        PBNDS_OK) {
        fault(c, "%s", reason.message);
        return;
    }
    if (strcmp(file, "sample.exr") == 0) {
        check_gbuffer(c, bytes->name, &exr);
        if (!pbnds_exr_find(&exr, "R"))
            fault(c, "%s: has no reference radiance (R, G, B)", bytes->name);
    }
    check_light(c, bytes->name, &exr);
    pbnds_exr_free(&exr);
}

static bool check_notes(struct checker *c, const struct pbnds_store_bytes *bytes,
                        enum pbnds_split split)
{
    cJSON *json = cJSON_ParseWithLength((const char *)bytes->data, bytes->size);
    bool ok = true;
    if (!cJSON_IsObject(json)) {
        fault(c, "%s: is not JSON", bytes->name);
    } else {
        if (split_of(json) != (int)split)
            fault(c, "%s: says that it is of split %s", bytes->name,
                  text_of(json, "split"));
        ok = add_uses(c, json, split);
    }
    cJSON_Delete(json);
    return ok;
}

/* `files`: what the manifest says, or NULL. */
static void check_hash(struct checker *c, const cJSON *files, const char *file,
                       const struct pbnds_store_bytes *bytes)
{
    char hash[17];
    const cJSON *said = cJSON_GetObjectItemCaseSensitive(files, file);
    if (!files) return;
    if (!said) {
        fault(c, "%s: is not in the manifest", bytes->name);
        return;
    }
    pbnds_store_hash(bytes->data, bytes->size, hash);
    if (strcmp(text_of(said, "xxh64"), hash) != 0)
        fault(c, "%s: is not what it was when it was made (%zu bytes, xxh64 %s)",
              bytes->name, bytes->size, hash);
}

static enum pbnds_status check_sample(struct checker *c, const char *path,
                                      enum pbnds_split split, const cJSON *files,
                                      struct pbnds_error *error)
{
    struct pbnds_store_names names;
    struct pbnds_error reason = {{0}};
    ++c->samples;
    if (pbnds_store_files(path, &names, &reason) != PBNDS_OK) {
        fault(c, "%s", reason.message);
        return PBNDS_OK;
    }
    bool ok = true;
    for (int i = 0; i < names.count && ok; ++i) {
        const char *file = names.items[i], *dot = strrchr(file, '.');
        struct pbnds_store_bytes bytes;
        if (pbnds_store_read(path, file, &bytes, &reason) != PBNDS_OK) {
            fault(c, "%s", reason.message);
            continue;
        }
        check_hash(c, files, file, &bytes);
        if (dot && strcmp(dot, ".exr") == 0) check_image(c, file, &bytes);
        if (strcmp(file, "sample.json") == 0) ok = check_notes(c, &bytes, split);
        free(bytes.data);
    }
    const cJSON *said;
    cJSON_ArrayForEach(said, files)
    {
        bool there = false;
        for (int i = 0; i < names.count; ++i)
            there = there || strcmp(names.items[i], said->string) == 0;
        if (!there) fault(c, "%s: lacks its %s", path, said->string);
    }
    pbnds_store_names_free(&names);
    return ok ? PBNDS_OK : pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
}

/* ---- the samples of a split ---- */

/* The number in .../000012, TAR#000012@OFFSET or .work/train-000012. */
static int index_of(const char *path)
{
    const char *at = path + strlen(path);
    const char *mark = strrchr(path, '#');
    const char *slash = strrchr(path, '/');
    if (mark && (!slash || mark > slash)) {
        at = mark + 1;
    } else {
        while (at > path && at[-1] >= '0' && at[-1] <= '9')
            --at;
    }
    return (int)strtol(at, NULL, 10);
}

/* Entries of both lists are in order: the next of a split, from `at` on. */
static const cJSON *of_split(const cJSON *at, int split)
{
    while (at && split_of(at) != split)
        at = at->next;
    return at;
}

static const cJSON *entries(const struct checker *c, const char *key, int split)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(c->manifest, key);
    return of_split(list ? list->child : NULL, split);
}

/* What dataset.json counts, and the manifest does not have. */
static void check_count(struct checker *c, int split)
{
    const char *name = pbnds_split_name((enum pbnds_split)split);
    const int count =
        number_of(cJSON_GetObjectItemCaseSensitive(c->claim, "count"), name);
    const cJSON *made = entries(c, "samples", split);
    const cJSON *lost = entries(c, "quarantined", split);
    for (int i = 0; c->manifest && i < count; ++i) {
        const bool has = made && number_of(made, "index") == i;
        const bool knows = lost && number_of(lost, "index") == i;
        if (has) made = of_split(made->next, split);
        if (knows) {
            lost = of_split(lost->next, split);
            ++c->quarantined;
        }
        if (!has && !knows)
            fault(c, "%s/manifest.json: knows nothing of sample %d of %s", c->dir, i,
                  name);
    }
}

static enum pbnds_status check_list(struct checker *c, int split,
                                    const struct pbnds_sample_list *list, int total,
                                    struct pbnds_error *error)
{
    const char *name = pbnds_split_name((enum pbnds_split)split);
    const cJSON *entry = entries(c, "samples", split);
    for (int i = 0; i < list->count; ++i) {
        const int index = index_of(list->folders[i]);
        while (entry && number_of(entry, "index") < index) {
            fault(c, "%s: sample %d of %s is missing", c->dir,
                  number_of(entry, "index"), name);
            entry = of_split(entry->next, split);
        }
        const bool known = entry && number_of(entry, "index") == index;
        if (c->manifest && !known)
            fault(c, "%s: is not in the manifest", list->folders[i]);
        const cJSON *files =
            known ? cJSON_GetObjectItemCaseSensitive(entry, "files") : NULL;
        PBNDS_TRY(
            check_sample(c, list->folders[i], (enum pbnds_split)split, files, error));
        PBNDS_TRY(tool_check_stop(error));
        pbnds_progress(tool_report(), "check", ++c->done, total);
        if (known) entry = of_split(entry->next, split);
    }
    for (; entry; entry = of_split(entry->next, split))
        fault(c, "%s: sample %d of %s is missing", c->dir, number_of(entry, "index"),
              name);
    return PBNDS_OK;
}

static enum pbnds_status check_samples(struct checker *c, struct pbnds_error *error)
{
    struct pbnds_sample_list lists[PBNDS_SPLIT_COUNT] = {{0}};
    bool listed[PBNDS_SPLIT_COUNT] = {false};
    enum pbnds_status status = PBNDS_OK;
    int total = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT && status == PBNDS_OK; ++s) {
        struct pbnds_error reason = {{0}};
        status = pbnds_dataset_list(c->dir, (enum pbnds_split)s, &lists[s], &reason);
        if (status == PBNDS_ERROR_FORMAT) {
            fault(c, "%s", reason.message);
            status = PBNDS_OK;
        } else if (status != PBNDS_OK && error) {
            *error = reason;
        }
        listed[s] = lists[s].folders != NULL;
        total += lists[s].count;
    }
    for (int s = 0; s < PBNDS_SPLIT_COUNT && status == PBNDS_OK; ++s) {
        check_count(c, s);
        if (listed[s]) status = check_list(c, s, &lists[s], total, error);
    }
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        pbnds_sample_list_free(&lists[s]);
    return status;
}

static int by_name(const void *a, const void *b)
{
    const struct use *x = a, *y = b;
    if (x->light != y->light) return x->light ? 1 : -1;
    const int order = strcmp(x->name, y->name);
    return order ? order : (int)x->split - (int)y->split;
}

/* What samples say that they were made of. */
static void check_uses(struct checker *c)
{
    if (c->use_count > 1) qsort(c->uses, c->use_count, sizeof *c->uses, by_name);
    for (size_t i = 1; i < c->use_count; ++i) {
        const struct use *a = &c->uses[i - 1], *b = &c->uses[i];
        if (a->light != b->light || a->split == b->split ||
            strcmp(a->name, b->name) != 0)
            continue;
        fault(c, "%s: %s %s is in samples of %s and of %s", c->dir,
              a->light ? "light" : "asset", a->name, pbnds_split_name(a->split),
              pbnds_split_name(b->split));
    }
}

/* ---- what is said ---- */

static void print_text(const struct checker *c)
{
    (void)printf("%s: data set, %s: %d samples, %d in quarantine", c->dir,
                 c->fault_count ? "not sound" : "sound", c->samples, c->quarantined);
    if (c->fault_count > 0)
        (void)printf(", %d fault%s", c->fault_count, c->fault_count == 1 ? "" : "s");
    (void)printf("\n");
    for (int i = 0; i < FAULTS_SHOWN && i < c->fault_count; ++i)
        (void)printf("  %s\n", c->faults[i] ? c->faults[i] : "?");
    if (c->fault_count > FAULTS_SHOWN)
        (void)printf("  and %d more that are not listed\n",
                     c->fault_count - FAULTS_SHOWN);
}

static void print_json(const struct checker *c)
{
    (void)printf("{\"output\": ");
    tool_json_string(stdout, c->dir);
    (void)printf(", \"sound\": %d, \"samples\": %d, \"quarantined\": %d, \"faults\": "
                 "%d, \"findings\": [",
                 c->fault_count == 0, c->samples, c->quarantined, c->fault_count);
    for (int i = 0; i < FAULTS_SHOWN && i < c->fault_count; ++i) {
        if (i > 0) (void)printf(", ");
        tool_json_string(stdout, c->faults[i] ? c->faults[i] : "?");
    }
    (void)printf("]}\n");
}

static enum pbnds_status check(struct checker *c, struct pbnds_error *error)
{
    PBNDS_TRY(read_manifest(c));
    PBNDS_TRY(read_claim(c, error));
    check_assets(c, "assets");
    check_assets(c, "light_maps");
    PBNDS_TRY(check_samples(c, error));
    check_uses(c);
    return PBNDS_OK;
}

enum pbnds_status tool_check_dataset(const char *dir, bool json,
                                     struct pbnds_error *error)
{
    struct checker c = {.dir = dir, .findings = malloc(sizeof *c.findings)};
    enum pbnds_status status =
        c.findings ? check(&c, error)
                   : pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", dir);
    tool_console_clear();
    if (status == PBNDS_OK && json) print_json(&c);
    if (status == PBNDS_OK && !json) print_text(&c);
    if (status == PBNDS_OK && c.fault_count > 0) {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT,
                            "%s: not a sound data set: %d fault%s, the first: %s", dir,
                            c.fault_count, c.fault_count == 1 ? "" : "s",
                            c.faults[0] ? c.faults[0] : "?");
    }
    for (int i = 0; i < FAULTS_SHOWN; ++i)
        free(c.faults[i]);
    for (size_t i = 0; i < c.use_count; ++i)
        free(c.uses[i].name);
    free(c.uses);
    free(c.findings);
    cJSON_Delete(c.claim);
    cJSON_Delete(c.manifest);
    return status;
}
