/* Heads, helmets and figures: the forms that faces and characters have. */
#include "scenes/generator/objects.h"
#include "scenes/generator/sdf.h"
#include "scenes/generator/shapes.h"

/* Proportions of one head; 1 is the mean. */
struct face {
    float width, depth, jaw, nose, brow, lips, eye, age;
    bool plain; /* no nostrils nor hollow ears: what few cells cannot carry */
    struct pbnds_vec3 eye_at;
};

static struct face random_face(struct pbnds_rng *r)
{
    struct face f;
    f.width = gen_uniform(r, 0.88f, 1.1f);
    f.depth = gen_uniform(r, 0.92f, 1.08f);
    f.jaw = gen_uniform(r, 0.75f, 1.25f);
    f.nose = gen_uniform(r, 0.7f, 1.35f);
    f.brow = gen_uniform(r, 0.5f, 1.4f);
    f.lips = gen_uniform(r, 0.6f, 1.4f);
    f.eye = gen_uniform(r, 0.85f, 1.2f);
    f.age = gen_uniform(r, 0.0f, 1.0f);
    f.eye_at = pbnds_vec3_make(0.122f * f.width, 0.03f, 0.262f * f.depth);
    return f;
}

static struct pbnds_vec3 v3(float x, float y, float z)
{
    return pbnds_vec3_make(x, y, z);
}

static void skull(struct gen_sdf *s, const struct face *f)
{
    const float w = f->width, d = f->depth;
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, 0.12f, -0.06f),
                      v3(0.335f * w, 0.375f, 0.41f * d), 0.0f);
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, -0.17f, 0.07f * d),
                      v3(0.25f * w, 0.32f, 0.265f * d), 0.14f);
    (void)gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, -0.43f, 0.2f * d),
                      v3(0.095f * f->jaw, 0.075f, 0.085f), 0.11f);
    gen_sdf_cone(s, v3(0.215f * w * f->jaw, -0.2f, 0.0f),
                 v3(0.07f * f->jaw, -0.42f, 0.19f * d), 0.07f, 0.06f, 0.09f)
        ->mirror = true;
    gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.17f * w, -0.085f, 0.225f * d),
                v3(0.08f, 0.06f, 0.07f), 0.09f)
        ->mirror = true;
    (void)gen_sdf_cone(s, v3(0.0f, -0.28f, -0.1f), v3(0.0f, -0.72f, -0.13f), 0.16f,
                       0.175f, 0.1f);
}

static void eye_region(struct gen_sdf *s, const struct face *f)
{
    const struct pbnds_vec3 e = f->eye_at;
    gen_sdf_cone(s, v3(0.035f, 0.105f, 0.335f * f->depth),
                 v3(0.19f * f->width, 0.115f, 0.245f * f->depth), 0.03f * f->brow,
                 0.022f * f->brow, 0.07f)
        ->mirror = true;
    struct gen_sdf_op *socket =
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(e.x, e.y, e.z + 0.09f),
                    v3(0.075f * f->eye, 0.052f * f->eye, 0.06f), 0.06f);
    socket->combine = GEN_CUT;
    socket->mirror = true;
    /* lids: a ball a little larger than the eye, opened by an almond */
    gen_sdf_add(s, GEN_SDF_ELLIPSOID, e, pbnds_splat(0.072f * f->eye), 0.03f)->mirror =
        true;
    struct gen_sdf_op *slit =
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(e.x, e.y, e.z + 0.07f),
                    v3(0.056f * f->eye, 0.026f * f->eye, 0.06f), 0.012f);
    slit->combine = GEN_CUT;
    slit->mirror = true;
}

static void nose_and_mouth(struct gen_sdf *s, const struct face *f)
{
    const float d = f->depth, n = f->nose, l = f->lips;
    (void)gen_sdf_cone(s, v3(0.0f, 0.09f, 0.325f * d),
                       v3(0.0f, -0.1f, 0.36f * d + 0.055f * n), 0.028f, 0.042f * n,
                       0.05f);
    gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.042f * n, -0.118f, 0.365f * d),
                v3(0.03f, 0.026f, 0.035f), f->plain ? 0.07f : 0.03f)
        ->mirror = true;
    struct gen_sdf_op *op;
    if (!f->plain) {
        op = gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.022f * n, -0.148f, 0.385f * d),
                         v3(0.012f, 0.014f, 0.018f), 0.015f);
        op->combine = GEN_CUT;
        op->mirror = true;
    }
    gen_sdf_cone(s, v3(0.0f, -0.228f, 0.335f * d), v3(0.085f, -0.244f, 0.29f * d),
                 0.024f * l, 0.01f * l, 0.025f)
        ->mirror = true;
    gen_sdf_cone(s, v3(0.0f, -0.268f, 0.325f * d), v3(0.07f, -0.256f, 0.292f * d),
                 0.028f * l, 0.012f * l, 0.03f)
        ->mirror = true;
    op = gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, -0.246f, 0.36f * d),
                     v3(0.09f, f->plain ? 0.009f : 0.005f, 0.05f), 0.014f);
    op->combine = GEN_CUT;
}

static void ears(struct gen_sdf *s, const struct face *f)
{
    const struct pbnds_vec3 up = {0.0f, 1.0f, 0.0f};
    struct gen_sdf_op *ear = gen_sdf_add(
        s, GEN_SDF_ELLIPSOID, v3(0.335f * f->width, -0.01f, -0.03f),
        v3(f->plain ? 0.038f : 0.028f, 0.105f, 0.065f), f->plain ? 0.07f : 0.03f);
    ear->turn = gen_turn(up, -0.4f);
    ear->mirror = true;
    if (f->plain) return;
    struct gen_sdf_op *hollow =
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.365f * f->width, 0.0f, -0.02f),
                    v3(0.018f, 0.065f, 0.035f), 0.02f);
    hollow->turn = gen_turn(up, -0.4f);
    hollow->combine = GEN_CUT;
    hollow->mirror = true;
}

static void eyeballs(const struct gen_maker *k, const struct face *f)
{
    struct gen_mesh white = {.vertex_count = 0}, iris = {.vertex_count = 0};
    static const uint32_t colors[] = {0x3b2415, 0x5a3a1c, 0x4f6b8a, 0x4a6b4a, 0x1d1410};
    const float radius = 0.066f * f->eye;
    for (int side = -1; side <= 1; side += 2) {
        struct gen_mesh ball = {.vertex_count = 0}, disc = {.vertex_count = 0};
        struct pbnds_vec3 at = f->eye_at;
        at.x *= (float)side;
        const struct pbnds_vec4 none = {0.0f, 0.0f, 0.0f, 1.0f};
        struct pbnds_mat4 t = pbnds_mat4_from_trs(at, none, pbnds_splat(1.0f));
        gen_ellipsoid(&ball, pbnds_splat(radius), gen_segments(k, 32));
        gen_mesh_append(&white, &ball, &t);
        gen_ellipsoid(&disc, v3(0.45f * radius, 0.45f * radius, 0.12f * radius),
                      gen_segments(k, 24));
        at.z += 0.91f * radius;
        t = pbnds_mat4_from_trs(at, none, pbnds_splat(1.0f));
        gen_mesh_append(&iris, &disc, &t);
        gen_mesh_free(&ball);
        gen_mesh_free(&disc);
    }
    gen_mesh_shade(&white, 180.0f);
    gen_mesh_shade(&iris, 180.0f);
    const struct gen_material sclera =
        gen_material_plain(gen_srgb(0xe6dcd2), 0.0f, gen_uniform(k->rng, 0.05f, 0.2f));
    const struct gen_material dark =
        gen_material_plain(gen_srgb(colors[gen_below(k->rng, 5)]), 0.0f, 0.1f);
    gen_object_part(k->world, &white, gen_world_material(k->world, &sclera));
    gen_object_part(k->world, &iris, gen_world_material(k->world, &dark));
}

static void hair(const struct gen_maker *k, const struct face *f)
{
    static const uint32_t colors[] = {0x17110d, 0x2c1b12, 0x4a3020, 0x7a5230,
                                      0xb08d57, 0x8c8c8c, 0xd9d5cd, 0x7a2f1a};
    struct gen_sdf s = {.count = 0};
    const float w = f->width, d = f->depth, thick = gen_uniform(k->rng, 0.02f, 0.07f);
    (void)gen_sdf_add(&s, GEN_SDF_ELLIPSOID, v3(0.0f, 0.13f, -0.07f),
                      v3(0.335f * w + thick, 0.375f + thick, 0.41f * d + thick), 0.0f);
    if (gen_chance(k->rng, 0.4f)) { /* long at the back */
        const float fall = gen_uniform(k->rng, -0.7f, -0.3f);
        (void)gen_sdf_cone(&s, v3(0.0f, 0.0f, -0.25f), v3(0.0f, fall, -0.3f), 0.27f,
                           0.2f, 0.1f);
    }
    if (gen_chance(k->rng, 0.15f)) { /* bun */
        (void)gen_sdf_add(&s, GEN_SDF_ELLIPSOID, v3(0.0f, 0.45f, -0.3f),
                          pbnds_splat(0.16f), 0.05f);
    }
    const float line = gen_uniform(k->rng, 0.2f, 0.32f);
    struct gen_sdf_op *op =
        gen_sdf_add(&s, GEN_SDF_ELLIPSOID, v3(0.0f, line - 0.52f, 0.3f),
                    v3(0.36f * w, 0.5f, 0.36f), 0.04f);
    op->combine = GEN_CUT;
    op = gen_sdf_add(&s, GEN_SDF_BOX, v3(0.0f, -0.65f, 0.3f), v3(1.0f, 0.6f, 0.42f),
                     0.04f);
    op->combine = GEN_CUT;
    s.relief = gen_uniform(k->rng, 0.015f, 0.05f);
    s.relief_frequency = gen_uniform(k->rng, 6.0f, 18.0f);
    s.seed = (uint32_t)gen_below(k->rng, 1 << 20);
    const struct pbnds_vec3 color = gen_srgb(colors[gen_below(k->rng, 8)]);
    const struct gen_material m =
        gen_material_plain(color, 0.0f, gen_uniform(k->rng, 0.35f, 0.7f));
    gen_form_part(k, &s, 56, gen_world_material(k->world, &m));
}

static void bust(const struct gen_maker *k, const struct face *f)
{
    struct gen_sdf s = {.count = 0};
    const float wide = gen_uniform(k->rng, 0.4f, 0.55f);
    (void)f;
    gen_sdf_cone(&s, v3(0.0f, -0.82f, -0.13f), v3(wide, -0.93f, -0.14f), 0.2f, 0.15f,
                 0.1f)
        ->mirror = true;
    (void)gen_sdf_add(&s, GEN_SDF_ELLIPSOID, v3(0.0f, -1.0f, -0.1f),
                      v3(0.42f, 0.24f, 0.22f), 0.12f);
    struct gen_sdf_op *op = gen_sdf_add(&s, GEN_SDF_BOX, v3(0.0f, -1.6f, 0.0f),
                                        v3(2.0f, 0.5f, 2.0f), 0.03f);
    op->combine = GEN_CUT;
    gen_form_part(k, &s, 44, gen_make_material(k, GEN_CLOTH));
}

/* A statue's eyes are of one piece with it. */
static void head_form(struct gen_sdf *s, const struct face *f, bool statue)
{
    skull(s, f);
    eye_region(s, f);
    nose_and_mouth(s, f);
    ears(s, f);
    if (statue) {
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, f->eye_at, pbnds_splat(0.066f * f->eye), 0.0f)
            ->mirror = true;
    }
}

void gen_mean_head(struct gen_sdf *s)
{
    const struct face f = {.width = 1.0f,
                           .depth = 1.0f,
                           .jaw = 1.0f,
                           .nose = 1.0f,
                           .brow = 1.0f,
                           .lips = 1.0f,
                           .eye = 1.0f,
                           .plain = true,
                           .eye_at = {0.122f, 0.03f, 0.262f}};
    head_form(s, &f, true);
}

void gen_build_head(const struct gen_maker *k)
{
    struct gen_sdf s = {.count = 0};
    struct face f = random_face(k->rng);
    f.plain = k->detail < 0.7f;
    const bool statue = gen_chance(k->rng, 0.35f);
    const bool blind = statue && !gen_chance(k->rng, 0.3f);
    head_form(&s, &f, blind);
    s.relief_frequency = 9.0f;
    s.seed = (uint32_t)gen_below(k->rng, 1 << 20);
    s.relief = 0.004f * f.age;
    gen_form_part(k, &s, 96, gen_make_material(k, statue ? GEN_ANY : GEN_SKIN));
    if (!blind) eyeballs(k, &f);
    if (gen_chance(k->rng, statue ? 0.2f : 0.75f)) hair(k, &f);
    if (gen_chance(k->rng, 0.5f)) bust(k, &f);
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
