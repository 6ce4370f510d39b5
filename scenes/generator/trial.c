#include "scenes/generator/trial.h"

#include "scenes/generator/shapes.h"

static const struct pbnds_vec4 REST = {0.0f, 0.0f, 0.0f, 1.0f};

static struct pbnds_vec3 v3(float x, float y, float z)
{
    return pbnds_vec3_make(x, y, z);
}

static void add(struct gen_world *w, struct gen_mesh *m,
                const struct gen_material *material, struct pbnds_vec3 at,
                struct pbnds_vec4 turn)
{
    const int object = gen_object_begin(w);
    gen_mesh_shade(m, 35.0f);
    gen_object_part(w, m, gen_world_material(w, material));
    gen_object_place(w, object, at, turn, 1.0f);
}

/* Rectangle whose front looks along `normal`, an axis. */
static void wall(struct gen_world *w, struct pbnds_vec3 at, struct pbnds_vec3 normal,
                 float half_x, float half_z, const struct gen_material *material)
{
    struct gen_mesh m = {.vertex_count = 0};
    struct pbnds_vec4 turn = REST;
    const struct pbnds_vec3 x = {1.0f, 0.0f, 0.0f}, z = {0.0f, 0.0f, 1.0f};
    if (normal.y < 0.0f) turn = gen_turn(x, PBNDS_PI);
    if (normal.z != 0.0f) turn = gen_turn(x, 0.5f * PBNDS_PI * normal.z);
    if (normal.x != 0.0f) turn = gen_turn(z, -0.5f * PBNDS_PI * normal.x);
    gen_plane(&m, half_x, half_z, 1);
    add(w, &m, material, at, turn);
}

static void ball(struct gen_world *w, struct pbnds_vec3 at, float radius,
                 const struct gen_material *material)
{
    struct gen_mesh m = {.vertex_count = 0};
    gen_ellipsoid(&m, pbnds_splat(radius), 64);
    add(w, &m, material, at, REST);
}

static void box(struct gen_world *w, struct pbnds_vec3 at, struct pbnds_vec3 half,
                float turn_deg, const struct gen_material *material)
{
    struct gen_mesh m = {.vertex_count = 0};
    gen_rounded_box(&m, half, 0.01f, 2, 1);
    add(w, &m, material, at,
        gen_turn(v3(0.0f, 1.0f, 0.0f), turn_deg * PBNDS_PI / 180.0f));
}

static struct gen_material glow(float r, float g, float b)
{
    struct gen_material m = gen_material_plain(pbnds_splat(0.0f), 0.0f, 1.0f);
    m.specular = 0.0f;
    m.emission = v3(r, g, b);
    return m;
}

void gen_emitters(struct gen_world *w)
{
    const struct gen_material white =
                                  gen_material_plain(v3(0.7f, 0.7f, 0.66f), 0.0f, 0.9f),
                              red = gen_material_plain(v3(0.6f, 0.07f, 0.06f), 0.0f,
                                                       0.9f),
                              green =
                                  gen_material_plain(v3(0.1f, 0.4f, 0.1f), 0.0f, 0.9f),
                              metal =
                                  gen_material_plain(v3(0.9f, 0.7f, 0.5f), 1.0f, 0.5f),
                              glaze =
                                  gen_material_plain(v3(0.1f, 0.2f, 0.5f), 0.0f, 0.3f),
                              panel = glow(3.5f, 3.1f, 2.5f),
                              lamp = glow(0.4f, 1.0f, 2.0f);
    wall(w, v3(0.0f, 0.0f, 0.0f), v3(0.0f, 1.0f, 0.0f), 1.0f, 1.0f, &white);
    wall(w, v3(0.0f, 2.0f, 0.0f), v3(0.0f, -1.0f, 0.0f), 1.0f, 1.0f, &white);
    wall(w, v3(0.0f, 1.0f, -1.0f), v3(0.0f, 0.0f, 1.0f), 1.0f, 1.0f, &white);
    wall(w, v3(0.0f, 1.0f, 1.0f), v3(0.0f, 0.0f, -1.0f), 1.0f, 1.0f, &white);
    wall(w, v3(-1.0f, 1.0f, 0.0f), v3(1.0f, 0.0f, 0.0f), 1.0f, 1.0f, &red);
    wall(w, v3(1.0f, 1.0f, 0.0f), v3(-1.0f, 0.0f, 0.0f), 1.0f, 1.0f, &green);
    wall(w, v3(0.0f, 1.98f, 0.0f), v3(0.0f, -1.0f, 0.0f), 0.6f, 0.6f, &panel);
    box(w, v3(-0.4f, 0.5f, -0.4f), v3(0.27f, 0.5f, 0.27f), 20.0f, &white);
    ball(w, v3(0.4f, 0.35f, -0.1f), 0.35f, &metal);
    ball(w, v3(-0.15f, 0.2f, 0.35f), 0.2f, &glaze);
    ball(w, v3(0.62f, 1.1f, -0.6f), 0.15f, &lamp);
    w->camera = (struct gen_camera){{0.0f, 1.0f, 0.98f}, {0.0f, 0.8f, 0.0f}, 1.3f};
}

static void still(struct gen_world *w)
{
    const struct gen_material floor = gen_material_plain(v3(0.5f, 0.48f, 0.45f), 0.0f,
                                                         0.8f),
                              clay =
                                  gen_material_plain(v3(0.6f, 0.3f, 0.2f), 0.0f, 0.6f),
                              steel =
                                  gen_material_plain(v3(0.6f, 0.6f, 0.62f), 1.0f, 0.6f),
                              paint =
                                  gen_material_plain(v3(0.1f, 0.3f, 0.5f), 0.0f, 0.4f);
    wall(w, v3(0.0f, 0.0f, 0.0f), v3(0.0f, 1.0f, 0.0f), 2.0f, 2.0f, &floor);
    wall(w, v3(0.0f, 1.5f, -1.2f), v3(0.0f, 0.0f, 1.0f), 2.0f, 1.5f, &floor);
    ball(w, v3(-0.7f, 0.35f, 0.0f), 0.35f, &clay);
    box(w, v3(0.1f, 0.3f, -0.3f), v3(0.25f, 0.3f, 0.25f), 30.0f, &paint);
    ball(w, v3(0.8f, 0.3f, 0.1f), 0.3f, &steel);
    w->camera = (struct gen_camera){{0.3f, 1.3f, 4.0f}, {0.0f, 0.55f, 0.0f}, 0.5f};
}

void gen_lamps(struct gen_world *w)
{
    still(w);
    w->lights[w->light_count++] = (struct gen_light){.name = "sun",
                                                     .kind = GEN_LIGHT_DIRECTIONAL,
                                                     .at = {2.0f, 3.0f, 1.5f},
                                                     .target = {0.0f, 0.0f, 0.0f},
                                                     .color = {1.0f, 0.9f, 0.75f},
                                                     .intensity = 0.8f};
    w->lights[w->light_count++] = (struct gen_light){.name = "bulb",
                                                     .kind = GEN_LIGHT_POINT,
                                                     .at = {-1.3f, 1.2f, 0.5f},
                                                     .color = {0.5f, 0.7f, 1.0f},
                                                     .intensity = 2.0f,
                                                     .range = 2.5f};
    w->lights[w->light_count++] = (struct gen_light){.name = "spot",
                                                     .kind = GEN_LIGHT_SPOT,
                                                     .at = {0.5f, 2.5f, 1.0f},
                                                     .target = {0.4f, 0.2f, -0.1f},
                                                     .color = {1.0f, 0.5f, 0.4f},
                                                     .intensity = 12.0f,
                                                     .inner = 0.15f,
                                                     .outer = 0.32f};
}

void gen_panes(struct gen_world *w)
{
    static const struct pbnds_vec3 tints[] = {
        {0.8f, 0.1f, 0.1f}, {0.1f, 0.7f, 0.2f}, {0.1f, 0.2f, 0.8f}};
    still(w);
    for (int i = 0; i < 3; ++i) {
        struct gen_material pane = gen_material_plain(tints[i], 0.0f, 0.3f);
        struct gen_mesh m = {.vertex_count = 0};
        pane.blend = pane.double_sided = true;
        pane.alpha = 0.25f * (float)(i + 1);
        gen_plane(&m, 0.45f, 0.4f, 1);
        const struct pbnds_vec4 upright =
                                    gen_turn(v3(1.0f, 0.0f, 0.0f), 0.5f * PBNDS_PI),
                                turn = gen_turn(v3(0.0f, 1.0f, 0.0f), 0.3f * (float)i);
        add(w, &m, &pane, v3(-0.5f + 0.45f * (float)i, 0.45f, 0.6f + 0.15f * (float)i),
            gen_quat_mul(turn, upright));
    }
}
