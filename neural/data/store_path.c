#include "neural/data/store_path.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

void pbnds_store_path(const char *dir, enum pbnds_store_place place,
                      enum pbnds_split split, int number,
                      char path[PBNDS_STORE_PATH_MAX])
{
    const char *name = pbnds_split_name(split);
    const size_t size = PBNDS_STORE_PATH_MAX;
    switch (place) {
    case PBNDS_PLACE_FOLDER:
        (void)snprintf(path, size, "%s/%s/%06d", dir, name, number);
        break;
    case PBNDS_PLACE_STAGED:
        (void)snprintf(path, size, "%s/.work/%s-%06d", dir, name, number);
        break;
    case PBNDS_PLACE_TEMP:
        (void)snprintf(path, size, "%s/.work/%s-%06d.tmp", dir, name, number);
        break;
    case PBNDS_PLACE_QUARANTINE:
        (void)snprintf(path, size, "%s/quarantine/%s-%06d.json", dir, name, number);
        break;
    case PBNDS_PLACE_TAR:
        (void)snprintf(path, size, "%s/%s-%06d.tar", dir, name, number);
        break;
    case PBNDS_PLACE_TAR_TEMP:
        (void)snprintf(path, size, "%s/.work/%s-%06d.tar.tmp", dir, name, number);
        break;
    }
}

bool pbnds_store_exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0;
}

static void remove_below(const char *path, int depth)
{
    DIR *dir = depth < 8 ? opendir(path) : NULL;
    for (struct dirent *entry; dir && (entry = readdir(dir));) {
        char child[PBNDS_STORE_PATH_MAX + 300];
        const int length = snprintf(child, sizeof child, "%s/%s", path, entry->d_name);
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0 ||
            length >= PBNDS_STORE_PATH_MAX) {
            continue;
        }
        if (unlink(child) != 0 && (errno == EISDIR || errno == EPERM))
            remove_below(child, depth + 1);
    }
    if (dir) (void)closedir(dir);
    (void)rmdir(path);
}

void pbnds_store_remove(const char *path)
{
    if (unlink(path) != 0 && (errno == EISDIR || errno == EPERM)) remove_below(path, 0);
}

void pbnds_store_sweep(const char *folder)
{
    DIR *dir = opendir(folder);
    for (struct dirent *entry; dir && (entry = readdir(dir));) {
        char child[PBNDS_STORE_PATH_MAX + 300];
        (void)snprintf(child, sizeof child, "%s/%s", folder, entry->d_name);
        if (strncmp(entry->d_name, ".tmp-", 5) == 0) (void)unlink(child);
    }
    if (dir) (void)closedir(dir);
}

void pbnds_store_sync(const char *folder)
{
    const int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return;
    (void)fsync(fd);
    (void)close(fd);
}

static int is_shown(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

/* Not alphasort: the order must not follow the user's language. */
static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

enum pbnds_status pbnds_store_list(const char *folder, struct pbnds_store_names *names,
                                   struct pbnds_error *error)
{
    *names = (struct pbnds_store_names){0};
    struct dirent **entries;
    const int n = scandir(folder, &entries, is_shown, by_name);
    if (n < 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be listed: %s", folder,
                          strerror(errno));
    }
    names->items = calloc((size_t)n + 1, sizeof *names->items);
    bool ok = names->items != NULL;
    for (int i = 0; i < n; ++i) {
        char *name = ok ? strdup(entries[i]->d_name) : NULL;
        if (name) {
            names->items[names->count++] = name;
        } else {
            ok = false;
        }
        free(entries[i]);
    }
    free(entries);
    if (ok) return PBNDS_OK;
    pbnds_store_names_free(names);
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list", folder);
}

void pbnds_store_names_free(struct pbnds_store_names *names)
{
    for (int i = 0; i < names->count; ++i)
        free(names->items[i]);
    free(names->items);
    *names = (struct pbnds_store_names){0};
}

enum pbnds_status pbnds_store_sync_files(const char *folder, struct pbnds_error *error)
{
    struct pbnds_store_names names;
    PBNDS_TRY(pbnds_store_list(folder, &names, error));
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < names.count && status == PBNDS_OK; ++i) {
        char path[PBNDS_STORE_PATH_MAX + 300];
        (void)snprintf(path, sizeof path, "%s/%s", folder, names.items[i]);
        const int fd = open(path, O_RDWR | O_CLOEXEC);
        if (fd < 0 || fsync(fd) != 0) {
            status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s",
                                path, strerror(errno));
        }
        if (fd >= 0) (void)close(fd);
    }
    pbnds_store_names_free(&names);
    pbnds_store_sync(folder);
    return status;
}

void pbnds_store_hash(const void *bytes, size_t size, char hash[17])
{
    (void)snprintf(hash, 17, "%016" PRIx64, XXH64(bytes, size, 0));
}
