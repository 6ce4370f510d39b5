/* Things built of simple pieces: cloth, architecture, furniture, plants, machines. */
#include "scenes/generator/assemble.h"
#include "scenes/generator/noise.h"
#include "scenes/generator/shapes.h"

/* ---- cloth ---- */

struct folds {
    float frequency, height, bend, sag;
    uint32_t seed;
};

/* Ridges along a wandering direction, gathered where noise says so. */
static struct pbnds_vec3 fold_point(const void *context, float u, float v)
{
    const struct folds *f = context;
    const struct pbnds_vec3 p = {u - 0.5f, v - 0.5f, 0.0f};
    const float wander = gen_fbm(pbnds_scale(p, 2.5f), 2, 0, f->seed);
    const float phase = f->frequency * (p.x + f->bend * p.y + 0.35f * wander);
    const float strength = 0.5f + gen_noise(pbnds_scale(p, 3.0f), 0, f->seed + 7);
    const float ridge = sinf(2.0f * PBNDS_PI * phase);
    const float crumple = gen_fbm(pbnds_scale(p, 6.0f), 3, 0, f->seed + 13);
    const float height = f->height * (strength * ridge + 0.8f * crumple) -
                         f->sag * (p.x * p.x + p.y * p.y);
    return pbnds_vec3_make(p.x, height, -p.y);
}

void gen_build_cloth(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    struct folds f;
    f.frequency = gen_uniform(k->rng, 1.0f, 7.0f);
    f.height = gen_log_uniform(k->rng, 0.1f, 0.35f) / (1.0f + f.frequency);
    f.bend = gen_uniform(k->rng, -0.8f, 0.8f);
    f.sag = gen_chance(k->rng, 0.5f) ? 0.0f : gen_uniform(k->rng, -0.5f, 0.8f);
    f.seed = (uint32_t)gen_below(k->rng, 1 << 20);
    const int n = gen_segments(k, 110);
    const struct gen_grid grid = {n, n, false, false, fold_point, &f};
    gen_mesh_grid(&m, &grid);
    gen_finish(k, &m, 180.0f, gen_sheet_material(k));
}

struct drape {
    float radius, drop, waves, depth, square;
    uint32_t seed;
};

/* Flat over a table top of the given radius; the rest hangs in waves. */
static struct pbnds_vec3 drape_point(const void *context, float u, float v)
{
    const struct drape *d = context;
    const float a = u * 2.0f * PBNDS_PI, c = cosf(a), s = sinf(a);
    const float edge = d->square > 0.5f ? 1.0f / fmaxf(fabsf(c), fabsf(s)) : 1.0f;
    const float arc = (d->radius + d->drop) * (1.0f - v), round = 0.03f;
    const float over = fmaxf(0.0f, arc - d->radius);
    const float hang =
        over < round ? over * over / (2.0f * round) : over - 0.5f * round;
    const struct pbnds_vec3 at = {1.5f * c, 1.5f * s, 0.0f};
    const float irregular = gen_fbm(at, 2, 0, d->seed);
    const float wave = sinf(d->waves * a + 3.0f * irregular);
    const float out =
        fminf(arc, d->radius) * edge + 0.3f * hang + d->depth * hang * (0.7f + wave);
    return pbnds_vec3_make(out * c, -hang, -out * s);
}

void gen_build_tablecloth(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    struct drape d;
    d.radius = gen_uniform(k->rng, 0.2f, 0.35f);
    d.drop = gen_uniform(k->rng, 0.15f, 0.5f);
    d.waves = (float)gen_between(k->rng, 4, 14);
    d.depth = gen_uniform(k->rng, 0.1f, 0.35f);
    d.square = pbnds_rng_float(k->rng);
    d.seed = (uint32_t)gen_below(k->rng, 1 << 20);
    const struct gen_grid grid = {
        gen_segments(k, 160), gen_segments(k, 56), true, false, drape_point, &d};
    gen_mesh_grid(&m, &grid);
    gen_finish(k, &m, 100.0f, gen_sheet_material(k));
}

/* ---- architecture ---- */

void gen_build_stairs(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    const int steps = gen_between(k->rng, 3, 10);
    const float n = (float)steps, rise = gen_uniform(k->rng, 0.4f, 0.9f) / n;
    const float tread = 0.9f / n, half = gen_uniform(k->rng, 0.15f, 0.45f);
    const float winding =
        gen_chance(k->rng, 0.3f) ? gen_uniform(k->rng, 0.2f, 0.5f) : 0.0f;
    const bool solid = gen_chance(k->rng, 0.6f);
    const float bevel = gen_chance(k->rng, 0.5f) ? 0.0f : 0.08f * rise;
    for (int i = 0; i < steps; ++i) {
        const float top = rise * (float)(i + 1);
        const float high = solid ? 0.5f * top : 0.3f * rise;
        const struct pbnds_vec3 box = {half, high,
                                       0.5f * tread * (winding > 0.0f ? 1.6f : 1.0f)};
        const struct pbnds_vec4 q = gen_turn(GEN_Y, winding * (float)i);
        const struct pbnds_vec3 at =
            winding > 0.0f ? gen_rotate(q, pbnds_vec3_make(half + 0.05f, 0.0f, 0.0f))
                           : pbnds_vec3_make(0.0f, 0.0f, 0.45f - tread * (float)i);
        gen_put_block(&m, box, bevel, pbnds_vec3_make(at.x, top - high, at.z), q);
    }
    gen_finish(k, &m, 40.0f, gen_make_material(k, GEN_GROUND));
}

/* Half ring of wedge stones on two pillars. */
void gen_build_arch(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    const int stones = gen_between(k->rng, 7, 15);
    const float radius = gen_uniform(k->rng, 0.2f, 0.4f),
                thick = gen_uniform(k->rng, 0.05f, 0.1f);
    const float deep = gen_uniform(k->rng, 0.06f, 0.2f),
                high = gen_uniform(k->rng, 0.1f, 0.3f);
    const float bevel = gen_uniform(k->rng, 0.004f, 0.02f);
    for (int i = 0; i < stones; ++i) {
        const float a = PBNDS_PI * ((float)i + 0.5f) / (float)stones;
        const float half = 0.5f * PBNDS_PI * (radius + thick) / (float)stones;
        const float grow = gen_uniform(k->rng, 0.95f, 1.08f);
        const struct pbnds_vec3 box = {thick * grow, 0.97f * half, deep * grow};
        gen_put_block(&m, box, bevel,
                      pbnds_vec3_make(radius * cosf(a), high + radius * sinf(a), 0.0f),
                      gen_turn(GEN_Z, a));
    }
    for (int side = -1; side <= 1; side += 2) {
        gen_put_block(&m, pbnds_vec3_make(thick * 1.1f, 0.5f * high, deep * 1.1f),
                      bevel, pbnds_vec3_make(radius * (float)side, 0.5f * high, 0.0f),
                      GEN_REST);
    }
    if (gen_chance(k->rng, 0.3f)) {
        gen_put_block(
            &m, pbnds_vec3_make(radius + 2.0f * thick, 0.6f * thick, deep * 1.2f),
            bevel, pbnds_vec3_make(0.0f, high + radius + 1.5f * thick, 0.0f), GEN_REST);
    }
    gen_finish(k, &m, 40.0f, gen_make_material(k, GEN_GROUND));
}

static void one_column(const struct gen_maker *k, struct gen_mesh *m,
                       struct pbnds_vec3 at, float radius, float half, int flutes)
{
    struct gen_mesh shaft = {.vertex_count = 0}, ring = {.vertex_count = 0};
    struct pbnds_vec2 profile[13];
    for (int i = 0; i < 13; ++i) { /* entasis: the shaft swells a little */
        const float t = (float)i / 12.0f;
        profile[i] = (struct pbnds_vec2){
            radius * (0.9f + 0.1f * sinf(PBNDS_PI * (0.3f + 0.7f * t))),
            half * (2.0f * t - 1.0f)};
    }
    gen_lathe(&shaft, profile, 13, flutes ? flutes * 6 : gen_segments(k, 48), flutes,
              0.08f);
    gen_put(m, &shaft, at, GEN_REST);
    for (int side = -1; side <= 1; side += 2) {
        const float y = half * (float)side;
        const struct pbnds_vec3 slab = {1.5f * radius, 0.25f * radius, 1.5f * radius};
        gen_put_block(m, slab, 0.03f * radius,
                      pbnds_vec3_make(at.x, at.y + y * 1.06f, at.z), GEN_REST);
        gen_torus(&ring, 0.95f * radius, 0.2f * radius, gen_segments(k, 40));
        gen_put(m, &ring, pbnds_vec3_make(at.x, at.y + y * 0.98f, at.z), GEN_REST);
    }
}

void gen_build_column(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    const int count = gen_chance(k->rng, 0.5f) ? 1 : gen_between(k->rng, 2, 5);
    const int flutes = gen_chance(k->rng, 0.5f) ? 0 : gen_between(k->rng, 8, 16);
    const float radius = gen_uniform(k->rng, 0.05f, 0.12f),
                half = gen_uniform(k->rng, 0.25f, 0.45f);
    const float step = 4.5f * radius;
    for (int i = 0; i < count; ++i) {
        const float x = step * ((float)i - 0.5f * (float)(count - 1));
        one_column(k, &m, pbnds_vec3_make(x, 0.0f, 0.0f), radius, half, flutes);
    }
    if (count > 1) {
        gen_put_block(
            &m,
            pbnds_vec3_make(0.5f * step * (float)count, 0.4f * radius, 1.6f * radius),
            0.02f * radius, pbnds_vec3_make(0.0f, half * 1.06f + 0.6f * radius, 0.0f),
            GEN_REST);
    }
    gen_finish(k, &m, 40.0f, gen_make_material(k, GEN_GROUND));
}

/* ---- furniture ---- */

/* Many boxes of a few materials, on a heap or in a row like books. */
void gen_build_clutter(const struct gen_maker *k)
{
    struct gen_mesh parts[3] = {
        {.vertex_count = 0}, {.vertex_count = 0}, {.vertex_count = 0}};
    const bool row = gen_chance(k->rng, 0.4f);
    const int count = gen_between(k->rng, 6, 22);
    float x = -0.45f;
    for (int i = 0; i < count; ++i) {
        struct gen_mesh *m = &parts[gen_below(k->rng, 3)];
        struct pbnds_vec3 half = gen_vec3(k->rng, 0.03f, 0.13f);
        struct pbnds_vec3 at = gen_vec3(k->rng, -0.35f, 0.35f);
        float turn = gen_uniform(k->rng, 0.0f, 2.0f * PBNDS_PI);
        if (row) {
            half = pbnds_vec3_make(0.15f * half.x + 0.008f, 0.6f * half.y + 0.14f,
                                   0.1f + 0.2f * half.z);
            at = pbnds_vec3_make(x + half.x, half.y, 0.1f * at.z);
            turn = 0.0f;
            x += 2.0f * half.x + 0.002f;
        } else {
            at.y = half.y + (i > count / 2 ? 0.12f : 0.0f);
        }
        gen_put_block(m, half, 0.06f * fminf(half.x, fminf(half.y, half.z)), at,
                      gen_turn(GEN_Y, turn));
    }
    for (int i = 0; i < 3; ++i) {
        if (parts[i].index_count)
            gen_finish(k, &parts[i], 35.0f, gen_make_material(k, GEN_ANY));
    }
}

void gen_build_table(const struct gen_maker *k)
{
    struct gen_mesh top = {.vertex_count = 0}, legs = {.vertex_count = 0};
    const bool round = gen_chance(k->rng, 0.4f), chair = gen_chance(k->rng, 0.4f);
    const float wide = gen_uniform(k->rng, 0.2f, 0.5f);
    const float deep = round ? wide : gen_uniform(k->rng, 0.2f, 0.4f);
    const float high = gen_uniform(k->rng, 0.3f, 0.7f),
                thick = gen_uniform(k->rng, 0.012f, 0.04f);
    const float leg = gen_uniform(k->rng, 0.012f, 0.04f);
    if (round) {
        gen_put_frustum(&top, wide, wide, thick, pbnds_splat(0.0f), GEN_REST,
                        gen_segments(k, 72));
    } else {
        gen_put_block(&top, pbnds_vec3_make(wide, thick, deep), 0.4f * thick,
                      pbnds_splat(0.0f), GEN_REST);
    }
    const bool central = round && gen_chance(k->rng, 0.5f);
    for (int i = 0; i < (central ? 1 : 4); ++i) {
        const float x =
            central ? 0.0f : (i & 1 ? 0.8f : -0.8f) * wide * (round ? 0.75f : 1.0f);
        const float z =
            central ? 0.0f : (i & 2 ? 0.8f : -0.8f) * deep * (round ? 0.75f : 1.0f);
        gen_put_frustum(&legs, 0.8f * leg, leg, 0.5f * high,
                        pbnds_vec3_make(x, -0.5f * high, z), GEN_REST, 20);
    }
    if (central) {
        gen_put_frustum(&legs, 0.6f * wide, 0.15f * wide, thick,
                        pbnds_vec3_make(0.0f, -high, 0.0f), GEN_REST, 48);
    }
    if (chair && !round) {
        const float back = gen_uniform(k->rng, 0.15f, 0.4f);
        gen_put_block(&top, pbnds_vec3_make(wide, back, thick), 0.4f * thick,
                      pbnds_vec3_make(0.0f, back, -deep), gen_turn(GEN_X, -0.1f));
    }
    const int material = gen_make_material(k, GEN_ANY);
    gen_finish(k, &top, 35.0f, material);
    gen_finish(k, &legs, 35.0f,
               gen_chance(k->rng, 0.5f) ? material : gen_make_material(k, GEN_ANY));
}

/* ---- plants ---- */

struct blade {
    struct pbnds_vec3 out;
    float length, width, droop;
};

static struct pbnds_vec3 blade_point(const void *context, float u, float v)
{
    const struct blade *b = context;
    const struct pbnds_vec3 side = {-b->out.z, 0.0f, b->out.x};
    const float along = v * b->length;
    const float across = (u - 0.5f) * b->width * sinf(PBNDS_PI * (0.12f + 0.87f * v));
    const float crease = 0.25f * fabsf(u - 0.5f) * b->width;
    struct pbnds_vec3 p = pbnds_scale(b->out, along * (0.25f + b->droop * v));
    p.y = along * (1.0f - 0.7f * b->droop * v) + crease;
    return pbnds_mad(p, side, across);
}

void gen_build_tuft(const struct gen_maker *k)
{
    struct gen_mesh leaves = {.vertex_count = 0}, pot = {.vertex_count = 0};
    const int count = gen_between(k->rng, 10, k->detail > 0.7f ? 90 : 40);
    const float width = gen_log_uniform(k->rng, 0.02f, 0.18f),
                droop = gen_uniform(k->rng, 0.1f, 0.9f);
    for (int i = 0; i < count; ++i) {
        struct blade b;
        const float a =
            2.399963f * (float)i; /* golden angle: leaves shade each other least */
        b.out = pbnds_vec3_make(cosf(a), 0.0f, sinf(a));
        b.length = gen_uniform(k->rng, 0.3f, 0.7f);
        b.width = width * gen_uniform(k->rng, 0.7f, 1.3f);
        b.droop = droop * gen_uniform(k->rng, 0.3f, 1.3f);
        const struct gen_grid grid = {4, 10, false, false, blade_point, &b};
        gen_mesh_grid(&leaves, &grid);
    }
    gen_finish(k, &leaves, 70.0f, gen_sheet_material(k));
    if (!gen_chance(k->rng, 0.6f)) return;
    gen_put_frustum(&pot, 0.11f, 0.17f, 0.13f, pbnds_vec3_make(0.0f, -0.1f, 0.0f),
                    GEN_REST, gen_segments(k, 56));
    gen_finish(k, &pot, 35.0f, gen_make_material(k, GEN_ANY));
}

/* ---- made by machines ---- */

void gen_build_lattice(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    const int nx = gen_between(k->rng, 2, 6), ny = gen_between(k->rng, 2, 6);
    const int nz = gen_chance(k->rng, 0.5f) ? 1 : gen_between(k->rng, 2, 3);
    const float bar = gen_log_uniform(k->rng, 0.008f, 0.035f), half = 0.45f;
    const bool round = gen_chance(k->rng, 0.5f);
    for (int axis = 0; axis < (nz > 1 ? 3 : 2); ++axis) {
        const int counts[3][2] = {{ny, nz}, {nx, nz}, {nx, ny}};
        for (int i = 0; i < counts[axis][0]; ++i) {
            for (int j = 0; j < counts[axis][1]; ++j) {
                const float s =
                    half * (2.0f * (float)i / (float)(counts[axis][0] - 1) - 1.0f);
                const float t =
                    counts[axis][1] > 1
                        ? half * (2.0f * (float)j / (float)(counts[axis][1] - 1) - 1.0f)
                        : 0.0f;
                const struct pbnds_vec3 at = axis == 0   ? pbnds_vec3_make(0.0f, s, t)
                                             : axis == 1 ? pbnds_vec3_make(s, 0.0f, t)
                                                         : pbnds_vec3_make(s, t, 0.0f);
                const struct pbnds_vec4 q = axis == 0 ? gen_turn(GEN_Z, 0.5f * PBNDS_PI)
                                            : axis == 1
                                                ? GEN_REST
                                                : gen_turn(GEN_X, 0.5f * PBNDS_PI);
                if (round) {
                    gen_put_frustum(&m, bar, bar, half + bar, at, q, 12);
                } else {
                    gen_put_block(&m, pbnds_vec3_make(bar, half + bar, bar), 0.0f, at,
                                  q);
                }
            }
        }
    }
    gen_finish(k, &m, 40.0f, gen_make_material(k, GEN_ANY));
}

/* Bolts, knobs or fins in a circle about an axis. */
static void put_circle(const struct gen_maker *k, struct gen_mesh *m,
                       struct pbnds_vec3 at, struct pbnds_vec4 q, float radius)
{
    const int count = gen_between(k->rng, 3, 12), kind = gen_below(k->rng, 3);
    const float size = gen_uniform(k->rng, 0.15f, 0.7f) * radius / sqrtf((float)count);
    for (int i = 0; i < count; ++i) {
        const struct pbnds_vec4 turn =
            gen_turn(GEN_Y, 2.0f * PBNDS_PI * (float)i / (float)count);
        const struct pbnds_vec3 arm =
            gen_rotate(turn, pbnds_vec3_make(radius, 0.0f, 0.0f));
        const struct pbnds_vec3 t = pbnds_add(at, gen_rotate(q, arm));
        const struct pbnds_vec4 pose = gen_quat_mul(q, turn);
        struct gen_mesh knob = {.vertex_count = 0};
        if (kind == 0)
            gen_put_frustum(m, size, size, 0.6f * size, t, pose, i % 2 ? 6 : 6);
        if (kind == 1)
            gen_put_block(m, pbnds_vec3_make(1.6f * size, 1.2f * size, 0.25f * size),
                          0.05f * size, t, pose);
        if (kind == 2) {
            gen_ellipsoid(&knob, pbnds_splat(size), 20);
            gen_put(m, &knob, t, pose);
        }
    }
}

/* A pile of turned parts along one axis, with rings, bolts and pipes. */
void gen_build_machine(const struct gen_maker *k)
{
    struct gen_mesh parts[3] = {
        {.vertex_count = 0}, {.vertex_count = 0}, {.vertex_count = 0}};
    const int stages = gen_between(k->rng, 3, 7), segments = gen_segments(k, 64);
    float y = -0.45f;
    for (int i = 0; i < stages; ++i) {
        struct gen_mesh *m = &parts[gen_below(k->rng, 3)], ring = {.vertex_count = 0};
        const float radius = gen_uniform(k->rng, 0.08f, 0.38f);
        const float half = gen_uniform(k->rng, 0.02f, 0.13f);
        const struct pbnds_vec3 at = {0.0f, y + half, 0.0f};
        const int kind = gen_below(k->rng, 4);
        if (kind == 0) {
            const float deep = radius * gen_uniform(k->rng, 0.5f, 1.0f);
            gen_put_block(m, pbnds_vec3_make(radius, half, deep), 0.15f * half, at,
                          GEN_REST);
        } else {
            gen_put_frustum(m, radius, radius * (kind == 1 ? 0.6f : 1.0f), half, at,
                            GEN_REST, segments);
        }
        if (gen_chance(k->rng, 0.5f)) {
            gen_torus(&ring, 1.02f * radius, 0.25f * half, segments);
            gen_put(&parts[gen_below(k->rng, 3)], &ring, at, GEN_REST);
        }
        if (gen_chance(k->rng, 0.6f)) {
            put_circle(k, &parts[gen_below(k->rng, 3)],
                       pbnds_vec3_make(0.0f, y + 2.0f * half, 0.0f), GEN_REST,
                       0.75f * radius);
        }
        y += 1.98f * half;
    }
    const int pipes = gen_between(k->rng, 0, 3);
    for (int i = 0; i < pipes; ++i) {
        struct gen_mesh pipe = {.vertex_count = 0};
        const float a = gen_uniform(k->rng, 0.0f, 2.0f * PBNDS_PI);
        const float bow = gen_uniform(k->rng, 0.1f, 0.25f);
        gen_torus(&pipe, bow, gen_uniform(k->rng, 0.015f, 0.04f), segments);
        gen_put(&parts[2], &pipe,
                pbnds_vec3_make(0.25f * cosf(a), 0.4f * y - 0.1f, -0.25f * sinf(a)),
                gen_quat_mul(gen_turn(GEN_Y, a), gen_turn(GEN_X, 0.5f * PBNDS_PI)));
    }
    for (int i = 0; i < 3; ++i) {
        const bool metal = gen_chance(k->rng, 0.5f);
        if (parts[i].index_count) {
            gen_finish(k, &parts[i], 35.0f,
                       gen_make_material(k, metal ? GEN_METAL : GEN_ANY));
        }
    }
}
