/**
 * @file scene.h
 * What the ray caster sees: triangles in world space, materials, textures, cameras.
 * Loaded from glTF 2.0 (gltf.h) and immutable afterwards.
 */
#ifndef PBNDS_ENGINE_SCENE_SCENE_H
#define PBNDS_ENGINE_SCENE_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/vec.h"
#include "engine/scene/camera.h"
#include "engine/scene/texture.h"

/** Reference from a material to a texture; texture < 0 means none. */
struct pbnds_texture_ref {
    int texture;
    int texcoord; /**< which UV set, 0 or 1 */
};

enum pbnds_alpha_mode { PBNDS_ALPHA_OPAQUE, PBNDS_ALPHA_MASK, PBNDS_ALPHA_BLEND };

/** glTF metallic-roughness material. Colours linear Rec. 709. */
struct pbnds_material {
    char name[64];
    struct pbnds_vec4 base_color; /**< factor, with alpha                               */
    float metallic, roughness;    /**< factors                                          */
    float dielectric_f0;          /**< reflectance of the non-metal part, 0.04 for ior 1.5 */
    struct pbnds_vec3 emissive;   /**< factor, radiance                                 */
    float normal_scale;
    enum pbnds_alpha_mode alpha_mode;
    float alpha_cutoff;
    bool double_sided;
    struct pbnds_texture_ref base_color_texture, metallic_roughness_texture, normal_texture,
        emissive_texture;
};

/** One primitive of one node, transformed to world space. Arrays owned by the scene;
 *  absent attributes are NULL. */
struct pbnds_mesh {
    char name[64];
    size_t vertex_count, triangle_count;
    struct pbnds_vec3 *position; /**< metres                                            */
    struct pbnds_vec3 *normal;   /**< unit; NULL: use the face normal                   */
    struct pbnds_vec4 *tangent;  /**< unit xyz, w = +-1 (already negated if mirrored)   */
    struct pbnds_vec2 *uv[2];
    struct pbnds_vec4 *color;    /**< COLOR_0, linear                                   */
    uint32_t *index;             /**< 3 * triangle_count, counter-clockwise in front    */
    int material;
    uint32_t object_id; /**< index of the glTF node                                     */
};

struct pbnds_scene {
    struct pbnds_mesh *meshes;
    int mesh_count;
    struct pbnds_material *materials; /**< at least one: the glTF default is appended   */
    int material_count;
    struct pbnds_texture *textures;
    int texture_count;
    struct pbnds_pixels *images;
    int image_count;
    struct pbnds_camera *cameras; /**< of the file, in node order                       */
    int camera_count;
    struct pbnds_vec3 lo, hi; /**< bounds of all vertices                               */
    size_t triangle_count;
};

/** Where a ray met a triangle. */
struct pbnds_hit {
    float t;       /**< distance along the unit direction, metres                       */
    float u, v;    /**< barycentric weights of vertices 1 and 2                         */
    uint32_t mesh; /**< index into scene.meshes; UINT32_MAX: nothing was hit            */
    uint32_t triangle;
};

/** Everything a BRDF needs to know about a point. Normals face wo's side. */
struct pbnds_surface {
    struct pbnds_vec3 position;
    struct pbnds_vec3 ng;       /**< unit geometric normal, dot(ng, wo) >= 0            */
    struct pbnds_vec3 n;        /**< unit shading normal (normal map applied), in ng's
                                     hemisphere and made to face wo (contract)          */
    struct pbnds_vec3 base_color, emission;
    float metallic, roughness;
    float dielectric_f0;
    float alpha;
    struct pbnds_vec2 uv;
    uint32_t object_id;
};

#ifdef __cplusplus
extern "C" {
#endif

void pbnds_scene_free(struct pbnds_scene *scene);

/** Interpolates and evaluates the material at a hit; wo is unit, to the eye. Back faces of
 *  one-sided materials are seen as if double sided (the ray hit them all the same). */
void pbnds_scene_surface(const struct pbnds_scene *scene, const struct pbnds_hit *hit,
                         struct pbnds_vec3 wo, struct pbnds_surface *surface);
/** The contract's "faces the eye": n, or, where it looks away from wo, n turned toward wo
 *  by the smallest angle that makes dot(n, wo) slightly positive. Both are unit. */
struct pbnds_vec3 pbnds_face_eye(struct pbnds_vec3 n, struct pbnds_vec3 wo);
/** Alpha only, for intersection filters; 1 for opaque materials. */
float pbnds_scene_alpha(const struct pbnds_scene *scene, const struct pbnds_hit *hit);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_SCENE_H */
