/**
 * @file still.h
 * The scenes that ship: designed, not drawn.
 */
#ifndef PBNDS_SCENES_STILL_H
#define PBNDS_SCENES_STILL_H

#include "scenes/generator/world.h"

/** A bust, a vase, a metal ball, a cloth and a box before a curved backdrop; camera
 * "main". */
void gen_still_life(struct gen_world *w);
/** Spheres: roughness grows to the right, metallic from the lower to the upper rows. */
void gen_sphere_grid(struct gen_world *w);

#endif /* PBNDS_SCENES_STILL_H */
