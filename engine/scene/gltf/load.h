/**
 * @file load.h
 * What the files of the glTF loader share. Private. In the order of a load:
 * extensions.c, check.c (references), variant.c, nodes.c (the tree, its scene),
 * animation.c (poses), material.c and image.c (looks), packed.c (compressed geometry),
 * budget.c (room), camera.c, light.c, mesh.c (with primitive.c, morph.c, skin.c,
 * instancing.c, place.c); contents.c lists; access.c reads typed data for all of them.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_LOAD_H
#define PBNDS_ENGINE_SCENE_GLTF_LOAD_H

#include "engine/core/mat4.h"
#include "engine/core/report.h"
#include "engine/scene/gltf.h"
#include "engine/scene/gltf/shim.h"
#include "engine/scene/gltf/source.h"
#include "engine/scene/scene.h"

/** Where every node of the document is at one time. */
struct pbnds_gltf_pose {
    double time;              /**< seconds; read where the load has an animation      */
    struct pbnds_mat4 *world; /**< of each node, in the scene or not                  */
};

/** The joint matrices of a skin in each pose, made when they are first wanted. */
struct pbnds_gltf_joints {
    struct pbnds_mat4 *world[2];
};

/** A load in progress. */
struct pbnds_gltf_load_state {
    const char *name;
    const struct pbnds_report *report;
    struct pbnds_error *error;
    const struct pbnds_gltf_options *options; /**< never NULL after the open */
    struct pbnds_gltf_source source;
    struct pbnds_gltf_document doc;
    struct pbnds_scene *scene;
    const struct pbnds_gltf_animation *animation; /**< NULL: as the nodes say     */
    struct pbnds_gltf_pose pose[2];   /**< now, and at the earlier time             */
    int pose_count;                   /**< 2 where motion was asked for             */
    int64_t *weights_channel;         /**< of the animation, for each node; < 0: none */
    struct pbnds_gltf_joints *joints; /**< of each skin; NULL: none yet           */
    bool *in_scene;          /**< node belongs to the scene that is loaded        */
    uint64_t geometry_bytes; /**< that are in use now, against max_geometry       */
    uint64_t max_geometry;
    uint64_t work_bytes; /**< that were read so far, again and again              */
    size_t skipped_primitives; /**< points and lines                               */
    int64_t variant;           /**< KHR_materials_variants, < 0: none              */
    bool more_texcoords, skinned_instances, matrix_animated; /**< seen, for a warning */
};

/** A file as it was read, and the folder that its URIs start from. */
struct pbnds_gltf_file {
    uint8_t *bytes;
    size_t size;
    char *folder;
};

enum pbnds_status pbnds_gltf_read_file(const char *path,
                                       const struct pbnds_gltf_options *options,
                                       struct pbnds_gltf_file *file,
                                       struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_gltf_file_free(struct pbnds_gltf_file *file);
/** The structure of a file, sound enough to look into. g has its name, options, report and
 *  error; to be closed in every case. */
enum pbnds_status pbnds_gltf_open(struct pbnds_gltf_load_state *g, const void *bytes,
                                  size_t size, const char *folder) PBNDS_NODISCARD;
void pbnds_gltf_close(struct pbnds_gltf_load_state *g);

/** Copies a name into 64 bytes, cut at a whole UTF-8 character; `what N` if it is
 * empty. */
void pbnds_gltf_name(char out[64], const char *name, const char *what, size_t index);
/** Item of a list that the user chose by its name, else by its number. `name` gives the
 *  name of item i. Errors: ARGUMENT, which calls the list's items `what`. */
typedef const char *pbnds_gltf_namer(const struct pbnds_gltf_document *document,
                                     size_t i);
enum pbnds_status pbnds_gltf_choose(struct pbnds_gltf_load_state *g, const char *wanted,
                                    const char *what, size_t count,
                                    pbnds_gltf_namer *name,
                                    size_t *chosen) PBNDS_NODISCARD;

/** Every reference of the document leads somewhere, every view lies in its buffer.
 *  Errors: FORMAT. After it indices between nodes, meshes, materials, textures, images,
 *  skins, cameras, lights, animations and accessors are known to exist. */
enum pbnds_status pbnds_gltf_check(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;

/* ---- access.c ---- */

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
/** The same of `count` elements from element `first` on, which the accessor has. */
enum pbnds_status pbnds_gltf_read_some(struct pbnds_gltf_load_state *g,
                                       const struct pbnds_gltf_accessor *accessor,
                                       const char *what, uint64_t first, uint64_t count,
                                       float *out) PBNDS_NODISCARD;
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

/* ---- budget.c ---- */

/** Takes count * size bytes from what the geometry may use, before they are allocated.
 *  Errors: MEMORY. */
enum pbnds_status pbnds_gltf_charge(struct pbnds_gltf_load_state *g, uint64_t count,
                                    uint64_t size) PBNDS_NODISCARD;
/** Gives back what was charged and is free again. */
void pbnds_gltf_refund(struct pbnds_gltf_load_state *g, uint64_t count, uint64_t size);
/** Notes that count * size bytes of the file are about to be read. Errors: MEMORY, where
 *  a file asks for the same too often; INTERRUPTED. */
enum pbnds_status pbnds_gltf_work(struct pbnds_gltf_load_state *g, uint64_t count,
                                  uint64_t size) PBNDS_NODISCARD;
/** Room for every mesh, camera, light and object of the scene. A file that asks for more
 *  geometry than the budget is refused here, before anything is built. */
enum pbnds_status pbnds_gltf_make_room(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;

/* ---- nodes.c, animation.c ---- */

/** A node's own transform. */
struct pbnds_gltf_trs {
    const double *matrix; /**< 16 numbers that are used instead; NULL: none */
    double translation[3], rotation[4], scale[3];
};

/** Its matrix; a rotation of length zero is none. */
struct pbnds_mat4 pbnds_gltf_matrix(const struct pbnds_gltf_trs *trs);
/** Which nodes the scene has and where they are: fills in_scene, pose[].world.
 *  Errors: FORMAT (not a tree), ARGUMENT (no such scene), MEMORY. */
enum pbnds_status
pbnds_gltf_place_nodes(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;
/** Index of the animation of the options: fills animation, pose[].time, pose_count,
 *  weights_channel. Errors: ARGUMENT (no such animation), MEMORY. */
enum pbnds_status
pbnds_gltf_choose_animation(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;
/** Puts the nodes where the animation has them at `time`. Errors: FORMAT, IO. */
enum pbnds_status pbnds_gltf_animate(struct pbnds_gltf_load_state *g, double time,
                                     struct pbnds_gltf_trs *nodes) PBNDS_NODISCARD;
/** The weights of a node's morph targets in a pose: of the animation, else of the node,
 *  else of its mesh, else 0. Errors: FORMAT, IO. */
enum pbnds_status pbnds_gltf_morph_weights(struct pbnds_gltf_load_state *g,
                                           const struct pbnds_gltf_pose *pose,
                                           size_t node, size_t count,
                                           float *weights) PBNDS_NODISCARD;
/** The last key time of an animation. Errors: FORMAT, IO. */
enum pbnds_status pbnds_gltf_animation_end(struct pbnds_gltf_load_state *g,
                                           const struct pbnds_gltf_animation *animation,
                                           double *seconds) PBNDS_NODISCARD;

/* ---- camera.c, light.c ---- */

/** Rotation and translation of a transform: scale, shear and mirroring do not turn what
 *  looks along -z (glTF 2.0, section 3.10.1). */
struct pbnds_mat4 pbnds_gltf_rigid(const struct pbnds_mat4 *m);
/** Appends the node's camera to the scene, which has room. Errors: FORMAT. */
enum pbnds_status pbnds_gltf_add_camera(struct pbnds_gltf_load_state *g,
                                        size_t node) PBNDS_NODISCARD;
/** Appends the node's light to the scene, which has room. Errors: FORMAT. */
enum pbnds_status pbnds_gltf_add_light(struct pbnds_gltf_load_state *g,
                                       size_t node) PBNDS_NODISCARD;

/** Materials (the default one last), textures and decoded images. */
enum pbnds_status pbnds_gltf_materials(struct pbnds_gltf_load_state *g) PBNDS_NODISCARD;
/** Appends the primitives of one node's mesh to the scene, which has room for them. */
enum pbnds_status pbnds_gltf_node_meshes(struct pbnds_gltf_load_state *g,
                                         size_t node) PBNDS_NODISCARD;

/* ---- what mesh.c builds with ---- */

/** A primitive being built. */
struct pbnds_gltf_build {
    struct pbnds_gltf_load_state *g;
    const struct pbnds_gltf_primitive *primitive;
    size_t node;
    struct pbnds_mesh mesh; /**< in the frame of the mesh, later of the world       */
    size_t file_vertices;   /**< vertex_count of the file                           */
    uint32_t *origin;  /**< which vertex of the file each is; NULL: the same        */
    bool own_tangents; /**< not the file's                                          */
};

/** A vertex attribute of the file as floats, malloc'd and charged; NULL when accessor is
 *  negative. Errors: FORMAT, IO, MEMORY. */
enum pbnds_status pbnds_gltf_read_attribute(struct pbnds_gltf_build *b,
                                            int64_t accessor, int width,
                                            const char *what,
                                            float **out) PBNDS_NODISCARD;
enum pbnds_status pbnds_gltf_no_memory(struct pbnds_gltf_load_state *g);

/** primitive.c: fills position, normal, tangent, uv and color of b->mesh, and
 *  file_vertices. Errors: FORMAT, IO, UNSUPPORTED, MEMORY. */
enum pbnds_status pbnds_gltf_read_vertices(struct pbnds_gltf_build *b) PBNDS_NODISCARD;
/** primitive.c: fills index and triangle_count; strips and fans become lists. Errors: as
 *  above. */
enum pbnds_status pbnds_gltf_read_triangles(struct pbnds_gltf_build *b) PBNDS_NODISCARD;

/** place.c: unit vector, or zero where there is no direction. */
struct pbnds_vec3 pbnds_gltf_direction(struct pbnds_vec3 v);
/** place.c: where a normal or tangent is missing (zero in the file, or crushed by a scale
 *  of zero): the mean of the faces around, and any tangent. Errors: MEMORY. */
enum pbnds_status pbnds_gltf_mesh_repair(struct pbnds_gltf_load_state *g,
                                         struct pbnds_mesh *m) PBNDS_NODISCARD;
/** place.c: bytes of the arrays of a mesh, at least. */
uint64_t pbnds_gltf_mesh_size(const struct pbnds_mesh *m);
void pbnds_gltf_mesh_free(struct pbnds_mesh *m);
/** place.c: one mesh of the scene for each instance, of which `local` are the transforms
 *  in the frame of the node, or one that the joints place. The scene has room; b->mesh is
 *  empty afterwards. Errors: FORMAT (not finite), IO, MEMORY. */
enum pbnds_status pbnds_gltf_add_instances(struct pbnds_gltf_build *b,
                                           const struct pbnds_mat4 *local,
                                           uint64_t count) PBNDS_NODISCARD;
enum pbnds_status pbnds_gltf_add_skinned(struct pbnds_gltf_build *b) PBNDS_NODISCARD;

/** Moves the vertices to where the morph targets have them: position, normal and tangent
 *  as in pose 0, previous as in pose 1. Errors: FORMAT, IO, MEMORY. */
enum pbnds_status pbnds_gltf_morph(struct pbnds_gltf_build *b) PBNDS_NODISCARD;

/** The influences of a skinned primitive. */
struct pbnds_gltf_skinning {
    const struct pbnds_gltf_joints *joints; /**< borrowed                           */
    size_t joint_count, sets;
    float **index, **weight; /**< `sets` arrays, 4 a vertex of the file            */
};

/** Is the primitive skinned? Reads its influences, checked to be joints of the skin.
 *  To be freed in every case. Errors: FORMAT, IO, MEMORY. */
bool pbnds_gltf_is_skinned(const struct pbnds_gltf_build *b);
enum pbnds_status
pbnds_gltf_skin_open(struct pbnds_gltf_build *b,
                     struct pbnds_gltf_skinning *skin) PBNDS_NODISCARD;
void pbnds_gltf_skin_close(struct pbnds_gltf_build *b,
                           struct pbnds_gltf_skinning *skin);
/** Frees what skins left in g->joints. */
void pbnds_gltf_free_joints(struct pbnds_gltf_load_state *g);
/** World transform of vertex `vertex` of the file in pose `pose`. */
struct pbnds_mat4 pbnds_gltf_skin_matrix(const struct pbnds_gltf_skinning *skin,
                                         int pose, size_t vertex);

/** How often EXT_mesh_gpu_instancing has a node's mesh; 1 without it. Errors: FORMAT. */
enum pbnds_status pbnds_gltf_instance_count(struct pbnds_gltf_load_state *g,
                                            size_t node,
                                            uint64_t *count) PBNDS_NODISCARD;
/** The transforms of the instances in the frame of their node, `count` as above.
 *  Errors: FORMAT, IO, MEMORY. */
enum pbnds_status pbnds_gltf_instances(struct pbnds_gltf_load_state *g, size_t node,
                                       uint64_t count,
                                       struct pbnds_mat4 *local) PBNDS_NODISCARD;

#endif /* PBNDS_ENGINE_SCENE_GLTF_LOAD_H */
