/**
 * @file recipe.h
 * What a data set is asked for. With the assets' bytes it says everything: sample `index` of
 * a split is a pure function of (recipe, split, index), made alone, in any order, by any
 * process.
 */
#ifndef PBNDS_NEURAL_DATA_RECIPE_H
#define PBNDS_NEURAL_DATA_RECIPE_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

enum pbnds_split {
    PBNDS_SPLIT_TRAIN,
    PBNDS_SPLIT_VAL,
    PBNDS_SPLIT_TEST,
    PBNDS_SPLIT_COUNT
};

enum pbnds_dataset_format {
    PBNDS_DATASET_FOLDERS, /**< a folder a sample                                   */
    PBNDS_DATASET_TAR,     /**< WebDataset: tar files of `per_tar` samples          */
};

/** A file, or a folder searched for files. `share` of the samples of a split are made of
 *  it, however many files it has; sources of share 0 divide what is left by their number
 *  of files. */
struct pbnds_dataset_source {
    char *path;
    double share;
};

/** Strings are owned where the recipe came from pbnds_dataset_recipe_load(), borrowed where
 *  the caller filled it in. */
struct pbnds_dataset_recipe {
    struct pbnds_dataset_source *scenes; /**< .glb, .gltf                            */
    int scene_count;
    struct pbnds_dataset_source *envs; /**< .hdr, .exr                               */
    int env_count;
    /** Procedural worlds and light maps (scenes/generator) of each split; files of
     *  their own to the splits, as if they were in a folder of share world_share. */
    int worlds[PBNDS_SPLIT_COUNT], skies[PBNDS_SPLIT_COUNT];
    double world_share, sky_share;
    uint64_t world_seed;

    int count[PBNDS_SPLIT_COUNT]; /**< samples of each split                         */
    int width, height;
    int spp; /**< of the radiance                                               */
    uint64_t seed;
    bool every_split; /**< `count` came from one number: splits without assets are
                           left out, and their samples go to train                   */

    /** Shares of the samples (0 to 1) whose scene or light is changed on the way. */
    double randomize_materials; /**< factors drawn anew, textures kept               */
    double swap_textures;       /**< base colour and normal maps of other materials  */
    double mix_lights;          /**< light map plus another of the same split        */
    double hard_lights;         /**< small suns, single lamps, in place of the map   */
    double dark_lights;         /**< four stops darker                               */

    /** Targets beside radiance, direct light and the visibility of the cluster lights. */
    bool variance, ao;
    int olat;     /**< directions lit one at a time, 0: none                         */
    int olat_spp; /**< samples of each; 0: spp                                       */
    bool denoise; /**< a-trous on radiance and direct of train and val, never of test */

    enum pbnds_dataset_format format;
    int per_tar;
};

#ifdef __cplusplus
extern "C" {
#endif

const char *pbnds_split_name(enum pbnds_split split);

/** Defaults: 256x256 at 64 spp, no change of scene or light but 4 % dark ones, folders. */
void pbnds_dataset_recipe_init(struct pbnds_dataset_recipe *recipe);
/** `count` samples of all splits: a tenth val, a tenth test, the others train. */
void pbnds_dataset_recipe_count(struct pbnds_dataset_recipe *recipe, int count);
/** Reads a recipe file: a JSON object,
 *
 *     {"scenes": ["assets", {"path": "heads", "share": 0.1}], "envs": ["hdri"],
 *      "worlds": {"train": 500}, "world_share": 0.7, "world_seed": 1, "skies": {},
 *      "sky_share": 0, "count": {"train": 3000, "val": 100, "test": 0},
 *      "size": [128, 128], "spp": 64, "seed": 1, "format": "tar", "per_tar": 100,
 *      "materials": {"randomize": 0.2, "swap_textures": 0.1},
 *      "lights": {"mix": 0.1, "hard": 0.1, "dark": 0.04},
 *      "targets": {"variance": true, "ao": true, "olat": 8, "olat_spp": 16,
 *                  "denoise": false}, "about": "any text"}
 *
 *  in which any key may be missing (defaults) and no other may stand. Paths are below
 *  `root`; "" is the working folder. Free with pbnds_dataset_recipe_free().
 *  Errors: IO, FORMAT (the key and what is wanted), MEMORY. */
enum pbnds_status pbnds_dataset_recipe_load(const char *path, const char *root,
                                            struct pbnds_dataset_recipe *recipe,
                                            struct pbnds_error *error) PBNDS_NODISCARD;
/** The same from memory; `name` is for messages. */
enum pbnds_status pbnds_dataset_recipe_parse(const char *text, size_t size,
                                             const char *name, const char *root,
                                             struct pbnds_dataset_recipe *recipe,
                                             struct pbnds_error *error) PBNDS_NODISCARD;
/** Frees what load or parse made; never call it on borrowed strings. */
void pbnds_dataset_recipe_free(struct pbnds_dataset_recipe *recipe);
/** Adds everything but the paths and the counts of samples to a JSON object, by the keys
 *  of a recipe file. */
void pbnds_dataset_recipe_describe(const struct pbnds_dataset_recipe *recipe,
                                   cJSON *json);

/** Errors: ARGUMENT, with what is out of range. */
enum pbnds_status pbnds_dataset_recipe_check(const struct pbnds_dataset_recipe *recipe,
                                             struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_RECIPE_H */
