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
    int texcoord; /**< which UV set, 0 or 1                                            */
    bool
        transformed; /**< false: `transform` is the identity and is not read              */
    float transform[6]; /**< KHR_texture_transform, rows of a 2x3 matrix:
                             u' = t[0] u + t[1] v + t[2], v' = t[3] u + t[4] v + t[5]      */
};

enum pbnds_alpha_mode { PBNDS_ALPHA_OPAQUE, PBNDS_ALPHA_MASK, PBNDS_ALPHA_BLEND };

/**
 * glTF metallic-roughness material. Colours linear Rec. 709.
 *
 * The non-metal part reflects, KHR_materials_ior and KHR_materials_specular:
 *     f0 = specular min(ior_f0 specular_color, 1),   f90 = specular
 * where textures multiply `specular` (alpha) and `specular_color` (rgb, sRGB).
 *
 * With specular_glossiness (KHR_materials_pbrSpecularGlossiness) there is no metal:
 *     base_color = diffuse (1 - max(f0)),   f0 = specular_color,   f90 = 1,
 *     roughness = 1 - (1 - `roughness`) specular_color_texture.a
 * where base_color holds the diffuse factor and specular_color_texture is the
 * specularGlossinessTexture (rgb sRGB, a linear).
 *
 * An unlit material (KHR_materials_unlit) emits its base colour and reflects nothing
 * (base_color, metallic, f0 and f90 are 0, roughness 1).
 */
struct pbnds_material {
    char name[64];
    struct pbnds_vec4
        base_color;            /**< factor, with alpha                               */
    float metallic, roughness; /**< factors                                          */
    float ior_f0;              /**< ((ior - 1) / (ior + 1))^2, 0.04 for ior 1.5      */
    float specular;            /**< factor                                           */
    struct pbnds_vec3
        specular_color;         /**< factor                                       */
    struct pbnds_vec3 emissive; /**< factor, radiance                                 */
    float normal_scale;
    float occlusion_strength; /**< ao = 1 + strength (texture.r - 1)                */
    enum pbnds_alpha_mode alpha_mode;
    float alpha_cutoff;
    bool double_sided, unlit, specular_glossiness;
    struct pbnds_texture_ref base_color_texture, metallic_roughness_texture,
        normal_texture, emissive_texture, occlusion_texture, specular_texture,
        specular_color_texture;
};

/** A material that has all defaults of glTF 2.0: white, metallic 1, roughness 1. */
struct pbnds_material pbnds_material_default(void);

/** What a hit interpolates, in one place: [3] of the first two are the UV's u and v. */
struct pbnds_vertex {
    float position_u[4], normal_v[4], tangent[4];
};

/** One primitive of one node, transformed to world space. Arrays owned by the scene;
 *  absent attributes are NULL. */
struct pbnds_mesh {
    char name[64];
    size_t vertex_count, triangle_count;
    struct pbnds_vec3
        *position; /**< metres                                            */
    struct pbnds_vec3 *previous; /**< position at the earlier time, for motion vectors;
                                      NULL: at rest, or no earlier time was asked for   */
    struct pbnds_vec3 *normal; /**< unit; NULL: use the face normal                   */
    struct pbnds_vec4
        *tangent; /**< unit xyz, w = +-1 (already negated if mirrored)   */
    struct pbnds_vec2 *uv[2];
    struct pbnds_vec4 *color; /**< COLOR_0, linear                                   */
    struct pbnds_vertex
        *packed;     /**< the above again, for packets of rays (packet.h); or NULL    */
    uint32_t *index; /**< 3 * triangle_count, counter-clockwise in front    */
    int material;
    uint32_t
        object_id; /**< index of the glTF node, and into scene.objects             */
};

enum pbnds_light_kind { PBNDS_LIGHT_DIRECTIONAL, PBNDS_LIGHT_POINT, PBNDS_LIGHT_SPOT };

/** KHR_lights_punctual. Its photometric units are taken as radiometric ones, as the light
 *  map's are: intensity is W m^-2 (directional: irradiance of a facing surface) or
 *  W sr^-1 (point, spot), linear Rec. 709, colour included. */
struct pbnds_light {
    char name[64];
    enum pbnds_light_kind kind;
    struct pbnds_vec3
        position; /**< world, metres                                     */
    struct pbnds_vec3
        direction; /**< unit, world: the way the light travels            */
    struct pbnds_vec3 intensity;
    float range; /**< metres, INFINITY: unlimited                       */
    float cos_inner,
        cos_outer; /**< of the spot's half angles                         */
};

/** What a glTF node is called. */
struct pbnds_object {
    char name[64];
};

struct pbnds_scene {
    struct pbnds_mesh *meshes;
    int mesh_count;
    struct pbnds_material
        *materials; /**< at least one: the glTF default is appended   */
    int material_count;
    struct pbnds_texture *textures;
    int texture_count;
    struct pbnds_pixels *images;
    int image_count;
    struct pbnds_maps
        *maps; /**< owned, prefiltered (maps.h); NULL: only the finest level is read */
    struct pbnds_camera
        *cameras; /**< of the file, in node order                       */
    struct pbnds_camera
        *previous_cameras; /**< at the earlier time; NULL: none asked   */
    int camera_count;
    struct pbnds_light
        *lights; /**< of the file, in node order                         */
    int light_count;
    struct pbnds_object
        *objects; /**< one a glTF node                                  */
    int object_count;
    struct pbnds_vec3 lo,
        hi; /**< bounds of all vertices                               */
    size_t triangle_count;
};

/** Where a ray met a triangle. */
struct pbnds_hit {
    float t;    /**< distance along the unit direction, metres                       */
    float u, v; /**< barycentric weights of vertices 1 and 2                         */
    uint32_t
        mesh; /**< index into scene.meshes; UINT32_MAX: nothing was hit            */
    uint32_t triangle;
};

/** Everything a BRDF needs to know about a point. Normals face wo's side. */
struct pbnds_surface {
    struct pbnds_vec3 position;
    struct pbnds_vec3 ng; /**< unit geometric normal, dot(ng, wo) >= 0            */
    struct pbnds_vec3 n;  /**< unit shading normal (normal map applied), in ng's
                                     hemisphere, made to face wo (contract) and to mirror
                                     wo above the face: dot(2 dot(n, wo) n - wo, ng) is
                                     at least 0.01, or half of dot(ng, wo)              */
    struct pbnds_vec3 base_color, emission;
    float metallic, roughness;
    struct pbnds_vec3
        f0;    /**< of the non-metal part: reflectance at normal incidence  */
    float f90; /**< of the non-metal part: reflectance at grazing incidence  */
    float alpha;
    float occlusion; /**< of the occlusion map, 1: open; not used by any light     */
    struct pbnds_vec2 uv;
    uint32_t object_id;
    int material;
};

#ifdef __cplusplus
extern "C" {
#endif

void pbnds_scene_free(struct pbnds_scene *scene);

/** Interpolates and evaluates the material at a hit; wo is unit, to the eye. Back faces of
 *  one-sided materials are as if double sided: rays other than the camera's meet them.
 *  @param footprint  width of the ray's cone at the hit, metres, across the ray: textures
 *                    are averaged over it (mip maps); 0: finest level */
void pbnds_scene_surface(const struct pbnds_scene *scene, const struct pbnds_hit *hit,
                         struct pbnds_vec3 wo, float footprint,
                         struct pbnds_surface *surface);
/** The contract's "faces the eye": n, or, where it looks away from wo, n turned toward wo
 *  by the smallest angle that makes dot(n, wo) slightly positive. Both are unit. */
struct pbnds_vec3 pbnds_face_eye(struct pbnds_vec3 n, struct pbnds_vec3 wo);
/** Where the point of the hit was at the earlier time, world; where it is now, to the
 *  bit, when its mesh is at rest. */
struct pbnds_vec3 pbnds_scene_previous(const struct pbnds_scene *scene,
                                       const struct pbnds_hit *hit);
/** Alpha only, for intersection filters; 1 for opaque materials. */
float pbnds_scene_alpha(const struct pbnds_scene *scene, const struct pbnds_hit *hit);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_SCENE_H */
