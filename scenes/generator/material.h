/**
 * @file material.h
 * Random materials: palettes of measured-plausible colours, layered textures.
 *
 * What the draws aim at, linear: non-metals have albedo 0.02 to 0.9, most of them 0.05 to
 * 0.8 (no natural diffuse surface is darker than about 0.02 or brighter than fresh snow,
 * 0.9); their reflectance at normal incidence is 0.02 (water, ior 1.33) to 0.08 (ior 1.8,
 * crystal, gemstones reach further), 0.04 for most (plastics, glass, paint, skin 0.028 to
 * 0.04); metals have the reflectances that were measured. Roughness is 0.02 to 1.
 */
#ifndef PBNDS_SCENES_MATERIAL_H
#define PBNDS_SCENES_MATERIAL_H

#include "scenes/generator/world.h"

enum gen_surface {
    GEN_ANY,
    GEN_GROUND, /**< floors and walls: rarely metal, often textured            */
    GEN_SKIN,
    GEN_CLOTH, /**< dielectric, rough */
    GEN_METAL,
    GEN_PLAIN, /**< as GEN_ANY, never textured                                */
    GEN_BARK,  /**< wood with its bark, soil, stone                           */
    GEN_LEAF,
    GEN_FRUIT, /**< saturated, half glossy                                    */
    GEN_GLAZE, /**< smooth: glass, enamel, glazed ceramics                    */
    GEN_PRINT, /**< paper, posters, labels, screens                           */
    GEN_GLOW,  /**< gives light                                               */
    GEN_SURFACE_COUNT
};

/** Some colours that the materials of one world share, or none. */
void gen_random_palette(struct gen_world *w, struct pbnds_rng *r);

/** Adds a random material. @return its index */
int gen_random_material(struct gen_world *w, struct pbnds_rng *r, enum gen_surface kind,
                        int texture_size);

/** Linear colour of an sRGB code 0xrrggbb. */
struct pbnds_vec3 gen_srgb(uint32_t code);

#endif /* PBNDS_SCENES_MATERIAL_H */
