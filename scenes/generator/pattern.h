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
    GEN_TILES,    /**< squares with joints                                     */
    GEN_PLANKS,   /**< boards of a floor, each with its own grain              */
    GEN_HEXAGONS, /**< honeycomb                                               */
    GEN_CHEVRON,  /**< zigzag stripes                                          */
    GEN_PLAID,    /**< crossing bands of several widths                        */
    GEN_DOTS,     /**< regular rows of discs                                   */
    GEN_RINGS,    /**< concentric                                              */
    GEN_TEXT,     /**< lines of marks like writing                             */
    GEN_BLOCKS,   /**< random squares, like a matrix code                      */
    GEN_GRADIENT, /**< slow change from one side to the other and back         */
    GEN_BLOTCHES, /**< sharp-edged patches: camouflage, rust, peeled paint     */
    GEN_BRUSHED,  /**< fine streaks                                            */
    GEN_TERRAZZO, /**< chips in a matrix                                       */
    GEN_SPECKLE,  /**< fine grains                                             */
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

/** What a pattern is at a point. */
struct gen_texel {
    float value; /**< in [0, 1]: 0 is the first layer, 1 the second        */
    float id;    /**< in [0, 1): the same over one tile, board, stone, chip */
};

struct gen_pattern gen_random_pattern(struct pbnds_rng *r);
struct gen_texel gen_pattern_at(const struct gen_pattern *p, float u, float v);
float gen_pattern_value(const struct gen_pattern *p, float u, float v);

#endif /* PBNDS_SCENES_PATTERN_H */
