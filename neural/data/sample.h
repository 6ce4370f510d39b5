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
 * Data of other origin have fewer targets: photographs (`pbnds:target` display, sRGB decoded;
 * import_ffhq.h) have neither direct nor visibility.
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
    enum pbnds_target target;    /**< what radiance is */
    struct pbnds_image radiance; /**< or the photograph */
    struct pbnds_image direct;   /**< empty in photographs */
    uint32_t *visibility;        /**< width * height, owned; NULL in photographs */
    struct pbnds_envmap *envmap; /**< of light.exr */
};

/** What the files of a sample are made of, whoever made it. All borrowed. */
struct pbnds_sample_parts {
    const struct pbnds_gbuffer *gbuffer;
    const struct pbnds_gbuffer_origin *origin;
    const struct pbnds_image *radiance;
    const struct pbnds_exr_channel *extra; /**< further targets */
    int extra_count;
    const struct pbnds_image *light; /**< light.exr: 3 channels, gltf convention */
    const cJSON *json;               /**< sample.json */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Writes the three files into a folder that exists. Errors: IO, MEMORY. */
enum pbnds_status pbnds_sample_write_parts(const char *folder,
                                           const struct pbnds_sample_parts *parts,
                                           struct pbnds_error *error) PBNDS_NODISCARD;

/** The same of a draw. */
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
