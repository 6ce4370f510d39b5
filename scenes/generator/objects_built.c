/* Buildings, vehicles and seats: what is put together on purpose. */
#include "scenes/generator/assemble.h"
#include "scenes/generator/shapes.h"

static struct pbnds_vec3 v3(float x, float y, float z)
{
    return pbnds_vec3_make(x, y, z);
}

/* ---- buildings ---- */

/* Rows of panes on the four sides, a little in front of the wall. */
static void put_windows(const struct gen_maker *k, struct gen_mesh *panes, float x,
                        float z, float low, float high)
{
    const int floors = gen_between(k->rng, 1, k->detail > 0.7f ? 9 : 5);
    const int across = gen_between(k->rng, 2, 6);
    const float fill_x = gen_uniform(k->rng, 0.3f, 0.9f);
    const float fill_y = gen_uniform(k->rng, 0.4f, 0.85f);
    const float step = (high - low) / (float)floors;
    for (int side = 0; side < 4; ++side) {
        const bool turned = side & 1;
        const float half = turned ? z : x, out = turned ? x : z;
        const float sign = side & 2 ? -1.0f : 1.0f, wide = half / (float)across;
        for (int i = 0; i < floors * across; ++i) {
            const float a =
                half * (2.0f * ((float)(i % across) + 0.5f) / (float)across - 1.0f);
            const float y = low + step * ((float)(i / across) + 0.5f);
            const struct pbnds_vec3 box = {turned ? 0.004f : wide * fill_x,
                                           0.5f * step * fill_y,
                                           turned ? wide * fill_x : 0.004f};
            gen_put_block(panes, box, 0.0f,
                          turned ? v3(sign * out, y, a) : v3(a, y, sign * out),
                          GEN_REST);
        }
    }
}

/* A prism over a rectangle: gable (ridge along x) or hip (ridge shorter). */
static void put_roof(struct gen_mesh *m, float x, float z, float y, float rise,
                     float ridge)
{
    const struct pbnds_vec3 p[6] = {v3(-x, y, -z),
                                    v3(x, y, -z),
                                    v3(x, y, z),
                                    v3(-x, y, z),
                                    v3(-ridge, y + rise, 0.0f),
                                    v3(ridge, y + rise, 0.0f)};
    static const int faces[][4] = {
        {3, 2, 5, 4}, {1, 0, 4, 5}, {2, 1, 5, 5}, {0, 3, 4, 4}, {0, 1, 2, 3}};
    for (size_t f = 0; f < sizeof faces / sizeof faces[0]; ++f) {
        uint32_t v[4];
        for (int i = 0; i < 4; ++i) {
            const struct pbnds_vec3 q = p[faces[f][i]];
            const struct pbnds_vec2 uv = {q.x + 0.3f * q.z, q.z - q.y};
            v[i] = gen_mesh_vertex(m, q, uv);
        }
        gen_mesh_quad(m, v[0], v[1], v[2], v[3]);
    }
}

void gen_build_building(const struct gen_maker *k)
{
    struct gen_mesh walls = {.vertex_count = 0}, panes = {.vertex_count = 0},
                    roof = {.vertex_count = 0};
    const bool tower = gen_chance(k->rng, 0.4f);
    const int blocks = tower ? gen_between(k->rng, 1, 4) : gen_between(k->rng, 1, 2);
    float x = gen_uniform(k->rng, 0.12f, 0.35f), z = gen_uniform(k->rng, 0.12f, 0.3f);
    float y = 0.0f;
    for (int i = 0; i < blocks; ++i) { /* each set back on the one below */
        const float high =
            (tower ? 0.9f : 0.45f) / (float)blocks * gen_uniform(k->rng, 0.6f, 1.2f);
        gen_put_block(&walls, v3(x, 0.5f * high, z), 0.0f,
                      v3(0.0f, y + 0.5f * high, 0.0f), GEN_REST);
        put_windows(k, &panes, x, z, y + 0.05f * high, y + 0.95f * high);
        gen_put_block(&roof, v3(1.04f * x, 0.012f, 1.04f * z), 0.0f,
                      v3(0.0f, y + high, 0.0f), GEN_REST);
        y += high;
        const float keep = gen_uniform(k->rng, 0.5f, 0.95f);
        if (i + 1 < blocks) {
            x *= keep;
            z *= keep;
        }
    }
    if (!tower || gen_chance(k->rng, 0.3f)) {
        const float rise = gen_uniform(k->rng, 0.1f, 0.4f);
        const float ridge = gen_chance(k->rng, 0.6f) ? x : gen_uniform(k->rng, 0.0f, x);
        put_roof(&roof, 1.1f * x, 1.12f * z, y, rise, 1.1f * ridge);
        if (gen_chance(k->rng, 0.5f)) {
            gen_put_block(&walls, v3(0.04f, 0.14f, 0.04f), 0.0f,
                          v3(0.5f * x, y + 0.6f * rise, 0.3f * z), GEN_REST);
        }
    }
    gen_finish(k, &walls, 30.0f, gen_make_material(k, GEN_GROUND));
    const bool lit = gen_chance(k->rng, 0.15f);
    gen_finish(k, &panes, 30.0f, gen_make_material(k, lit ? GEN_GLOW : GEN_GLAZE));
    gen_finish(k, &roof, 30.0f, gen_make_material(k, GEN_GROUND));
}

/* ---- vehicles ---- */

static void put_wheels(const struct gen_maker *k, struct gen_mesh *m, int axles,
                       float length, float wide, float radius)
{
    for (int i = 0; i < 2 * axles; ++i) {
        struct gen_mesh tyre = {.vertex_count = 0};
        const float t = axles > 1 ? (float)(i / 2) / (float)(axles - 1) : 0.5f;
        const struct pbnds_vec3 at = {length * (1.4f * t - 0.7f), radius,
                                      i % 2 ? wide : -wide};
        gen_frustum(&tyre, radius, radius, 0.35f * radius, 0.12f * radius,
                    gen_segments(k, 40));
        gen_put(m, &tyre, at, gen_turn(GEN_X, 0.5f * PBNDS_PI));
    }
}

static void car(const struct gen_maker *k)
{
    struct gen_mesh body = {.vertex_count = 0}, glass = {.vertex_count = 0},
                    wheels = {.vertex_count = 0};
    const float length = gen_uniform(k->rng, 0.3f, 0.48f);
    const float wide = gen_uniform(k->rng, 0.12f, 0.2f);
    const float radius = gen_uniform(k->rng, 0.05f, 0.1f);
    const float low = gen_uniform(k->rng, 0.04f, 0.09f);
    const float cabin = gen_uniform(k->rng, 0.06f, 0.16f);
    const float soft = gen_uniform(k->rng, 0.15f, 0.9f);
    const float back = length * gen_uniform(k->rng, -0.5f, 0.3f);
    const float roof = length * gen_uniform(k->rng, 0.25f, 0.5f);
    struct gen_mesh shell = {.vertex_count = 0}, top = {.vertex_count = 0};
    const int segments = gen_segments(k, 64);
    gen_superquadric(&shell, 0.5f * soft, 0.3f, v3(length, low + 0.02f, wide),
                     segments);
    gen_put(&body, &shell, v3(0.0f, radius + low, 0.0f), GEN_REST);
    gen_superquadric(&top, 0.8f * soft, 0.35f, v3(roof, cabin, 0.88f * wide), segments);
    gen_put(&glass, &top, v3(back, radius + 2.0f * low, 0.0f), GEN_REST);
    gen_put_block(&body, v3(0.75f * roof, 0.008f, 0.7f * wide), 0.004f,
                  v3(back, radius + 2.0f * low + cabin, 0.0f), GEN_REST);
    put_wheels(k, &wheels, gen_between(k->rng, 2, 3), length, 0.95f * wide, radius);
    gen_finish(k, &body, 40.0f, gen_make_material(k, GEN_ANY));
    gen_finish(k, &glass, 40.0f, gen_make_material(k, GEN_GLAZE));
    gen_finish(k, &wheels, 40.0f, gen_make_material(k, GEN_CLOTH));
}

/* Fuselage, wings and fins: aeroplanes, rockets, darts, fish. */
static void plane(const struct gen_maker *k)
{
    struct gen_mesh body = {.vertex_count = 0}, wings = {.vertex_count = 0};
    const float thick = gen_uniform(k->rng, 0.04f, 0.12f);
    const struct pbnds_vec2 profile[9] = {
        {0.0f, -0.48f},         {0.25f * thick, -0.47f}, {0.6f * thick, -0.3f},
        {0.95f * thick, -0.1f}, {thick, 0.1f},           {0.95f * thick, 0.25f},
        {0.7f * thick, 0.38f},  {0.35f * thick, 0.46f},  {0.0f, 0.49f}};
    gen_lathe(&body, profile, 9, gen_segments(k, 48), 0, 0.0f);
    const int fins = gen_chance(k->rng, 0.6f) ? 2 : gen_between(k->rng, 3, 5);
    const float span = gen_uniform(k->rng, 0.15f, 0.45f),
                at = gen_uniform(k->rng, -0.3f, 0.1f);
    const float chord = gen_uniform(k->rng, 0.05f, 0.12f);
    for (int i = 0; i < fins; ++i) {
        const struct pbnds_vec4 q =
            gen_turn(GEN_Y, 2.0f * PBNDS_PI * (float)i / (float)fins);
        const struct pbnds_vec4 swept = gen_quat_mul(q, gen_turn(GEN_Z, -0.25f));
        const struct pbnds_vec3 middle = gen_rotate(q, v3(0.5f * span, at, 0.0f));
        gen_put_block(&wings, v3(0.5f * span + 0.3f * thick, chord, 0.008f), 0.006f,
                      middle, swept);
    }
    for (int i = 0; i < 3; ++i) {
        const struct pbnds_vec4 q = gen_turn(GEN_Y, 0.5f * PBNDS_PI * (float)i);
        gen_put_block(&wings, v3(0.09f, 0.035f, 0.006f), 0.004f,
                      gen_rotate(q, v3(0.09f, -0.42f, 0.0f)), q);
    }
    gen_finish(k, &body, 50.0f, gen_make_material(k, GEN_ANY));
    gen_finish(k, &wings, 30.0f, gen_make_material(k, GEN_ANY));
}

void gen_build_vehicle(const struct gen_maker *k)
{
    if (gen_chance(k->rng, 0.6f)) {
        car(k);
    } else {
        plane(k);
    }
}

/* ---- seats ---- */

void gen_build_seat(const struct gen_maker *k)
{
    struct gen_mesh soft = {.vertex_count = 0}, hard = {.vertex_count = 0};
    const int places = gen_between(k->rng, 1, 3);
    const float wide = 0.2f * (float)places, deep = gen_uniform(k->rng, 0.18f, 0.26f);
    const float thick = gen_uniform(k->rng, 0.04f, 0.1f);
    const float leg = gen_uniform(k->rng, 0.02f, 0.22f);
    const float back = gen_uniform(k->rng, 0.12f, 0.35f);
    const float arm =
        gen_chance(k->rng, 0.6f) ? gen_uniform(k->rng, 0.03f, 0.07f) : 0.0f;
    const float lean = gen_uniform(k->rng, -0.25f, 0.0f),
                round = gen_uniform(k->rng, 0.2f, 0.9f);
    for (int i = 0; i < places; ++i) {
        struct gen_mesh cushion = {.vertex_count = 0};
        const float x = 0.4f * ((float)i - 0.5f * (float)(places - 1));
        gen_rounded_box(&cushion, v3(0.195f, thick, deep), round * thick, 5, 4);
        gen_put(&soft, &cushion, v3(x, leg + thick, 0.0f), GEN_REST);
        gen_rounded_box(&cushion, v3(0.195f, back, 0.8f * thick), 0.7f * round * thick,
                        5, 4);
        gen_put(&soft, &cushion, v3(x, leg + 1.6f * thick + back, -0.9f * deep),
                gen_turn(GEN_X, lean));
    }
    for (int side = -1; arm > 0.0f && side <= 1; side += 2) {
        struct gen_mesh rest = {.vertex_count = 0};
        gen_rounded_box(&rest, v3(arm, 0.9f * thick + 0.08f, deep), 0.6f * round * arm,
                        5, 4);
        gen_put(&soft, &rest, v3((wide + arm) * (float)side, leg + thick + 0.08f, 0.0f),
                GEN_REST);
    }
    for (int i = 0; i < 4; ++i) {
        gen_put_frustum(&hard, 0.012f, 0.02f, 0.5f * leg,
                        v3((i & 1 ? 0.9f : -0.9f) * wide, 0.5f * leg,
                           (i & 2 ? 0.85f : -0.85f) * deep),
                        GEN_REST, 16);
    }
    gen_finish(k, &soft, 60.0f,
               gen_make_material(k, gen_chance(k->rng, 0.7f) ? GEN_CLOTH : GEN_ANY));
    gen_finish(k, &hard, 40.0f, gen_make_material(k, GEN_ANY));
}
