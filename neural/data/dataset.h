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

/** Which of the samples this process makes: those whose number modulo count is index. */
struct pbnds_dataset_shard {
    int index, count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Makes the data set, or what is missing of it: samples that are there are kept, so a
 *  killed run goes on where it stopped. `shard` NULL: all of it. A sample whose asset or
 *  light map cannot be read is left out with a warning that says why. */
enum pbnds_status pbnds_dataset_make(const struct pbnds_dataset_recipe *recipe,
                                     const struct pbnds_dataset_shard *shard,
                                     const char *dir, const struct pbnds_report *report,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DATASET_H */
