/**
 * @file bench_scene.h
 * The scene that `pbnds bench` measures ray casting on: a million triangles with three
 * 2048 x 2048 maps, made in memory from nothing but numbers.
 */
#ifndef PBNDS_TOOLS_BENCH_SCENE_H
#define PBNDS_TOOLS_BENCH_SCENE_H

#include "engine/scene/scene.h"

/** A displaced sphere of 516 960 triangles on uneven ground of 524 288; both wear a base
 *  colour, a metallic-roughness and a normal map, the ground's repeated. `camera` sees
 *  them so that some four fifths of a picture's rays hit something. Errors: MEMORY. */
enum pbnds_status tool_bench_scene(struct pbnds_scene *scene,
                                   struct pbnds_camera *camera,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_BENCH_SCENE_H */
