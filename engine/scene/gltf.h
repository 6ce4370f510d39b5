/**
 * @file gltf.h
 * glTF 2.0 (.gltf with its files, .glb) to a scene.
 *
 * Trusts nothing: every index, offset and count is checked in 64 bits before use; files
 * are looked for below the folder of the .gltf only (no absolute path, no .., no scheme
 * but data:); images are capped (oiio.h). Vertices must be finite.
 *
 * Extensions read: KHR_draco_mesh_compression, KHR_lights_punctual, KHR_materials_ior,
 * _specular, _emissive_strength, _unlit, _variants, _pbrSpecularGlossiness,
 * KHR_mesh_quantization, KHR_texture_transform, EXT_mesh_gpu_instancing,
 * EXT_meshopt_compression, EXT_texture_webp. All others are told of and left out: of
 * layered materials (clearcoat, sheen, iridescence, anisotropy) the base stays, and what
 * light would go through (transmission, volume) is opaque with its base colour. A file
 * that requires such an extension is refused.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_H
#define PBNDS_ENGINE_SCENE_GLTF_H

#include "engine/core/report.h"
#include "engine/scene/scene.h"

/** What to take of the file, and how far to trust it. Zeros are the defaults. */
struct pbnds_gltf_options {
    const char
        *scene; /**< name or index; NULL: the file's default                     */
    const char
        *variant; /**< KHR_materials_variants, by name or index; NULL: none        */
    const char
        *animation; /**< name or index; NULL: the first                              */
    bool posed;     /**< the animation poses the scene at `time`; else it is as the
                                nodes say                                                   */
    double time;    /**< seconds, clamped to the animation's range                   */
    bool motion;    /**< also keep where everything was at `earlier` (posed only)    */
    double earlier; /**< seconds                                                     */
    bool allow_external; /**< files outside of the folder may be opened: absolute paths,
                                .., links that lead out; schemes other than data: never     */
    uint64_t
        max_geometry; /**< bytes of all vertices and indices; 0: 8 GiB                 */
    uint64_t
        max_images; /**< bytes of all decoded images; 0: 8 GiB                       */
    uint64_t max_file;  /**< bytes of any one file; 0: 2 GiB                         */
    int max_image_side; /**< pixels; 0: 16384                                        */
};

/** One of the things that a file has several of. */
struct pbnds_gltf_item {
    char name[64];  /**< of the file, or "scene 0" where it gives none            */
    double seconds; /**< of an animation: when its last key is                    */
    size_t count;   /**< of a scene: root nodes; of a skin: joints; of an
                         animation: channels                                      */
};

/** What options may choose from, in the order of the file. */
struct pbnds_gltf_contents {
    struct pbnds_gltf_item *scenes, *animations, *variants, *skins;
    size_t scene_count, animation_count, variant_count, skin_count;
    size_t default_scene; /**< that is loaded when none is chosen */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Loads one scene of the file; options NULL: the defaults. What is skipped (points, lines,
 * unknown extensions that are not required, ...) is told through report->warn. `scene` is empty on failure. Errors:
 * IO (missing, unreadable), FORMAT (not glTF, truncated, index out of range, NaN
 *  vertex, damaged image), UNSUPPORTED (required extension), ARGUMENT (no such scene,
 *  variant or animation), MEMORY. */
enum pbnds_status pbnds_gltf_load(const char *path,
                                  const struct pbnds_gltf_options *options,
                                  const struct pbnds_report *report,
                                  struct pbnds_scene *scene,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

/** The same from a file that is already in memory; `name` is for messages. URIs are
 * looked for below `folder`; NULL: none may be opened. */
enum pbnds_status pbnds_gltf_load_memory(const void *bytes, size_t size,
                                         const char *name, const char *folder,
                                         const struct pbnds_gltf_options *options,
                                         const struct pbnds_report *report,
                                         struct pbnds_scene *scene,
                                         struct pbnds_error *error) PBNDS_NODISCARD;

/** Lists what the file has, without loading a scene; of options only those count that say
 *  how far to trust it. To be freed; empty on failure. Errors: as pbnds_gltf_load(). */
enum pbnds_status pbnds_gltf_list(const char *path,
                                  const struct pbnds_gltf_options *options,
                                  struct pbnds_gltf_contents *contents,
                                  struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_gltf_contents_free(struct pbnds_gltf_contents *contents);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_GLTF_H */
