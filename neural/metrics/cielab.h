/**
 * @file cielab.h
 * CIE colour spaces for the measures, relative to the white of Rec. 709 (D65).
 */
#ifndef PBNDS_NEURAL_METRICS_CIELAB_H
#define PBNDS_NEURAL_METRICS_CIELAB_H

#include <math.h>

/** Linear Rec. 709 to XYZ over the XYZ of white: exact rationals of the primaries and
 * of D65 = (0.3127, 0.3290); each row sums to 1. */
static const double PBNDS_XYZ_FROM_RGB[3][3] = {
    {10135552.0 / 23359437.0, 8788810.0 / 23359437.0, 4435075.0 / 23359437.0},
    {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
    {1425312.0 / 80288307.0, 8788810.0 / 80288307.0, 70074185.0 / 80288307.0},
};

/** The inverse of PBNDS_XYZ_FROM_RGB, by cofactors. */
static inline void pbnds_rgb_from_xyz(double out[3][3])
{
    const double(*m)[3] = PBNDS_XYZ_FROM_RGB;
    double det = 0.0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int r0 = (j + 1) % 3, r1 = (j + 2) % 3;
            const int c0 = (i + 1) % 3, c1 = (i + 2) % 3;
            out[i][j] = m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0];
        }
    for (int i = 0; i < 3; ++i)
        det += m[0][i] * out[i][0];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            out[i][j] /= det;
}

/** CIE 15:2004: the cube root with its linear toe below (6/29)^3. */
static inline float pbnds_lab_root(float t)
{
    return t > 216.0f / 24389.0f ? cbrtf(t) : t * (841.0f / 108.0f) + 4.0f / 29.0f;
}

#endif /* PBNDS_NEURAL_METRICS_CIELAB_H */
