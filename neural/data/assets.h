/**
 * @file assets.h
 * The scenes and light maps that a data set is made of: found, hashed, split.
 */
#ifndef PBNDS_NEURAL_DATA_ASSETS_H
#define PBNDS_NEURAL_DATA_ASSETS_H

#include "neural/data/dataset.h"

struct pbnds_asset {
    char *path;
    char stem[96]; /**< file name without its extension */
    uint64_t hash; /**< xxh64 of the file's bytes (of the .gltf alone) */
    enum pbnds_split split;
};

/** Sorted by (split, stem), so that the order of arguments does not matter. */
struct pbnds_asset_list {
    struct pbnds_asset *items;
    int count;
    int first[PBNDS_SPLIT_COUNT + 1]; /**< items of split s: [first[s], first[s + 1]) */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Files with one of the extensions (".glb", ...; NULL-terminated list), given directly
 * or found in folders and their subfolders. Errors: IO, ARGUMENT (nothing found, or two
 * of the same stem in different splits), MEMORY. */
enum pbnds_status pbnds_assets_find(const char *const *paths, int count,
                                    const char *const *extensions,
                                    struct pbnds_asset_list *list,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_assets_free(struct pbnds_asset_list *list);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_ASSETS_H */
