/* Thin and swept things: wires, cages, chains, ropes, baskets, branching trees. */
#include "scenes/generator/assemble.h"
#include "scenes/generator/shapes.h"

#define TURN (2.0f * PBNDS_PI)

enum { MAX_KNOTS = 14, MAX_CURVE = 512 };

/* Pipe, ribbon or wire along a random curve, open or closed. */
static void one_wire(const struct gen_maker *k, struct gen_mesh *m, float thickness)
{
    struct pbnds_vec3 knot[MAX_KNOTS], points[MAX_CURVE];
    const int knots = gen_between(k->rng, 4, MAX_KNOTS);
    const bool closed = gen_chance(k->rng, 0.5f);
    const bool boxy = gen_chance(k->rng, 0.25f); /* turns square like pipes */
    for (int i = 0; i < knots; ++i) {
        knot[i] = gen_vec3(k->rng, -0.45f, 0.45f);
        if (!boxy || i == 0) continue;
        const int axis = gen_below(k->rng, 3); /* one coordinate changes a step */
        const struct pbnds_vec3 before = knot[i - 1], to = knot[i];
        knot[i] = before;
        if (axis == 0) knot[i].x = to.x;
        if (axis == 1) knot[i].y = to.y;
        if (axis == 2) knot[i].z = to.z;
    }
    const int steps = gen_segments(k, 22);
    struct gen_tube t = {.points = points,
                         .count = gen_curve(knot, knots, closed, steps, points),
                         .closed = closed,
                         .thickness = thickness,
                         .flat = 1.0f,
                         .sides = gen_segments(k, 14)};
    if (gen_chance(k->rng, 0.3f)) t.flat = gen_uniform(k->rng, 0.15f, 0.6f);
    gen_tube(m, &t);
}

void gen_build_wire(const struct gen_maker *k)
{
    struct gen_mesh parts[2] = {{.vertex_count = 0}, {.vertex_count = 0}};
    const float thickness = gen_log_uniform(k->rng, 0.006f, 0.07f);
    const int count = thickness > 0.03f ? 1 : gen_between(k->rng, 1, 4);
    for (int i = 0; i < count; ++i)
        one_wire(k, &parts[i % 2], thickness);
    for (int i = 0; i < 2; ++i)
        gen_finish(k, &parts[i], 60.0f, gen_make_material(k, GEN_ANY));
}

/* A surface of revolution drawn with rings and meridians only: cages, baskets, lamps. */
void gen_build_cage(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    enum { POINTS = 40 };
    struct pbnds_vec3 points[POINTS + 1];
    const int rings = gen_between(k->rng, 3, 9), ribs = gen_between(k->rng, 5, 16);
    const float bar = gen_log_uniform(k->rng, 0.005f, 0.022f);
    const float belly = gen_uniform(k->rng, 0.25f, 0.45f);
    const float neck = gen_uniform(k->rng, 0.0f, 0.3f);
    const float power = gen_uniform(k->rng, 0.4f, 1.2f);
    const float winding =
        gen_chance(k->rng, 0.3f) ? gen_uniform(k->rng, -2.5f, 2.5f) : 0.0f;
    for (int i = 0; i < rings; ++i) {
        const float t = ((float)i + 0.5f) / (float)rings;
        const float r =
            neck + (belly - neck) * powf(fmaxf(0.0f, sinf(PBNDS_PI * t)), power);
        for (int j = 0; j < POINTS; ++j) {
            const float a = TURN * (float)j / POINTS;
            points[j] = pbnds_vec3_make(r * cosf(a), 0.9f * t - 0.45f, r * sinf(a));
        }
        const struct gen_tube ring = {.points = points,
                                      .count = POINTS,
                                      .closed = true,
                                      .thickness = bar,
                                      .flat = 1.0f,
                                      .sides = 6};
        gen_tube(&m, &ring);
    }
    for (int j = 0; j < ribs; ++j) {
        for (int i = 0; i <= POINTS; ++i) {
            const float t = (float)i / POINTS;
            const float a = TURN * (float)j / (float)ribs + winding * t;
            const float r =
                neck + (belly - neck) * powf(fmaxf(0.0f, sinf(PBNDS_PI * t)), power);
            points[i] = pbnds_vec3_make(r * cosf(a), 0.9f * t - 0.45f, r * sinf(a));
        }
        const struct gen_tube rib = {.points = points,
                                     .count = POINTS + 1,
                                     .thickness = bar,
                                     .flat = 1.0f,
                                     .sides = 6};
        gen_tube(&m, &rib);
    }
    const int material = gen_make_material(k, GEN_ANY);
    gen_finish(k, &m, 60.0f, material);
    if (!gen_chance(k->rng, 0.4f)) return;
    struct gen_mesh inside = {.vertex_count = 0};
    gen_put_ball(&inside, pbnds_vec3_make(0.0f, -0.1f, 0.0f), pbnds_splat(0.5f * belly),
                 gen_segments(k, 40));
    gen_finish(k, &inside, 80.0f, gen_make_material(k, GEN_ANY));
}

/* Oval links, each turned by a quarter against the one before, along a sagging curve. */
void gen_build_chain(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    enum { POINTS = 24 };
    const int links = gen_between(k->rng, 5, 14);
    const float length = 0.9f / (float)links, wire = 0.12f * length;
    const float sag = gen_uniform(k->rng, 0.0f, 0.9f);
    const bool beads = gen_chance(k->rng, 0.35f);
    for (int i = 0; i < links; ++i) {
        const float t = 2.0f * ((float)i + 0.5f) / (float)links - 1.0f;
        const struct pbnds_vec3 at = {0.45f * t, sag * 0.45f * (t * t - 0.5f), 0.0f};
        const float slope = atan2f(2.0f * sag * t, 1.0f);
        const struct pbnds_vec4 along = gen_turn(GEN_Z, slope);
        const struct pbnds_vec4 q =
            gen_quat_mul(along, gen_turn(GEN_X, i % 2 ? 0.5f * PBNDS_PI : 0.0f));
        struct pbnds_vec3 points[POINTS];
        if (beads) {
            const float r = 0.52f * length * sqrtf(1.0f + 4.0f * sag * sag * t * t);
            gen_put_ball(&m, at, pbnds_splat(r), gen_segments(k, 28));
            continue;
        }
        const float half = 0.62f * length * sqrtf(1.0f + 4.0f * sag * sag * t * t);
        for (int j = 0; j < POINTS; ++j) {
            const float a = TURN * (float)j / POINTS;
            const struct pbnds_vec3 p = {half * cosf(a), 0.38f * length * sinf(a),
                                         0.0f};
            points[j] = pbnds_add(at, gen_rotate(q, p));
        }
        const struct gen_tube link = {.points = points,
                                      .count = POINTS,
                                      .closed = true,
                                      .thickness = wire,
                                      .flat = 1.0f,
                                      .sides = 10};
        gen_tube(&m, &link);
    }
    gen_finish(k, &m, 60.0f,
               gen_make_material(k, gen_chance(k->rng, 0.6f) ? GEN_METAL : GEN_ANY));
}

/* Strands wound about each other. */
void gen_build_rope(const struct gen_maker *k)
{
    struct gen_mesh parts[2] = {{.vertex_count = 0}, {.vertex_count = 0}};
    struct pbnds_vec3 points[MAX_CURVE];
    const int strands = gen_between(k->rng, 2, 5);
    const float radius = gen_uniform(k->rng, 0.02f, 0.09f);
    const float turns = gen_uniform(k->rng, 2.0f, 8.0f);
    const float bow = gen_uniform(k->rng, -0.9f, 0.9f);
    const int count = gen_segments(k, 140);
    for (int s = 0; s < strands; ++s) {
        for (int i = 0; i < count; ++i) {
            const float t = (float)i / (float)(count - 1) - 0.5f;
            const float a = TURN * (turns * t + (float)s / (float)strands);
            points[i] = pbnds_vec3_make(radius * cosf(a), t, radius * sinf(a));
        }
        const struct gen_tube strand = {
            .points = points,
            .count = count,
            .thickness = radius * sinf(PBNDS_PI / (float)strands) * 1.05f,
            .flat = 1.0f,
            .sides = 10};
        gen_tube(&parts[s % 2], &strand);
    }
    const int first = gen_make_material(k, GEN_ANY);
    const int second = gen_chance(k->rng, 0.5f) ? first : gen_make_material(k, GEN_ANY);
    for (int i = 0; i < 2; ++i) {
        struct gen_mesh *m = &parts[i];
        for (size_t v = 0; v < m->vertex_count; ++v) { /* bent as a whole */
            const float y = m->position[v].y;
            m->position[v].x += bow * y * y;
        }
        gen_finish(k, m, 60.0f, i ? second : first);
    }
}

/* ---- trees ---- */

struct tree {
    const struct gen_maker *maker;
    struct gen_mesh wood, leaves;
    float leaf, spread, wander;
    int budget; /* branches left */
    bool needles;
};

static void add_leaf(struct tree *t, struct pbnds_vec3 at, struct pbnds_vec3 d)
{
    struct pbnds_rng *r = t->maker->rng;
    const struct pbnds_vec3 out =
        pbnds_normalize(pbnds_add(d, gen_vec3(r, -0.9f, 0.9f)));
    const struct pbnds_frame f = pbnds_frame_from_normal(out);
    const float length = t->leaf * gen_uniform(r, 0.7f, 1.4f);
    const float wide = length * (t->needles ? 0.06f : 0.32f);
    const struct pbnds_vec3 mid = pbnds_mad(at, out, 0.45f * length);
    const struct pbnds_vec3 keel = pbnds_mad(mid, f.b, -0.25f * wide);
    const struct pbnds_vec3 p[5] = {at, pbnds_mad(mid, f.t, wide),
                                    pbnds_mad(at, out, length),
                                    pbnds_mad(mid, f.t, -wide), keel};
    static const struct pbnds_vec2 uv[5] = {
        {0.5f, 1.0f}, {1.0f, 0.5f}, {0.5f, 0.0f}, {0.0f, 0.5f}, {0.5f, 0.5f}};
    uint32_t v[5];
    for (int i = 0; i < 5; ++i)
        v[i] = gen_mesh_vertex(&t->leaves, p[i], uv[i]);
    for (int i = 0; i < 4; ++i)
        gen_mesh_triangle(&t->leaves, v[4], v[i], v[(i + 1) % 4]);
}

static void grow_branch(struct tree *t, struct pbnds_vec3 at, struct pbnds_vec3 d,
                        float length, float radius, int depth)
{
    enum { POINTS = 7 };
    struct pbnds_rng *r = t->maker->rng;
    struct pbnds_vec3 points[POINTS];
    float width[POINTS];
    if (t->budget-- <= 0) return;
    for (int i = 0; i < POINTS; ++i) {
        points[i] = at;
        width[i] = radius * (1.0f - 0.6f * (float)i / (POINTS - 1));
        d = pbnds_add(d, pbnds_scale(gen_vec3(r, -1.0f, 1.0f), t->wander));
        d = pbnds_normalize(d);
        at = pbnds_mad(at, d, length / (POINTS - 1));
    }
    const struct gen_tube tube = {.points = points,
                                  .count = POINTS,
                                  .radius = width,
                                  .flat = 1.0f,
                                  .sides = depth >= 3 ? 8 : 5};
    gen_tube(&t->wood, &tube);
    if (t->leaf > 0.0f && depth <= 1) {
        const int leaves = t->needles ? 14 : 6;
        for (int i = 0; i < leaves; ++i)
            add_leaf(t, points[1 + i % (POINTS - 1)], d);
    }
    if (depth <= 0) return;
    const int children = gen_between(r, 2, 4);
    for (int i = 0; i < children; ++i) {
        const struct pbnds_vec3 side = gen_vec3(r, -1.0f, 1.0f);
        const struct pbnds_vec3 way = pbnds_normalize(pbnds_mad(d, side, t->spread));
        const int from = i == 0 ? POINTS - 1 : gen_between(r, 2, POINTS - 1);
        const float shorter = gen_uniform(r, 0.55f, 0.85f);
        grow_branch(t, points[from], way, length * shorter, 0.8f * width[from],
                    depth - 1);
    }
}

void gen_build_tree(const struct gen_maker *k)
{
    struct tree t = {.maker = k};
    t.spread = gen_uniform(k->rng, 0.4f, 1.1f);
    t.wander = gen_uniform(k->rng, 0.03f, 0.25f);
    t.needles = gen_chance(k->rng, 0.2f);
    const bool bare = gen_chance(k->rng, 0.25f);
    t.leaf = gen_log_uniform(k->rng, 0.03f, 0.12f);
    if (bare) t.leaf = 0.0f;
    t.budget = (int)(140.0f * k->detail);
    const float girth = gen_uniform(k->rng, 0.015f, 0.05f);
    const float trunk = gen_uniform(k->rng, 0.25f, 0.4f);
    grow_branch(&t, pbnds_splat(0.0f), GEN_Y, trunk, girth, 4);
    gen_finish(k, &t.wood, 80.0f, gen_make_material(k, GEN_BARK));
    const int green = gen_make_material(k, GEN_LEAF);
    k->world->materials[green].double_sided = true;
    gen_finish(k, &t.leaves, 40.0f, green);
}
