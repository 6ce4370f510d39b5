/**
 * @file store_tar.h
 * Writes tar files through libarchive (the only file that includes it): ustar, every member
 * with the same owner, mode and time, so that the bytes are a pure function of names and
 * contents.
 */
#ifndef PBNDS_NEURAL_DATA_STORE_TAR_H
#define PBNDS_NEURAL_DATA_STORE_TAR_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/error.h"

struct pbnds_tar_writer;

#ifdef __cplusplus
extern "C" {
#endif

/** Writes into a file that is made or emptied; it is no data set's before the caller
 *  renames it. */
enum pbnds_status pbnds_tar_writer_open(const char *path,
                                        struct pbnds_tar_writer **writer,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
enum pbnds_status pbnds_tar_writer_add(struct pbnds_tar_writer *writer,
                                       const char *name, const void *bytes, size_t size,
                                       struct pbnds_error *error) PBNDS_NODISCARD;
/** Ends the file, syncs it if asked to and closes it; the writer is gone in any case. */
enum pbnds_status pbnds_tar_writer_close(struct pbnds_tar_writer *writer, bool sync,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
/** Gives up: the file is left as it is. */
void pbnds_tar_writer_abort(struct pbnds_tar_writer *writer);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_STORE_TAR_H */
