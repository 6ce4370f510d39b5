#include "neural/data/ffhq_layout.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <xxhash.h>

#include "engine/core/file.h"
#include "neural/data/assets.h"

#define LIST_BYTES_MAX ((size_t)256 << 20)

static bool is_folder(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

static bool is_file(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode);
}

static bool is_png(const char *name)
{
    const size_t n = strlen(name);
    return n > 4 && name[0] != '.' && strcasecmp(name + n - 4, ".png") == 0;
}

/* A picture's name without its extension; too long a one is no number either. */
static enum pbnds_status add_picture(struct pbnds_ffhq_layout *layout,
                                     const char *folder, const char *name,
                                     struct pbnds_error *error)
{
    const unsigned count = (unsigned)layout->count;
    if ((count & (count - 1u)) == 0) { /* zero or a power of two: grow */
        struct pbnds_ffhq_picture *grown =
            realloc(layout->pictures, 2u * (size_t)(count + 1u) * sizeof *grown);
        if (!grown)
            return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list",
                              layout->dir);
        layout->pictures = grown;
    }
    struct pbnds_ffhq_picture *p = &layout->pictures[layout->count++];
    p->index = pbnds_picture_index(name);
    (void)snprintf(p->id, sizeof p->id, "%.*s", (int)(strlen(name) - 4), name);
    (void)snprintf(p->folder, sizeof p->folder, "%s", folder);
    return PBNDS_OK;
}

/* The pictures of bgremoval/ itself and, with `deeper`, of its folders. */
static enum pbnds_status list_folder(struct pbnds_ffhq_layout *layout,
                                     const char *folder, bool deeper,
                                     struct pbnds_error *error)
{
    char path[1400];
    (void)snprintf(path, sizeof path, "%s/bgremoval/%s", layout->dir, folder);
    struct dirent **entries;
    const int n = scandir(path, &entries, NULL, alphasort);
    if (n < 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be listed: %s", path,
                          strerror(errno));
    }
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < n; ++i) {
        const char *name = entries[i]->d_name;
        char child[1400 + 260];
        (void)snprintf(child, sizeof child, "%s/%s", path, name);
        if (status != PBNDS_OK || name[0] == '.') {
            /* nothing more of it */
        } else if (is_png(name)) {
            status = add_picture(layout, folder, name, error);
        } else if (deeper && strlen(name) < sizeof layout->pictures->folder &&
                   is_folder(child)) {
            status = list_folder(layout, name, false, error);
        }
        free(entries[i]);
    }
    free(entries);
    return status;
}

static int by_index(const void *a, const void *b)
{
    const struct pbnds_ffhq_picture *x = a, *y = b;
    if (x->index != y->index) return x->index < y->index ? -1 : 1;
    const int ids = strcmp(x->id, y->id);
    return ids ? ids : strcmp(x->folder, y->folder);
}

/* Of several pictures with one number the first is taken, so that a second run takes the
 * same. */
static void sort_pictures(struct pbnds_ffhq_layout *layout)
{
    if (layout->count == 0) return;
    qsort(layout->pictures, (size_t)layout->count, sizeof *layout->pictures, by_index);
    int last = -1;
    for (int i = 0; i < layout->count; ++i) {
        struct pbnds_ffhq_picture *p = &layout->pictures[i];
        if (p->index == last) {
            p->index = -1;
        } else {
            last = p->index;
        }
    }
}

static enum pbnds_status read_fov(struct pbnds_ffhq_layout *layout,
                                  struct pbnds_error *error)
{
    char path[1400];
    (void)snprintf(path, sizeof path, "%s/pred_fov.json", layout->dir);
    if (!is_file(path)) return PBNDS_OK;
    uint8_t *bytes;
    size_t size;
    PBNDS_TRY(pbnds_file_read(path, LIST_BYTES_MAX, &bytes, &size, error));
    enum pbnds_status status =
        pbnds_picture_list_json(&layout->fov, bytes, size, path, error);
    free(bytes);
    if (status == PBNDS_OK) status = pbnds_picture_list_sort(&layout->fov, path, error);
    return status;
}

static enum pbnds_status read_splits(struct pbnds_ffhq_layout *layout,
                                     struct pbnds_error *error)
{
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        char path[1400];
        (void)snprintf(path, sizeof path, "%s/%s.txt", layout->dir,
                       pbnds_split_name((enum pbnds_split)s));
        if (!is_file(path)) continue;
        uint8_t *bytes;
        size_t size;
        PBNDS_TRY(pbnds_file_read(path, LIST_BYTES_MAX, &bytes, &size, error));
        layout->has_splits = true;
        const enum pbnds_status status = pbnds_picture_list_lines(
            &layout->splits, bytes, size, (double)s, path, error);
        free(bytes);
        PBNDS_TRY(status);
    }
    char names[1400];
    (void)snprintf(names, sizeof names, "%s/{train,val,test}.txt", layout->dir);
    return pbnds_picture_list_sort(&layout->splits, names, error);
}

static int split_of(const struct pbnds_ffhq_layout *layout,
                    const struct pbnds_ffhq_picture *picture)
{
    if (picture->index < 0) return -1;
    if (!layout->has_splits) return (int)pbnds_split_of_name(picture->id);
    const double found = pbnds_picture_list_find(&layout->splits, picture->index);
    return isnan(found) ? -1 : (int)found;
}

/* What the pictures are called in the data set, and what makes it another one. */
static enum pbnds_status number_pictures(struct pbnds_ffhq_layout *layout,
                                         struct pbnds_error *error)
{
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        layout->in_split[s] =
            calloc((size_t)layout->count + 1u, sizeof *layout->in_split[s]);
        if (!layout->in_split[s])
            return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list",
                              layout->dir);
    }
    for (int i = 0; i < layout->count; ++i) {
        struct pbnds_ffhq_picture *p = &layout->pictures[i];
        p->split = split_of(layout, p);
        if (p->split < 0) continue;
        p->number = layout->split_count[p->split]++;
        layout->in_split[p->split][p->number] = p;
        layout->hash = XXH64(p->id, strlen(p->id) + 1, layout->hash);
        layout->hash =
            XXH64(p->folder, strlen(p->folder) + 1, layout->hash + (uint64_t)p->split);
    }
    return PBNDS_OK;
}

static enum pbnds_status read_all(struct pbnds_ffhq_layout *layout,
                                  struct pbnds_error *error)
{
    const char *dir = layout->dir;
    if (strlen(dir) > 1000)
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: is too long a name", dir);
    if (!is_folder(dir)) {
        return pbnds_fail(
            error, PBNDS_ERROR_IO,
            "%s: is no folder that can be read; give one with bgremoval/, "
            "texture/ and hdri/ in it",
            dir);
    }
    char path[1400];
    (void)snprintf(path, sizeof path, "%s/bgremoval", dir);
    if (!is_folder(path)) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: has no folder bgremoval, so it is not laid out as "
                          "FFHQ-PBR; see pbnds import --help",
                          dir);
    }
    PBNDS_TRY(list_folder(layout, "", true, error));
    sort_pictures(layout);
    PBNDS_TRY(read_fov(layout, error));
    PBNDS_TRY(read_splits(layout, error));
    return number_pictures(layout, error);
}

enum pbnds_status pbnds_ffhq_layout_read(const char *dir,
                                         struct pbnds_ffhq_layout *layout,
                                         struct pbnds_error *error)
{
    *layout = (struct pbnds_ffhq_layout){.dir = dir};
    const enum pbnds_status status = read_all(layout, error);
    if (status != PBNDS_OK) pbnds_ffhq_layout_free(layout);
    return status;
}

void pbnds_ffhq_layout_free(struct pbnds_ffhq_layout *layout)
{
    free(layout->pictures);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        free(layout->in_split[s]);
    pbnds_picture_list_free(&layout->fov);
    pbnds_picture_list_free(&layout->splits);
    *layout = (struct pbnds_ffhq_layout){.dir = NULL};
}

static enum pbnds_status check_there(const char *path, struct pbnds_error *error)
{
    if (is_file(path)) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is missing", path);
}

enum pbnds_status pbnds_ffhq_paths_of(const struct pbnds_ffhq_layout *layout,
                                      const struct pbnds_ffhq_picture *picture,
                                      struct pbnds_ffhq_paths *paths,
                                      struct pbnds_error *error)
{
    static const struct {
        enum pbnds_import_map_name map;
        const char *kind, *extension;
    } TEXTURES[] = {{PBNDS_IMPORT_ALBEDO, "albedo", "png"},
                    {PBNDS_IMPORT_NORMAL, "normal", "png"},
                    {PBNDS_IMPORT_ROUGHNESS, "roughness", "png"},
                    {PBNDS_IMPORT_SPECULAR, "specular", "png"},
                    {PBNDS_IMPORT_DEPTH, "depth", "exr"}};
    memset(paths, 0, sizeof *paths);
    const char *dir = layout->dir, *id = picture->id, *folder = picture->folder;
    const char *slash = folder[0] ? "/" : "";
    char *photo = paths->maps.path[PBNDS_IMPORT_PHOTO];
    (void)snprintf(photo, sizeof paths->maps.path[0], "%s/bgremoval/%s%s%s.png", dir,
                   folder, slash, id);
    PBNDS_TRY(check_there(photo, error));
    for (size_t i = 0; i < sizeof TEXTURES / sizeof TEXTURES[0]; ++i) {
        char *path = paths->maps.path[TEXTURES[i].map];
        (void)snprintf(path, sizeof paths->maps.path[0], "%s/texture/%s/%s%s%s_%s.%s",
                       dir, TEXTURES[i].kind, folder, slash, TEXTURES[i].kind, id,
                       TEXTURES[i].extension);
        if (TEXTURES[i].map == PBNDS_IMPORT_DEPTH) {
            if (!is_file(path)) path[0] = 0;
        } else {
            PBNDS_TRY(check_there(path, error));
        }
    }
    (void)snprintf(paths->light, sizeof paths->light, "%s/hdri/%s%shdri_%s.exr", dir,
                   folder, slash, id);
    return check_there(paths->light, error);
}
