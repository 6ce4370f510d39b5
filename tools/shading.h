/**
 * @file shading.h
 * What render and shade share: one shader, one picture.
 */
#ifndef PBNDS_TOOLS_SHADING_H
#define PBNDS_TOOLS_SHADING_H

#include "tools/shaders.h"
#include "tools/world.h"

/** Loads a world: tool_world_scene or tool_world_gbuffer. */
typedef enum pbnds_status (*tool_world_loader)(const struct tool_options *options,
                                               const char *path,
                                               struct tool_world *world,
                                               struct pbnds_error *error);

/** Checks the outputs, opens the shader, loads world and light, shades, writes, says
 * so. */
enum pbnds_status tool_shade_one(const struct tool_options *options,
                                 tool_world_loader load,
                                 struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_SHADING_H */
