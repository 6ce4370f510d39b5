/**
 * @file pathtrace.h
 * The reference: a unidirectional path tracer on the scene, with next-event estimation of
 * the light map, MIS (balance heuristic) and Russian roulette. Same primary hits as the
 * G-buffer (pixel centres), so that images can be compared pixel by pixel.
 */
#ifndef PBNDS_ENGINE_SHADE_PATHTRACE_H
#define PBNDS_ENGINE_SHADE_PATHTRACE_H

#include "engine/shade/shader.h"

struct pbnds_pathtrace_options {
    int spp;
    int max_bounces; /**< surface interactions after the primary hit; 0 means the default 8 */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Fills radiance (all light) and, where not NULL, direct (light that reached the primary
 *  hit without another surface, plus its emission). Both are allocated here, 3-channel.
 *  job->spp is ignored. Errors: ARGUMENT (no scene), MEMORY, INTERRUPTED. */
enum pbnds_status pbnds_pathtrace(const struct pbnds_shade_job *job,
                                  const struct pbnds_pathtrace_options *options,
                                  struct pbnds_image *radiance, struct pbnds_image *direct,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_PATHTRACE_H */
