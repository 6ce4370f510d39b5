/**
 * @file dataset.h
 * Making data sets: samples of (G-buffer, light map, reference radiance) from glTF scenes,
 * procedural worlds and HDRIs.
 *
 *     recipe --assets--> draw (scene, camera, light) --> targets --> sample files --> store
 */
#ifndef PBNDS_NEURAL_DATA_DATASET_H
#define PBNDS_NEURAL_DATA_DATASET_H

#include "neural/data/sample.h"
#include "neural/data/store.h"

/** Which of the units (store.h) this process makes: those whose number modulo count is
 *  index. */
struct pbnds_dataset_shard {
    int index, count;
};

struct pbnds_dataset_options {
    struct pbnds_dataset_shard shard; /**< count 0: all                              */
    bool retry;                       /**< samples in quarantine are tried again     */
};

/** What came of the samples of a shard: total = made + kept + quarantined + failed + busy,
 *  unless the run was stopped. */
struct pbnds_dataset_summary {
    int total;
    int made;        /**< by this run                                                */
    int kept;        /**< were there                                                 */
    int quarantined; /**< cannot be made: their scene, light or camera; by this run or
                          an earlier one                                             */
    int failed;      /**< could not be written; a later run makes them               */
    int busy;        /**< another process is at them                                 */
    enum pbnds_status status; /**< of the first that this run quarantined or failed  */
    char reason[1024];        /**< likewise, a sentence                              */
    bool complete; /**< every sample of the data set, of all shards, is accounted for:
                        the manifest is written                                      */
    char hash[17]; /**< of the manifest                                              */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Makes the data set, or what is missing of it: samples that are there are kept, so a
 *  killed run goes on where it stopped. A sample that cannot be made (its asset or light
 *  map cannot be read, no camera sees enough, its light is not finite) is put into
 *  quarantine with a warning that says why, and the run goes on; so it does past samples
 *  that cannot be written, to the eighth in a row. `options`, `summary` may be NULL.
 *
 *  Errors: of the drawer; ARGUMENT (shard; another recipe's folder); of the first sample,
 *  where not one of a whole data set could be made; IO, where some could not be written;
 *  INTERRUPTED. The summary tells of what was done before. */
enum pbnds_status pbnds_dataset_make(const struct pbnds_dataset_recipe *recipe,
                                     const struct pbnds_dataset_options *options,
                                     const char *dir, const struct pbnds_report *report,
                                     struct pbnds_dataset_summary *summary,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DATASET_H */
