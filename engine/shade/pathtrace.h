/**
 * @file pathtrace.h
 * The reference: a unidirectional path tracer on the scene; what a path is stands in
 * path.h. This file makes pictures of paths: where they start, how many, how noisy.
 *
 * Start. A point-sampled G-buffer gives the first surfaces, so that images can be compared
 * pixel by pixel. Two cases need a camera ray a sample instead: an anti-aliased G-buffer
 * (samples > 1; the ray goes through a random point of the pixel, box filter), and a pixel
 * whose first surface blends (the ray goes through the centre and meets layers by chance).
 * The share of these rays that hit something is then the pixel's own coverage, see
 * pbnds_shade_job.alpha.
 *
 * Numbers. Sample s of a pixel is point s of one Owen-scrambled sequence. Blocks of 2^k
 * consecutive samples are nets of their own (sampler.h), and the samples are summed block
 * by block: k is the greatest with 8 blocks and at most 32 samples in each. One seed gives
 * one picture, whatever else is asked for.
 *
 * Variance. With m_b the block means, n_b their sizes, m the mean and N the samples,
 *
 *     var = sum_b n_b (m_b - m)^2 / (B - 1) / N
 *
 * which is the variance of the mean if blocks were independent. They are better than that:
 * the blocks of one sequence fill each other's gaps, so this is an estimate from above. It
 * is that of radiance * coverage, what the pixel receives. Fewer than two blocks tell
 * nothing: with one sample there is no variance image.
 *
 * Noise. With means over the channels of all pixels that something covers,
 *
 *     noise = sqrt(mean(var)) / mean(radiance * coverage)
 *
 * the error of the picture that is to be expected (root mean square) over its mean. The
 * mean of the roots would be less: where light is rare, most pixels have not met it yet
 * and do not know of it; those that have speak for them here. Asked for (job->noise > 0),
 * it is looked at after each block from the eighth on, and the picture is done when it is
 * below. The samples are then those of a picture of `spp`, broken off: a target that is
 * never reached gives the picture without one.
 */
#ifndef PBNDS_ENGINE_SHADE_PATHTRACE_H
#define PBNDS_ENGINE_SHADE_PATHTRACE_H

#include "engine/shade/shader.h"

struct pbnds_pathtrace_options {
    int spp; /**< samples a pixel, at most with job->noise; 0: 256, 4096 with it */
    int max_bounces; /**< surface interactions after the primary hit; 0: the default 8   */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Fills radiance (all light) and, where not NULL, direct (light that reached the primary
 *  hit without another surface, plus its emission: no light of emitting surfaces). Both
 *  are allocated here, 3-channel; so are job->variance, job->alpha, and job->taken is
 *  set, where given. job->spp is ignored.
 *  Errors: ARGUMENT (no scene), MEMORY, INTERRUPTED. */
enum pbnds_status pbnds_pathtrace(const struct pbnds_shade_job *job,
                                  const struct pbnds_pathtrace_options *options,
                                  struct pbnds_image *radiance,
                                  struct pbnds_image *direct,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_PATHTRACE_H */
