/**
 * @file flip_naive.h
 * LDR-FLIP as the paper's text has it, one step after the other, in double precision,
 * with two-dimensional kernels and nothing shared with neural/metrics. For small
 * images.
 */
#ifndef PBNDS_TESTS_REFERENCE_FLIP_NAIVE_H
#define PBNDS_TESTS_REFERENCE_FLIP_NAIVE_H

#include <math.h>
#include <stdlib.h>

#define FLIP_NAIVE_PPD 67.0
#define FLIP_NAIVE_PI  3.141592653589793

struct flip_color {
    double v[3];
};

/* The matrix of Rec. 709 with D65 as published to eight digits. */
static inline struct flip_color flip_xyz(struct flip_color c)
{
    const double r = c.v[0], g = c.v[1], b = c.v[2];
    const struct flip_color xyz = {{0.41238656 * r + 0.35759149 * g + 0.18045049 * b,
                                    0.21263682 * r + 0.71518298 * g + 0.07218020 * b,
                                    0.01933062 * r + 0.11919716 * g + 0.95037259 * b}};
    return xyz;
}

/* Cramer's rule on the three columns of flip_xyz(). */
static inline struct flip_color flip_linear(struct flip_color xyz)
{
    struct flip_color column[3], out;
    for (int i = 0; i < 3; ++i) {
        struct flip_color unit = {{0.0, 0.0, 0.0}};
        unit.v[i] = 1.0;
        column[i] = flip_xyz(unit);
    }
    double det[4];
    for (int k = 0; k < 4; ++k) {
        const double *a = k == 1 ? xyz.v : column[0].v;
        const double *b = k == 2 ? xyz.v : column[1].v;
        const double *c = k == 3 ? xyz.v : column[2].v;
        det[k] = a[0] * (b[1] * c[2] - b[2] * c[1]) -
                 b[0] * (a[1] * c[2] - a[2] * c[1]) +
                 c[0] * (a[1] * b[2] - a[2] * b[1]);
    }
    for (int i = 0; i < 3; ++i)
        out.v[i] = det[i + 1] / det[0];
    return out;
}

static inline struct flip_color flip_white(void)
{
    const struct flip_color one = {{1.0, 1.0, 1.0}};
    return flip_xyz(one);
}

static inline double flip_srgb_to_linear(double s)
{
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

static inline struct flip_color flip_ycxcz(struct flip_color linear)
{
    const struct flip_color w = flip_white(), t = flip_xyz(linear);
    const double x = t.v[0] / w.v[0], y = t.v[1] / w.v[1], z = t.v[2] / w.v[2];
    const struct flip_color out = {
        {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)}};
    return out;
}

static inline struct flip_color flip_from_ycxcz(struct flip_color c)
{
    const struct flip_color w = flip_white();
    const double y = (c.v[0] + 16.0) / 116.0;
    const struct flip_color xyz = {
        {(c.v[1] / 500.0 + y) * w.v[0], y * w.v[1], (y - c.v[2] / 200.0) * w.v[2]}};
    return flip_linear(xyz);
}

static inline double flip_lab_f(double t)
{
    const double delta = 6.0 / 29.0;
    return t > delta * delta * delta ? cbrt(t) : t / (3.0 * delta * delta) + 4.0 / 29.0;
}

static inline struct flip_color flip_hunt_lab(struct flip_color linear)
{
    const struct flip_color w = flip_white(), t = flip_xyz(linear);
    const double fx = flip_lab_f(t.v[0] / w.v[0]), fy = flip_lab_f(t.v[1] / w.v[1]);
    const double fz = flip_lab_f(t.v[2] / w.v[2]);
    const double l = 116.0 * fy - 16.0;
    const struct flip_color out = {
        {l, 0.01 * l * 500.0 * (fx - fy), 0.01 * l * 200.0 * (fy - fz)}};
    return out;
}

static inline double flip_hyab(struct flip_color a, struct flip_color b)
{
    return fabs(a.v[0] - b.v[0]) + hypot(a.v[1] - b.v[1], a.v[2] - b.v[2]);
}

static inline int flip_clamped(int i, int n)
{
    return i < 0 ? 0 : i < n ? i : n - 1;
}

/* kernel: (2 radius + 1)^2 weights */
static inline double flip_apply(const double *kernel, int radius, const double *plane,
                                int w, int h, int x, int y)
{
    double sum = 0.0;
    for (int j = -radius; j <= radius; ++j)
        for (int i = -radius; i <= radius; ++i)
            sum += kernel[(j + radius) * (2 * radius + 1) + i + radius] *
                   plane[flip_clamped(y + j, h) * w + flip_clamped(x + i, w)];
    return sum;
}

static inline int flip_csf_kernel(int channel, double *kernel)
{
    static const double a1[3] = {1.0, 1.0, 34.1}, b1[3] = {0.0047, 0.0053, 0.04};
    static const double a2[3] = {0.0, 0.0, 13.5}, b2[3] = {1e-5, 1e-5, 0.025};
    const double pi = FLIP_NAIVE_PI;
    const int r = (int)ceil(3.0 * sqrt(0.04 / (2.0 * pi * pi)) * FLIP_NAIVE_PPD);
    const int c = channel, n = 2 * r + 1;
    double total = 0.0;
    for (int i = 0; i < n * n; ++i) {
        const double x = (i % n - r) / FLIP_NAIVE_PPD, y = (i / n - r) / FLIP_NAIVE_PPD;
        const double d2 = x * x + y * y;
        kernel[i] = a1[c] * sqrt(pi / b1[c]) * exp(-pi * pi * d2 / b1[c]) +
                    a2[c] * sqrt(pi / b2[c]) * exp(-pi * pi * d2 / b2[c]);
        total += kernel[i];
    }
    for (int i = 0; i < n * n; ++i)
        kernel[i] /= total;
    return r;
}

/* Derivative along x, or along y when transposed. */
static inline int flip_feature_kernel(int point, int transposed, double *kernel)
{
    const double sd = 0.5 * 0.082 * FLIP_NAIVE_PPD;
    const int r = (int)ceil(3.0 * sd), n = 2 * r + 1;
    double positive = 0.0, negative = 0.0;
    for (int i = 0; i < n * n; ++i) {
        const double x = transposed ? i / n - r : i % n - r;
        const double y = transposed ? i % n - r : i / n - r;
        const double g = exp(-(x * x + y * y) / (2.0 * sd * sd));
        kernel[i] = point ? (x * x / (sd * sd) - 1.0) * g : -x * g;
        if (kernel[i] > 0.0) positive += kernel[i];
        if (kernel[i] < 0.0) negative -= kernel[i];
    }
    for (int i = 0; i < n * n; ++i)
        kernel[i] /= kernel[i] > 0.0 ? positive : negative;
    return r;
}

/* Everything about one image: Hunt-adjusted Lab after filtering, edge and point
 * strength. */
static inline void flip_prepare(const float *image, int w, int h,
                                struct flip_color *lab, double *edge, double *point)
{
    static double kernel[64 * 64];
    double *plane = malloc(4 * (size_t)(w * h) * sizeof *plane);
    double *luminance = plane ? plane + 3 * w * h : NULL;
    if (!plane) abort();
    for (int i = 0; i < w * h; ++i) {
        struct flip_color c;
        for (int k = 0; k < 3; ++k)
            c.v[k] = flip_srgb_to_linear((double)image[3 * i + k]);
        c = flip_ycxcz(c);
        for (int k = 0; k < 3; ++k)
            plane[k * w * h + i] = c.v[k];
        luminance[i] = (c.v[0] + 16.0) / 116.0;
    }
    for (int k = 0; k < 3; ++k) {
        const int r = flip_csf_kernel(k, kernel);
        for (int i = 0; i < w * h; ++i)
            lab[i].v[k] = flip_apply(kernel, r, plane + k * w * h, w, h, i % w, i / w);
    }
    for (int i = 0; i < w * h; ++i) {
        struct flip_color c = flip_from_ycxcz(lab[i]);
        for (int k = 0; k < 3; ++k)
            c.v[k] = fmin(fmax(c.v[k], 0.0), 1.0);
        lab[i] = flip_hunt_lab(c);
        edge[i] = point[i] = 0.0;
    }
    for (int k = 0; k < 4; ++k) {
        const int r = flip_feature_kernel(k / 2, k % 2, kernel);
        double *out = k / 2 ? point : edge;
        for (int i = 0; i < w * h; ++i)
            out[i] =
                hypot(out[i], flip_apply(kernel, r, luminance, w, h, i % w, i / w));
    }
    free(plane);
}

static inline double flip_color_error(struct flip_color a, struct flip_color b)
{
    const struct flip_color green = {{0.0, 1.0, 0.0}}, blue = {{0.0, 0.0, 1.0}};
    const double cmax = pow(flip_hyab(flip_hunt_lab(green), flip_hunt_lab(blue)), 0.7);
    const double d = pow(flip_hyab(a, b), 0.7), knee = 0.4 * cmax;
    return d < knee ? 0.95 / knee * d : 0.95 + (d - knee) / (cmax - knee) * 0.05;
}

/* map: w * h errors */
static inline void flip_naive(const float *test, const float *reference, int w, int h,
                              double *map)
{
    const size_t n = (size_t)(w * h);
    struct flip_color *lab = malloc(2 * n * sizeof *lab);
    double *feature = malloc(4 * n * sizeof *feature);
    if (!lab || !feature) abort();
    flip_prepare(test, w, h, lab, feature, feature + n);
    flip_prepare(reference, w, h, lab + n, feature + 2 * n, feature + 3 * n);
    for (size_t i = 0; i < n; ++i) {
        const double edge = fabs(feature[i] - feature[2 * n + i]);
        const double point = fabs(feature[n + i] - feature[3 * n + i]);
        const double f = fmin(pow(fmax(edge, point) / sqrt(2.0), 0.5), 1.0);
        map[i] = pow(flip_color_error(lab[i], lab[n + i]), 1.0 - f);
    }
    free(lab);
    free(feature);
}

#endif
