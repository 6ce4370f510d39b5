/**
 * @file store.h
 * A data set on disk, made exactly once: a sample is there whole or not at all, whatever
 * killed the run, and however many processes work on it.
 *
 *     DIR/dataset.json                  the claim: recipe; assets and light maps with
 *                                       split and hash
 *     DIR/manifest.json                 every file with its hash (store_manifest.h), once
 *                                       every sample is accounted for
 *     DIR/{train,val,test}/NNNNNN/      folders: a sample's files (sample.h)
 *     DIR/{train,val,test}-NNNNNN.tar   tar: `per_tar` samples, NNNNNN.FILE each
 *     DIR/quarantine/SPLIT-NNNNNN.json  why a sample cannot be made
 *     DIR/.work/                        what is being made; gone when all is there
 *
 * Units: what one process makes at a time is a sample (folders) or the samples of a tar. A
 * unit is locked (fcntl, a byte of dataset.json each), so that two runs over the same
 * folder share it and never meet. A sample is made in .work and renamed: into its place, or
 * to wait in .work for the others of its tar, which is written in .work too, synced and
 * renamed before they go. So a kill leaves a sample in .work or in the data set; what it
 * left in both, the next run removes from .work.
 */
#ifndef PBNDS_NEURAL_DATA_STORE_H
#define PBNDS_NEURAL_DATA_STORE_H

#include <cjson/cJSON.h>

#include "engine/core/report.h"
#include "neural/data/recipe.h"

struct pbnds_store;

/** Samples [first, end) of a split. */
struct pbnds_store_unit {
    enum pbnds_split split;
    int first, end;
};

enum pbnds_store_state {
    PBNDS_STORE_MISSING,
    PBNDS_STORE_THERE,
    PBNDS_STORE_QUARANTINED,
};

/** The samples of one split that are there, in index order. */
struct pbnds_sample_list {
    char **folders; /**< paths for pbnds_sample_load(); owned */
    int count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Opens DIR for writing, makes it where it is missing. `claim` becomes dataset.json; a
 *  DIR that holds another one is refused (ARGUMENT). */
enum pbnds_status pbnds_store_open(const char *dir,
                                   const struct pbnds_dataset_recipe *recipe,
                                   const int count[PBNDS_SPLIT_COUNT],
                                   const cJSON *claim, struct pbnds_store **store,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_store_free(struct pbnds_store *store);

/** Units, numbered through all splits. */
int pbnds_store_units(const struct pbnds_store *store);
struct pbnds_store_unit pbnds_store_unit(const struct pbnds_store *store, int number);

/** Begins the work on a unit; `busy`: another process is at it, leave it alone. Errors: IO,
 *  FORMAT (its tar is damaged), MEMORY. */
enum pbnds_status pbnds_store_enter(struct pbnds_store *store, int number, bool *busy,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** Of a sample of the unit entered. */
enum pbnds_store_state pbnds_store_state(const struct pbnds_store *store, int index);
/** An empty folder to write the sample's files into; its path is the store's until the
 *  next call. Whatever a kill left there is swept. */
enum pbnds_status pbnds_store_begin(struct pbnds_store *store, int index,
                                    const char **folder,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** Makes the sample begun last part of the data set. Its sample.json gets "files": bytes
 *  and xxh64 of each of the others. */
enum pbnds_status pbnds_store_commit(struct pbnds_store *store,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Leaves the sample begun last out; a later run makes it. */
void pbnds_store_abort(struct pbnds_store *store);
/** Leaves it out for good, with the reason. */
enum pbnds_status pbnds_store_quarantine(struct pbnds_store *store, const char *reason,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
/** Ends the work on the unit entered: its tar is written when its samples are accounted
 *  for. Errors: IO, MEMORY; nothing is lost then, and the next run goes on. */
enum pbnds_status pbnds_store_leave(struct pbnds_store *store,
                                    struct pbnds_error *error) PBNDS_NODISCARD;

/** Where every sample of the data set is there or quarantined: writes the manifest, removes
 *  what kills left; else says that it is not complete. Any number of processes may. */
enum pbnds_status pbnds_store_finish(struct pbnds_store *store, bool *complete,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Nothing was made: the claim goes, since mended assets make another recipe. */
void pbnds_store_abandon(struct pbnds_store *store);

/** Samples of a half-made data set are listed too. A path is that of a folder, or
 *  TAR#KEY@OFFSET. Errors: IO (no data set), FORMAT (a damaged tar), MEMORY. */
enum pbnds_status pbnds_dataset_list(const char *dir, enum pbnds_split split,
                                     struct pbnds_sample_list *list,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_sample_list_free(struct pbnds_sample_list *list);
/** The manifest's hash, 16 hex digits; of a half-made data set one of dataset.json and the
 *  names of its samples. */
enum pbnds_status pbnds_dataset_hash(const char *dir, char hash[17],
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_STORE_H */
