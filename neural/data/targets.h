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

enum { PBNDS_DATASET_LIGHTS = 32, PBNDS_DATASET_OLAT = 32 };

/** One light at a time. */
struct pbnds_olat {
    int count;                                /**< of lights, to PBNDS_DATASET_OLAT  */
    struct pbnds_vec3 wi[PBNDS_DATASET_OLAT]; /**< unit, to the light, world         */
    struct pbnds_image *images; /**< radiance under each alone, E = 1 W m^-2; owned  */
    uint32_t *visibility;       /**< bit k: light k is seen; owned                   */
};

/** Owned; what the recipe does not ask for is empty. */
struct pbnds_targets {
    struct pbnds_image light; /**< the light map that lit the scene: the draw's, rounded
                                 to what the file holds                             */
    struct pbnds_gbuffer gbuffer;
    struct pbnds_image radiance; /**< all light                                       */
    struct pbnds_image direct;   /**< of it, what came from no other surface, and what
                                    the first one emits                              */
    struct pbnds_image variance; /**< of radiance, which is a mean (pathtrace.h), before
                                    it was denoised                                  */
    bool denoised;               /**< by atrous.h; never in the test split            */
    uint32_t *visibility;        /**< bit i: cluster light i (envmap.h,
                                    PBNDS_DATASET_LIGHTS of the light) is seen      */
    struct pbnds_olat olat;
    double path_seconds; /**< of the clock, in the path tracer; for those who want to
                            know the cost of the rest                                 */
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
void pbnds_olat_free(struct pbnds_olat *olat);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_TARGETS_H */
