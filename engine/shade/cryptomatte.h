/**
 * @file cryptomatte.h
 * Mattes of every object and material, by the names that the scene gives them.
 *
 * Cryptomatte specification 1.2.0 (Friedman and Jones 2015, "Fully Automatic ID Mattes
 * with Support for Motion Blur and Transparency"): a name is hashed with MurmurHash3_32,
 * seed 0, over its UTF-8 bytes; the 32 bits are read as a float whose exponent is kept in
 * [1, 254], so that no id is zero, denormal, infinite or NaN. Each pixel lists ids and
 * the share of the pixel that each covers, the greatest first: its ranks. In a file the
 * ranks 2 k and 2 k + 1 are the channels NAME0k.R (id) .G (share) and .B (id) .A (share).
 */
#ifndef PBNDS_ENGINE_SHADE_CRYPTOMATTE_H
#define PBNDS_ENGINE_SHADE_CRYPTOMATTE_H

#include <stddef.h>
#include <stdint.h>

#include "engine/scene/scene.h"

enum {
    PBNDS_CRYPTOMATTE_RANKS = 6,  /**< kept of each pixel; what is beyond is dropped */
    PBNDS_CRYPTOMATTE_LAYERS = 2, /**< CryptoObject and CryptoMaterial, in this order */
};

struct pbnds_cryptomatte_layer {
    char name[32];
    char
        *manifest; /**< JSON, {"name":"8 hex digits of the id", ...}, owned           */
    float
        *id[PBNDS_CRYPTOMATTE_RANKS]; /**< width x height, 0 where the rank is unused */
    float *share[PBNDS_CRYPTOMATTE_RANKS];
};

struct pbnds_cryptomatte {
    int width, height;
    struct pbnds_cryptomatte_layer layers[PBNDS_CRYPTOMATTE_LAYERS];
    void *storage; /**< of all planes, owned */
};

/** One candidate for a rank. */
struct pbnds_cryptomatte_part {
    uint32_t id; /**< pbnds_cryptomatte_id() */
    float share;
};

#ifdef __cplusplus
extern "C" {
#endif

/** MurmurHash3_x86_32, Austin Appleby 2011 (public domain). */
uint32_t pbnds_murmur3_32(const void *bytes, size_t size, uint32_t seed);
/** Bits of the float that stands for a name. */
uint32_t pbnds_cryptomatte_id(const char *name);

/** What a mesh is filed under: the name of its node or material, "node_12" or
 *  "material_3" where that is empty. out has room for 64 bytes. */
void pbnds_cryptomatte_object_name(const struct pbnds_scene *scene,
                                   const struct pbnds_mesh *mesh, char out[64]);
void pbnds_cryptomatte_material_name(const struct pbnds_scene *scene,
                                     const struct pbnds_mesh *mesh, char out[64]);

/** Empty planes and no manifests. Errors: MEMORY. */
enum pbnds_status pbnds_cryptomatte_create(int width, int height,
                                           struct pbnds_cryptomatte **cryptomatte,
                                           struct pbnds_error *error) PBNDS_NODISCARD;
/** The manifests of everything that has a mesh. Errors: MEMORY. */
enum pbnds_status pbnds_cryptomatte_name(struct pbnds_cryptomatte *cryptomatte,
                                         const struct pbnds_scene *scene,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_cryptomatte_free(struct pbnds_cryptomatte *cryptomatte);

/** Stores the ranks of pixel i. Parts of the same id are added up first (two nodes may
 *  have one name); equal shares stay in the order in which they came. The parts are
 *  reordered. */
void pbnds_cryptomatte_store(const struct pbnds_cryptomatte_layer *layer, size_t i,
                             struct pbnds_cryptomatte_part *parts, int count);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_CRYPTOMATTE_H */
