/**
 * @file trial.h
 * Scenes on which renderers are compared: each has what the shipped ones lack.
 */
#ifndef PBNDS_SCENES_TRIAL_H
#define PBNDS_SCENES_TRIAL_H

#include "scenes/generator/world.h"

/** A closed room lit by a panel and a ball that emit; no light comes from outside. */
void gen_emitters(struct gen_world *w);
/** A stage under a directional light, a point light with a range and a spot. */
void gen_lamps(struct gen_world *w);
/** Tinted panes of alpha 0.25 to 0.75, one behind another, before and behind things. */
void gen_panes(struct gen_world *w);

#endif /* PBNDS_SCENES_TRIAL_H */
