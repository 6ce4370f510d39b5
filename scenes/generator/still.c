#include "scenes/generator/still.h"

#include <stdlib.h>

#include "engine/core/color.h"
#include "scenes/generator/noise.h"
#include "scenes/generator/objects.h"
#include "scenes/generator/pattern.h"
#include "scenes/generator/shapes.h"

static const struct pbnds_vec3 UP = {0.0f, 1.0f, 0.0f};
static const struct pbnds_vec4 REST = {0.0f, 0.0f, 0.0f, 1.0f};

static struct pbnds_vec3 v3(float x, float y, float z)
{
    return pbnds_vec3_make(x, y, z);
}

/* One mesh with one plain or textured material, placed. */
static void add(struct gen_world *w, struct gen_mesh *m, float crease,
                const struct gen_material *material, struct pbnds_vec3 at,
                struct pbnds_vec4 turn, float scale)
{
    const int object = gen_object_begin(w);
    if (crease > 0.0f) gen_mesh_shade(m, crease);
    gen_object_part(w, m, gen_world_material(w, material));
    gen_object_place(w, object, at, turn, scale);
}

/* Floor that bends up into a wall behind. */
static struct pbnds_vec3 sweep_point(const void *context, float u, float v)
{
    (void)context;
    const float radius = 0.5f, front = 1.2f, arc = 0.5f * PBNDS_PI * radius,
                s = v * 4.0f;
    const float x = 4.0f * (u - 0.5f);
    if (s < front + 0.6f) return v3(x, 0.0f, front - s);
    const float turned = s - front - 0.6f;
    if (turned > arc) return v3(x, radius + turned - arc, -0.6f - radius);
    const float a = turned / radius;
    return v3(x, radius - radius * cosf(a), -0.6f - radius * sinf(a));
}

static void backdrop(struct gen_world *w)
{
    struct gen_mesh m = {.vertex_count = 0};
    const struct gen_grid grid = {1, 40, false, false, sweep_point, NULL};
    const struct gen_material paper =
        gen_material_plain(gen_srgb(0xb9b2a6), 0.0f, 0.85f);
    gen_mesh_grid(&m, &grid);
    add(w, &m, 60.0f, &paper, v3(0.0f, 0.0f, 0.0f), REST, 1.0f);
}

static void bust(struct gen_world *w)
{
    struct gen_sdf s = {.count = 0};
    struct gen_mesh head = {.vertex_count = 0}, plinth = {.vertex_count = 0};
    const struct gen_material marble =
        gen_material_plain(gen_srgb(0xe9e4da), 0.0f, 0.35f);
    const struct gen_material stone =
        gen_material_plain(gen_srgb(0x37393c), 0.0f, 0.15f);
    gen_mean_head(&s);
    /* the neck ends flat on the plinth */
    gen_sdf_add(&s, GEN_SDF_BOX, v3(0.0f, -1.2f, 0.0f), v3(1.0f, 0.48f, 1.0f), 0.02f)
        ->combine = GEN_CUT;
    gen_sdf_mesh(&s, v3(-0.42f, -0.76f, -0.5f), v3(0.42f, 0.52f, 0.5f), 44, &head);
    const struct pbnds_vec4 turn = gen_turn(UP, 0.5f);
    add(w, &head, 0.0f, &marble, v3(-0.3f, 0.42f, -0.25f), turn, 0.42f);
    gen_rounded_box(&plinth, v3(0.12f, 0.06f, 0.12f), 0.008f, 2, 1);
    add(w, &plinth, 35.0f, &stone, v3(-0.3f, 0.06f, -0.275f), turn, 1.0f);
}

static void vase(struct gen_world *w)
{
    static const struct pbnds_vec2 outline[] = {
        {0.055f, 0.0f},  {0.075f, 0.02f}, {0.11f, 0.09f}, {0.125f, 0.16f},
        {0.115f, 0.23f}, {0.08f, 0.30f},  {0.05f, 0.36f}, {0.042f, 0.40f},
        {0.052f, 0.44f}, {0.07f, 0.46f}};
    enum { N = sizeof outline / sizeof outline[0] };
    struct pbnds_vec2 profile[2 * N + 2];
    struct gen_mesh m = {.vertex_count = 0};
    int n = 0;
    profile[n++] = (struct pbnds_vec2){0.0f, 0.0f};
    for (int i = 0; i < N; ++i)
        profile[n++] = outline[i];
    for (int i = N - 1; i >= 1; --i) {
        profile[n++] = (struct pbnds_vec2){outline[i].x - 0.008f, outline[i].y};
    }
    profile[n++] = (struct pbnds_vec2){0.0f, outline[1].y};
    gen_lathe(&m, profile, n, 36, 0, 0.0f);
    const struct gen_material glaze =
        gen_material_plain(gen_srgb(0x1f5f8a), 0.0f, 0.12f);
    add(w, &m, 50.0f, &glaze, v3(0.3f, 0.0f, -0.3f), REST, 1.0f);
}

static void balls(struct gen_world *w)
{
    struct gen_mesh m = {.vertex_count = 0}, n = {.vertex_count = 0};
    const struct gen_material gold =
        gen_material_plain(v3(1.0f, 0.766f, 0.336f), 1.0f, 0.12f);
    const struct gen_material clay = gen_material_plain(gen_srgb(0xa9563c), 0.0f, 0.9f);
    gen_ellipsoid(&m, pbnds_splat(0.13f), 40);
    add(w, &m, 180.0f, &gold, v3(0.07f, 0.13f, 0.12f), REST, 1.0f);
    gen_torus(&n, 0.085f, 0.032f, 32);
    add(w, &n, 180.0f, &clay, v3(-0.22f, 0.032f, 0.25f), REST, 1.0f);
}

/* Wood: colour, roughness and slope from one pattern. */
static void box(struct gen_world *w)
{
    enum { SIZE = 128 };
    struct gen_mesh m = {.vertex_count = 0};
    struct gen_material wood = gen_material_plain(pbnds_splat(1.0f), 0.0f, 0.5f);
    const struct gen_pattern p = {GEN_CHECKER, 3, 0, 0.1f, 0.0f, 0.5f, 7};
    const struct pbnds_vec3 dark = gen_srgb(0x5a3a24), light = gen_srgb(0xd8b98a);
    uint8_t *rgb = malloc(3 * SIZE * SIZE);
    if (!rgb) {
        w->failed = true;
        return;
    }
    for (int i = 0; i < SIZE * SIZE; ++i) {
        const float u = ((float)(i % SIZE) + 0.5f) / SIZE,
                    v = ((float)(i / SIZE) + 0.5f) / SIZE;
        const float grain = gen_noise(v3(u * 4.0f, v * 32.0f, 0.5f), 32, 3);
        const struct pbnds_vec3 c = pbnds_scale(
            pbnds_lerp(dark, light, gen_pattern_value(&p, u, v)), 1.0f + 0.25f * grain);
        rgb[3 * i] = (uint8_t)lrintf(255.0f * pbnds_srgb_encode(c.x));
        rgb[3 * i + 1] = (uint8_t)lrintf(255.0f * pbnds_srgb_encode(c.y));
        rgb[3 * i + 2] = (uint8_t)lrintf(255.0f * pbnds_srgb_encode(c.z));
    }
    wood.color_image = gen_world_image(w, rgb, SIZE, SIZE);
    free(rgb);
    wood.repeat = 6.0f;
    gen_rounded_box(&m, pbnds_splat(0.1f), 0.008f, 2, 1);
    add(w, &m, 35.0f, &wood, v3(0.36f, 0.1f, 0.13f), gen_turn(UP, 0.55f), 1.0f);
}

struct wrap {
    float radius;
};

/* A cloth let fall over a ball that nobody sees. */
static struct pbnds_vec3 cloth_point(const void *context, float u, float v)
{
    const struct wrap *c = context;
    const float x = 2.0f * u - 1.0f, z = 1.0f - 2.0f * v, reach = 0.34f;
    const float r = sqrtf(x * x + z * z) * reach + 1e-6f, a = atan2f(z, x);
    const float top = c->radius * 0.5f * PBNDS_PI;
    const float bend = fminf(r, top) / c->radius;
    const float hang = fmaxf(0.0f, r - top);
    const float waves = (0.5f + 0.5f * sinf(5.0f * a + 1.3f * sinf(2.0f * a))) *
                        fminf(1.0f, 1.6f * r / reach) * 0.06f;
    const float fall = c->radius * cosf(bend) - hang;
    const float out = c->radius * sinf(bend) + waves + fmaxf(0.0f, -fall);
    return v3(out * cosf(a),
              fmaxf(fall, -c->radius + 0.004f + 0.1f * waves) + c->radius,
              out * sinf(a));
}

static void cloth(struct gen_world *w)
{
    struct gen_mesh m = {.vertex_count = 0};
    const struct wrap c = {0.1f};
    const struct gen_grid grid = {28, 28, false, false, cloth_point, &c};
    struct gen_material linen = gen_material_plain(gen_srgb(0x8c2f39), 0.0f, 0.8f);
    linen.double_sided = true;
    gen_mesh_grid(&m, &grid);
    add(w, &m, 180.0f, &linen, v3(0.02f, 0.0f, -0.28f), gen_turn(UP, 0.3f), 1.0f);
}

void gen_still_life(struct gen_world *w)
{
    backdrop(w);
    bust(w);
    vase(w);
    balls(w);
    box(w);
    cloth(w);
    w->camera =
        (struct gen_camera){{0.12f, 0.55f, 1.95f}, {0.04f, 0.27f, -0.15f}, 0.54f};
}

void gen_sphere_grid(struct gen_world *w)
{
    enum { COLUMNS = 5, ROWS = 5 };
    static const uint32_t colors[ROWS] = {0x9c2f2f, 0xe8e4dc, 0x3f6f8f, 0xd8b26a,
                                          0xd9dbde};
    for (int k = 0; k < COLUMNS * ROWS; ++k) {
        const int i = k % COLUMNS, j = k / COLUMNS;
        const float roughness = 0.05f + 0.95f * (float)i / (COLUMNS - 1);
        const float metallic = j < 2 ? 0.0f : j == 2 ? 0.5f : 1.0f;
        const struct gen_material material =
            gen_material_plain(gen_srgb(colors[j]), metallic, roughness);
        const struct pbnds_vec3 at = {(float)i - 0.5f * (COLUMNS - 1),
                                      (float)j - 0.5f * (ROWS - 1), 0.0f};
        const int object = gen_object_begin(w),
                  number = gen_world_material(w, &material);
        if (k == 0) {
            struct gen_mesh m = {.vertex_count = 0};
            gen_ellipsoid(&m, pbnds_splat(0.42f), 80);
            gen_mesh_shade(&m, 180.0f);
            gen_object_part(w, &m, number);
        } else {
            gen_object_twin(w, 0, number);
        }
        gen_object_place(w, object, at, REST, 1.0f);
    }
    w->camera = (struct gen_camera){{0.0f, 0.0f, 14.0f}, {0.0f, 0.0f, 0.0f}, 0.39f};
}
