/**
 * @file material.h
 * Random materials: palettes of measured-plausible colours, layered textures.
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
};

/** Adds a random material. @return its index */
int gen_random_material(struct gen_world *w, struct pbnds_rng *r, enum gen_surface kind,
                        int texture_size);

/** Linear colour of an sRGB code 0xrrggbb. */
struct pbnds_vec3 gen_srgb(uint32_t code);

#endif /* PBNDS_SCENES_MATERIAL_H */
