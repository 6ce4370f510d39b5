#include "scenes/generator/deform.h"
#include "scenes/generator/objects.h"
#include "scenes/generator/shapes.h"

static void rounded_block(const struct gen_maker *k, struct gen_mesh *m)
{
    struct pbnds_vec3 half = gen_vec3(k->rng, 0.12f, 0.5f);
    if (gen_chance(k->rng, 0.3f)) half = pbnds_splat(0.4f);
    const float least = fminf(half.x, fminf(half.y, half.z));
    const float bevel =
        gen_chance(k->rng, 0.15f) ? 0.0f : gen_log_uniform(k->rng, 0.01f, 0.6f);
    gen_rounded_box(m, half, bevel * least, bevel > 0.2f ? 6 : 3, 10);
}

static void solid_of_revolution(const struct gen_maker *k, struct gen_mesh *m)
{
    const int segments = gen_segments(k, 72);
    const float bottom = gen_uniform(k->rng, 0.15f, 0.5f);
    const float half = gen_log_uniform(k->rng, 0.05f, 0.5f);
    const float bevel = gen_log_uniform(k->rng, 0.003f, 0.08f);
    const int kind = gen_below(k->rng, 4);
    const float top = kind == 0   ? 0.0f
                      : kind == 1 ? bottom * gen_uniform(k->rng, 0.2f, 0.9f)
                                  : bottom;
    gen_frustum(m, bottom, top, half, fminf(bevel, 0.5f * half), segments);
}

static void knot(const struct gen_maker *k, struct gen_mesh *m)
{
    static const int turns[6][2] = {{2, 3}, {3, 2}, {2, 5}, {3, 4}, {1, 3}, {1, 5}};
    const int *t = turns[gen_below(k->rng, 6)];
    const float swing = gen_uniform(k->rng, 0.12f, 0.17f);
    const float tube = gen_uniform(k->rng, 0.04f, 0.085f);
    const float flat =
        gen_chance(k->rng, 0.7f) ? 1.0f : gen_uniform(k->rng, 0.3f, 0.7f);
    gen_knot(m, t[0], t[1], 0.32f, swing, tube, flat, gen_segments(k, 48));
}

/* Fills m with one elementary solid. @return the crease angle for its normals */
static float elementary(const struct gen_maker *k, struct gen_mesh *m)
{
    static const float weights[8] = {3.0f, 3.0f, 2.0f, 1.2f, 1.0f, 1.5f, 0.8f, 0.6f};
    const int kind = gen_pick(k->rng, weights, 8);
    switch (kind) {
    case 0: {
        const struct pbnds_vec3 r = gen_chance(k->rng, 0.5f)
                                        ? pbnds_splat(0.45f)
                                        : gen_vec3(k->rng, 0.2f, 0.5f);
        gen_ellipsoid(m, r, gen_segments(k, 80));
        return 80.0f;
    }
    case 1:
        rounded_block(k, m);
        return 35.0f;
    case 2:
        solid_of_revolution(k, m);
        return 35.0f;
    case 3: {
        const float tube = gen_uniform(k->rng, 0.06f, 0.2f);
        gen_torus(m, 0.5f - tube, tube, gen_segments(k, 80));
        return 80.0f;
    }
    case 4: {
        const float radius = gen_uniform(k->rng, 0.1f, 0.3f);
        gen_capsule(m, radius, gen_uniform(k->rng, 0.1f, 0.4f), gen_segments(k, 64));
        return 80.0f;
    }
    case 5: {
        const float north = gen_log_uniform(k->rng, 0.15f, 2.2f);
        const float east = gen_log_uniform(k->rng, 0.15f, 2.2f);
        gen_superquadric(m, north, east, gen_vec3(k->rng, 0.25f, 0.5f),
                         gen_segments(k, 88));
        return 40.0f;
    }
    case 6:
        knot(k, m);
        return 80.0f;
    default: {
        const float tube = gen_uniform(k->rng, 0.03f, 0.06f);
        const float height = gen_uniform(k->rng, 0.5f, 0.9f);
        const float radius = gen_uniform(k->rng, 0.2f, 0.35f);
        gen_spring(m, radius, tube, height, gen_uniform(k->rng, 2.0f, 5.0f),
                   gen_segments(k, 36));
        return 80.0f;
    }
    }
}

static void random_deformation(const struct gen_maker *k, struct gen_mesh *m)
{
    const int kind = gen_below(k->rng, 10);
    const float amount = gen_uniform(k->rng, -1.0f, 1.0f);
    if (kind == 0) gen_twist(m, 3.0f * amount);
    if (kind == 1) gen_taper(m, 0.9f * amount);
    if (kind == 2) gen_bend(m, 1.2f * amount);
}

void gen_build_basic(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    const float crease = elementary(k, &m);
    random_deformation(k, &m);
    gen_mesh_shade(&m, crease);
    gen_object_part(k->world, &m, gen_make_material(k, GEN_ANY));
}

/* Catmull-Rom through random radii; the wall has a thickness and an open or closed top.
 */
static int vase_profile(struct pbnds_rng *r, struct pbnds_vec2 *profile)
{
    enum { KNOTS = 7, STEPS = 10 };
    float radius[KNOTS + 2];
    const float base = gen_uniform(r, 0.12f, 0.3f),
                wildness = gen_uniform(r, 0.2f, 0.9f);
    for (int i = 0; i < KNOTS + 2; ++i) {
        radius[i] = pbnds_clamp(base * (1.0f + wildness * gen_uniform(r, -1.0f, 1.2f)),
                                0.05f, 0.48f);
    }
    const bool hollow = gen_chance(r, 0.6f);
    const float wall = gen_uniform(r, 0.012f, 0.03f), half = gen_uniform(r, 0.3f, 0.5f);
    int n = 0;
    profile[n++] = (struct pbnds_vec2){0.0f, -half};
    const int outside = n;
    for (int i = 0; i <= (KNOTS - 1) * STEPS; ++i) {
        const int s = i / STEPS < KNOTS - 1 ? i / STEPS : KNOTS - 2;
        const float t = (float)(i - s * STEPS) / STEPS, *p = radius + s;
        const float x =
            p[1] + 0.5f * t *
                       (p[2] - p[0] +
                        t * (2.0f * p[0] - 5.0f * p[1] + 4.0f * p[2] - p[3] +
                             t * (3.0f * (p[1] - p[2]) + p[3] - p[0])));
        const float y = half * (2.0f * (float)i / ((KNOTS - 1) * STEPS) - 1.0f);
        profile[n++] = (struct pbnds_vec2){fmaxf(x, 0.04f), y};
    }
    const int rim = n - 1;
    if (hollow) {
        profile[n++] =
            (struct pbnds_vec2){profile[rim].x - 0.5f * wall, half + 0.4f * wall};
        for (int i = rim; i >= outside + 1; --i) {
            profile[n++] =
                (struct pbnds_vec2){fmaxf(profile[i].x - wall, 0.01f), profile[i].y};
        }
        profile[n++] = (struct pbnds_vec2){0.0f, profile[outside + 1].y};
    } else {
        profile[n++] = (struct pbnds_vec2){0.0f, half};
    }
    return n;
}

void gen_build_vase(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    struct pbnds_vec2 profile[160];
    const int n = vase_profile(k->rng, profile);
    const bool fluted = gen_chance(k->rng, 0.2f);
    const int flutes = gen_between(k->rng, 5, 16);
    const float depth = gen_uniform(k->rng, 0.05f, 0.2f);
    gen_lathe(&m, profile, n, gen_segments(k, fluted ? 128 : 72), fluted ? flutes : 0,
              depth);
    if (gen_chance(k->rng, 0.15f)) gen_twist(&m, gen_uniform(k->rng, -2.0f, 2.0f));
    gen_mesh_shade(&m, 45.0f);
    gen_object_part(k->world, &m, gen_make_material(k, GEN_ANY));
}

void gen_build_rock(const struct gen_maker *k)
{
    struct gen_mesh m = {.vertex_count = 0};
    const bool faceted = gen_chance(k->rng, 0.2f);
    gen_cube_sphere(&m, 0.38f,
                    faceted ? gen_between(k->rng, 3, 6) : gen_segments(k, 44));
    const enum gen_relief relief = (enum gen_relief)gen_below(k->rng, 3);
    const float frequency = gen_log_uniform(k->rng, 2.0f, 7.0f);
    const float height = gen_uniform(k->rng, 0.25f, 0.8f) / frequency;
    const int octaves = gen_between(k->rng, 1, 4);
    gen_displace(&m, relief, frequency, height, octaves,
                 (uint32_t)gen_below(k->rng, 1 << 20));
    random_deformation(k, &m);
    gen_mesh_shade(&m, faceted ? 5.0f : 180.0f);
    gen_object_part(k->world, &m, gen_make_material(k, GEN_ANY));
}
