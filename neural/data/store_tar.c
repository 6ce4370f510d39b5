#include "neural/data/store_tar.h"

#include <archive.h>
#include <archive_entry.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* 2000-01-01: a time that no tool warns of. */
enum { MEMBER_TIME = 946684800 };

struct pbnds_tar_writer {
    char *path;
    int fd;
    struct archive *archive;
};

static enum pbnds_status fail_write(const struct pbnds_tar_writer *w,
                                    struct pbnds_error *error)
{
    const int code = archive_errno(w->archive);
    const char *text = archive_error_string(w->archive);
    return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", w->path,
                      code > 0 ? strerror(code)
                      : text   ? text
                               : "unknown fault");
}

enum pbnds_status pbnds_tar_writer_open(const char *path,
                                        struct pbnds_tar_writer **writer,
                                        struct pbnds_error *error)
{
    *writer = NULL;
    struct pbnds_tar_writer *w = calloc(1, sizeof *w);
    if (w) {
        w->path = strdup(path);
        w->archive = archive_write_new();
        w->fd = -1;
    }
    if (!w || !w->path || !w->archive) {
        pbnds_tar_writer_abort(w);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    }
    w->fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (w->fd < 0) {
        const int code = errno;
        pbnds_tar_writer_abort(w);
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                          strerror(code));
    }
    enum pbnds_status status = PBNDS_OK;
    if (archive_write_set_format_ustar(w->archive) != ARCHIVE_OK ||
        archive_write_set_bytes_per_block(w->archive, 10240) != ARCHIVE_OK ||
        archive_write_set_bytes_in_last_block(w->archive, 1) != ARCHIVE_OK ||
        archive_write_open_fd(w->archive, w->fd) != ARCHIVE_OK) {
        status = fail_write(w, error);
    }
    if (status != PBNDS_OK) {
        pbnds_tar_writer_abort(w);
        return status;
    }
    *writer = w;
    return PBNDS_OK;
}

enum pbnds_status pbnds_tar_writer_add(struct pbnds_tar_writer *w, const char *name,
                                       const void *bytes, size_t size,
                                       struct pbnds_error *error)
{
    struct archive_entry *entry = archive_entry_new();
    if (!entry) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", w->path);
    archive_entry_set_pathname(entry, name);
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0644);
    archive_entry_set_mtime(entry, MEMBER_TIME, 0);
    archive_entry_set_uid(entry, 0);
    archive_entry_set_gid(entry, 0);
    archive_entry_set_size(entry, (la_int64_t)size);
    enum pbnds_status status = PBNDS_OK;
    if (archive_write_header(w->archive, entry) != ARCHIVE_OK ||
        archive_write_data(w->archive, bytes, size) != (la_ssize_t)size) {
        status = fail_write(w, error);
    }
    archive_entry_free(entry);
    return status;
}

enum pbnds_status pbnds_tar_writer_close(struct pbnds_tar_writer *w, bool sync,
                                         struct pbnds_error *error)
{
    enum pbnds_status status = PBNDS_OK;
    if (archive_write_close(w->archive) != ARCHIVE_OK) status = fail_write(w, error);
    if (status == PBNDS_OK && sync && fsync(w->fd) != 0) {
        status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", w->path,
                            strerror(errno));
    }
    if (close(w->fd) != 0 && status == PBNDS_OK) {
        status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", w->path,
                            strerror(errno));
    }
    w->fd = -1;
    pbnds_tar_writer_abort(w);
    return status;
}

void pbnds_tar_writer_abort(struct pbnds_tar_writer *w)
{
    if (!w) return;
    if (w->archive) {
        /* After a fault free() alone would keep the buffers. */
        (void)archive_write_close(w->archive);
        (void)archive_write_free(w->archive);
    }
    if (w->fd >= 0) (void)close(w->fd);
    free(w->path);
    free(w);
}
