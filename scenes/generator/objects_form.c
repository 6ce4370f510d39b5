/* Objects made by smooth unions and cuts: blobs, symmetric and carved things. */
#include "scenes/generator/objects.h"
#include "scenes/generator/sdf.h"

void gen_form_part(const struct gen_maker *k, const struct gen_sdf *s, int cells,
                   int material)
{
    struct gen_mesh m = {.vertex_count = 0};
    struct pbnds_vec3 lo, hi;
    gen_sdf_bounds(s, &lo, &hi);
    gen_sdf_mesh(s, lo, hi, gen_segments(k, cells), &m);
    gen_object_part(k->world, &m, material);
}

static void random_relief(const struct gen_maker *k, struct gen_sdf *s, float chance)
{
    s->relief_frequency = gen_log_uniform(k->rng, 4.0f, 16.0f);
    s->seed = (uint32_t)gen_below(k->rng, 1 << 20);
    const float strength = gen_uniform(k->rng, 0.05f, 0.35f);
    if (gen_chance(k->rng, chance)) s->relief = strength / s->relief_frequency;
}

void gen_build_blob(const struct gen_maker *k)
{
    struct gen_sdf s = {.count = 0};
    const int balls = gen_between(k->rng, 3, 9);
    const float blend = gen_log_uniform(k->rng, 0.04f, 0.35f);
    struct pbnds_vec3 at = pbnds_splat(0.0f);
    for (int i = 0; i < balls; ++i) { /* each near the one before: one piece, mostly */
        const struct pbnds_vec3 radii = gen_vec3(k->rng, 0.08f, 0.24f);
        struct gen_sdf_op *op = gen_sdf_add(&s, GEN_SDF_ELLIPSOID, at, radii, blend);
        op->turn = gen_rotation(k->rng);
        at = pbnds_add(at, gen_vec3(k->rng, -0.25f, 0.25f));
    }
    random_relief(k, &s, 0.35f);
    gen_form_part(k, &s, 56, gen_make_material(k, GEN_ANY));
}

/* One more part of a symmetric thing, touching a point of the body. */
static void attach(const struct gen_maker *k, struct gen_sdf *s, struct pbnds_vec3 body,
                   float blend)
{
    struct pbnds_vec3 at = gen_vec3(k->rng, -0.95f, 0.95f);
    at = pbnds_mul(at, body);
    const struct pbnds_vec3 size = gen_vec3(k->rng, 0.03f, 0.15f);
    const struct pbnds_vec4 turn = gen_rotation(k->rng);
    const int kind = gen_below(k->rng, 5);
    struct gen_sdf_op *op;
    if (kind == 0) {
        op = gen_sdf_add(s, GEN_SDF_BOX, at, size, blend);
        op->round = 0.3f * fminf(size.x, fminf(size.y, size.z));
    } else if (kind == 1) {
        const struct pbnds_vec3 ring = {0.1f + 0.5f * size.x, 0.015f + 0.2f * size.y,
                                        0.0f};
        op = gen_sdf_add(s, GEN_SDF_TORUS, at, ring, 0.3f * blend);
    } else if (kind == 2) {
        op = gen_sdf_add(s, GEN_SDF_ELLIPSOID, at, size, blend);
    } else { /* horns, legs, antennae */
        const struct pbnds_vec3 end =
            pbnds_add(pbnds_scale(at, 1.6f), gen_vec3(k->rng, -0.2f, 0.2f));
        op = gen_sdf_cone(s, at, end, size.x, size.x * gen_uniform(k->rng, 0.2f, 1.0f),
                          blend);
    }
    op->turn = turn;
    op->mirror = true;
}

void gen_build_symmetric(const struct gen_maker *k)
{
    struct gen_sdf s = {.count = 0};
    const struct pbnds_vec3 body = gen_vec3(k->rng, 0.15f, 0.35f);
    const float blend = gen_log_uniform(k->rng, 0.02f, 0.15f);
    const bool boxy = gen_chance(k->rng, 0.4f);
    struct gen_sdf_op *op = gen_sdf_add(&s, boxy ? GEN_SDF_BOX : GEN_SDF_ELLIPSOID,
                                        pbnds_splat(0.0f), body, 0.0f);
    op->round = 0.06f;
    const int parts = gen_between(k->rng, 3, 8);
    for (int i = 0; i < parts; ++i)
        attach(k, &s, body, blend);
    const int cuts = gen_between(k->rng, 0, 3);
    for (int i = 0; i < cuts; ++i) {
        const struct pbnds_vec3 at = pbnds_mul(gen_vec3(k->rng, -1.0f, 1.0f), body);
        const struct pbnds_vec3 size = gen_vec3(k->rng, 0.03f, 0.15f);
        op = gen_sdf_add(&s, GEN_SDF_ELLIPSOID, at, size, 0.03f);
        op->combine = GEN_CUT;
        op->mirror = true;
    }
    random_relief(k, &s, 0.2f);
    gen_form_part(k, &s, 60, gen_make_material(k, GEN_ANY));
}

static void drill(const struct gen_maker *k, struct gen_sdf *s)
{
    const float bore = gen_uniform(k->rng, 0.08f, 0.24f);
    const bool square = gen_chance(k->rng, 0.3f);
    for (int axis = 0; axis < 3; ++axis) {
        if (axis > 0 && !gen_chance(k->rng, 0.7f)) continue;
        const struct pbnds_vec3 x = {1.0f, 0.0f, 0.0f}, z = {0.0f, 0.0f, 1.0f};
        const struct pbnds_vec3 size = {bore, square ? 1.0f : 1.0f, bore};
        const struct pbnds_vec3 round_size = {bore, 1.0f, 0.0f};
        struct gen_sdf_op *op =
            gen_sdf_add(s, square ? GEN_SDF_BOX : GEN_SDF_CYLINDER, pbnds_splat(0.0f),
                        square ? size : round_size, 0.03f);
        op->combine = GEN_CUT;
        if (axis == 1) op->turn = gen_turn(x, 0.5f * PBNDS_PI);
        if (axis == 2) op->turn = gen_turn(z, 0.5f * PBNDS_PI);
    }
}

static void bite(const struct gen_maker *k, struct gen_sdf *s)
{
    const int bites = gen_between(k->rng, 2, 10);
    for (int i = 0; i < bites; ++i) {
        const struct pbnds_vec3 at = gen_vec3(k->rng, -0.45f, 0.45f);
        const float size = gen_uniform(k->rng, 0.08f, 0.22f);
        struct gen_sdf_op *op =
            gen_sdf_add(s, GEN_SDF_ELLIPSOID, at, pbnds_splat(size), 0.02f);
        op->combine = GEN_CUT;
    }
}

static void lace(const struct gen_maker *k, struct gen_sdf *s)
{
    /* no thinner than the cells of the mesh can show */
    const float thin = fmaxf(0.025f, 1.3f * 0.8f / (float)gen_segments(k, 72));
    const struct pbnds_vec3 size = {
        gen_uniform(k->rng, 0.3f, 0.55f) + 4.0f * (thin - 0.025f), thin, 0.0f};
    struct gen_sdf_op *op =
        gen_sdf_add(s, GEN_SDF_GYROID, gen_vec3(k->rng, -0.2f, 0.2f), size, 0.02f);
    op->combine = GEN_INTERSECT;
    op->turn = gen_rotation(k->rng);
}

static void shell(const struct gen_maker *k, struct gen_sdf *s)
{
    const float inner = 0.4f - gen_uniform(k->rng, 0.035f, 0.08f);
    struct gen_sdf_op *op =
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, pbnds_splat(0.0f), pbnds_splat(inner), 0.02f);
    op->combine = GEN_CUT;
    bite(k, s);
}

void gen_build_carved(const struct gen_maker *k)
{
    struct gen_sdf s = {.count = 0};
    const int kind = gen_below(k->rng, 4);
    const bool ball = kind == 3 || gen_chance(k->rng, 0.4f);
    const enum gen_sdf_kind body = ball                       ? GEN_SDF_ELLIPSOID
                                   : gen_chance(k->rng, 0.6f) ? GEN_SDF_BOX
                                                              : GEN_SDF_CYLINDER;
    struct gen_sdf_op *op =
        gen_sdf_add(&s, body, pbnds_splat(0.0f), pbnds_splat(0.4f), 0.0f);
    op->round = gen_uniform(k->rng, 0.03f, 0.12f);
    if (kind == 0) drill(k, &s);
    if (kind == 1) bite(k, &s);
    if (kind == 2) lace(k, &s);
    if (kind == 3) shell(k, &s);
    gen_form_part(k, &s, kind == 2 ? 72 : 60, gen_make_material(k, GEN_ANY));
}
