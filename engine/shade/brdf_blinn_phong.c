/* Normalised Blinn-Phong; equations, frame and units are in brdf_blinn_phong.h. */
#include "engine/shade/brdf_blinn_phong.h"

#include <assert.h>
#include <math.h>

static const struct pbnds_vec3 BLACK = {0.0f, 0.0f, 0.0f};

static float exponent_from_alpha(float alpha)
{
    return 2.0f / (alpha * alpha) - 2.0f;
}

float pbnds_blinn_phong_exponent(float roughness)
{
    return exponent_from_alpha(pbnds_ggx_from_gltf(BLACK, 1.0f, roughness).alpha);
}

/* The inverse of the integral of (n.h)^m cos_i over the hemisphere, seen along n. */
static float normalisation(float m)
{
    return (m + 2.0f) * (m + 4.0f) / (8.0f * PBNDS_PI * (m + exp2f(-0.5f * m)));
}

struct pbnds_blinn_phong pbnds_blinn_phong_make(const struct pbnds_bsdf *bsdf)
{
    struct pbnds_blinn_phong lobe;
    lobe.frame = bsdf->frame;
    lobe.f0 = bsdf->ggx.f0;
    lobe.c_diff = pbnds_mul(pbnds_sub(pbnds_splat(1.0f), lobe.f0), bsdf->c_diff);
    lobe.exponent = exponent_from_alpha(bsdf->ggx.alpha);
    lobe.peak = normalisation(lobe.exponent);
    return lobe;
}

/* (n.h)^m from sin^2, because m reaches 2e6, where 1 - n.h decides and n.h has lost it.
 */
static float cosine_power(struct pbnds_vec3 h, float m)
{
    const float sin2 = fminf(h.x * h.x + h.y * h.y, 1.0f);
    return m > 0.0f ? expf(0.5f * m * log1pf(-sin2)) : 1.0f;
}

static float specular_share(const struct pbnds_blinn_phong *lobe)
{
    const float specular = pbnds_luminance(lobe->f0);
    const float diffuse = pbnds_luminance(lobe->c_diff);
    if (specular <= 0.0f) return 0.0f;
    if (diffuse <= 0.0f) return 1.0f;
    return pbnds_clamp(specular / (specular + diffuse), 0.1f, 0.9f);
}

static struct pbnds_vec3 eval_local(const struct pbnds_blinn_phong *lobe,
                                    struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    if (wo.z <= 0.0f || wi.z <= 0.0f) return BLACK;
    const struct pbnds_vec3 h = pbnds_normalize(pbnds_add(wo, wi));
    return pbnds_mad(pbnds_scale(lobe->c_diff, 1.0f / PBNDS_PI), lobe->f0,
                     lobe->peak * cosine_power(h, lobe->exponent));
}

static float pdf_local(const struct pbnds_blinn_phong *lobe, struct pbnds_vec3 wo,
                       struct pbnds_vec3 wi)
{
    if (wo.z <= 0.0f || wi.z <= 0.0f) return 0.0f;
    const float m = lobe->exponent, share = specular_share(lobe);
    const struct pbnds_vec3 h = pbnds_normalize(pbnds_add(wo, wi));
    /* p(h) = (m + 1) / 2 pi (n.h)^m, and the Jacobian of the reflection 1 / (4 wo.h) */
    const float p_h = (m + 1.0f) / (2.0f * PBNDS_PI) * cosine_power(h, m);
    return share * p_h / (4.0f * pbnds_dot(wo, h)) + (1.0f - share) * wi.z / PBNDS_PI;
}

struct pbnds_vec3 pbnds_blinn_phong_eval(const struct pbnds_blinn_phong *lobe,
                                         struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    return eval_local(lobe, pbnds_to_local(&lobe->frame, wo),
                      pbnds_to_local(&lobe->frame, wi));
}

float pbnds_blinn_phong_pdf(const struct pbnds_blinn_phong *lobe, struct pbnds_vec3 wo,
                            struct pbnds_vec3 wi)
{
    return pdf_local(lobe, pbnds_to_local(&lobe->frame, wo),
                     pbnds_to_local(&lobe->frame, wi));
}

/* cos^(m+1) = 1 - u, hence sin^2 = 1 - (1 - u)^(2 / (m+1)), without cancellation. */
static struct pbnds_vec3 sample_half(float m, float u1, float u2)
{
    const float sin2 = -expm1f(2.0f / (m + 1.0f) * log1pf(-u1));
    const float s = sqrtf(sin2), phi = 2.0f * PBNDS_PI * u2;
    return pbnds_vec3_make(s * cosf(phi), s * sinf(phi),
                           sqrtf(fmaxf(1.0f - sin2, 0.0f)));
}

bool pbnds_blinn_phong_sample(const struct pbnds_blinn_phong *lobe,
                              struct pbnds_vec3 wo, float u_lobe, float u1, float u2,
                              struct pbnds_brdf_sample *out)
{
    const struct pbnds_vec3 lo = pbnds_to_local(&lobe->frame, wo);
    if (lo.z <= 0.0f) return false;
    struct pbnds_vec3 wi;
    if (u_lobe < specular_share(lobe)) {
        const struct pbnds_vec3 h = sample_half(lobe->exponent, u1, u2);
        const float cos_d = pbnds_dot(lo, h);
        if (cos_d <= 0.0f) return false;
        wi = pbnds_sub(pbnds_scale(h, 2.0f * cos_d), lo);
    } else {
        const float r = sqrtf(u1), phi = 2.0f * PBNDS_PI * u2;
        wi = pbnds_vec3_make(r * cosf(phi), r * sinf(phi),
                             sqrtf(fmaxf(1.0f - u1, 0.0f)));
    }
    out->pdf = pdf_local(lobe, lo, wi);
    if (!(out->pdf > 0.0f)) return false;
    out->f = eval_local(lobe, lo, wi);
    out->wi = pbnds_to_world(&lobe->frame, wi);
    assert(isfinite(out->pdf));
    return true;
}
