#include "neural/data/store_read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "neural/data/store_index.h"

#define FILE_BYTES_MAX ((size_t)1 << 32)

/* TAR#KEY@OFFSET taken apart. */
struct place {
    char tar[PBNDS_STORE_PATH_MAX];
    char key[32];
    uint64_t hint;
};

static bool in_tar(const char *path, struct place *place)
{
    const char *hash = strrchr(path, '#');
    if (!hash || hash - path < 4 || hash - path >= PBNDS_STORE_PATH_MAX ||
        strncmp(hash - 4, ".tar", 4) != 0) {
        return false;
    }
    memcpy(place->tar, path, (size_t)(hash - path));
    place->tar[hash - path] = 0;
    const size_t length = strcspn(hash + 1, "@");
    if (length < 1 || length >= sizeof place->key || strchr(hash, '/')) return false;
    memcpy(place->key, hash + 1, length);
    place->key[length] = 0;
    const char *at = strchr(hash, '@');
    place->hint = at ? strtoull(at + 1, NULL, 10) : 0;
    return true;
}

enum pbnds_status pbnds_store_read(const char *path, const char *file,
                                   struct pbnds_store_bytes *bytes,
                                   struct pbnds_error *error)
{
    struct place place;
    bytes->data = NULL;
    bytes->size = 0;
    if (!in_tar(path, &place)) {
        if (snprintf(bytes->name, sizeof bytes->name, "%s/%s", path, file) >=
            (int)sizeof bytes->name) {
            return pbnds_fail(error, PBNDS_ERROR_IO, "%s: is too long a name", path);
        }
        return pbnds_file_read(bytes->name, FILE_BYTES_MAX, &bytes->data, &bytes->size,
                               error);
    }
    char name[sizeof((struct pbnds_tar_member *)NULL)->name];
    (void)snprintf(name, sizeof name, "%s.%s", place.key, file);
    (void)snprintf(bytes->name, sizeof bytes->name, "%.*s/%s",
                   (int)(sizeof bytes->name - sizeof name - 2), place.tar, name);
    struct pbnds_tar_member member;
    PBNDS_TRY(pbnds_tar_locate(place.tar, place.hint, name, &member, error));
    return pbnds_tar_read(place.tar, &member, &bytes->data, &bytes->size, error);
}

bool pbnds_store_holds(const char *path, const char *file)
{
    struct place place;
    char name[PBNDS_STORE_PATH_MAX];
    if (in_tar(path, &place)) {
        struct pbnds_tar_member member;
        (void)snprintf(name, sizeof name, "%s.%s", place.key, file);
        return pbnds_tar_locate(place.tar, place.hint, name, &member, NULL) == PBNDS_OK;
    }
    (void)snprintf(name, sizeof name, "%s/%s", path, file);
    return pbnds_store_exists(name);
}

enum pbnds_status pbnds_store_files(const char *path, struct pbnds_store_names *names,
                                    struct pbnds_error *error)
{
    struct place place;
    if (!in_tar(path, &place)) return pbnds_store_list(path, names, error);
    *names = (struct pbnds_store_names){0};
    struct pbnds_tar_index index;
    PBNDS_TRY(pbnds_tar_index_read(place.tar, &index, error));
    int count;
    const int first = pbnds_tar_find_key(&index, place.key, &count);
    names->items = calloc((size_t)count + 1, sizeof *names->items);
    bool ok = names->items != NULL;
    for (int i = 0; i < count && ok; ++i) {
        names->items[i] = strdup(index.members[first + i].name + strlen(place.key) + 1);
        ok = names->items[i] != NULL;
        names->count += ok;
    }
    pbnds_tar_index_free(&index);
    if (!ok) {
        pbnds_store_names_free(names);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list",
                          path);
    }
    return PBNDS_OK;
}
