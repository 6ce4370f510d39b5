/**
 * @file store_path.h
 * Names and small deeds in a data set's folder, for the store's own files.
 */
#ifndef PBNDS_NEURAL_DATA_STORE_PATH_H
#define PBNDS_NEURAL_DATA_STORE_PATH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"
#include "neural/data/recipe.h"

enum { PBNDS_STORE_DIR_MAX = 3900, PBNDS_STORE_PATH_MAX = 4096 };

enum pbnds_store_place {
    PBNDS_PLACE_FOLDER,     /**< DIR/train/000003                 */
    PBNDS_PLACE_STAGED,     /**< DIR/.work/train-000003           */
    PBNDS_PLACE_TEMP,       /**< DIR/.work/train-000003.tmp       */
    PBNDS_PLACE_QUARANTINE, /**< DIR/quarantine/train-000003.json */
    PBNDS_PLACE_TAR,        /**< DIR/train-000003.tar             */
    PBNDS_PLACE_TAR_TEMP,   /**< DIR/.work/train-000003.tar.tmp   */
};

/** Names of the files of a folder that do not begin with a dot, by strcmp. */
struct pbnds_store_names {
    char **items; /**< owned */
    int count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** `number` is the sample's index, or the tar's number. */
void pbnds_store_path(const char *dir, enum pbnds_store_place place,
                      enum pbnds_split split, int number,
                      char path[PBNDS_STORE_PATH_MAX]);
bool pbnds_store_exists(const char *path);
/** rm -rf; whatever is not there or cannot go is left. */
void pbnds_store_remove(const char *path);
/** Removes the temporary files that a kill left in a folder. */
void pbnds_store_sweep(const char *folder);
/** Makes the names in a folder outlive a power failure; where a file system knows no
 *  syncing of folders, that is its business. */
void pbnds_store_sync(const char *folder);
/** The same for the files in it. Errors: IO, MEMORY. */
enum pbnds_status pbnds_store_sync_files(const char *folder,
                                         struct pbnds_error *error) PBNDS_NODISCARD;

/** Errors: IO, MEMORY. */
enum pbnds_status pbnds_store_list(const char *folder, struct pbnds_store_names *names,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_store_names_free(struct pbnds_store_names *names);

/** xxh64, seed 0, as 16 hex digits: what `xxhsum -H1` prints. */
void pbnds_store_hash(const void *bytes, size_t size, char hash[17]);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_STORE_PATH_H */
