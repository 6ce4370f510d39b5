#include "engine/core/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum pbnds_status pbnds_file_read_open(int fd, const char *name, size_t max_bytes,
                                       uint8_t **data, size_t *size,
                                       struct pbnds_error *error)
{
    *data = NULL;
    *size = 0;
    enum pbnds_status status = PBNDS_OK;
    struct stat info;
    uint8_t *buffer = NULL;
    size_t filled = 0;
    if (fstat(fd, &info) != 0 || S_ISDIR(info.st_mode)) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: is a folder, not a file", name);
    }
    /* What it says of its size is not taken for granted, nor paid for beyond the limit. */
    size_t capacity = 65536;
    if (info.st_size > 0) {
        capacity = (uint64_t)info.st_size < max_bytes ? (size_t)info.st_size + 1
                                                      : max_bytes + 1;
    }
    for (;;) {
        if (filled > max_bytes) {
            status = pbnds_fail(error, PBNDS_ERROR_MEMORY,
                                "%s: is larger than the limit of %zu bytes", name,
                                max_bytes);
            goto done;
        }
        if (!buffer || filled == capacity) {
            if (buffer) capacity *= 2;
            uint8_t *grown = realloc(buffer, capacity + 1);
            if (!grown) {
                status = pbnds_fail(error, PBNDS_ERROR_MEMORY,
                                    "%s: no memory for %zu bytes", name, capacity);
                goto done;
            }
            buffer = grown;
        }
        const ssize_t n = read(fd, buffer + filled, capacity - filled);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) {
            status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be read: %s", name,
                                strerror(errno));
            goto done;
        }
        if (n == 0) break;
        filled += (size_t)n;
    }
    buffer[filled] = 0;
    *data = buffer;
    *size = filled;
    buffer = NULL;
done:
    free(buffer);
    return status;
}

enum pbnds_status pbnds_file_read(const char *path, size_t max_bytes, uint8_t **data,
                                  size_t *size, struct pbnds_error *error)
{
    *data = NULL;
    *size = 0;
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be opened: %s", path,
                          strerror(errno));
    }
    const enum pbnds_status status =
        pbnds_file_read_open(fd, path, max_bytes, data, size, error);
    (void)close(fd);
    return status;
}

enum pbnds_status pbnds_file_begin(struct pbnds_file_writer *w, const char *path,
                                   struct pbnds_error *error)
{
    const size_t length = strlen(path);
    *w = (struct pbnds_file_writer){malloc(length + 1), malloc(length + 48)};
    if (!w->path || !w->temp) {
        free(w->path);
        free(w->temp);
        *w = (struct pbnds_file_writer){NULL, NULL};
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its name",
                          path);
    }
    memcpy(w->path, path, length + 1);
    /* The extension stays last: image writers choose the format by it. */
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    (void)snprintf(w->temp, length + 48, "%.*s.tmp-%ld-%s", (int)(name - path), path,
                   (long)getpid(), name);
    const int fd = open(w->temp, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (fd < 0) {
        const int code = errno;
        w->temp[0] = 0; /* nothing to remove */
        pbnds_file_abort(w);
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                          strerror(code));
    }
    (void)close(fd);
    return PBNDS_OK;
}

static _Thread_local bool unsynced;

bool pbnds_file_set_sync(bool on)
{
    const bool before = !unsynced;
    unsynced = !on;
    return before;
}

enum pbnds_status pbnds_file_commit(struct pbnds_file_writer *w,
                                    struct pbnds_error *error)
{
    enum pbnds_status status = PBNDS_OK;
    const int fd = open(w->temp, O_RDWR | O_CLOEXEC);
    const int synced = fd >= 0 && (unsynced || fsync(fd) == 0);
    const int closed = fd >= 0 && close(fd) == 0;
    if (!synced || !closed || rename(w->temp, w->path) != 0) {
        status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", w->path,
                            strerror(errno));
        pbnds_file_abort(w);
        return status;
    }
    w->temp[0] = 0;
    pbnds_file_abort(w);
    return status;
}

void pbnds_file_abort(struct pbnds_file_writer *w)
{
    if (w->temp && w->temp[0]) (void)unlink(w->temp);
    free(w->path);
    free(w->temp);
    *w = (struct pbnds_file_writer){NULL, NULL};
}

enum pbnds_status pbnds_file_write(const char *path, const void *data, size_t size,
                                   struct pbnds_error *error)
{
    struct pbnds_file_writer w;
    PBNDS_TRY(pbnds_file_begin(&w, path, error));
    FILE *file = fopen(w.temp, "wb");
    const size_t written = file ? fwrite(data, 1, size, file) : 0;
    const int flushed = file ? fclose(file) : EOF;
    if (!file || written != size || flushed != 0) {
        const int code = errno;
        pbnds_file_abort(&w);
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                          strerror(code));
    }
    return pbnds_file_commit(&w, error);
}

enum pbnds_status pbnds_make_folder(const char *path, struct pbnds_error *error)
{
    const size_t length = strlen(path);
    char *copy = malloc(length + 1);
    if (!copy) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    memcpy(copy, path, length + 1);
    enum pbnds_status status = PBNDS_OK;
    for (size_t i = 1; i <= length && status == PBNDS_OK; ++i) {
        if (copy[i] != '/' && copy[i] != 0) continue;
        const char kept = copy[i];
        copy[i] = 0;
        struct stat info;
        if (mkdir(copy, 0777) != 0 &&
            !(errno == EEXIST && stat(copy, &info) == 0 && S_ISDIR(info.st_mode))) {
            status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: folder cannot be made: %s",
                                copy, strerror(errno));
        }
        copy[i] = kept;
    }
    free(copy);
    return status;
}
