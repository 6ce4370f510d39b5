/**
 * @file lookup.h
 * Trilinear lookups in prefiltered maps, for one point or for many side by side: the same
 * expressions in the same order for both, so that both give the same bits. For the files
 * of this folder.
 *
 * Level of detail: Akenine-Moeller et al. 2019, "Texture Level of Detail Strategies for
 * Real-Time Ray Tracing", ray cones. A cone of width w at the hit, on a triangle that has
 * a_t texels and area a_p, seen under the cosine |n.d|, covers
 *     lambda = log2(w sqrt(a_t / a_p) / |n.d|)
 * levels. Here as half the logarithm of the square.
 */
#ifndef PBNDS_ENGINE_SCENE_LOOKUP_H
#define PBNDS_ENGINE_SCENE_LOOKUP_H

#include "engine/core/lanes.h"
#include "engine/scene/maps.h"

enum { PBNDS_LANES = 16 };

/** Least cosine between a shading normal and the eye. */
#define PBNDS_FACING 1e-3f
/** Least cosine between the face and the eye's mirror direction about a shading normal. */
#define PBNDS_LEAVING 1e-2f

/** floor() of |x| < 2^31 without the library call that SSE2 needs for floorf(). */
static inline int pbnds_floor_int(float x)
{
    const int i = (int)x;
    return i - (x < (float)i ? 1 : 0);
}

/** log2 of a positive normal number by its exponent and a polynomial of its mantissa;
 *  exact at powers of two, elsewhere within 0.009. The same bits on every machine. */
static inline float pbnds_log2_about(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    const int exponent = (int)(bits >> 23) - 127;
    bits = (bits & 0x7fffffu) | 0x3f800000u;
    float m;
    memcpy(&m, &bits, sizeof m);
    /* (m - 1)(a - b m): 0 at 1, 1 at 2 */
    return (float)exponent + (m - 1.0f) * (1.6733f - 0.33665f * m);
}

/** Beyond this a float holds no fraction worth filtering; NaN goes the same way. */
static inline float pbnds_foldable(float u)
{
    return fabsf(u) < 1e6f ? u : 0.0f;
}

/** Folds a texture coordinate into one period: [0, 1], mirrored [0, 2]. */
static inline float pbnds_fold(enum pbnds_wrap wrap, float u)
{
    if (wrap == PBNDS_WRAP_CLAMP) return u > 0.0f ? (u < 1.0f ? u : 1.0f) : 0.0f;
    if (wrap == PBNDS_WRAP_REPEAT) return u - (float)pbnds_floor_int(u);
    return u - 2.0f * (float)pbnds_floor_int(0.5f * u);
}

/** A texel index at most one step out of the folded period, back inside. */
static inline int pbnds_wrap_index(enum pbnds_wrap wrap, int i, int size)
{
    if (wrap == PBNDS_WRAP_CLAMP) {
        const int low = i < 0 ? 0 : i;
        return low >= size ? size - 1 : low;
    }
    if (wrap == PBNDS_WRAP_REPEAT) {
        const int low = i < 0 ? i + size : i;
        return low >= size ? low - size : low;
    }
    const int low = i < 0 ? -1 - i : i;
    const int once = low >= 2 * size ? low - 2 * size : low;
    return once >= size ? 2 * size - 1 - once : once;
}

/** What one lookup needs, of `PBNDS_LANES` points at most. */
struct pbnds_lookup {
    float u[PBNDS_LANES], v[PBNDS_LANES]; /**< of the UV set, not yet transformed     */
    float lod[PBNDS_LANES];               /**< any number; NaN counts as 0            */
};

/** Texels and weights of four taps in each of two levels. */
struct pbnds_taps {
    uint32_t texel[2][4][PBNDS_LANES];
    float weight[2][4][PBNDS_LANES];
    int levels[PBNDS_LANES]; /**< 1: the second level has no weight                  */
};

/* Taps of one level, `share` being the level's part of the whole. */
static inline void pbnds_level_taps(const struct pbnds_bundle *b,
                                    enum pbnds_wrap wrap_u, enum pbnds_wrap wrap_v,
                                    int lanes, const float *u, const float *v,
                                    const int *level, const float *share,
                                    uint32_t texel[4][PBNDS_LANES],
                                    float weight[4][PBNDS_LANES])
{
    int width[PBNDS_LANES], height[PBNDS_LANES];
    uint32_t at[PBNDS_LANES];
    int differ = 0;
    for (int k = 0; k < lanes; ++k)
        differ |= level[k] ^ level[0];
    if (differ) {
        for (int k = 0; k < lanes; ++k) {
            width[k] = b->width[level[k]];
            height[k] = b->height[level[k]];
            at[k] = b->at[level[k]];
        }
    } else { /* the common case: no table to look into for each lane */
        const int w = b->width[level[0]], h = b->height[level[0]];
        const uint32_t first = b->at[level[0]];
        for (int k = 0; k < lanes; ++k) {
            width[k] = w;
            height[k] = h;
            at[k] = first;
        }
    }
    for (int k = 0; k < lanes; ++k) {
        /* Texel centres are at +0.5. */
        const float x = u[k] * (float)width[k] - 0.5f;
        const float y = v[k] * (float)height[k] - 0.5f;
        const int ix = pbnds_floor_int(x), iy = pbnds_floor_int(y);
        const float fx = x - (float)ix, fy = y - (float)iy;
        const uint32_t x0 = (uint32_t)pbnds_wrap_index(wrap_u, ix, width[k]);
        const uint32_t x1 = (uint32_t)pbnds_wrap_index(wrap_u, ix + 1, width[k]);
        const uint32_t y0 = (uint32_t)pbnds_wrap_index(wrap_v, iy, height[k]);
        const uint32_t y1 = (uint32_t)pbnds_wrap_index(wrap_v, iy + 1, height[k]);
        const uint32_t r0 = at[k] + y0 * (uint32_t)width[k];
        const uint32_t r1 = at[k] + y1 * (uint32_t)width[k];
        const float top = share[k] * (1.0f - fy), bottom = share[k] * fy;
        texel[0][k] = r0 + x0;
        texel[1][k] = r0 + x1;
        texel[2][k] = r1 + x0;
        texel[3][k] = r1 + x1;
        weight[0][k] = top * (1.0f - fx);
        weight[1][k] = top * fx;
        weight[2][k] = bottom * (1.0f - fx);
        weight[3][k] = bottom * fx;
    }
}

static inline void pbnds_wrapped_taps(const struct pbnds_bundle *b,
                                      enum pbnds_wrap wrap_u, enum pbnds_wrap wrap_v,
                                      int lanes, const struct pbnds_lookup *at,
                                      struct pbnds_taps *taps)
{
    float u[PBNDS_LANES], v[PBNDS_LANES], near[PBNDS_LANES], far[PBNDS_LANES];
    int level[PBNDS_LANES], next[PBNDS_LANES];
    float m[6] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};
    if (b->transformed) memcpy(m, b->transform, sizeof m);
    const float last = (float)(b->levels - 1);
    /* Short loops: the compiler turns each into vector instructions, one long loop not. */
    for (int k = 0; k < lanes; ++k) /* KHR_texture_transform */
        u[k] = m[0] * at->u[k] + m[1] * at->v[k] + m[2];
    for (int k = 0; k < lanes; ++k)
        v[k] = m[3] * at->u[k] + m[4] * at->v[k] + m[5];
    for (int k = 0; k < lanes; ++k)
        u[k] = pbnds_foldable(u[k]);
    for (int k = 0; k < lanes; ++k)
        v[k] = pbnds_foldable(v[k]);
    for (int k = 0; k < lanes; ++k)
        u[k] = pbnds_fold(wrap_u, u[k]);
    for (int k = 0; k < lanes; ++k)
        v[k] = pbnds_fold(wrap_v, v[k]);
    for (int k = 0; k < lanes; ++k) {
        const float low = at->lod[k] > 0.0f ? at->lod[k] : 0.0f;
        const float lod = low < last ? low : last;
        level[k] = (int)lod;
        far[k] = lod - (float)level[k];
        near[k] = 1.0f - far[k];
    }
    for (int k = 0; k < lanes; ++k) {
        const int more = far[k] > 0.0f;
        next[k] = level[k] + more;
        taps->levels[k] = 1 + more;
    }
    pbnds_level_taps(b, wrap_u, wrap_v, lanes, u, v, level, near, taps->texel[0],
                     taps->weight[0]);
    pbnds_level_taps(b, wrap_u, wrap_v, lanes, u, v, next, far, taps->texel[1],
                     taps->weight[1]);
}

static inline void pbnds_lookup_taps(const struct pbnds_bundle *b, int lanes,
                                     const struct pbnds_lookup *at,
                                     struct pbnds_taps *taps)
{
    /* The common case as constants, so that loops over lanes have no branches. */
    if (b->wrap_u == PBNDS_WRAP_REPEAT && b->wrap_v == PBNDS_WRAP_REPEAT)
        pbnds_wrapped_taps(b, PBNDS_WRAP_REPEAT, PBNDS_WRAP_REPEAT, lanes, at, taps);
    else
        pbnds_wrapped_taps(b, b->wrap_u, b->wrap_v, lanes, at, taps);
}

/** Four or eight channels of one lane, as linear light; texels are `stride` apart. */
static inline void pbnds_gather4(const uint16_t *texels, size_t stride,
                                 const struct pbnds_taps *taps, int lane, float *out)
{
    float sum[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    for (int level = 0; level < taps->levels[lane]; ++level) {
        for (int tap = 0; tap < 4; ++tap) {
            const uint16_t *p = texels + taps->texel[level][tap][lane] * stride;
            const float w = taps->weight[level][tap][lane];
            for (int c = 0; c < 4; ++c)
                sum[c] += w * (float)p[c];
        }
    }
    for (int c = 0; c < 4; ++c)
        out[c] = sum[c] * (1.0f / 65535.0f);
}

static inline void pbnds_gather8(const uint16_t *texels, size_t stride,
                                 const struct pbnds_taps *taps, int lane, float *out)
{
#if defined(PBNDS_VECTORS)
    pbnds_float8 sum = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    for (int level = 0; level < taps->levels[lane]; ++level) {
        for (int tap = 0; tap < 4; ++tap) {
            pbnds_add8(&sum, taps->weight[level][tap][lane],
                       texels + taps->texel[level][tap][lane] * stride);
        }
    }
    sum *= 1.0f / 65535.0f;
    memcpy(out, &sum, sizeof sum);
#else
    pbnds_gather4(texels, stride, taps, lane, out);
    pbnds_gather4(texels + 4, stride, taps, lane, out + 4);
#endif
}

/** All channels of one lane, as linear light; `channels` is best a constant. */
static inline void pbnds_taps_gather(const struct pbnds_bundle *b,
                                     const struct pbnds_taps *taps, int lane,
                                     int channels, float *out)
{
    const size_t stride = (size_t)channels;
    int c = 0;
    for (; c + 8 <= channels; c += 8)
        pbnds_gather8(b->texels + c, stride, taps, lane, out + c);
    if (c < channels) pbnds_gather4(b->texels + c, stride, taps, lane, out + c);
}

/** One point, all channels of the bundle. */
static inline void pbnds_bundle_sample(const struct pbnds_bundle *b,
                                       struct pbnds_vec2 uv, float lod, float *out)
{
    const struct pbnds_lookup at = {.u = {uv.x}, .v = {uv.y}, .lod = {lod}};
    struct pbnds_taps taps;
    pbnds_lookup_taps(b, 1, &at, &taps);
    pbnds_taps_gather(b, &taps, 0, b->channels, out);
}

/** lambda of the ray cone; `uv_area` and `area` are twice the triangle's in UV space and
 *  in the world, `cosine` is |n.d|. Degenerate triangles get the finest level. */
static inline float pbnds_cone_lod(float footprint, float cosine, float uv_area,
                                   float area, float density)
{
    const float across = footprint * footprint * uv_area * density;
    const float along = area * cosine * cosine;
    const float square = across / along;
    const float lod = 0.5f * pbnds_log2_about(square);
    /* Written so that NaN and infinity fail. */
    return square > 1e-30f && square < 1e30f ? lod : 0.0f;
}
#endif /* PBNDS_ENGINE_SCENE_LOOKUP_H */
