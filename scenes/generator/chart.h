/**
 * @file chart.h
 * The calibration chart: a scene and a light map that show every convention at a glance.
 *
 * The scene, metres, seen by its cameras "main" (from the right and above) and "front"
 * (at (0, 1, 8), along -z): arrows along +X red, +Y green, +Z blue with their letters;
 * cards of known albedo (Lambert) and, above, the same values unlit; a mirror ball and a
 * matte ball; metal balls of roughness 0, 1/4, 1/2, 3/4, 1; a card whose texture shows
 * u and v; a card with the normal map of a dome beside that dome in geometry; unlit
 * squares of depth 7, 8, 9, 10, 12 and 16 from "front".
 *
 * The light map, `gltf` convention: the face of the cube that looks +X is red, +Y green,
 * +Z blue, the opposite ones cyan, magenta and yellow, each with its name on it, upright
 * and legible from the middle (on +-Y: from a camera that pitched up or down from -z).
 */
#ifndef PBNDS_SCENES_CHART_H
#define PBNDS_SCENES_CHART_H

#include "scenes/generator/world.h"

void gen_chart(struct gen_world *w);
/** Radiance of every texel into rgb[width * height * 3], row 0 on top. */
void gen_chart_light(int width, int height, float *rgb);

#endif /* PBNDS_SCENES_CHART_H */
