/**
 * @file ggx_albedo.h
 * How much of the light a GGX lobe reflects at all (brdf_ggx.h: single scattering,
 * height-correlated Smith, Schlick), as a share of what arrives:
 *
 *     E(wo) = integral f_r(wo, wi) cos_i dwi = f0 A(cos_o, alpha) + f90 B(cos_o, alpha)
 *     E_avg = 2 integral E(mu) mu dmu        = f0 A_avg(alpha)    + f90 B_avg(alpha)
 *
 * because Schlick's F is linear in f0 and f90. A and B are a bilinear table over
 * alpha^(1/4) and cos^(1/4): both vary where alpha and the cosine are small. Against
 * E itself the interpolated f0 A + f90 B is off by 0.006 at most (alpha and cosine near
 * 0.001) and by 0.0004 (root of the mean square); E_avg is that of the interpolant, exactly. The table is printed by
 * its test (test_ggx_albedo --print), which also computes it anew and compares.
 *
 * Threads: pure functions, safe from any thread.
 */
#ifndef PBNDS_ENGINE_SHADE_GGX_ALBEDO_H
#define PBNDS_ENGINE_SHADE_GGX_ALBEDO_H

#include "engine/shade/brdf_ggx.h"

enum { PBNDS_GGX_ALBEDO_ROWS = 32, PBNDS_GGX_ALBEDO_COLUMNS = 48 };

/** E = f0 a + f90 b. */
struct pbnds_ggx_albedo {
    float a, b;
};

/** Where an alpha lies in the table; the same for all directions. */
struct pbnds_ggx_albedo_row {
    int row;    /**< [0, ROWS - 2]                 */
    float part; /**< [0, 1], from this row to next */
};

#ifdef __cplusplus
extern "C" {
#endif

/** alpha in [PBNDS_GGX_ALPHA_MIN, 1]; clamped to it. */
struct pbnds_ggx_albedo_row pbnds_ggx_albedo_row(float alpha);
/** A and B at a cosine in [0, 1]; clamped to it. */
struct pbnds_ggx_albedo pbnds_ggx_albedo(struct pbnds_ggx_albedo_row row, float cosine);
/** A_avg and B_avg. */
struct pbnds_ggx_albedo pbnds_ggx_albedo_mean(struct pbnds_ggx_albedo_row row);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_GGX_ALBEDO_H */
