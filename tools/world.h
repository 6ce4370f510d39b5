/**
 * @file world.h
 * What a shading job needs, loaded as the command line says: scene, camera, G-buffer,
 * light.
 */
#ifndef PBNDS_TOOLS_WORLD_H
#define PBNDS_TOOLS_WORLD_H

#include "engine/scene/gltf.h"
#include "engine/shade/shader.h"
#include "tools/options.h"

struct tool_world {
    struct pbnds_scene scene;
    struct pbnds_accel *accel; /**< NULL: the G-buffer came from a file */
    struct pbnds_gbuffer gbuffer;
    struct pbnds_gbuffer_origin origin; /**< for the header of what is written */
    struct pbnds_image
        stored; /**< the picture that a G-buffer file carries, or empty */
    enum pbnds_target stored_target; /**< what it is */
    struct pbnds_envmap *envmap; /**< NULL: no light */
};

/** What the command line says about reading a scene file. */
struct pbnds_gltf_options tool_gltf_options(const struct tool_options *options);
/** Loads the scene, picks the camera, casts the G-buffer. */
enum pbnds_status tool_world_scene(const struct tool_options *options, const char *path,
                                   struct tool_world *world,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
/** Reads the G-buffer from a file. */
enum pbnds_status tool_world_gbuffer(const struct tool_options *options,
                                     const char *path, struct tool_world *world,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Loads the light map of the command line and notes it in world->origin. */
enum pbnds_status tool_world_light(const struct tool_options *options,
                                   struct tool_world *world,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
void tool_world_free(struct tool_world *world);

/** The job that the command line asks of a shader in this world. */
struct pbnds_shade_job tool_world_job(const struct tool_options *options,
                                      const struct tool_world *world);
/** Does the file name end in `extension` (".exr"), in any case of letters? */
bool tool_has_extension(const char *path, const char *extension);
/** Behind the last slash. */
const char *tool_base_name(const char *path);

#endif /* PBNDS_TOOLS_WORLD_H */
