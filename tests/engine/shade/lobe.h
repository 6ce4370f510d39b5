/* Measures of any BRDF over the hemisphere of +z, for the tests of the BRDFs. */
#ifndef PBNDS_TESTS_ENGINE_SHADE_LOBE_H
#define PBNDS_TESTS_ENGINE_SHADE_LOBE_H

#include <stdbool.h>

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
#endif
