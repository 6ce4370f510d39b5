/* A data set's folder: the manifest that says what it is, the samples in it. */
#include "neural/data/store.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "engine/core/file.h"

struct pbnds_store {
    char dir[3900];
    char folder[4096], temp[4096]; /* of the sample begun last */
};

/* A sample's folder with whatever a kill left in it. */
static void remove_folder(const char *folder)
{
    DIR *dir = opendir(folder);
    if (!dir) return;
    for (struct dirent *entry; (entry = readdir(dir));) {
        char path[4096 + 300];
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0) {
            (void)unlink(path);
        }
    }
    (void)closedir(dir);
    (void)rmdir(folder);
}

/* Writes the manifest, or finds that the folder already holds this very one. */
static enum pbnds_status claim(const char *dir, const cJSON *manifest,
                               struct pbnds_error *error)
{
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    char *text = cJSON_Print(manifest);
    if (!text) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", dir);
    enum pbnds_status status = PBNDS_OK;
    struct stat info;
    if (stat(path, &info) != 0) {
        status = pbnds_file_write(path, text, strlen(text), error);
    } else {
        uint8_t *old = NULL;
        size_t size = 0;
        status = pbnds_file_read(path, (size_t)1 << 26, &old, &size, error);
        if (status == PBNDS_OK &&
            (size != strlen(text) || memcmp(old, text, size) != 0)) {
            status =
                pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                           "%s: was made by another recipe; give another folder or "
                           "the same options",
                           path);
        }
        free(old);
    }
    free(text);
    return status;
}

enum pbnds_status pbnds_store_open(const char *dir,
                                   const struct pbnds_dataset_recipe *recipe,
                                   const cJSON *manifest, struct pbnds_store **store,
                                   struct pbnds_error *error)
{
    (void)recipe;
    *store = NULL;
    PBNDS_TRY(pbnds_make_folder(dir, error));
    PBNDS_TRY(claim(dir, manifest, error));
    struct pbnds_store *s = calloc(1, sizeof *s);
    if (!s) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", dir);
    if (snprintf(s->dir, sizeof s->dir, "%s", dir) >= (int)sizeof s->dir) {
        free(s);
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: is too long a name", dir);
    }
    *store = s;
    return PBNDS_OK;
}

void pbnds_store_free(struct pbnds_store *store)
{
    free(store);
}

static void name_folder(const struct pbnds_store *store, enum pbnds_split split,
                        int index, const char *prefix, char path[4096])
{
    (void)snprintf(path, 4096, "%s/%s/%s%06d", store->dir, pbnds_split_name(split),
                   prefix, index);
}

bool pbnds_store_has(const struct pbnds_store *store, enum pbnds_split split, int index)
{
    char path[4096];
    struct stat info;
    name_folder(store, split, index, "", path);
    return stat(path, &info) == 0;
}

enum pbnds_status pbnds_store_begin(struct pbnds_store *store, enum pbnds_split split,
                                    int index, const char **folder,
                                    struct pbnds_error *error)
{
    name_folder(store, split, index, "", store->folder);
    name_folder(store, split, index, ".tmp-", store->temp);
    remove_folder(store->temp);
    *folder = store->temp;
    return pbnds_make_folder(store->temp, error);
}

enum pbnds_status pbnds_store_commit(struct pbnds_store *store,
                                     struct pbnds_error *error)
{
    if (rename(store->temp, store->folder) == 0) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", store->folder,
                      strerror(errno));
}

void pbnds_store_abort(struct pbnds_store *store)
{
    remove_folder(store->temp);
}

void pbnds_store_abandon(struct pbnds_store *store)
{
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/dataset.json", store->dir);
    (void)unlink(path);
}

static int is_sample(const struct dirent *entry)
{
    return entry->d_name[0] >= '0' && entry->d_name[0] <= '9';
}

enum pbnds_status pbnds_dataset_list(const char *dir, enum pbnds_split split,
                                     struct pbnds_sample_list *list,
                                     struct pbnds_error *error)
{
    *list = (struct pbnds_sample_list){0};
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    struct stat info;
    if (stat(path, &info) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "%s: is not a data set (no dataset.json in it)", dir);
    }
    (void)snprintf(path, sizeof path, "%s/%s", dir, pbnds_split_name(split));
    if (stat(path, &info) != 0) return PBNDS_OK; /* no such split: an empty list */
    struct dirent **entries;
    const int n = scandir(path, &entries, is_sample, alphasort);
    if (n < 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be listed: %s", path,
                          strerror(errno));
    }
    list->folders = calloc((size_t)n + 1, sizeof *list->folders);
    bool ok = list->folders != NULL;
    for (int i = 0; i < n; ++i) {
        const size_t size = strlen(path) + strlen(entries[i]->d_name) + 2;
        char *folder = ok ? malloc(size) : NULL;
        if (folder) {
            (void)snprintf(folder, size, "%s/%s", path, entries[i]->d_name);
            list->folders[list->count++] = folder;
        } else {
            ok = false;
        }
        free(entries[i]);
    }
    free(entries);
    if (!ok) {
        pbnds_sample_list_free(list);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list",
                          path);
    }
    return PBNDS_OK;
}

void pbnds_sample_list_free(struct pbnds_sample_list *list)
{
    for (int i = 0; i < list->count; ++i)
        free(list->folders[i]);
    free(list->folders);
    *list = (struct pbnds_sample_list){0};
}

enum pbnds_status pbnds_dataset_hash(const char *dir, char hash[17],
                                     struct pbnds_error *error)
{
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    uint8_t *manifest;
    size_t size;
    PBNDS_TRY(pbnds_file_read(path, (size_t)1 << 26, &manifest, &size, error));
    uint64_t h = XXH64(manifest, size, 0);
    free(manifest);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        struct pbnds_sample_list list;
        PBNDS_TRY(pbnds_dataset_list(dir, (enum pbnds_split)s, &list, error));
        for (int i = 0; i < list.count; ++i) {
            const char *name = list.folders[i] + strlen(dir);
            h = XXH64(name, strlen(name), h);
        }
        pbnds_sample_list_free(&list);
    }
    (void)snprintf(hash, 17, "%016" PRIx64, h);
    return PBNDS_OK;
}
