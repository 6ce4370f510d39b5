/* Helmets and figures: the forms that characters have. */
#include "scenes/generator/objects.h"
#include "scenes/generator/sdf.h"
#include "scenes/generator/shapes.h"

static struct pbnds_vec3 v3(float x, float y, float z)
{
    return pbnds_vec3_make(x, y, z);
}

/* Opening at the front, rim below, ridge above. */
static void helmet_shell(const struct gen_maker *k, struct gen_sdf *s,
                         struct pbnds_vec3 radii, float wall)
{
    const float blend = 0.02f;
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, pbnds_splat(0.0f), radii, 0.0f);
    if (gen_chance(k->rng, 0.5f)) {
        (void)gen_sdf_add(s, GEN_SDF_BOX, v3(0.0f, 0.55f * radii.y, 0.0f),
                          v3(0.025f, 0.55f * radii.y, 1.02f * radii.z), 0.05f);
    }
    if (gen_chance(k->rng, 0.6f)) {
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.95f * radii.x, -0.05f, 0.0f),
                    v3(0.06f, 0.14f, 0.14f), 0.03f)
            ->mirror = true;
    }
    if (gen_chance(k->rng, 0.4f)) { /* horns or antennae */
        const float lift = gen_uniform(k->rng, 0.2f, 0.5f);
        gen_sdf_cone(s, v3(0.8f * radii.x, 0.2f, 0.0f),
                     v3(1.3f * radii.x, 0.2f + lift, 0.0f), 0.07f, 0.01f, 0.04f)
            ->mirror = true;
    }
    const struct pbnds_vec3 inner = pbnds_sub(radii, pbnds_splat(wall));
    gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, -0.01f, 0.0f), inner, blend)->combine =
        GEN_CUT;
    const float high = gen_uniform(k->rng, 0.08f, 0.16f);
    const float wide = radii.x * gen_uniform(k->rng, 0.55f, 0.85f);
    struct gen_sdf_op *op =
        gen_sdf_add(s, GEN_SDF_BOX, v3(0.0f, gen_uniform(k->rng, -0.1f, 0.05f), 0.5f),
                    v3(wide, high, 0.3f), blend);
    op->round = 0.07f;
    op->combine = GEN_CUT;
    op = gen_sdf_add(s, GEN_SDF_BOX, v3(0.0f, -0.3f - radii.y, 0.0f),
                     pbnds_vec3_make(1.0f, radii.y - 0.05f, 1.0f), blend);
    op->combine = GEN_CUT;
}

void gen_build_helmet(const struct gen_maker *k)
{
    struct gen_sdf s = {.count = 0}, visor = {.count = 0};
    const struct pbnds_vec3 radii = {gen_uniform(k->rng, 0.34f, 0.42f), 0.45f, 0.44f};
    helmet_shell(k, &s, radii, 0.05f);
    gen_form_part(k, &s, 88,
                  gen_make_material(k, gen_chance(k->rng, 0.5f) ? GEN_METAL : GEN_ANY));
    if (gen_chance(k->rng, 0.6f)) { /* dark glass inside the opening */
        (void)gen_sdf_add(&visor, GEN_SDF_ELLIPSOID, pbnds_splat(0.0f),
                          pbnds_sub(radii, pbnds_splat(0.035f)), 0.0f);
        gen_sdf_add(&visor, GEN_SDF_BOX, v3(0.0f, -0.02f, 0.4f), v3(0.38f, 0.26f, 0.3f),
                    0.01f)
            ->combine = GEN_INTERSECT;
        gen_form_part(k, &visor, 40, gen_make_material(k, GEN_PLAIN));
    }
    if (gen_chance(k->rng, 0.3f)) {
        struct gen_mesh inside = {.vertex_count = 0};
        gen_ellipsoid(&inside, pbnds_scale(radii, 0.75f), gen_segments(k, 40));
        gen_mesh_shade(&inside, 180.0f);
        gen_object_part(k->world, &inside, gen_make_material(k, GEN_SKIN));
    }
}

static struct pbnds_vec3 swing(struct pbnds_vec3 from, float length, float side,
                               float front)
{
    const struct pbnds_vec3 d = pbnds_normalize(v3(side, -1.0f, front));
    return pbnds_mad(from, d, length);
}

/* Two limbs of two bones each, posed apart from each other. */
static void limbs(const struct gen_maker *k, struct gen_sdf *s, struct pbnds_vec3 root,
                  float length, float thick, float spread)
{
    for (int side = -1; side <= 1; side += 2) {
        struct pbnds_vec3 a = root;
        a.x *= (float)side;
        const float out = gen_uniform(k->rng, 0.0f, spread) * (float)side;
        const float front = gen_uniform(k->rng, -0.6f, 0.6f);
        const float bend = gen_uniform(k->rng, -0.3f, 0.8f);
        const struct pbnds_vec3 b = swing(a, 0.5f * length, out, front);
        const struct pbnds_vec3 c =
            swing(b, 0.5f * length, 0.3f * out, front + bend * spread);
        (void)gen_sdf_cone(s, a, b, thick, 0.8f * thick, 0.04f);
        (void)gen_sdf_cone(s, b, c, 0.8f * thick, 0.6f * thick, 0.02f);
        (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(c.x, c.y, c.z + 0.03f),
                          v3(0.7f * thick, 0.6f * thick, 1.3f * thick), 0.03f);
    }
}

static void person(const struct gen_maker *k, struct gen_sdf *s)
{
    const float stout = gen_uniform(k->rng, 0.7f, 1.6f),
                head = gen_uniform(k->rng, 0.065f, 0.11f);
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, 0.2f, 0.0f),
                      v3(0.115f * stout, 0.15f, 0.075f * stout), 0.0f);
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, 0.03f, 0.0f),
                      v3(0.09f * stout, 0.09f, 0.07f * stout), 0.08f);
    (void)gen_sdf_cone(s, v3(0.0f, 0.3f, 0.0f), v3(0.0f, 0.38f, 0.0f), 0.04f, 0.035f,
                       0.04f);
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, 0.38f + head, 0.01f),
                      v3(0.8f * head, head, 0.9f * head), 0.02f);
    limbs(k, s, v3(0.11f * stout + 0.02f, 0.29f, 0.0f), 0.36f, 0.035f * sqrtf(stout),
          1.2f);
    limbs(k, s, v3(0.05f * stout, -0.02f, 0.0f), 0.46f, 0.05f * sqrtf(stout), 0.35f);
}

static void animal(const struct gen_maker *k, struct gen_sdf *s)
{
    const float high = gen_uniform(k->rng, 0.12f, 0.35f),
                long_ = gen_uniform(k->rng, 0.18f, 0.3f);
    const float thick = gen_uniform(k->rng, 0.08f, 0.17f),
                leg = gen_uniform(k->rng, 0.025f, 0.05f);
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, pbnds_splat(0.0f), v3(thick, thick, long_),
                      0.0f);
    for (int end = -1; end <= 1; end += 2) {
        const float z = 0.75f * long_ * (float)end,
                    lean = gen_uniform(k->rng, -0.06f, 0.06f);
        gen_sdf_cone(s, v3(0.6f * thick, -0.3f * thick, z),
                     v3(0.7f * thick, -high - thick, z + lean), leg * 1.3f, leg, 0.05f)
            ->mirror = true;
    }
    const float neck = gen_uniform(k->rng, 0.1f, 0.35f),
                skull_size = gen_uniform(k->rng, 0.06f, 0.12f);
    const struct pbnds_vec3 head = {0.0f, 0.5f * thick + neck, long_ + 0.4f * neck};
    (void)gen_sdf_cone(s, v3(0.0f, 0.3f * thick, 0.8f * long_), head, 0.6f * thick,
                       0.7f * skull_size, 0.06f);
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, head,
                      v3(0.8f * skull_size, skull_size, skull_size), 0.03f);
    const float muzzle = gen_uniform(k->rng, 0.5f, 2.0f) * skull_size;
    (void)gen_sdf_cone(
        s, head, pbnds_add(head, v3(0.0f, -0.3f * skull_size, skull_size + muzzle)),
        0.7f * skull_size, 0.4f * skull_size, 0.03f);
    const float ear = gen_uniform(k->rng, 0.5f, 2.5f) * skull_size;
    gen_sdf_cone(
        s, pbnds_add(head, v3(0.5f * skull_size, 0.7f * skull_size, 0.0f)),
        pbnds_add(head, v3(0.9f * skull_size, 0.7f * skull_size + ear, -0.02f)),
        0.3f * skull_size, 0.1f * skull_size, 0.02f)
        ->mirror = true;
    struct pbnds_vec3 tail = gen_vec3(k->rng, -1.0f, 1.0f);
    tail = v3(0.1f * tail.x, 0.22f * tail.y, -long_ - 0.18f - 0.13f * tail.z);
    (void)gen_sdf_cone(s, v3(0.0f, 0.2f * thick, -0.9f * long_), tail, 0.035f, 0.015f,
                       0.04f);
}

void gen_build_figure(const struct gen_maker *k)
{
    struct gen_sdf s = {.count = 0};
    if (gen_chance(k->rng, 0.5f)) {
        person(k, &s);
    } else {
        animal(k, &s);
    }
    if (gen_chance(k->rng, 0.3f)) {
        s.relief_frequency = 20.0f;
        s.relief = gen_uniform(k->rng, 0.005f, 0.02f);
    }
    gen_form_part(k, &s, 88, gen_make_material(k, GEN_ANY));
}
