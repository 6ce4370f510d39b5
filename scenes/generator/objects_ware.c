/* Things of the household: cups, pots, bottles, lamps, fruit, candles, bolts, books. */
#include "scenes/generator/assemble.h"
#include "scenes/generator/deform.h"
#include "scenes/generator/shapes.h"

#define TURN (2.0f * PBNDS_PI)

/* Appends n points of a smooth curve through three heights; x radius, y height. */
static int add_profile(struct pbnds_vec2 *profile, int at, const float knot[][2],
                       int knots, int steps)
{
    struct pbnds_vec3 in[12], out[12 * 16];
    for (int i = 0; i < knots; ++i)
        in[i] = pbnds_vec3_make(knot[i][0], knot[i][1], 0.0f);
    const int n = gen_curve(in, knots, false, steps, out);
    for (int i = 0; i < n; ++i)
        profile[at++] = (struct pbnds_vec2){fmaxf(out[i].x, 0.0f), out[i].y};
    return at;
}

/* Body of a cup or pot: outside up, over the rim, inside down. */
static void vessel(const struct gen_maker *k, struct gen_mesh *m, float foot,
                   float belly, float mouth, float half)
{
    struct pbnds_vec2 profile[200];
    const float wall = gen_uniform(k->rng, 0.012f, 0.03f);
    const float outside[5][2] = {{0.9f * foot, -half},
                                 {foot, -half + 0.02f},
                                 {belly, -0.2f * half},
                                 {0.5f * (belly + mouth), 0.45f * half},
                                 {mouth, half}};
    const float inside[4][2] = {{mouth - wall, half},
                                {0.5f * (belly + mouth) - wall, 0.45f * half},
                                {belly - wall, -0.2f * half},
                                {0.7f * foot, -half + 2.0f * wall}};
    int n = 0;
    profile[n++] = (struct pbnds_vec2){0.0f, -half};
    n = add_profile(profile, n, outside, 5, 8);
    profile[n++] = (struct pbnds_vec2){mouth - 0.5f * wall, half + 0.5f * wall};
    n = add_profile(profile, n, inside, 4, 8);
    profile[n++] = (struct pbnds_vec2){0.0f, -half + 2.0f * wall};
    gen_lathe(m, profile, n, gen_segments(k, 64), 0, 0.0f);
}

static void handle(const struct gen_maker *k, struct gen_mesh *m, float x, float low,
                   float high, float out)
{
    struct pbnds_vec3 points[80];
    const float thick = gen_uniform(k->rng, 0.014f, 0.03f);
    const struct pbnds_vec3 knot[5] = {
        pbnds_vec3_make(x - 0.02f, low, 0.0f),
        pbnds_vec3_make(x + 0.75f * out, low + 0.12f * (high - low), 0.0f),
        pbnds_vec3_make(x + out, 0.55f * (low + high), 0.0f),
        pbnds_vec3_make(x + 0.7f * out, high, 0.0f),
        pbnds_vec3_make(x - 0.02f, high - 0.05f, 0.0f)};
    const struct gen_tube t = {.points = points,
                               .count = gen_curve(knot, 5, false, 10, points),
                               .thickness = thick,
                               .flat = gen_uniform(k->rng, 0.5f, 1.6f),
                               .sides = 12};
    gen_tube(m, &t);
}

void gen_build_cup(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0}, tea = {.vertex_count = 0};
    const float half = gen_uniform(k->rng, 0.12f, 0.42f);
    const float foot = gen_uniform(k->rng, 0.12f, 0.28f);
    const float belly = foot * gen_uniform(k->rng, 1.0f, 1.5f);
    const float mouth = belly * gen_uniform(k->rng, 0.85f, 1.35f);
    const bool handled = gen_chance(k->rng, 0.6f), full = gen_chance(k->rng, 0.4f);
    vessel(k, &m, foot, belly, mouth, half);
    if (handled) handle(k, &m, 0.95f * belly, -0.55f * half, 0.6f * half, 0.16f);
    gen_finish(k, &m, 45.0f, gen_make_material(k, GEN_ANY));
    if (!full) return;
    gen_put_frustum(&tea, 0.8f * fminf(mouth, belly), 0.8f * fminf(mouth, belly), 0.01f,
                    pbnds_vec3_make(0.0f, 0.3f * half, 0.0f), GEN_REST, 48);
    const struct gen_material liquid = gen_material_plain(
        gen_srgb(gen_chance(k->rng, 0.5f) ? 0x2b1508u : 0x9c4a12u), 0.0f, 0.03f);
    gen_finish(k, &tea, 40.0f, gen_world_material(k->world, &liquid));
}

void gen_build_pot(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0}, lid = {.vertex_count = 0};
    struct pbnds_vec3 points[40];
    float width[40];
    const float half = gen_uniform(k->rng, 0.16f, 0.28f);
    const float belly = gen_uniform(k->rng, 0.24f, 0.36f);
    const float mouth = belly * gen_uniform(k->rng, 0.4f, 0.75f);
    vessel(k, &m, 0.6f * belly, belly, mouth, half);
    handle(k, &m, 0.9f * belly, -0.4f * half, 0.6f * half, 0.2f);
    const struct pbnds_vec3 spout[4] = {
        pbnds_vec3_make(-0.85f * belly, -0.3f * half, 0.0f),
        pbnds_vec3_make(-1.25f * belly, -0.05f * half, 0.0f),
        pbnds_vec3_make(-1.4f * belly, 0.5f * half, 0.0f),
        pbnds_vec3_make(-1.7f * belly, 0.95f * half, 0.0f)};
    const int n = gen_curve(spout, 4, false, 9, points);
    for (int i = 0; i < n; ++i)
        width[i] = 0.075f - 0.045f * (float)i / (float)(n - 1);
    const struct gen_tube t = {
        .points = points, .count = n, .radius = width, .flat = 1.0f, .sides = 20};
    gen_tube(&m, &t);
    const int material = gen_make_material(k, GEN_ANY);
    gen_finish(k, &m, 50.0f, material);
    gen_put_ball(&lid, pbnds_vec3_make(0.0f, half, 0.0f),
                 pbnds_vec3_make(mouth, 0.35f * mouth, mouth), gen_segments(k, 48));
    const float knob = gen_uniform(k->rng, 0.03f, 0.05f);
    gen_put_ball(&lid, pbnds_vec3_make(0.0f, half + 0.35f * mouth + 0.6f * knob, 0.0f),
                 pbnds_splat(knob), 24);
    gen_finish(k, &lid, 80.0f,
               gen_chance(k->rng, 0.6f) ? material : gen_make_material(k, GEN_ANY));
}

void gen_build_bottle(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0}, label = {.vertex_count = 0},
                    cork = {.vertex_count = 0};
    struct pbnds_vec2 profile[100];
    const float r = gen_uniform(k->rng, 0.1f, 0.22f),
                neck = r * gen_uniform(k->rng, 0.25f, 0.5f);
    const float shoulder = gen_uniform(k->rng, -0.05f, 0.25f);
    const float knots[7][2] = {
        {0.9f * r, -0.5f},    {r, -0.47f},           {r, -0.2f},
        {r, shoulder - 0.1f}, {0.85f * r, shoulder}, {neck, shoulder + 0.14f},
        {neck, 0.48f}};
    int n = 0;
    profile[n++] = (struct pbnds_vec2){0.0f, -0.5f};
    n = add_profile(profile, n, knots, 7, 8);
    profile[n++] = (struct pbnds_vec2){1.15f * neck, 0.48f};
    profile[n++] = (struct pbnds_vec2){1.15f * neck, 0.5f};
    profile[n++] = (struct pbnds_vec2){0.0f, 0.5f};
    gen_lathe(&m, profile, n, gen_segments(k, 64), 0, 0.0f);
    gen_finish(k, &m, 45.0f, gen_make_material(k, GEN_GLAZE));
    if (gen_chance(k->rng, 0.7f)) {
        const float half = 0.4f * (shoulder + 0.35f);
        const struct pbnds_vec2 band[2] = {{1.012f * r, -half}, {1.012f * r, half}};
        struct gen_mesh sheet = {.vertex_count = 0};
        gen_lathe(&sheet, band, 2, 64, 0, 0.0f);
        gen_put(&label, &sheet, pbnds_vec3_make(0.0f, shoulder - 0.12f - half, 0.0f),
                GEN_REST);
        const int paper = gen_make_material(k, GEN_PRINT);
        k->world->materials[paper].double_sided = true;
        gen_finish(k, &label, 60.0f, paper);
    }
    if (!gen_chance(k->rng, 0.5f)) return;
    gen_put_frustum(&cork, 1.2f * neck, 1.2f * neck, 0.035f,
                    pbnds_vec3_make(0.0f, 0.53f, 0.0f), GEN_REST, 32);
    gen_finish(k, &cork, 40.0f, gen_make_material(k, GEN_ANY));
}

/* Foot, stem, open shade, and what glows inside. */
void gen_build_lamp(const struct gen_maker *k)
{
    struct gen_mesh stand = {.vertex_count = 0}, shade = {.vertex_count = 0},
                    bulb = {.vertex_count = 0};
    const float foot = gen_uniform(k->rng, 0.1f, 0.22f);
    const float wide = gen_uniform(k->rng, 0.15f, 0.34f);
    const float top = wide * gen_uniform(k->rng, 0.3f, 1.0f);
    const float high = gen_uniform(k->rng, 0.1f, 0.2f);
    gen_put_frustum(&stand, foot, 0.8f * foot, 0.015f,
                    pbnds_vec3_make(0.0f, -0.5f, 0.0f), GEN_REST, gen_segments(k, 56));
    gen_put_frustum(&stand, 0.015f, 0.015f, 0.4f, pbnds_vec3_make(0.0f, -0.1f, 0.0f),
                    GEN_REST, 16);
    if (gen_chance(k->rng, 0.4f)) {
        const float belly = gen_uniform(k->rng, 0.08f, 0.18f);
        gen_put_ball(&stand, pbnds_vec3_make(0.0f, -0.48f + belly, 0.0f),
                     pbnds_vec3_make(belly, belly, belly), gen_segments(k, 48));
    }
    gen_finish(k, &stand, 40.0f, gen_make_material(k, GEN_ANY));
    const struct pbnds_vec2 cone[2] = {{wide, 0.32f - high}, {top, 0.32f + high}};
    const int flutes = gen_chance(k->rng, 0.3f) ? 24 : 0;
    gen_lathe(&shade, cone, 2, flutes ? 144 : gen_segments(k, 64), flutes, 0.06f);
    gen_finish(k, &shade, 70.0f, gen_sheet_material(k));
    gen_put_ball(&bulb, pbnds_vec3_make(0.0f, 0.32f, 0.0f), pbnds_splat(0.05f), 24);
    gen_finish(k, &bulb, 80.0f, gen_make_material(k, GEN_GLOW));
}

/* Rods that stand or hang, lit. */
void gen_build_candles(const struct gen_maker *k)
{
    struct gen_mesh wax = {.vertex_count = 0}, flame = {.vertex_count = 0},
                    plate = {.vertex_count = 0};
    const int count = gen_between(k->rng, 1, 6);
    for (int i = 0; i < count; ++i) {
        const float a = 2.4f * (float)i, r = i ? 0.26f : 0.0f;
        const float half = gen_uniform(k->rng, 0.08f, 0.4f);
        const float thick = gen_uniform(k->rng, 0.04f, 0.11f);
        const struct pbnds_vec3 at = {r * cosf(a), half, r * sinf(a)};
        gen_put_frustum(&wax, thick, thick, half, at, GEN_REST, gen_segments(k, 40));
        gen_put_ball(&flame, pbnds_vec3_make(at.x, 2.0f * half + 0.05f, at.z),
                     pbnds_vec3_make(0.018f, 0.05f, 0.018f), 16);
    }
    gen_put_frustum(&plate, 0.3f, 0.42f, 0.02f, pbnds_vec3_make(0.0f, -0.02f, 0.0f),
                    GEN_REST, gen_segments(k, 64));
    gen_finish(k, &wax, 40.0f, gen_make_material(k, GEN_PLAIN));
    gen_finish(k, &plate, 40.0f, gen_make_material(k, GEN_ANY));
    gen_finish(k, &flame, 80.0f, gen_make_material(k, GEN_GLOW));
}

/* One fruit or vegetable about y, unit size. */
static void one_fruit(const struct gen_maker *k, struct gen_mesh *m, int kind)
{
    const int segments = gen_segments(k, 40);
    if (kind == 0) { /* apple: dimples at both poles */
        gen_ellipsoid(m, pbnds_splat(0.5f), segments);
        for (size_t i = 0; i < m->vertex_count; ++i) {
            const struct pbnds_vec3 p = m->position[i];
            const float r = hypotf(p.x, p.z);
            m->position[i].y = p.y * (0.92f - 0.55f * expf(-30.0f * r * r));
        }
    } else if (kind == 1) { /* banana, cucumber */
        gen_capsule(m, 0.12f, 0.4f, segments);
        gen_bend(m, gen_uniform(k->rng, 0.2f, 1.4f));
    } else if (kind == 2) { /* pear, gourd */
        gen_ellipsoid(m, pbnds_vec3_make(0.4f, 0.5f, 0.4f), segments);
        for (size_t i = 0; i < m->vertex_count; ++i) {
            const float s = 0.72f - 0.5f * m->position[i].y;
            m->position[i].x *= s;
            m->position[i].z *= s;
        }
    } else if (kind == 3) { /* pumpkin */
        gen_ellipsoid(m, pbnds_vec3_make(0.5f, 0.36f, 0.5f), 2 * segments);
        for (size_t i = 0; i < m->vertex_count; ++i) {
            const struct pbnds_vec3 p = m->position[i];
            const float s = 1.0f - 0.12f * fabsf(cosf(5.0f * atan2f(p.z, p.x)));
            m->position[i].x *= s;
            m->position[i].z *= s;
        }
    } else { /* citrus, berry, egg */
        gen_ellipsoid(m, pbnds_vec3_make(0.45f, 0.5f, 0.45f), segments);
    }
}

void gen_build_fruit(const struct gen_maker *k)
{
    struct gen_mesh parts[3] = {
        {.vertex_count = 0}, {.vertex_count = 0}, {.vertex_count = 0}};
    const int count = gen_chance(k->rng, 0.4f) ? 1 : gen_between(k->rng, 3, 9);
    const bool bowl = count > 2 && gen_chance(k->rng, 0.6f);
    const float size = count == 1 ? 0.95f : 0.26f;
    for (int i = 0; i < count; ++i) {
        struct gen_mesh fruit = {.vertex_count = 0}, small = {.vertex_count = 0};
        const int kind = gen_below(k->rng, 5);
        one_fruit(k, &fruit, kind);
        const float a = 2.4f * (float)i, r = count == 1 || i == 0 ? 0.0f : 0.22f;
        const struct pbnds_vec4 turn = gen_rotation(k->rng);
        const struct pbnds_vec3 at = {r * cosf(a), 0.13f + (i > 4 ? 0.18f : 0.0f),
                                      r * sinf(a)};
        const struct pbnds_mat4 scale =
            pbnds_mat4_from_trs(pbnds_splat(0.0f), GEN_REST, pbnds_splat(size));
        gen_mesh_append(&small, &fruit, &scale);
        gen_mesh_free(&fruit);
        gen_put(&parts[i % 3], &small, at, count == 1 ? GEN_REST : turn);
    }
    for (int i = 0; i < 3; ++i)
        gen_finish(k, &parts[i], 90.0f, gen_make_material(k, GEN_FRUIT));
    if (!bowl) return;
    struct gen_mesh dish = {.vertex_count = 0};
    const struct pbnds_vec2 profile[8] = {
        {0.0f, -0.02f}, {0.2f, -0.02f}, {0.36f, 0.06f}, {0.46f, 0.2f},
        {0.43f, 0.2f},  {0.34f, 0.09f}, {0.2f, 0.02f},  {0.0f, 0.02f}};
    gen_lathe(&dish, profile, 8, gen_segments(k, 72), 0, 0.0f);
    gen_finish(k, &dish, 60.0f, gen_make_material(k, GEN_ANY));
}

/* Hexagonal head, shaft, thread. */
void gen_build_bolt(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    enum { POINTS = 220 };
    struct pbnds_vec3 points[POINTS];
    float width[POINTS];
    const float shaft = gen_uniform(k->rng, 0.06f, 0.16f);
    const float head = shaft * gen_uniform(k->rng, 1.4f, 2.2f);
    const float pitch = shaft * gen_uniform(k->rng, 0.25f, 0.5f);
    const int corners = gen_chance(k->rng, 0.6f)   ? 6
                        : gen_chance(k->rng, 0.5f) ? 4
                                                   : 40;
    const float turns = fminf(0.6f / pitch, 14.0f);
    for (int i = 0; i < POINTS; ++i) {
        const float t = (float)i / (POINTS - 1), a = TURN * turns * t;
        points[i] = pbnds_vec3_make(shaft * cosf(a), -0.45f + pitch * turns * t,
                                    shaft * sinf(a));
        const float end = fminf(t, 1.0f - t) * 12.0f;
        width[i] = 0.45f * pitch * fminf(1.0f, 0.1f + end);
    }
    const struct gen_tube thread = {
        .points = points, .count = POINTS, .radius = width, .flat = 1.0f, .sides = 6};
    gen_tube(&m, &thread);
    gen_put_frustum(&m, 0.98f * shaft, 0.98f * shaft, 0.45f,
                    pbnds_vec3_make(0.0f, -0.02f, 0.0f), GEN_REST, 48);
    gen_put_frustum(&m, head, head, 0.09f, pbnds_vec3_make(0.0f, 0.42f, 0.0f), GEN_REST,
                    corners);
    gen_finish(k, &m, 35.0f,
               gen_make_material(k, gen_chance(k->rng, 0.7f) ? GEN_METAL : GEN_ANY));
}

/* An open book: two fans of pages over a cover. */
struct pages {
    float side, thick, arch;
};

static struct pbnds_vec3 page_point(const void *context, float u, float v)
{
    const struct pages *p = context;
    const float x = p->side > 0.0f ? u : 1.0f - u;
    const float lift = p->thick * sqrtf(fmaxf(0.0f, 1.0f - powf(1.0f - x, 6.0f))) +
                       p->arch * sinf(PBNDS_PI * powf(x, 0.6f));
    return pbnds_vec3_make(p->side * 0.45f * x, lift, 0.3f - 0.6f * v);
}

void gen_build_book(const struct gen_maker *k)
{
    struct gen_mesh paper = {.vertex_count = 0}, cover = {.vertex_count = 0};
    const float thick = gen_uniform(k->rng, 0.02f, 0.06f);
    const float arch = gen_uniform(k->rng, 0.0f, 0.06f);
    for (int side = -1; side <= 1; side += 2) {
        const struct pages p = {(float)side, thick, arch};
        const struct gen_grid grid = {24, 4, false, false, page_point, &p};
        gen_mesh_grid(&paper, &grid);
        gen_put_block(&cover, pbnds_vec3_make(0.24f, 0.006f, 0.32f), 0.002f,
                      pbnds_vec3_make(0.235f * (float)side, -0.01f, 0.0f), GEN_REST);
    }
    const int print = gen_make_material(k, GEN_PRINT);
    k->world->materials[print].double_sided = true;
    gen_finish(k, &paper, 60.0f, print);
    gen_finish(k, &cover, 35.0f, gen_make_material(k, GEN_ANY));
}

/* Plates, coins, tyres or discs on a pile that is not quite straight. */
void gen_build_discs(const struct gen_maker *k)
{
    struct gen_mesh parts[2] = {{.vertex_count = 0}, {.vertex_count = 0}};
    const int count = gen_between(k->rng, 3, 14), mode = gen_below(k->rng, 3);
    const float radius = gen_uniform(k->rng, 0.2f, 0.45f);
    const float half = 0.45f / (float)count;
    for (int i = 0; i < count; ++i) {
        struct gen_mesh one = {.vertex_count = 0};
        const float r = radius * gen_uniform(k->rng, mode == 2 ? 0.6f : 0.96f, 1.0f);
        const float dx = gen_uniform(k->rng, -0.03f, 0.03f);
        const float dz = gen_uniform(k->rng, -0.03f, 0.03f);
        const struct pbnds_vec3 at = {dx, half * (2.0f * (float)i + 1.0f), dz};
        if (mode == 0) {
            gen_torus(&one, r - half, half, gen_segments(k, 56));
        } else {
            gen_frustum(&one, r, r, 0.97f * half, 0.3f * half, gen_segments(k, 56));
        }
        gen_put(&parts[i % 2], &one, at, GEN_REST);
    }
    const int first = gen_make_material(k, GEN_ANY);
    gen_finish(k, &parts[0], 40.0f, first);
    gen_finish(k, &parts[1], 40.0f,
               gen_chance(k->rng, 0.6f) ? first : gen_make_material(k, GEN_ANY));
}

/* Caps on stalks. */
void gen_build_mushroom(const struct gen_maker *k)
{
    struct gen_mesh caps = {.vertex_count = 0}, stalks = {.vertex_count = 0};
    const int count = gen_chance(k->rng, 0.4f) ? 1 : gen_between(k->rng, 3, 9);
    const float round = gen_uniform(k->rng, 0.2f, 0.9f);
    for (int i = 0; i < count; ++i) {
        struct gen_mesh cap = {.vertex_count = 0};
        const float high = gen_uniform(k->rng, 0.2f, 0.7f) * (count == 1 ? 1.2f : 1.0f);
        const float wide = gen_uniform(k->rng, 0.12f, 0.32f);
        const float a = 2.4f * (float)i,
                    r = count == 1 ? 0.0f : 0.12f * sqrtf((float)i) + 0.05f;
        const struct pbnds_vec3 d = pbnds_normalize(
            pbnds_vec3_make(0.5f * r * cosf(a), 0.5f, 0.5f * r * sinf(a)));
        const struct pbnds_vec3 foot = {r * cosf(a), 0.0f, r * sinf(a)};
        const struct pbnds_vec3 top = pbnds_mad(foot, d, high);
        const struct pbnds_vec2 profile[9] = {{0.25f * wide, 0.0f},
                                              {0.8f * wide, -0.25f * round * wide},
                                              {wide, -0.2f * round * wide},
                                              {1.02f * wide, 0.0f},
                                              {0.92f * wide, 0.35f * round * wide},
                                              {0.7f * wide, 0.7f * round * wide},
                                              {0.4f * wide, 0.92f * round * wide},
                                              {0.15f * wide, 0.99f * round * wide},
                                              {0.0f, round * wide}};
        gen_lathe(&cap, profile, 9, gen_segments(k, 48), 0, 0.0f);
        gen_put(&caps, &cap, top, gen_aim(d));
        gen_put_frustum(&stalks, 0.3f * wide, 0.2f * wide, 0.5f * high,
                        pbnds_mad(foot, d, 0.5f * high), gen_aim(d), 24);
    }
    gen_finish(k, &caps, 60.0f, gen_make_material(k, GEN_FRUIT));
    gen_finish(k, &stalks, 60.0f, gen_make_material(k, GEN_ANY));
}
