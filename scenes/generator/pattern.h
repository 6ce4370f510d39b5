/**
 * @file pattern.h
 * Scalar patterns that tile the unit square.
 */
#ifndef PBNDS_SCENES_PATTERN_H
#define PBNDS_SCENES_PATTERN_H

#include "scenes/generator/random.h"

enum gen_pattern_kind {
    GEN_CLOUDS,
    GEN_MARBLE,
    GEN_CHECKER,
    GEN_STRIPES,
    GEN_SPOTS,
    GEN_CRACKS,
    GEN_WOOD,
    GEN_BRICKS,
    GEN_SCRATCHES,
    GEN_WEAVE,
    GEN_STONES,
    GEN_PATTERN_COUNT
};

struct gen_pattern {
    enum gen_pattern_kind kind;
    int frequency;  /**< cells across the tile   */
    int slant;      /**< stripes: cells upwards  */
    float softness; /**< width of transitions    */
    float warp;     /**< how far noise bends it  */
    float level;    /**< share of the first layer */
    uint32_t seed;
};

struct gen_pattern gen_random_pattern(struct pbnds_rng *r);
/** In [0, 1]: 0 is the first layer, 1 the second. */
float gen_pattern_value(const struct gen_pattern *p, float u, float v);

#endif /* PBNDS_SCENES_PATTERN_H */
