/**
 * @file store_read.h
 * A sample's files as bytes, from its folder or from the tar that holds it.
 */
#ifndef PBNDS_NEURAL_DATA_STORE_READ_H
#define PBNDS_NEURAL_DATA_STORE_READ_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"
#include "neural/data/store_path.h"

/** Bytes of one file, malloc'd; `name` is where they came from, for messages. */
struct pbnds_store_bytes {
    uint8_t *data;
    size_t size;
    char name[PBNDS_STORE_PATH_MAX];
};

#ifdef __cplusplus
extern "C" {
#endif

/** `path`: a folder, or TAR#KEY with the hint @OFFSET or without it. Errors: IO, FORMAT,
 *  MEMORY. */
enum pbnds_status pbnds_store_read(const char *path, const char *file,
                                   struct pbnds_store_bytes *bytes,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
/** Is there such a file? */
bool pbnds_store_holds(const char *path, const char *file);
/** Names of the sample's files, by strcmp. */
enum pbnds_status pbnds_store_files(const char *path, struct pbnds_store_names *names,
                                    struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_STORE_READ_H */
