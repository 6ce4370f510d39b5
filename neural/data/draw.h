/**
 * @file draw.h
 * What one sample shows: scene, camera and light, drawn from the assets by chance. A pure
 * function of (recipe, assets, split, index); nothing is written and nothing rendered but
 * the small G-buffers that judge cameras.
 *
 * Random numbers: one stream for each kind of choice, so that one more draw in one place
 * does not move the others.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_H
#define PBNDS_NEURAL_DATA_DRAW_H

#include <cjson/cJSON.h>

#include "engine/core/rng.h"
#include "engine/image/image.h"
#include "engine/scene/accel.h"
#include "engine/scene/camera.h"
#include "engine/scene/envmap.h"
#include "engine/scene/scene.h"
#include "neural/data/assets.h"

enum { PBNDS_DATASET_LIGHT_WIDTH = 256 };

enum pbnds_draw_stream {
    PBNDS_DRAW_ASSET,
    PBNDS_DRAW_CAMERA,
    PBNDS_DRAW_LIGHT,
    PBNDS_DRAW_TRACE,
    PBNDS_DRAW_MATERIAL,
    PBNDS_DRAW_OLAT,
};

/** The scene of the draw made last, kept for the next one. */
struct pbnds_drawer;

struct pbnds_draw {
    enum pbnds_split split;
    int index;
    const struct pbnds_asset *asset, *env;
    const struct pbnds_scene *scene; /**< the drawer's, until its next draw          */
    const struct pbnds_accel *accel; /**< likewise                                   */
    struct pbnds_camera camera;
    float yaw_deg, strength; /**< of the light map                                   */
    /** The light as it lights the scene: equirect, gltf convention, linear radiance,
     *  PBNDS_DATASET_LIGHT_WIDTH wide, 3 channels; owned. */
    struct pbnds_image light;
    cJSON *notes; /**< what was drawn, for sample.json; owned                        */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Finds, hashes and splits the assets; nothing is loaded yet. The recipe is borrowed. */
enum pbnds_status pbnds_drawer_create(const struct pbnds_dataset_recipe *recipe,
                                      struct pbnds_drawer **drawer,
                                      struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_drawer_free(struct pbnds_drawer *drawer);
const struct pbnds_asset_list *pbnds_drawer_scenes(const struct pbnds_drawer *drawer);
const struct pbnds_asset_list *pbnds_drawer_envs(const struct pbnds_drawer *drawer);
/** Samples that a split gets: the recipe's count, or what every_split makes of it. */
int pbnds_drawer_count(const struct pbnds_drawer *drawer, enum pbnds_split split);

/** The random numbers of one kind of choice of a sample. */
struct pbnds_rng pbnds_draw_rng(const struct pbnds_dataset_recipe *recipe,
                                enum pbnds_split split, int index,
                                enum pbnds_draw_stream stream);

/** Errors: of the asset or light map drawn, or ARGUMENT where no camera sees enough of
 *  the scene: this sample cannot be made, others may. */
enum pbnds_status pbnds_draw(struct pbnds_drawer *drawer, enum pbnds_split split,
                             int index, struct pbnds_draw *draw,
                             struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_draw_free(struct pbnds_draw *draw);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_DRAW_H */
