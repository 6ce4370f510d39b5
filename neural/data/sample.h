/**
 * @file sample.h
 * A sample's files, written and read:
 *
 *     sample.exr    contract G-buffer and the targets: R, G, B reference radiance;
 *                   direct.{R,G,B}; visibility (uint)
 *     light.exr     the light map as it lit the scene: gltf convention, yaw, strength and
 *                   exposure baked in; R, G, B
 *     sample.json   what was drawn: asset, light, yaw, strength, field of view, spp, seed
 *
 * In a folder of their own, or one after another in a WebDataset tar as KEY.sample.exr,
 * KEY.light.exr, KEY.sample.json.
 */
#ifndef PBNDS_NEURAL_DATA_SAMPLE_H
#define PBNDS_NEURAL_DATA_SAMPLE_H

#include "neural/data/targets.h"

/** One sample in memory. */
struct pbnds_sample {
    char path[512];
    struct pbnds_gbuffer gbuffer;
    struct pbnds_image radiance, direct;
    uint32_t *visibility;        /**< width * height, owned */
    struct pbnds_envmap *envmap; /**< of light.exr */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Writes the three files into a folder that exists. Errors: IO, MEMORY. */
enum pbnds_status pbnds_sample_write(const char *folder,
                                     const struct pbnds_dataset_recipe *recipe,
                                     const struct pbnds_draw *draw,
                                     const struct pbnds_targets *targets,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

/** `path` is one of a pbnds_sample_list (store.h), or a folder. */
enum pbnds_status pbnds_sample_load(const char *path, struct pbnds_sample *sample,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_sample_free(struct pbnds_sample *sample);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_SAMPLE_H */
