/**
 * @file metrics.h
 * How far an image is from its reference. Display metrics (mse, psnr, ssim, flip) take
 * display-encoded sRGB in [0, 1] (tonemap.h); relmse takes linear radiance.
 *
 * mask: width * height floats, pixels with mask > 0 count; NULL: all. Masked pixels are
 * excluded from means, never blended in; SSIM and FLIP are computed on the whole image with
 * the uncounted pixels of both set to black, then averaged over the counted.
 */
#ifndef PBNDS_NEURAL_METRICS_METRICS_H
#define PBNDS_NEURAL_METRICS_METRICS_H

#include "engine/image/image.h"

struct pbnds_metrics {
    double mse; /**< mean over counted pixels and channels, display sRGB              */
    double
        psnr; /**< 10 log10(1 / mse), dB; +inf for equal images                     */
    double
        ssim; /**< Wang et al. 2004: 11x11 Gaussian sigma 1.5, K1 .01, K2 .03, L 1, mean
                        over channels, reflected borders                                 */
    double
        flip; /**< LDR-FLIP, Andersson et al. 2020, 67 pixels a degree, mean        */
    double
        relmse; /**< mean of (a - b)^2 / (b^2 + 0.01) on linear radiance              */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Error images must have 3 channels and agree in size, else ARGUMENT; an image with a NaN or
 *  infinity in a counted pixel, or an empty mask, is FORMAT. flip_map (or NULL) receives a
 *  1-channel image, allocated here, 0 where the mask does not count. */
enum pbnds_status pbnds_metrics_compare(
    const struct pbnds_image *display, const struct pbnds_image *display_reference,
    const struct pbnds_image *linear, const struct pbnds_image *linear_reference,
    const float *mask, struct pbnds_metrics *metrics, struct pbnds_image *flip_map,
    struct pbnds_error *error) PBNDS_NODISCARD;
/** The parts, for tests and other callers. SSIM is NaN when shapes differ, nothing counts, memory
 *  is out or a stop was requested. */
double pbnds_ssim(const struct pbnds_image *a, const struct pbnds_image *b,
                  const float *mask);
enum pbnds_status pbnds_flip(const struct pbnds_image *test,
                             const struct pbnds_image *reference,
                             struct pbnds_image *map,
                             struct pbnds_error *error) PBNDS_NODISCARD;
/** Magma-like colour map (perceptually ordered black-violet-orange-cream) of a 1-channel
 *  image in [0, 1] to a 3-channel display image, allocated here. */
enum pbnds_status pbnds_colorize(const struct pbnds_image *map,
                                 struct pbnds_image *image,
                                 struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_METRICS_METRICS_H */
