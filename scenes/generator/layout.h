/**
 * @file layout.h
 * Random worlds: what stands where.
 */
#ifndef PBNDS_SCENES_LAYOUT_H
#define PBNDS_SCENES_LAYOUT_H

#include "scenes/generator/world.h"

/** Fills an empty world; a function of (seed, index) alone (and of w->sketch, where the
 *  same things are made coarsely). */
void gen_random_world(struct gen_world *w, uint64_t seed, uint64_t index);

#endif /* PBNDS_SCENES_LAYOUT_H */
