/**
 * @file import_ffhq.h
 * Photographs with their estimated maps and light (ffhq_layout.h) as a data set that
 * trainers and judges read like a rendered one (sample.h).
 *
 * Conventions, kept and recorded in dataset.json and every sample.json:
 * - the frame is the camera's: it stands at the origin, looks down -z, +y up; normals are
 *   PNG * 2 - 1 in it, and the light is in it;
 * - the light map is rolled by half a turn from the `pbnds` convention into `gltf`
 *   (envmap.h); one wider than PBNDS_DATASET_LIGHT_WIDTH is averaged down to that;
 * - the horizontal field of view h becomes the vertical v: tan(v/2) = tan(h/2) H / W;
 * - R, G, B are the photograph with its sRGB decoded, pbnds:target is `display`
 *   (gbuffer.h), and there is no direct light and no visibility;
 * - alpha is the coverage: 0 is nothing hit, and the photograph is black there;
 * - albedo is decoded from sRGB; roughness and specular are taken as they are: specular is
 *   the reflectance at normal incidence, 0 to 1; metallic is 0, there is no such map;
 * - depth is taken as it is; its unit is not known. Positions follow from it and the
 *   camera. Where it is missing it is 1 everywhere, where it is not positive nothing was
 *   hit, and sample.json says which of `as given`, `constant`, `missing` it is.
 *
 * Splits: ffhq_layout.h. Nothing says who is in a picture, so that one person may be in
 * two splits. Samples are numbered within their split in the order of the IDs; sample.json
 * says the ID. A folder whose pictures or splits changed makes another data set.
 */
#ifndef PBNDS_NEURAL_DATA_IMPORT_FFHQ_H
#define PBNDS_NEURAL_DATA_IMPORT_FFHQ_H

#include "engine/core/report.h"
#include "neural/data/recipe.h"

struct pbnds_ffhq_options {
    float
        yfov; /**< vertical field of view, radians, of pictures that pred_fov.json gives
                     none from 1 to 170 degrees; 0: these are left out              */
    enum pbnds_dataset_format format;
    int per_tar; /**< samples of a tar; 0: the default                              */
};

struct pbnds_ffhq_result {
    int count[PBNDS_SPLIT_COUNT]; /**< samples that the data set now has, of this DIR */
    int left_out;                 /**< broken, or in none of the split files         */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Makes the data set `to` of the folder `from`, or what is missing of it: samples that are
 *  there are kept, so that a run that was stopped goes on where it was. A picture that
 *  lacks a file or has a damaged one is left out (quarantined, store.h, and tried again by
 *  the next run); `to`/import.json lists these and the pictures in no split with their
 *  reasons, and so do warnings (the first hundred).
 *  Errors: FORMAT where nothing could be imported, IO, ARGUMENT (`to` is another data set),
 *  MEMORY, INTERRUPTED. */
enum pbnds_status pbnds_import_ffhq(const char *from, const char *to,
                                    const struct pbnds_ffhq_options *options,
                                    const struct pbnds_report *report,
                                    struct pbnds_ffhq_result *result,
                                    struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_IMPORT_FFHQ_H */
