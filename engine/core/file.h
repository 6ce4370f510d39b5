/**
 * @file file.h
 * Whole files in, atomic files out: a kill leaves the old file or the new one.
 */
#ifndef PBNDS_ENGINE_CORE_FILE_H
#define PBNDS_ENGINE_CORE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "engine/core/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Reads a whole file of at most max_bytes. *data is malloc'd (with one extra zero byte
 *  behind it) and the caller's to free(). A folder, a missing or unreadable file is
 *  PBNDS_ERROR_IO; one too large is PBNDS_ERROR_MEMORY. */
enum pbnds_status pbnds_file_read(const char *path, size_t max_bytes, uint8_t **data,
                                  size_t *size,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

/** The same from a descriptor that is open for reading and stays the caller's; `name`
 *  is for messages. */
enum pbnds_status pbnds_file_read_open(int fd, const char *name, size_t max_bytes,
                                       uint8_t **data, size_t *size,
                                       struct pbnds_error *error) PBNDS_NODISCARD;

/** A file being written under a temporary name in the folder of its final one. */
struct pbnds_file_writer {
    char *path; /**< final name, owned      */
    char *temp; /**< temporary name, owned; third-party writers may open it by name */
};

/** Creates the temporary file (empty). Fails early where the folder cannot be written. */
enum pbnds_status pbnds_file_begin(struct pbnds_file_writer *w, const char *path,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
/** Syncs the temporary file (unless told not to) and renames it to its final name. On failure it is removed.
 *  The writer is empty afterwards. */
enum pbnds_status pbnds_file_commit(struct pbnds_file_writer *w,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** Whether commit waits until the disk has the file, for this thread; it does unless told
 *  otherwise. For who writes many files and syncs them together: each wait costs a turn of
 *  the disk. @return what was the case before */
bool pbnds_file_set_sync(bool on);
/** Removes the temporary file. Safe on an empty (zeroed) or committed writer. */
void pbnds_file_abort(struct pbnds_file_writer *w);

/** begin + write + commit. */
enum pbnds_status pbnds_file_write(const char *path, const void *data, size_t size,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

/** mkdir -p. */
enum pbnds_status pbnds_make_folder(const char *path,
                                    struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_CORE_FILE_H */
