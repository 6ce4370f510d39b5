/**
 * @file sample.h
 * A sample's files, written and read. All light is linear, W m^-2 sr^-1, Rec. 709, of the
 * part of a pixel that something covers:
 *
 *     sample.exr    contract G-buffer and the targets:
 *                   R, G, B            reference radiance; A: coverage
 *                   direct.{R,G,B}     of it, what came from no other surface, and what the
 *                                      first one emits
 *                   indirect.{R,G,B}   the rest
 *                   variance.{R,G,B}   of the mean that R, G, B are (pathtrace.h), as it
 *                                      was before any denoising; where the recipe asks
 *                   visibility (uint)  bit i: cluster light i of light.exr is seen
 *                   ao.R               share of a uniform sky's irradiance that arrives
 *                                      (engine/shade/openness.h); where the recipe asks
 *     light.exr     the light map as it lit the scene, to the bit: gltf convention, yaw,
 *                   strength and exposure baked in; R, G, B
 *     sample.json   what was drawn: asset, light, yaw, strength, field of view, spp, seed
 *     olat.exr      one light at a time, where the recipe asks: olat.NN.{R,G,B} for light
 *                   NN = 00, 01, ...: the radiance under that directional light alone, of
 *                   irradiance 1 W m^-2 on a plane that faces it, all bounces, no emission;
 *                   olat_visibility (uint), bit NN: light NN is seen. sample.json lists the
 *                   directions (olat.wi: unit, to the light, world)
 *
 * Where the recipe asks, radiance, its parts and the lights of train and val are denoised
 * (atrous.h), and sample.json says `"denoised": true`; samples of test never are.
 *
 * Light is half where that loses nothing, else float (pack.h), so what a glowing surface
 * reflects is known to 2^-12 of what it emits; the variance is float of 8 significant bits.
 *
 * Data of other origin have fewer targets: photographs (`pbnds:target` display, sRGB decoded;
 * import_ffhq.h) have neither direct nor visibility.
 *
 * In a folder of their own, or one after another in a WebDataset tar as KEY.sample.exr,
 * KEY.light.exr, KEY.sample.json and KEY.olat.exr.
 */
#ifndef PBNDS_NEURAL_DATA_SAMPLE_H
#define PBNDS_NEURAL_DATA_SAMPLE_H

#include "neural/data/targets.h"

/** Parts of a sample that not everybody wants to hold in memory. */
enum pbnds_sample_part {
    PBNDS_SAMPLE_VARIANCE = 1u << 0,
    PBNDS_SAMPLE_OLAT = 1u << 1,
};

/** One sample in memory. The traced ambient occlusion, where there is one, is the
 *  G-buffer's `ao`. */
struct pbnds_sample {
    char path[512];
    struct pbnds_gbuffer gbuffer;
    enum pbnds_target target;    /**< what radiance is */
    struct pbnds_image radiance; /**< or the photograph */
    struct pbnds_image direct;   /**< empty in photographs */
    struct pbnds_image variance; /**< empty: not there, or not asked for            */
    uint32_t *visibility;        /**< width * height, owned; NULL in photographs */
    struct pbnds_envmap *envmap; /**< of light.exr */
    struct pbnds_olat olat;      /**< count 0: not there, or not asked for          */
};

/** What the files of a sample are made of, whoever made it. All borrowed. */
struct pbnds_sample_parts {
    const struct pbnds_gbuffer *gbuffer;
    const struct pbnds_gbuffer_origin *origin;
    const struct pbnds_image *radiance; /**< NULL: `extra` has R, G, B and A          */
    const struct pbnds_exr_channel *extra; /**< further targets */
    int extra_count;
    const struct pbnds_image *light; /**< light.exr: 3 channels, gltf convention */
    const struct pbnds_olat *olat;   /**< NULL: none                                  */
    const cJSON *json;               /**< sample.json */
};

#ifdef __cplusplus
extern "C" {
#endif

/** i-th file of a sample, NULL past the end. The last ones may be missing. */
const char *pbnds_sample_file(int i);

/** Writes the files into a folder that exists. Errors: IO, MEMORY, FORMAT (a target is not
 *  finite). */
enum pbnds_status pbnds_sample_write_parts(const char *folder,
                                           const struct pbnds_sample_parts *parts,
                                           struct pbnds_error *error) PBNDS_NODISCARD;

/** The same of a draw. */
enum pbnds_status pbnds_sample_write(const char *folder,
                                     const struct pbnds_dataset_recipe *recipe,
                                     const struct pbnds_draw *draw,
                                     const struct pbnds_targets *targets,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

/** `path` is one of a pbnds_sample_list (store.h), or a folder. `parts`: PBNDS_SAMPLE_*
 *  bits of what is wanted where it is there. */
enum pbnds_status pbnds_sample_load(const char *path, unsigned parts,
                                    struct pbnds_sample *sample,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_sample_free(struct pbnds_sample *sample);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_SAMPLE_H */
