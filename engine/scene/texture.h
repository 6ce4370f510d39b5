/**
 * @file texture.h
 * A texture with its sampler state; lookups return linear values.
 */
#ifndef PBNDS_ENGINE_SCENE_TEXTURE_H
#define PBNDS_ENGINE_SCENE_TEXTURE_H

#include <stdbool.h>

#include "engine/core/vec.h"
#include "engine/image/oiio.h"

enum pbnds_wrap { PBNDS_WRAP_REPEAT, PBNDS_WRAP_MIRROR, PBNDS_WRAP_CLAMP };

/** Decoded once, shared by every sampler that uses the same image. */
struct pbnds_texture {
    const struct pbnds_pixels *pixels; /**< borrowed from the scene                     */
    enum pbnds_wrap wrap_u, wrap_v;
    bool nearest; /**< magnification filter NEAREST, else bilinear                      */
};

#ifdef __cplusplus
extern "C" {
#endif

/** glTF uv (0, 0 is the corner of the first texel, v down). With `srgb` the colour
 *  channels are decoded from sRGB before filtering; alpha never is. */
struct pbnds_vec4 pbnds_texture_sample(const struct pbnds_texture *texture,
                                       struct pbnds_vec2 uv, bool srgb);

/** One texel of an image, x and y inside of it; decoded as above. */
struct pbnds_vec4 pbnds_texel(const struct pbnds_pixels *pixels, int x, int y,
                              bool srgb);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_TEXTURE_H */
