/** Draco meshes for the tests: libdraco's encoder behind C. */
#ifndef PBNDS_TESTS_SCENE_GLTF_ENCODE_DRACO_H
#define PBNDS_TESTS_SCENE_GLTF_ENCODE_DRACO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** One attribute of every point; its place in the list is its unique id plus 10. */
struct encode_attribute {
    int kind; /**< 0 position, 1 normal, 2 colour, 3 texture coordinates, 4 other */
    int component; /**< GL constant, as in glTF */
    int width;
    bool normalized;
    int bits; /**< to quantise floats to; 0: lossless */
    const void *data;
};

struct encode_mesh {
    size_t points, faces;
    const uint32_t *index;
    const struct encode_attribute *attributes;
    int attribute_count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Encodes; `edgebreaker` reorders the points, else they stay in order. Equal values of
 *  an attribute are merged first, so that its seams are real ones.
 *  @return bytes written, 0 where it failed or `room` was too small */
size_t encode_draco(const struct encode_mesh *mesh, bool edgebreaker, uint8_t *out,
                    size_t room);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_TESTS_SCENE_GLTF_ENCODE_DRACO_H */
