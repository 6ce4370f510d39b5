#include "scenes/generator/pattern.h"

#include "scenes/generator/noise.h"

#define TURN (2.0f * PBNDS_PI)

struct gen_pattern gen_random_pattern(struct pbnds_rng *r)
{
    static const float weights[GEN_PATTERN_COUNT] = {3.0f, 1.5f, 1.2f, 1.2f, 1.2f, 1.0f,
                                                     1.5f, 1.2f, 1.2f, 0.8f, 1.0f};
    struct gen_pattern p;
    p.kind = (enum gen_pattern_kind)gen_pick(r, weights, GEN_PATTERN_COUNT);
    p.frequency = gen_between(r, 2, 9);
    p.slant = gen_between(r, -4, 4);
    p.softness = gen_log_uniform(r, 0.02f, 0.5f);
    p.warp = gen_chance(r, 0.5f) ? 0.0f : gen_uniform(r, 0.0f, 0.12f);
    p.level = gen_uniform(r, 0.35f, 0.65f);
    p.seed = (uint32_t)(pbnds_rng_u64(r) >> 40);
    return p;
}

static float smooth(float lo, float hi, float x)
{
    const float t = pbnds_clamp((x - lo) / (hi - lo), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

/* Distance from x to the nearest whole number, 0 to 0.5. */
static float to_line(float x)
{
    return fabsf(x - floorf(x + 0.5f));
}

static float triangle(float x)
{
    return 2.0f * to_line(0.5f * x);
}

static float bricks(const struct gen_pattern *p, float u, float v)
{
    const int rows = 2 * p->frequency;
    const float y = v * (float)rows, shift = (int)floorf(y) % 2 ? 0.5f : 0.0f;
    const float x = u * (float)p->frequency + shift;
    const float gap = fminf(to_line(y), 2.0f * to_line(x));
    return 1.0f - smooth(0.04f, 0.06f + 0.2f * p->softness, gap);
}

static float weave(const struct gen_pattern *p, float u, float v)
{
    const float n = 2.0f * (float)p->frequency, x = u * n, y = v * n;
    const bool over = ((int)floorf(x) + (int)floorf(y)) % 2 != 0;
    const float a = x - floorf(x), b = y - floorf(y);
    const float thread = over ? sinf(PBNDS_PI * a) : sinf(PBNDS_PI * b);
    return over ? 0.5f * thread : 0.5f + 0.5f * thread;
}

float gen_pattern_value(const struct gen_pattern *p, float u, float v)
{
    const float n = (float)p->frequency;
    const int lattice = 4;
    if (p->warp > 0.0f) {
        const struct pbnds_vec3 q = {u * (float)lattice, v * (float)lattice, 0.5f};
        const float du = gen_fbm(q, 3, lattice, p->seed + 31);
        const float dv = gen_fbm(q, 3, lattice, p->seed + 47);
        u += p->warp * du;
        v += p->warp * dv;
    }
    u -= floorf(u);
    v -= floorf(v);
    const float soft = p->softness, level = p->level;
    const struct pbnds_vec3 at = {u * n, v * n, 0.25f};
    switch (p->kind) {
    case GEN_MARBLE: {
        const float bend = gen_fbm(at, 5, p->frequency, p->seed);
        const float x =
            u * (float)(p->frequency / 2 + 1) + v * (float)p->slant + 1.2f * bend;
        return powf(fabsf(sinf(PBNDS_PI * x)), 0.3f + 2.0f * soft);
    }
    case GEN_CHECKER: {
        const float s = (triangle(2.0f * floorf(n) * u + 0.5f) - 0.5f) *
                        (triangle(2.0f * floorf(n) * v + 0.5f) - 0.5f);
        return smooth(-0.05f * soft - 1e-3f, 0.05f * soft + 1e-3f, s);
    }
    case GEN_STRIPES:
        return smooth(level - 0.5f * soft, level + 0.5f * soft,
                      triangle(2.0f * (n * u + (float)p->slant * v)));
    case GEN_SPOTS: {
        const struct gen_cell c = gen_cells(u, v, p->frequency, 0.9f, p->seed);
        const float size = 0.2f + 0.25f * c.id;
        return smooth(size, size + 0.05f + 0.3f * soft, c.f1);
    }
    case GEN_CRACKS: {
        const struct gen_cell c = gen_cells(u, v, p->frequency, 1.0f, p->seed);
        return 1.0f - smooth(0.02f, 0.05f + 0.3f * soft, c.f2 - c.f1);
    }
    case GEN_STONES: {
        const struct gen_cell c = gen_cells(u, v, p->frequency, 1.0f, p->seed);
        return 0.75f * c.id + 0.25f * smooth(0.0f, 0.2f, c.f2 - c.f1);
    }
    case GEN_WOOD: {
        const struct pbnds_vec3 grain = {u * n, v * 2.0f, 0.5f};
        const float knots =
            gen_fbm(pbnds_vec3_make(u * 2.0f, v * 2.0f, 0.7f), 2, 2, p->seed);
        const float rings = to_line(u * n + 2.5f * knots) * 2.0f;
        const float fibre =
            gen_noise(pbnds_vec3_make(u * 64.0f, v * 2.0f, 0.3f), 64, p->seed);
        return pbnds_clamp(powf(rings, 0.7f) * 0.75f + 0.2f * fibre +
                               0.15f * gen_noise(grain, p->frequency, p->seed + 5),
                           0.0f, 1.0f);
    }
    case GEN_BRICKS:
        return bricks(p, u, v);
    case GEN_SCRATCHES: {
        const struct pbnds_vec3 a = {u * 48.0f, v * 3.0f, 0.1f},
                                b = {u * 3.0f, v * 48.0f, 0.6f};
        const float s = fmaxf(gen_noise(a, 48, p->seed), gen_noise(b, 48, p->seed + 3));
        return smooth(0.3f, 0.35f + 0.4f * soft, s);
    }
    case GEN_WEAVE:
        return weave(p, u, v);
    default: {
        const float s = 0.5f + 0.9f * gen_fbm(at, 5, p->frequency, p->seed);
        return smooth(level - 0.5f * soft, level + 0.5f * soft, s);
    }
    }
}
