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
#include "engine/core/rng.h"

#define ASSET_BYTES_MAX ((size_t)1 << 31)

/* Numbers of procedural assets of the splits do not meet. */
#define SPLIT_STRIDE 1000000u

/* What a search is about. */
struct search {
    struct pbnds_asset_list *list;
    const char *const *extensions;
    int source;
};

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

enum pbnds_split pbnds_split_of_name(const char *stem)
{
    const uint64_t percent = XXH64(stem, strlen(stem), 0) % 100u;
    return percent < 80u   ? PBNDS_SPLIT_TRAIN
           : percent < 90u ? PBNDS_SPLIT_VAL
                           : PBNDS_SPLIT_TEST;
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
    return found >= 0 ? (enum pbnds_split)found : pbnds_split_of_name(stem);
}

static struct pbnds_asset *add_asset(struct pbnds_asset_list *list)
{
    if (((unsigned)list->count & ((unsigned)list->count - 1u)) ==
        0) { /* power of two: grow */
        const size_t capacity = list->count ? 2u * (size_t)list->count : 1u;
        struct pbnds_asset *grown = realloc(list->items, capacity * sizeof *grown);
        if (!grown) return NULL;
        list->items = grown;
    }
    struct pbnds_asset *a = &list->items[list->count++];
    memset(a, 0, sizeof *a);
    return a;
}

static enum pbnds_status add_file(const struct search *search, const char *path,
                                  const char *below, struct pbnds_error *error)
{
    uint8_t *bytes;
    size_t size;
    PBNDS_TRY(pbnds_file_read(path, ASSET_BYTES_MAX, &bytes, &size, error));
    const uint64_t hash = XXH64(bytes, size, 0);
    free(bytes);
    char *copy = strdup(path);
    struct pbnds_asset *a = copy ? add_asset(search->list) : NULL;
    if (!a) {
        free(copy);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    }
    a->path = copy;
    a->hash = hash;
    a->source = search->source;
    const char *slash = strrchr(path, '/');
    (void)snprintf(a->stem, sizeof a->stem, "%s", slash ? slash + 1 : path);
    char *dot = strrchr(a->stem, '.');
    if (dot) *dot = 0;
    a->split = split_of(below, a->stem);
    return PBNDS_OK;
}

/* `below` is the part of the path that may name its split. */
static enum pbnds_status add_path(const struct search *search, const char *path,
                                  size_t below, int depth, struct pbnds_error *error)
{
    struct stat info;
    if (stat(path, &info) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be opened: %s", path,
                          strerror(errno));
    }
    if (!S_ISDIR(info.st_mode)) return add_file(search, path, path + below, error);
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
            (S_ISDIR(info.st_mode) || has_extension(child, search->extensions))) {
            status = add_path(search, child, below, depth + 1, error);
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
    if (by_stem || !x->path || !y->path) return by_stem;
    return strcmp(x->path, y->path);
}

/* An asset in two splits would leak the test set into training. */
static enum pbnds_status check_leaks(const struct pbnds_asset_list *list,
                                     struct pbnds_error *error)
{
    for (int i = 0; i < list->count; ++i) {
        for (int j = i + 1; j < list->count; ++j) {
            const struct pbnds_asset *a = &list->items[i], *b = &list->items[j];
            if (a->path && b->path && a->split != b->split &&
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

static enum pbnds_status add_procedural(struct pbnds_asset_list *list,
                                        enum pbnds_asset_kind kind, const int *counts,
                                        int source, struct pbnds_error *error)
{
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        for (int i = 0; i < counts[s]; ++i) {
            struct pbnds_asset *a = add_asset(list);
            if (!a)
                return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for worlds");
            a->number = (uint64_t)s * SPLIT_STRIDE + (uint64_t)i;
            a->hash = pbnds_mix64(a->number + (kind == PBNDS_ASSET_LIGHT));
            a->split = (enum pbnds_split)s;
            a->source = source;
            (void)snprintf(a->stem, sizeof a->stem, "%s_%07llu",
                           kind == PBNDS_ASSET_SCENE ? "world" : "sky",
                           (unsigned long long)a->number);
        }
    }
    return PBNDS_OK;
}

/* Weights of one split's assets, as the sums before each. `files` has room for a number
 * a source. */
static void weigh(struct pbnds_asset_list *list, int split, const double *shares,
                  int *files, int source_count)
{
    const int first = list->first[split], end = list->first[split + 1];
    memset(files, 0, (size_t)source_count * sizeof *files);
    for (int i = first; i < end; ++i)
        ++files[list->items[i].source];
    double given = 0.0;
    int unshared = 0;
    for (int s = 0; s < source_count; ++s) {
        if (!(shares[s] > 0.0)) {
            unshared += files[s];
        } else if (files[s] > 0) {
            given += shares[s];
        }
    }
    /* With nothing to take the rest, or shares beyond one, the shares are relative. */
    const double rest = unshared > 0 && given < 1.0 ? 1.0 - given : 0.0;
    const double scale = rest > 0.0 || given <= 0.0 ? 1.0 : 1.0 / given;
    double sum = 0.0;
    for (int i = first; i < end; ++i) {
        const int s = list->items[i].source;
        list->items[i].below = sum;
        sum += shares[s] > 0.0 ? scale * shares[s] / files[s] : rest / unshared;
    }
}

static enum pbnds_status finish(struct pbnds_asset_list *list,
                                const struct pbnds_dataset_source *sources, int count,
                                double procedural, struct pbnds_error *error)
{
    qsort(list->items, (size_t)list->count, sizeof *list->items, compare_asset);
    for (int i = 0; i < list->count; ++i) {
        for (int s = (int)list->items[i].split + 1; s <= PBNDS_SPLIT_COUNT; ++s) {
            ++list->first[s];
        }
    }
    double *shares = calloc((size_t)count + 1, sizeof *shares);
    int *files = calloc((size_t)count + 1, sizeof *files);
    if (!shares || !files) {
        free(shares);
        free(files);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for assets");
    }
    for (int i = 0; i < count; ++i)
        shares[i] = sources[i].share;
    shares[count] = procedural;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        weigh(list, s, shares, files, count + 1);
    free(shares);
    free(files);
    return check_leaks(list, error);
}

enum pbnds_status pbnds_assets_find(const struct pbnds_dataset_recipe *recipe,
                                    enum pbnds_asset_kind kind,
                                    struct pbnds_asset_list *list,
                                    struct pbnds_error *error)
{
    static const char *const SCENES[] = {".glb", ".gltf", NULL};
    static const char *const LIGHTS[] = {".hdr", ".exr", NULL};
    const bool scene = kind == PBNDS_ASSET_SCENE;
    const struct pbnds_dataset_source *sources = scene ? recipe->scenes : recipe->envs;
    const int count = scene ? recipe->scene_count : recipe->env_count;
    struct search search = {list, scene ? SCENES : LIGHTS, 0};
    *list = (struct pbnds_asset_list){0};
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < count && status == PBNDS_OK; ++i) {
        search.source = i;
        status =
            add_path(&search, sources[i].path, own_name(sources[i].path), 0, error);
    }
    if (status == PBNDS_OK) {
        status = add_procedural(list, kind, scene ? recipe->worlds : recipe->skies,
                                count, error);
    }
    if (status == PBNDS_OK && list->count == 0) {
        status =
            pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: no %s files found there",
                       count > 0 ? sources[0].path : "(nothing)", search.extensions[0]);
    }
    if (status == PBNDS_OK) {
        status = finish(list, sources, count,
                        scene ? recipe->world_share : recipe->sky_share, error);
    }
    if (status != PBNDS_OK) pbnds_assets_free(list);
    return status;
}

const struct pbnds_asset *pbnds_assets_pick(const struct pbnds_asset_list *list,
                                            enum pbnds_split split, double u)
{
    const int first = list->first[split];
    int lo = first, hi = list->first[split + 1]; /* below(lo) <= u < below(hi) */
    if (lo == hi) return NULL;
    while (hi - lo > 1) {
        const int middle = lo + (hi - lo) / 2;
        if (list->items[middle].below <= u) {
            lo = middle;
        } else {
            hi = middle;
        }
    }
    return &list->items[lo];
}

void pbnds_assets_free(struct pbnds_asset_list *list)
{
    for (int i = 0; i < list->count; ++i)
        free(list->items[i].path);
    free(list->items);
    *list = (struct pbnds_asset_list){0};
}
