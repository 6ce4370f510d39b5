/**
 * @file shader_paper.h
 * The two classical baselines as the paper's predecessor (PBNDS, He et al. 2025)
 * published them, errors included, for comparison with its tables. The honest models
 * are `blinn-phong` and `ggx`. Both average N directions l, drawn i.i.d. and uniform
 * over the whole sphere, the same for all pixels, times 2 pi (a sphere has 4 pi: hence
 * half the light), and clamp the mean:
 *
 *     out = clamp(mean_l [B(l) L(l) 2 pi <n.l>], 0, 1),   <x> = max(x, 0)
 *
 * paper-blinn-phong   B = albedo <n.l> + s <n.h>^16        (n.l enters twice)
 *
 * paper-ggx           B = (1 - s) albedo / pi + D F V
 *     F  = F0 + (1 - F0)(1 - <h.v>)^5,  F0 = 0.04 (1 - s) + albedo s   (s as metalness)
 *     V  = V1(<n.l>) V1(<n.v>),  V1(c) = 0.5 / max(c (1 - k) + k, 0.01),
 *          k = (1 + r)^2 / 8
 *     D  = min(exp(2 (<n.h> - 1) / a) / (pi a), 1),  a = max(r^2, 0.01)
 *
 * with albedo, roughness r and specular s of the G-buffer, h = normalize(l + v), and L
 * the nearest texel of the light map. A white matte surface (albedo 1, s 0, r 1) under
 * L = 1 gives 0.51 where 1 is right.
 *
 * The numbers are linear. The paper compared them as they are with display-encoded
 * targets (8-bit PNG / 255): to score them its way, compare without encoding; here they
 * leave as radiance, so every display transform downstream applies to them as to any
 * other shader.
 *
 * Ours, where nothing was published: N = 128 unless the job says (their training set's
 * count), the directions of one seed are drawn once per image, s is our `specular`
 * plane (f0's luminance), and emission is added before the clamp.
 */
#ifndef PBNDS_ENGINE_SHADE_SHADER_PAPER_H
#define PBNDS_ENGINE_SHADE_SHADER_PAPER_H

#include <stdint.h>

#include "engine/core/vec.h"

struct pbnds_paper_material {
    struct pbnds_vec3 albedo, n;
    float roughness, specular;
};

#ifdef __cplusplus
extern "C" {
#endif

/** i-th direction of the set that belongs to `seed`: uniform over the sphere. */
struct pbnds_vec3 pbnds_paper_direction(uint64_t seed, int i);
/** B(l) above; v and l unit, away from the surface. */
struct pbnds_vec3 pbnds_paper_blinn_phong(const struct pbnds_paper_material *m,
                                          struct pbnds_vec3 v, struct pbnds_vec3 l);
struct pbnds_vec3 pbnds_paper_ggx(const struct pbnds_paper_material *m,
                                  struct pbnds_vec3 v, struct pbnds_vec3 l);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_SHADER_PAPER_H */
