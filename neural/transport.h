/**
 * @file transport.h
 * From the transport network's output to radiance: everything here is linear in the
 * light.
 *
 * For lights i with irradiance E_i (envmap.h, clusters that sum to the whole map):
 *
 *     R = sum_i E_i (A_i V_i + B S_i)  +  G O  +  emission
 *     A_i = (f_diffuse + w f_specular)(wo, wi) max(n.wi, 0)      analytic, exact
 *     V_i = sigmoid(v_i + 1)                                     visibility, network
 *     S_i = softplus(s_i - 2), R, G and B                        indirect, network
 *     B   = c_diff + f0
 *     G   = (1 - w) integral of L f_specular max(n.wi, 0)        whole map, unshadowed
 *     O   = sigmoid(o + 2)                                       its occlusion, network
 *     w   = clamp((alpha - 0.1) / 0.2, 0, 1)
 *
 * A few clusters are a fine light for a wide lobe and a bad one for a narrow one, so
 * the specular goes over from the whole map (narrow) to the clusters with their shadows
 * (wide). G is by filtered importance sampling (Krivanek and Colbert 2008): a fixed set
 * of visible GGX normals, each looked up in a map averaged over its solid angle. All in
 * camera space; colours linear Rec. 709.
 */
#ifndef PBNDS_NEURAL_TRANSPORT_H
#define PBNDS_NEURAL_TRANSPORT_H

#include "engine/scene/envmap.h"
#include "engine/shade/bsdf.h"
#include "neural/view.h"

/** Channels of the network's output for one light. */
enum { PBNDS_OUT_VISIBILITY, PBNDS_OUT_INDIRECT, PBNDS_OUT_COUNT = 4 };

/** What shading needs to know of a pixel. */
struct pbnds_transport_pixel {
    bool covered;
    struct pbnds_bsdf bsdf; /**< camera space */
    struct pbnds_vec3 wo;   /**< to the eye, camera space */
    struct pbnds_vec3 b;    /**< c_diff + f0 */
    float cluster_weight;   /**< w */
};

#ifdef __cplusplus
extern "C" {
#endif

struct pbnds_transport_pixel pbnds_transport_pixel(const struct pbnds_view *view,
                                                   size_t i);

/** A_i for unit irradiance; wi in camera space. */
struct pbnds_vec3 pbnds_transport_direct(const struct pbnds_transport_pixel *pixel,
                                         struct pbnds_vec3 wi);
/** A V + B S, for unit irradiance, from the network's output for that light. */
struct pbnds_vec3 pbnds_transport_outgoing(const struct pbnds_transport_pixel *pixel,
                                           struct pbnds_vec3 wi,
                                           const float out[PBNDS_OUT_COUNT]);
/** One look at the light map from a pixel: f L factor, L the map's mean over the cone. */
struct pbnds_transport_look {
    struct pbnds_vec3 wi; /**< unit, world */
    float solid_angle;
    struct pbnds_vec3 f;
    float factor;
};
/** The looks whose sum times (1 - w) / count is G; none where the pixel has no narrow
 *  lobe. @return how many of `count` were written: some samples carry nothing */
int pbnds_transport_looks(const struct pbnds_transport_pixel *pixel,
                          const struct pbnds_camera *camera, int count,
                          struct pbnds_transport_look *looks);
/** G. */
struct pbnds_vec3 pbnds_transport_specular(const struct pbnds_transport_pixel *pixel,
                                           const struct pbnds_view *view,
                                           const struct pbnds_envmap *envmap);

/** The output functions, and for training their slopes. */
float pbnds_transport_visibility(float v);
float pbnds_transport_indirect(float s);
float pbnds_transport_indirect_slope(float s);
float pbnds_transport_occlusion(float o);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRANSPORT_H */
