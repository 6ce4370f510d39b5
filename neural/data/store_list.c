/* A data set's folder, read: what is there. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "engine/core/file.h"
#include "neural/data/store.h"
#include "neural/data/store_index.h"
#include "neural/data/store_path.h"

struct found {
    long index;
    char *path; /* owned */
};

struct finding {
    struct found *items;
    size_t count, capacity;
    enum pbnds_split split;
};

/* NNNNNN, all digits: a sample's index, -1 for another name. `end` is what follows. */
static long parse_index(const char *name, const char **end)
{
    size_t length = 0;
    while (name[length] >= '0' && name[length] <= '9')
        ++length;
    *end = name + length;
    return length >= 6 && length <= 9 ? strtol(name, NULL, 10) : -1;
}

static enum pbnds_status add(struct finding *f, long index, const char *path,
                             struct pbnds_error *error)
{
    if (f->count == f->capacity) {
        const size_t capacity = f->capacity ? 2 * f->capacity : 64;
        struct found *grown = realloc(f->items, capacity * sizeof *grown);
        if (!grown) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
        f->items = grown;
        f->capacity = capacity;
    }
    f->items[f->count] = (struct found){index, strdup(path)};
    if (!f->items[f->count].path)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    ++f->count;
    return PBNDS_OK;
}

/* The samples of one tar: a path leads to the first member of its sample. */
static enum pbnds_status add_tar(struct finding *f, const char *tar,
                                 struct pbnds_error *error)
{
    struct pbnds_tar_index index;
    PBNDS_TRY(pbnds_tar_index_read(tar, &index, error));
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < index.count && status == PBNDS_OK; ++i) {
        const char *end;
        const long number = parse_index(index.members[i].name, &end);
        if (number < 0 || strcmp(end, ".sample.json") != 0) continue;
        char key[32], path[PBNDS_STORE_PATH_MAX + 400];
        int count;
        (void)snprintf(key, sizeof key, "%.*s", (int)(end - index.members[i].name),
                       index.members[i].name);
        const int at = pbnds_tar_find_key(&index, key, &count);
        uint64_t first = index.members[i].header;
        for (int k = at; k < at + count; ++k) {
            if (index.members[k].header < first) first = index.members[k].header;
        }
        (void)snprintf(path, sizeof path, "%s#%s@%" PRIu64, tar, key, first);
        status = add(f, number, path, error);
    }
    pbnds_tar_index_free(&index);
    return status;
}

/* One name in DIR, DIR/SPLIT or DIR/.work; most are something else. */
static enum pbnds_status add_name(struct finding *f, const char *folder,
                                  const char *name, bool prefixed,
                                  struct pbnds_error *error)
{
    const char *rest = name, *end;
    const char *split = pbnds_split_name(f->split);
    if (prefixed) {
        const size_t length = strlen(split);
        if (strncmp(name, split, length) != 0 || name[length] != '-') return PBNDS_OK;
        rest = name + length + 1;
    }
    const long index = parse_index(rest, &end);
    if (index < 0) return PBNDS_OK;
    char path[PBNDS_STORE_PATH_MAX + 300];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    if (prefixed && strcmp(end, ".tar") == 0) return add_tar(f, path, error);
    return *end ? PBNDS_OK : add(f, index, path, error);
}

static enum pbnds_status add_folder(struct finding *f, const char *folder,
                                    bool prefixed, struct pbnds_error *error)
{
    struct pbnds_store_names names;
    if (!pbnds_store_exists(folder)) return PBNDS_OK;
    PBNDS_TRY(pbnds_store_list(folder, &names, error));
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < names.count && status == PBNDS_OK; ++i)
        status = add_name(f, folder, names.items[i], prefixed, error);
    pbnds_store_names_free(&names);
    return status;
}

/* Of a sample in a tar and in .work, the one in the tar comes first. */
static int by_index(const void *a, const void *b)
{
    const struct found *x = a, *y = b;
    if (x->index != y->index) return x->index < y->index ? -1 : 1;
    const int staged_x = strstr(x->path, "/.work/") != NULL;
    const int staged_y = strstr(y->path, "/.work/") != NULL;
    return staged_x != staged_y ? staged_x - staged_y : strcmp(x->path, y->path);
}

static enum pbnds_status find_all(struct finding *f, const char *dir,
                                  struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX];
    (void)snprintf(path, sizeof path, "%s/%s", dir, pbnds_split_name(f->split));
    PBNDS_TRY(add_folder(f, path, false, error));
    PBNDS_TRY(add_folder(f, dir, true, error));
    (void)snprintf(path, sizeof path, "%s/.work", dir);
    return add_folder(f, path, true, error);
}

enum pbnds_status pbnds_dataset_list(const char *dir, enum pbnds_split split,
                                     struct pbnds_sample_list *list,
                                     struct pbnds_error *error)
{
    *list = (struct pbnds_sample_list){0};
    char path[PBNDS_STORE_PATH_MAX];
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    if (!pbnds_store_exists(path)) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "%s: is not a data set (no dataset.json in it)", dir);
    }
    struct finding f = {.split = split};
    enum pbnds_status status = find_all(&f, dir, error);
    if (status == PBNDS_OK && f.count > 0)
        qsort(f.items, f.count, sizeof *f.items, by_index);
    if (status == PBNDS_OK) {
        list->folders = calloc(f.count + 1, sizeof *list->folders);
        if (!list->folders)
            status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", dir);
    }
    for (size_t i = 0; i < f.count; ++i) {
        const bool again = i > 0 && f.items[i].index == f.items[i - 1].index;
        if (status == PBNDS_OK && !again) {
            list->folders[list->count++] = f.items[i].path;
        } else {
            free(f.items[i].path);
        }
    }
    free(f.items);
    return status;
}

void pbnds_sample_list_free(struct pbnds_sample_list *list)
{
    for (int i = 0; i < list->count; ++i)
        free(list->folders[i]);
    free(list->folders);
    *list = (struct pbnds_sample_list){0};
}

/* {"hash": "................", on the first line. */
static enum pbnds_status hash_of_manifest(const char *path, char hash[17],
                                          struct pbnds_error *error)
{
    FILE *file = fopen(path, "rb");
    if (!file) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be opened: %s", path,
                          strerror(errno));
    }
    const int found = fscanf(file, "{\"hash\": \"%16[0-9a-f]\"", hash);
    (void)fclose(file);
    if (found == 1 && strlen(hash) == 16) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not a manifest of ours", path);
}

enum pbnds_status pbnds_dataset_hash(const char *dir, char hash[17],
                                     struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX];
    (void)snprintf(path, sizeof path, "%s/manifest.json", dir);
    if (pbnds_store_exists(path)) return hash_of_manifest(path, hash, error);
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    uint8_t *claim;
    size_t size;
    PBNDS_TRY(pbnds_file_read(path, (size_t)1 << 26, &claim, &size, error));
    uint64_t h = XXH64(claim, size, 0);
    free(claim);
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
