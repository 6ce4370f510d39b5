/**
 * @file store_manifest.h
 * manifest.json: what a complete data set holds.
 *
 *     {"hash": xxh64 of all that follows this line,
 *     "dataset": xxh64 of dataset.json,
 *     "samples": [
 *     {"split": "train", "index": 0, "files": {FILE: {"bytes": N, "xxh64": H}, ...}},
 *     ...],
 *     "quarantined": [
 *     {"split": "train", "index": 7, "reason": TEXT},
 *     ...]}
 *
 * in the order of splits and indices, so that its bytes are the same whoever writes it, for
 * folders and for tar files (where FILE of sample 3 is the member 000003.FILE).
 */
#ifndef PBNDS_NEURAL_DATA_STORE_MANIFEST_H
#define PBNDS_NEURAL_DATA_STORE_MANIFEST_H

#include <cjson/cJSON.h>
#include <stddef.h>

#include "engine/core/error.h"
#include "neural/data/recipe.h"

struct pbnds_manifest;

#ifdef __cplusplus
extern "C" {
#endif

/** Errors: IO, MEMORY. */
enum pbnds_status pbnds_manifest_begin(const char *dir,
                                       struct pbnds_manifest **manifest,
                                       struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_manifest_free(struct pbnds_manifest *manifest);
/** A sample by its sample.json, which says the hashes of the others; one that does not is
 *  read whole. `path` as for pbnds_store_read(). Errors: IO, FORMAT, MEMORY. */
enum pbnds_status pbnds_manifest_sample(struct pbnds_manifest *manifest,
                                        enum pbnds_split split, int index,
                                        const char *path,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
/** `path`: its file in DIR/quarantine. */
enum pbnds_status pbnds_manifest_quarantined(struct pbnds_manifest *manifest,
                                             const char *path,
                                             struct pbnds_error *error) PBNDS_NODISCARD;
/** Writes DIR/manifest.json, unless it is there with these bytes. */
enum pbnds_status pbnds_manifest_write(struct pbnds_manifest *manifest, const char *dir,
                                       struct pbnds_error *error) PBNDS_NODISCARD;

/** Reads DIR/manifest.json and holds it against its own hash. Errors: IO, FORMAT. */
enum pbnds_status pbnds_manifest_read(const char *dir, cJSON **json,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

/** Adds NAME: {"bytes": ..., "xxh64": ...} of a file's bytes. */
void pbnds_manifest_file(cJSON *files, const char *name, const void *bytes,
                         size_t size);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_STORE_MANIFEST_H */
