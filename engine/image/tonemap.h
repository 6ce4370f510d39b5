/**
 * @file tonemap.h
 * The one display transform: exposure, tone map, exact sRGB OETF. Everything before it is
 * linear and scene-referred; metrics that say "display" are taken after it.
 */
#ifndef PBNDS_ENGINE_IMAGE_TONEMAP_H
#define PBNDS_ENGINE_IMAGE_TONEMAP_H

#include "engine/core/vec.h"
#include "engine/image/image.h"

enum pbnds_tonemap {
    PBNDS_TONEMAP_PBR_NEUTRAL, /**< Khronos PBR Neutral 1.0 (2024); the default */
    PBNDS_TONEMAP_NONE,        /**< clamp to [0, 1]                             */
    PBNDS_TONEMAP_REINHARD,    /**< x / (1 + x) a channel, Reinhard 2002 eq. 3  */
};

struct pbnds_display {
    float exposure_ev; /**< radiance is multiplied by 2^ev */
    enum pbnds_tonemap tonemap;
};

#ifdef __cplusplus
extern "C" {
#endif

/** One linear colour to display-encoded sRGB in [0, 1]; NaN becomes 0. */
struct pbnds_vec3 pbnds_display_color(const struct pbnds_display *display,
                                      struct pbnds_vec3 linear);
/** Every pixel of a 3-channel image; src and dst may be the same, sizes must agree. */
void pbnds_display_image(const struct pbnds_display *display, const struct pbnds_image *src,
                         struct pbnds_image *dst);
/** "none", "pbr-neutral", "reinhard"; false when the name is none of them. */
int pbnds_tonemap_parse(const char *name, enum pbnds_tonemap *tonemap);
const char *pbnds_tonemap_name(enum pbnds_tonemap tonemap);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_IMAGE_TONEMAP_H */
