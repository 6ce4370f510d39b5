#include "scenes/generator/material.h"

#include "engine/core/color.h"
#include "scenes/generator/bake.h"

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
static const uint32_t BARK[] = {0x5b4636, 0x3d2f25, 0x716154, 0x8a7a68,
                                0x4a4038, 0x9b8a76, 0x2e241c, 0xb0a595};
static const uint32_t LEAF[] = {0x3f5a36, 0x556b2f, 0x6b8e4e, 0x2f4a26, 0x7c9a3c,
                                0x8f9779, 0xa8862f, 0xb5532a, 0x7a2f2f, 0x4f7a5f};
static const uint32_t FRUIT[] = {0xa31c1c, 0xd96a1a, 0xe8b51f, 0xc8d24a, 0x5f8f2a,
                                 0x5a1f3f, 0xe07a5f, 0xf0c9a0, 0x7a4a2a, 0x2f5f2a};
/* Reflectance at normal incidence, linear: silver, aluminium, gold, copper, iron,
 * chromium, titanium, nickel, brass, dark iron oxide, bronze, platinum, zinc, cobalt,
 * tungsten (Hoffman, "Background: Physics and Math of Shading", SIGGRAPH 2013 course, table
 * of metals; Lagarde, "Feeding a physically based shading model", 2011; both from measured
 * complex indices of refraction). */
static const float METAL[][3] = {
    {0.972f, 0.960f, 0.915f}, {0.913f, 0.922f, 0.924f}, {1.000f, 0.766f, 0.336f},
    {0.955f, 0.638f, 0.538f}, {0.562f, 0.565f, 0.578f}, {0.550f, 0.556f, 0.554f},
    {0.542f, 0.497f, 0.449f}, {0.660f, 0.609f, 0.526f}, {0.887f, 0.789f, 0.434f},
    {0.320f, 0.310f, 0.300f}, {0.714f, 0.428f, 0.181f}, {0.673f, 0.637f, 0.585f},
    {0.664f, 0.824f, 0.850f}, {0.662f, 0.655f, 0.634f}, {0.504f, 0.498f, 0.478f},
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
    return pbnds_vec3_make(pbnds_clamp(c.x, 0.008f, 0.92f),
                           pbnds_clamp(c.y, 0.008f, 0.92f),
                           pbnds_clamp(c.z, 0.008f, 0.92f));
}

static struct pbnds_vec3 one_of(struct pbnds_rng *r, const uint32_t *codes, int count)
{
    return jitter(r, gen_srgb(codes[gen_below(r, count)]));
}

static struct pbnds_vec3 free_color(struct pbnds_rng *r, bool ground)
{
    static const float any[7] = {3.5f, 0.6f, 2.0f, 1.5f, 1.3f, 0.7f, 0.8f};
    static const float floors[7] = {6.0f, 0.0f, 0.6f, 0.6f, 2.0f, 0.4f, 0.8f};
    switch (gen_pick(r, ground ? floors : any, 7)) {
    case 0:
        return one_of(r, NATURAL, COUNT(NATURAL));
    case 1:
        return one_of(r, SKIN, COUNT(SKIN));
    case 2:
        return one_of(r, PAINT, COUNT(PAINT));
    case 3: {
        const float hue = pbnds_rng_float(r);
        const float saturation = gen_uniform(r, 0.05f, 0.9f);
        const float value = gen_uniform(r, 0.15f, 0.97f);
        return jitter(r, hue_color(hue, saturation, value));
    }
    case 5: /* coal, rubber, black paint */
        return jitter(r, pbnds_splat(gen_log_uniform(r, 0.015f, 0.05f)));
    case 6: /* chalk, porcelain, paper, snow */
        return jitter(r, pbnds_splat(gen_uniform(r, 0.65f, 0.88f)));
    default:
        return jitter(r, pbnds_splat(pbnds_srgb_decode(gen_uniform(r, 0.1f, 0.97f))));
    }
}

void gen_random_palette(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 2, GEN_PALETTE);
    w->palette_count = 0;
    for (int i = 0; i < GEN_PALETTE; ++i)
        w->palette[i] = free_color(r, false);
    if (gen_chance(r, 0.45f)) w->palette_count = count;
}

static struct pbnds_vec3 random_color(const struct gen_world *w, struct pbnds_rng *r,
                                      enum gen_surface kind)
{
    switch (kind) {
    case GEN_SKIN: /* the scales show skin as it is photographed; its albedo is lower */
        return pbnds_scale(one_of(r, SKIN, COUNT(SKIN)), 0.75f);
    case GEN_BARK:
        return one_of(r, BARK, COUNT(BARK));
    case GEN_LEAF:
        return one_of(r, LEAF, COUNT(LEAF));
    case GEN_FRUIT:
        return one_of(r, FRUIT, COUNT(FRUIT));
    default:
        break;
    }
    const struct pbnds_vec3 own = free_color(r, kind == GEN_GROUND);
    if (w->palette_count == 0 || gen_chance(r, 0.25f)) return own;
    return jitter(r, w->palette[gen_below(r, w->palette_count)]);
}

/* Polished, glossy or matt. */
static float random_roughness(struct pbnds_rng *r, float polished, float glossy)
{
    const float x = pbnds_rng_float(r);
    if (x < polished) return gen_log_uniform(r, 0.02f, 0.12f);
    if (x < polished + glossy) return gen_uniform(r, 0.1f, 0.4f);
    return gen_uniform(r, 0.3f, 1.0f);
}

static struct gen_layer random_metal(const struct gen_world *w, struct pbnds_rng *r)
{
    const float *f0 = METAL[gen_below(r, COUNT(METAL))];
    struct gen_layer l = {pbnds_vec3_make(f0[0], f0[1], f0[2]), 1.0f, 0.0f};
    const float soiled = gen_uniform(r, 0.75f, 1.0f);
    l.color = pbnds_scale(l.color, gen_chance(r, 0.4f) ? soiled : 1.0f);
    /* anodised, tinted and lacquered metal */
    if (gen_chance(r, 0.15f)) l.color = random_color(w, r, GEN_ANY);
    l.roughness = random_roughness(r, 0.18f, 0.45f);
    return l;
}

static struct gen_layer random_layer(const struct gen_world *w, struct pbnds_rng *r,
                                     enum gen_surface kind)
{
    static const float metals[GEN_SURFACE_COUNT] = {[GEN_ANY] = 0.2f,
                                                    [GEN_GROUND] = 0.04f,
                                                    [GEN_METAL] = 1.0f,
                                                    [GEN_PLAIN] = 0.2f,
                                                    [GEN_GLAZE] = 0.1f};
    if (gen_chance(r, metals[kind])) return random_metal(w, r);
    struct gen_layer l = {.metallic = 0.0f};
    l.color = random_color(w, r, kind);
    if (kind == GEN_ANY && gen_chance(r, 0.04f))
        l.metallic = gen_uniform(r, 0.1f, 0.9f);
    switch (kind) {
    case GEN_SKIN:
        l.roughness = gen_uniform(r, 0.3f, 0.6f);
        break;
    case GEN_CLOTH:
    case GEN_BARK:
        l.roughness = gen_uniform(r, 0.6f, 1.0f);
        break;
    case GEN_LEAF:
    case GEN_FRUIT:
        l.roughness = gen_uniform(r, 0.2f, 0.7f);
        break;
    case GEN_GLAZE:
        l.roughness = random_roughness(r, 0.6f, 0.3f);
        break;
    case GEN_GROUND:
        l.roughness = random_roughness(r, 0.06f, 0.2f);
        break;
    default:
        l.roughness = random_roughness(r, 0.1f, 0.3f);
        break;
    }
    return l;
}

/* Worn, dirty, painted over: the second layer often keeps something of the first. */
static struct gen_layer second_layer(const struct gen_world *w, struct pbnds_rng *r,
                                     enum gen_surface kind, const struct gen_layer *a)
{
    struct gen_layer b = *a;
    const int change = gen_below(r, 4);
    if (kind == GEN_SKIN) { /* freckles, flush, veins */
        const float tint = gen_uniform(r, 0.7f, 1.1f);
        b.color = pbnds_mul(a->color, pbnds_vec3_make(1.0f, tint, tint));
        b.color = pbnds_scale(b.color, gen_uniform(r, 0.7f, 1.0f));
        b.roughness =
            pbnds_clamp(a->roughness + gen_uniform(r, -0.12f, 0.12f), 0.2f, 0.8f);
    } else if (kind == GEN_LEAF || kind == GEN_FRUIT || kind == GEN_BARK) {
        const struct gen_layer other = random_layer(w, r, kind);
        b.color = pbnds_lerp(a->color, other.color, gen_uniform(r, 0.1f, 0.7f));
    } else if (change == 0) {
        b.color = pbnds_scale(a->color, gen_uniform(r, 0.3f, 0.8f));
        b.roughness = gen_uniform(r, 0.1f, 1.0f);
    } else if (change == 1) {
        b.roughness = gen_uniform(r, 0.03f, 1.0f);
    } else {
        b = random_layer(w, r, kind);
        if (gen_chance(r, 0.5f)) b.metallic = a->metallic;
    }
    return b;
}

static void random_marks(const struct gen_world *w, struct pbnds_rng *r,
                         struct gen_bake *k)
{
    k->mark_count = gen_between(r, 2, GEN_MARKS_MAX);
    for (int i = 0; i < k->mark_count; ++i) {
        struct gen_mark *m = &k->marks[i];
        m->kind = gen_below(r, 5);
        m->x = gen_uniform(r, 0.1f, 0.9f);
        m->y = gen_uniform(r, 0.1f, 0.9f);
        m->half_x = gen_log_uniform(r, 0.04f, 0.4f);
        m->half_y = gen_chance(r, 0.4f) ? m->half_x : gen_log_uniform(r, 0.03f, 0.4f);
        m->slant = gen_chance(r, 0.7f) ? 0.0f : gen_uniform(r, -1.0f, 1.0f);
        m->color = random_color(w, r, GEN_ANY);
    }
}

/* Patterns that a kind of surface has; -1: any. */
static int own_pattern(struct pbnds_rng *r, enum gen_surface kind)
{
    static const enum gen_pattern_kind skin[] = {GEN_CLOUDS, GEN_CLOUDS, GEN_SPECKLE};
    static const enum gen_pattern_kind bark[] = {GEN_WOOD, GEN_CRACKS, GEN_CLOUDS,
                                                 GEN_BRUSHED};
    static const enum gen_pattern_kind leaf[] = {GEN_GRADIENT, GEN_CLOUDS, GEN_BLOTCHES,
                                                 GEN_SPECKLE};
    static const enum gen_pattern_kind fruit[] = {GEN_GRADIENT, GEN_CLOUDS, GEN_SPECKLE,
                                                  GEN_STRIPES, GEN_SPOTS};
    static const enum gen_pattern_kind cloth[] = {GEN_WEAVE, GEN_PLAID,   GEN_STRIPES,
                                                  GEN_DOTS,  GEN_CHECKER, GEN_CHEVRON};
    static const enum gen_pattern_kind ground[] = {
        GEN_TILES,  GEN_PLANKS,   GEN_BRICKS,   GEN_STONES, GEN_HEXAGONS, GEN_CRACKS,
        GEN_CLOUDS, GEN_TERRAZZO, GEN_BLOTCHES, GEN_MARBLE, GEN_SPECKLE,  GEN_CHECKER};
    static const enum gen_pattern_kind metal[] = {GEN_SCRATCHES, GEN_BRUSHED,
                                                  GEN_BLOTCHES, GEN_CLOUDS};
    const float x = pbnds_rng_float(r);
#define OF(list) (int)(list)[(int)(x * (float)COUNT(list))]
    switch (kind) {
    case GEN_SKIN:
        return OF(skin);
    case GEN_BARK:
        return OF(bark);
    case GEN_LEAF:
        return OF(leaf);
    case GEN_FRUIT:
        return OF(fruit);
    default:
        break;
    }
    if (!gen_chance(r, 0.6f)) return -1;
    if (kind == GEN_CLOTH) return OF(cloth);
    if (kind == GEN_GROUND) return OF(ground);
    if (kind == GEN_METAL) return OF(metal);
#undef OF
    return -1;
}

static struct gen_bake random_bake(const struct gen_world *w, struct pbnds_rng *r,
                                   enum gen_surface kind, int size)
{
    struct gen_bake k = {.size = size};
    k.a = random_layer(w, r, kind);
    k.b = second_layer(w, r, kind, &k.a);
    k.pattern = gen_random_pattern(r);
    const int own = own_pattern(r, kind);
    if (own >= 0) k.pattern.kind = (enum gen_pattern_kind)own;
    if (gen_chance(r, 0.5f)) k.variety = gen_uniform(r, 0.05f, 0.7f);
    if (kind == GEN_SKIN) k.variety = 0.0f;
    k.worn = gen_random_pattern(r);
    static const enum gen_pattern_kind wears[] = {
        GEN_CLOUDS, GEN_BLOTCHES, GEN_SCRATCHES, GEN_SPECKLE, GEN_CRACKS, GEN_MARBLE};
    k.worn.kind = wears[gen_below(r, COUNT(wears))];
    k.worn.level = gen_uniform(r, 0.5f, 0.75f);
    k.wear =
        random_layer(w, r, kind == GEN_ANY || kind == GEN_METAL ? GEN_GROUND : kind);
    k.has_wear = gen_chance(r, kind == GEN_SKIN ? 0.0f : 0.3f);
    k.grain = gen_chance(r, 0.55f) ? 0.0f : gen_uniform(r, 0.05f, 0.45f);
    k.depth = gen_chance(r, 0.45f) ? 0.0f : gen_uniform(r, -0.02f, 0.02f);
    k.bump = gen_chance(r, 0.55f) ? 0.0f : gen_log_uniform(r, 0.001f, 0.03f);
    if (kind == GEN_SKIN) {
        k.depth *= 0.2f;
        k.bump *= 0.25f;
        k.grain *= 0.3f;
    }
    k.grain_frequency = gen_between(r, 4, 24);
    k.seed = (uint32_t)(pbnds_rng_u64(r) >> 40);
    const bool marked = gen_chance(r, kind == GEN_PRINT ? 0.75f : 0.06f);
    if (kind == GEN_PRINT && !marked) k.pattern.kind = GEN_TEXT;
    if (marked && (kind == GEN_ANY || kind == GEN_PRINT || kind == GEN_CLOTH)) {
        random_marks(w, r, &k);
    }
    return k;
}

/* Black body colours and signs; radiance in the units of the light maps. */
static struct gen_material glow(struct pbnds_rng *r)
{
    static const struct pbnds_vec3 warm = {1.0f, 0.62f, 0.28f},
                                   cool = {0.8f, 0.9f, 1.0f};
    struct gen_material m = gen_material_plain(pbnds_splat(0.8f), 0.0f, 0.5f);
    const float t = pbnds_rng_float(r), hue = pbnds_rng_float(r);
    const bool colored = gen_chance(r, 0.35f);
    const struct pbnds_vec3 c =
        colored ? hue_color(hue, 0.85f, 1.0f) : pbnds_lerp(warm, cool, t);
    m.emission = pbnds_scale(c, gen_log_uniform(r, 0.5f, 25.0f));
    return m;
}

/* Index of refraction 1.33 (water, f0 0.02) to 1.8 (f0 0.08), few beyond; 1.5 (0.04) is
 * what most files say. KHR_materials_specular dims and tints it. */
static void random_dielectric(struct pbnds_rng *r, enum gen_surface kind,
                              struct gen_material *m)
{
    const bool stone = gen_chance(r, 0.03f), other = gen_chance(r, 0.35f);
    const float ior = gen_uniform(r, 1.33f, 1.8f), gem = gen_uniform(r, 1.8f, 2.4f);
    if (kind == GEN_SKIN && other) m->ior = 1.4f; /* f0 0.028 (Weyrich et al. 2006) */
    if (kind != GEN_SKIN && other) m->ior = stone ? gem : ior;
    const float specular = pbnds_rng_float(r);
    if (gen_chance(r, 0.1f)) m->specular = specular;
    const struct pbnds_vec3 tint = gen_vec3(r, 0.2f, 1.0f);
    if (gen_chance(r, 0.04f)) m->specular_color = tint;
}

int gen_random_material(struct gen_world *w, struct pbnds_rng *r, enum gen_surface kind,
                        int texture_size)
{
    static const float chances[GEN_SURFACE_COUNT] = {
        [GEN_ANY] = 0.45f,   [GEN_GROUND] = 0.7f, [GEN_SKIN] = 0.6f,
        [GEN_CLOTH] = 0.65f, [GEN_METAL] = 0.4f,  [GEN_BARK] = 0.8f,
        [GEN_LEAF] = 0.6f,   [GEN_FRUIT] = 0.7f,  [GEN_GLAZE] = 0.25f,
        [GEN_PRINT] = 1.0f};
    const bool glows = gen_chance(r, 0.012f);
    if (kind == GEN_GLOW || (glows && kind == GEN_ANY)) {
        const struct gen_material m = glow(r);
        return gen_world_material(w, &m);
    }
    const bool textured = gen_chance(r, chances[kind]);
    const struct gen_bake k = random_bake(w, r, kind, texture_size);
    struct gen_material m = gen_material_plain(k.a.color, k.a.metallic, k.a.roughness);
    const float repeat = (float)gen_between(r, 1, 3);
    m.repeat = kind == GEN_PRINT || k.mark_count > 0 ? 1.0f : repeat;
    random_dielectric(r, kind, &m);
    if (textured) gen_bake_images(w, &k, &m);
    return gen_world_material(w, &m);
}
