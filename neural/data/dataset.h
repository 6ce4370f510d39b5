/**
 * @file dataset.h
 * Training data: samples of (G-buffer, light map, reference radiance) made from glTF
 * scenes and HDRIs. Every sample is a pure function of (recipe, seed, id).
 *
 * On disk:
 *     DIR/dataset.json       recipe; assets and light maps with their split and hash
 *     DIR/{train,val,test}/ID/
 *         sample.exr         contract G-buffer and the targets below
 *         light.exr          the light map as it lit the scene: gltf convention, yaw,
 *                            strength and exposure baked in; R, G, B
 *         sample.json        asset, light map, yaw, strength, field of view, spp, seed
 *
 * Targets in sample.exr: R, G, B reference radiance (linear); direct.{R,G,B} its part
 * that reached the surface directly; visibility (uint): bit i is 1 where cluster light i
 * (envmap.h, PBNDS_DATASET_LIGHTS of light.exr) is seen from the pixel.
 *
 * Splits: the deepest folder named train, val or test, below or at the path given,
 * decides; others go by a hash of their file stem (80 / 10 / 10). A sample's asset and light map
 * are always of the same split, so test scenes and test lights are both unseen.
 */
#ifndef PBNDS_NEURAL_DATA_DATASET_H
#define PBNDS_NEURAL_DATA_DATASET_H

#include "engine/core/report.h"
#include "engine/scene/envmap.h"
#include "engine/shade/gbuffer.h"

enum { PBNDS_DATASET_LIGHTS = 32, PBNDS_DATASET_LIGHT_WIDTH = 256 };

enum pbnds_split {
    PBNDS_SPLIT_TRAIN,
    PBNDS_SPLIT_VAL,
    PBNDS_SPLIT_TEST,
    PBNDS_SPLIT_COUNT
};

/** What `pbnds dataset` is asked for. Strings are borrowed. */
struct pbnds_dataset_recipe {
    const char *const *scenes; /**< .glb/.gltf files, or folders searched for them */
    int scene_count;
    const char *const *envs; /**< .hdr/.exr files, or folders searched for them */
    int env_count;
    int count;      /**< samples in all; 10 % val, 10 % test where those splits
                         have assets and lights                          */
    int only_split; /**< enum pbnds_split, or -1: all of them */
    int width, height, spp;
    uint64_t seed;
    int shard, shard_count; /**< makes ids with id % shard_count == shard */
};

/** One sample in memory. */
struct pbnds_sample {
    char path[512];
    struct pbnds_gbuffer gbuffer;
    struct pbnds_image radiance, direct;
    uint32_t *visibility;        /**< width * height, owned */
    struct pbnds_envmap *envmap; /**< of light.exr */
};

/** The list of a data set's samples of one split, in id order. */
struct pbnds_sample_list {
    char **folders; /**< owned */
    int count;
};

#ifdef __cplusplus
extern "C" {
#endif

const char *pbnds_split_name(enum pbnds_split split);

/** Makes the data set, or what is missing of it: samples that are there are kept, so a
 * killed run goes on where it stopped. A DIR made by another recipe is refused
 * (ARGUMENT). A sample whose asset or light map cannot be read is skipped with a
 * warning that says why. */
enum pbnds_status pbnds_dataset_make(const struct pbnds_dataset_recipe *recipe,
                                     const char *dir, const struct pbnds_report *report,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

enum pbnds_status pbnds_dataset_list(const char *dir, enum pbnds_split split,
                                     struct pbnds_sample_list *list,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_sample_list_free(struct pbnds_sample_list *list);
/** Hash of the data set's manifest and the names of its samples, 16 hex digits. */
enum pbnds_status pbnds_dataset_hash(const char *dir, char hash[17],
                                     struct pbnds_error *error) PBNDS_NODISCARD;

enum pbnds_status pbnds_sample_load(const char *folder, struct pbnds_sample *sample,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_sample_free(struct pbnds_sample *sample);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DATASET_H */
