/**
 * @file brdf_blinn_phong.h
 * Normalised Blinn-Phong: the empirical model, made to keep energy.
 *
 *     f = (1 - f0) c_diff / pi + f0 N(m) (n.h)^m
 *     N = (m + 2)(m + 4) / (8 pi (m + 2^(-m/2)))
 *     c_diff = base_color (1 - metallic),  f0 = lerp(dielectric f0, base_color, metallic)
 *     m = 2 / alpha^2 - 2,  alpha = roughness^2, at least PBNDS_GGX_ALPHA_MIN
 *
 * Blinn 1977, "Models of Light Reflection for Computer Synthesized Pictures". N is the
 * inverse of the integral of (n.h)^m cos_i over the hemisphere at normal view, of which
 * the better known (m + 8) / (8 pi) (Akenine-Moeller, Haines and Hoffman, "Real-Time
 * Rendering", 3rd ed., eq. 7.49) is a round fit, 7.5 % too bright near m = 9. So a white
 * lobe reflects exactly 1 of a white furnace along the normal, and less from elsewhere.
 * The exponent is the one whose lobe (n.h)^m has the width of GGX's for narrow lobes
 * (Walter et al. 2007, sec. 5.2: m = 2 / alpha^2 - 2): roughness 1 gives m = 0 (Lambert's
 * lobe), 0.5 gives 30, 0.25 gives 510, below 0.032 it stays at 2e6.
 *
 * No Fresnel term and no 1 / (cos_o cos_i): highlights fade as cos_o^2 toward grazing
 * view, where GGX's grow. Frame: world space about the surface's n. Units: f and pdf in
 * 1/sr, f without cosine.
 */
#ifndef PBNDS_ENGINE_SHADE_BRDF_BLINN_PHONG_H
#define PBNDS_ENGINE_SHADE_BRDF_BLINN_PHONG_H

#include <stdbool.h>

#include "engine/shade/brdf.h"
#include "engine/shade/bsdf.h"

struct pbnds_blinn_phong {
    struct pbnds_frame frame;
    struct pbnds_vec3 c_diff; /**< already filtered by 1 - f0 */
    struct pbnds_vec3 f0;
    float exponent, peak; /**< m, N(m) */
};

#ifdef __cplusplus
extern "C" {
#endif

/** The exponent of a perceptual roughness in [0, 1]. */
float pbnds_blinn_phong_exponent(float roughness);
/** The same surface as `bsdf`, in this model. */
struct pbnds_blinn_phong pbnds_blinn_phong_make(const struct pbnds_bsdf *bsdf);

struct pbnds_vec3 pbnds_blinn_phong_eval(const struct pbnds_blinn_phong *lobe,
                                         struct pbnds_vec3 wo, struct pbnds_vec3 wi);
/** Density of pbnds_blinn_phong_sample(): cosine hemisphere and h ~ (n.h)^m, mixed. */
float pbnds_blinn_phong_pdf(const struct pbnds_blinn_phong *lobe, struct pbnds_vec3 wo,
                            struct pbnds_vec3 wi);
/** u_lobe, u1, u2 uniform in [0, 1). false: the sample carries no energy. */
bool pbnds_blinn_phong_sample(const struct pbnds_blinn_phong *lobe,
                              struct pbnds_vec3 wo, float u_lobe, float u1, float u2,
                              struct pbnds_brdf_sample *out);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_BRDF_BLINN_PHONG_H */
