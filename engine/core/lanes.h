/**
 * @file lanes.h
 * Loops over lanes, compiled for several instruction sets.
 *
 * PBNDS_LANES_CODE before a function definition: it and all that is inlined into it is
 * compiled for AVX-512, AVX2 and the portable baseline, and the best is chosen when the
 * program starts. Contraction is off everywhere (-ffp-contract=off), so all give the same
 * bits. Where compiler or machine cannot do this, it means nothing.
 */
#ifndef PBNDS_ENGINE_CORE_LANES_H
#define PBNDS_ENGINE_CORE_LANES_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) &&              \
    !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) &&                           \
    !defined(__SANITIZE_THREAD__)
#define PBNDS_LANES_CODE                                                               \
    __attribute__((flatten,                                                            \
                   target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define PBNDS_LANES_CODE
#endif

/** Tells the processor that the cache line at `p` will be read soon. */
#if defined(__GNUC__)
#define PBNDS_PREFETCH(p) __builtin_prefetch(p)
#else
#define PBNDS_PREFETCH(p) ((void)(p))
#endif

#if defined(__GNUC__)
/** Four and eight numbers that arithmetic treats as one: attributes of gcc and clang. */
typedef float pbnds_float4 __attribute__((vector_size(16)));
typedef float pbnds_float8 __attribute__((vector_size(32)));
typedef int32_t pbnds_int8 __attribute__((vector_size(32)));
typedef uint16_t pbnds_short8 __attribute__((vector_size(16)));
#define PBNDS_VECTORS 1
#endif

#if defined(PBNDS_VECTORS)
/** *sum += weight * (eight shorts from p on) */
static inline void pbnds_add8(pbnds_float8 *sum, float weight, const uint16_t *p)
{
    pbnds_short8 narrow;
    memcpy(&narrow, p, sizeof narrow);
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    /* A shuffle with zeros: gcc 12 makes of it the one instruction that there is for
     * this, and five of a conversion. */
    const pbnds_short8 zero = {0, 0, 0, 0, 0, 0, 0, 0};
    const pbnds_int8 whole = (pbnds_int8)__builtin_shufflevector(
        narrow, zero, 0, 8, 1, 9, 2, 10, 3, 11, 4, 12, 5, 13, 6, 14, 7, 15);
#else
    const pbnds_int8 whole = __builtin_convertvector(narrow, pbnds_int8);
#endif
    *sum += weight * __builtin_convertvector(whole, pbnds_float8);
}
#endif

/** column[c][lane] = row[lane][c] for four lanes from `lane` on and four columns from `c`
 *  on; rows are `stride` floats apart. */
static inline void pbnds_transpose4(const float *row, size_t stride, float *column,
                                    size_t column_stride)
{
#if defined(PBNDS_VECTORS)
    pbnds_float4 a, b, c, d;
    memcpy(&a, row, sizeof a);
    memcpy(&b, row + stride, sizeof b);
    memcpy(&c, row + 2 * stride, sizeof c);
    memcpy(&d, row + 3 * stride, sizeof d);
    const pbnds_float4 ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
    const pbnds_float4 ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const pbnds_float4 cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    const pbnds_float4 cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    a = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
    b = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
    c = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
    d = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
    memcpy(column, &a, sizeof a);
    memcpy(column + column_stride, &b, sizeof b);
    memcpy(column + 2 * column_stride, &c, sizeof c);
    memcpy(column + 3 * column_stride, &d, sizeof d);
#else
    for (size_t i = 0; i < 4; ++i)
        for (size_t k = 0; k < 4; ++k)
            column[i * column_stride + k] = row[k * stride + i];
#endif
}

#endif /* PBNDS_ENGINE_CORE_LANES_H */
