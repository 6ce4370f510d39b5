/**
 * @file bsdf.h
 * The physical material of every honest row: glTF 2.0 appendix B metallic-roughness with
 * KHR_materials_ior and _specular, but for one term.
 *
 *     f = (1 - metallic) f_dielectric + metallic f_metal          (appendix B, B.2)
 *     f_metal      = F(base_color, 1) D(h) V(wo, wi)
 *     f_dielectric = F(f0, f90) D(h) V(wo, wi) + f_diffuse
 *     F(f0, f90)   = f0 + (f90 - f0)(1 - wo.h)^5,  D: GGX with alpha = roughness^2,
 *     V: height-correlated Smith G2 / (4 cos_o cos_i)             (brdf_ggx.h)
 *
 * F is linear in f0 and f90, so the specular parts are one lobe of
 * f0 = lerp(f0, base_color, metallic), f90 = lerp(f90, 1, metallic).
 *
 * The one term. Appendix B couples the diffuse part by f_diffuse = (1 - max F(wo.h))
 * base_color / pi. That is reciprocal but not passive: a white smooth dielectric returns
 * 1.37 of a white furnace's light at wo.n = 0.18 and 2 in the limit of grazing view, since
 * the half vector of diffuse light meets wo steeply even where all of wo's own light is
 * reflected. Here the diffuse part gets what the lobe leaves, from either side (Kelemen
 * and Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model"; Kulla
 * and Conty 2017):
 *
 *     f_diffuse = base_color / pi (1 - E(wo)) (1 - E(wi)) / (1 - E_avg)
 *
 * with E the directional albedo of the dielectric's lobe and E_avg its mean
 * (ggx_albedo.h), of the greatest component of f0, as KHR_materials_specular has its
 * max(F), so that no complementary hue appears. It is reciprocal, and what leaves is
 * E(wo) + base_color (1 - E(wo)): a white dielectric of grey f0 returns 1 at every
 * roughness and view, within the table's 0.006 (at most 1.006). So the 4 % or less that
 * single scattering loses of a dielectric's lobe comes back by the diffuse part; with
 * f90 = f0 = 0 the model is Lambert's.
 *
 * The size of the change, at f0 = 0.04 and f90 = 1: the diffuse part is that of appendix
 * B times 1.00 (roughness 0) to 1.03 (roughness 1) seen along the normal, times 0.68 to
 * 1.02 at wo.n = 0.2, times 0.23 to 1.00 at wo.n = 0.05; times 0.956 to 1.026 averaged
 * over the hemisphere of views. Specular parts and metals are appendix B's, and stay
 * single scattering: a white metal loses up to 0.69 (brdf_ggx.h).
 *
 * Sampling mixes the cosine hemisphere and visible GGX normals in proportion to what
 * either part reflects; pdf is the mixture's. Frame: world space about the surface's n.
 * Units: f and pdf in 1/sr, f without cosine. Pure functions, safe from any thread.
 */
#ifndef PBNDS_ENGINE_SHADE_BSDF_H
#define PBNDS_ENGINE_SHADE_BSDF_H

#include <stdbool.h>

#include "engine/shade/brdf.h"
#include "engine/shade/brdf_ggx.h"
#include "engine/shade/gbuffer.h"
#include "engine/shade/ggx_albedo.h"

struct pbnds_bsdf {
    struct pbnds_frame frame;
    struct pbnds_vec3 c_diff; /**< base_color (1 - metallic)                        */
    struct pbnds_ggx ggx;     /**< specular lobe of metal and dielectric together   */
    struct pbnds_ggx_albedo_row row; /**< of alpha                                  */
    float f0, f90;       /**< of the dielectric part, f0's greatest component  */
    float diffuse_scale; /**< 1 / (pi (1 - E_avg))                             */
};

#ifdef __cplusplus
extern "C" {
#endif

/** f0 and f90 are those of the non-metal part; see struct pbnds_surface. */
struct pbnds_bsdf pbnds_bsdf_make(struct pbnds_vec3 n, struct pbnds_vec3 base_color,
                                  float metallic, float roughness, struct pbnds_vec3 f0,
                                  float f90);
struct pbnds_bsdf pbnds_bsdf_from_surface(const struct pbnds_surface *surface);
/** From pixel i = y * width + x: the dielectric f0 and f90 are recovered from the planes
 *  f0 and f90, or, where there are none, grey from specular, with metallic and albedo, so
 *  that the round trip through the contract is exact. */
struct pbnds_bsdf pbnds_bsdf_from_gbuffer(const struct pbnds_gbuffer *gbuffer,
                                          size_t i);

/** f(wo, wi), and its diffuse part alone; without the cosine. */
struct pbnds_vec3 pbnds_bsdf_eval(const struct pbnds_bsdf *bsdf, struct pbnds_vec3 wo,
                                  struct pbnds_vec3 wi);
struct pbnds_vec3 pbnds_bsdf_diffuse(const struct pbnds_bsdf *bsdf,
                                     struct pbnds_vec3 wo, struct pbnds_vec3 wi);
float pbnds_bsdf_pdf(const struct pbnds_bsdf *bsdf, struct pbnds_vec3 wo,
                     struct pbnds_vec3 wi);
/** u_lobe, u1, u2 uniform in [0, 1). out->wi world. false: no energy, the path ends. */
bool pbnds_bsdf_sample(const struct pbnds_bsdf *bsdf, struct pbnds_vec3 wo,
                       float u_lobe, float u1, float u2, struct pbnds_brdf_sample *out);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_BSDF_H */
