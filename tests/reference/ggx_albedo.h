/* What the table of engine/shade/ggx_albedo.c holds, computed in double precision. */
#ifndef PBNDS_TESTS_REFERENCE_GGX_ALBEDO_H
#define PBNDS_TESTS_REFERENCE_GGX_ALBEDO_H

#include <math.h>

#include "engine/shade/ggx_albedo.h"

struct naive_albedo {
    double a, b;
};

/* alpha of row i and cosine of column j; both axes are fourth powers. */
static inline double naive_row_alpha(int i)
{
    const double first = pow((double)PBNDS_GGX_ALPHA_MIN, 0.25);
    const double x = first + (1.0 - first) * i / (PBNDS_GGX_ALBEDO_ROWS - 1.0);
    return x * x * x * x;
}

static inline double naive_column_cosine(int j)
{
    return pow(j / (PBNDS_GGX_ALBEDO_COLUMNS - 1.0), 4.0);
}

/* The mean of (1 - k) G2/G1 and k G2/G1, k = (1 - wo.h)^5, over the visible normals of wo
 * (Dupuy and Benyoub 2023), by the midpoint rule; the height goes by the smootherstep
 * 10 t^3 - 15 t^4 + 6 t^5, because the integrand has roots at both of its ends. The
 * azimuth is even, so half of it does. */
static inline struct naive_albedo naive_ggx_albedo(double mu, double a, int n)
{
    const double pi = acos(-1.0), s0 = sqrt(fmax(1.0 - mu * mu, 0.0));
    const double length = sqrt(a * a * s0 * s0 + mu * mu);
    const double vx = a * s0 / length, vz = mu / length;
    const double stretch_o = sqrt(a * a + (1.0 - a * a) * mu * mu);
    struct naive_albedo sum = {0.0, 0.0};
    for (int i = 0; i < n; ++i) {
        const double cos_phi = cos(pi * (i + 0.5) / n);
        const double sin_phi = sin(pi * (i + 0.5) / n);
        for (int j = 0; j < n; ++j) {
            const double t = (j + 0.5) / n;
            const double u = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
            const double weight = 30.0 * t * t * (1.0 - t) * (1.0 - t);
            const double z = (1.0 - u) * (1.0 + vz) - vz;
            const double s = sqrt(fmax(1.0 - z * z, 0.0));
            const double x = a * (vx + s * cos_phi), y = a * s * sin_phi;
            const double norm = sqrt(x * x + y * y + (vz + z) * (vz + z));
            const double cos_h = (vz + z) / norm, o_h = s0 * x / norm + mu * cos_h;
            const double cos_i = 2.0 * o_h * cos_h - mu;
            if (cos_i <= 0.0) continue;
            const double stretch_i = sqrt(a * a + (1.0 - a * a) * cos_i * cos_i);
            const double g = weight * cos_i * (mu + stretch_o) /
                             (mu * stretch_i + cos_i * stretch_o);
            const double m = fmax(1.0 - o_h, 0.0), k = m * m * m * m * m;
            sum.a += g * (1.0 - k);
            sum.b += g * k;
        }
    }
    const double count = (double)n * n;
    return (struct naive_albedo){sum.a / count, sum.b / count};
}

/* 2 integral E mu dmu of the table's own interpolant: with mu = t^4 that is
 * 8 integral E t^7 dt, and E is linear in t between the columns. */
static inline double naive_mean_weight(int j)
{
    const double h = 1.0 / (PBNDS_GGX_ALBEDO_COLUMNS - 1.0), t = j * h;
    double sum = 0.0;
    /* integral of s^7 (1 - |s - t| / h) from t - h to t, and from t to t + h */
    if (j > 0) {
        const double p = t - h, i8 = (pow(t, 8.0) - pow(p, 8.0)) / 8.0;
        sum += ((pow(t, 9.0) - pow(p, 9.0)) / 9.0 - p * i8) / h;
    }
    if (j < PBNDS_GGX_ALBEDO_COLUMNS - 1) {
        const double p = t + h, i8 = (pow(p, 8.0) - pow(t, 8.0)) / 8.0;
        sum += (p * i8 - (pow(p, 9.0) - pow(t, 9.0)) / 9.0) / h;
    }
    return 8.0 * sum;
}
#endif
