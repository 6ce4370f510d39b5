/**
 * @file pbnds_plus.h
 * The paper's light model and its regression target, with our completions.
 *
 * N directions, uniform over the sphere and the same for all pixels, drawn anew each
 * step; the network is run on each and its outputs are averaged:
 *
 *     I = 1/N sum_i f_theta(a, n, s, r, v, L_i <n.l_i>)
 *     loss = |sRGB(I) - sRGB(clamp(R, 0, 1))|
 *
 * Ours, where the paper is silent: the directions are a spherical Fibonacci lattice
 * (Gonzalez 2010) under a random rotation instead of independent draws, and L_i is the
 * map averaged over the direction's share of the sphere, 4 pi / N. Point samples of a
 * real HDRI miss its sun nearly always, and the network then sees light that has
 * nothing to do with the picture. The mean is taken in linear light and display-encoded
 * once, since light adds before the display.
 */
#ifndef PBNDS_NEURAL_PBNDS_PLUS_H
#define PBNDS_NEURAL_PBNDS_PLUS_H

#include "engine/scene/envmap.h"
#include "neural/features.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Draws `count` lights with the radiance of the map (NULL: black) around their
 *  direction; a pure function of (seed, count). */
void pbnds_plus_draw_lights(const struct pbnds_envmap *envmap, uint64_t seed, int count,
                            struct pbnds_light_source *lights);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_PBNDS_PLUS_H */
