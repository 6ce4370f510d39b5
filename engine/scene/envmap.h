/**
 * @file envmap.h
 * Light at infinity: an equirect radiance map with its sampling distribution.
 *
 * Internal convention (`gltf`): u = 0.5 + atan2(z, x) / 2 pi, v = acos(y) / pi, row 0 is
 * up (+y), the map's centre column is +X. Other conventions are rolled into it on load:
 * u_openexr = u - 1/4, u_falcor = u + 1/4, u_pbnds = u + 1/2. Yaw turns the light about +y:
 * L(w) = L_map(R_y(-yaw) w), so that a light at +X with yaw 90 degrees comes from -Z.
 * Radiance: linear Rec. 709, W m^-2 sr^-1, constant over a texel (nearest lookup), so
 * that eval, pdf and cluster agree exactly.
 */
#ifndef PBNDS_ENGINE_SCENE_ENVMAP_H
#define PBNDS_ENGINE_SCENE_ENVMAP_H

#include "engine/core/vec.h"
#include "engine/image/image.h"

enum pbnds_env_convention {
    PBNDS_ENV_GLTF,
    PBNDS_ENV_OPENEXR,
    PBNDS_ENV_FALCOR,
    PBNDS_ENV_PBNDS,
};

struct pbnds_envmap; /* opaque, immutable: share it between threads */

/** A light direction drawn from the map. */
struct pbnds_env_sample {
    struct pbnds_vec3 wi;       /**< unit, to the light, world                     */
    struct pbnds_vec3 radiance; /**< L(wi)                                         */
    float pdf;                  /**< 1/sr; 0 when the map is black                 */
};

/** A distant light that stands for a region of the map. */
struct pbnds_env_light {
    struct pbnds_vec3 wi;    /**< unit, energy-weighted mean direction            */
    struct pbnds_vec3 power; /**< integral of L over the region, W m^-2 per channel:
                                  a surface facing wi receives this irradiance     */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Builds from a 3-channel image (copied; convention, yaw and strength are applied on
 *  lookup or baked, the caller cannot tell). NaN and negative texels count as 0.
 *  Errors: ARGUMENT (not 3 channels, yaw or strength not finite, strength < 0), MEMORY. */
enum pbnds_status pbnds_envmap_create(const struct pbnds_image *image,
                                      enum pbnds_env_convention convention, float yaw_deg,
                                      float strength, struct pbnds_envmap **envmap,
                                      struct pbnds_error *error) PBNDS_NODISCARD;
/** Reads a .hdr or .exr light map and builds it. */
enum pbnds_status pbnds_envmap_load(const char *path, enum pbnds_env_convention convention,
                                    float yaw_deg, float strength,
                                    struct pbnds_envmap **envmap,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_envmap_free(struct pbnds_envmap *envmap);

/** L(w) for a unit world direction. */
struct pbnds_vec3 pbnds_envmap_eval(const struct pbnds_envmap *envmap, struct pbnds_vec3 w);
/** Prefiltered lookup: mean radiance over a cone of about `solid_angle` sr around w, from a
 *  chain of area-averaged maps (each level half the size), trilinear. Linear in the map:
 *  for fixed w and solid_angle, L1 + L2 gives the sum. */
struct pbnds_vec3 pbnds_envmap_eval_cone(const struct pbnds_envmap *envmap,
                                         struct pbnds_vec3 w, float solid_angle);
/** eval_cone in two steps, for cones that are looked up in many maps. */
struct pbnds_env_place {
    float turn;       /**< atan2(z, x) / 2 pi, [-0.5, 0.5] */
    float v;          /**< acos(y) / pi, [0, 1] */
    float log2_texel; /**< of the texels, sr, whose bilinear lookup blurs like the cone */
};
struct pbnds_env_place pbnds_envmap_place(struct pbnds_vec3 w, float solid_angle);
struct pbnds_vec3 pbnds_envmap_eval_place(const struct pbnds_envmap *envmap,
                                          struct pbnds_env_place place);
/** Density of pbnds_envmap_sample() at w, 1/sr (luminance times sin theta, texel-wise). */
float pbnds_envmap_pdf(const struct pbnds_envmap *envmap, struct pbnds_vec3 w);
struct pbnds_env_sample pbnds_envmap_sample(const struct pbnds_envmap *envmap, float u1,
                                            float u2);
/** Splits the map into at most `count` regions of similar energy by repeated median cuts
 *  (Debevec 2005, "A Median Cut Algorithm for Light Probe Sampling"; always the region
 *  of greatest energy x extent next) and gives each as one light. The powers of the
 *  lights sum to the map's integral. A black map gives 0 lights. Deterministic.
 *  @return how many were written to lights[] */
int pbnds_envmap_cluster(const struct pbnds_envmap *envmap, int count,
                         struct pbnds_env_light *lights);
/** The map as it lights the scene (gltf convention, yaw and strength applied), resampled by
 *  area averaging to width x height (yaw by exact area overlap, so energy is kept). */
enum pbnds_status pbnds_envmap_bake(const struct pbnds_envmap *envmap, int width, int height,
                                    struct pbnds_image *image,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** Mean radiance over the sphere. */
struct pbnds_vec3 pbnds_envmap_mean(const struct pbnds_envmap *envmap);
/** "gltf", "openexr", "falcor", "pbnds"; 0 when the name is none of them. */
int pbnds_env_convention_parse(const char *name, enum pbnds_env_convention *convention);
const char *pbnds_env_convention_name(enum pbnds_env_convention convention);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_ENVMAP_H */
