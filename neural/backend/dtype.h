/**
 * @file dtype.h
 * bfloat16 is the upper half of a float32; conversion rounds to nearest even, and a NaN
 * stays a (quiet) NaN.
 */
#ifndef PBNDS_NEURAL_BACKEND_DTYPE_H
#define PBNDS_NEURAL_BACKEND_DTYPE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "neural/backend/backend.h"

#if defined(__SANITIZE_ADDRESS__)
#define PBNDS_SANITIZED 1 /* which does not get on with clones */
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define PBNDS_SANITIZED 1
#endif
#endif

/** Before a function with loops over elements: compiled for AVX2 too and chosen at load
 *  time. Every clone computes the same bits, for none reorders a sum or contracts. */
#if defined(__GNUC__) && defined(__x86_64__) && defined(__gnu_linux__) &&              \
    !defined(__AVX2__) && !defined(PBNDS_SANITIZED)
#define PBNDS_KERNEL __attribute__((target_clones("avx2", "default")))
#else
#define PBNDS_KERNEL
#endif

/** Before such a loop. Clang vectorises it unasked, and warns where it was asked and
 *  cannot (without optimisation, with sanitizers). */
#if defined(__clang__)
#define PBNDS_SIMD
#else
#define PBNDS_SIMD _Pragma("omp simd")
#endif

static inline size_t pbnds_dtype_size(enum pbnds_dtype dtype)
{
    return dtype == PBNDS_BF16 ? 2 : 4;
}

static inline float pbnds_bf16_to_f32(uint16_t b)
{
    const uint32_t u = (uint32_t)b << 16;
    float f;
    memcpy(&f, &u, sizeof f);
    return f;
}

static inline uint16_t pbnds_f32_to_bf16(float f)
{
    uint32_t u;
    memcpy(&u, &f, sizeof u);
    const uint32_t rounded = (u + 0x7fffu + ((u >> 16) & 1u)) >> 16;
    const uint32_t nan = (u >> 16) | 0x40u;
    return (uint16_t)((u & 0x7fffffffu) > 0x7f800000u ? nan : rounded);
}
#endif /* PBNDS_NEURAL_BACKEND_DTYPE_H */
