/**
 * @file cut.h
 * What a training step sees of a sample: a window of it, mirrored left to right or not,
 * more or less exposed.
 *
 * Mirrored is the whole scene with its lights, in the plane through the camera's y and z
 * axes: M = C diag(-1, 1, 1) C^-1 for world_from_camera C. A reflected scene under
 * reflected light gives the reflected picture. To say it without touching the light map:
 * the same world seen by the mirrored camera C diag(-1, 1, 1). In camera space every x
 * changes its sign (normals, directions to the eye and to the lights), the horizon of
 * azimuth a is that of pi - a, and what belongs to a pixel and a light (visibility, march)
 * goes with the pixel.
 *
 * Exposure: light and what it makes are multiplied by 2^stops, which linear light allows.
 */
#ifndef PBNDS_NEURAL_TRAIN_CUT_H
#define PBNDS_NEURAL_TRAIN_CUT_H

#include "neural/train/item.h"

struct pbnds_cut {
    struct pbnds_window window; /**< inside the image */
    bool mirror;
    float stops; /**< 0 in photographs: their values are not linear */
};

#ifdef __cplusplus
extern "C" {
#endif

/** `out` becomes a sample of the window's size that borrows the light map of `item`; of its
 *  camera only the rotation means something. Errors: MEMORY. */
enum pbnds_status pbnds_train_item_cut(const struct pbnds_train_item *item,
                                       const struct pbnds_cut *cut,
                                       struct pbnds_train_item *out,
                                       struct pbnds_error *error) PBNDS_NODISCARD;
/** In place of pbnds_train_item_free() for what was cut. */
void pbnds_train_cut_free(struct pbnds_train_item *item);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_CUT_H */
