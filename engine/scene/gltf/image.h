/**
 * @file image.h
 * Textures and images of a glTF file: only those that a material samples are decoded and
 * kept, so they are numbered anew. Private to the loader.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_IMAGE_H
#define PBNDS_ENGINE_SCENE_GLTF_IMAGE_H

#include "engine/scene/gltf/load.h"

/** Numbers in the scene of what the document numbers, -1: not used (yet). */
struct pbnds_gltf_remap {
    int *texture;
    int *image;
    int64_t *fallback; /**< image of the document that stands in for an image, or -1 */
};

/** Room for all textures and images that the scene can have. Errors: MEMORY. */
enum pbnds_status pbnds_gltf_remap_init(struct pbnds_gltf_load_state *g,
                                        struct pbnds_gltf_remap *map) PBNDS_NODISCARD;
void pbnds_gltf_remap_free(struct pbnds_gltf_remap *map);

/** The scene's number of a texture of the document; -1 when there is none, or none that
 *  has an image in a format that can be read (which is told). */
int pbnds_gltf_add_texture(struct pbnds_gltf_load_state *g,
                           struct pbnds_gltf_remap *map, int64_t index);

/** Fetches and decodes every image that a texture uses. Errors: IO, FORMAT, UNSUPPORTED,
 *  MEMORY, INTERRUPTED; the sentence names the image. */
enum pbnds_status
pbnds_gltf_decode_images(struct pbnds_gltf_load_state *g,
                         const struct pbnds_gltf_remap *map) PBNDS_NODISCARD;

#endif /* PBNDS_ENGINE_SCENE_GLTF_IMAGE_H */
