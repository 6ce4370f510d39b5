/**
 * @file pathtrace_olat.h
 * One light at a time: K pictures by the reference, each under one directional light of
 * irradiance 1 W m^-2 on a plane that faces it, and nothing else. Light adds up, so the
 * picture under lights of irradiances E_k is sum_k E_k times picture k. Emission is in none
 * of them.
 *
 * The K pictures share their paths (path.h): at each surface the path asks all K lights, by
 * a shadow ray to each that is above it, and goes on in one direction. So a pass costs
 * less than K renders, and what differs between two of its pictures is the light alone.
 * Surfaces, roulette, bounces and transparency by chance are those of the reference, and so
 * is the mean; the first surface, where it is that of the G-buffer and nothing blends, asks
 * its lights once for all samples, as the answer is always the same.
 *
 * The variance of a picture is estimated from its blocks of samples as that of the
 * reference (pathtrace.h), of radiance itself: coverage plays no part.
 */
#ifndef PBNDS_ENGINE_SHADE_PATHTRACE_OLAT_H
#define PBNDS_ENGINE_SHADE_PATHTRACE_OLAT_H

#include "engine/shade/pathtrace.h"

enum { PBNDS_OLAT_LIGHTS = 32 };

#ifdef __cplusplus
extern "C" {
#endif

/** Fills radiance[count] (allocated here, 3-channel; of what covers the pixel, as the
 *  reference's) and, where not NULL and of more than one sample, variance[count] (likewise;
 *  else emptied). wi[count]: unit, to the light, world. The job's light map, lights, noise
 *  and outputs other than the progress are not looked at.
 *  Errors: ARGUMENT (no scene; count beyond [1, PBNDS_OLAT_LIGHTS]), MEMORY, INTERRUPTED;
 *  nothing is left allocated then. */
enum pbnds_status pbnds_pathtrace_olat(const struct pbnds_shade_job *job,
                                       const struct pbnds_pathtrace_options *options,
                                       const struct pbnds_vec3 *wi, int count,
                                       struct pbnds_image *radiance,
                                       struct pbnds_image *variance,
                                       struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_PATHTRACE_OLAT_H */
