/**
 * @file gbuffer.h
 * What the primary rays hit, one entry a pixel: the contract between the ray caster, the
 * shading passes, files, and everyone who makes G-buffers elsewhere.
 *
 * Planar, row-major, row 0 on top. A pixel whose ray hit nothing has depth = +INFINITY,
 * coverage 0 and zeros elsewhere.
 *
 * Point-sampled (samples = 1): the surface at the pixel centre, coverage 0 or 1.
 * Anti-aliased (samples > 1): every channel c of a pixel is sum(w_i c_i) / sum(w_i) over
 * the surfaces i that its samples met, with the same weights w_i for all channels and
 * coverage = sum(w_i) / samples; directions are made unit again, ids are those of the
 * greatest weight. In memory normals and positions are world space; files
 * hold camera-space normals by default and say so (attribute pbnds:normalSpace).
 */
#ifndef PBNDS_ENGINE_SHADE_GBUFFER_H
#define PBNDS_ENGINE_SHADE_GBUFFER_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/report.h"
#include "engine/image/exr.h"
#include "engine/scene/accel.h"

#define PBNDS_GBUFFER_CONTRACT 1

/** Channels a shader may ask for. */
enum pbnds_channel {
    PBNDS_CHANNEL_ALBEDO = 1u << 0,
    PBNDS_CHANNEL_NORMAL = 1u << 1,
    PBNDS_CHANNEL_SPECULAR = 1u << 2,
    PBNDS_CHANNEL_ROUGHNESS = 1u << 3,
    PBNDS_CHANNEL_DEPTH = 1u << 4,
    PBNDS_CHANNEL_METALLIC = 1u << 5,
    PBNDS_CHANNEL_POSITION = 1u << 6,
    PBNDS_CHANNEL_EMISSION = 1u << 7,
};

/** The transparency policy, the same for all channels. */
enum pbnds_through {
    PBNDS_THROUGH_FIRST, /**< the first surface with alpha >= 1/2 (MASK: its cutoff)       */
    PBNDS_THROUGH_ALPHA, /**< every surface, weighed by its alpha times what those before
                              it let through                                               */
};

struct pbnds_cryptomatte;

struct pbnds_gbuffer {
    int width, height;
    struct pbnds_camera camera;
    float *
        albedo[3]; /**< base colour, linear Rec. 709, [0, 1]                          */
    float *
        normal[3]; /**< unit shading normal, world, faces the eye                     */
    float
        *specular; /**< reflectance at normal incidence, luminance of f0, [0, 1]      */
    float *
        roughness; /**< perceptual, [0, 1]; alpha = roughness^2                       */
    float
        *metallic; /**< [0, 1]                                                        */
    float *depth;  /**< planar: distance along the view axis, metres; +inf: nothing   */
    float
        *coverage; /**< share of the pixel that something covers, [0, 1]              */
    float *position
        [3]; /**< world, metres                                                 */
    float *emission
        [3]; /**< radiance that the surface emits, linear Rec. 709              */
    float
        *geometric_normal[3]; /**< unit face normal, world, faces the eye; not in files:
                                     rebuilt from `normal` there                           */
    uint32_t
        *object_id; /**< glTF node index; UINT32_MAX where nothing was hit            */

    /* Optional planes: NULL unless asked for, or read from a file that has them. */
    float
        *f0[3]; /**< reflectance at normal incidence in colour; present where a material
                        has KHR_materials_specular or specular-glossiness, since `specular`
                        cannot tell then. `specular` is its luminance                      */
    float
        *f90; /**< with f0: reflectance at grazing incidence                          */
    float
        *ao; /**< of the occlusion maps, 1: open                                     */
    float *uv
        [2]; /**< TEXCOORD_0                                                         */
    float *motion[2]; /**< pixels that the surface moved in the image since the earlier
                           time, +x right, +y down                                         */
    uint32_t
        *material_id; /**< index of the glTF material; UINT32_MAX: nothing            */
    struct pbnds_cryptomatte
        *cryptomatte; /**< owned; NULL: none (cryptomatte.h)          */

    int samples; /**< rays a pixel; 1: point-sampled                                       */
    enum pbnds_through through;
    void *
        storage; /**< the one allocation that all planes point into, owned               */
};

/** Optional planes of a ray cast. f0 and f90 come by themselves. */
enum pbnds_optional {
    PBNDS_OPTIONAL_AO = 1u << 0,
    PBNDS_OPTIONAL_UV = 1u << 1,
    PBNDS_OPTIONAL_MOTION = 1u << 2, /**< of a scene that was loaded without motion only
                                       the camera's is seen                            */
    PBNDS_OPTIONAL_MATERIAL_ID = 1u << 3,
    PBNDS_OPTIONAL_CRYPTOMATTE =
        1u << 4, /**< object and material                          */
};

struct pbnds_raycast_options {
    unsigned optional; /**< PBNDS_OPTIONAL_* bits                                  */
    int samples;       /**< rays a pixel; 0 and 1: one, through its centre         */
    enum pbnds_through
        through; /**< what a BLEND surface does                              */
    const struct pbnds_camera
        *previous_camera; /**< NULL: the camera did not move          */
};

enum pbnds_normal_space { PBNDS_NORMAL_CAMERA, PBNDS_NORMAL_WORLD };
enum pbnds_depth_kind {
    PBNDS_DEPTH_PLANAR,   /**< along the view axis       */
    PBNDS_DEPTH_DISTANCE, /**< from the eye to the point */
};

/** What R, G, B of a file are. */
enum pbnds_target {
    PBNDS_TARGET_RADIANCE, /**< scene-referred, linear                             */
    PBNDS_TARGET_DISPLAY,  /**< a photograph, its sRGB decoded: the sRGB OETF, and neither
                                exposure nor tone map, gives the picture           */
};

/** Where a file came from: its header attributes beside the camera. */
struct pbnds_gbuffer_origin {
    char env[256]; /**< light map file name, or ""                                   */
    float env_yaw_deg, env_strength;
    char env_convention[16];
    uint64_t seed;
    enum pbnds_normal_space
        normal_space;            /**< of `normal` in the file                     */
    enum pbnds_depth_kind depth; /**< of `Z` in the file                          */
    enum pbnds_target target;    /**< of R, G, B in the file                      */
    char arguments
        [400]; /**< the command line                                             */
    char
        version[32]; /**< of the program that wrote the file; for readers             */
};

#ifdef __cplusplus
extern "C" {
#endif

enum pbnds_status pbnds_gbuffer_init(struct pbnds_gbuffer *gbuffer, int width,
                                     int height,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_gbuffer_free(struct pbnds_gbuffer *gbuffer);

/** Casts the primary rays, by packets in tiles, multi-threaded; options NULL: one ray
 *  through each pixel centre, no optional plane. Allocates the planes.
 *  Errors: ARGUMENT (size), MEMORY, INTERRUPTED. */
enum pbnds_status pbnds_gbuffer_raycast(const struct pbnds_scene *scene,
                                        const struct pbnds_accel *accel,
                                        const struct pbnds_camera *camera, int width,
                                        int height,
                                        const struct pbnds_raycast_options *options,
                                        struct pbnds_gbuffer *gbuffer,
                                        struct pbnds_error *error) PBNDS_NODISCARD;

/** The same into a G-buffer that is empty (all zero) or was cast before: where size and
 *  planes are those that are asked for, its memory is used again. A system that hands out
 *  fresh memory zeroes it page by page, which costs more than casting the rays; whoever
 *  casts many G-buffers of one size should do it with this. */
enum pbnds_status pbnds_gbuffer_recast(const struct pbnds_scene *scene,
                                       const struct pbnds_accel *accel,
                                       const struct pbnds_camera *camera, int width,
                                       int height,
                                       const struct pbnds_raycast_options *options,
                                       struct pbnds_gbuffer *gbuffer,
                                       struct pbnds_error *error) PBNDS_NODISCARD;

/**
 * Writes the contract's channels and attributes; origin NULL: normals in camera space,
 * planar depth. `radiance` (3-channel, linear, or NULL) joins as R, G, B with
 * A = coverage; `extra` are further channels (borrowed) such as a data set's targets, or
 * an A that takes the place of this one.
 *
 * Beside those of DESIGN's contract: f0.{R,G,B} and f90.R where the G-buffer has them,
 * material_id (uint), and Cryptomatte's CryptoObject00 to 02 and CryptoMaterial00 to 02.
 * Attributes: pbnds:contract, version, normalSpace (camera or world), depth (planar or
 * distance: from the eye, along the ray through the pixel's centre), samples, through
 * (first or alpha), camera, projection, yfov (radians), ymag, worldFromCamera; with an
 * origin env, envYaw (degrees), envStrength, envConvention, seed, arguments, and target
 * (display) unless it is radiance; and
 * OpenEXR's worldToCamera and worldToNDC, for row vectors.
 */
enum pbnds_status pbnds_gbuffer_write(
    const char *path, const struct pbnds_gbuffer *gbuffer,
    const struct pbnds_gbuffer_origin *origin, const struct pbnds_image *radiance,
    const struct pbnds_exr_channel *extra, int extra_count,
    enum pbnds_exr_compression compression, struct pbnds_error *error) PBNDS_NODISCARD;

/** Reads a G-buffer of ours. Required: albedo.*, normal.*, Z and roughness.R; the rest gets
 *  its default when absent (specular 0.04, metallic 0, coverage from Z, position from Z and
 *  the camera, emission 0); optional planes come where the file has them. Normals are
 *  taken to world space and depth to planar, as the header says. A file without our camera attributes gets a camera at the origin
 *  of 40 degrees vertical field of view. `origin`, `radiance` may be NULL; radiance is
 *  left empty where the file has no R, G, B. `exr` (or NULL) receives the raw file for extra
 *  channels and is the caller's to free.
 *  Errors: IO, FORMAT (the sentence names the missing channels; NaN), UNSUPPORTED. */
enum pbnds_status pbnds_gbuffer_read(const char *path, struct pbnds_gbuffer *gbuffer,
                                     struct pbnds_gbuffer_origin *origin,
                                     struct pbnds_image *radiance,
                                     struct pbnds_exr *exr,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

/** The same from a file's bytes, which are borrowed for the call; `name` is for
 *  messages. */
enum pbnds_status pbnds_gbuffer_read_memory(const char *name, const uint8_t *bytes,
                                            size_t size, struct pbnds_gbuffer *gbuffer,
                                            struct pbnds_gbuffer_origin *origin,
                                            struct pbnds_image *radiance,
                                            struct pbnds_exr *exr,
                                            struct pbnds_error *error) PBNDS_NODISCARD;

/** Entry i of three planes, e.g. gbuffer->normal. */
static inline struct pbnds_vec3 pbnds_gbuffer_vec3(float *const plane[3], size_t i)
{
    return pbnds_vec3_make(plane[0][i], plane[1][i], plane[2][i]);
}
/** Unit vector from the pixel's surface to the eye, world. */
struct pbnds_vec3 pbnds_gbuffer_wo(const struct pbnds_gbuffer *gbuffer, int x, int y);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_GBUFFER_H */
