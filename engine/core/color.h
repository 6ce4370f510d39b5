/**
 * @file color.h
 * The exact sRGB transfer functions, IEC 61966-2-1.
 */
#ifndef PBNDS_ENGINE_CORE_COLOR_H
#define PBNDS_ENGINE_CORE_COLOR_H

#include <math.h>

/** Linear [0, 1] to display code value [0, 1]; clamps outside. */
static inline float pbnds_srgb_encode(float x)
{
    if (!(x > 0.0f)) return 0.0f;
    if (x >= 1.0f) return 1.0f;
    return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1.0f / 2.4f) - 0.055f;
}

/** Display code value [0, 1] to linear [0, 1]. */
static inline float pbnds_srgb_decode(float x)
{
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}
#endif /* PBNDS_ENGINE_CORE_COLOR_H */
