/**
 * @file import.h
 * G-buffers that others made: Blender's multilayer files, and folders of material maps.
 * What a source does not say gets a default, and every default is told in the notes.
 */
#ifndef PBNDS_ENGINE_SHADE_IMPORT_H
#define PBNDS_ENGINE_SHADE_IMPORT_H

#include <stdbool.h>

#include "engine/shade/gbuffer.h"

struct pbnds_import_options {
    float yfov; /**< vertical field of view, radians; 0: found, or 40 degrees       */
    float xfov; /**< maps: horizontal one, radians; used in place of yfov unless 0  */
    bool
        look_given; /**< is the direction below known? Else it is found, or 0, 0        */
    float yaw, pitch; /**< radians: 0, 0 looks along -z (Blender's +y); positive yaw
                            looks from +x, positive pitch from above                       */
};

/** One sentence each: what came from where, and what was assumed. */
struct pbnds_import_notes {
    char text[24][200];
    int count;
};

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Reads the passes of a view layer (`LAYER.PASS.CHANNEL`, any layer name; of several the
 * first that has what is needed) of an OpenEXR multilayer file. Needed: Depth, Normal and
 * DiffCol (or a colour AOV `albedo`).
 *
 * Blender is z-up: (x, y, z) becomes (x, z, -y). Depth is planar already; 1e10 is nothing.
 * Coverage is Combined.A; colours and AOVs are means over the pixel's samples in which
 * those that missed count as 0, so they are divided by it. Albedo is the AOV, else
 * DiffCol / (1 - metallic), and GlossCol of pure metal. Roughness and metallic are the
 * AOVs of these names, else 0.5 and 0; specular is that AOV, else 0.04 mixed with the
 * luminance of albedo by metallic. Emit, IndexOB and IndexMA join where they are.
 *
 * The file has no camera. Where it has a Position pass the camera is the one that sees
 * these positions at these pixels and depths (least squares; perspective and
 * orthographic), else that of the options. Combined goes to `radiance` (or NULL).
 *
 * Errors: IO, FORMAT (missing passes, NaN), UNSUPPORTED (DWAA and other codecs, several
 * parts, shifted lenses and pixels that are not square), MEMORY.
 */
enum pbnds_status pbnds_import_blender(const char *path,
                                       const struct pbnds_import_options *options,
                                       struct pbnds_gbuffer *gbuffer,
                                       struct pbnds_image *radiance,
                                       struct pbnds_import_notes *notes,
                                       struct pbnds_error *error) PBNDS_NODISCARD;

/** Maps of one size, one file each; an empty path: there is none. */
enum pbnds_import_map_name {
    PBNDS_IMPORT_ALBEDO,
    PBNDS_IMPORT_NORMAL,
    PBNDS_IMPORT_ROUGHNESS,
    PBNDS_IMPORT_METALLIC,
    PBNDS_IMPORT_SPECULAR,
    PBNDS_IMPORT_DEPTH,
    PBNDS_IMPORT_MASK,
    PBNDS_IMPORT_EMISSION,
    PBNDS_IMPORT_AO,
    PBNDS_IMPORT_PHOTO,
    PBNDS_IMPORT_MAPS
};

struct pbnds_import_paths {
    char path[PBNDS_IMPORT_MAPS][1400];
};

/**
 * Makes a G-buffer of material maps:
 *   albedo     display-encoded (sRGB) in 8 and 16 bit, linear in .exr and .hdr   0.5
 *   normal     camera space, +x right, +y up, +z to the eye; 2 v - 1 in 8 and
 *              16 bit, signed in .exr                                            0, 0, 1
 *   roughness  perceptual                                                        0.5
 *   metallic                                                                     0
 *   specular   reflectance at normal incidence                      0.04, albedo of metal
 *   depth      planar, metres in .exr, millimetres in 16 bit, 0 is nothing       1 m
 *   mask       coverage          alpha of photo where that has one, else of albedo, or 1
 *   emission   as albedo; any range in .exr and .hdr                             0
 *   ao         occlusion                                                   (no plane)
 *   photo      the photograph of which the maps were estimated; encoded as albedo  (none)
 * where the last column is the default of a map that is missing. At least albedo or
 * normal must be there. The camera stands at the origin and looks along -z. Where the
 * mask or the depth is 0, nothing was hit; a fractional mask is the coverage.
 *
 * `photo` gets the photograph as linear values, 0 where nothing was hit (empty where there
 * is none): radiance where it was .exr or .hdr, else display-referred, which *target says.
 *
 * Errors: IO, FORMAT (sizes that differ, NaN), UNSUPPORTED (8-bit depth, and what the
 * readers refuse), MEMORY, ARGUMENT (neither albedo nor normal).
 */
enum pbnds_status
pbnds_import_maps(const struct pbnds_import_paths *paths,
                  const struct pbnds_import_options *options,
                  struct pbnds_gbuffer *gbuffer, struct pbnds_image *photo,
                  enum pbnds_target *target, struct pbnds_import_notes *notes,
                  struct pbnds_error *error) PBNDS_NODISCARD;

/** The same of a folder's NAME.exr, .png, .jpg, .jpeg, .webp or .hdr, the first of these
 *  that exists, for the names above. Errors: FORMAT too where it has no maps. */
enum pbnds_status
pbnds_import_images(const char *folder, const struct pbnds_import_options *options,
                    struct pbnds_gbuffer *gbuffer, struct pbnds_image *photo,
                    enum pbnds_target *target, struct pbnds_import_notes *notes,
                    struct pbnds_error *error) PBNDS_NODISCARD;

/** Adds a sentence; what does not fit is left out. */
void pbnds_import_note(struct pbnds_import_notes *notes, const char *format, ...)
    PBNDS_PRINTF(2, 3);

/** The camera at the origin that the options describe. */
struct pbnds_camera pbnds_import_camera(const struct pbnds_import_options *options);

/** What pbnds_import_fit_camera() found. */
enum pbnds_camera_fit {
    PBNDS_FIT_DONE,
    PBNDS_FIT_UNKNOWN, /**< too few points, or all in one plane that faces the eye    */
    PBNDS_FIT_SKEWED,  /**< points of a camera with a shifted lens or oblong pixels   */
};

/** The camera that sees world position p[i] at pixel i (+-1 pixel: renderers jitter) and
 *  planar depth d[i]; pixels of depth +inf are left out. *off is the root mean square
 *  distance between pixels and projected positions, pixels.
 *
 *  p = eye + d (sx a + sy b + c) with sx, sy in half heights is linear in eye, a, b, c:
 *  a and b are the camera's axes times tan(fov / 2), c its direction. An orthographic
 *  camera is p = eye + sx a + sy b + d c; the model that fits better is taken. */
enum pbnds_camera_fit pbnds_import_fit_camera(const float *const position[3],
                                              const float *depth, int width, int height,
                                              struct pbnds_camera *camera, float *off);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_IMPORT_H */
