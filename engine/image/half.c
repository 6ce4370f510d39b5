#include "engine/image/half.h"

#include <string.h>

uint16_t pbnds_half_from_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint16_t sign = (uint16_t)(bits >> 16 & 0x8000u);
    const uint32_t magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u) { /* NaN keeps the top of its payload, and stays one */
        const uint32_t payload = magnitude >> 13 & 0x3ffu;
        return (uint16_t)(sign | 0x7c00u | (payload ? payload : 0x200u));
    }
    if (magnitude == 0x7f800000u) return (uint16_t)(sign | 0x7c00u);
    if (magnitude >= 0x477fe000u) return (uint16_t)(sign | 0x7bffu); /* saturates */
    if (magnitude < 0x33000000u) return sign;                        /* below 2^-25 */
    uint32_t mantissa, shift;
    if (magnitude < 0x38800000u) { /* subnormal: the leading one becomes explicit */
        shift = 126u - (magnitude >> 23);
        mantissa = (magnitude & 0x7fffffu) | 0x800000u;
    } else { /* rebias 127 to 15 */
        shift = 13;
        mantissa = magnitude - 0x38000000u;
    }
    const uint32_t rest = mantissa & ((1u << shift) - 1u), middle = 1u << (shift - 1u);
    uint32_t half = mantissa >> shift;
    half += rest > middle || (rest == middle && (half & 1u)) ? 1u : 0u;
    return (uint16_t)(sign | half);
}

float pbnds_float_from_half(uint16_t half)
{
    const uint32_t sign = (uint32_t)(half & 0x8000u) << 16;
    const uint32_t exponent = half >> 10 & 0x1fu;
    uint32_t mantissa = half & 0x3ffu, bits;
    if (exponent == 0x1fu) {
        bits = sign | 0x7f800000u | mantissa << 13;
    } else if (exponent != 0) {
        bits = sign | (exponent + 112u) << 23 | mantissa << 13;
    } else if (mantissa == 0) {
        bits = sign;
    } else { /* subnormal half, normal float */
        uint32_t e = 113u;
        while (!(mantissa & 0x400u)) {
            mantissa <<= 1;
            --e;
        }
        bits = sign | e << 23 | (mantissa & 0x3ffu) << 13;
    }
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
