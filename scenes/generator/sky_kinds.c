/* What light maps there are: parameters of the formula in sky.h. */
#include "scenes/generator/sky.h"

static struct pbnds_vec3 v3(float x, float y, float z)
{
    return pbnds_vec3_make(x, y, z);
}

/* Disc of a given irradiance on a surface that faces it. */
static struct gen_lamp sun(struct pbnds_vec3 direction, float radius,
                           struct pbnds_vec3 irradiance)
{
    struct gen_lamp l = {.direction = pbnds_normalize(direction), .half_x = radius};
    l.softness = 0.05f;
    l.radiance =
        pbnds_scale(irradiance, 1.0f / (2.0f * PBNDS_PI * (1.0f - cosf(radius))));
    return l;
}

static struct gen_lamp softbox(struct pbnds_rng *r, struct pbnds_vec3 direction,
                               struct pbnds_vec3 radiance)
{
    const struct pbnds_frame f = pbnds_frame_from_normal(direction);
    const float roll = gen_uniform(r, 0.0f, PBNDS_PI);
    struct gen_lamp l = {.direction = direction, .radiance = radiance};
    l.side = pbnds_mad(pbnds_scale(f.t, cosf(roll)), f.b, sinf(roll));
    l.up = pbnds_cross(direction, l.side);
    l.half_x = gen_log_uniform(r, 0.05f, 0.6f);
    l.half_y = gen_chance(r, 0.3f) ? 0.0f : l.half_x * gen_log_uniform(r, 0.25f, 1.0f);
    l.softness = gen_log_uniform(r, 0.02f, 0.8f);
    return l;
}

/* Colour of a black body near `kelvin`, luminance about 1: a fit good enough for lamps
 * between 1800 and 12000 K (linear Rec. 709). */
static struct pbnds_vec3 black_body(float kelvin)
{
    const float t = 6500.0f / kelvin - 1.0f;
    const struct pbnds_vec3 c = {expf(0.55f * t), expf(-0.15f * t), expf(-1.25f * t)};
    return pbnds_scale(c, 1.0f / pbnds_luminance(c));
}

static struct pbnds_vec3 lamp_color(struct pbnds_rng *r)
{
    const float kelvin = gen_log_uniform(r, 2200.0f, 11000.0f);
    const struct pbnds_vec3 gel = gen_vec3(r, 0.05f, 1.0f);
    if (gen_chance(r, 0.15f)) return pbnds_scale(gel, 1.0f / pbnds_luminance(gel));
    return black_body(kelvin);
}

static struct pbnds_vec3 from_angles(float azimuth, float elevation)
{
    return v3(cosf(elevation) * cosf(azimuth), sinf(elevation),
              cosf(elevation) * sinf(azimuth));
}

static struct pbnds_vec3 any_direction(struct pbnds_rng *r, float lowest)
{
    const float y = gen_uniform(r, lowest, 1.0f);
    const float azimuth = gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
    return from_angles(azimuth, asinf(y));
}

/* Grey to brown or green, never far from grey. */
static struct pbnds_vec3 earth(struct pbnds_rng *r, float lo, float hi)
{
    const float grey = gen_log_uniform(r, lo, hi);
    return pbnds_mul(gen_vec3(r, 0.75f, 1.2f), v3(grey * 1.1f, grey, grey * 0.8f));
}

static struct pbnds_vec3 mean_sky(const struct gen_sky *s)
{
    return pbnds_lerp(s->horizon, s->zenith, 0.6f);
}

void gen_default_sky(struct gen_sky *s)
{
    *s = (struct gen_sky){.zenith = {0.16f, 0.34f, 0.80f},
                          .horizon = {0.80f, 0.90f, 1.00f},
                          .power = 0.45f,
                          .glow = {1.0f, 0.8f, 0.5f},
                          .glow_falloff = 6.0f,
                          .ground_albedo = {0.22f, 0.19f, 0.16f}};
    /* 4.5 times the sky's own irradiance, about pi times its mean radiance of 0.6 */
    const struct pbnds_vec3 color = {1.0f, 0.90f, 0.72f};
    s->lamps[0] = sun(v3(-0.50f, 0.62f, 0.60f), 2.0f * PBNDS_PI / 180.0f,
                      pbnds_scale(color, 4.5f * 0.6f * PBNDS_PI));
    s->lamp_count = 1;
}

/* Lower suns are redder and weaker, and so is the horizon about them. */
static void clear_sky(struct gen_sky *s, struct pbnds_rng *r)
{
    const float elevation = gen_uniform(r, -0.02f, 1.4f);
    const float azimuth = gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
    const float air = 1.0f / (fmaxf(sinf(elevation), 0.0f) + 0.08f);
    const float haze = gen_uniform(r, 0.02f, 0.1f);
    const struct pbnds_vec3 color = {expf(-0.3f * haze * air), expf(-0.9f * haze * air),
                                     expf(-2.2f * haze * air)};
    const float radius = gen_log_uniform(r, 0.01f, 0.08f);
    const float strength = gen_log_uniform(r, 1.0f, 8.0f);
    const float bright = gen_uniform(r, 0.3f, 1.0f);
    s->zenith = pbnds_scale(v3(0.16f, 0.34f, 0.80f), bright);
    s->horizon = pbnds_scale(pbnds_lerp(v3(0.8f, 0.9f, 1.0f), color, 0.6f), bright);
    s->power = gen_uniform(r, 0.3f, 0.7f);
    s->glow = pbnds_scale(color, gen_uniform(r, 0.3f, 2.0f));
    s->glow_falloff = gen_uniform(r, 2.0f, 12.0f);
    s->ground_albedo = earth(r, 0.05f, 0.4f);
    const struct pbnds_vec3 e =
        pbnds_scale(color, strength * PBNDS_PI * pbnds_luminance(mean_sky(s)));
    s->lamps[0] = sun(from_angles(azimuth, elevation), radius, e);
    s->lamp_count = 1;
    if (gen_chance(r, 0.4f)) {
        s->cloud_cover = gen_uniform(r, 0.2f, 0.8f);
        s->cloud_frequency = gen_log_uniform(r, 0.4f, 2.0f);
        s->cloud = pbnds_scale(pbnds_lerp(pbnds_splat(1.0f), color, 0.5f),
                               gen_uniform(r, 0.8f, 2.0f));
    }
}

/* CIE overcast: three times brighter above than at the horizon; clouds in patches. */
static void overcast(struct gen_sky *s, struct pbnds_rng *r)
{
    const struct pbnds_vec3 tint = black_body(gen_uniform(r, 5500.0f, 9000.0f));
    s->zenith = tint;
    s->horizon = pbnds_scale(tint, gen_uniform(r, 0.2f, 0.7f));
    s->power = gen_uniform(r, 0.6f, 1.2f);
    s->ground_albedo = earth(r, 0.05f, 0.7f);
    if (gen_chance(r, 0.6f)) {
        s->cloud_cover = gen_uniform(r, 0.3f, 0.7f);
        s->cloud_frequency = gen_log_uniform(r, 0.3f, 1.5f);
        s->cloud = pbnds_scale(tint, gen_uniform(r, 0.3f, 1.8f));
    }
}

/* Lamps on black. */
static void studio(struct gen_sky *s, struct pbnds_rng *r)
{
    const int count = gen_between(r, 1, 6);
    const float surround =
        gen_chance(r, 0.5f) ? 0.0f : gen_log_uniform(r, 0.003f, 0.1f);
    s->zenith = s->horizon = pbnds_scale(lamp_color(r), surround);
    s->power = 1.0f;
    if (gen_chance(r, 0.4f))
        s->ground_albedo = pbnds_splat(gen_uniform(r, 0.02f, 0.5f));
    for (int i = 0; i < count; ++i) {
        const struct pbnds_vec3 d =
            any_direction(r, gen_chance(r, 0.8f) ? -0.1f : -0.9f);
        const struct pbnds_vec3 color = lamp_color(r);
        struct gen_lamp l = softbox(r, d, color);
        const float across = l.half_y > 0.0f ? l.half_y : l.half_x;
        /* similar energy whatever the size */
        const float energy = gen_log_uniform(r, 0.3f, 3.0f);
        l.radiance = pbnds_scale(color, energy / (4.0f * l.half_x * across));
        s->lamps[s->lamp_count++] = l;
    }
}

static void room(struct gen_sky *s, struct pbnds_rng *r)
{
    s->room = true;
    s->half = gen_vec3(r, 1.5f, 4.0f);
    s->half.y = gen_uniform(r, 1.2f, 1.8f);
    s->eye = pbnds_mul(gen_vec3(r, -0.6f, 0.6f), s->half);
    const struct pbnds_vec3 paint = gen_vec3(r, 0.3f, 0.9f);
    for (int i = 0; i < 6; ++i) {
        const struct pbnds_vec3 own = gen_vec3(r, 0.1f, 0.9f);
        s->wall[i] = gen_chance(r, 0.3f) ? own : paint;
    }
    s->wall[2] = pbnds_splat(gen_uniform(r, 0.6f, 0.9f));
    const struct pbnds_vec3 color = lamp_color(r);
    s->lamp_at = pbnds_mul(gen_vec3(r, -0.7f, 0.7f), s->half);
    s->lamp_at.y = s->half.y * gen_uniform(r, 0.2f, 0.95f);
    const struct pbnds_vec3 to = pbnds_sub(s->lamp_at, s->eye);
    const float size = gen_log_uniform(r, 0.05f, 0.4f);
    const float distance = pbnds_length(to), radius = fminf(size / distance, 0.6f);
    s->lamp_power = pbnds_scale(color, gen_log_uniform(r, 2.0f, 20.0f));
    s->ambient = pbnds_scale(s->lamp_power, gen_uniform(r, 0.005f, 0.03f));
    /* seen: power per solid angle over its area */
    s->lamps[0] =
        sun(to, radius, pbnds_scale(s->lamp_power, 1.0f / (distance * distance)));
    s->lamps[0].softness = gen_uniform(r, 0.02f, 0.5f);
    s->lamp_count = 1;
    const int windows = gen_chance(r, 0.5f) ? gen_between(r, 1, 3) : 0;
    for (int i = 0; i < windows; ++i) {
        const float azimuth = gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
        const struct pbnds_vec3 day = black_body(gen_uniform(r, 5000.0f, 10000.0f));
        struct gen_lamp l = {.direction =
                                 from_angles(azimuth, gen_uniform(r, -0.1f, 0.4f))};
        l.side = pbnds_normalize(v3(-l.direction.z, 0.0f, l.direction.x));
        l.up = pbnds_cross(l.direction, l.side);
        l.half_x = gen_uniform(r, 0.1f, 0.5f);
        l.half_y = gen_uniform(r, 0.15f, 0.5f);
        l.softness = 0.03f;
        l.radiance = pbnds_scale(day, gen_log_uniform(r, 0.5f, 10.0f));
        s->lamps[s->lamp_count++] = l;
    }
}

/* Little light, from few small sources. */
static void night(struct gen_sky *s, struct pbnds_rng *r)
{
    const float dim = gen_log_uniform(r, 1e-4f, 3e-2f);
    s->zenith = pbnds_scale(v3(0.3f, 0.5f, 1.0f), dim);
    const float haze = dim * gen_uniform(r, 0.5f, 5.0f);
    s->horizon = pbnds_scale(lamp_color(r), haze);
    s->power = 0.5f;
    s->ground_albedo = pbnds_splat(gen_uniform(r, 0.03f, 0.2f));
    const int count = gen_below(r, 12);
    for (int i = 0; i < count; ++i) {
        const struct pbnds_vec3 d = any_direction(r, -0.05f);
        const struct pbnds_vec3 low = pbnds_normalize(v3(d.x, 0.35f * d.y, d.z));
        const float radius = gen_log_uniform(r, 0.012f, 0.06f);
        const float energy = gen_log_uniform(r, 0.002f, 0.3f);
        s->lamps[s->lamp_count++] =
            sun(low, radius, pbnds_scale(lamp_color(r), energy));
    }
}

/* Broad coloured light from several sides, above and below. */
static void mixed(struct gen_sky *s, struct pbnds_rng *r)
{
    const float above = gen_uniform(r, 0.02f, 0.6f),
                beside = gen_uniform(r, 0.02f, 0.6f);
    s->zenith = pbnds_scale(lamp_color(r), above);
    s->horizon = pbnds_scale(lamp_color(r), beside);
    s->power = gen_uniform(r, 0.3f, 1.5f);
    s->ground_albedo = gen_vec3(r, 0.05f, 0.6f);
    const int count = gen_between(r, 3, 12);
    for (int i = 0; i < count; ++i) {
        const struct pbnds_vec3 d = any_direction(r, -1.0f);
        const struct pbnds_vec3 color = lamp_color(r);
        struct gen_lamp l =
            softbox(r, d, pbnds_scale(color, gen_log_uniform(r, 0.1f, 8.0f)));
        l.softness = gen_uniform(r, 0.3f, 1.0f);
        s->lamps[s->lamp_count++] = l;
    }
}

void gen_random_sky(struct gen_sky *s, uint64_t seed, uint64_t index)
{
    static const float weights[6] = {3.0f, 1.0f, 2.5f, 2.0f, 0.7f, 1.5f};
    static void (*const kinds[6])(struct gen_sky *, struct pbnds_rng *) = {
        clear_sky, overcast, studio, room, night, mixed};
    struct pbnds_rng r = pbnds_rng_make(seed, index, 0x736b79u);
    *s = (struct gen_sky){.power = 1.0f};
    s->seed = (uint32_t)gen_below(&r, 1 << 20);
    s->ground_relief = gen_uniform(&r, 0.0f, 0.8f);
    kinds[gen_pick(&r, weights, 6)](s, &r);
}
