/* All measures of one image against its reference, under one mask. */
#include "neural/metrics/metrics.h"

#include <math.h>
#include <string.h>

#include "engine/core/report.h"

static int counts(const float *mask, size_t i)
{
    return !mask || mask[i] > 0.0f;
}

static int same_shape(const struct pbnds_image *a, const struct pbnds_image *b)
{
    return a->data && b->data && a->channels == 3 && b->channels == 3 &&
           a->width == b->width && a->height == b->height;
}

static enum pbnds_status check_finite(const struct pbnds_image *image, const char *name,
                                      const float *mask, struct pbnds_error *error)
{
    const size_t w = (size_t)image->width, n = w * (size_t)image->height;
    for (size_t i = 0; i < n; ++i) {
        const float *p = image->data + 3 * i;
        if (!counts(mask, i) || (isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2])))
            continue;
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "metrics: pixel %zu, %zu of the %s is not a finite number; mask "
            "it out or mend the image",
            i % w, i / w, name);
    }
    return PBNDS_OK;
}

static enum pbnds_status check(const struct pbnds_image *const images[4],
                               const float *mask, size_t *counted,
                               struct pbnds_error *error)
{
    static const char *const names[4] = {"display image", "display reference",
                                         "linear image", "linear reference"};
    for (int i = 0; i < 4; ++i) {
        if (images[i] && same_shape(images[0], images[i])) continue;
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "metrics: the %s is not of 3 channels and the size of the "
                          "others; compare images of one size",
                          names[i]);
    }
    const size_t n = (size_t)images[0]->width * (size_t)images[0]->height;
    *counted = 0;
    for (size_t i = 0; i < n; ++i)
        *counted += counts(mask, i) ? 1 : 0;
    if (*counted == 0)
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "metrics: the mask counts no pixel; nothing to compare");
    for (int i = 0; i < 4; ++i)
        PBNDS_TRY(check_finite(images[i], names[i], mask, error));
    return PBNDS_OK;
}

/* Mean over counted pixels and channels of (a - b)^2, over b^2 + 0.01 when relative. */
static double mean_square_error(const struct pbnds_image *a,
                                const struct pbnds_image *b, const float *mask,
                                size_t counted, int relative)
{
    const size_t n = (size_t)a->width * (size_t)a->height;
    double sum = 0.0;
    for (size_t i = 0; i < n; ++i) {
        if (!counts(mask, i)) continue;
        for (size_t k = 3 * i; k < 3 * i + 3; ++k) {
            const double reference = (double)b->data[k];
            const double difference = (double)a->data[k] - reference;
            const double scale = relative ? reference * reference + 0.01 : 1.0;
            sum += difference * difference / scale;
        }
    }
    return sum / (3.0 * (double)counted);
}

/* A copy with the uncounted pixels black. */
static enum pbnds_status blacken(const struct pbnds_image *src, const float *mask,
                                 struct pbnds_image *dst, struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_image_init(dst, src->width, src->height, 3, error));
    const size_t n = (size_t)src->width * (size_t)src->height;
    for (size_t i = 0; i < n; ++i)
        if (counts(mask, i))
            memcpy(dst->data + 3 * i, src->data + 3 * i, 3 * sizeof *dst->data);
    return PBNDS_OK;
}

/* FLIP of the masked images; uncounted pixels of the map are 0. */
static enum pbnds_status masked_flip(const struct pbnds_image *test,
                                     const struct pbnds_image *reference,
                                     const float *mask, struct pbnds_image *map,
                                     struct pbnds_error *error)
{
    if (!mask) return pbnds_flip(test, reference, map, error);
    struct pbnds_image a = {0}, b = {0};
    enum pbnds_status status = blacken(test, mask, &a, error);
    if (status == PBNDS_OK) status = blacken(reference, mask, &b, error);
    if (status == PBNDS_OK) status = pbnds_flip(&a, &b, map, error);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    if (status != PBNDS_OK) return status;
    const size_t n = (size_t)map->width * (size_t)map->height;
    for (size_t i = 0; i < n; ++i)
        if (!counts(mask, i)) map->data[i] = 0.0f;
    return PBNDS_OK;
}

/* Sum over the whole map: uncounted pixels add 0. */
static double mean_of_map(const struct pbnds_image *map, size_t counted)
{
    const size_t n = (size_t)map->width * (size_t)map->height;
    double sum = 0.0;
    for (size_t i = 0; i < n; ++i)
        sum += (double)map->data[i];
    return sum / (double)counted;
}

enum pbnds_status pbnds_metrics_compare(
    const struct pbnds_image *display, const struct pbnds_image *display_reference,
    const struct pbnds_image *linear, const struct pbnds_image *linear_reference,
    const float *mask, struct pbnds_metrics *metrics, struct pbnds_image *flip_map,
    struct pbnds_error *error)
{
    const struct pbnds_image *const images[4] = {display, display_reference, linear,
                                                 linear_reference};
    struct pbnds_image map = {0};
    size_t counted;
    if (flip_map) *flip_map = map;
    PBNDS_TRY(check(images, mask, &counted, error));
    struct pbnds_metrics m;
    m.mse = mean_square_error(display, display_reference, mask, counted, 0);
    m.psnr = m.mse > 0.0 ? -10.0 * log10(m.mse) : (double)INFINITY;
    m.relmse = mean_square_error(linear, linear_reference, mask, counted, 1);
    m.ssim = pbnds_ssim(display, display_reference, mask);
    if (pbnds_stop_requested()) return pbnds_fail_interrupted(error);
    if (isnan(m.ssim))
        return pbnds_fail(
            error, PBNDS_ERROR_MEMORY,
            "metrics: no memory for SSIM of %d x %d pixels; compare smaller "
            "images",
            display->width, display->height);
    PBNDS_TRY(masked_flip(display, display_reference, mask, &map, error));
    m.flip = mean_of_map(&map, counted);
    *metrics = m;
    if (flip_map)
        *flip_map = map;
    else
        pbnds_image_free(&map);
    return PBNDS_OK;
}
