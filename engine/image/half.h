/**
 * @file half.h
 * Half floats, IEEE 754 binary16, in integer arithmetic: no flush-to-zero mode of the
 * calling thread can reach them.
 */
#ifndef PBNDS_ENGINE_IMAGE_HALF_H
#define PBNDS_ENGINE_IMAGE_HALF_H

#include <stdint.h>

#define PBNDS_HALF_MAX 65504.0f

#ifdef __cplusplus
extern "C" {
#endif

/** Nearest, ties to even; saturates at +-PBNDS_HALF_MAX, infinities and NaN stay. */
uint16_t pbnds_half_from_float(float value);
/** Exact. */
float pbnds_float_from_half(uint16_t half);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_IMAGE_HALF_H */
