/** @file brdf.h  What sampling a BRDF gives. */
#ifndef PBNDS_ENGINE_SHADE_BRDF_H
#define PBNDS_ENGINE_SHADE_BRDF_H

#include "engine/core/vec.h"

struct pbnds_brdf_sample {
    struct pbnds_vec3 wi; /**< unit, away from the surface          */
    struct pbnds_vec3 f;  /**< value of the BRDF, 1/sr, no cosine   */
    float pdf;            /**< density of wi, 1/sr                  */
};

#endif /* PBNDS_ENGINE_SHADE_BRDF_H */
