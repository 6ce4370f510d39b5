/* Heads: the form that this renderer is about. Proportions vary about a mean; skin is
 * coloured by region; hair, beards, glasses and hats are parts of their own. */
#include "scenes/generator/assemble.h"
#include "scenes/generator/sdf.h"
#include "scenes/generator/shapes.h"

/* Proportions of one head; 1 is the mean. */
struct face {
    float width, depth, jaw, nose, brow, lips, eye, age;
    float cheek, neck, ear; /* sizes, likewise                            */
    float smile, open; /* how far the corners of the mouth are up, and it is open */
    bool plain;        /* no nostrils nor hollow ears: what few cells cannot carry */
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
    f.cheek = gen_uniform(r, 0.7f, 1.5f);
    f.neck = gen_uniform(r, 0.8f, 1.25f);
    f.ear = gen_uniform(r, 0.8f, 1.3f);
    f.smile = gen_uniform(r, -0.02f, 0.03f);
    f.open = gen_chance(r, 0.75f) ? 0.0f : gen_uniform(r, 0.005f, 0.03f);
    f.plain = false;
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
                v3(0.08f * f->cheek, 0.06f * f->cheek, 0.07f), 0.09f)
        ->mirror = true;
    (void)gen_sdf_cone(s, v3(0.0f, -0.28f, -0.1f), v3(0.0f, -0.72f, -0.13f),
                       0.16f * f->neck, 0.175f * f->neck, 0.1f);
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
    gen_sdf_cone(s, v3(0.0f, -0.228f, 0.335f * d),
                 v3(0.085f, -0.244f + f->smile, 0.29f * d), 0.024f * l, 0.01f * l,
                 0.025f)
        ->mirror = true;
    gen_sdf_cone(s, v3(0.0f, -0.268f - f->open, 0.325f * d),
                 v3(0.07f, -0.256f + f->smile, 0.292f * d), 0.028f * l, 0.012f * l,
                 0.03f)
        ->mirror = true;
    op =
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.0f, -0.246f - 0.5f * f->open, 0.36f * d),
                    v3(0.09f, (f->plain ? 0.009f : 0.005f) + f->open, 0.05f), 0.014f);
    op->combine = GEN_CUT;
}

static void ears(struct gen_sdf *s, const struct face *f)
{
    const struct pbnds_vec3 up = {0.0f, 1.0f, 0.0f};
    struct gen_sdf_op *ear =
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(0.335f * f->width, -0.01f, -0.03f),
                    v3(f->plain ? 0.038f : 0.028f, 0.105f * f->ear, 0.065f * f->ear),
                    f->plain ? 0.07f : 0.03f);
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

static void hair(const struct gen_maker *k, const struct face *f, int material)
{
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
    gen_form_part(k, &s, 56, material);
}

static void bust(const struct gen_maker *k)
{
    struct gen_sdf s = {.count = 0};
    const float wide = gen_uniform(k->rng, 0.4f, 0.55f);
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
                           .cheek = 1.0f,
                           .neck = 1.0f,
                           .ear = 1.0f,
                           .plain = true,
                           .eye_at = {0.122f, 0.03f, 0.262f}};
    head_form(s, &f, true);
}

/* A head without its flesh. */
static void bones(struct gen_sdf *s, const struct face *f)
{
    const float d = f->depth;
    struct gen_sdf_op *op =
        gen_sdf_add(s, GEN_SDF_ELLIPSOID, v3(f->eye_at.x, f->eye_at.y, 0.33f * d),
                    v3(0.08f, 0.075f, 0.14f), 0.03f);
    op->combine = GEN_CUT;
    op->mirror = true;
    op = gen_sdf_cone(s, v3(0.0f, -0.02f, 0.37f * d), v3(0.0f, -0.11f, 0.36f * d),
                      0.02f, 0.045f, 0.02f);
    op->combine = GEN_CUT;
    for (int i = 0; i < 5; ++i) { /* between the teeth */
        op = gen_sdf_add(s, GEN_SDF_BOX, v3(0.018f * (float)i, -0.24f, 0.34f * d),
                         v3(0.002f, 0.05f, 0.1f), 0.01f);
        op->combine = GEN_CUT;
        op->mirror = true;
    }
    op = gen_sdf_add(s, GEN_SDF_BOX, v3(0.0f, -0.24f, 0.3f * d),
                     v3(0.3f, 0.006f, 0.25f), 0.01f);
    op->combine = GEN_CUT;
}

/* ---- what a face is coloured like ---- */

struct complexion {
    const struct face *face;
    struct pbnds_vec3 lips, flush, brows, stubble;
    float beard; /* 0: shaved */
};

static float within(struct pbnds_vec3 p, struct pbnds_vec3 c, struct pbnds_vec3 r)
{
    const struct pbnds_vec3 q = {(p.x - c.x) / r.x, (p.y - c.y) / r.y,
                                 (p.z - c.z) / r.z};
    const float d = pbnds_length(q);
    return 1.0f - pbnds_clamp((d - 0.75f) / 0.4f, 0.0f, 1.0f);
}

static struct pbnds_vec3 paint_face(const void *context, struct pbnds_vec3 p)
{
    const struct complexion *c = context;
    const struct face *f = c->face;
    const float d = f->depth;
    const struct pbnds_vec3 q = {fabsf(p.x), p.y, p.z};
    struct pbnds_vec3 color = pbnds_splat(1.0f);
    const float cheek = within(q, v3(0.19f, -0.08f, 0.24f * d), v3(0.1f, 0.08f, 0.12f));
    const float tip = within(q, v3(0.0f, -0.11f, 0.42f * d), v3(0.06f, 0.05f, 0.1f));
    const float ear =
        within(q, v3(0.35f * f->width, 0.0f, -0.03f), v3(0.05f, 0.13f, 0.1f));
    color = pbnds_lerp(color, c->flush, fmaxf(cheek, fmaxf(tip, ear)));
    const float jaw = within(q, v3(0.0f, -0.38f, 0.15f * d), v3(0.3f, 0.2f, 0.3f)) +
                      within(q, v3(0.0f, -0.19f, 0.36f * d), v3(0.1f, 0.025f, 0.1f));
    color = pbnds_lerp(color, c->stubble, c->beard * fminf(jaw, 1.0f));
    const float mouth =
        within(q, v3(0.0f, -0.248f, 0.345f * d), v3(0.088f, 0.034f * f->lips, 0.09f));
    color = pbnds_lerp(color, c->lips, mouth);
    const float arch = 0.125f + 0.012f * f->brow - 1.1f * (q.x - 0.12f) * (q.x - 0.12f);
    const float brow =
        within(q, v3(0.115f * f->width, arch, 0.31f * d), v3(0.075f, 0.018f, 0.12f));
    return pbnds_lerp(color, c->brows, brow);
}

static struct complexion random_complexion(struct pbnds_rng *r, const struct face *f,
                                           struct pbnds_vec3 skin,
                                           struct pbnds_vec3 hair)
{
    struct complexion c = {.face = f};
    const float red = gen_uniform(r, 0.55f, 1.0f), made_up = gen_uniform(r, 0.3f, 1.0f);
    c.flush = v3(1.0f, 0.8f + 0.2f * red, 0.78f + 0.22f * red);
    c.lips = v3(0.95f, 0.5f + 0.35f * red, 0.5f + 0.35f * red);
    if (gen_chance(r, 0.25f)) c.lips = v3(0.9f * made_up, 0.15f, 0.2f);
    const struct pbnds_vec3 ratio = {
        pbnds_clamp(hair.x / fmaxf(skin.x, 0.02f), 0.05f, 1.0f),
        pbnds_clamp(hair.y / fmaxf(skin.y, 0.02f), 0.05f, 1.0f),
        pbnds_clamp(hair.z / fmaxf(skin.z, 0.02f), 0.05f, 1.0f)};
    c.brows = pbnds_lerp(pbnds_splat(1.0f), ratio, gen_uniform(r, 0.5f, 1.0f));
    c.stubble = pbnds_lerp(pbnds_splat(0.8f), ratio, 0.4f);
    c.beard = gen_chance(r, 0.6f) ? 0.0f : gen_uniform(r, 0.2f, 1.0f);
    return c;
}

/* ---- what is worn ---- */

static void beard(const struct gen_maker *k, const struct face *f, int material)
{
    struct gen_sdf s = {.count = 0};
    const float d = f->depth, length = gen_uniform(k->rng, 0.02f, 0.22f);
    gen_sdf_cone(&s, v3(0.0f, -0.41f, 0.22f * d), v3(0.0f, -0.43f - length, 0.2f * d),
                 0.12f, 0.05f, 0.0f);
    gen_sdf_cone(&s, v3(0.08f, -0.36f, 0.22f * d), v3(0.27f * f->width, -0.14f, -0.01f),
                 0.09f, 0.05f, 0.08f)
        ->mirror = true;
    gen_sdf_cone(&s, v3(0.015f, -0.2f, 0.37f * d), v3(0.1f, -0.23f, 0.3f * d), 0.025f,
                 0.015f, 0.02f)
        ->mirror = true;
    struct gen_sdf_op *op =
        gen_sdf_add(&s, GEN_SDF_ELLIPSOID, v3(0.0f, -0.25f, 0.4f * d),
                    v3(0.09f, 0.035f, 0.2f), 0.02f);
    op->combine = GEN_CUT;
    s.relief = gen_uniform(k->rng, 0.01f, 0.03f);
    s.relief_frequency = gen_uniform(k->rng, 12.0f, 30.0f);
    s.seed = (uint32_t)gen_below(k->rng, 1 << 20);
    gen_form_part(k, &s, 52, material);
}

static void glasses(const struct gen_maker *k, const struct face *f)
{
    enum { POINTS = 32 };
    struct gen_mesh rim = {.vertex_count = 0}, lens = {.vertex_count = 0};
    struct pbnds_vec3 points[POINTS], temple[4];
    const float wide = gen_uniform(k->rng, 0.075f, 0.105f);
    const float high = gen_uniform(k->rng, 0.05f, 0.09f);
    const float power = gen_uniform(k->rng, 0.4f, 1.0f);
    const float wire = gen_uniform(k->rng, 0.006f, 0.016f), z = 0.41f * f->depth;
    for (int side = -1; side <= 1; side += 2) {
        struct gen_mesh disc = {.vertex_count = 0};
        const float x = f->eye_at.x * (float)side;
        for (int i = 0; i < POINTS; ++i) {
            const float a = 2.0f * PBNDS_PI * (float)i / POINTS, c = cosf(a),
                        s = sinf(a);
            points[i] = v3(x + wide * copysignf(powf(fabsf(c), power), c),
                           f->eye_at.y + high * copysignf(powf(fabsf(s), power), s), z);
        }
        const struct gen_tube hoop = {.points = points,
                                      .count = POINTS,
                                      .closed = true,
                                      .thickness = wire,
                                      .flat = 1.0f,
                                      .sides = 8};
        gen_tube(&rim, &hoop);
        temple[0] = v3(x + wide * (float)side, f->eye_at.y + 0.02f, z);
        temple[1] = v3(0.35f * f->width * (float)side, 0.05f, 0.1f);
        temple[2] = v3(0.36f * f->width * (float)side, 0.05f, -0.05f);
        temple[3] = v3(0.35f * f->width * (float)side, -0.02f, -0.1f);
        const struct gen_tube bow = {
            .points = temple, .count = 4, .thickness = wire, .flat = 0.6f, .sides = 8};
        gen_tube(&rim, &bow);
        gen_superquadric(&disc, 1.0f, power, v3(wide, 0.006f, high), 32);
        gen_put(&lens, &disc, v3(x, f->eye_at.y, z), gen_turn(GEN_X, 0.5f * PBNDS_PI));
    }
    const struct pbnds_vec3 bridge[3] = {
        v3(wide - f->eye_at.x, f->eye_at.y + 0.01f, z),
        v3(0.0f, f->eye_at.y + 0.03f, z + 0.01f),
        v3(f->eye_at.x - wide, f->eye_at.y + 0.01f, z)};
    const struct gen_tube arch = {
        .points = bridge, .count = 3, .thickness = wire, .flat = 1.0f, .sides = 8};
    gen_tube(&rim, &arch);
    gen_finish(k, &rim, 60.0f, gen_make_material(k, GEN_PLAIN));
    if (gen_chance(k->rng, 0.5f)) { /* sunglasses: no light comes through */
        gen_finish(k, &lens, 60.0f, gen_make_material(k, GEN_GLAZE));
    }
    gen_mesh_free(&lens);
}

static void hat(const struct gen_maker *k, const struct face *f)
{
    struct gen_mesh m = {.vertex_count = 0}, shape = {.vertex_count = 0};
    const float r = 0.36f * fmaxf(f->width, 1.1f * f->depth) + 0.035f, y = 0.24f;
    const int kind = gen_below(k->rng, 4);
    const float high = gen_uniform(k->rng, 0.25f, 0.5f) + (kind == 3 ? 0.4f : 0.05f);
    const float brim = r * gen_uniform(k->rng, 1.2f, 1.9f);
    const float top = r * (kind == 3 ? 0.02f : gen_uniform(k->rng, 0.6f, 1.0f));
    if (kind == 0) { /* knitted cap */
        const struct pbnds_vec2 p[8] = {{0.97f * r, -0.06f}, {1.06f * r, -0.05f},
                                        {1.06f * r, 0.05f},  {r, 0.07f},
                                        {0.9f * r, 0.2f},    {0.6f * r, 0.31f},
                                        {0.3f * r, 0.355f},  {0.0f, 0.37f}};
        gen_lathe(&shape, p, 8, 96, gen_between(k->rng, 12, 30), 0.03f);
        if (gen_chance(k->rng, 0.5f))
            gen_put_ball(&m, v3(0.0f, y + 0.42f, -0.06f), pbnds_splat(0.08f), 24);
    } else { /* brim and crown */
        const struct pbnds_vec2 p[8] = {
            {0.95f * r, 0.0f},          {brim, -0.03f},      {brim, -0.015f},
            {1.02f * r, 0.02f},         {r, 0.06f},          {top, high},
            {0.7f * top, high + 0.02f}, {0.0f, high - 0.01f}};
        gen_lathe(&shape, p, 8, gen_segments(k, 80), 0, 0.0f);
    }
    gen_put(&m, &shape, v3(0.0f, y, -0.06f),
            gen_turn(GEN_X, gen_uniform(k->rng, -0.3f, 0.0f)));
    gen_finish(k, &m, 50.0f, gen_make_material(k, GEN_CLOTH));
}

static void worn(const struct gen_maker *k, const struct face *f, bool hairy,
                 int strands)
{
    const bool hatted = gen_chance(k->rng, 0.15f),
               short_sighted = gen_chance(k->rng, 0.18f);
    if (hairy && !hatted) hair(k, f, strands);
    if (hatted) hat(k, f);
    if (short_sighted) glasses(k, f);
    if (hairy && gen_chance(k->rng, 0.18f)) beard(k, f, strands);
}

void gen_build_head(const struct gen_maker *k)
{
    static const uint32_t colors[] = {0x17110d, 0x2c1b12, 0x4a3020, 0x7a5230, 0xb08d57,
                                      0x8c8c8c, 0xd9d5cd, 0x7a2f1a, 0x2f6fb0};
    struct gen_sdf s = {.count = 0};
    struct face f = random_face(k->rng);
    f.plain = k->detail < 0.7f;
    const bool statue = gen_chance(k->rng, 0.3f),
               skull_only = gen_chance(k->rng, 0.15f);
    const bool blind = statue && !gen_chance(k->rng, 0.3f);
    head_form(&s, &f, blind);
    if (blind && skull_only) bones(&s, &f);
    s.relief_frequency = 9.0f;
    s.seed = (uint32_t)gen_below(k->rng, 1 << 20);
    s.relief = 0.004f * f.age;
    const int skin = gen_make_material(k, statue ? GEN_ANY : GEN_SKIN);
    const struct pbnds_vec3 dye = gen_srgb(colors[gen_below(k->rng, 9)]);
    const struct gen_material strands =
        gen_material_plain(dye, 0.0f, gen_uniform(k->rng, 0.3f, 0.7f));
    gen_form_part(k, &s, 104, skin);
    if (!statue) {
        const struct complexion c =
            random_complexion(k->rng, &f, k->world->materials[skin].base_color, dye);
        gen_object_paint(k->world, paint_face, &c);
    }
    if (!blind) eyeballs(k, &f);
    const bool hairy = gen_chance(k->rng, statue ? 0.2f : 0.75f);
    const int strand_material = gen_world_material(k->world, &strands);
    if (!(blind && skull_only)) worn(k, &f, hairy, strand_material);
    if (gen_chance(k->rng, 0.5f)) bust(k);
}
