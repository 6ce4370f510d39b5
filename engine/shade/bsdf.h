/**
 * @file bsdf.h
 * The physical material of every honest row: glTF 2.0 appendix B metallic-roughness.
 *
 *     f = (1 - F) c_diff / pi + F D(h) V(wo, wi)
 *     c_diff = base_color (1 - metallic),  f0 = lerp(dielectric_f0, base_color, metallic)
 *     F = f0 + (1 - f0)(1 - wo.h)^5,  D: GGX with alpha = roughness^2,
 *     V: height-correlated Smith G2 / (4 cos_o cos_i)  (brdf_ggx.h)
 *
 * Limits: glTF's coupling by F(wo.h) is reciprocal but not passive. Of a white furnace's
 * light a white smooth dielectric (base_color 1, roughness 0) returns 1.37 at wo.n = 0.18,
 * 2 in the limit of grazing view, 1.04 averaged over the hemisphere; at most 1.01 where
 * roughness is 1 or wo.n > 0.7. The specular lobe is single scattering and loses up to
 * 0.69 (brdf_ggx.h).
 *
 * Sampling mixes the cosine hemisphere and visible GGX normals; pdf is the mixture's.
 * Frame: world space about the surface's n. Units: f and pdf in 1/sr, f without cosine.
 */
#ifndef PBNDS_ENGINE_SHADE_BSDF_H
#define PBNDS_ENGINE_SHADE_BSDF_H

#include <stdbool.h>

#include "engine/shade/brdf.h"
#include "engine/shade/brdf_ggx.h"
#include "engine/shade/gbuffer.h"

struct pbnds_bsdf {
    struct pbnds_frame frame;
    struct pbnds_vec3 c_diff;
    struct pbnds_ggx ggx;
};

#ifdef __cplusplus
extern "C" {
#endif

/** f0 and f90 are those of the non-metal part; see struct pbnds_surface. */
struct pbnds_bsdf pbnds_bsdf_make(struct pbnds_vec3 n, struct pbnds_vec3 base_color,
                                  float metallic, float roughness, struct pbnds_vec3 f0,
                                  float f90);
struct pbnds_bsdf pbnds_bsdf_from_surface(const struct pbnds_surface *surface);
/** From pixel i = y * width + x: the dielectric f0 is recovered from specular, metallic and
 *  albedo, so that the round trip through the contract is exact. */
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
