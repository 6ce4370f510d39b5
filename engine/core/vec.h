/**
 * @file vec.h
 * Vectors by value. Right-handed, +y up; angles in radians. The same type serves
 * points, directions and linear Rec. 709 colours.
 */
#ifndef PBNDS_ENGINE_CORE_VEC_H
#define PBNDS_ENGINE_CORE_VEC_H

#include <math.h>

#define PBNDS_PI 3.14159265358979323846f

struct pbnds_vec2 {
    float x, y;
};
struct pbnds_vec3 {
    float x, y, z;
};
struct pbnds_vec4 {
    float x, y, z, w;
};

static inline struct pbnds_vec3 pbnds_vec3_make(float x, float y, float z)
{
    struct pbnds_vec3 v = {x, y, z};
    return v;
}
static inline struct pbnds_vec3 pbnds_splat(float s)
{
    return pbnds_vec3_make(s, s, s);
}
static inline struct pbnds_vec3 pbnds_add(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline struct pbnds_vec3 pbnds_sub(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(a.x - b.x, a.y - b.y, a.z - b.z);
}
/** Componentwise product: a colour filtered by another. */
static inline struct pbnds_vec3 pbnds_mul(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline struct pbnds_vec3 pbnds_scale(struct pbnds_vec3 a, float s)
{
    return pbnds_vec3_make(a.x * s, a.y * s, a.z * s);
}
/** a + s b */
static inline struct pbnds_vec3 pbnds_mad(struct pbnds_vec3 a, struct pbnds_vec3 b, float s)
{
    return pbnds_vec3_make(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}
static inline struct pbnds_vec3 pbnds_lerp(struct pbnds_vec3 a, struct pbnds_vec3 b, float t)
{
    return pbnds_add(pbnds_scale(a, 1.0f - t), pbnds_scale(b, t));
}
static inline float pbnds_dot(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline struct pbnds_vec3 pbnds_cross(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
                           a.x * b.y - a.y * b.x);
}
static inline float pbnds_length(struct pbnds_vec3 a)
{
    return sqrtf(pbnds_dot(a, a));
}
static inline struct pbnds_vec3 pbnds_normalize(struct pbnds_vec3 a)
{
    return pbnds_scale(a, 1.0f / sqrtf(pbnds_dot(a, a)));
}
static inline float pbnds_max3(struct pbnds_vec3 a)
{
    return fmaxf(a.x, fmaxf(a.y, a.z));
}
/** Rec. 709 luminance of a linear colour. */
static inline float pbnds_luminance(struct pbnds_vec3 c)
{
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}
/** lo where x is NaN. By selections, not fminf(): those are library calls. */
static inline float pbnds_clamp(float x, float lo, float hi)
{
    const float up = x > lo ? x : lo;
    return up < hi ? up : hi;
}

/** Orthonormal frame about the unit vector n; local z is n. Duff et al. 2017,
 *  "Building an Orthonormal Basis, Revisited". */
struct pbnds_frame {
    struct pbnds_vec3 t, b, n;
};

static inline struct pbnds_frame pbnds_frame_from_normal(struct pbnds_vec3 n)
{
    const float sign = copysignf(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    struct pbnds_frame f;
    f.t = pbnds_vec3_make(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    f.b = pbnds_vec3_make(b, sign + n.y * n.y * a, -n.y);
    f.n = n;
    return f;
}
static inline struct pbnds_vec3 pbnds_to_local(const struct pbnds_frame *f,
                                               struct pbnds_vec3 v)
{
    return pbnds_vec3_make(pbnds_dot(f->t, v), pbnds_dot(f->b, v), pbnds_dot(f->n, v));
}
static inline struct pbnds_vec3 pbnds_to_world(const struct pbnds_frame *f,
                                               struct pbnds_vec3 v)
{
    return pbnds_mad(pbnds_mad(pbnds_scale(f->t, v.x), f->b, v.y), f->n, v.z);
}
#endif /* PBNDS_ENGINE_CORE_VEC_H */
