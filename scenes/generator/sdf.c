#include "scenes/generator/sdf.h"

#include "scenes/generator/noise.h"

struct gen_sdf_op *gen_sdf_add(struct gen_sdf *s, enum gen_sdf_kind kind,
                               struct pbnds_vec3 centre, struct pbnds_vec3 size,
                               float blend)
{
    if (s->count == GEN_SDF_MAX) --s->count;
    struct gen_sdf_op *op = &s->ops[s->count++];
    *op = (struct gen_sdf_op){.kind = kind,
                              .combine = GEN_UNION,
                              .blend = blend,
                              .a = centre,
                              .b = centre,
                              .turn = {0.0f, 0.0f, 0.0f, 1.0f},
                              .size = size};
    return op;
}

struct gen_sdf_op *gen_sdf_cone(struct gen_sdf *s, struct pbnds_vec3 a,
                                struct pbnds_vec3 b, float radius_a, float radius_b,
                                float blend)
{
    const struct pbnds_vec3 size = {radius_a, radius_b, 0.0f};
    struct gen_sdf_op *op = gen_sdf_add(s, GEN_SDF_CONE, a, size, blend);
    op->b = b;
    return op;
}

/* Bound of Quilez, "Ellipsoid SDF": exact on the surface, good near it. */
static float ellipsoid(struct pbnds_vec3 p, struct pbnds_vec3 r)
{
    const struct pbnds_vec3 q = {p.x / r.x, p.y / r.y, p.z / r.z};
    const struct pbnds_vec3 g = {q.x / r.x, q.y / r.y, q.z / r.z};
    const float k0 = pbnds_length(q), k1 = pbnds_length(g);
    if (k1 < 1e-6f) return -fminf(r.x, fminf(r.y, r.z));
    return k0 * (k0 - 1.0f) / k1;
}

static float box(struct pbnds_vec3 p, struct pbnds_vec3 half, float round)
{
    const struct pbnds_vec3 q = {fabsf(p.x) - half.x + round,
                                 fabsf(p.y) - half.y + round,
                                 fabsf(p.z) - half.z + round};
    const struct pbnds_vec3 out = {fmaxf(q.x, 0.0f), fmaxf(q.y, 0.0f),
                                   fmaxf(q.z, 0.0f)};
    return pbnds_length(out) + fminf(pbnds_max3(q), 0.0f) - round;
}

/* Distance to a segment, its radius interpolated: round enough for limbs and noses. */
static float cone(struct pbnds_vec3 p, struct pbnds_vec3 a, struct pbnds_vec3 b,
                  struct pbnds_vec3 size)
{
    const struct pbnds_vec3 d = pbnds_sub(b, a), q = pbnds_sub(p, a);
    const float t =
        pbnds_clamp(pbnds_dot(q, d) / (pbnds_dot(d, d) + 1e-12f), 0.0f, 1.0f);
    return pbnds_length(pbnds_mad(q, d, -t)) - (size.x + (size.y - size.x) * t);
}

static float torus(struct pbnds_vec3 p, float radius, float tube)
{
    return hypotf(hypotf(p.x, p.z) - radius, p.y) - tube;
}

static float cylinder(struct pbnds_vec3 p, float radius, float half, float round)
{
    const float x = hypotf(p.x, p.z) - radius + round, y = fabsf(p.y) - half + round;
    return hypotf(fmaxf(x, 0.0f), fmaxf(y, 0.0f)) + fminf(fmaxf(x, y), 0.0f) - round;
}

static float gyroid(struct pbnds_vec3 p, float cell, float half)
{
    const float k = 2.0f * PBNDS_PI / cell;
    const struct pbnds_vec3 q = pbnds_scale(p, k);
    const float g =
        sinf(q.x) * cosf(q.y) + sinf(q.y) * cosf(q.z) + sinf(q.z) * cosf(q.x);
    return fabsf(g) / (1.5f * k) - half;
}

static float primitive(const struct gen_sdf_op *op, struct pbnds_vec3 p)
{
    if (op->kind == GEN_SDF_CONE) return cone(p, op->a, op->b, op->size);
    const struct pbnds_vec4 back = {-op->turn.x, -op->turn.y, -op->turn.z, op->turn.w};
    const struct pbnds_vec3 q = gen_rotate(back, pbnds_sub(p, op->a));
    switch (op->kind) {
    case GEN_SDF_ELLIPSOID:
        return ellipsoid(q, op->size);
    case GEN_SDF_BOX:
        return box(q, op->size, op->round);
    case GEN_SDF_TORUS:
        return torus(q, op->size.x, op->size.y);
    case GEN_SDF_CYLINDER:
        return cylinder(q, op->size.x, op->size.y, op->round);
    default:
        return gyroid(q, op->size.x, op->size.y);
    }
}

/* Quilez, "smooth minimum", cubic polynomial. */
static float smooth_min(float a, float b, float k)
{
    if (k <= 0.0f) return fminf(a, b);
    const float h = fmaxf(k - fabsf(a - b), 0.0f) / k;
    return fminf(a, b) - h * h * h * k * (1.0f / 6.0f);
}

static struct gen_sdf_ball ball_around(const struct gen_sdf_op *op)
{
    const struct pbnds_vec3 s = op->size;
    struct gen_sdf_ball ball = {op->a, pbnds_length(s), 1.0f};
    switch (op->kind) {
    case GEN_SDF_ELLIPSOID: {
        /* k0 (k0 - 1) / k1 with k0 >= |p| / max r and k0 / k1 >= min r */
        const float least = fminf(s.x, fminf(s.y, s.z));
        ball.radius = pbnds_max3(s);
        ball.stretch = ball.radius / least;
        return ball;
    }
    case GEN_SDF_CONE:
        ball.centre = pbnds_scale(pbnds_add(op->a, op->b), 0.5f);
        ball.radius = 0.5f * pbnds_length(pbnds_sub(op->a, op->b)) + fmaxf(s.x, s.y);
        return ball;
    case GEN_SDF_TORUS:
        ball.radius = s.x + s.y;
        return ball;
    case GEN_SDF_BOX:
    case GEN_SDF_CYLINDER:
        return ball;
    default: /* a gyroid is everywhere */
        ball.radius = INFINITY;
        return ball;
    }
}

void gen_sdf_prepare(struct gen_sdf_field *field, const struct gen_sdf *s)
{
    field->sdf = s;
    for (int i = 0; i < s->count; ++i)
        field->balls[i] = ball_around(&s->ops[i]);
}

/* Is the primitive farther from p than `distance`? False where the ball cannot tell. */
static bool beyond(const struct gen_sdf_ball *ball, struct pbnds_vec3 p, float distance)
{
    const struct pbnds_vec3 d = pbnds_sub(p, ball->centre);
    /* inside of it an ellipsoid's estimate is never below the distance itself */
    const float reach =
        ball->radius + distance * (distance > 0.0f ? ball->stretch : 1.0f);
    return reach <= 0.0f || pbnds_dot(d, d) > 1.0001f * reach * reach;
}

/* The distance to an operation's primitive and its mirror image, INFINITY where it is beyond
 * `distance`. */
static float distance_to(const struct gen_sdf_op *op, const struct gen_sdf_ball *ball,
                         struct pbnds_vec3 p, float distance)
{
    const struct pbnds_vec3 mirrored = {-p.x, p.y, p.z};
    float e = INFINITY;
    if (!beyond(ball, p, distance)) e = primitive(op, p);
    if (op->mirror && !beyond(ball, mirrored, distance))
        e = fminf(e, primitive(op, mirrored));
    return e;
}

float gen_sdf_eval(const struct gen_sdf_field *field, struct pbnds_vec3 p)
{
    const struct gen_sdf *s = field->sdf;
    float d = 1e6f;
    for (int i = 0; i < s->count; ++i) {
        const struct gen_sdf_op *op = &s->ops[i];
        const struct gen_sdf_ball *ball = &field->balls[i];
        /* what is farther than the blend is wide changes nothing */
        const float far = op->combine == GEN_UNION ? d + op->blend
                          : op->combine == GEN_CUT ? op->blend - d
                                                   : INFINITY;
        const float e = distance_to(op, ball, p, far);
        if (e == INFINITY) continue;
        if (op->combine == GEN_UNION) d = smooth_min(d, e, op->blend);
        if (op->combine == GEN_CUT) d = -smooth_min(-d, e, op->blend);
        if (op->combine == GEN_INTERSECT) d = -smooth_min(-d, -e, op->blend);
    }
    if (s->relief != 0.0f && fabsf(d) < 3.0f * fabsf(s->relief)) {
        d += s->relief * gen_fbm(pbnds_scale(p, s->relief_frequency), 3, 0, s->seed);
    }
    return d;
}

/* Half extents along the world's axes of a box that holds the primitive about each end.
 */
static struct pbnds_vec3 reach(const struct gen_sdf_op *op)
{
    const struct pbnds_vec3 s = op->size;
    struct pbnds_vec3 half = s;
    if (op->kind == GEN_SDF_CONE) return pbnds_splat(fmaxf(s.x, s.y));
    if (op->kind == GEN_SDF_TORUS) half = pbnds_vec3_make(s.x + s.y, s.y, s.x + s.y);
    if (op->kind == GEN_SDF_CYLINDER) half = pbnds_vec3_make(s.x, s.y, s.x);
    const struct pbnds_vec3 x =
        gen_rotate(op->turn, pbnds_vec3_make(half.x, 0.0f, 0.0f));
    const struct pbnds_vec3 y =
        gen_rotate(op->turn, pbnds_vec3_make(0.0f, half.y, 0.0f));
    const struct pbnds_vec3 z =
        gen_rotate(op->turn, pbnds_vec3_make(0.0f, 0.0f, half.z));
    return pbnds_vec3_make(fabsf(x.x) + fabsf(y.x) + fabsf(z.x),
                           fabsf(x.y) + fabsf(y.y) + fabsf(z.y),
                           fabsf(x.z) + fabsf(y.z) + fabsf(z.z));
}

static void widen(struct pbnds_vec3 p, struct pbnds_vec3 r, struct pbnds_vec3 *lo,
                  struct pbnds_vec3 *hi)
{
    *lo = pbnds_vec3_make(fminf(lo->x, p.x - r.x), fminf(lo->y, p.y - r.y),
                          fminf(lo->z, p.z - r.z));
    *hi = pbnds_vec3_make(fmaxf(hi->x, p.x + r.x), fmaxf(hi->y, p.y + r.y),
                          fmaxf(hi->z, p.z + r.z));
}

void gen_sdf_bounds(const struct gen_sdf *s, struct pbnds_vec3 *lo,
                    struct pbnds_vec3 *hi)
{
    *lo = pbnds_splat(INFINITY);
    *hi = pbnds_splat(-INFINITY);
    for (int i = 0; i < s->count; ++i) {
        const struct gen_sdf_op *op = &s->ops[i];
        if (op->combine != GEN_UNION) continue;
        /* A smooth union bulges by at most a sixth of its width. */
        const float bulge = 0.17f * op->blend + fabsf(s->relief);
        const struct pbnds_vec3 r = pbnds_add(reach(op), pbnds_splat(bulge));
        const struct pbnds_vec3 ends[2] = {op->a, op->b};
        for (int k = 0; k < 2; ++k) {
            widen(ends[k], r, lo, hi);
            if (!op->mirror) continue;
            widen(pbnds_vec3_make(-ends[k].x, ends[k].y, ends[k].z), r, lo, hi);
        }
    }
}
