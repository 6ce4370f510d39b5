#include "tools/world.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "engine/image/oiio.h"
#include "engine/scene/gltf.h"
#include "engine/scene/maps.h"
#include "tools/console.h"
#include "tools/shipped.h"

enum { DEFAULT_SIDE = 512 };
static const float default_fov_deg = 40.0f;

bool tool_has_extension(const char *path, const char *extension)
{
    const size_t n = strlen(path), m = strlen(extension);
    return n > m && strcasecmp(path + n - m, extension) == 0;
}

const char *tool_base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* A camera of the file by its name, else by its number. */
static enum pbnds_status find_camera(const struct pbnds_scene *scene,
                                     const char *wanted, const char *path,
                                     const struct pbnds_camera **camera,
                                     struct pbnds_error *error)
{
    for (int i = 0; i < scene->camera_count; ++i) {
        if (strcmp(scene->cameras[i].name, wanted) == 0) {
            *camera = &scene->cameras[i];
            return PBNDS_OK;
        }
    }
    char *end = NULL;
    errno = 0;
    const long index = strtol(wanted, &end, 10);
    if (*wanted >= '0' && *wanted <= '9' && !*end && !errno &&
        index < scene->camera_count) {
        *camera = &scene->cameras[index];
        return PBNDS_OK;
    }
    if (scene->camera_count == 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: has no camera; leave out --camera %s to frame the scene",
                          path, wanted);
    }
    return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                      "%s: has no camera '%s', its %d are listed by 'pbnds info'", path,
                      wanted, scene->camera_count);
}

/* *previous: the same camera at the earlier time, NULL where it did not move. */
static enum pbnds_status pick_camera(const struct tool_options *options,
                                     const struct pbnds_scene *scene, const char *path,
                                     float aspect, struct pbnds_camera *camera,
                                     struct pbnds_camera **previous,
                                     struct pbnds_error *error)
{
    *previous = NULL;
    if (options->camera && options->look_given) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "--camera and --look each choose a camera; give one of them");
    }
    const float fov = options->fov > 0.0 ? (float)options->fov : default_fov_deg;
    const struct pbnds_camera *found = NULL;
    if (options->camera) {
        PBNDS_TRY(find_camera(scene, options->camera, path, &found, error));
    } else if (!options->look_given && scene->camera_count > 0) {
        found = &scene->cameras[0];
    }
    if (found) {
        *camera = *found;
        if (options->fov > 0.0) camera->yfov = fov * PBNDS_PI / 180.0f;
        if (scene->previous_cameras) {
            *previous = &scene->previous_cameras[found - scene->cameras];
            (*previous)->yfov = camera->yfov;
        }
        return PBNDS_OK;
    }
    if (scene->triangle_count == 0) {
        return pbnds_fail(
            error, PBNDS_ERROR_UNSUPPORTED,
            "%s: has no triangles and no camera, so there is nothing to frame", path);
    }
    *camera = pbnds_camera_framing(scene->lo, scene->hi, (float)options->look[0],
                                   (float)options->look[1], fov, aspect);
    return PBNDS_OK;
}

static void note_origin(const struct tool_options *options, struct tool_world *world)
{
    world->origin.seed = options->seed;
    world->origin.normal_space = (enum pbnds_normal_space)options->normal_space;
    world->origin.depth = (enum pbnds_depth_kind)options->depth;
    (void)snprintf(world->origin.arguments, sizeof world->origin.arguments, "%s",
                   options->arguments);
}

struct pbnds_gltf_options tool_gltf_options(const struct tool_options *options)
{
    return (struct pbnds_gltf_options){
        .scene = options->scene,
        .variant = options->variant,
        .animation = options->animation,
        .posed = options->time >= 0.0,
        .time = options->time,
        .motion = options->time >= 0.0 && options->motion > 0.0,
        .earlier = options->time - options->motion,
        .allow_external = options->allow_external,
        .max_geometry = (uint64_t)options->max_geometry_mb << 20,
        .max_images = (uint64_t)options->max_images_mb << 20,
        .max_file = (uint64_t)options->max_file_mb << 20,
        .max_image_side = options->max_image_side,
    };
}

static struct pbnds_raycast_options raycast_options(const struct tool_options *options,
                                                    const struct pbnds_camera *previous)
{
    struct pbnds_raycast_options cast = {
        .samples = options->aov_samples,
        .through = (enum pbnds_through)options->aov_through,
        .previous_camera = previous,
    };
    if (options->aovs) {
        cast.optional |=
            PBNDS_OPTIONAL_AO | PBNDS_OPTIONAL_UV | PBNDS_OPTIONAL_MATERIAL_ID;
    }
    if (options->cryptomatte) cast.optional |= PBNDS_OPTIONAL_CRYPTOMATTE;
    if (options->motion > 0.0) cast.optional |= PBNDS_OPTIONAL_MOTION;
    return cast;
}

enum pbnds_status tool_world_scene(const struct tool_options *options, const char *path,
                                   struct tool_world *world, struct pbnds_error *error)
{
    const int width = options->size[0] ? options->size[0] : DEFAULT_SIDE;
    const int height = options->size[1] ? options->size[1] : DEFAULT_SIDE;
    const struct pbnds_gltf_options gltf = tool_gltf_options(options);
    PBNDS_TRY(pbnds_gltf_load(path, &gltf, tool_report(), &world->scene, error));
    PBNDS_TRY(tool_check_stop(error));
    if (options->no_scene_lights) world->scene.light_count = 0;
    if (options->no_mips) {
        pbnds_maps_free(world->scene.maps);
        world->scene.maps = NULL;
    }
    for (int i = 0; options->backfaces && i < world->scene.material_count; ++i)
        world->scene.materials[i].double_sided = true;
    struct pbnds_camera camera, *previous = NULL;
    PBNDS_TRY(pick_camera(options, &world->scene, path, (float)width / (float)height,
                          &camera, &previous, error));
    PBNDS_TRY(pbnds_accel_create(&world->scene, &world->accel, error));
    PBNDS_TRY(tool_check_stop(error));
    const struct pbnds_raycast_options cast = raycast_options(options, previous);
    PBNDS_TRY(pbnds_gbuffer_raycast(&world->scene, world->accel, &camera, width, height,
                                    &cast, &world->gbuffer, error));
    note_origin(options, world);
    return tool_check_stop(error);
}

enum pbnds_status tool_world_gbuffer(const struct tool_options *options,
                                     const char *path, struct tool_world *world,
                                     struct pbnds_error *error)
{
    if (options->camera || options->look_given || options->fov > 0.0 ||
        options->size[0]) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: is a G-buffer, its camera and size are fixed; leave out "
                          "--camera, --look, --fov and --size",
                          path);
    }
    PBNDS_TRY(pbnds_gbuffer_read(path, &world->gbuffer, &world->origin, &world->stored,
                                 NULL, error));
    world->stored_target = world->origin.target;
    world->origin.target = PBNDS_TARGET_RADIANCE; /* of what will be shaded */
    note_origin(options, world);
    return tool_check_stop(error);
}

/* As pbnds_envmap_load(), within the limits of the command line. */
static enum pbnds_status load_envmap(const struct tool_options *options,
                                     const char *path, struct pbnds_envmap **envmap,
                                     struct pbnds_error *error)
{
    const struct pbnds_image_limits limits = {
        .side = options->max_image_side,
        .bytes = options->max_images_mb ? (uint64_t)options->max_images_mb << 20
                                        : PBNDS_LIGHT_MAP_BYTES};
    struct pbnds_image image;
    PBNDS_TRY(pbnds_image_read_rgb_within(path, &limits, &image, error));
    const enum pbnds_status status = pbnds_envmap_create(
        &image, (enum pbnds_env_convention)options->env_convention,
        (float)options->env_yaw, (float)options->env_strength, envmap, error);
    pbnds_image_free(&image);
    return status;
}

enum pbnds_status tool_world_light(const struct tool_options *options,
                                   struct tool_world *world, struct pbnds_error *error)
{
    char sky[1400];
    const char *path = options->env;
    world->origin.env[0] = 0;
    world->origin.env_strength = (float)options->env_strength;
    world->origin.env_yaw_deg = (float)options->env_yaw;
    (void)snprintf(
        world->origin.env_convention, sizeof world->origin.env_convention, "%s",
        pbnds_env_convention_name((enum pbnds_env_convention)options->env_convention));
    if (path && strcmp(path, "none") == 0) return PBNDS_OK;
    if (!path) {
        if (!tool_shipped("scenes/sky.hdr", sky, sizeof sky)) {
            return pbnds_fail(
                error, PBNDS_ERROR_IO,
                "%s: the default light map is not installed; give --env FILE "
                "or --env none",
                sky);
        }
        path = sky;
    }
    PBNDS_TRY(load_envmap(options, path, &world->envmap, error));
    (void)snprintf(world->origin.env, sizeof world->origin.env, "%.255s",
                   tool_base_name(path));
    return tool_check_stop(error);
}

void tool_world_free(struct tool_world *world)
{
    pbnds_gbuffer_free(&world->gbuffer);
    pbnds_accel_free(world->accel);
    pbnds_scene_free(&world->scene);
    pbnds_image_free(&world->stored);
    pbnds_envmap_free(world->envmap);
    *world = (struct tool_world){.accel = NULL};
}

struct pbnds_shade_job tool_world_job(const struct tool_options *options,
                                      const struct tool_world *world)
{
    return (struct pbnds_shade_job){
        .gbuffer = &world->gbuffer,
        .envmap = world->envmap,
        .scene = world->accel ? &world->scene : NULL,
        .accel = world->accel,
        .seed = options->seed,
        .spp = options->spp,
        .lights = options->lights,
        .shadows = options->shadows,
        .noise = (float)options->noise,
        .max_memory = (size_t)options->max_memory_mb << 20,
        .report = tool_report(),
    };
}
