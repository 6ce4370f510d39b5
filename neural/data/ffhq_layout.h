/**
 * @file ffhq_layout.h
 * The folders of FFHQ-PBR and CelebA-PBR: photographs with their estimated maps and light.
 *
 *     DIR/bgremoval/SUB/ID.png                     the photograph, RGBA: alpha is the mask
 *     DIR/texture/KIND/SUB/KIND_ID.png             albedo, normal, roughness, specular
 *     DIR/texture/depth/SUB/depth_ID.exr
 *     DIR/hdri/SUB/hdri_ID.exr                     the light, equirect
 *     DIR/pred_fov.json                            {"ID": horizontal degrees, ...}
 *     DIR/train.txt, val.txt, test.txt             one ID a line; ours, optional
 *
 * Split by these files where there are any (a picture in none of them is in no split),
 * else by the hash of the ID, as other data sets are split.
 *
 * SUB is any folder (FFHQ-PBR: by thousands, 05000/05030.png) or none; ID is a number.
 */
#ifndef PBNDS_NEURAL_DATA_FFHQ_LAYOUT_H
#define PBNDS_NEURAL_DATA_FFHQ_LAYOUT_H

#include <stdbool.h>
#include <stdint.h>

#include "engine/shade/import.h"
#include "neural/data/picture_list.h"
#include "neural/data/recipe.h"

struct pbnds_ffhq_picture {
    int index;   /**< ID as a number; -1: its name is none, or another's too    */
    int split;   /**< enum pbnds_split; -1: none, as index < 0 or split files say */
    int number;  /**< among the pictures of its split, in order of index        */
    char id[64]; /**< as the files are named                                    */
    char folder[128]; /**< SUB, or ""                                                */
};

struct pbnds_ffhq_layout {
    const char *dir;                     /**< borrowed                               */
    struct pbnds_ffhq_picture *pictures; /**< in order of index, owned               */
    int count;
    int split_count[PBNDS_SPLIT_COUNT]; /**< pictures of each split               */
    const struct pbnds_ffhq_picture *
        *in_split[PBNDS_SPLIT_COUNT]; /**< by number, owned */
    uint64_t hash;                    /**< of the IDs, their folders and splits */
    struct pbnds_picture_list fov;    /**< degrees; empty where there is no such file */
    struct pbnds_picture_list splits; /**< enum pbnds_split                          */
    bool has_splits;                  /**< are there split files?                    */
};

/** Files of one picture. */
struct pbnds_ffhq_paths {
    struct pbnds_import_paths maps; /**< depth may be ""                             */
    char light[1400];
};

#ifdef __cplusplus
extern "C" {
#endif

/** Lists the pictures and reads the lists beside them. `dir` must outlive it. Errors: IO
 *  (dir cannot be read), FORMAT (not this layout, a damaged list, a picture in two
 *  splits), MEMORY. */
enum pbnds_status pbnds_ffhq_layout_read(const char *dir,
                                         struct pbnds_ffhq_layout *layout,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_ffhq_layout_free(struct pbnds_ffhq_layout *layout);

/** Where its files are. Errors: FORMAT where one other than depth is missing. */
enum pbnds_status pbnds_ffhq_paths_of(const struct pbnds_ffhq_layout *layout,
                                      const struct pbnds_ffhq_picture *picture,
                                      struct pbnds_ffhq_paths *paths,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_FFHQ_LAYOUT_H */
