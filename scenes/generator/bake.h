/**
 * @file bake.h
 * Textures of layered materials: colour, roughness and metallic, normals.
 */
#ifndef PBNDS_SCENES_BAKE_H
#define PBNDS_SCENES_BAKE_H

#include "scenes/generator/pattern.h"
#include "scenes/generator/world.h"

/** One homogeneous layer. */
struct gen_layer {
    struct pbnds_vec3 color;
    float metallic, roughness;
};

enum { GEN_MARKS_MAX = 12 };

/** A printed shape: disc, ring, rectangle or block of writing on the unit square. */
struct gen_mark {
    int kind;
    float x, y, half_x, half_y, slant;
    struct pbnds_vec3 color;
};

/** What lies on what. */
struct gen_bake {
    struct gen_layer a, b;      /**< the pattern chooses between them                 */
    struct gen_pattern pattern; /**< of the first two layers                          */
    struct gen_layer wear;      /**< a third on top: dirt, rust, dust, peeled paint   */
    struct gen_pattern worn;    /**< where it lies                                    */
    bool has_wear;
    float variety; /**< how far tiles, boards and stones differ in brightness   */
    float grain;   /**< amplitude of fine noise on colour and roughness         */
    float depth;   /**< height of the pattern, of the side of the tile           */
    float bump;    /**< height of the fine noise                                 */
    int grain_frequency;                  /**< cells across the tile              */
    struct gen_mark marks[GEN_MARKS_MAX]; /**< painted over the first layer, in order */
    int mark_count;
    uint32_t seed;
    int size; /**< pixels a side */
};

/** Adds the images that the layers need and refers to them from m. */
void gen_bake_images(struct gen_world *w, const struct gen_bake *k,
                     struct gen_material *m);

#endif /* PBNDS_SCENES_BAKE_H */
