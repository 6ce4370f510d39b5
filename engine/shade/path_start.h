/**
 * @file path_start.h
 * Where the paths of a pixel start; the rules are in pathtrace.h.
 */
#ifndef PBNDS_ENGINE_SHADE_PATH_START_H
#define PBNDS_ENGINE_SHADE_PATH_START_H

#include "engine/scene/camera.h"
#include "engine/shade/path.h"

enum pbnds_path_start {
    PBNDS_PATH_NOWHERE, /**< nothing covers the pixel                    */
    PBNDS_PATH_SURFACE, /**< at the surface of the G-buffer              */
    PBNDS_PATH_CAMERA,  /**< at the eye, a ray a sample                  */
};

/** Borrowed, immutable. */
struct pbnds_path_lens {
    const struct pbnds_gbuffer *gbuffer;
    const struct pbnds_path_world *world;
    struct pbnds_camera_view view;
};

#ifdef __cplusplus
extern "C" {
#endif

struct pbnds_path_lens pbnds_path_lens_make(const struct pbnds_gbuffer *gbuffer,
                                            const struct pbnds_path_world *world);
/** `first` is filled where the paths start at the surface. */
enum pbnds_path_start pbnds_path_start_of(const struct pbnds_path_lens *lens, int x,
                                          int y, struct pbnds_path_vertex *first);
/** The ray of one sample and its cone, for pbnds_path_trace_camera(). */
struct pbnds_ray pbnds_path_start_ray(const struct pbnds_path_lens *lens, int x, int y,
                                      const struct pbnds_sampler *sampler,
                                      float cone[2]);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_PATH_START_H */
