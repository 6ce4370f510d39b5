#include "engine/shade/sampler.h"

#include <assert.h>

#include "engine/core/rng.h"

static uint32_t reverse_bits(uint32_t x)
{
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

/* Owen scrambling of a bit-reversed number: each step lets a bit depend on lower bits
 * only, that is, on more significant ones of the number itself. */
static uint32_t scramble_reversed(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* Sobol dimensions 1 and 2 as bits in reversed order (bit 31 of the direction number is
 * bit 0 here), which saves the reversal before scrambling. Both follow the recurrence
 * v_j = v_{j-1} ^ (v_{j-1} >> 1) (polynomial x + 1) and
 * v_j = v_{j-1} ^ v_{j-2} ^ (v_{j-2} >> 2) (x^2 + x + 1; m = 1, 3), shifts to the left
 * here because of the reversal. */
static void sobol_reversed(uint32_t index, int dimensions, uint32_t *x)
{
    uint32_t d1 = 1u, d2 = 1u, d2_before = 1u, y = 0, z = 0;
    x[0] = index; /* dimension 0 is the radical inverse */
    if (dimensions == 1) return;
    for (uint32_t j = 0; index != 0; ++j, index >>= 1) {
        if (index & 1u) {
            y ^= d1;
            z ^= d2;
        }
        d1 ^= d1 << 1;
        const uint32_t next = j == 0 ? 3u : d2 ^ d2_before ^ (d2_before << 2);
        d2_before = d2;
        d2 = next;
    }
    x[1] = y;
    if (dimensions == 3) x[2] = z;
}

struct pbnds_sampler pbnds_sampler_make(uint64_t seed, uint64_t pixel, uint32_t sample,
                                        uint32_t count)
{
    assert(sample < count);
    struct pbnds_sampler s;
    s.key = pbnds_rng_make(seed, pixel, 0).key;
    s.index = sample;
    s.mask =
        count - 1; /* then every bit below its highest is set: 2^n - 1 >= count - 1 */
    s.mask |= s.mask >> 1;
    s.mask |= s.mask >> 2;
    s.mask |= s.mask >> 4;
    s.mask |= s.mask >> 8;
    s.mask |= s.mask >> 16;
    return s;
}

void pbnds_sampler_get_bits(const struct pbnds_sampler *sampler, uint32_t set,
                            int dimensions, uint32_t *bits)
{
    assert(dimensions >= 1 && dimensions <= 3);
    const uint64_t h = pbnds_mix64(sampler->key ^ pbnds_mix64(set)),
                   h2 = pbnds_mix64(h);
    const uint32_t seed[3] = {(uint32_t)(h >> 32), (uint32_t)h2, (uint32_t)(h2 >> 32)};
    /* The order of the points is Owen-scrambled too: aligned blocks of 2^k samples stay
     * together, so every such prefix is a net of its own. */
    const uint32_t order =
        reverse_bits(scramble_reversed(reverse_bits(sampler->index), (uint32_t)h)) &
        sampler->mask;
    uint32_t x[3];
    sobol_reversed(order, dimensions, x);
    for (int i = 0; i < dimensions; ++i)
        bits[i] = reverse_bits(scramble_reversed(x[i], seed[i]));
}

void pbnds_sampler_get(const struct pbnds_sampler *sampler, uint32_t set,
                       int dimensions, float *u)
{
    uint32_t bits[3];
    pbnds_sampler_get_bits(sampler, set, dimensions, bits);
    for (int i = 0; i < dimensions; ++i)
        u[i] = pbnds_sampler_unit(bits[i]);
}

uint32_t pbnds_sampler_hash(const struct pbnds_sampler *sampler, uint32_t set)
{
    const uint64_t salt = 0xd6e8feb86659fd93u; /* apart from the scrambling's hashes */
    const uint64_t name = (uint64_t)sampler->index << 32 | set;
    return (uint32_t)(pbnds_mix64(sampler->key ^ salt ^ pbnds_mix64(name)) >> 32);
}
