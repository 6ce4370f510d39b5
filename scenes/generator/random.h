/**
 * @file random.h
 * Draws for the scene generator. Each takes one number from the stream and is a
 * statement of its own: C does not say in which order the arguments of a call are
 * evaluated.
 */
#ifndef PBNDS_SCENES_RANDOM_H
#define PBNDS_SCENES_RANDOM_H

#include <stdbool.h>

#include "engine/core/rng.h"
#include "engine/core/vec.h"

static inline float gen_uniform(struct pbnds_rng *r, float lo, float hi)
{
    return lo + (hi - lo) * pbnds_rng_float(r);
}
/** Uniform on a logarithmic scale; lo > 0. */
static inline float gen_log_uniform(struct pbnds_rng *r, float lo, float hi)
{
    return lo * powf(hi / lo, pbnds_rng_float(r));
}
/** 0 to n - 1. */
static inline int gen_below(struct pbnds_rng *r, int n)
{
    return (int)(pbnds_rng_float(r) * (float)n);
}
/** lo to hi, both included. */
static inline int gen_between(struct pbnds_rng *r, int lo, int hi)
{
    return lo + gen_below(r, hi - lo + 1);
}
static inline bool gen_chance(struct pbnds_rng *r, float p)
{
    return pbnds_rng_float(r) < p;
}
static inline struct pbnds_vec3 gen_vec3(struct pbnds_rng *r, float lo, float hi)
{
    struct pbnds_vec3 v;
    v.x = gen_uniform(r, lo, hi);
    v.y = gen_uniform(r, lo, hi);
    v.z = gen_uniform(r, lo, hi);
    return v;
}
/** Index drawn with the given weights. */
static inline int gen_pick(struct pbnds_rng *r, const float *weights, int n)
{
    float total = 0.0f;
    for (int i = 0; i < n; ++i)
        total += weights[i];
    float x = pbnds_rng_float(r) * total;
    for (int i = 0; i < n - 1; ++i) {
        if (x < weights[i]) return i;
        x -= weights[i];
    }
    return n - 1;
}
/** Quaternion of a turn by `angle` radians about a unit axis. */
static inline struct pbnds_vec4 gen_turn(struct pbnds_vec3 axis, float angle)
{
    const float s = sinf(0.5f * angle);
    const struct pbnds_vec4 q = {axis.x * s, axis.y * s, axis.z * s,
                                 cosf(0.5f * angle)};
    return q;
}
/** a after b. */
static inline struct pbnds_vec4 gen_quat_mul(struct pbnds_vec4 a, struct pbnds_vec4 b)
{
    const struct pbnds_vec4 q = {
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    };
    return q;
}
/** Uniform rotation (Shoemake 1992). */
static inline struct pbnds_vec4 gen_rotation(struct pbnds_rng *r)
{
    const float u = pbnds_rng_float(r);
    const float a = gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
    const float b = gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
    const float p = sqrtf(1.0f - u), q = sqrtf(u);
    const struct pbnds_vec4 rotation = {p * sinf(a), p * cosf(a), q * sinf(b),
                                        q * cosf(b)};
    return rotation;
}
/** v turned by the unit quaternion q. */
static inline struct pbnds_vec3 gen_rotate(struct pbnds_vec4 q, struct pbnds_vec3 v)
{
    const struct pbnds_vec3 u = {q.x, q.y, q.z};
    const struct pbnds_vec3 t = pbnds_scale(pbnds_cross(u, v), 2.0f);
    return pbnds_add(pbnds_mad(v, t, q.w), pbnds_cross(u, t));
}
#endif /* PBNDS_SCENES_RANDOM_H */
