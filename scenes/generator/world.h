/**
 * @file world.h
 * A world under construction: objects made of parts (mesh + material), placed by node
 * transforms, and the glb file made of it.
 */
#ifndef PBNDS_SCENES_WORLD_H
#define PBNDS_SCENES_WORLD_H

#include "scenes/generator/mesh.h"
#include "scenes/generator/pack.h"
#include "scenes/generator/random.h"

struct gen_material {
    struct pbnds_vec3 base_color; /**< linear */
    float metallic, roughness;
    float ior, specular;              /**< written where they differ from 1.5 and 1 */
    struct pbnds_vec3 specular_color; /**< likewise from white */
    float normal_scale;
    int color_image, surface_image, normal_image; /**< -1: none */
    float repeat; /**< texture repeats over a mesh's unit of uv */
    bool double_sided;
    struct pbnds_vec3 emission; /**< radiance */
    bool unlit;
    float alpha;
    bool blend; /**< alphaMode BLEND; opaque otherwise */
};

struct gen_part {
    struct gen_mesh mesh;
    struct pbnds_vec3 *color; /**< of each vertex (COLOR_0, linear), owned; or NULL */
    int material;
    int twin; /**< part whose mesh this one shows as well (its own is empty), or -1 */
};

struct gen_object {
    int first_part, part_count;
    struct pbnds_vec3 translation;
    struct pbnds_vec4 rotation;
    float scale;
    const char *name; /**< NULL: object_N                                           */
    bool numbered;    /**< its number is put behind the name                        */
    struct pbnds_vec3 lo, hi; /**< bounds in the world, after gen_object_place() */
};

struct gen_camera {
    struct pbnds_vec3 eye, target;
    float yfov;
};

enum gen_light_kind { GEN_LIGHT_DIRECTIONAL, GEN_LIGHT_POINT, GEN_LIGHT_SPOT };

/** KHR_lights_punctual. */
struct gen_light {
    const char *name;
    enum gen_light_kind kind;
    struct pbnds_vec3 at, target, color;
    float intensity, range; /**< range 0: unlimited                                 */
    float inner, outer;     /**< of a spot: half angles, radians                    */
};

enum {
    GEN_MAX_PARTS = 256,
    GEN_MAX_OBJECTS = 128,
    GEN_MAX_MATERIALS = 128,
    GEN_MAX_IMAGES = 96,
    GEN_MAX_LIGHTS = 8,
    GEN_PALETTE = 5
};

/** Fixed room: what does not fit is left out (parts) or shared (materials). */
struct gen_world {
    struct gen_part parts[GEN_MAX_PARTS];
    int part_count;
    struct gen_object objects[GEN_MAX_OBJECTS];
    int object_count;
    struct gen_material materials[GEN_MAX_MATERIALS];
    int material_count;
    struct gen_bytes images[GEN_MAX_IMAGES]; /**< PNG files */
    int image_count;
    struct gen_camera camera; /**< "main"; yfov 0: none */
    struct gen_camera front;  /**< a second one, likewise */
    struct gen_light lights[GEN_MAX_LIGHTS];
    int light_count;
    struct pbnds_vec3 palette[GEN_PALETTE]; /**< colours that its materials share */
    int palette_count;
    const char *name; /**< of the scene; NULL: none */
    bool sketch; /**< to be set before: coarse meshes and tiny textures, for tests of
                           what is made rather than how */
    bool failed; /**< memory ran out */
};

void gen_world_free(struct gen_world *w);

/** Opens a new object; the parts added next belong to it. @return its index */
int gen_object_begin(struct gen_world *w);
/** Names the object opened last, a literal; its number is put behind. */
void gen_object_name(struct gen_world *w, const char *name);
/** Moves the mesh (normals made) into the object opened last. */
void gen_object_part(struct gen_world *w, struct gen_mesh *mesh, int material);
/** Shows the mesh of an earlier part once more, in another material. */
void gen_object_twin(struct gen_world *w, int part, int material);
/** Colours the part added last: `paint` gives the factor of the base colour at a point. */
void gen_object_paint(struct gen_world *w,
                      struct pbnds_vec3 (*paint)(const void *context,
                                                 struct pbnds_vec3 p),
                      const void *context);
const struct gen_mesh *gen_part_mesh(const struct gen_world *w, int part);
/** Centre and greatest extent of the parts before placement. */
void gen_object_extent(const struct gen_world *w, int object, struct pbnds_vec3 *centre,
                       float *extent);
/** Sets the pose and brings the bounds up to date. */
void gen_object_place(struct gen_world *w, int object, struct pbnds_vec3 translation,
                      struct pbnds_vec4 rotation, float scale);
/** Scales and shifts all objects: centre of the bounds to the origin, radius as given.
 */
void gen_world_normalize(struct gen_world *w, float radius);

struct gen_material gen_material_plain(struct pbnds_vec3 base_color, float metallic,
                                       float roughness);
bool gen_material_textured(const struct gen_material *m);
int gen_world_material(struct gen_world *w, const struct gen_material *material);
/** Encodes and keeps an image. @return its index, -1 when there is no room */
int gen_world_image(struct gen_world *w, const uint8_t *rgb, int width, int height);
/** The same in a fraction of the time, the file a little larger: for worlds, which are
 *  read once. */
int gen_world_texture(struct gen_world *w, const uint8_t *rgb, int width, int height);

/** Appends the binary glTF 2.0 file of the world. @return false when memory ran out, here
 *  or while the world was made */
bool gen_glb_make(const struct gen_world *w, struct gen_bytes *file);
/** Writes the same to disk, atomically. */
enum pbnds_status gen_glb_write(const struct gen_world *w, const char *path,
                                struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_SCENES_WORLD_H */
