/**
 * @file load.h
 * What the files of the glTF loader share: load.c (nodes, cameras), gltf/access.c
 * (typed reads), gltf/mesh.c (primitives), gltf/material.c, gltf/image.c and
 * gltf/variant.c (looks), gltf/packed.c (compressed geometry), gltf/extensions.c.
 * Private.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_LOAD_H
#define PBNDS_ENGINE_SCENE_GLTF_LOAD_H

#include "engine/core/mat4.h"
#include "engine/core/report.h"
#include "engine/scene/gltf.h"
#include "engine/scene/gltf/shim.h"
#include "engine/scene/gltf/source.h"
#include "engine/scene/scene.h"

/** What all geometry of a scene may take. */
#define PBNDS_GLTF_MAX_GEOMETRY ((uint64_t)8 << 30)

/** A load in progress. */
struct pbnds_gltf_load_state {
    const char *name;
    const struct pbnds_report *report;
    struct pbnds_error *error;
    const struct pbnds_gltf_options *options; /**< never NULL */
    struct pbnds_gltf_source source;
    struct pbnds_gltf_document doc;
    struct pbnds_scene *scene;
    struct pbnds_mat4 *world;  /**< of each node                                */
    bool *in_scene;            /**< node belongs to the scene that is loaded    */
    uint64_t geometry_bytes;   /**< of the meshes so far, against a bomb        */
    size_t skipped_primitives; /**< points and lines                            */
    int64_t variant;           /**< KHR_materials_variants, < 0: none            */
    bool morphs, more_joints, more_texcoords; /**< seen, for a warning */
};

/** Copies a name into 64 bytes, cut at a whole UTF-8 character; `what N` if it is
 * empty. */
void pbnds_gltf_name(char out[64], const char *name, const char *what, size_t index);

/** Every reference of the document leads somewhere, every view lies in its buffer.
 *  Errors: FORMAT. After it indices between nodes, meshes, materials, textures, images,
 *  skins, cameras and accessors are known to exist. */
enum pbnds_status pbnds_gltf_check(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;

/** Accessor `index`, checked against its buffer (the whole range lies inside) and
 * against `width` components. Errors: FORMAT, IO. `what` names the user in messages. */
enum pbnds_status
pbnds_gltf_accessor_at(struct pbnds_gltf_load_state *g, int64_t index, int width,
                       const char *what,
                       const struct pbnds_gltf_accessor **accessor) PBNDS_NODISCARD;
/** Bytes of one element; 0 where the accessor's type is unknown. */
uint64_t pbnds_gltf_element_size(const struct pbnds_gltf_accessor *accessor);
/** Do `count` elements of `element` > 0 bytes from `offset`, `stride` apart (0:
 * packed), lie inside of an existing view? FORMAT otherwise. */
enum pbnds_status pbnds_gltf_check_range(struct pbnds_gltf_load_state *g,
                                         const char *what, int64_t view,
                                         uint64_t offset, uint64_t count,
                                         uint64_t element,
                                         uint64_t stride) PBNDS_NODISCARD;
/** count * width floats, integers normalised where the accessor says so, sparse values
 *  applied. Every value must be finite. */
enum pbnds_status pbnds_gltf_read_floats(struct pbnds_gltf_load_state *g,
                                         const struct pbnds_gltf_accessor *accessor,
                                         const char *what, float *out) PBNDS_NODISCARD;
/** count unsigned integers below `limit` of a SCALAR accessor. */
enum pbnds_status pbnds_gltf_read_indices(struct pbnds_gltf_load_state *g,
                                          const struct pbnds_gltf_accessor *accessor,
                                          uint64_t limit,
                                          uint32_t *out) PBNDS_NODISCARD;
/** `size` bytes of an existing buffer from `offset`. FORMAT where it has fewer. */
enum pbnds_status pbnds_gltf_buffer_bytes(struct pbnds_gltf_load_state *g,
                                          int64_t buffer, uint64_t offset,
                                          uint64_t size,
                                          const uint8_t **data) PBNDS_NODISCARD;
/** The bytes of buffer view `index`, decompressed where they are compressed. */
enum pbnds_status pbnds_gltf_view_bytes(struct pbnds_gltf_load_state *g, int64_t index,
                                        const char *what, const uint8_t **data,
                                        uint64_t *size) PBNDS_NODISCARD;

/** Refuses a file that requires what is not read, tells what else is not. Errors:
 *  UNSUPPORTED, with the names of all and what to convert with. */
enum pbnds_status
pbnds_gltf_check_extensions(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;

/** Finds options->variant, by name or index. Errors: ARGUMENT, with a list of them. */
enum pbnds_status
pbnds_gltf_find_variant(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;
/** Do the materials of a primitive's variants exist? FORMAT otherwise. */
enum pbnds_status
pbnds_gltf_check_mappings(struct pbnds_gltf_load_state *g,
                          const struct pbnds_gltf_primitive *p) PBNDS_NODISCARD;
/** The scene's material of a primitive, in the variant that was asked for. */
int pbnds_gltf_material_of(const struct pbnds_gltf_load_state *g,
                           const struct pbnds_gltf_primitive *p);

/** Are the ranges of compressed geometry sound? FORMAT otherwise. */
enum pbnds_status
pbnds_gltf_check_packed(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;
/** Fills view->unpacked of a compressed view. Errors: FORMAT, IO, MEMORY. */
enum pbnds_status pbnds_gltf_unpack_view(struct pbnds_gltf_load_state *g,
                                         int64_t index) PBNDS_NODISCARD;
/** Fills accessor->unpacked for every Draco mesh of the scene. Errors: FORMAT, IO,
 *  UNSUPPORTED, MEMORY. */
enum pbnds_status
pbnds_gltf_unpack_meshes(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;
void pbnds_gltf_free_unpacked(struct pbnds_gltf_load_state *g);

/** Materials (the default one last), textures and decoded images. */
enum pbnds_status pbnds_gltf_materials(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;
/** Appends the primitives of one node's mesh to the scene, which has room for them. */
enum pbnds_status pbnds_gltf_node_meshes(struct pbnds_gltf_load_state *g,
                                         size_t node) PBNDS_NODISCARD;

#endif /* PBNDS_ENGINE_SCENE_GLTF_LOAD_H */
