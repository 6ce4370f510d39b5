#include "scenes/generator/material.h"

#include <stdlib.h>

#include "engine/core/color.h"
#include "scenes/generator/noise.h"
#include "scenes/generator/pattern.h"

struct pbnds_vec3 gen_srgb(uint32_t code)
{
    return pbnds_vec3_make(pbnds_srgb_decode((float)(code >> 16 & 255u) / 255.0f),
                           pbnds_srgb_decode((float)(code >> 8 & 255u) / 255.0f),
                           pbnds_srgb_decode((float)(code & 255u) / 255.0f));
}

/* sRGB codes. Earths, stones, woods, plants and building stuff as photographed charts
 * and material collections give them; skin after the Monk and Fitzpatrick scales. */
static const uint32_t NATURAL[] = {
    0x8c8c8a, 0x6f6e6a, 0xb4b0a8, 0x4a4845, 0xd8d4cc, 0xa39a8c, 0x7d6f5f, 0x5b4636,
    0x3d2f25, 0x9b7653, 0xc2a480, 0xe0cda9, 0x8a5a3c, 0x6b3f2a, 0xa65f42, 0xb5785a,
    0x556b2f, 0x6b8e4e, 0x3f5a36, 0x8f9779, 0xc9b458, 0x7a8b99, 0x43515c, 0xece9e2,
    0xf4f2ee, 0x1f1f1e, 0x2e2c2a, 0x716154, 0xbfae98, 0x94887b, 0xcfc6b4, 0x5e5a4f,
};
static const uint32_t SKIN[] = {
    0xf6ede4, 0xf3e7db, 0xf7d7c4, 0xeadaba, 0xd7bd96, 0xe0ac90,
    0xc68863, 0xa07e56, 0x825c43, 0x8d5524, 0x604134, 0x523426,
};
static const uint32_t PAINT[] = {
    0xc0221f, 0xd9531e, 0xe8a317, 0xf2d21b, 0x7fb93b, 0x2e8b40, 0x157a6e,
    0x1c9bc4, 0x1f5fae, 0x27348b, 0x5b2a86, 0xa02c7a, 0xe2648f, 0xf3f3f0,
    0x141414, 0x0e3b2e, 0x7c1f2b, 0xb9d3e6, 0xf7c8c0, 0xd6e8c3,
};
/* Reflectance at normal incidence, linear (Hoffman, "Background: Physics and Math of
 * Shading", SIGGRAPH 2013 course, and the usual optical constants). */
static const float METAL[][3] = {
    {0.972f, 0.960f, 0.915f}, {0.913f, 0.922f, 0.924f}, {1.000f, 0.766f, 0.336f},
    {0.955f, 0.638f, 0.538f}, {0.562f, 0.565f, 0.578f}, {0.550f, 0.556f, 0.554f},
    {0.542f, 0.497f, 0.449f}, {0.660f, 0.609f, 0.526f}, {0.887f, 0.789f, 0.434f},
    {0.320f, 0.310f, 0.300f}, {0.714f, 0.428f, 0.181f},
};

#define COUNT(array) ((int)(sizeof(array) / sizeof(array)[0]))

static struct pbnds_vec3 hue_color(float hue, float saturation, float value)
{
    float c[3];
    for (int i = 0; i < 3; ++i) {
        const float k = fmodf((float)(5 - 2 * i) + 6.0f * hue, 6.0f);
        const float t = pbnds_clamp(fminf(k, 4.0f - k), 0.0f, 1.0f);
        c[i] = pbnds_srgb_decode(value - value * saturation * t);
    }
    return pbnds_vec3_make(c[0], c[1], c[2]);
}

/* Moves a palette colour a little: no two worlds share their exact colours. */
static struct pbnds_vec3 jitter(struct pbnds_rng *r, struct pbnds_vec3 c)
{
    const float gain = gen_log_uniform(r, 0.7f, 1.3f);
    const struct pbnds_vec3 tint = gen_vec3(r, 0.9f, 1.1f);
    c = pbnds_scale(pbnds_mul(c, tint), gain);
    return pbnds_vec3_make(pbnds_clamp(c.x, 0.01f, 0.95f),
                           pbnds_clamp(c.y, 0.01f, 0.95f),
                           pbnds_clamp(c.z, 0.01f, 0.95f));
}

static struct pbnds_vec3 random_color(struct pbnds_rng *r, enum gen_surface kind)
{
    static const float any[5] = {4.0f, 1.0f, 2.0f, 1.5f, 1.5f};
    static const float ground[5] = {6.0f, 0.0f, 0.6f, 0.6f, 2.5f};
    const int family =
        kind == GEN_SKIN ? 1 : gen_pick(r, kind == GEN_GROUND ? ground : any, 5);
    switch (family) {
    case 0:
        return jitter(r, gen_srgb(NATURAL[gen_below(r, COUNT(NATURAL))]));
    case 1:
        return jitter(r, gen_srgb(SKIN[gen_below(r, COUNT(SKIN))]));
    case 2:
        return jitter(r, gen_srgb(PAINT[gen_below(r, COUNT(PAINT))]));
    case 3: {
        const float hue = pbnds_rng_float(r);
        const float saturation = gen_uniform(r, 0.05f, 0.9f);
        const float value = gen_uniform(r, 0.15f, 0.97f);
        return jitter(r, hue_color(hue, saturation, value));
    }
    default:
        return jitter(r, pbnds_splat(pbnds_srgb_decode(gen_uniform(r, 0.1f, 0.97f))));
    }
}

/* One homogeneous layer. */
struct layer {
    struct pbnds_vec3 color;
    float metallic, roughness;
};

static struct layer random_layer(struct pbnds_rng *r, enum gen_surface kind)
{
    struct layer l = {.metallic = 0.0f};
    const float metal = kind == GEN_METAL                       ? 1.0f
                        : kind == GEN_GROUND                    ? 0.05f
                        : kind == GEN_SKIN || kind == GEN_CLOTH ? 0.0f
                                                                : 0.25f;
    if (gen_chance(r, metal)) {
        const float *f0 = METAL[gen_below(r, COUNT(METAL))];
        l.color = jitter(r, pbnds_vec3_make(f0[0], f0[1], f0[2]));
        /* anodised and painted metal */
        if (gen_chance(r, 0.2f)) l.color = random_color(r, GEN_ANY);
        l.metallic = 1.0f;
        l.roughness = gen_uniform(r, 0.05f, 0.75f);
    } else {
        l.color = random_color(r, kind);
        if (kind == GEN_ANY && gen_chance(r, 0.06f))
            l.metallic = gen_uniform(r, 0.1f, 0.9f);
        const bool glossy = gen_chance(r, kind == GEN_GROUND ? 0.25f : 0.4f);
        l.roughness = glossy ? gen_uniform(r, 0.05f, 0.4f) : gen_uniform(r, 0.3f, 1.0f);
        if (kind == GEN_SKIN) l.roughness = gen_uniform(r, 0.35f, 0.65f);
        if (kind == GEN_CLOTH) l.roughness = gen_uniform(r, 0.6f, 1.0f);
    }
    return l;
}

/* Two layers and what lies between them. */
struct bake {
    struct layer a, b;
    struct gen_pattern pattern;
    float grain;         /* amplitude of fine noise on colour and roughness */
    float depth, bump;   /* height of the pattern and of the fine noise     */
    int grain_frequency; /* cells across the tile                           */
    uint32_t seed;
    int size;
};

static struct bake random_bake(struct pbnds_rng *r, enum gen_surface kind, int size)
{
    struct bake k;
    k.a = random_layer(r, kind);
    k.b = k.a;
    /* worn, dirty, painted over: the second layer often keeps something of the first */
    const int change = gen_below(r, 4);
    switch (kind == GEN_SKIN ? -1 : change) {
    case -1: { /* freckles, flush, veins */
        const float tint = gen_uniform(r, 0.7f, 1.1f);
        k.b.color = pbnds_mul(k.a.color, pbnds_vec3_make(1.0f, tint, tint));
        k.b.color = pbnds_scale(k.b.color, gen_uniform(r, 0.7f, 1.0f));
        k.b.roughness =
            pbnds_clamp(k.a.roughness + gen_uniform(r, -0.15f, 0.15f), 0.2f, 0.9f);
        break;
    }
    case 0:
        k.b.color = pbnds_scale(k.a.color, gen_uniform(r, 0.3f, 0.8f));
        k.b.roughness = gen_uniform(r, 0.1f, 1.0f);
        break;
    case 1:
        k.b.roughness = gen_uniform(r, 0.05f, 1.0f);
        break;
    default:
        k.b = random_layer(r, kind);
        if (gen_chance(r, 0.5f)) k.b.metallic = k.a.metallic;
        break;
    }
    k.pattern = gen_random_pattern(r);
    if (kind == GEN_SKIN) k.pattern.kind = gen_chance(r, 0.7f) ? GEN_CLOUDS : GEN_SPOTS;
    k.grain = gen_chance(r, 0.5f) ? 0.0f : gen_uniform(r, 0.05f, 0.5f);
    k.depth = gen_chance(r, 0.4f) ? 0.0f : gen_uniform(r, -0.02f, 0.02f);
    k.bump = gen_chance(r, 0.4f) ? 0.0f : gen_log_uniform(r, 0.003f, 0.04f);
    k.grain_frequency = gen_between(r, 4, 24);
    k.seed = (uint32_t)(pbnds_rng_u64(r) >> 40);
    k.size = size;
    return k;
}

static float mix(float a, float b, float t)
{
    return a + (b - a) * t;
}

static uint8_t code(float x)
{
    return (uint8_t)lrintf(255.0f * pbnds_clamp(x, 0.0f, 1.0f));
}

/* Pattern and grain of every texel. */
static void bake_fields(const struct bake *k, float *mask, float *grain)
{
    for (int y = 0; y < k->size; ++y) {
        for (int x = 0; x < k->size; ++x) {
            const float u = ((float)x + 0.5f) / (float)k->size;
            const float v = ((float)y + 0.5f) / (float)k->size;
            const float n = (float)k->grain_frequency;
            const size_t i = (size_t)(y * k->size + x);
            mask[i] = gen_pattern_value(&k->pattern, u, v);
            grain[i] = k->grain > 0.0f || k->bump > 0.0f
                           ? gen_fbm(pbnds_vec3_make(u * n, v * n, 0.5f), 3,
                                     k->grain_frequency, k->seed)
                           : 0.0f;
        }
    }
}

static void bake_color(const struct bake *k, const float *mask, const float *grain,
                       uint8_t *rgb)
{
    for (int i = 0; i < k->size * k->size; ++i) {
        const struct pbnds_vec3 c = pbnds_scale(
            pbnds_lerp(k->a.color, k->b.color, mask[i]), 1.0f + k->grain * grain[i]);
        rgb[3 * i] = code(pbnds_srgb_encode(c.x));
        rgb[3 * i + 1] = code(pbnds_srgb_encode(c.y));
        rgb[3 * i + 2] = code(pbnds_srgb_encode(c.z));
    }
}

static void bake_surface(const struct bake *k, const float *mask, const float *grain,
                         uint8_t *rgb)
{
    for (int i = 0; i < k->size * k->size; ++i) {
        const float rough = mix(k->a.roughness, k->b.roughness, mask[i]);
        rgb[3 * i] = 255; /* occlusion lives here in other people's files: none */
        rgb[3 * i + 1] = code(fmaxf(rough + 0.3f * k->grain * grain[i], 0.04f));
        rgb[3 * i + 2] = code(mix(k->a.metallic, k->b.metallic, mask[i]));
    }
}

/* Slope of the height field, wrapping; green points up, against v. */
static void bake_normal(const struct bake *k, const float *mask, const float *grain,
                        uint8_t *rgb)
{
    const int n = k->size;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const int east = y * n + (x + 1) % n, west = y * n + (x + n - 1) % n;
            const int south = (y + 1) % n * n + x, north = (y + n - 1) % n * n + x;
            const float scale = 0.5f * (float)n;
            const float du = scale * (k->depth * (mask[east] - mask[west]) +
                                      k->bump * (grain[east] - grain[west]));
            const float dv = scale * (k->depth * (mask[south] - mask[north]) +
                                      k->bump * (grain[south] - grain[north]));
            const struct pbnds_vec3 m = pbnds_normalize(pbnds_vec3_make(
                pbnds_clamp(-du, -1.5f, 1.5f), pbnds_clamp(dv, -1.5f, 1.5f), 1.0f));
            uint8_t *out = rgb + 3 * (y * n + x);
            out[0] = code(0.5f + 0.5f * m.x);
            out[1] = code(0.5f + 0.5f * m.y);
            out[2] = code(0.5f + 0.5f * m.z);
        }
    }
}

static void bake_images(struct gen_world *w, const struct bake *k,
                        struct gen_material *m)
{
    const size_t texels = (size_t)k->size * (size_t)k->size;
    float *mask = malloc(texels * sizeof *mask),
          *grain = malloc(texels * sizeof *grain);
    uint8_t *rgb = malloc(texels * 3);
    if (!mask || !grain || !rgb) {
        w->failed = true;
        goto done;
    }
    bake_fields(k, mask, grain);
    const struct pbnds_vec3 d = pbnds_sub(k->a.color, k->b.color);
    if (k->grain > 0.0f || pbnds_dot(d, d) > 0.0f) {
        bake_color(k, mask, grain, rgb);
        m->color_image = gen_world_image(w, rgb, k->size, k->size);
        if (m->color_image >= 0) m->base_color = pbnds_splat(1.0f);
    }
    if (k->a.roughness != k->b.roughness || k->a.metallic != k->b.metallic) {
        bake_surface(k, mask, grain, rgb);
        m->surface_image = gen_world_image(w, rgb, k->size, k->size);
        if (m->surface_image >= 0) m->metallic = m->roughness = 1.0f;
    }
    if (k->depth != 0.0f || k->bump > 0.0f) {
        bake_normal(k, mask, grain, rgb);
        m->normal_image = gen_world_image(w, rgb, k->size, k->size);
    }
done:
    free(mask);
    free(grain);
    free(rgb);
}

int gen_random_material(struct gen_world *w, struct pbnds_rng *r, enum gen_surface kind,
                        int texture_size)
{
    static const float chances[6] = {0.5f, 0.65f, 0.5f, 0.6f, 0.4f, 0.0f};
    const bool textured = gen_chance(r, chances[kind]);
    const struct bake k = random_bake(r, kind, texture_size);
    struct gen_material m = gen_material_plain(k.a.color, k.a.metallic, k.a.roughness);
    m.repeat = (float)gen_between(r, 1, 3);
    if (textured) bake_images(w, &k, &m);
    if (gen_chance(r, 0.08f)) m.ior = gen_uniform(r, 1.2f, 2.0f);
    if (gen_chance(r, 0.05f)) m.specular = gen_uniform(r, 0.0f, 0.9f);
    return gen_world_material(w, &m);
}
