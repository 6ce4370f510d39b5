#include "scenes/generator/noise.h"

#define HASH_X    0x8da6b343u
#define HASH_Y    0xd8163841u
#define HASH_Z    0xcb1ab31fu
#define HASH_SEED 0x9e3779b1u

/* Finaliser of MurmurHash3 (Appleby). */
static uint32_t finish(uint32_t h)
{
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return h ^ (h >> 16);
}

uint32_t gen_hash(uint32_t x, uint32_t y, uint32_t z, uint32_t seed)
{
    return finish(x * HASH_X ^ y * HASH_Y ^ z * HASH_Z ^ seed * HASH_SEED);
}

static float unit(uint32_t h)
{
    return (float)(h >> 8) * 0x1p-24f;
}

static uint32_t wrap(int i, int period)
{
    if (period > 0) i = (i % period + period) % period;
    return (uint32_t)i;
}

/* Dot product with one of the 12 edge directions of a cube. */
static float corner(uint32_t h, float x, float y, float z)
{
    const uint32_t k = h & 15u;
    const float u = k < 8 ? x : y;
    const float v = k < 4 ? y : k == 12 || k == 14 ? x : z;
    return ((k & 1u) ? -u : u) + ((k & 2u) ? -v : v);
}

static float fade(float t)
{
    return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}

static float mix(float a, float b, float t)
{
    return a + (b - a) * t;
}

/* floorf() as an integer, without the call. */
static int floor_int(float x)
{
    const int i = (int)x;
    return i - (x < (float)i);
}

/* What gen_hash() makes of one coordinate before it mixes: of lattice line i and the next. */
static void spread(int i, int period, uint32_t factor, uint32_t out[2])
{
    const uint32_t first = wrap(i, period);
    const uint32_t next = first + 1;
    out[0] = first * factor;
    out[1] = (period > 0 && next == (uint32_t)period ? 0u : next) * factor;
}

float gen_noise(struct pbnds_vec3 p, int period, uint32_t seed)
{
    const int ix = floor_int(p.x), iy = floor_int(p.y), iz = floor_int(p.z);
    const float x = p.x - (float)ix, y = p.y - (float)iy, z = p.z - (float)iz;
    const float tx = fade(x), ty = fade(y), tz = fade(z);
    uint32_t hx[2], hy[2], hz[2];
    float value[2][2];
    spread(ix, period, HASH_X, hx);
    spread(iy, period, HASH_Y, hy);
    spread(iz, period, HASH_Z, hz);
    const uint32_t hs = seed * HASH_SEED;
    for (int k = 0; k < 2; ++k) {
        for (int j = 0; j < 2; ++j) {
            const uint32_t h = hy[j] ^ hz[k] ^ hs;
            const float b = y - (float)j, c = z - (float)k;
            const float first = corner(finish(hx[0] ^ h), x, b, c);
            const float second = corner(finish(hx[1] ^ h), x - 1.0f, b, c);
            value[k][j] = mix(first, second, tx);
        }
    }
    return mix(mix(value[0][0], value[0][1], ty), mix(value[1][0], value[1][1], ty),
               tz);
}

float gen_fbm(struct pbnds_vec3 p, int octaves, int period, uint32_t seed)
{
    float sum = 0.0f, amplitude = 0.55f;
    for (int i = 0; i < octaves; ++i) {
        sum += amplitude * gen_noise(p, period, seed + (uint32_t)i);
        p = pbnds_scale(p, 2.0f);
        period *= 2;
        amplitude *= 0.5f;
    }
    return sum;
}

struct gen_cell gen_cells(float u, float v, int n, float jitter, uint32_t seed)
{
    struct gen_cell cell = {1e9f, 1e9f, 0.0f};
    const float x = u * (float)n, y = v * (float)n;
    const int cx = (int)floorf(x), cy = (int)floorf(y);
    for (int j = cy - 1; j <= cy + 1; ++j) {
        for (int i = cx - 1; i <= cx + 1; ++i) {
            const uint32_t h = gen_hash(wrap(i, n), wrap(j, n), 0, seed);
            const uint32_t g = gen_hash(wrap(i, n), wrap(j, n), 1, seed);
            const float dx = (float)i + 0.5f + jitter * (unit(h) - 0.5f) - x;
            const float dy = (float)j + 0.5f + jitter * (unit(g) - 0.5f) - y;
            const float d = sqrtf(dx * dx + dy * dy);
            if (d < cell.f1) {
                cell.f2 = cell.f1;
                cell.f1 = d;
                cell.id = unit(h ^ g * 0x9e3779b1u);
            } else if (d < cell.f2) {
                cell.f2 = d;
            }
        }
    }
    return cell;
}
