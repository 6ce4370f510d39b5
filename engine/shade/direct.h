/**
 * @file direct.h
 * Light that reaches the visible surface straight from the light map and from the lights
 * of the file:
 *
 *     L_o = L_e + integral f(wo, wi) L_i(wi) V(wi) max(n.wi, 0) dwi
 *               + sum_lights f(wo, wi) E V(wi) max(n.wi, 0)        (light_punctual.h)
 *
 * Map. Each sample of a pixel draws one direction from the map and one from the BRDF, and
 * weighs them by the balance heuristic (Veach 1997, eq. 9.8; both with one sample):
 * f L cos / (p_map + p_brdf) whichever of them drew it.
 *
 * Lights of the file. They have one direction each, so all of them are summed and nothing
 * is drawn. They are known where the job has its scene; a G-buffer from a file has none.
 *
 * V is traced where shadows are on, up to the light; directions below the geometric
 * surface are then dark too. Without shadows V = 1, since only the shading normal is
 * known. BLEND surfaces let light through by chance (accel.h): a sample's shadow rays see
 * their own choice of layers, so that V's mean is the light let through; for lights of
 * the file it is averaged over as many rays as the job has samples.
 *
 * The result is the radiance of what covers the pixel; shader.h says how it is composed
 * with what is behind.
 */
#ifndef PBNDS_ENGINE_SHADE_DIRECT_H
#define PBNDS_ENGINE_SHADE_DIRECT_H

#include "engine/shade/brdf_blinn_phong.h"
#include "engine/shade/bsdf.h"
#include "engine/shade/shader.h"

union pbnds_direct_lobe {
    struct pbnds_bsdf bsdf;
    struct pbnds_blinn_phong blinn_phong;
};

/** A reflectance model as direct lighting uses it. World frame; the conventions of
 * bsdf.h. */
struct pbnds_direct_model {
    const char *name;
    int spp;      /**< samples a pixel where the job gives none             */
    bool shadows; /**< traced where the job gives -1 and the scene is known */
    void (*load)(union pbnds_direct_lobe *lobe, const struct pbnds_gbuffer *gbuffer,
                 size_t i);
    struct pbnds_vec3 (*eval)(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                              struct pbnds_vec3 wi);
    float (*pdf)(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                 struct pbnds_vec3 wi);
    bool (*sample)(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                   float u_lobe, float u1, float u2, struct pbnds_brdf_sample *out);
};

#ifdef __cplusplus
extern "C" {
#endif

/** Fills `radiance` (width x height x 3, zeroed). Errors: INTERRUPTED. */
enum pbnds_status pbnds_direct(const struct pbnds_direct_model *model,
                               const struct pbnds_shade_job *job,
                               struct pbnds_image *radiance,
                               struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_DIRECT_H */
