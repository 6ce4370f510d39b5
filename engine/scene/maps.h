/**
 * @file maps.h
 * The maps of materials, prefiltered: what a lookup with a footprint reads.
 *
 * Maps of one material that share image size, sampler, UV set and transform lie
 * interleaved in one `bundle`, so that one lookup (addresses, weights, cache lines)
 * serves them all. Only the channels that glTF reads are kept, as linear light in 16 bits
 * (sRGB maps are decoded before they are averaged), with a chain of mip levels down to
 * 1 x 1: each texel of a level is the mean over exactly its share of the level above,
 * which need not be a power of two. Colours with alpha are averaged weighed by alpha.
 */
#ifndef PBNDS_ENGINE_SCENE_MAPS_H
#define PBNDS_ENGINE_SCENE_MAPS_H

#include <stdint.h>

#include "engine/core/error.h"
#include "engine/scene/texture.h"

struct pbnds_scene;

/** The maps of a material, and how many channels of them are kept. */
enum pbnds_map {
    PBNDS_MAP_BASE_COLOR,         /**< r, g, b; a too unless the material is opaque  */
    PBNDS_MAP_METALLIC_ROUGHNESS, /**< g, b                                          */
    PBNDS_MAP_NORMAL,             /**< r, g, b                                       */
    PBNDS_MAP_EMISSIVE,           /**< r, g, b                                       */
    PBNDS_MAP_OCCLUSION,          /**< r                                             */
    PBNDS_MAP_SPECULAR,           /**< a                                             */
    PBNDS_MAP_SPECULAR_COLOR,     /**< r, g, b; a too with specular-glossiness       */
    PBNDS_MAP_COUNT
};

enum { PBNDS_BUNDLE_CHANNELS = 16, PBNDS_MIP_LEVELS = 16 };

struct pbnds_bundle {
    enum pbnds_wrap wrap_u, wrap_v;
    int texcoord;
    bool transformed;
    float transform[6]; /**< as in struct pbnds_texture_ref                           */
    float density;      /**< texels of the finest level in one unit of UV area        */
    int channels;       /**< interleaved: 4, 8, 12 or 16; what is not used is 0       */
    int first[PBNDS_MAP_COUNT]; /**< channel where a map begins, -1: not in here      */
    int kept[PBNDS_MAP_COUNT];  /**< how many channels of it there are                */
    int texture[PBNDS_MAP_COUNT]; /**< of the scene, -1: none                         */
    int levels;
    int width[PBNDS_MIP_LEVELS], height[PBNDS_MIP_LEVELS];
    uint32_t at[PBNDS_MIP_LEVELS]; /**< first texel of a level                        */
    uint16_t *texels;              /**< owned; 65535 is 1                             */
};

/** Which bundle a map of a material is in; -1: in none, look it up in its texture. */
struct pbnds_material_maps {
    int bundle[PBNDS_MAP_COUNT];
};

struct pbnds_maps {
    struct pbnds_bundle *bundles;
    int count;
    struct pbnds_material_maps *materials; /**< one a material of the scene */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Builds scene->maps, on every thread. Maps with a NEAREST filter stay out of it, as do,
 *  in the order of the materials, maps past a budget of `max_bytes` (0: 4 GiB): these are
 *  looked up in their finest level. Call it when images and materials are complete, once.
 *  Errors: MEMORY. */
enum pbnds_status pbnds_scene_prefilter(struct pbnds_scene *scene, uint64_t max_bytes,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
/** A map's values among those of its bundle, as the r, g, b, a that its texture holds;
 *  channels that are not kept are 1. */
struct pbnds_vec4 pbnds_map_value(const struct pbnds_bundle *bundle, int map,
                                  const float *values);
/** Frees them; NULL is fine. */
void pbnds_maps_free(struct pbnds_maps *maps);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_MAPS_H */
