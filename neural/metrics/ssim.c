/* SSIM: Wang, Bovik, Sheikh and Simoncelli 2004, "Image Quality Assessment: From Error
   Visibility to Structural Similarity", eq. 13, with their 11 x 11 Gaussian of
   deviation 1.5, K1 = 0.01, K2 = 0.03 and L = 1. Moments are population ones, borders
   are mirrored about the outermost pixel edge, and each channel counts alike. */
#include <math.h>
#include <stdlib.h>

#include "engine/core/parallel.h"
#include "engine/core/report.h"
#include "neural/metrics/metrics.h"

enum { RADIUS = 5, TAPS = 2 * RADIUS + 1 };
enum { MEAN_A, MEAN_B, SQUARE_A, SQUARE_B, PRODUCT, MOMENTS };

/* Per row: the moments of its pixels filtered along the row, then its sum of SSIM. */
struct ssim {
    const struct pbnds_image *a, *b;
    const float *mask;
    int channel;
    double weight[TAPS];
    double *across;  /* MOMENTS planes            */
    double *row_sum; /* one a row, over channels  */
};

/* ... 2 1 0 | 0 1 2 ... n-1 | n-1 n-2 ..., for any distance */
static int mirror(int i, int n)
{
    const int period = 2 * n;
    const int j = ((i % period) + period) % period;
    return j < n ? j : period - 1 - j;
}

static int counts(const float *mask, size_t i)
{
    return !mask || mask[i] > 0.0f;
}

static void pass_across(void *context, size_t y, int thread)
{
    const struct ssim *s = context;
    (void)thread;
    const int w = s->a->width, channels = s->a->channels;
    const size_t row = y * (size_t)w, plane = (size_t)w * (size_t)s->a->height;
    for (int x = 0; x < w; ++x) {
        double moment[MOMENTS] = {0.0, 0.0, 0.0, 0.0, 0.0};
        for (int t = 0; t < TAPS; ++t) {
            const int at = x + t - RADIUS;
            const size_t i = row + (size_t)(at >= 0 && at < w ? at : mirror(at, w));
            if (!counts(s->mask, i)) continue; /* both black: all moments are 0 */
            const size_t k = i * (size_t)channels + (size_t)s->channel;
            const double a = (double)s->a->data[k], b = (double)s->b->data[k];
            moment[MEAN_A] += s->weight[t] * a;
            moment[MEAN_B] += s->weight[t] * b;
            moment[SQUARE_A] += s->weight[t] * a * a;
            moment[SQUARE_B] += s->weight[t] * b * b;
            moment[PRODUCT] += s->weight[t] * a * b;
        }
        for (int m = 0; m < MOMENTS; ++m)
            s->across[(size_t)m * plane + row + (size_t)x] = moment[m];
    }
}

static double similarity(const double moment[MOMENTS])
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const double mean_product = moment[MEAN_A] * moment[MEAN_B];
    const double mean_squares =
        moment[MEAN_A] * moment[MEAN_A] + moment[MEAN_B] * moment[MEAN_B];
    const double covariance = moment[PRODUCT] - mean_product;
    const double variances = moment[SQUARE_A] + moment[SQUARE_B] - mean_squares;
    return (2.0 * mean_product + c1) * (2.0 * covariance + c2) /
           ((mean_squares + c1) * (variances + c2));
}

static void pass_down(void *context, size_t y, int thread)
{
    struct ssim *s = context;
    (void)thread;
    const int w = s->a->width, h = s->a->height;
    const size_t plane = (size_t)w * (size_t)h;
    size_t rows[TAPS];
    for (int t = 0; t < TAPS; ++t)
        rows[t] = (size_t)mirror((int)y + t - RADIUS, h) * (size_t)w;
    for (int x = 0; x < w; ++x) {
        if (!counts(s->mask, y * (size_t)w + (size_t)x)) continue;
        double moment[MOMENTS];
        for (int m = 0; m < MOMENTS; ++m) {
            const double *source = s->across + (size_t)m * plane + (size_t)x;
            moment[m] = 0.0;
            for (int t = 0; t < TAPS; ++t)
                moment[m] += s->weight[t] * source[rows[t]];
        }
        s->row_sum[y] += similarity(moment);
    }
}

double pbnds_ssim(const struct pbnds_image *a, const struct pbnds_image *b,
                  const float *mask)
{
    if (!a->data || !b->data || a->width != b->width || a->height != b->height ||
        a->channels != b->channels)
        return (double)NAN;
    const size_t h = (size_t)a->height, n = h * (size_t)a->width;
    struct ssim s = {.a = a, .b = b, .mask = mask};
    double *block = calloc(MOMENTS * n + h, sizeof *block);
    if (!block) return (double)NAN;
    s.across = block;
    s.row_sum = block + MOMENTS * n;
    double total = 0.0;
    for (int t = 0; t < TAPS; ++t) {
        const double x = (double)(t - RADIUS) / 1.5;
        s.weight[t] = exp(-0.5 * x * x);
        total += s.weight[t];
    }
    for (int t = 0; t < TAPS; ++t)
        s.weight[t] /= total;
    for (s.channel = 0; s.channel < a->channels; ++s.channel) {
        pbnds_parallel_for(h, pass_across, &s);
        pbnds_parallel_for(h, pass_down, &s);
    }
    double sum = 0.0;
    size_t counted = 0;
    for (size_t y = 0; y < h; ++y)
        sum += s.row_sum[y];
    for (size_t i = 0; i < n; ++i)
        counted += counts(mask, i) ? 1 : 0;
    free(block);
    if (counted == 0 || pbnds_stop_requested()) return (double)NAN;
    return sum / ((double)counted * (double)a->channels);
}
