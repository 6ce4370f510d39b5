/** @file gltf_input.h  Any bytes as a .glb or .gltf that may open no file. */
#ifndef PBNDS_TESTS_FUZZ_GLTF_INPUT_H
#define PBNDS_TESTS_FUZZ_GLTF_INPUT_H

#include <stdint.h>

#include "engine/scene/gltf.h"

/** Small budgets: a bomb must be refused, not survived. */
static inline struct pbnds_gltf_options fuzz_options(void)
{
    return (struct pbnds_gltf_options){.max_geometry = 64 << 20,
                                       .max_images = 16 << 20,
                                       .max_file = 1 << 20,
                                       .max_image_side = 2048};
}

/** The same, moving: for files that have an animation. */
static inline struct pbnds_gltf_options fuzz_options_moving(void)
{
    struct pbnds_gltf_options options = fuzz_options();
    options.animation = "0";
    options.posed = true;
    options.time = 0.7;
    options.motion = true;
    options.earlier = 0.2;
    return options;
}

/** The same, in another guise: for files that have variants. */
static inline struct pbnds_gltf_options fuzz_options_variant(void)
{
    struct pbnds_gltf_options options = fuzz_options();
    options.scene = "0";
    options.variant = "0";
    options.allow_external = true;
    return options;
}

static inline enum pbnds_status fuzz_load(const uint8_t *data, size_t size,
                                          const struct pbnds_gltf_options *options,
                                          struct pbnds_scene *scene)
{
    struct pbnds_error error;
    return pbnds_gltf_load_memory(data, size, "fuzz", NULL, options, NULL, scene,
                                  &error);
}

#endif /* PBNDS_TESTS_FUZZ_GLTF_INPUT_H */
