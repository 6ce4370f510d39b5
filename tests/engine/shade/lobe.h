/* Measures of any BRDF over the hemisphere of +z, for the tests of the BRDFs. */
#ifndef PBNDS_TESTS_ENGINE_SHADE_LOBE_H
#define PBNDS_TESTS_ENGINE_SHADE_LOBE_H

#include <stdbool.h>
#include <string.h>

#include "engine/core/rng.h"
#include "engine/shade/brdf.h"
#include "tests/test.h"

/* A BRDF behind three functions; the surface's normal is `n`. */
struct lobe {
    const void *brdf;
    struct pbnds_vec3 (*eval)(const void *brdf, struct pbnds_vec3 wo,
                              struct pbnds_vec3 wi);
    float (*pdf)(const void *brdf, struct pbnds_vec3 wo, struct pbnds_vec3 wi);
    bool (*sample)(const void *brdf, struct pbnds_vec3 wo, float u_lobe, float u1,
                   float u2, struct pbnds_brdf_sample *out);
    struct pbnds_frame frame;
};

static inline struct pbnds_vec3 direction(float cos_theta, float phi)
{
    const float s = sqrtf(fmaxf(1.0f - cos_theta * cos_theta, 0.0f));
    return pbnds_vec3_make(s * cosf(phi), s * sinf(phi), cos_theta);
}

/* Midpoint rule over the hemisphere, uniform in solid angle; red channel. */
static inline double quadrature_albedo(const struct lobe *lobe, struct pbnds_vec3 wo,
                                       int n)
{
    double sum = 0.0;
    for (int i = 0; i < n * n; ++i) {
        const float z = ((float)(i / n) + 0.5f) / (float)n;
        const struct pbnds_vec3 wi =
            direction(z, 2.0f * PBNDS_PI * ((float)(i % n) + 0.5f) / (float)n);
        const float f = lobe->eval(lobe->brdf, pbnds_to_world(&lobe->frame, wo),
                                   pbnds_to_world(&lobe->frame, wi))
                            .x;
        sum += (double)(f * z);
    }
    return sum * 2.0 * (double)PBNDS_PI / ((double)n * n);
}

/* Mean of f cos / pdf over stratified samples, and the share of samples kept. */
static inline double sampled_albedo(const struct lobe *lobe, struct pbnds_vec3 wo,
                                    int n, double *kept)
{
    double sum = 0.0, count = 0.0;
    const struct pbnds_vec3 wo_world = pbnds_to_world(&lobe->frame, wo);
    for (int i = 0; i < n; ++i) {
        struct pbnds_brdf_sample s;
        /* R3 sequence, Roberts 2018: powers of the root of x^4 = x + 1 */
        const float u0 = (float)fmod(0.5 + 0.8191725133961645 * i, 1.0);
        const float u1 = (float)fmod(0.5 + 0.6710436067037893 * i, 1.0);
        const float u2 = (float)fmod(0.5 + 0.5497004779019703 * i, 1.0);
        if (!lobe->sample(lobe->brdf, wo_world, fminf(u0, 0x1.fffffep-1f),
                          fminf(u1, 0x1.fffffep-1f), fminf(u2, 0x1.fffffep-1f), &s))
            continue;
        const float cos_i = pbnds_dot(lobe->frame.n, s.wi);
        sum += (double)(s.f.x * cos_i / s.pdf);
        count += 1.0;
    }
    *kept = count / n;
    return sum / n;
}

static inline double quadrature_pdf(const struct lobe *lobe, struct pbnds_vec3 wo,
                                    int n)
{
    double sum = 0.0;
    for (int i = 0; i < n * n; ++i) {
        const float z = ((float)(i / n) + 0.5f) / (float)n;
        const struct pbnds_vec3 wi =
            direction(z, 2.0f * PBNDS_PI * ((float)(i % n) + 0.5f) / (float)n);
        sum += (double)lobe->pdf(lobe->brdf, pbnds_to_world(&lobe->frame, wo),
                                 pbnds_to_world(&lobe->frame, wi));
    }
    return sum * 2.0 * (double)PBNDS_PI / ((double)n * n);
}

enum { CHI_Z = 12, CHI_PHI = 16, CHI_SUB = 24, CHI_SAMPLES = 200000 };

/* Pearson's statistic of random samples against the integral of pdf over each bin, in
 * standard deviations above its mean: chi^2 of k degrees has mean k and variance 2 k.
 * Bins of fewer than ten expected samples, and the samples not kept, go together. */
static inline double chi_square_excess(const struct lobe *lobe, struct pbnds_vec3 wo,
                                       uint64_t seed)
{
    static int observed[CHI_Z * CHI_PHI];
    const struct pbnds_vec3 wo_world = pbnds_to_world(&lobe->frame, wo);
    memset(observed, 0, sizeof observed);
    for (uint64_t i = 0; i < CHI_SAMPLES; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(seed, 0, i);
        const float u0 = pbnds_rng_float(&rng), u1 = pbnds_rng_float(&rng),
                    u2 = pbnds_rng_float(&rng);
        struct pbnds_brdf_sample s;
        if (!lobe->sample(lobe->brdf, wo_world, u0, u1, u2, &s)) continue;
        const struct pbnds_vec3 wi = pbnds_to_local(&lobe->frame, s.wi);
        const float turn = atan2f(wi.y, wi.x) / (2.0f * PBNDS_PI);
        int z = (int)(wi.z * CHI_Z);
        int phi = (int)((turn < 0.0f ? turn + 1.0f : turn) * CHI_PHI);
        z = z < 0 ? 0 : z >= CHI_Z ? CHI_Z - 1 : z;
        phi = phi >= CHI_PHI ? CHI_PHI - 1 : phi;
        ++observed[z * CHI_PHI + phi];
    }
    double chi = 0.0, rest_expected = CHI_SAMPLES, rest_observed = CHI_SAMPLES;
    int degrees = 0;
    for (int bin = 0; bin < CHI_Z * CHI_PHI; ++bin) {
        double integral = 0.0;
        for (int i = 0; i < CHI_SUB * CHI_SUB; ++i) {
            const float z =
                ((float)(bin / CHI_PHI) + ((float)(i / CHI_SUB) + 0.5f) / CHI_SUB) /
                CHI_Z;
            const float phi =
                ((float)(bin % CHI_PHI) + ((float)(i % CHI_SUB) + 0.5f) / CHI_SUB) /
                CHI_PHI;
            integral += (double)lobe->pdf(
                lobe->brdf, wo_world,
                pbnds_to_world(&lobe->frame, direction(z, 2.0f * PBNDS_PI * phi)));
        }
        const double expected = integral * 2.0 * (double)PBNDS_PI /
                                (CHI_Z * CHI_PHI * CHI_SUB * CHI_SUB) * CHI_SAMPLES;
        if (expected < 10.0) continue;
        chi += (observed[bin] - expected) * (observed[bin] - expected) / expected;
        rest_expected -= expected;
        rest_observed -= observed[bin];
        ++degrees;
    }
    if (rest_expected >= 10.0) {
        chi += (rest_observed - rest_expected) * (rest_observed - rest_expected) /
               rest_expected;
        ++degrees;
    }
    --degrees; /* the counts sum to the number of samples */
    return (chi - degrees) / sqrt(2.0 * degrees);
}
#endif
