/**
 * @file estimate.h
 * What a data set will cost, from a few of its samples.
 *
 * The pilots are spread evenly over the samples. Each is made twice with few samples a
 * pixel, a and 2a: the time of a sample is then t(spp) = t(a) + (t(2a) - t(a)) (spp - a) / a,
 * since the path tracer's time goes with its samples and all else does not. Bytes are
 * those of the files that the second time wrote.
 */
#ifndef PBNDS_NEURAL_DATA_ESTIMATE_H
#define PBNDS_NEURAL_DATA_ESTIMATE_H

#include "engine/core/report.h"
#include "neural/data/recipe.h"

struct pbnds_dataset_cost {
    int count;           /**< samples of the whole data set                     */
    int pilots, failed;  /**< samples tried, and those of them that failed      */
    double core_seconds; /**< of all samples                                    */
    double core_error;   /**< its standard error, from the spread of the pilots */
    double bytes, bytes_error;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Works in a temporary folder below `scratch`, which is removed. Errors: as
 *  pbnds_dataset_make(); those of the first sample where no pilot could be made. */
enum pbnds_status pbnds_dataset_estimate(const struct pbnds_dataset_recipe *recipe,
                                         const char *scratch,
                                         const struct pbnds_report *report,
                                         struct pbnds_dataset_cost *cost,
                                         struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_ESTIMATE_H */
