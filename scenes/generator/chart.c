/* The chart's scene; what stands where is in chart.h. */
#include "scenes/generator/chart.h"

#include <stdlib.h>

#include "scenes/generator/shapes.h"

static const struct pbnds_vec4 REST = {0.0f, 0.0f, 0.0f, 1.0f};
static const struct pbnds_vec3 RIGHT = {1.0f, 0.0f, 0.0f}, FRONT = {0.0f, 0.0f, 1.0f};

static struct pbnds_vec3 v3(float x, float y, float z)
{
    return pbnds_vec3_make(x, y, z);
}

static void add(struct gen_world *w, const char *name, struct gen_mesh *m,
                const struct gen_material *material, struct pbnds_vec3 at,
                struct pbnds_vec4 turn)
{
    const int object = gen_object_begin(w);
    gen_mesh_shade(m, 30.0f);
    gen_object_part(w, m, gen_world_material(w, material));
    gen_object_place(w, object, at, turn, 1.0f);
    w->objects[object].name = name;
}

/* Reflects base_color / pi and nothing else. */
static struct gen_material lambert(struct pbnds_vec3 color)
{
    struct gen_material m = gen_material_plain(color, 0.0f, 1.0f);
    m.specular = 0.0f;
    return m;
}

static struct gen_material unlit(struct pbnds_vec3 color)
{
    struct gen_material m = gen_material_plain(color, 0.0f, 1.0f);
    m.unlit = true;
    return m;
}

/* Square facing +z; u to the right, v downwards, as glTF has them. */
static void card(struct gen_mesh *m, float half)
{
    const struct pbnds_vec2 corners[] = {
        {-half, -half}, {half, -half}, {half, half}, {-half, half}};
    uint32_t i[4];
    for (int k = 0; k < 4; ++k) {
        const struct pbnds_vec2 uv = {0.5f + 0.5f * corners[k].x / half,
                                      0.5f - 0.5f * corners[k].y / half};
        i[k] = gen_mesh_vertex(m, v3(corners[k].x, corners[k].y, 0.0f), uv);
    }
    gen_mesh_quad(m, i[0], i[1], i[2], i[3]);
}

static void add_card(struct gen_world *w, const char *name,
                     const struct gen_material *material, struct pbnds_vec3 at,
                     float half)
{
    struct gen_mesh m = {.vertex_count = 0};
    card(&m, half);
    add(w, name, &m, material, at, REST);
}

/* ------------------------------------------------------------------------- axes */

/* Box along a stroke of a letter. */
static void stroke(struct gen_mesh *m, float x0, float y0, float x1, float y1)
{
    struct gen_mesh box = {.vertex_count = 0};
    const float length = hypotf(x1 - x0, y1 - y0);
    gen_rounded_box(&box, v3(0.5f * length + 0.015f, 0.015f, 0.015f), 0.005f, 1, 1);
    const struct pbnds_mat4 pose = pbnds_mat4_from_trs(
        v3(0.5f * (x0 + x1), 0.5f * (y0 + y1), 0.0f),
        gen_turn(FRONT, atan2f(y1 - y0, x1 - x0)), pbnds_splat(1.0f));
    gen_mesh_append(m, &box, &pose);
    gen_mesh_free(&box);
}

static void letter(struct gen_mesh *m, int axis)
{
    const float x = 0.06f, y = 0.09f;
    if (axis == 0) {
        stroke(m, -x, -y, x, y);
        stroke(m, -x, y, x, -y);
    } else if (axis == 1) {
        stroke(m, -x, y, 0.0f, 0.0f);
        stroke(m, x, y, 0.0f, 0.0f);
        stroke(m, 0.0f, 0.0f, 0.0f, -y);
    } else {
        stroke(m, -x, y, x, y);
        stroke(m, -x, -y, x, y);
        stroke(m, -x, -y, x, -y);
    }
}

static void arrow(struct gen_world *w, const char *name, int axis,
                  struct pbnds_vec3 origin)
{
    static const struct pbnds_vec3 ways[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const struct pbnds_vec4 turns[] = {gen_turn(FRONT, -0.5f * PBNDS_PI), REST,
                                       gen_turn(RIGHT, 0.5f * PBNDS_PI)};
    const struct gen_material paint =
        lambert(pbnds_mad(pbnds_splat(0.05f), ways[axis], 0.75f));
    struct gen_mesh shape = {.vertex_count = 0}, part = {.vertex_count = 0};
    struct gen_mesh sign = {.vertex_count = 0};
    gen_frustum(&shape, 0.025f, 0.025f, 0.225f, 0.0f, 24);
    const struct pbnds_mat4 lift =
        pbnds_mat4_from_trs(v3(0.0f, 0.225f, 0.0f), REST, pbnds_splat(1.0f));
    gen_mesh_transform(&shape, &lift);
    gen_frustum(&part, 0.06f, 0.0f, 0.075f, 0.0f, 24);
    const struct pbnds_mat4 tip =
        pbnds_mat4_from_trs(v3(0.0f, 0.525f, 0.0f), REST, pbnds_splat(1.0f));
    gen_mesh_append(&shape, &part, &tip);
    gen_mesh_free(&part);
    add(w, name, &shape, &paint, origin, turns[axis]);
    letter(&sign, axis);
    add(w, name, &sign, &paint, pbnds_mad(origin, ways[axis], 0.75f), REST);
}

/* ------------------------------------------------------------------------ cards */

static void color_cards(struct gen_world *w)
{
    static const struct pbnds_vec3 values[] = {
        {0.18f, 0.18f, 0.18f}, {0.8f, 0.8f, 0.8f},   {0.02f, 0.02f, 0.02f},
        {0.4f, 0.04f, 0.04f},  {0.04f, 0.4f, 0.04f}, {0.04f, 0.04f, 0.4f},
        {0.4f, 0.4f, 0.04f}};
    static const char *const lit[] = {"lit grey",  "lit white", "lit black", "lit red",
                                      "lit green", "lit blue",  "lit yellow"};
    static const char *const plain[] = {"unlit grey",  "unlit white", "unlit black",
                                        "unlit red",   "unlit green", "unlit blue",
                                        "unlit yellow"};
    for (int i = 0; i < 7; ++i) {
        const struct gen_material a = lambert(values[i]), b = unlit(values[i]);
        const float x = 0.32f * (float)(i - 3);
        add_card(w, lit[i], &a, v3(x, 0.75f, 0.0f), 0.14f);
        add_card(w, plain[i], &b, v3(x, 1.1f, 0.0f), 0.14f);
    }
}

enum { TEXELS = 64 };

static uint8_t code(float x)
{
    return (uint8_t)lrintf(255.0f * pbnds_clamp(x, 0.0f, 1.0f));
}

/* Red grows with u, green with v; a white F in the texel rows as a reader sees them,
 * and a white frame where u and v are least. */
static void uv_texel(int x, int y, uint8_t *rgb)
{
    const float u = ((float)x + 0.5f) / TEXELS, v = ((float)y + 0.5f) / TEXELS;
    const bool stem = u > 0.34f && u < 0.44f && v > 0.2f && v < 0.8f;
    const bool bar = u > 0.34f && v > 0.2f && v < 0.3f && u < 0.7f;
    const bool middle = u > 0.34f && v > 0.45f && v < 0.55f && u < 0.6f;
    const bool corner = u < 0.12f && v < 0.12f;
    const bool white = stem || bar || middle || corner;
    rgb[0] = white ? 255 : code(u);
    rgb[1] = white ? 255 : code(v);
    rgb[2] = white ? 255 : 0;
}

/* Sine of the greatest slope of the dome, and its radius in half widths of the card. */
static const float DOME_SINE = 0.8f, DOME_RADIUS = 0.75f;

/* glTF: x to the right (+u), y up (-v), z outwards. */
static void dome_texel(int x, int y, uint8_t *rgb)
{
    const float a = (2.0f * ((float)x + 0.5f) / TEXELS - 1.0f) / DOME_RADIUS,
                b = (1.0f - 2.0f * ((float)y + 0.5f) / TEXELS) / DOME_RADIUS;
    const float r2 = a * a + b * b;
    struct pbnds_vec3 n = {0.0f, 0.0f, 1.0f};
    if (r2 < 1.0f)
        n = v3(a * DOME_SINE, b * DOME_SINE, sqrtf(1.0f - r2 * DOME_SINE * DOME_SINE));
    rgb[0] = code(0.5f + 0.5f * n.x);
    rgb[1] = code(0.5f + 0.5f * n.y);
    rgb[2] = code(0.5f + 0.5f * n.z);
}

static int draw(struct gen_world *w, void (*texel)(int x, int y, uint8_t *rgb))
{
    uint8_t *rgb = malloc(3 * TEXELS * TEXELS);
    if (!rgb) {
        w->failed = true;
        return -1;
    }
    for (int i = 0; i < TEXELS * TEXELS; ++i)
        texel(i % TEXELS, i / TEXELS, rgb + 3 * i);
    const int image = gen_world_image(w, rgb, TEXELS, TEXELS);
    free(rgb);
    return image;
}

/* Cap of a sphere that rises from z = 0; u, v are polar. */
static struct pbnds_vec3 dome_point(const void *context, float u, float v)
{
    const float radius = *(const float *)context / DOME_SINE;
    const float top = asinf(DOME_SINE), theta = (1.0f - v) * top,
                phi = 2.0f * PBNDS_PI * u;
    return v3(radius * sinf(theta) * cosf(phi), radius * sinf(theta) * sinf(phi),
              radius * (cosf(theta) - cosf(top)));
}

static void texture_cards(struct gen_world *w)
{
    const float half = 0.3f, radius = DOME_RADIUS * half;
    struct gen_material uv = unlit(pbnds_splat(1.0f)),
                        bump = lambert(pbnds_splat(0.5f));
    const struct gen_material plain = bump;
    const struct gen_grid grid = {48, 16, true, false, dome_point, &radius};
    struct gen_mesh dome = {.vertex_count = 0};
    uv.color_image = draw(w, uv_texel);
    bump.normal_image = draw(w, dome_texel);
    add_card(w, "uv", &uv, v3(-0.75f, 1.65f, 0.0f), half);
    add_card(w, "normal map", &bump, v3(0.0f, 1.65f, 0.0f), half);
    add_card(w, "behind the dome", &plain, v3(0.75f, 1.65f, -0.001f), half);
    gen_mesh_grid(&dome, &grid);
    add(w, "dome", &dome, &plain, v3(0.75f, 1.65f, 0.0f), REST);
}

/* ------------------------------------------------------------------------ balls */

/* A first one makes the sphere, the others show it again. @return the part */
static int ball(struct gen_world *w, int part, const char *name, struct pbnds_vec3 at,
                float radius, const struct gen_material *material)
{
    const int object = gen_object_begin(w), number = gen_world_material(w, material);
    if (part < 0) {
        struct gen_mesh m = {.vertex_count = 0};
        gen_ellipsoid(&m, pbnds_splat(1.0f), 96);
        gen_mesh_shade(&m, 180.0f);
        part = w->part_count;
        gen_object_part(w, &m, number);
    } else {
        gen_object_twin(w, part, number);
    }
    gen_object_place(w, object, at, REST, radius);
    w->objects[object].name = name;
    return part;
}

static void balls(struct gen_world *w)
{
    static const char *const names[] = {"roughness 0", "roughness 1/4", "roughness 1/2",
                                        "roughness 3/4", "roughness 1"};
    const struct gen_material mirror =
        gen_material_plain(pbnds_splat(1.0f), 1.0f, 0.0f);
    const struct gen_material matte = lambert(pbnds_splat(0.5f));
    const int part = ball(w, -1, "mirror ball", v3(-1.5f, 1.55f, 0.0f), 0.35f, &mirror);
    (void)ball(w, part, "matte ball", v3(1.5f, 1.55f, 0.0f), 0.35f, &matte);
    for (int i = 0; i < 5; ++i) {
        const struct gen_material metal =
            gen_material_plain(pbnds_splat(0.9f), 1.0f, 0.25f * (float)i);
        (void)ball(w, part, names[i], v3(0.4f * (float)(i - 2), 0.35f, 0.0f), 0.17f,
                   &metal);
    }
}

/* Squares that look equally large from "front". */
static void depth_ladder(struct gen_world *w)
{
    static const float depths[] = {7.0f, 8.0f, 9.0f, 10.0f, 12.0f, 16.0f};
    static const char *const names[] = {"depth 7",  "depth 8",  "depth 9",
                                        "depth 10", "depth 12", "depth 16"};
    for (int i = 0; i < 6; ++i) {
        const struct gen_material m = unlit(pbnds_splat(0.1f + 0.15f * (float)i));
        const float s = depths[i] / 8.0f, z = w->front.eye.z - depths[i];
        const float x = 1.2f + 0.22f * (float)(i % 3), y = i < 3 ? 0.3f : 0.55f;
        add_card(w, names[i], &m, v3(x * s, 1.0f + (y - 1.0f) * s, z), 0.09f * s);
    }
}

void gen_chart(struct gen_world *w)
{
    const struct pbnds_vec3 origin = {-1.8f, 0.15f, 0.0f};
    w->front = (struct gen_camera){{0.0f, 1.0f, 8.0f}, {0.0f, 1.0f, 0.0f}, 0.32f};
    w->camera = (struct gen_camera){{2.6f, 2.4f, 6.6f}, {0.0f, 1.0f, 0.0f}, 0.38f};
    arrow(w, "+X", 0, origin);
    arrow(w, "+Y", 1, origin);
    arrow(w, "+Z", 2, origin);
    color_cards(w);
    texture_cards(w);
    balls(w);
    depth_ladder(w);
}
