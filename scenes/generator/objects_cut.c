/* Extruded outlines: gears, stars, letters, tiles; wheels, frames and pixel figures. */
#include "scenes/generator/assemble.h"
#include "scenes/generator/pattern.h"
#include "scenes/generator/shapes.h"

#define TURN (2.0f * PBNDS_PI)

/* Fills the outline by its radius at each angle. */
static void around(struct gen_plate *p, int count,
                   float (*radius)(const float *c, float a), const float *c)
{
    p->count = count;
    for (int i = 0; i < count; ++i) {
        const float a = TURN * (float)i / (float)count, r = radius(c, a);
        p->outline[i] = (struct pbnds_vec2){r * cosf(a), r * sinf(a)};
    }
}

/* c: petals, depth, base radius */
static float flower_radius(const float *c, float a)
{
    return c[2] * (1.0f + c[1] * cosf(c[0] * a));
}

/* c: four amplitudes and four phases of a Fourier series */
static float wobble_radius(const float *c, float a)
{
    float r = 1.0f;
    for (int i = 0; i < 4; ++i)
        r += c[i] * sinf((float)(i + 2) * a + c[4 + i]);
    return 0.34f * r;
}

/* Straight edges between `corners` points, each edge in `cuts` pieces. */
static void corners_to_outline(struct gen_plate *p, const struct pbnds_vec2 *corner,
                               int corners, int cuts)
{
    p->count = 0;
    for (int i = 0; i < corners; ++i) {
        const struct pbnds_vec2 a = corner[i], b = corner[(i + 1) % corners];
        for (int j = 0; j < cuts; ++j) {
            const float t = (float)j / (float)cuts;
            p->outline[p->count++] =
                (struct pbnds_vec2){a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t};
        }
    }
}

static void star(const struct gen_maker *k, struct gen_plate *p)
{
    struct pbnds_vec2 corner[24];
    const int points = gen_between(k->rng, 3, 12);
    const bool polygon = points < 9 && gen_chance(k->rng, 0.5f);
    const float inner =
        polygon ? cosf(PBNDS_PI / (float)points) : gen_uniform(k->rng, 0.3f, 0.75f);
    for (int i = 0; i < 2 * points; ++i) {
        const float a = PBNDS_PI * (float)i / (float)points;
        const float r = i % 2 ? 0.45f * inner : 0.45f;
        corner[i] = (struct pbnds_vec2){r * cosf(a), r * sinf(a)};
    }
    corners_to_outline(p, corner, 2 * points, 4);
}

static void gear(const struct gen_maker *k, struct gen_plate *p)
{
    struct pbnds_vec2 corner[4 * 28];
    const int teeth = gen_between(k->rng, 8, 28);
    const float deep = gen_uniform(k->rng, 0.1f, 0.25f);
    const float slope = gen_uniform(k->rng, 0.05f, 0.2f);
    for (int i = 0; i < teeth; ++i) {
        static const float level[4] = {0.0f, 1.0f, 1.0f, 0.0f};
        const float step[4] = {0.0f, slope, 0.5f, 0.5f + slope};
        for (int j = 0; j < 4; ++j) {
            const float a = TURN * ((float)i + step[j]) / (float)teeth;
            const float r = 0.45f * (1.0f - deep * (1.0f - level[j]));
            corner[4 * i + j] = (struct pbnds_vec2){r * cosf(a), r * sinf(a)};
        }
    }
    corners_to_outline(p, corner, 4 * teeth, 2);
}

/* Signs and letters of straight strokes, counter-clockwise, star-shaped about 0. */
static void sign(const struct gen_maker *k, struct gen_plate *p)
{
    static const struct {
        int count;
        float xy[12][2];
    } signs[] = {
        /* plus */
        {12,
         {{-1, -3},
          {1, -3},
          {1, -1},
          {3, -1},
          {3, 1},
          {1, 1},
          {1, 3},
          {-1, 3},
          {-1, 1},
          {-3, 1},
          {-3, -1},
          {-1, -1}}},
        /* T */
        {8,
         {{-0.7f, -4},
          {0.7f, -4},
          {0.7f, -0.5f},
          {3, -0.5f},
          {3, 1},
          {-3, 1},
          {-3, -0.5f},
          {-0.7f, -0.5f}}},
        /* L */
        {6, {{-1, -1}, {3, -1}, {3, 0.6f}, {0.6f, 0.6f}, {0.6f, 4}, {-1, 4}}},
        /* arrow */
        {7,
         {{-0.9f, -3},
          {0.9f, -3},
          {0.9f, 0},
          {2.6f, 0},
          {0, 3.2f},
          {-2.6f, 0},
          {-0.9f, 0}}},
        /* house */
        {5, {{-2, -2.4f}, {2, -2.4f}, {2, 0.8f}, {0, 2.8f}, {-2, 0.8f}}},
        /* diamond, V, Y */
        {4, {{0, -3}, {1.9f, 0}, {0, 3}, {-1.9f, 0}}},
        {6, {{0, -1.2f}, {2.6f, 3}, {1.2f, 3}, {0, 0.9f}, {-1.2f, 3}, {-2.6f, 3}}},
        {9,
         {{-0.7f, -3},
          {0.7f, -3},
          {0.7f, -0.2f},
          {2.6f, 3},
          {1.1f, 3},
          {0, 0.9f},
          {-1.1f, 3},
          {-2.6f, 3},
          {-0.7f, -0.2f}}},
    };
    struct pbnds_vec2 corner[12];
    const int which = gen_below(k->rng, (int)(sizeof signs / sizeof signs[0]));
    for (int i = 0; i < signs[which].count; ++i) {
        corner[i] = (struct pbnds_vec2){0.13f * signs[which].xy[i][0],
                                        0.13f * signs[which].xy[i][1]};
    }
    corners_to_outline(p, corner, signs[which].count, 6);
}

void gen_build_plate(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    struct gen_plate p = {.count = 0, .steps = 1};
    float c[8];
    const int kind = gen_below(k->rng, 5);
    c[0] = (float)gen_between(k->rng, 3, 12);
    c[1] = gen_uniform(k->rng, 0.08f, 0.35f);
    c[2] = 0.35f;
    if (kind == 0) star(k, &p);
    if (kind == 1) gear(k, &p);
    if (kind == 2) sign(k, &p);
    if (kind == 3) around(&p, 144, flower_radius, c);
    if (kind == 4) {
        for (int i = 0; i < 8; ++i) {
            c[i] = i < 4 ? gen_uniform(k->rng, -0.22f, 0.22f) / (float)(i + 1)
                         : gen_uniform(k->rng, 0.0f, TURN);
        }
        around(&p, 144, wobble_radius, c);
    }
    p.half = gen_log_uniform(k->rng, 0.015f, 0.45f);
    const float bevel = gen_log_uniform(k->rng, 0.004f, 0.05f);
    p.bevel = gen_chance(k->rng, 0.3f) ? 0.0f : fminf(bevel, 0.4f * p.half);
    const float hole = gen_uniform(k->rng, 0.15f, 0.8f);
    if (gen_chance(k->rng, 0.35f)) p.hole = hole;
    if (p.half > 0.12f && gen_chance(k->rng, 0.4f)) {
        p.twist = gen_uniform(k->rng, -1.5f, 1.5f);
        p.taper = gen_uniform(k->rng, -0.6f, 0.4f);
        p.steps = 16;
    }
    gen_plate(&m, &p);
    if (p.half > 0.12f) { /* a column rather than a sign */
        struct gen_mesh upright = {.vertex_count = 0};
        gen_put(&upright, &m, pbnds_splat(0.0f), gen_turn(GEN_X, -0.5f * PBNDS_PI));
        m = upright;
    }
    gen_finish(k, &m, 32.0f, gen_make_material(k, GEN_ANY));
}

void gen_build_wheel(const struct gen_maker *k)
{
    struct gen_mesh tyre = {.vertex_count = 0}, rim = {.vertex_count = 0};
    const int segments = gen_segments(k, 72), spokes = gen_between(k->rng, 3, 20);
    const float tube = gen_log_uniform(k->rng, 0.025f, 0.14f), radius = 0.48f - tube;
    const float hub = gen_uniform(k->rng, 0.04f, 0.12f);
    const float wire = spokes > 8 ? 0.008f : gen_uniform(k->rng, 0.012f, 0.04f);
    gen_torus(&tyre, radius, tube, segments);
    gen_torus(&rim, radius - 0.8f * tube, 0.35f * tube, segments);
    gen_put_frustum(&rim, hub, hub, 0.8f * tube + 0.02f, pbnds_splat(0.0f), GEN_REST,
                    40);
    const float half = 0.5f * (radius - tube), lean = spokes > 8 ? 0.5f : 0.0f;
    for (int i = 0; i < spokes; ++i) {
        const float a = TURN * (float)i / (float)spokes;
        const struct pbnds_vec3 d = {cosf(a), 0.0f, sinf(a)};
        const float lift = lean * (i % 2 ? tube : -tube) * 0.4f;
        struct pbnds_vec3 at = pbnds_scale(d, half);
        at.y = lift;
        gen_put_frustum(&rim, wire, wire, half, at, gen_aim(d), 10);
    }
    gen_finish(k, &tyre, 80.0f,
               gen_make_material(k, gen_chance(k->rng, 0.6f) ? GEN_CLOTH : GEN_ANY));
    gen_finish(k, &rim, 40.0f,
               gen_make_material(k, gen_chance(k->rng, 0.6f) ? GEN_METAL : GEN_ANY));
}

/* A mirrored pattern of cubes: glyphs, game figures, crossword blocks. */
void gen_build_pixels(const struct gen_maker *k)
{
    struct gen_mesh parts[3] = {
        {.vertex_count = 0}, {.vertex_count = 0}, {.vertex_count = 0}};
    const int columns = gen_between(k->rng, 3, 9), rows = gen_between(k->rng, 4, 9);
    const int layers = gen_chance(k->rng, 0.6f) ? 1 : gen_between(k->rng, 2, 4);
    const float size = 0.9f / (float)(rows > columns ? rows : columns);
    const float fill = gen_uniform(k->rng, 0.4f, 0.7f);
    const float gap =
        gen_chance(k->rng, 0.5f) ? 0.5f : gen_uniform(k->rng, 0.4f, 0.49f);
    const int colors = gen_between(k->rng, 1, 3);
    for (int z = 0; z < layers; ++z) {
        for (int y = 0; y < rows; ++y) {
            for (int x = 0; x < (columns + 1) / 2; ++x) {
                const bool on = gen_chance(k->rng, fill);
                const int color = gen_below(k->rng, colors);
                if (!on) continue;
                for (int side = 0; side < 2; ++side) {
                    const int c = side ? columns - 1 - x : x;
                    if (side && c == x) continue;
                    const struct pbnds_vec3 at = {
                        size * ((float)c - 0.5f * (float)(columns - 1)),
                        size * ((float)y - 0.5f * (float)(rows - 1)),
                        size * ((float)z - 0.5f * (float)(layers - 1))};
                    gen_put_block(&parts[color], pbnds_splat(gap * size),
                                  gap < 0.5f ? 0.06f * size : 0.0f, at, GEN_REST);
                }
            }
        }
    }
    for (int i = 0; i < colors; ++i)
        gen_finish(k, &parts[i], 30.0f, gen_make_material(k, GEN_ANY));
}

/* A picture, mirror or panel in a moulded frame. */
void gen_build_frame(const struct gen_maker *k)
{
    struct gen_mesh rim = {.vertex_count = 0}, panel = {.vertex_count = 0};
    struct gen_plate p = {.count = 0, .steps = 1};
    struct pbnds_vec2 corner[4];
    const bool oval = gen_chance(k->rng, 0.25f);
    const float wide = gen_uniform(k->rng, 0.25f, 0.45f);
    const float high = gen_uniform(k->rng, 0.25f, 0.45f);
    p.half = gen_uniform(k->rng, 0.015f, 0.05f);
    p.bevel = p.half * gen_uniform(k->rng, 0.1f, 0.9f);
    p.hole = gen_uniform(k->rng, 0.7f, 0.9f);
    if (oval) {
        p.count = 96;
        for (int i = 0; i < p.count; ++i) {
            const float a = TURN * (float)i / (float)p.count;
            p.outline[i] = (struct pbnds_vec2){wide * cosf(a), high * sinf(a)};
        }
    } else {
        for (int i = 0; i < 4; ++i) {
            corner[i].x = i == 0 || i == 3 ? -wide : wide;
            corner[i].y = i < 2 ? -high : high;
        }
        corners_to_outline(&p, corner, 4, 8);
    }
    gen_plate(&rim, &p);
    struct gen_plate inside = p;
    for (int i = 0; i < p.count; ++i) {
        inside.outline[i].x *= p.hole * 1.01f;
        inside.outline[i].y *= p.hole * 1.01f;
    }
    inside.half = 0.2f * p.half;
    inside.bevel = inside.hole = 0.0f;
    gen_plate(&panel, &inside);
    gen_finish(k, &rim, 35.0f, gen_make_material(k, GEN_ANY));
    const bool mirror = gen_chance(k->rng, 0.25f);
    if (mirror) {
        const struct gen_material glass = gen_material_plain(
            pbnds_splat(0.9f), 1.0f, gen_uniform(k->rng, 0.02f, 0.1f));
        gen_finish(k, &panel, 30.0f, gen_world_material(k->world, &glass));
        return;
    }
    gen_finish(k, &panel, 30.0f, gen_make_material(k, GEN_PRINT));
}

/* A panel whose relief fills the picture: carved, tiled, cobbled, cast. */
struct relief {
    int kind, n;
    float depth;
    uint32_t seed;
    struct gen_pattern pattern;
};

static struct pbnds_vec3 relief_point(const void *context, float u, float v)
{
    const struct relief *r = context;
    const struct pbnds_vec3 p = {u - 0.5f, v - 0.5f, 0.0f};
    float h = gen_pattern_value(&r->pattern, u, v);
    if (r->kind == 1) { /* domes or studs */
        const float x = u * (float)r->n, y = v * (float)r->n;
        const float a = x - floorf(x) - 0.5f, b = y - floorf(y) - 0.5f;
        h = sqrtf(fmaxf(0.0f, 0.2f - a * a - b * b)) * 2.0f;
    }
    if (r->kind == 2) { /* waves, crossed */
        h = 0.5f + 0.25f * (sinf(TURN * (float)r->n * p.x) +
                            sinf(TURN * (float)r->n * (0.4f * p.x + p.y)));
    }
    return pbnds_vec3_make(p.x, p.y, r->depth * h);
}

void gen_build_relief(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    struct relief r = {.kind = gen_below(k->rng, 5), .n = gen_between(k->rng, 3, 10)};
    r.depth = gen_log_uniform(k->rng, 0.02f, 0.12f);
    r.pattern = gen_random_pattern(k->rng);
    r.pattern.softness = fmaxf(r.pattern.softness, 0.2f);
    const int n = gen_segments(k, 180);
    const struct gen_grid grid = {n, n, false, false, relief_point, &r};
    gen_mesh_grid(&m, &grid);
    const int material = gen_make_material(k, GEN_GROUND);
    k->world->materials[material].double_sided = true;
    gen_finish(k, &m, 70.0f, material);
}
