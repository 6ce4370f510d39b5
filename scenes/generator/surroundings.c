#include "scenes/generator/surroundings.h"

#include "scenes/generator/assemble.h"
#include "scenes/generator/noise.h"
#include "scenes/generator/shapes.h"

#define TURN (2.0f * PBNDS_PI)

static struct pbnds_vec3 v3(float x, float y, float z)
{
    return pbnds_vec3_make(x, y, z);
}

/* Opens an object that stays where it is made. */
static void begin(const struct gen_maker *k, const char *name)
{
    (void)gen_object_begin(k->world);
    gen_object_name(k->world, name);
}

static void settle(const struct gen_maker *k)
{
    gen_object_place(k->world, k->world->object_count - 1, pbnds_splat(0.0f), GEN_REST,
                     1.0f);
}

/* ---- terrain ---- */

float gen_ground_height(const struct gen_ground *g, float x, float z)
{
    if (!g->rough) return 0.0f;
    const struct pbnds_vec3 p = {g->frequency * x, 0.37f, g->frequency * z};
    const float n = gen_fbm(p, 4, 0, g->seed);
    switch (g->terrain) {
    case GEN_RIDGES:
        return g->height * (0.6f - 1.6f * fabsf(n));
    case GEN_DUNES: {
        const float along =
            p.x + 0.35f * p.z + 1.3f * gen_noise(pbnds_scale(p, 0.4f), 0, g->seed + 3);
        const float t = along - floorf(along); /* long windward side, steep lee side */
        return g->height * (t < 0.7f ? t / 0.7f : (1.0f - t) / 0.3f) * 0.7f;
    }
    case GEN_TERRACES: {
        const float level = 4.0f * (n + 0.5f), step = floorf(level), t = level - step;
        return g->height * (step + t * t * t * t * t * t) * 0.3f;
    }
    case GEN_RIPPLES:
        return 0.25f * g->height * sinf(TURN * (1.5f * p.x + 0.8f * n));
    case GEN_COBBLES: {
        const float size = 0.25f * g->frequency / (2.0f * g->half);
        const int cells = (int)(2.0f * g->half * 8.0f * fmaxf(size, 0.3f)) + 4;
        const struct gen_cell c = gen_cells(
            0.5f + 0.5f * x / g->half, 0.5f + 0.5f * z / g->half, cells, 0.8f, g->seed);
        return 0.6f * g->height * sqrtf(fmaxf(0.0f, 0.6f - c.f1 * c.f1)) /
               (float)cells * 4.0f;
    }
    default:
        return g->height * 0.9f * n;
    }
}

static struct pbnds_vec3 terrain_point(const void *context, float u, float v)
{
    const struct gen_ground *g = context;
    const float x = g->half * (2.0f * u - 1.0f), z = g->half * (1.0f - 2.0f * v);
    return v3(x, gen_ground_height(g, x, z), z);
}

struct gen_ground gen_random_terrain(const struct gen_maker *k, float half)
{
    struct gen_mesh m = {.vertex_count = 0};
    struct gen_ground g = {.half = half, .rough = true};
    g.terrain = (enum gen_terrain)gen_below(k->rng, 6);
    g.frequency = gen_log_uniform(k->rng, 0.6f, 3.0f) / half;
    g.height = half * gen_log_uniform(k->rng, 0.06f, 0.45f);
    g.seed = (uint32_t)gen_below(k->rng, 1 << 20);
    const int n = gen_segments(k, 200);
    const struct gen_grid grid = {n, n, false, false, terrain_point, &g};
    begin(k, "terrain");
    gen_mesh_grid(&m, &grid);
    gen_finish(k, &m, g.terrain == GEN_TERRACES ? 50.0f : 180.0f,
               gen_make_material(k, gen_chance(k->rng, 0.5f) ? GEN_BARK : GEN_GROUND));
    settle(k);
    return g;
}

/* ---- floors ---- */

struct backdrop {
    float half, radius, height;
};

/* Floor towards -z, a quarter circle, wall upwards. */
static struct pbnds_vec3 backdrop_point(const void *context, float u, float v)
{
    const struct backdrop *b = context;
    const float floor = 2.0f * b->half - b->radius, arc = 0.5f * PBNDS_PI * b->radius;
    const float s = v * (floor + arc + b->height), x = b->half * (2.0f * u - 1.0f);
    if (s < floor) return v3(x, 0.0f, b->half - s);
    if (s < floor + arc) {
        const float a = (s - floor) / b->radius;
        return v3(x, b->radius * (1.0f - cosf(a)),
                  -b->half + b->radius * (1.0f - sinf(a)));
    }
    return v3(x, b->radius + s - floor - arc, -b->half);
}

static void flat_floor(const struct gen_maker *k, float half_x, float half_z)
{
    struct gen_mesh m = {.vertex_count = 0};
    gen_plane(&m, half_x, half_z, 1);
    const float longer = fmaxf(half_x, half_z);
    for (size_t i = 0; i < m.vertex_count; ++i) { /* square texels */
        m.uv[i].x *= half_x / longer;
        m.uv[i].y *= half_z / longer;
    }
    gen_finish(k, &m, 30.0f, gen_make_material(k, GEN_GROUND));
}

struct gen_ground gen_random_ground(const struct gen_maker *k, float half)
{
    static const float kinds[5] = {3.0f, 1.0f, 1.0f, 1.3f, 1.5f};
    struct gen_mesh m = {.vertex_count = 0};
    const struct gen_ground flat = {.half = half};
    const int kind = gen_pick(k->rng, kinds, 5);
    if (kind == 4) return gen_random_terrain(k, half);
    begin(k, "ground");
    if (kind == 0) flat_floor(k, half * gen_uniform(k->rng, 0.7f, 1.4f), half);
    if (kind == 1) { /* round table, plinth */
        const float high = half * gen_log_uniform(k->rng, 0.03f, 0.6f);
        const float foot = half * gen_uniform(k->rng, 0.7f, 1.2f);
        gen_put_frustum(&m, foot, half, high, v3(0.0f, -high, 0.0f), GEN_REST,
                        gen_chance(k->rng, 0.7f) ? 96 : gen_between(k->rng, 5, 8));
        gen_finish(k, &m, 40.0f, gen_make_material(k, GEN_GROUND));
    }
    if (kind == 2) { /* block */
        const float high = half * gen_log_uniform(k->rng, 0.05f, 0.7f);
        gen_put_block(&m, v3(half, high, half * gen_uniform(k->rng, 0.6f, 1.0f)),
                      0.03f * half, v3(0.0f, -high, 0.0f), GEN_REST);
        gen_finish(k, &m, 40.0f, gen_make_material(k, GEN_GROUND));
    }
    if (kind == 3) {
        const float radius = half * gen_uniform(k->rng, 0.2f, 0.7f);
        const struct backdrop b = {half, radius,
                                   half * gen_uniform(k->rng, 0.4f, 1.2f)};
        const struct gen_grid grid = {1, 48, false, false, backdrop_point, &b};
        gen_mesh_grid(&m, &grid);
        gen_finish(k, &m, 40.0f, gen_make_material(k, GEN_GROUND));
    }
    settle(k);
    return flat;
}

/* ---- walls ---- */

/* A wall 2 half wide and `high`, standing at the origin of a pose, with a rectangular hole
 * (x0..x1, y0..y1) or none (x0 = x1). */
struct wall {
    float half, high, thick, x0, x1, y0, y1;
};

static void put_wall(struct gen_mesh *m, const struct wall *w, struct pbnds_vec3 t,
                     struct pbnds_vec4 q)
{
    const bool whole = !(w->x1 > w->x0);
    const float pieces[4][4] = {{-w->half, whole ? w->half : w->x0, 0.0f, w->high},
                                {w->x1, w->half, 0.0f, w->high},
                                {w->x0, w->x1, 0.0f, w->y0},
                                {w->x0, w->x1, w->y1, w->high}};
    for (int i = 0; i < (whole ? 1 : 4); ++i) {
        const float *p = pieces[i];
        const struct pbnds_vec3 half = {0.5f * (p[1] - p[0]), 0.5f * (p[3] - p[2]),
                                        0.5f * w->thick};
        if (half.x < 1e-4f || half.y < 1e-4f) continue;
        const struct pbnds_vec3 at = {0.5f * (p[0] + p[1]), 0.5f * (p[2] + p[3]), 0.0f};
        gen_put_block(m, half, 0.0f, pbnds_add(t, gen_rotate(q, at)), q);
    }
}

/* Bars or panes' frames in the opening. */
static void put_bars(const struct gen_maker *k, struct gen_mesh *m,
                     const struct wall *w, struct pbnds_vec3 t, struct pbnds_vec4 q)
{
    const int upright = gen_between(k->rng, 0, 6), level = gen_between(k->rng, 0, 9);
    const float bar = 0.012f * w->high;
    for (int i = 1; i <= upright; ++i) {
        const float x = w->x0 + (w->x1 - w->x0) * (float)i / (float)(upright + 1);
        const struct pbnds_vec3 at = {x, 0.5f * (w->y0 + w->y1), 0.0f};
        gen_put_block(m, v3(bar, 0.5f * (w->y1 - w->y0), bar), 0.0f,
                      pbnds_add(t, gen_rotate(q, at)), q);
    }
    for (int i = 1; i <= level; ++i) {
        const float y = w->y0 + (w->y1 - w->y0) * (float)i / (float)(level + 1);
        const struct pbnds_vec3 at = {0.5f * (w->x0 + w->x1), y, 0.0f};
        gen_put_block(m, v3(0.5f * (w->x1 - w->x0), bar, bar), 0.0f,
                      pbnds_add(t, gen_rotate(q, at)), q);
    }
}

static void add_wall(const struct gen_maker *k, struct pbnds_vec3 t,
                     struct pbnds_vec4 q, float half, float high, int material)
{
    struct gen_mesh m = {.vertex_count = 0}, bars = {.vertex_count = 0};
    struct wall w = {.half = half, .high = high, .thick = 0.06f * half};
    const bool opening = gen_chance(k->rng, 0.55f), door = gen_chance(k->rng, 0.3f);
    const float middle = half * gen_uniform(k->rng, -0.4f, 0.4f);
    const float wide = half * gen_uniform(k->rng, 0.15f, 0.5f);
    if (opening) {
        w.x0 = middle - wide;
        w.x1 = middle + wide;
        w.y0 = door ? 0.0f : high * gen_uniform(k->rng, 0.25f, 0.5f);
        w.y1 = high * gen_uniform(k->rng, 0.65f, 0.9f);
    }
    begin(k, "wall");
    put_wall(&m, &w, t, q);
    gen_finish(k, &m, 30.0f, material);
    if (opening && !door && gen_chance(k->rng, 0.6f)) {
        put_bars(k, &bars, &w, t, q);
        gen_finish(k, &bars, 30.0f, gen_make_material(k, GEN_PLAIN));
    }
    settle(k);
}

struct gen_ground gen_random_room(const struct gen_maker *k, float half, int walls)
{
    const float quarter = 0.5f * PBNDS_PI,
                high = half * gen_uniform(k->rng, 0.7f, 1.3f);
    const struct gen_ground ground = {.half = half};
    begin(k, "ground");
    flat_floor(k, half, half);
    settle(k);
    const int paint = gen_make_material(k, GEN_GROUND);
    const bool other = gen_chance(k->rng, 0.4f), ceiling = gen_chance(k->rng, 0.4f);
    const int side = walls > 1 && other ? gen_make_material(k, GEN_GROUND) : paint;
    add_wall(k, v3(0.0f, 0.0f, -half), GEN_REST, half, high, paint);
    if (walls > 1)
        add_wall(k, v3(-half, 0.0f, 0.0f), gen_turn(GEN_Y, quarter), half, high, side);
    if (walls > 2)
        add_wall(k, v3(half, 0.0f, 0.0f), gen_turn(GEN_Y, -quarter), half, high, side);
    if (walls > 1 && ceiling) {
        struct gen_mesh m = {.vertex_count = 0};
        begin(k, "ceiling");
        gen_put_block(&m, v3(half, 0.02f * half, half), 0.0f,
                      v3(0.0f, high + 0.02f * half, 0.0f), GEN_REST);
        gen_finish(k, &m, 30.0f, paint);
        settle(k);
    }
    return ground;
}

/* ---- furniture that holds others ---- */

int gen_random_shelf(const struct gen_maker *k, float half, float depth, float *level)
{
    struct gen_mesh m = {.vertex_count = 0};
    const int boards = gen_between(k->rng, 2, 5), uprights = gen_between(k->rng, 2, 4);
    const float thick = 0.03f * half, step = 2.0f * half / (float)boards;
    const bool back = gen_chance(k->rng, 0.5f);
    begin(k, "shelf");
    for (int i = 0; i <= boards; ++i) {
        const float y = step * (float)i;
        gen_put_block(&m, v3(half, thick, depth), 0.2f * thick, v3(0.0f, y, 0.0f),
                      GEN_REST);
        if (i < boards) level[i] = y + thick;
    }
    for (int i = 0; i < uprights; ++i) {
        const float x = half * (2.0f * (float)i / (float)(uprights - 1) - 1.0f);
        gen_put_block(&m, v3(thick, half, depth), 0.2f * thick, v3(x, half, 0.0f),
                      GEN_REST);
    }
    if (back) {
        gen_put_block(&m, v3(half, half, 0.4f * thick), 0.0f, v3(0.0f, half, -depth),
                      GEN_REST);
    }
    gen_finish(k, &m, 35.0f, gen_make_material(k, GEN_ANY));
    settle(k);
    return boards;
}

void gen_gallows(const struct gen_maker *k, float half, float height)
{
    struct gen_mesh m = {.vertex_count = 0};
    const float bar = 0.02f * half * gen_uniform(k->rng, 0.6f, 2.0f);
    begin(k, "bar");
    gen_put_frustum(&m, bar, bar, half * 1.05f, v3(0.0f, height, 0.0f),
                    gen_turn(GEN_Z, 0.5f * PBNDS_PI), 20);
    for (int side = -1; side <= 1; side += 2) {
        gen_put_frustum(&m, 1.4f * bar, bar, 0.5f * height,
                        v3(half * (float)side, 0.5f * height, 0.0f), GEN_REST, 20);
    }
    gen_finish(k, &m, 40.0f, gen_make_material(k, GEN_ANY));
    settle(k);
}

void gen_thread(const struct gen_maker *k, struct pbnds_vec3 from, float to,
                int material)
{
    struct gen_mesh m = {.vertex_count = 0};
    const float half = 0.5f * (from.y - to);
    if (!(half > 0.0f)) return;
    begin(k, "thread");
    gen_put_frustum(&m, 0.006f, 0.006f, half, v3(from.x, to + half, from.z), GEN_REST,
                    6);
    gen_finish(k, &m, 60.0f, material);
    settle(k);
}
