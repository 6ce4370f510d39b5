/**
 * @file assets.h
 * The scenes and light maps that a data set is made of: found, hashed, split, weighted.
 *
 * Splits: the deepest folder named train, val or test, below or at the path given,
 * decides; others go by a hash of their file stem (80 / 10 / 10). Procedural ones are made
 * for their split. A file in two splits, by its bytes or its name, is refused.
 */
#ifndef PBNDS_NEURAL_DATA_ASSETS_H
#define PBNDS_NEURAL_DATA_ASSETS_H

#include "neural/data/recipe.h"

struct pbnds_asset {
    char *path;      /**< NULL: procedural                                      */
    uint64_t number; /**< of a procedural one, for the generator                */
    char stem[96];   /**< file name without its extension                       */
    uint64_t hash;   /**< xxh64 of the file's bytes (of the .gltf alone)        */
    enum pbnds_split split;
    int source;   /**< index in the recipe's list; its count: procedural     */
    double below; /**< sum of the weights before it in its split, in [0, 1)  */
};

/** Sorted by (split, stem), so that the order of arguments does not matter. */
struct pbnds_asset_list {
    struct pbnds_asset *items;
    int count;
    int first[PBNDS_SPLIT_COUNT + 1]; /**< items of split s: [first[s], first[s + 1]) */
};

enum pbnds_asset_kind { PBNDS_ASSET_SCENE, PBNDS_ASSET_LIGHT };

#ifdef __cplusplus
extern "C" {
#endif

/** The split of a name that nothing else decides: 80 / 10 / 10 by its hash. */
enum pbnds_split pbnds_split_of_name(const char *stem);

/** The recipe's scenes or light maps. Errors: IO, ARGUMENT (nothing found, or two of the
 *  same stem or bytes in different splits), MEMORY. */
enum pbnds_status pbnds_assets_find(const struct pbnds_dataset_recipe *recipe,
                                    enum pbnds_asset_kind kind,
                                    struct pbnds_asset_list *list,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_assets_free(struct pbnds_asset_list *list);

/** The asset of a split at u in [0, 1); NULL where the split has none. */
const struct pbnds_asset *pbnds_assets_pick(const struct pbnds_asset_list *list,
                                            enum pbnds_split split, double u);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_ASSETS_H */
