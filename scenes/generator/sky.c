#include "scenes/generator/sky.h"

#include "scenes/generator/noise.h"

#define TURN (2.0f * PBNDS_PI)

static struct pbnds_vec3 direction_at(float u, float v)
{
    const float phi = (u - 0.5f) * TURN, theta = v * PBNDS_PI;
    return pbnds_vec3_make(sinf(theta) * cosf(phi), cosf(theta),
                           sinf(theta) * sinf(phi));
}

static float smooth(float lo, float hi, float x)
{
    const float t = pbnds_clamp((x - lo) / (hi - lo), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

static float angle_between(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return atan2f(pbnds_length(pbnds_cross(a, b)), pbnds_dot(a, b));
}

/* 1 inside the lamp, 0 outside, smooth between. */
static float lamp_cover(const struct gen_lamp *l, struct pbnds_vec3 w)
{
    if (l->half_y <= 0.0f) {
        const float a = angle_between(w, l->direction) / l->half_x;
        return 1.0f - smooth(1.0f - l->softness, 1.0f + 1e-3f, a);
    }
    const float ahead = pbnds_dot(w, l->direction);
    if (ahead <= 0.05f) return 0.0f;
    const float x = fabsf(atanf(pbnds_dot(w, l->side) / ahead)) / l->half_x;
    const float y = fabsf(atanf(pbnds_dot(w, l->up) / ahead)) / l->half_y;
    return (1.0f - smooth(1.0f - l->softness, 1.0f + 1e-3f, x)) *
           (1.0f - smooth(1.0f - l->softness, 1.0f + 1e-3f, y));
}

static struct pbnds_vec3 sky_above(const struct gen_sky *s, struct pbnds_vec3 w)
{
    struct pbnds_vec3 c =
        pbnds_lerp(s->horizon, s->zenith, powf(fmaxf(w.y, 0.0f), s->power));
    if (s->lamp_count > 0 && s->glow_falloff > 0.0f) {
        const float a = angle_between(w, s->lamps[0].direction);
        c = pbnds_mad(c, s->glow, expf(-s->glow_falloff * a));
    }
    if (s->cloud_cover > 0.0f && w.y > 0.0f) {
        /* the plane of the clouds, bent down at the horizon so that it stays finite */
        const float reach = s->cloud_frequency / (w.y + 0.15f);
        const struct pbnds_vec3 p = {w.x * reach, w.z * reach, 0.5f};
        const float n = 0.5f + 0.8f * gen_fbm(p, 5, 0, s->seed);
        const float cover = smooth(1.0f - s->cloud_cover, 1.35f - s->cloud_cover, n);
        const float shade = 0.55f + 0.45f * (1.0f - cover * n);
        c = pbnds_lerp(c, pbnds_scale(s->cloud, shade),
                       cover * smooth(0.0f, 0.12f, w.y));
    }
    return c;
}

/* First wall along w, lit by the lamp as a point and by what bounces about. */
static struct pbnds_vec3 room_wall(const struct gen_sky *s, struct pbnds_vec3 w)
{
    const float d[3] = {w.x, w.y, w.z};
    const float e[3] = {s->eye.x, s->eye.y, s->eye.z};
    const float h[3] = {s->half.x, s->half.y, s->half.z};
    float nearest = 1e9f;
    int axis = 0;
    for (int i = 0; i < 3; ++i) {
        if (fabsf(d[i]) < 1e-6f) continue;
        const float t = (copysignf(h[i], d[i]) - e[i]) / d[i];
        if (t < nearest) {
            nearest = t;
            axis = i;
        }
    }
    const struct pbnds_vec3 hit = pbnds_mad(s->eye, w, nearest);
    const struct pbnds_vec3 to_lamp = pbnds_sub(s->lamp_at, hit);
    const float along = axis == 0 ? to_lamp.x : axis == 1 ? to_lamp.y : to_lamp.z;
    const float r2 = pbnds_dot(to_lamp, to_lamp) + 0.05f;
    const float cosine = fmaxf(0.0f, -copysignf(1.0f, d[axis]) * along) / sqrtf(r2);
    const struct pbnds_vec3 light =
        pbnds_mad(s->ambient, s->lamp_power, cosine / (r2 * PBNDS_PI));
    return pbnds_mul(s->wall[2 * axis + (d[axis] < 0.0f)], light);
}

/* The plain below the eye, fading to its mean before it aliases at the horizon. */
static struct pbnds_vec3 ground_below(const struct gen_sky *s, struct pbnds_vec3 w)
{
    if (s->ground_relief <= 0.0f) return s->ground;
    const float reach = 2.0f / (0.08f - w.y);
    const struct pbnds_vec3 p = {w.x * reach, w.z * reach, 0.5f};
    const float n = gen_fbm(p, 4, 0, s->seed + 77) * smooth(0.0f, 0.15f, -w.y);
    return pbnds_scale(s->ground, fmaxf(0.1f, 1.0f + s->ground_relief * n));
}

static struct pbnds_vec3 radiance(const struct gen_sky *s, struct pbnds_vec3 w)
{
    struct pbnds_vec3 c = s->room      ? room_wall(s, w)
                          : w.y < 0.0f ? ground_below(s, w)
                                       : sky_above(s, w);
    for (int i = 0; i < s->lamp_count; ++i) {
        const float cover = lamp_cover(&s->lamps[i], w);
        if (cover > 0.0f) c = pbnds_lerp(c, s->lamps[i].radiance, cover);
    }
    return c;
}

static void render_rows(const struct gen_sky *sky, int width, int height, int rows,
                        float *rgb)
{
    enum { SUB = 4 };
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < width; ++x) {
            struct pbnds_vec3 sum = pbnds_splat(0.0f);
            for (int k = 0; k < SUB * SUB; ++k) {
                const float u =
                    ((float)x + ((float)(k % SUB) + 0.5f) / SUB) / (float)width;
                const float v =
                    ((float)y + ((float)(k / SUB) + 0.5f) / SUB) / (float)height;
                sum = pbnds_add(sum, radiance(sky, direction_at(u, v)));
            }
            float *out = rgb + 3 * ((size_t)y * (size_t)width + (size_t)x);
            out[0] = sum.x / (SUB * SUB);
            out[1] = sum.y / (SUB * SUB);
            out[2] = sum.z / (SUB * SUB);
        }
    }
}

struct pbnds_vec3 gen_sky_irradiance(const float *rgb, int width, int height)
{
    struct pbnds_vec3 sum = pbnds_splat(0.0f);
    for (int y = 0; y < height / 2; ++y) {
        const float t0 = PBNDS_PI * (float)y / (float)height;
        const float t1 = PBNDS_PI * (float)(y + 1) / (float)height;
        /* integral of cos sin over the row, times the width of a texel */
        const float weight =
            0.5f * (sinf(t1) * sinf(t1) - sinf(t0) * sinf(t0)) * TURN / (float)width;
        for (int x = 0; x < width; ++x) {
            const float *p = rgb + 3 * ((size_t)y * (size_t)width + (size_t)x);
            sum = pbnds_mad(sum, pbnds_vec3_make(p[0], p[1], p[2]), weight);
        }
    }
    return sum;
}

void gen_sky_render(struct gen_sky *sky, int width, int height, float *rgb)
{
    sky->ground = pbnds_splat(0.0f);
    if (!sky->room) { /* the upper half first: it lights the ground */
        render_rows(sky, width, height, height / 2, rgb);
        const struct pbnds_vec3 e = gen_sky_irradiance(rgb, width, height);
        sky->ground = pbnds_scale(pbnds_mul(sky->ground_albedo, e), 1.0f / PBNDS_PI);
    }
    render_rows(sky, width, height, height, rgb);
}
