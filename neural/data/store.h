/**
 * @file store.h
 * A data set on disk, made exactly once: a sample is there whole or not at all, whatever
 * killed the run, and however many processes work on it.
 *
 *     DIR/dataset.json              recipe; assets and light maps with split and hash
 *     DIR/{train,val,test}/NNNNNN/  a sample's files (sample.h)
 *
 * A sample is written into a temporary folder and renamed.
 */
#ifndef PBNDS_NEURAL_DATA_STORE_H
#define PBNDS_NEURAL_DATA_STORE_H

#include <cjson/cJSON.h>

#include "engine/core/report.h"
#include "neural/data/recipe.h"

struct pbnds_store;

/** The samples of one split that are there, in index order. */
struct pbnds_sample_list {
    char **folders; /**< paths for pbnds_sample_load(); owned */
    int count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Opens DIR for writing, makes it where it is missing. `manifest` becomes dataset.json; a
 *  DIR that holds another one is refused (ARGUMENT). */
enum pbnds_status pbnds_store_open(const char *dir,
                                   const struct pbnds_dataset_recipe *recipe,
                                   const cJSON *manifest, struct pbnds_store **store,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_store_free(struct pbnds_store *store);

bool pbnds_store_has(const struct pbnds_store *store, enum pbnds_split split,
                     int index);
/** An empty folder to write the sample's files into; its path is the store's until the
 *  next call. Whatever a kill left there is swept. */
enum pbnds_status pbnds_store_begin(struct pbnds_store *store, enum pbnds_split split,
                                    int index, const char **folder,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** Makes the sample begun last part of the data set. */
enum pbnds_status pbnds_store_commit(struct pbnds_store *store,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Leaves the sample begun last out. */
void pbnds_store_abort(struct pbnds_store *store);
/** Nothing was made: the manifest goes, since mended assets make another recipe. */
void pbnds_store_abandon(struct pbnds_store *store);

enum pbnds_status pbnds_dataset_list(const char *dir, enum pbnds_split split,
                                     struct pbnds_sample_list *list,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_sample_list_free(struct pbnds_sample_list *list);
/** Hash of the data set's manifest and the names of its samples, 16 hex digits. */
enum pbnds_status pbnds_dataset_hash(const char *dir, char hash[17],
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_STORE_H */
