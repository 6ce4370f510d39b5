/**
 * @file shim.h
 * The structure of a glTF file as plain C, read by tinygltf (gltf/shim.cpp is the only
 * file that includes it). Nothing here is checked beyond JSON types: indices may be out
 * of range, counts absurd. load.c and its helpers check before they use.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_SHIM_H
#define PBNDS_ENGINE_SCENE_GLTF_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

/** GL constants, as glTF stores them. */
enum pbnds_gltf_component {
    PBNDS_GLTF_BYTE = 5120,
    PBNDS_GLTF_UBYTE = 5121,
    PBNDS_GLTF_SHORT = 5122,
    PBNDS_GLTF_USHORT = 5123,
    PBNDS_GLTF_UINT = 5125,
    PBNDS_GLTF_FLOAT = 5126,
};

/** EXT_meshopt_compression of a bufferView. */
struct pbnds_gltf_meshopt {
    bool present;
    int64_t buffer, offset, length, stride, count; /**< < 0: not a whole number */
    const char *mode, *filter;
};

struct pbnds_gltf_view {
    int64_t buffer;
    uint64_t offset, length, stride; /**< stride 0: tightly packed */
    struct pbnds_gltf_meshopt meshopt;
    uint8_t *unpacked; /**< NULL, or what packed.c decoded: `length` bytes, owned by the
                            load that did */
};

struct pbnds_gltf_accessor {
    int64_t view; /**< < 0: zeros */
    uint64_t offset, count;
    int component; /**< enum pbnds_gltf_component or anything else */
    int width;     /**< 1 SCALAR, 2 to 4 VECn, 16 MAT4, 0 anything else */
    bool normalized, sparse;
    int64_t sparse_count, sparse_index_view, sparse_index_offset, sparse_value_view,
        sparse_value_offset;
    int sparse_index_component;
    int64_t draco_id;  /**< of an attribute in a compressed mesh, -1: its indices */
    uint8_t *unpacked; /**< NULL, or what packed.c decoded: `count` packed elements,
                            owned by the load that did */
};

/** KHR_draco_mesh_compression of one primitive. Its accessors are copies of those that
 *  the file names, made for it alone: `first` (the indices) and those after it. */
struct pbnds_gltf_draco {
    int64_t mesh, view;
    size_t first, count;
    bool
        counted; /**< the file says how many indices there are: TRIANGLES, not a strip */
};

/** Modes of a primitive; those below are points and lines. */
enum pbnds_gltf_mode {
    PBNDS_GLTF_TRIANGLES = 4,
    PBNDS_GLTF_STRIP = 5,
    PBNDS_GLTF_FAN = 6,
};

/** Displacements of one morph target; < 0 means absent. */
struct pbnds_gltf_target {
    int64_t position, normal, tangent;
};

/** JOINTS_n with its WEIGHTS_n. */
struct pbnds_gltf_influence {
    int64_t joints, weights;
};

/** Accessors of one primitive; < 0 means absent. */
struct pbnds_gltf_primitive {
    int64_t position, normal, tangent, uv[2], color, indices;
    int64_t material;
    const struct pbnds_gltf_mapping *mappings;
    size_t mapping_count;
    int mode; /**< 0 points ... 4 triangles, 5 strip, 6 fan */
    const struct pbnds_gltf_influence *influences; /**< n = 0, 1, ... without a gap */
    size_t influence_count;
    const struct pbnds_gltf_target *targets;
    size_t target_count;
};

struct pbnds_gltf_mesh {
    const char *name;
    const struct pbnds_gltf_primitive *primitives;
    size_t primitive_count;
    const double *weights; /**< of the morph targets */
    size_t weight_count;
};

/** EXT_mesh_gpu_instancing: accessors, < 0: absent. */
struct pbnds_gltf_instancing {
    bool present;
    int64_t translation, rotation, scale;
};

struct pbnds_gltf_node {
    const char *name;
    int64_t mesh, skin, camera, light;
    const int *children;
    size_t child_count;
    const double *matrix, *translation, *rotation, *scale, *weights;
    size_t matrix_count, translation_count, rotation_count, scale_count, weight_count;
    struct pbnds_gltf_instancing instancing;
};

struct pbnds_gltf_list {
    const int *items;
    size_t count;
};

struct pbnds_gltf_scene {
    const char *name;
    struct pbnds_gltf_list nodes;
};

struct pbnds_gltf_skin {
    const char *name;
    struct pbnds_gltf_list joints;
    int64_t inverse_bind; /**< accessor, < 0: identity */
};

enum pbnds_gltf_path {
    PBNDS_GLTF_TRANSLATION,
    PBNDS_GLTF_ROTATION,
    PBNDS_GLTF_SCALE,
    PBNDS_GLTF_WEIGHTS,
    PBNDS_GLTF_OTHER_PATH,
};

enum pbnds_gltf_interpolation {
    PBNDS_GLTF_LINEAR,
    PBNDS_GLTF_STEP,
    PBNDS_GLTF_CUBICSPLINE,
    PBNDS_GLTF_OTHER_INTERPOLATION,
};

struct pbnds_gltf_channel {
    int64_t sampler, node; /**< node < 0: none of ours, to be ignored */
    enum pbnds_gltf_path path;
};

struct pbnds_gltf_animation_sampler {
    int64_t input, output; /**< accessors */
    enum pbnds_gltf_interpolation interpolation;
};

struct pbnds_gltf_animation {
    const char *name;
    const struct pbnds_gltf_channel *channels;
    const struct pbnds_gltf_animation_sampler *samplers;
    size_t channel_count, sampler_count;
};

/** KHR_lights_punctual, with its defaults filled in. */
struct pbnds_gltf_light {
    const char *name, *type;
    double color[3], intensity;
    double range;        /**< 0: unlimited */
    double inner, outer; /**< half angles of a spot, radians */
};

struct pbnds_gltf_camera {
    const char *name;
    bool orthographic;
    double yfov, ymag;
};

/** KHR_texture_transform's texCoord is in texcoord already. */
struct pbnds_gltf_texture_info {
    int64_t index, texcoord;
    bool transformed;
    double offset[2], rotation, scale[2];
};

/** With specular_glossiness base_color holds the diffuse factor and texture, roughness
 *  1 - glossinessFactor, specular_color the specularFactor and the
 *  specularGlossinessTexture: the meaning that struct pbnds_material gives them. */
struct pbnds_gltf_material {
    const char *name, *alpha_mode;
    double base_color[4], metallic, roughness, emissive[3], emissive_strength;
    double normal_scale, occlusion_strength, alpha_cutoff, ior, specular,
        specular_color[3];
    bool double_sided, unlit, specular_glossiness;
    struct pbnds_gltf_texture_info base_color_texture, metallic_roughness_texture,
        normal_texture, emissive_texture, occlusion_texture, specular_texture,
        specular_color_texture;
};

struct pbnds_gltf_texture {
    int64_t sampler;
    int64_t image;    /**< EXT_texture_webp's where there is one */
    int64_t fallback; /**< the other one where EXT_texture_webp's was taken, else -1 */
};

/** An image: a bufferView, or < 0 and the URI that pbnds_gltf_scan() took out. */
struct pbnds_gltf_image {
    int64_t view;
    const char *mime_type; /**< of a bufferView's image; "" where none is given */
};

/** KHR_materials_variants: what a primitive wears in a variant. */
struct pbnds_gltf_mapping {
    int64_t material;
    const int *variants;
    size_t variant_count;
};

struct pbnds_gltf_sampler {
    int mag_filter, wrap_s, wrap_t;
};

struct pbnds_gltf_document {
    const char *version, *min_version;
    const char *const *extensions_used, *const *extensions_required;
    size_t extensions_used_count, extensions_required_count;
    struct pbnds_gltf_view *views;
    struct pbnds_gltf_accessor *accessors;
    struct pbnds_gltf_mesh *meshes;
    struct pbnds_gltf_node *nodes;
    struct pbnds_gltf_scene *scenes;
    struct pbnds_gltf_animation *animations;
    struct pbnds_gltf_light *lights;
    struct pbnds_gltf_skin *skins;
    struct pbnds_gltf_camera *cameras;
    struct pbnds_gltf_material *materials;
    struct pbnds_gltf_texture *textures;
    struct pbnds_gltf_sampler *samplers;
    struct pbnds_gltf_image *images;
    struct pbnds_gltf_draco *dracos;
    const char *const *variants; /**< names */
    size_t view_count, accessor_count, mesh_count, node_count, scene_count, skin_count,
        camera_count, material_count, texture_count, sampler_count, image_count,
        buffer_count, animation_count, light_count, draco_count, variant_count;
    int64_t scene;     /**< default scene, < 0: none named */
    const char *notes; /**< what the parser grumbled about, may be empty */
    void *owner;       /**< what every pointer above points into */
};

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Parses the JSON of a glTF file. No file is opened and no payload is read: the text
 * must have been through pbnds_gltf_scan(), which takes buffers and URIs out of it.
 * `name` is for the message. Errors: FORMAT, MEMORY.
 */
enum pbnds_status pbnds_gltf_parse(const char *json, size_t size, const char *name,
                                   struct pbnds_gltf_document *document,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_gltf_document_free(struct pbnds_gltf_document *document);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_GLTF_SHIM_H */
