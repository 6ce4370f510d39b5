/**
 * @file envmap_map.h
 * What the envmap_*.c files share; nobody else includes it.
 *
 * Convention and yaw are both turns about +y, so together they are one offset in u:
 *     u_image = frac(atan2(z, x) / 2 pi + u_offset),   v = theta / pi.
 * Directions are carried through it in and out; texels are never resampled.
 */
#ifndef PBNDS_ENGINE_SCENE_ENVMAP_MAP_H
#define PBNDS_ENGINE_SCENE_ENVMAP_MAP_H

#include <stdbool.h>

#include "engine/scene/envmap.h"

#define PBNDS_ENVMAP_LEVELS_MAX 17 /* 65535 halves to 1 in 16 steps */

/** One map of the prefiltered chain. */
struct pbnds_envmap_level {
    int width, height;
    struct pbnds_vec3 *texels; /**< width * height */
    float log2_solid_angle;    /**< of a texel, averaged over the sphere */
};

struct pbnds_envmap {
    int width, height;
    struct pbnds_vec3 *texels; /**< width * height, as in the file, times strength    */
    double u_offset;           /**< in [0, 1), see above                              */
    double *cos_theta;         /**< height + 1 row edges, from 1 down to -1           */
    float *rows;               /**< height: P(row <= y)                               */
    float *columns;            /**< width * height: P(column <= x | row y)            */
    float pdf_scale;           /**< pdf = luminance * pdf_scale                       */
    struct pbnds_vec3 mean;
    struct pbnds_envmap_level levels[PBNDS_ENVMAP_LEVELS_MAX]; /**< [0] is the map */
    int level_count;
};

/** Image coordinates of a world direction, both in [0, 1]. */
static inline void pbnds_envmap_uv(const struct pbnds_envmap *envmap,
                                   struct pbnds_vec3 w, double *u, double *v)
{
    const double turn =
        (double)atan2f(w.z, w.x) * 0.15915494309189535 + envmap->u_offset;
    *u = turn < 0.0 ? turn + 1.0 : turn >= 1.0 ? turn - 1.0 : turn;
    /* acos(y) loses half of its digits at the poles; this does not. */
    *v = (double)atan2f(sqrtf(w.x * w.x + w.z * w.z), w.y) * 0.31830988618379067;
}

/** Builds levels[] from texels (exact area averages). @return false: out of memory */
bool pbnds_envmap_build_levels(struct pbnds_envmap *envmap);

#endif /* PBNDS_ENGINE_SCENE_ENVMAP_MAP_H */
