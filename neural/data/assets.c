#include "neural/data/assets.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <xxhash.h>

#include "engine/core/file.h"

#define ASSET_BYTES_MAX ((size_t)1 << 31)

const char *pbnds_split_name(enum pbnds_split split)
{
    static const char *const NAMES[] = {"train", "val", "test"};
    return split < PBNDS_SPLIT_COUNT ? NAMES[split] : "?";
}

static bool has_extension(const char *path, const char *const *extensions)
{
    const size_t length = strlen(path);
    for (int i = 0; extensions[i]; ++i) {
        const size_t n = strlen(extensions[i]);
        if (length > n && strcasecmp(path + length - n, extensions[i]) == 0)
            return true;
    }
    return false;
}

/* The deepest folder named train, val or test below (or as) the path given decides, the
 * hash of the stem otherwise. Folders above what was given say nothing. */
static enum pbnds_split split_of(const char *below, const char *stem)
{
    int found = -1;
    for (const char *at = below; at;) {
        const char *end = strchr(at, '/');
        for (int s = 0; end && s < PBNDS_SPLIT_COUNT; ++s) {
            const char *name = pbnds_split_name((enum pbnds_split)s);
            const size_t length = strlen(name);
            if ((size_t)(end - at) == length && strncmp(at, name, length) == 0)
                found = s;
        }
        at = end ? end + 1 : NULL;
    }
    if (found >= 0) return (enum pbnds_split)found;
    const uint64_t percent = XXH64(stem, strlen(stem), 0) % 100u;
    return percent < 80u   ? PBNDS_SPLIT_TRAIN
           : percent < 90u ? PBNDS_SPLIT_VAL
                           : PBNDS_SPLIT_TEST;
}

static enum pbnds_status add_file(struct pbnds_asset_list *list, const char *path,
                                  const char *below, struct pbnds_error *error)
{
    if (((unsigned)list->count & ((unsigned)list->count - 1u)) ==
        0) { /* power of two: grow */
        const size_t capacity = list->count ? 2u * (size_t)list->count : 1u;
        struct pbnds_asset *grown = realloc(list->items, capacity * sizeof *grown);
        if (!grown) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
        list->items = grown;
    }
    uint8_t *bytes;
    size_t size;
    PBNDS_TRY(pbnds_file_read(path, ASSET_BYTES_MAX, &bytes, &size, error));
    struct pbnds_asset *a = &list->items[list->count];
    a->hash = XXH64(bytes, size, 0);
    free(bytes);
    const char *slash = strrchr(path, '/');
    (void)snprintf(a->stem, sizeof a->stem, "%s", slash ? slash + 1 : path);
    char *dot = strrchr(a->stem, '.');
    if (dot) *dot = 0;
    a->split = split_of(below, a->stem);
    a->path = strdup(path);
    if (!a->path) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    ++list->count;
    return PBNDS_OK;
}

/* `below` is the part of the path that may name its split. */
static enum pbnds_status add_path(struct pbnds_asset_list *list, const char *path,
                                  size_t below, const char *const *extensions,
                                  int depth, struct pbnds_error *error)
{
    struct stat info;
    if (stat(path, &info) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be opened: %s", path,
                          strerror(errno));
    }
    if (!S_ISDIR(info.st_mode)) return add_file(list, path, path + below, error);
    if (depth > 8) return PBNDS_OK;
    struct dirent **entries;
    const int n = scandir(path, &entries, NULL, alphasort);
    if (n < 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be listed: %s", path,
                          strerror(errno));
    }
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < n; ++i) {
        char child[4096];
        const int length =
            snprintf(child, sizeof child, "%s/%s", path, entries[i]->d_name);
        const bool fits = length > 0 && (size_t)length < sizeof child;
        if (status == PBNDS_OK && entries[i]->d_name[0] != '.' && fits &&
            stat(child, &info) == 0 &&
            (S_ISDIR(info.st_mode) || has_extension(child, extensions))) {
            status = add_path(list, child, below, extensions, depth + 1, error);
        }
        free(entries[i]);
    }
    free(entries);
    return status;
}

static int compare_asset(const void *a, const void *b)
{
    const struct pbnds_asset *x = a, *y = b;
    if (x->split != y->split) return x->split < y->split ? -1 : 1;
    const int by_stem = strcmp(x->stem, y->stem);
    return by_stem ? by_stem : strcmp(x->path, y->path);
}

/* An asset in two splits would leak the test set into training. */
static enum pbnds_status check_leaks(const struct pbnds_asset_list *list,
                                     struct pbnds_error *error)
{
    for (int i = 0; i < list->count; ++i) {
        for (int j = i + 1; j < list->count; ++j) {
            const struct pbnds_asset *a = &list->items[i], *b = &list->items[j];
            if (a->split != b->split &&
                (a->hash == b->hash || strcmp(a->stem, b->stem) == 0)) {
                return pbnds_fail(
                    error, PBNDS_ERROR_ARGUMENT,
                    "%s: is in split %s and, as %s, in split %s; keep one", a->path,
                    pbnds_split_name(a->split), b->path, pbnds_split_name(b->split));
            }
        }
    }
    return PBNDS_OK;
}

/* Where the last component of a path begins; trailing slashes belong to it. */
static size_t own_name(const char *path)
{
    size_t end = strlen(path);
    while (end > 0 && path[end - 1] == '/')
        --end;
    while (end > 0 && path[end - 1] != '/')
        --end;
    return end;
}

enum pbnds_status pbnds_assets_find(const char *const *paths, int count,
                                    const char *const *extensions,
                                    struct pbnds_asset_list *list,
                                    struct pbnds_error *error)
{
    *list = (struct pbnds_asset_list){0};
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < count && status == PBNDS_OK; ++i) {
        status = add_path(list, paths[i], own_name(paths[i]), extensions, 0, error);
    }
    if (status == PBNDS_OK && list->count == 0) {
        status = pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: no %s files found there",
                            count > 0 ? paths[0] : "(nothing)", extensions[0]);
    }
    if (status == PBNDS_OK) {
        qsort(list->items, (size_t)list->count, sizeof *list->items, compare_asset);
        for (int i = 0; i < list->count; ++i) {
            for (int s = (int)list->items[i].split + 1; s <= PBNDS_SPLIT_COUNT; ++s) {
                ++list->first[s];
            }
        }
        status = check_leaks(list, error);
    }
    if (status != PBNDS_OK) pbnds_assets_free(list);
    return status;
}

void pbnds_assets_free(struct pbnds_asset_list *list)
{
    for (int i = 0; i < list->count; ++i)
        free(list->items[i].path);
    free(list->items);
    *list = (struct pbnds_asset_list){0};
}
