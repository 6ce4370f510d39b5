#include "scenes/generator/assemble.h"

#include "scenes/generator/shapes.h"

#define TURN (2.0f * PBNDS_PI)

const struct pbnds_vec4 GEN_REST = {0.0f, 0.0f, 0.0f, 1.0f};
const struct pbnds_vec3 GEN_X = {1.0f, 0.0f, 0.0f}, GEN_Y = {0.0f, 1.0f, 0.0f},
                        GEN_Z = {0.0f, 0.0f, 1.0f};

void gen_put(struct gen_mesh *whole, struct gen_mesh *piece, struct pbnds_vec3 t,
             struct pbnds_vec4 q)
{
    const struct pbnds_mat4 m = pbnds_mat4_from_trs(t, q, pbnds_splat(1.0f));
    gen_mesh_append(whole, piece, &m);
    gen_mesh_free(piece);
}

void gen_put_block(struct gen_mesh *whole, struct pbnds_vec3 half, float bevel,
                   struct pbnds_vec3 t, struct pbnds_vec4 q)
{
    struct gen_mesh m = {.vertex_count = 0};
    gen_rounded_box(&m, half, bevel, bevel > 0.0f ? 2 : 0, 1);
    gen_put(whole, &m, t, q);
}

void gen_put_frustum(struct gen_mesh *whole, float bottom, float top, float half,
                     struct pbnds_vec3 t, struct pbnds_vec4 q, int segments)
{
    struct gen_mesh m = {.vertex_count = 0};
    gen_frustum(&m, bottom, top, half, 0.1f * fminf(half, bottom), segments);
    gen_put(whole, &m, t, q);
}

void gen_put_ball(struct gen_mesh *whole, struct pbnds_vec3 centre,
                  struct pbnds_vec3 radii, int segments)
{
    struct gen_mesh m = {.vertex_count = 0};
    gen_ellipsoid(&m, radii, segments);
    gen_put(whole, &m, centre, GEN_REST);
}

void gen_finish(const struct gen_maker *k, struct gen_mesh *m, float crease,
                int material)
{
    gen_mesh_shade(m, crease);
    gen_object_part(k->world, m, material);
}

int gen_sheet_material(const struct gen_maker *k)
{
    const int material =
        gen_make_material(k, gen_chance(k->rng, 0.8f) ? GEN_CLOTH : GEN_ANY);
    k->world->materials[material].double_sided = true;
    return material;
}

struct pbnds_vec4 gen_aim(struct pbnds_vec3 d)
{
    /* half way quaternion of +y and d: (y x d, 1 + y.d), normalised */
    if (d.y < -0.9999f) return gen_turn(GEN_X, PBNDS_PI);
    const float w = 1.0f + d.y, s = 1.0f / sqrtf(d.z * d.z + d.x * d.x + w * w);
    const struct pbnds_vec4 q = {d.z * s, 0.0f, -d.x * s, w * s};
    return q;
}

/* ---- tubes ---- */

static struct pbnds_vec3 tangent_at(const struct gen_tube *t, int i)
{
    const int n = t->count;
    const int a = t->closed ? (i + n - 1) % n : i > 0 ? i - 1 : 0;
    const int b = t->closed ? (i + 1) % n : i + 1 < n ? i + 1 : n - 1;
    const struct pbnds_vec3 d = pbnds_sub(t->points[b], t->points[a]);
    const float length = pbnds_length(d);
    return length > 1e-12f ? pbnds_scale(d, 1.0f / length) : GEN_Y;
}

/* The normal with what points along t taken out. */
static struct pbnds_vec3 across(struct pbnds_vec3 n, struct pbnds_vec3 t)
{
    const struct pbnds_vec3 m = pbnds_mad(n, t, -pbnds_dot(n, t));
    const float length = pbnds_length(m);
    return length > 1e-6f ? pbnds_scale(m, 1.0f / length)
                          : pbnds_frame_from_normal(t).t;
}

/* How far the carried frame of a closed curve has turned when it comes home. */
static float closing_turn(const struct gen_tube *t, struct pbnds_vec3 start)
{
    struct pbnds_vec3 n = start;
    for (int i = 1; i <= t->count; ++i)
        n = across(n, tangent_at(t, i % t->count));
    const struct pbnds_vec3 axis = tangent_at(t, 0);
    return atan2f(pbnds_dot(pbnds_cross(start, n), axis), pbnds_dot(start, n));
}

static void add_ring(struct gen_mesh *m, const struct gen_tube *t, int i,
                     struct pbnds_vec3 n, float v)
{
    const struct pbnds_vec3 c = t->points[i], b = pbnds_cross(tangent_at(t, i), n);
    const float r = t->radius ? t->radius[i] : t->thickness;
    for (int j = 0; j <= t->sides; ++j) {
        const float u = (float)j / (float)t->sides, a = j == t->sides ? 0.0f : u * TURN;
        const struct pbnds_vec3 p =
            pbnds_mad(pbnds_mad(c, n, r * cosf(a)), b, r * t->flat * sinf(a));
        const struct pbnds_vec2 uv = {u, v};
        (void)gen_mesh_vertex(m, p, uv);
    }
}

static void cap(struct gen_mesh *m, const struct gen_tube *t, int i, uint32_t ring,
                bool last)
{
    const struct pbnds_vec2 uv = {0.5f, 0.5f};
    const uint32_t centre = gen_mesh_vertex(m, t->points[i], uv);
    for (uint32_t j = 0; j < (uint32_t)t->sides; ++j) {
        const uint32_t a = ring + j, b = ring + j + 1;
        gen_mesh_triangle(m, centre, last ? a : b, last ? b : a);
    }
}

void gen_tube(struct gen_mesh *m, const struct gen_tube *t)
{
    const uint32_t base = (uint32_t)m->vertex_count, row = (uint32_t)t->sides + 1;
    const int rings = t->closed ? t->count + 1 : t->count;
    struct pbnds_vec3 n = pbnds_frame_from_normal(tangent_at(t, 0)).t;
    const float turn = t->closed ? closing_turn(t, n) : 0.0f;
    const float girth = TURN * fmaxf(t->radius ? t->radius[0] : t->thickness, 0.02f);
    float along = 0.0f;
    for (int i = 0; i < rings; ++i) {
        const int k = i % t->count;
        const struct pbnds_vec3 axis = tangent_at(t, k);
        if (i > 0) {
            const struct pbnds_vec3 step = pbnds_sub(t->points[k], t->points[i - 1]);
            along += pbnds_length(step) / girth;
        }
        n = across(n, axis);
        const float a = -turn * (float)i / (float)t->count;
        const struct pbnds_vec3 b = pbnds_cross(axis, n);
        add_ring(m, t, k, pbnds_mad(pbnds_scale(n, cosf(a)), b, sinf(a)), along);
    }
    if (m->failed) return;
    for (uint32_t i = 0; i + 1 < (uint32_t)rings; ++i) {
        for (uint32_t j = 0; j + 1 < row; ++j) {
            const uint32_t a = base + i * row + j;
            gen_mesh_quad(m, a, a + 1, a + row + 1, a + row);
        }
    }
    if (t->closed) return;
    cap(m, t, 0, base, false);
    cap(m, t, t->count - 1, base + (uint32_t)(rings - 1) * row, true);
}

/* ---- plates ---- */

/* One closed line of the plate's skin: the outline at a height, drawn in by `inset`. */
static uint32_t add_line(struct gen_mesh *m, const struct gen_plate *p, float share,
                         float inset, float z, bool flat)
{
    const float t = p->half > 0.0f ? 0.5f + 0.5f * z / p->half : 0.5f;
    const float size = 1.0f + p->taper * t, a = p->twist * t;
    const uint32_t first = (uint32_t)m->vertex_count;
    float along = 0.0f;
    for (int i = 0; i <= p->count; ++i) {
        const struct pbnds_vec2 o = p->outline[i % p->count];
        const struct pbnds_vec2 q = p->outline[(i + p->count - 1) % p->count];
        const float r = hypotf(o.x, o.y);
        const float s =
            size * share * (r > 1e-6f ? fmaxf(0.0f, 1.0f - inset / r) : 0.0f);
        const float x = s * (o.x * cosf(a) - o.y * sinf(a));
        const float y = s * (o.x * sinf(a) + o.y * cosf(a));
        if (i > 0) along += hypotf(o.x - q.x, o.y - q.y);
        const struct pbnds_vec2 uv = {flat ? 0.5f + x : along, flat ? 0.5f - y : z};
        (void)gen_mesh_vertex(m, pbnds_vec3_make(x, y, z), uv);
    }
    return first;
}

/* Faces between two lines; `out` when the second is to the front of, or inside, the
 * first. */
static void join(struct gen_mesh *m, int count, uint32_t a, uint32_t b, bool out)
{
    for (uint32_t i = 0; i < (uint32_t)count; ++i) {
        if (out) gen_mesh_quad(m, a + i, a + i + 1, b + i + 1, b + i);
        if (!out) gen_mesh_quad(m, a + i + 1, a + i, b + i, b + i + 1);
    }
}

static void add_face(struct gen_mesh *m, const struct gen_plate *p, float inset,
                     float z)
{
    const bool front = z > 0.0f;
    const uint32_t rim = add_line(m, p, 1.0f, inset, z, true);
    if (p->hole > 0.0f) {
        join(m, p->count, rim, add_line(m, p, p->hole, 0.0f, z, true), front);
        return;
    }
    const struct pbnds_vec2 uv = {0.5f, 0.5f};
    const uint32_t centre = gen_mesh_vertex(m, pbnds_vec3_make(0.0f, 0.0f, z), uv);
    for (uint32_t i = 0; i < (uint32_t)p->count; ++i) {
        gen_mesh_triangle(m, centre, rim + i + (front ? 0 : 1),
                          rim + i + (front ? 1 : 0));
    }
}

void gen_plate(struct gen_mesh *m, const struct gen_plate *p)
{
    const float bevel = fminf(p->bevel, 0.9f * p->half);
    const float low = -p->half + bevel, high = p->half - bevel;
    uint32_t line = add_line(m, p, 1.0f, 0.0f, low, false);
    if (bevel > 0.0f) {
        const uint32_t back = add_line(m, p, 1.0f, bevel, -p->half, false);
        join(m, p->count, back, line, true);
    }
    for (int s = 1; s <= p->steps; ++s) {
        const float z = low + (high - low) * (float)s / (float)p->steps;
        const uint32_t next = add_line(m, p, 1.0f, 0.0f, z, false);
        join(m, p->count, line, next, true);
        line = next;
    }
    if (bevel > 0.0f) {
        const uint32_t front = add_line(m, p, 1.0f, bevel, p->half, false);
        join(m, p->count, line, front, true);
    }
    add_face(m, p, bevel, p->half);
    add_face(m, p, bevel, -p->half);
    if (!(p->hole > 0.0f)) return;
    line = add_line(m, p, p->hole, 0.0f, -p->half, false);
    for (int s = 1; s <= p->steps; ++s) {
        const float z = p->half * (2.0f * (float)s / (float)p->steps - 1.0f);
        const uint32_t next = add_line(m, p, p->hole, 0.0f, z, false);
        join(m, p->count, line, next, false);
        line = next;
    }
}

int gen_curve(const struct pbnds_vec3 *knot, int knots, bool closed, int steps,
              struct pbnds_vec3 *out)
{
    const int spans = closed ? knots : knots - 1;
    int n = 0;
    for (int s = 0; s < spans; ++s) {
        const int last = knots - 1;
        const int i0 = closed ? (s + knots - 1) % knots : s > 0 ? s - 1 : 0;
        const int i2 = closed ? (s + 1) % knots : s + 1;
        const int i3 = closed ? (s + 2) % knots : s + 2 < last ? s + 2 : last;
        const struct pbnds_vec3 a = knot[i0], b = knot[s], c = knot[i2], d = knot[i3];
        for (int i = 0; i < steps; ++i) {
            const float t = (float)i / (float)steps, t2 = t * t, t3 = t2 * t;
            struct pbnds_vec3 p = pbnds_scale(a, -0.5f * t3 + t2 - 0.5f * t);
            p = pbnds_mad(p, b, 1.5f * t3 - 2.5f * t2 + 1.0f);
            p = pbnds_mad(p, c, -1.5f * t3 + 2.0f * t2 + 0.5f * t);
            out[n++] = pbnds_mad(p, d, 0.5f * t3 - 0.5f * t2);
        }
    }
    if (!closed) out[n++] = knot[knots - 1];
    return n;
}
