/**
 * @file view.h
 * A G-buffer as the networks see it: its planes in camera space, with what can be
 * derived from them once a view (horizon angles) and once a light (screen-space shadow
 * march).
 *
 * Everything here is a function of the G-buffer alone, so that photographs with
 * estimated maps go the same way as ray-cast scenes. Camera space: +x right, +y up,
 * looks down -z.
 */
#ifndef PBNDS_NEURAL_VIEW_H
#define PBNDS_NEURAL_VIEW_H

#include "engine/shade/gbuffer.h"

enum { PBNDS_HORIZONS = 8 };

/** Planes of a view, row-major; 0 where nothing was hit. */
enum pbnds_plane {
    PBNDS_PLANE_ALBEDO_R,
    PBNDS_PLANE_ALBEDO_G,
    PBNDS_PLANE_ALBEDO_B,
    PBNDS_PLANE_NORMAL_X, /**< camera space */
    PBNDS_PLANE_NORMAL_Y,
    PBNDS_PLANE_NORMAL_Z,
    PBNDS_PLANE_WO_X, /**< to the eye, camera space */
    PBNDS_PLANE_WO_Y,
    PBNDS_PLANE_WO_Z,
    PBNDS_PLANE_SPECULAR,
    PBNDS_PLANE_ROUGHNESS,
    PBNDS_PLANE_METALLIC,
    PBNDS_PLANE_N_DOT_V,
    PBNDS_PLANE_MASK,      /**< coverage */
    PBNDS_PLANE_LOG_DEPTH, /**< ln(depth / median depth of the view) */
    PBNDS_PLANE_HORIZON, /**< 8 planes, azimuth 45 degrees each from +x towards -y (down
                              the image): largest cosine between the normal and a
                              nearer or farther neighbour, faded with distance; 0: open
                          */
    PBNDS_PLANE_COUNT = PBNDS_PLANE_HORIZON + PBNDS_HORIZONS,
};

/** The planes cover a rectangle of the image; what is derived from depth sees all of it,
 * so that a pixel's values do not depend on the rectangle. */
struct pbnds_view {
    int width, height;             /**< of the planes */
    int x, y;                      /**< of their first pixel in the image */
    int image_width, image_height; /**< of depth */
    struct pbnds_camera camera;
    float *plane[PBNDS_PLANE_COUNT]; /**< into storage */
    const float
        *depth;     /**< planar metres, +inf where nothing was hit; the whole image's
                         */
    float *storage; /**< owned */
};

/** A rectangle of the image, in its pixels; it may reach past the image, whose border is
 * then repeated. */
struct pbnds_window {
    int x, y, width, height;
};

/** What one light looks like from every pixel, by march through the depth buffer. */
struct pbnds_march {
    uint32_t *thin;  /**< bit i: light i is blocked by something of small thickness */
    uint32_t *thick; /**< bit i: the same if surfaces are assumed thick */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Copies what it needs: the G-buffer may go afterwards. */
enum pbnds_status pbnds_view_create(const struct pbnds_gbuffer *gbuffer,
                                    struct pbnds_view *view,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** The part of a view under `window`, which must meet the image; its depth is the
 * G-buffer's, which must outlive it. median_depth: of pbnds_view_median_depth(). */
enum pbnds_status pbnds_view_create_part(const struct pbnds_gbuffer *gbuffer,
                                         struct pbnds_window window, float median_depth,
                                         struct pbnds_view *view,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_view_free(struct pbnds_view *view);
/** Of the pixels where something was hit; 1 where that is none. */
float pbnds_view_median_depth(const struct pbnds_gbuffer *gbuffer);
/** Bytes of a pixel of the planes. */
size_t pbnds_view_bytes_a_pixel(void);

/** Marches from every covered pixel of the view towards `count` <= 32 directions (unit, world) and
 * writes width * height words to each mask (caller's arrays). */
void pbnds_view_march(const struct pbnds_view *view, const struct pbnds_vec3 *wi,
                      int count, struct pbnds_march *march);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_VIEW_H */
