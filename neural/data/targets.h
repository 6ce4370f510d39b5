/**
 * @file targets.h
 * What is learned from: the path tracer's answers for a draw, beside its G-buffer. All
 * radiance is linear, W m^-2 sr^-1; planes are width * height, row 0 on top.
 */
#ifndef PBNDS_NEURAL_DATA_TARGETS_H
#define PBNDS_NEURAL_DATA_TARGETS_H

#include "engine/scene/envmap.h"
#include "engine/shade/gbuffer.h"
#include "neural/data/draw.h"

enum { PBNDS_DATASET_LIGHTS = 32 };

/** Owned; what the recipe does not ask for is empty. */
struct pbnds_targets {
    struct pbnds_gbuffer gbuffer;
    struct pbnds_image radiance; /**< all light                                       */
    struct pbnds_image direct;   /**< of it, what came from no other surface, and what
                                    the first one emits                              */
    uint32_t *visibility;        /**< bit i: cluster light i (envmap.h,
                                    PBNDS_DATASET_LIGHTS of the light) is seen      */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Errors: MEMORY, INTERRUPTED. */
enum pbnds_status pbnds_targets_render(const struct pbnds_dataset_recipe *recipe,
                                       const struct pbnds_draw *draw,
                                       struct pbnds_targets *targets,
                                       struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_targets_free(struct pbnds_targets *targets);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_TARGETS_H */
