#include "scenes/generator/shapes.h"

#include <stdlib.h>

#define TURN (2.0f * PBNDS_PI)

/* sign(x) |x|^e */
static float power(float x, float e)
{
    return copysignf(powf(fabsf(x) < 1e-6f ? 0.0f : fabsf(x), e), x);
}

struct quadric {
    float e_north, e_east;
    struct pbnds_vec3 radii;
};

static struct pbnds_vec3 quadric_point(const void *context, float u, float v)
{
    const struct quadric *q = context;
    const float lat = (v - 0.5f) * PBNDS_PI, lon = u * TURN;
    const float ring = v <= 0.0f || v >= 1.0f ? 0.0f : power(cosf(lat), q->e_north);
    return pbnds_vec3_make(q->radii.x * ring * power(cosf(lon), q->e_east),
                           q->radii.y * power(sinf(lat), q->e_north),
                           -q->radii.z * ring * power(sinf(lon), q->e_east));
}

void gen_superquadric(struct gen_mesh *m, float e_north, float e_east,
                      struct pbnds_vec3 radii, int segments)
{
    const struct quadric q = {e_north, e_east, radii};
    /* Multiples of 4 put vertices on the edges and corners of box-like forms. */
    const int around = (segments + 3) / 4 * 4;
    const struct gen_grid grid = {around, around / 2, true, false, quadric_point, &q};
    gen_mesh_grid(m, &grid);
}

void gen_ellipsoid(struct gen_mesh *m, struct pbnds_vec3 radii, int segments)
{
    gen_superquadric(m, 1.0f, 1.0f, radii, segments);
}

struct ring {
    float radius, tube;
};

static struct pbnds_vec3 torus_point(const void *context, float u, float v)
{
    const struct ring *t = context;
    const float r = t->radius + t->tube * cosf(v * TURN);
    return pbnds_vec3_make(r * cosf(u * TURN), t->tube * sinf(v * TURN),
                           -r * sinf(u * TURN));
}

void gen_torus(struct gen_mesh *m, float radius, float tube, int segments)
{
    const struct ring t = {radius, tube};
    const struct gen_grid grid = {segments, segments / 2, true, true, torus_point, &t};
    gen_mesh_grid(m, &grid);
}

struct knot {
    float p, q, radius, swing, tube, flat;
};

static struct pbnds_vec3 knot_centre(const struct knot *k, float u)
{
    const float a = k->p * u * TURN, b = k->q * u * TURN;
    const float r = k->radius + k->swing * cosf(b);
    return pbnds_vec3_make(r * cosf(a), k->swing * sinf(b), -r * sinf(a));
}

static struct pbnds_vec3 knot_point(const void *context, float u, float v)
{
    const struct knot *k = context;
    const struct pbnds_vec3 c = knot_centre(k, u);
    const struct pbnds_vec3 ahead = knot_centre(k, u + 1e-3f);
    const struct pbnds_vec3 behind = knot_centre(k, u - 1e-3f);
    const struct pbnds_vec3 t = pbnds_normalize(pbnds_sub(ahead, behind));
    /* From the torus' core to its skin: never parallel to the curve, and closed. */
    const float a = k->p * u * TURN;
    const struct pbnds_vec3 core = {k->radius * cosf(a), 0.0f, -k->radius * sinf(a)};
    struct pbnds_vec3 n = pbnds_sub(c, core);
    n = pbnds_normalize(pbnds_mad(n, t, -pbnds_dot(n, t)));
    const struct pbnds_vec3 b = pbnds_cross(t, n);
    const float x = k->tube * cosf(v * TURN), y = k->tube * k->flat * sinf(v * TURN);
    return pbnds_mad(pbnds_mad(c, b, x), n, y);
}

void gen_knot(struct gen_mesh *m, int p, int q, float radius, float swing, float tube,
              float flat, int segments)
{
    const struct knot k = {(float)p, (float)q, radius, swing, tube, flat};
    const struct gen_grid grid = {segments * 4, segments / 3 + 3, true,
                                  true,         knot_point,       &k};
    gen_mesh_grid(m, &grid);
}

struct spring {
    float radius, tube, height, turns;
};

static struct pbnds_vec3 spring_point(const void *context, float u, float v)
{
    const struct spring *s = context;
    /* The first and last tenths of the grid close the ends as half balls. */
    const float cap = 0.08f;
    float along = (u - cap) / (1.0f - 2.0f * cap), shrink = 1.0f, out = 0.0f;
    if (u < cap || u > 1.0f - cap) {
        const float a =
            0.5f * PBNDS_PI * (u < cap ? 1.0f - u / cap : 1.0f - (1.0f - u) / cap);
        shrink = u <= 0.0f || u >= 1.0f ? 0.0f : cosf(a);
        out = s->tube * sinf(a) * (u < cap ? -1.0f : 1.0f);
        along = u < cap ? 0.0f : 1.0f;
    }
    const float a = s->turns * along * TURN;
    const struct pbnds_vec3 radial = {cosf(a), 0.0f, -sinf(a)};
    const struct pbnds_vec3 t = pbnds_normalize(
        pbnds_vec3_make(-sinf(a) * s->radius * s->turns * TURN, s->height,
                        -cosf(a) * s->radius * s->turns * TURN));
    const struct pbnds_vec3 b = pbnds_cross(t, radial);
    struct pbnds_vec3 c = pbnds_scale(radial, s->radius);
    c.y = (along - 0.5f) * s->height;
    c = pbnds_mad(c, t, out);
    const float x = s->tube * shrink * cosf(v * TURN);
    const float y = s->tube * shrink * sinf(v * TURN);
    return pbnds_mad(pbnds_mad(c, b, x), radial, y);
}

void gen_spring(struct gen_mesh *m, float radius, float tube, float height, float turns,
                int segments)
{
    const struct spring s = {radius, tube, height, turns};
    const struct gen_grid grid = {(int)(turns * (float)segments) + 20,
                                  segments / 3 + 3,
                                  false,
                                  true,
                                  spring_point,
                                  &s};
    gen_mesh_grid(m, &grid);
}

/* Coordinates of the grid lines on one axis: rounded zone, flat zone, rounded zone.
 * tan keeps the arcs of the rounded zone evenly divided. */
static int box_lines(float half, float radius, int bevel, int flat, float *line)
{
    const float inner = half - radius;
    int n = 0;
    if (bevel > 0) line[n++] = -half; /* to the bit: faces meet here */
    for (int i = 1; i < bevel; ++i) {
        const float t = tanf(0.25f * PBNDS_PI * (1.0f - (float)i / (float)bevel));
        line[n++] = -(inner + radius * t);
    }
    const int inside = inner > 0.0f ? flat : 0;
    for (int i = 0; i <= inside; ++i) {
        line[n++] = inside ? inner * (2.0f * (float)i / (float)inside - 1.0f) : 0.0f;
    }
    for (int i = bevel - 1; i >= 0; --i)
        line[n++] = -line[i];
    return n;
}

/* Faces as (right, up, out) axes, right x up = out. */
static const int BOX_FACES[6][3] = {{1, 2, 0}, {2, 1, 0}, {2, 0, 1},
                                    {0, 2, 1}, {0, 1, 2}, {1, 0, 2}};

static float clamp_to(float x, float limit)
{
    return x > limit ? limit : x < -limit ? -limit : x;
}

static struct pbnds_vec3 box_point(const float q[3], struct pbnds_vec3 half,
                                   float radius)
{
    const struct pbnds_vec3 inner = {clamp_to(q[0], half.x - radius),
                                     clamp_to(q[1], half.y - radius),
                                     clamp_to(q[2], half.z - radius)};
    const struct pbnds_vec3 d = pbnds_sub(pbnds_vec3_make(q[0], q[1], q[2]), inner);
    if (radius <= 0.0f) return inner;
    return pbnds_mad(inner, pbnds_normalize(d), radius);
}

void gen_rounded_box(struct gen_mesh *m, struct pbnds_vec3 half, float radius,
                     int bevel_segments, int flat_segments)
{
    const float h[3] = {half.x, half.y, half.z};
    const float smallest = fminf(half.x, fminf(half.y, half.z));
    if (radius > smallest) radius = smallest;
    if (radius <= 0.0f) bevel_segments = 0;
    const size_t room = (size_t)(2 * bevel_segments + flat_segments + 1);
    float *line[3] = {malloc(room * sizeof(float)), malloc(room * sizeof(float)),
                      malloc(room * sizeof(float))};
    int n[3] = {0, 0, 0};
    if (!line[0] || !line[1] || !line[2]) {
        m->failed = true;
        goto done;
    }
    for (int a = 0; a < 3; ++a) {
        n[a] = box_lines(h[a], radius, bevel_segments, flat_segments, line[a]);
    }
    for (int f = 0; f < 6; ++f) {
        const int r = BOX_FACES[f][0], up = BOX_FACES[f][1], out = BOX_FACES[f][2];
        const float side = f % 2 == 0 ? 1.0f : -1.0f;
        const uint32_t base = (uint32_t)m->vertex_count, row = (uint32_t)n[r];
        for (int j = 0; j < n[up]; ++j) {
            for (int i = 0; i < n[r]; ++i) {
                float q[3];
                q[r] = line[r][i];
                q[up] = line[up][j];
                q[out] = side * h[out];
                const struct pbnds_vec2 uv = {0.5f + 0.5f * q[r], 0.5f - 0.5f * q[up]};
                (void)gen_mesh_vertex(m, box_point(q, half, radius), uv);
            }
        }
        for (uint32_t j = 0; j + 1 < (uint32_t)n[up]; ++j) {
            for (uint32_t i = 0; i + 1 < row; ++i) {
                const uint32_t a = base + j * row + i;
                gen_mesh_quad(m, a, a + 1, a + row + 1, a + row);
            }
        }
    }
done:
    for (int a = 0; a < 3; ++a)
        free(line[a]);
}

void gen_cube_sphere(struct gen_mesh *m, float radius, int n)
{
    gen_rounded_box(m, pbnds_splat(radius), radius, (n + 1) / 2, 0);
}

void gen_lathe(struct gen_mesh *m, const struct pbnds_vec2 *profile, int count,
               int segments, int flutes, float flute_depth)
{
    float length = 0.0f, reached = 0.0f;
    for (int j = 1; j < count; ++j) {
        length +=
            hypotf(profile[j].x - profile[j - 1].x, profile[j].y - profile[j - 1].y);
    }
    const uint32_t base = (uint32_t)m->vertex_count, row = (uint32_t)segments + 1;
    for (int j = 0; j < count; ++j) {
        if (j > 0) {
            reached += hypotf(profile[j].x - profile[j - 1].x,
                              profile[j].y - profile[j - 1].y);
        }
        for (int i = 0; i <= segments; ++i) {
            const float u = (float)i / (float)segments;
            const float a = i == segments ? 0.0f : u * TURN;
            float r = profile[j].x;
            if (flutes > 0) {
                r *= 1.0f - flute_depth * fabsf(sinf(0.5f * (float)flutes * a));
            }
            const struct pbnds_vec2 uv = {u, 1.0f - reached / length};
            (void)gen_mesh_vertex(
                m, pbnds_vec3_make(r * cosf(a), profile[j].y, -r * sinf(a)), uv);
        }
    }
    for (uint32_t j = 0; j + 1 < (uint32_t)count; ++j) {
        for (uint32_t i = 0; i + 1 < row; ++i) {
            const uint32_t a = base + j * row + i;
            gen_mesh_quad(m, a, a + 1, a + row + 1, a + row);
        }
    }
}

enum { BEVEL = 4 };

void gen_frustum(struct gen_mesh *m, float bottom, float top, float half, float bevel,
                 int segments)
{
    struct pbnds_vec2 profile[2 * BEVEL + 4];
    int n = 0;
    const float lower = fminf(bevel, bottom), upper = fminf(bevel, top);
    profile[n++] = (struct pbnds_vec2){0.0f, -half};
    for (int i = 0; i <= (lower > 0.0f ? BEVEL : 0); ++i) {
        const float a = 0.5f * PBNDS_PI * (float)i / BEVEL;
        profile[n++] = (struct pbnds_vec2){bottom - lower + lower * sinf(a),
                                           -half + lower - lower * cosf(a)};
    }
    for (int i = 0; i <= (upper > 0.0f ? BEVEL : 0); ++i) {
        const float a = 0.5f * PBNDS_PI * (float)i / BEVEL;
        profile[n++] = (struct pbnds_vec2){top - upper + upper * cosf(a),
                                           half - upper + upper * sinf(a)};
    }
    if (top > 0.0f) profile[n++] = (struct pbnds_vec2){0.0f, half};
    gen_lathe(m, profile, n, segments, 0, 0.0f);
}

enum { CAP = 16 };

void gen_capsule(struct gen_mesh *m, float radius, float half, int segments)
{
    struct pbnds_vec2 profile[2 * CAP + 2];
    for (int i = 0; i <= CAP; ++i) {
        const float a = 0.5f * PBNDS_PI * (float)i / CAP;
        const float s = i == 0 ? 0.0f : radius * sinf(a), c = radius * cosf(a);
        profile[i] = (struct pbnds_vec2){s, -half - c};
        profile[2 * CAP + 1 - i] = (struct pbnds_vec2){s, half + c};
    }
    gen_lathe(m, profile, 2 * CAP + 2, segments, 0, 0.0f);
}

struct rectangle {
    float half_x, half_z;
};

static struct pbnds_vec3 plane_point(const void *context, float u, float v)
{
    const struct rectangle *r = context;
    return pbnds_vec3_make(r->half_x * (2.0f * u - 1.0f), 0.0f,
                           r->half_z * (1.0f - 2.0f * v));
}

void gen_plane(struct gen_mesh *m, float half_x, float half_z, int segments)
{
    const struct rectangle r = {half_x, half_z};
    const struct gen_grid grid = {segments, segments, false, false, plane_point, &r};
    gen_mesh_grid(m, &grid);
}
