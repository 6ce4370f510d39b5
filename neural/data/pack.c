#include "neural/data/pack.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "engine/image/half.h"

static float rounded(float value)
{
    return pbnds_float_from_half(pbnds_half_from_float(value));
}

bool pbnds_pack_fits_half(const float *values, size_t count)
{
    double error = 0.0, sum = 0.0;
    for (size_t i = 0; i < count; ++i) {
        if (!(fabsf(values[i]) <= PBNDS_HALF_MAX)) return false;
        const double x = (double)values[i], d = (double)rounded(values[i]) - x;
        error += d * d;
        sum += x * x;
    }
    return error <= 0x1p-22 * sum;
}

void pbnds_pack_round_half(float *values, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        values[i] = rounded(values[i]);
}

void pbnds_pack_round_short(float *values, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        const uint32_t exponent = bits & 0x7f800000u;
        if (exponent != 0x7f800000u) bits += 0x7fffu + (bits >> 16 & 1u);
        bits &= 0xffff0000u;
        if (exponent != 0x7f800000u && (bits & 0x7f800000u) == 0x7f800000u)
            bits -= 0x10000u; /* the greatest numbers would round to infinity */
        memcpy(&values[i], &bits, sizeof bits);
    }
}
