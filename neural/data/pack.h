/**
 * @file pack.h
 * How a data set's light is stored in few bytes, without losing what it knows.
 *
 * Half. A target of a path tracer is known to a per cent or so (its variance says it), half
 * rounds to 2^-12. So light is half, as a layer of all its channels, where that is so: no
 * value is beyond 65504, which half cannot hold, and the layer as a whole is rounded by no
 * more than half's step says,
 *
 *     sum (round(x) - x)^2 <= 2^-22 sum x^2
 *
 * A layer so dark that it falls among half's subnormal numbers (below 2^-14, step 2^-24)
 * fails this, and stays float like one that is too bright. Nothing is clipped.
 *
 * Short. A variance from some ten blocks of samples is itself known to a third or so, and
 * spans too many orders of magnitude for half. It stays float, with a significand of 8
 * bits: the lower 16 bits of each number are zero, which lossless compression stores in
 * next to nothing.
 */
#ifndef PBNDS_NEURAL_DATA_PACK_H
#define PBNDS_NEURAL_DATA_PACK_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** May these values be stored as half? No where one is not finite. */
bool pbnds_pack_fits_half(const float *values, size_t count);
/** To half and back, nearest, in place. */
void pbnds_pack_round_half(float *values, size_t count);
/** To a significand of 8 bits, nearest, ties to even, in place. Finite values stay finite. */
void pbnds_pack_round_short(float *values, size_t count);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_PACK_H */
