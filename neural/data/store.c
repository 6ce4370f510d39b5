/* Making a data set's folder: units, samples, quarantine. */
#include "neural/data/store.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "neural/data/store_index.h"
#include "neural/data/store_manifest.h"
#include "neural/data/store_pack.h"
#include "neural/data/store_path.h"

struct pbnds_store {
    char dir[PBNDS_STORE_DIR_MAX];
    bool tars;
    int per_unit;
    int count[PBNDS_SPLIT_COUNT];
    int lock; /* dataset.json, open */
    /* The unit entered: its number, -1 for none, and what its tar holds. */
    int number;
    struct pbnds_store_unit unit;
    struct pbnds_tar_index tar;
    /* The sample begun last. */
    int index;
    char temp[PBNDS_STORE_PATH_MAX];
    bool sync;    /* as pbnds_file_set_sync() had it when the store was opened */
    bool changed; /* a manifest that was there is not true any more */
};

/* ---- the claim ---- */

/* A name that must not exist: two runs that begin at once leave one file, so that both
 * lock the same. */
static enum pbnds_status write_new(const char *path, const char *text,
                                   struct pbnds_error *error)
{
    char temp[PBNDS_STORE_PATH_MAX + 64];
    const char *slash = strrchr(path, '/');
    (void)snprintf(temp, sizeof temp, "%.*s/.tmp-%ld-claim.json", (int)(slash - path),
                   path, (long)getpid());
    PBNDS_TRY(pbnds_file_write(temp, text, strlen(text), error));
    enum pbnds_status status = PBNDS_OK;
    /* A file system without links: the last one wins, whose bytes are the same. */
    if (link(temp, path) != 0 && errno != EEXIST && rename(temp, path) != 0) {
        status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                            strerror(errno));
    }
    (void)unlink(temp);
    return status;
}

/* Writes the claim, or finds that the folder already holds this very one. */
static enum pbnds_status claim_folder(const char *dir, const cJSON *claim,
                                      struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX];
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    char *text = cJSON_Print(claim);
    if (!text) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", dir);
    enum pbnds_status status = PBNDS_OK;
    if (!pbnds_store_exists(path)) status = write_new(path, text, error);
    uint8_t *old = NULL;
    size_t size = 0;
    if (status == PBNDS_OK)
        status = pbnds_file_read(path, (size_t)1 << 26, &old, &size, error);
    if (status == PBNDS_OK && (size != strlen(text) || memcmp(old, text, size) != 0)) {
        status = pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                            "%s: was made by another recipe; give another folder or "
                            "the same options",
                            path);
    }
    free(old);
    free(text);
    return status;
}

enum pbnds_status pbnds_store_open(const char *dir,
                                   const struct pbnds_dataset_recipe *recipe,
                                   const int count[PBNDS_SPLIT_COUNT],
                                   const cJSON *claim, struct pbnds_store **store,
                                   struct pbnds_error *error)
{
    *store = NULL;
    if (strlen(dir) >= PBNDS_STORE_DIR_MAX)
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: is too long a name", dir);
    PBNDS_TRY(pbnds_make_folder(dir, error));
    PBNDS_TRY(claim_folder(dir, claim, error));
    struct pbnds_store *s = calloc(1, sizeof *s);
    if (!s) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", dir);
    (void)snprintf(s->dir, sizeof s->dir, "%s", dir);
    s->tars = recipe->format == PBNDS_DATASET_TAR;
    s->per_unit = s->tars ? recipe->per_tar : 1;
    memcpy(s->count, count, sizeof s->count);
    s->number = -1;
    s->sync = pbnds_file_set_sync(true);
    (void)pbnds_file_set_sync(s->sync);
    char path[PBNDS_STORE_PATH_MAX];
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    s->lock = open(path, O_RDWR | O_CLOEXEC);
    *store = s;
    return PBNDS_OK;
}

void pbnds_store_free(struct pbnds_store *store)
{
    if (!store) return;
    pbnds_tar_index_free(&store->tar);
    if (store->lock >= 0) (void)close(store->lock);
    free(store);
}

/* ---- units ---- */

static int units_of(const struct pbnds_store *s, int split)
{
    return s->count[split] / s->per_unit + (s->count[split] % s->per_unit != 0);
}

int pbnds_store_units(const struct pbnds_store *store)
{
    int sum = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        sum += units_of(store, s);
    return sum;
}

struct pbnds_store_unit pbnds_store_unit(const struct pbnds_store *store, int number)
{
    int split = 0;
    while (split < PBNDS_SPLIT_COUNT - 1 && number >= units_of(store, split))
        number -= units_of(store, split++);
    struct pbnds_store_unit unit = {(enum pbnds_split)split, number * store->per_unit,
                                    0};
    const int left = store->count[split] - unit.first;
    unit.end = unit.first + (left < store->per_unit ? left : store->per_unit);
    return unit;
}

/* Bytes of dataset.json that stand for something: 0 for the finish, 1 + n for unit n,
 * length 0 for all from `first` on. False: another process has one of them. Where there are
 * no locks, the shards that were given keep runs apart. */
static bool lock(const struct pbnds_store *s, int first, int length, short type,
                 bool wait)
{
    struct flock range = {
        .l_type = type, .l_whence = SEEK_SET, .l_start = first, .l_len = length};
    if (s->lock < 0) return true;
    while (fcntl(s->lock, wait ? F_SETLKW : F_SETLK, &range) != 0) {
        if (errno == EINTR) continue;
        return errno != EAGAIN && errno != EACCES;
    }
    return true;
}

static void place(const struct pbnds_store *s, enum pbnds_store_place kind, int index,
                  char path[PBNDS_STORE_PATH_MAX])
{
    pbnds_store_path(s->dir, kind, s->unit.split, index, path);
}

static bool is_at(const struct pbnds_store *s, enum pbnds_store_place kind, int index)
{
    char path[PBNDS_STORE_PATH_MAX];
    place(s, kind, index, path);
    return pbnds_store_exists(path);
}

static bool in_tar(const struct pbnds_store *s, int index)
{
    char name[64];
    (void)snprintf(name, sizeof name, "%06d.sample.json", index);
    return pbnds_tar_find(&s->tar, name) != NULL;
}

static void tar_path(const struct pbnds_store *s, enum pbnds_store_place kind,
                     char path[PBNDS_STORE_PATH_MAX])
{
    place(s, kind, s->unit.first / s->per_unit, path);
}

static enum pbnds_status load_unit(struct pbnds_store *s, int number,
                                   struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX];
    s->number = number;
    s->unit = pbnds_store_unit(s, number);
    pbnds_tar_index_free(&s->tar);
    if (!s->tars) return PBNDS_OK;
    tar_path(s, PBNDS_PLACE_TAR, path);
    return pbnds_store_exists(path) ? pbnds_tar_index_read(path, &s->tar, error)
                                    : PBNDS_OK;
}

enum pbnds_store_state pbnds_store_state(const struct pbnds_store *store, int index)
{
    const bool there =
        store->tars ? in_tar(store, index) || is_at(store, PBNDS_PLACE_STAGED, index)
                    : is_at(store, PBNDS_PLACE_FOLDER, index);
    if (there) return PBNDS_STORE_THERE;
    return is_at(store, PBNDS_PLACE_QUARANTINE, index) ? PBNDS_STORE_QUARANTINED
                                                       : PBNDS_STORE_MISSING;
}

/* What a kill left in two places stays in the one where it belongs; what a power failure
 * spoilt of the samples that wait for their tar is made again. */
static void mend_unit(const struct pbnds_store *s)
{
    char path[PBNDS_STORE_PATH_MAX];
    for (int i = s->unit.first; i < s->unit.end; ++i) {
        place(s, PBNDS_PLACE_STAGED, i, path);
        if (s->tars && pbnds_store_exists(path) &&
            (in_tar(s, i) || !pbnds_sample_is_sound(path))) {
            pbnds_store_remove(path);
        }
        place(s, PBNDS_PLACE_QUARANTINE, i, path);
        if (pbnds_store_exists(path) && pbnds_store_state(s, i) == PBNDS_STORE_THERE)
            (void)unlink(path);
    }
}

enum pbnds_status pbnds_store_enter(struct pbnds_store *store, int number, bool *busy,
                                    struct pbnds_error *error)
{
    *busy = !lock(store, 1 + number, 1, F_WRLCK, false);
    if (*busy) return PBNDS_OK;
    const enum pbnds_status status = load_unit(store, number, error);
    if (status == PBNDS_OK) {
        mend_unit(store);
    } else {
        (void)lock(store, 1 + number, 1, F_UNLCK, false);
    }
    return status;
}

/* ---- samples ---- */

/* The manifest tells of a whole data set: it goes before something is made. */
static void change(struct pbnds_store *s)
{
    char path[PBNDS_STORE_PATH_MAX];
    if (s->changed) return;
    (void)snprintf(path, sizeof path, "%s/manifest.json", s->dir);
    (void)unlink(path);
    s->changed = true;
}

static enum pbnds_status make_work(const struct pbnds_store *s,
                                   struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX];
    (void)snprintf(path, sizeof path, "%s/.work", s->dir);
    return pbnds_make_folder(path, error);
}

enum pbnds_status pbnds_store_begin(struct pbnds_store *store, int index,
                                    const char **folder, struct pbnds_error *error)
{
    change(store);
    store->index = index;
    place(store, PBNDS_PLACE_TEMP, index, store->temp);
    pbnds_store_remove(store->temp);
    *folder = store->temp;
    return pbnds_make_folder(store->temp, error);
}

void pbnds_store_abort(struct pbnds_store *store)
{
    pbnds_store_remove(store->temp);
}

enum pbnds_status pbnds_store_commit(struct pbnds_store *store,
                                     struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX];
    if (!store->tars) {
        (void)snprintf(path, sizeof path, "%s/%s", store->dir,
                       pbnds_split_name(store->unit.split));
        PBNDS_TRY(pbnds_make_folder(path, error));
    }
    PBNDS_TRY(pbnds_sample_seal(store->temp, error));
    /* What waits for its tar is looked at again before it goes in. */
    if (!store->tars && store->sync)
        PBNDS_TRY(pbnds_store_sync_files(store->temp, error));
    place(store, store->tars ? PBNDS_PLACE_STAGED : PBNDS_PLACE_FOLDER, store->index,
          path);
    if (rename(store->temp, path) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                          strerror(errno));
    }
    place(store, PBNDS_PLACE_QUARANTINE, store->index, path);
    (void)unlink(path); /* tried again, with better luck */
    return PBNDS_OK;
}

enum pbnds_status pbnds_store_quarantine(struct pbnds_store *store, const char *reason,
                                         struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX];
    (void)snprintf(path, sizeof path, "%s/quarantine", store->dir);
    PBNDS_TRY(pbnds_make_folder(path, error));
    place(store, PBNDS_PLACE_QUARANTINE, store->index, path);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "split", pbnds_split_name(store->unit.split));
    cJSON_AddNumberToObject(json, "index", store->index);
    cJSON_AddStringToObject(json, "reason", reason);
    char *text = cJSON_Print(json);
    cJSON_Delete(json);
    const enum pbnds_status status =
        text ? pbnds_file_write(path, text, strlen(text), error)
             : pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    free(text);
    pbnds_store_remove(store->temp);
    return status;
}

/* ---- the end of a unit ---- */

/* Is there anything to put into the tar, and nothing left to be made? */
static bool wants_tar(const struct pbnds_store *s)
{
    bool staged = false;
    for (int i = s->unit.first; i < s->unit.end; ++i) {
        if (pbnds_store_state(s, i) == PBNDS_STORE_MISSING) return false;
        staged = staged || is_at(s, PBNDS_PLACE_STAGED, i);
    }
    return staged;
}

static enum pbnds_status write_tar(const struct pbnds_store *s, const char *old,
                                   const char *temp, struct pbnds_error *error)
{
    struct pbnds_tar_writer *writer;
    PBNDS_TRY(make_work(s, error));
    PBNDS_TRY(pbnds_tar_writer_open(temp, &writer, error));
    enum pbnds_status status = PBNDS_OK;
    for (int i = s->unit.first; i < s->unit.end && status == PBNDS_OK; ++i) {
        char staged[PBNDS_STORE_PATH_MAX];
        place(s, PBNDS_PLACE_STAGED, i, staged);
        if (pbnds_store_exists(staged)) {
            status = pbnds_pack_folder(writer, staged, i, error);
        } else {
            status = pbnds_pack_members(writer, old, &s->tar, i, error);
        }
    }
    if (status == PBNDS_OK) return pbnds_tar_writer_close(writer, s->sync, error);
    pbnds_tar_writer_abort(writer);
    return status;
}

static enum pbnds_status pack_unit(struct pbnds_store *s, struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX], temp[PBNDS_STORE_PATH_MAX];
    tar_path(s, PBNDS_PLACE_TAR, path);
    tar_path(s, PBNDS_PLACE_TAR_TEMP, temp);
    change(s);
    enum pbnds_status status = write_tar(s, path, temp, error);
    if (status == PBNDS_OK && rename(temp, path) != 0) {
        status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                            strerror(errno));
    }
    if (status != PBNDS_OK) {
        (void)unlink(temp);
        return status;
    }
    if (s->sync) pbnds_store_sync(s->dir);
    for (int i = s->unit.first; i < s->unit.end; ++i) {
        char staged[PBNDS_STORE_PATH_MAX];
        place(s, PBNDS_PLACE_STAGED, i, staged);
        pbnds_store_remove(staged);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_store_leave(struct pbnds_store *store,
                                    struct pbnds_error *error)
{
    enum pbnds_status status = PBNDS_OK;
    if (store->tars && wants_tar(store)) status = pack_unit(store, error);
    (void)lock(store, 1 + store->number, 1, F_UNLCK, false);
    pbnds_tar_index_free(&store->tar);
    store->number = -1;
    return status;
}

/* ---- the end of all ---- */

/* For pbnds_store_read(): the way to its sample.json. */
static void sample_path(const struct pbnds_store *s, int index,
                        char path[PBNDS_STORE_PATH_MAX])
{
    char tar[PBNDS_STORE_PATH_MAX], name[64];
    place(s, PBNDS_PLACE_FOLDER, index, path);
    if (!s->tars) return;
    (void)snprintf(name, sizeof name, "%06d.sample.json", index);
    const struct pbnds_tar_member *member = pbnds_tar_find(&s->tar, name);
    tar_path(s, PBNDS_PLACE_TAR, tar);
    (void)snprintf(path, PBNDS_STORE_PATH_MAX, "%.*s#%06d@%" PRIu64,
                   PBNDS_STORE_PATH_MAX - 64, tar, index, member ? member->header : 0);
}

static enum pbnds_status add_unit(struct pbnds_store *s, int number,
                                  struct pbnds_manifest *manifest, bool *complete,
                                  struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX];
    PBNDS_TRY(load_unit(s, number, error));
    for (int i = s->unit.first; i < s->unit.end; ++i) {
        const enum pbnds_store_state state = pbnds_store_state(s, i);
        if (state == PBNDS_STORE_MISSING || (s->tars && state == PBNDS_STORE_THERE &&
                                             is_at(s, PBNDS_PLACE_STAGED, i))) {
            *complete = false;
            return PBNDS_OK;
        }
        if (state == PBNDS_STORE_QUARANTINED) {
            place(s, PBNDS_PLACE_QUARANTINE, i, path);
            PBNDS_TRY(pbnds_manifest_quarantined(manifest, path, error));
            continue;
        }
        sample_path(s, i, path);
        PBNDS_TRY(pbnds_manifest_sample(manifest, s->unit.split, i, path, error));
    }
    return PBNDS_OK;
}

static void sweep(const struct pbnds_store *s)
{
    char path[PBNDS_STORE_PATH_MAX];
    (void)snprintf(path, sizeof path, "%s/.work", s->dir);
    pbnds_store_remove(path);
    (void)snprintf(path, sizeof path, "%s/quarantine", s->dir);
    pbnds_store_sweep(path);
    (void)rmdir(path); /* where it is empty */
    pbnds_store_sweep(s->dir);
}

/* Under the lock. */
static enum pbnds_status finish(struct pbnds_store *s, struct pbnds_manifest *manifest,
                                bool *complete, struct pbnds_error *error)
{
    enum pbnds_status status = PBNDS_OK;
    const int units = pbnds_store_units(s);
    *complete = true;
    for (int n = 0; n < units && status == PBNDS_OK && *complete; ++n)
        status = add_unit(s, n, manifest, complete, error);
    pbnds_tar_index_free(&s->tar);
    if (status != PBNDS_OK || !*complete) return status;
    sweep(s);
    return pbnds_manifest_write(manifest, s->dir, error);
}

enum pbnds_status pbnds_store_finish(struct pbnds_store *store, bool *complete,
                                     struct pbnds_error *error)
{
    /* Reads dataset.json, and to close any descriptor of it drops every lock. */
    struct pbnds_manifest *manifest;
    *complete = false;
    PBNDS_TRY(pbnds_manifest_begin(store->dir, &manifest, error));
    enum pbnds_status status = PBNDS_OK;
    /* One process at a time, and none at work: it sweeps what others would be writing. The
     * last one to leave its last unit finds nobody. */
    (void)lock(store, 0, 1, F_WRLCK, true);
    if (lock(store, 1, 0, F_WRLCK, false)) {
        status = finish(store, manifest, complete, error);
        (void)lock(store, 1, 0, F_UNLCK, false);
    }
    (void)lock(store, 0, 1, F_UNLCK, false);
    pbnds_manifest_free(manifest);
    return status;
}

void pbnds_store_abandon(struct pbnds_store *store)
{
    static const char *const NAMES[] = {"quarantine", ".work", "manifest.json",
                                        "dataset.json"};
    for (int i = 0; i < 4; ++i) {
        char path[PBNDS_STORE_PATH_MAX];
        (void)snprintf(path, sizeof path, "%s/%s", store->dir, NAMES[i]);
        pbnds_store_remove(path);
    }
}
