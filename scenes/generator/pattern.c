#include "scenes/generator/pattern.h"

#include "scenes/generator/noise.h"

struct gen_pattern gen_random_pattern(struct pbnds_rng *r)
{
    static const float weights[GEN_PATTERN_COUNT] = {
        [GEN_CLOUDS] = 1.6f,   [GEN_MARBLE] = 1.2f,   [GEN_CHECKER] = 1.0f,
        [GEN_STRIPES] = 1.2f,  [GEN_SPOTS] = 1.0f,    [GEN_CRACKS] = 0.9f,
        [GEN_WOOD] = 1.6f,     [GEN_BRICKS] = 1.0f,   [GEN_SCRATCHES] = 1.1f,
        [GEN_WEAVE] = 0.8f,    [GEN_STONES] = 0.9f,   [GEN_TILES] = 1.3f,
        [GEN_PLANKS] = 1.2f,   [GEN_HEXAGONS] = 0.7f, [GEN_CHEVRON] = 0.7f,
        [GEN_PLAID] = 0.7f,    [GEN_DOTS] = 0.8f,     [GEN_RINGS] = 0.5f,
        [GEN_TEXT] = 0.8f,     [GEN_BLOCKS] = 0.5f,   [GEN_GRADIENT] = 0.9f,
        [GEN_BLOTCHES] = 1.3f, [GEN_BRUSHED] = 0.8f,  [GEN_TERRAZZO] = 0.7f,
        [GEN_SPECKLE] = 0.7f};
    struct gen_pattern p;
    p.kind = (enum gen_pattern_kind)gen_pick(r, weights, GEN_PATTERN_COUNT);
    p.frequency = gen_between(r, 2, 9);
    p.slant = gen_between(r, -4, 4);
    p.softness = gen_log_uniform(r, 0.02f, 0.5f);
    p.warp = gen_chance(r, 0.65f) ? 0.0f : gen_uniform(r, 0.0f, 0.12f);
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

/* A number in [0, 1) for a cell of a lattice that wraps after n cells. */
static float cell_id(int x, int y, int nx, int ny, uint32_t seed)
{
    const uint32_t i = (uint32_t)((x % nx + nx) % nx),
                   j = (uint32_t)((y % ny + ny) % ny);
    return (float)(gen_hash(i, j, 7, seed) >> 8) * 0x1p-24f;
}

static struct gen_texel texel(float value, float id)
{
    const struct gen_texel t = {value, id};
    return t;
}

/* ---- built of pieces: the id tells them apart ---- */

static struct gen_texel bricks(const struct gen_pattern *p, float u, float v)
{
    const int rows = 2 * p->frequency;
    const float y = v * (float)rows, shift = (int)floorf(y) % 2 ? 0.5f : 0.0f;
    const float x = u * (float)p->frequency + shift;
    const float gap = fminf(to_line(y), 2.0f * to_line(x));
    const float id =
        cell_id((int)floorf(x), (int)floorf(y), p->frequency, rows, p->seed);
    return texel(1.0f - smooth(0.04f, 0.06f + 0.2f * p->softness, gap), id);
}

static struct gen_texel tiles(const struct gen_pattern *p, float u, float v)
{
    const int n = p->frequency;
    const float x = u * (float)n, y = v * (float)n;
    const float gap = fminf(to_line(x), to_line(y)), joint = 0.015f + 0.05f * p->level;
    const float id = cell_id((int)floorf(x), (int)floorf(y), n, n, p->seed);
    return texel(1.0f - smooth(joint, joint + 0.02f + 0.1f * p->softness, gap), id);
}

static struct gen_texel hexagons(const struct gen_pattern *p, float u, float v)
{
    /* centres on two interleaved lattices; the second coordinate squeezed so that a
     * whole number of rows fits the tile */
    const int n = p->frequency, rows = (int)(1.1547f * (float)n + 0.5f);
    const float x = u * (float)n, y = v * (float)rows, squeeze = 0.8660254f;
    const float ax = floorf(x) + 0.5f, ay = 2.0f * floorf(0.5f * y) + 0.5f;
    const float bx = floorf(x + 0.5f), by = 2.0f * floorf(0.5f * (y - 1.0f)) + 1.5f;
    const float da =
        fmaxf(fabsf(x - ax), 0.5f * fabsf(x - ax) + squeeze * squeeze * fabsf(y - ay));
    const float db =
        fmaxf(fabsf(x - bx), 0.5f * fabsf(x - bx) + squeeze * squeeze * fabsf(y - by));
    const bool first = da < db;
    const float edge = 0.5f - fminf(da, db);
    const int even = (rows + 1) / 2 * 2;
    const float id = cell_id((int)(first ? ax : bx + 0.25f), (int)(first ? ay : by), n,
                             even, p->seed + (first ? 0u : 1u));
    return texel(1.0f - smooth(0.02f, 0.05f + 0.1f * p->softness, edge), id);
}

static struct gen_texel planks(const struct gen_pattern *p, float u, float v)
{
    const int n = 2 + p->frequency;
    const float y = v * (float)n;
    const int row = (int)floorf(y);
    const float shift = cell_id(row, 0, n, 1, p->seed + 3);
    const float x = u * 2.0f + shift;
    const float id = cell_id((int)floorf(x), row, 2, n, p->seed);
    const float gap = fminf(to_line(y), 2.0f * (float)n * 0.25f * to_line(x));
    const struct pbnds_vec3 grain = {u * 4.0f, v * 16.0f * (float)n, 8.0f * id};
    const float fibre = 0.5f + 0.5f * gen_fbm(grain, 3, 0, p->seed);
    const float joint = 1.0f - smooth(0.015f, 0.04f, gap);
    return texel(fmaxf(0.55f * pbnds_clamp(fibre, 0.0f, 1.0f), joint), id);
}

static struct gen_texel stones(const struct gen_pattern *p, float u, float v)
{
    const struct gen_cell c = gen_cells(u, v, p->frequency, 1.0f, p->seed);
    return texel(0.75f * c.id + 0.25f * smooth(0.0f, 0.2f, c.f2 - c.f1), c.id);
}

static struct gen_texel terrazzo(const struct gen_pattern *p, float u, float v)
{
    const struct gen_cell c = gen_cells(u, v, 3 * p->frequency, 1.0f, p->seed);
    const bool chip = c.id > p->level && c.f2 - c.f1 > 0.12f;
    return texel(chip ? 1.0f : 0.0f, c.id);
}

/* ---- printed ---- */

/* Marks on lines: each cell of a line is empty (a space) or has two or three strokes. */
static struct gen_texel text(const struct gen_pattern *p, float u, float v)
{
    const int rows = 4 + 2 * p->frequency, columns = 2 * rows;
    const float y = v * (float)rows, x = u * (float)columns;
    const int row = (int)floorf(y), column = (int)floorf(x);
    const float a = x - floorf(x), b = y - floorf(y);
    const float id = cell_id(column, row, columns, rows, p->seed);
    const float margin = cell_id(row, 1, rows, 1, p->seed + 9);
    const bool blank = id < 0.17f || u > 0.75f + 0.5f * margin || margin < 0.12f ||
                       a < 0.12f || a > 0.88f || b < 0.2f || b > 0.85f;
    if (blank) return texel(0.0f, id);
    const uint32_t strokes = gen_hash((uint32_t)column, (uint32_t)row, 3, p->seed);
    const float s = (a - 0.12f) / 0.76f, t = (b - 0.2f) / 0.65f, pen = 0.2f;
    const bool on = ((strokes & 3u) != 0 && s < pen) ||
                    ((strokes & 12u) == 4u && s > 1.0f - pen) ||
                    ((strokes & 16u) && t < pen) ||
                    ((strokes & 32u) && fabsf(t - 0.5f) < 0.5f * pen) ||
                    ((strokes & 64u) && t > 1.0f - pen);
    return texel(on ? 1.0f : 0.0f, id);
}

static struct gen_texel blocks(const struct gen_pattern *p, float u, float v)
{
    const int n = 4 * p->frequency;
    const float id =
        cell_id((int)floorf(u * (float)n), (int)floorf(v * (float)n), n, n, p->seed);
    return texel(id < p->level ? 0.0f : 1.0f, id);
}

static float plaid(const struct gen_pattern *p, float u, float v)
{
    const float n = (float)p->frequency, x = u * n, y = v * n;
    const float wide =
        smooth(0.2f, 0.22f, to_line(x)) + smooth(0.2f, 0.22f, to_line(y));
    const float thin =
        1.0f - smooth(0.03f, 0.05f, fminf(to_line(x + 0.3f), to_line(y + 0.3f)));
    const float weave = 0.08f * triangle(40.0f * (u + v));
    return pbnds_clamp(0.4f * wide + 0.5f * thin + weave, 0.0f, 1.0f);
}

static float weave(const struct gen_pattern *p, float u, float v)
{
    const float n = 2.0f * (float)p->frequency, x = u * n, y = v * n;
    const bool over = ((int)floorf(x) + (int)floorf(y)) % 2 != 0;
    const float a = x - floorf(x), b = y - floorf(y);
    const float thread = over ? sinf(PBNDS_PI * a) : sinf(PBNDS_PI * b);
    return over ? 0.5f * thread : 0.5f + 0.5f * thread;
}

/* ---- grown ---- */

static float wood(const struct gen_pattern *p, float u, float v)
{
    const float n = (float)p->frequency;
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

static float marble(const struct gen_pattern *p, float u, float v)
{
    const struct pbnds_vec3 at = {u * (float)p->frequency, v * (float)p->frequency,
                                  0.25f};
    const float bend = gen_fbm(at, 5, p->frequency, p->seed);
    const float x =
        u * (float)(p->frequency / 2 + 1) + v * (float)p->slant + 1.2f * bend;
    return powf(fabsf(sinf(PBNDS_PI * x)), 0.3f + 2.0f * p->softness);
}

static float scratches(const struct gen_pattern *p, float u, float v)
{
    const struct pbnds_vec3 a = {u * 48.0f, v * 3.0f, 0.1f},
                            b = {u * 3.0f, v * 48.0f, 0.6f};
    const float s = fmaxf(gen_noise(a, 48, p->seed), gen_noise(b, 48, p->seed + 3));
    return smooth(0.3f, 0.35f + 0.4f * p->softness, s);
}

static float clouds(const struct gen_pattern *p, float u, float v, float edge)
{
    const struct pbnds_vec3 at = {u * (float)p->frequency, v * (float)p->frequency,
                                  0.25f};
    const float s = 0.5f + 0.9f * gen_fbm(at, 5, p->frequency, p->seed);
    return smooth(p->level - edge, p->level + edge, s);
}

static void bend(const struct gen_pattern *p, float *u, float *v)
{
    const int lattice = 4;
    if (p->warp > 0.0f) {
        const struct pbnds_vec3 q = {*u * (float)lattice, *v * (float)lattice, 0.5f};
        const float du = gen_fbm(q, 3, lattice, p->seed + 31);
        const float dv = gen_fbm(q, 3, lattice, p->seed + 47);
        *u += p->warp * du;
        *v += p->warp * dv;
    }
    *u -= floorf(*u);
    *v -= floorf(*v);
}

struct gen_texel gen_pattern_at(const struct gen_pattern *p, float u, float v)
{
    const float n = (float)p->frequency, soft = p->softness, level = p->level;
    bend(p, &u, &v);
    switch (p->kind) {
    case GEN_BRICKS:
        return bricks(p, u, v);
    case GEN_TILES:
        return tiles(p, u, v);
    case GEN_HEXAGONS:
        return hexagons(p, u, v);
    case GEN_PLANKS:
        return planks(p, u, v);
    case GEN_STONES:
        return stones(p, u, v);
    case GEN_TERRAZZO:
        return terrazzo(p, u, v);
    case GEN_TEXT:
        return text(p, u, v);
    case GEN_BLOCKS:
        return blocks(p, u, v);
    case GEN_SPOTS: {
        const struct gen_cell c = gen_cells(u, v, p->frequency, 0.9f, p->seed);
        const float size = 0.2f + 0.25f * c.id;
        return texel(smooth(size, size + 0.05f + 0.3f * soft, c.f1), c.id);
    }
    case GEN_CRACKS: {
        const struct gen_cell c = gen_cells(u, v, p->frequency, 1.0f, p->seed);
        return texel(1.0f - smooth(0.02f, 0.05f + 0.3f * soft, c.f2 - c.f1), c.id);
    }
    case GEN_CHECKER: {
        const float s = (triangle(2.0f * n * u + 0.5f) - 0.5f) *
                        (triangle(2.0f * n * v + 0.5f) - 0.5f);
        return texel(smooth(-0.05f * soft - 1e-3f, 0.05f * soft + 1e-3f, s), 0.0f);
    }
    case GEN_STRIPES:
        return texel(smooth(level - 0.5f * soft, level + 0.5f * soft,
                            triangle(2.0f * (n * u + (float)p->slant * v))),
                     0.0f);
    case GEN_CHEVRON:
        return texel(smooth(level - 0.1f * soft - 0.01f, level + 0.1f * soft + 0.01f,
                            triangle(2.0f * (n * u + 0.5f * triangle(2.0f * n * v)))),
                     0.0f);
    case GEN_DOTS: {
        const float odd = (float)((int)floorf(v * 2.0f * n) % 2) * 0.5f;
        const float x = u * n + odd, y = v * 2.0f * n;
        const float a = x - floorf(x) - 0.5f, b = 0.5f * (y - floorf(y) - 0.5f);
        const float size = 0.08f + 0.18f * level;
        return texel(1.0f - smooth(size, size + 0.02f + 0.1f * soft, hypotf(a, b)),
                     0.0f);
    }
    case GEN_RINGS: {
        const float d = hypotf(u - 0.5f, v - 0.5f);
        return texel(
            smooth(level - 0.3f * soft, level + 0.3f * soft, triangle(4.0f * n * d)),
            0.0f);
    }
    case GEN_GRADIENT:
        return texel(
            0.5f - 0.5f * cosf(2.0f * PBNDS_PI *
                               ((p->slant & 1 ? u : 0.0f) +
                                (p->slant & 2 || p->slant == 0 ? v : 0.0f) + level)),
            0.0f);
    case GEN_BRUSHED: {
        const struct pbnds_vec3 fine = {u * 2.0f, v * 96.0f, 0.3f};
        return texel(
            pbnds_clamp(0.5f + 0.9f * gen_noise(fine, 96, p->seed), 0.0f, 1.0f), 0.0f);
    }
    case GEN_SPECKLE: {
        const uint32_t h =
            gen_hash((uint32_t)(u * 128.0f), (uint32_t)(v * 128.0f), 5, p->seed);
        const float x = (float)(h >> 8) * 0x1p-24f;
        return texel(x < 0.4f * level ? 1.0f : 0.0f, x);
    }
    case GEN_MARBLE:
        return texel(marble(p, u, v), 0.0f);
    case GEN_WOOD:
        return texel(wood(p, u, v), 0.0f);
    case GEN_PLAID:
        return texel(plaid(p, u, v), 0.0f);
    case GEN_WEAVE:
        return texel(weave(p, u, v), 0.0f);
    case GEN_SCRATCHES:
        return texel(scratches(p, u, v), 0.0f);
    case GEN_BLOTCHES:
        return texel(clouds(p, u, v, 0.02f + 0.04f * soft), 0.0f);
    default:
        return texel(clouds(p, u, v, 0.5f * soft), 0.0f);
    }
}

float gen_pattern_value(const struct gen_pattern *p, float u, float v)
{
    return gen_pattern_at(p, u, v).value;
}
