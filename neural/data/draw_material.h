/**
 * @file draw_material.h
 * Other materials for the scene of a sample: factors drawn anew, sets of textures handed
 * from material to material. What emits light, and what is not opaque, stays as it is:
 * tables of lights and intersection filters stay valid.
 *
 * With y the value of the file and N about normal:
 * - roughness: r = y exp(0.7 N), or for half of those without a map uniform in
 *   [0.05, 1]; a quarter as it was. Skin (upright scenes; no map, no metal): [0.3, 0.7].
 * - metallic: dielectric to metal (one in six of those without a map), with a colour of a
 *   real metal; metal to dielectric (one in four)
 * - base colour: hue, saturation and value moved within [0, 1]; where a texture is
 *   multiplied, a tint
 * - specular: ior_f0 log-uniform in [0.02, 0.08], specular in [0.3, 1] (one in three)
 * - normal map: scale uniform in [0, 2] (half)
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_MATERIAL_H
#define PBNDS_NEURAL_DATA_DRAW_MATERIAL_H

#include <cjson/cJSON.h>

#include "engine/core/rng.h"
#include "engine/scene/maps.h"
#include "engine/scene/scene.h"

/** The materials as the file has them. */
struct pbnds_material_store {
    struct pbnds_material *materials; /**< owned                          */
    struct pbnds_material_maps *maps; /**< owned; NULL: the scene has none */
    bool *swaps; /**< one a material: may it take others' textures? owned  */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Errors: MEMORY. */
enum pbnds_status pbnds_materials_keep(const struct pbnds_scene *scene,
                                       struct pbnds_material_store *store,
                                       struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_materials_restore(const struct pbnds_material_store *store,
                             struct pbnds_scene *scene);
void pbnds_material_store_free(struct pbnds_material_store *store);

/** May the material be changed? */
bool pbnds_material_is_free(const struct pbnds_material *material);
/** Draws factors. `skin`: plain materials are skin. */
void pbnds_materials_randomize(struct pbnds_scene *scene, bool skin,
                               struct pbnds_rng *rng);
/** Deals the sets of textures out anew. @return how many materials have another */
int pbnds_materials_swap(const struct pbnds_material_store *store,
                         struct pbnds_scene *scene, struct pbnds_rng *rng);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DRAW_MATERIAL_H */
