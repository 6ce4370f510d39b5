/* A naive path tracer, in double: what the reference must agree with.
 *
 * Uniform directions over the hemisphere, every ray against every triangle, independent
 * random numbers. No next-event estimation (but of lights without extent, which nothing
 * else finds: all of them, at every surface), no importance sampling, no MIS, no roulette,
 * no BVH. It shares with the engine what other tests judge: the scene's structs, the ray of
 * a pixel, the value of the BRDF (not its sampling) and the lookup of textured emission.
 * Meshes must have no vertex normals, materials no textures but the emissive one, and
 * alpha the same all over. */
#ifndef PBNDS_TESTS_REFERENCE_BRUTE_FORCE_H
#define PBNDS_TESTS_REFERENCE_BRUTE_FORCE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "engine/core/rng.h"
#include "engine/scene/camera.h"
#include "engine/scene/scene.h"
#include "engine/shade/bsdf.h"

struct brute {
    const struct pbnds_scene *scene;
    struct pbnds_vec3 (*sky)(float u, float v); /* of a texel's centre; NULL: black */
    int sky_rows;
    int max_bounces;
};

struct brute3 {
    double v[3];
};

static inline struct brute3 brute3_of(struct pbnds_vec3 a)
{
    return (struct brute3){{(double)a.x, (double)a.y, (double)a.z}};
}
static inline struct pbnds_vec3 brute3_float(struct brute3 a)
{
    return pbnds_vec3_make((float)a.v[0], (float)a.v[1], (float)a.v[2]);
}
static inline struct brute3 brute3_mad(struct brute3 a, struct brute3 b, double s)
{
    return (struct brute3){
        {a.v[0] + b.v[0] * s, a.v[1] + b.v[1] * s, a.v[2] + b.v[2] * s}};
}
static inline struct brute3 brute3_sub(struct brute3 a, struct brute3 b)
{
    return brute3_mad(a, b, -1.0);
}
static inline double brute3_dot(struct brute3 a, struct brute3 b)
{
    return a.v[0] * b.v[0] + a.v[1] * b.v[1] + a.v[2] * b.v[2];
}
static inline struct brute3 brute3_cross(struct brute3 a, struct brute3 b)
{
    return (struct brute3){{a.v[1] * b.v[2] - a.v[2] * b.v[1],
                            a.v[2] * b.v[0] - a.v[0] * b.v[2],
                            a.v[0] * b.v[1] - a.v[1] * b.v[0]}};
}
static inline struct brute3 brute3_unit(struct brute3 a)
{
    const struct brute3 zero = {{0, 0, 0}};
    return brute3_mad(zero, a, 1.0 / sqrt(brute3_dot(a, a)));
}

static inline double brute_random(struct pbnds_rng *rng)
{
    return (double)(pbnds_rng_u64(rng) >> 11) * 0x1p-53;
}

struct brute_hit {
    double t, u, v;
    int mesh; /* -1: nothing */
    uint32_t triangle;
    struct brute3 normal; /* unit, of the winding */
};

/* Moeller and Trumbore 1997. */
static inline bool brute_triangle(const struct pbnds_mesh *mesh, uint32_t k,
                                  struct brute3 o, struct brute3 d,
                                  struct brute_hit *hit)
{
    const uint32_t *i = mesh->index + 3 * (size_t)k;
    const struct brute3 p = brute3_of(mesh->position[i[0]]);
    const struct brute3 e1 = brute3_sub(brute3_of(mesh->position[i[1]]), p);
    const struct brute3 e2 = brute3_sub(brute3_of(mesh->position[i[2]]), p);
    const struct brute3 h = brute3_cross(d, e2), s = brute3_sub(o, p);
    const double det = brute3_dot(e1, h);
    if (fabs(det) < 1e-14) return false;
    hit->u = brute3_dot(s, h) / det;
    const struct brute3 q = brute3_cross(s, e1);
    hit->v = brute3_dot(d, q) / det;
    hit->t = brute3_dot(e2, q) / det;
    if (hit->t < 1e-6 || hit->u < 0 || hit->v < 0 || hit->u + hit->v > 1) return false;
    hit->triangle = k;
    hit->normal = brute3_unit(brute3_cross(e1, e2));
    return true;
}

static inline double brute_alpha(const struct pbnds_material *m)
{
    const double alpha = (double)m->base_color.w;
    if (m->alpha_mode == PBNDS_ALPHA_OPAQUE) return 1.0;
    if (m->alpha_mode == PBNDS_ALPHA_MASK) return alpha >= (double)m->alpha_cutoff;
    return alpha;
}

/* Each layer is there, or is not, by chance. */
static inline struct brute_hit brute_closest(const struct brute *b, struct brute3 o,
                                             struct brute3 d, struct pbnds_rng *rng)
{
    struct brute_hit best = {.t = (double)INFINITY, .mesh = -1};
    for (int m = 0; m < b->scene->mesh_count; ++m) {
        const struct pbnds_mesh *mesh = &b->scene->meshes[m];
        const double alpha = brute_alpha(&b->scene->materials[mesh->material]);
        for (uint32_t k = 0; k < mesh->triangle_count; ++k) {
            struct brute_hit hit = {.mesh = m};
            if (!brute_triangle(mesh, k, o, d, &hit) || hit.t >= best.t) continue;
            if (alpha < 1.0 && brute_random(rng) >= alpha) continue;
            best = hit;
        }
    }
    return best;
}

/* What the layers between two points let through. */
static inline double brute_clear(const struct brute *b, struct brute3 o,
                                 struct brute3 d, double distance)
{
    double clear = 1.0;
    for (int m = 0; m < b->scene->mesh_count; ++m) {
        const struct pbnds_mesh *mesh = &b->scene->meshes[m];
        const double alpha = brute_alpha(&b->scene->materials[mesh->material]);
        for (uint32_t k = 0; k < mesh->triangle_count; ++k) {
            struct brute_hit hit;
            if (brute_triangle(mesh, k, o, d, &hit) && hit.t < distance)
                clear *= 1.0 - alpha;
        }
    }
    return clear;
}

static inline struct brute3 brute_sky(const struct brute *b, struct brute3 d)
{
    if (!b->sky) return (struct brute3){{0, 0, 0}};
    const double pi = 3.14159265358979323846;
    const double u = 0.5 + atan2(d.v[2], d.v[0]) / (2 * pi);
    const double v = acos(fmax(-1, fmin(1, d.v[1]))) / pi;
    const int columns = 2 * b->sky_rows;
    const int x = (int)fmin(floor(u * columns), columns - 1);
    const int y = (int)fmin(floor(v * b->sky_rows), b->sky_rows - 1);
    return brute3_of(b->sky(((float)x + 0.5f) / (float)columns,
                            ((float)y + 0.5f) / (float)b->sky_rows));
}

/* f(wo, wi) (n.wi) */
static inline struct brute3 brute_reflect(const struct pbnds_material *m,
                                          struct brute3 n, struct brute3 wo,
                                          struct brute3 wi)
{
    const struct pbnds_vec3 base = {m->base_color.x, m->base_color.y, m->base_color.z};
    const struct pbnds_vec3 f0 =
        pbnds_scale(m->specular_color, m->ior_f0 * m->specular);
    const struct pbnds_bsdf bsdf = pbnds_bsdf_make(brute3_float(n), base, m->metallic,
                                                   m->roughness, f0, m->specular);
    const struct brute3 zero = {{0, 0, 0}};
    return brute3_mad(
        zero, brute3_of(pbnds_bsdf_eval(&bsdf, brute3_float(wo), brute3_float(wi))),
        brute3_dot(n, wi));
}

/* Irradiance from a light without extent at p, and the way to it. */
static inline double brute_light(const struct pbnds_light *light, struct brute3 p,
                                 struct brute3 *wi, double *distance)
{
    const struct brute3 zero = {{0, 0, 0}}, axis = brute3_of(light->direction);
    *wi = brute3_sub(zero, axis);
    *distance = (double)INFINITY;
    if (light->kind == PBNDS_LIGHT_DIRECTIONAL) return 1.0;
    const struct brute3 way = brute3_sub(brute3_of(light->position), p);
    const double d2 = brute3_dot(way, way), range = (double)light->range;
    *wi = brute3_unit(way);
    *distance = sqrt(d2);
    double e = fmax(0, fmin(1, 1 - pow(*distance / range, 4))) / d2;
    if (light->kind == PBNDS_LIGHT_SPOT) {
        const double inner = (double)light->cos_inner, outer = (double)light->cos_outer;
        const double s = fmax(
            0, fmin(1, (-brute3_dot(*wi, axis) - outer) / fmax(0.001, inner - outer)));
        e *= s * s;
    }
    return e;
}

static inline struct brute3 brute_punctual(const struct brute *b,
                                           const struct pbnds_material *m,
                                           struct brute3 p, struct brute3 n,
                                           struct brute3 wo)
{
    struct brute3 sum = {{0, 0, 0}};
    for (int i = 0; i < b->scene->light_count; ++i) {
        const struct pbnds_light *light = &b->scene->lights[i];
        struct brute3 wi;
        double distance;
        const double e = brute_light(light, p, &wi, &distance);
        if (e <= 0 || brute3_dot(wi, n) <= 0) continue;
        const struct brute3 f = brute_reflect(m, n, wo, wi);
        const struct brute3 intensity = brute3_of(light->intensity);
        const double seen = e * brute_clear(b, p, wi, distance);
        for (int c = 0; c < 3; ++c)
            sum.v[c] += f.v[c] * intensity.v[c] * seen;
    }
    return sum;
}

static inline struct brute3 brute_emission(const struct brute *b,
                                           const struct brute_hit *hit,
                                           const struct pbnds_material *m)
{
    if (m->unlit)
        return (struct brute3){{(double)m->base_color.x, (double)m->base_color.y,
                                (double)m->base_color.z}};
    if (m->emissive_texture.texture < 0) return brute3_of(m->emissive);
    const struct pbnds_hit where = {(float)hit->t, (float)hit->u, (float)hit->v,
                                    (uint32_t)hit->mesh, hit->triangle};
    struct pbnds_surface surface;
    pbnds_scene_surface(b->scene, &where, pbnds_vec3_make(0, 1, 0), 0, &surface);
    return brute3_of(surface.emission);
}

/* A direction uniform over the hemisphere about n: density 1 / 2 pi. */
static inline struct brute3 brute_hemisphere(struct brute3 n, struct pbnds_rng *rng)
{
    const double z = 2 * brute_random(rng) - 1, r = sqrt(1 - z * z);
    const double phi = 2 * 3.14159265358979323846 * brute_random(rng);
    const struct brute3 d = {{r * cos(phi), r * sin(phi), z}}, zero = {{0, 0, 0}};
    return brute3_dot(d, n) < 0 ? brute3_sub(zero, d) : d;
}

/* One sample of the light that surfaces send along a camera ray; false: none is met. */
static inline bool brute_sample(const struct brute *b, struct brute3 o, struct brute3 d,
                                struct pbnds_rng *rng, struct brute3 *light)
{
    const double pi = 3.14159265358979323846;
    const struct brute3 zero = {{0, 0, 0}};
    struct brute3 weight = {{1, 1, 1}};
    *light = zero;
    for (int surfaces = 0;; ++surfaces) {
        const struct brute_hit hit = brute_closest(b, o, d, rng);
        if (hit.mesh < 0) {
            if (surfaces == 0) return false;
            const struct brute3 sky = brute_sky(b, d);
            for (int c = 0; c < 3; ++c)
                light->v[c] += weight.v[c] * sky.v[c];
            return true;
        }
        if (surfaces > b->max_bounces) return true;
        const struct pbnds_material *m =
            &b->scene->materials[b->scene->meshes[hit.mesh].material];
        const struct brute3 wo = brute3_sub(zero, d), p = brute3_mad(o, d, hit.t);
        const struct brute3 n =
            brute3_dot(hit.normal, wo) < 0 ? brute3_sub(zero, hit.normal) : hit.normal;
        const struct brute3 emitted = brute_emission(b, &hit, m);
        for (int c = 0; c < 3; ++c)
            light->v[c] += weight.v[c] * emitted.v[c];
        if (m->unlit) return true;
        const struct brute3 punctual = brute_punctual(b, m, p, n, wo);
        const struct brute3 wi = brute_hemisphere(n, rng);
        const struct brute3 f = brute_reflect(m, n, wo, wi);
        for (int c = 0; c < 3; ++c) {
            light->v[c] += weight.v[c] * punctual.v[c];
            weight.v[c] *= f.v[c] * 2 * pi;
        }
        o = p;
        d = wi;
    }
}

/* Means of one pixel's channels with the variances of these means. Light that no surface
 * sent counts as none. */
static inline void brute_pixel(const struct brute *b, const struct pbnds_ray *ray,
                               uint64_t pixel, int samples, double mean[3],
                               double variance[3])
{
    double sum[3] = {0, 0, 0}, square[3] = {0, 0, 0};
    for (int s = 0; s < samples; ++s) {
        struct pbnds_rng rng = pbnds_rng_make(0xb7f0, pixel, (uint64_t)s);
        struct brute3 light;
        if (!brute_sample(b, brute3_of(ray->origin),
                          brute3_unit(brute3_of(ray->direction)), &rng, &light))
            continue;
        for (int c = 0; c < 3; ++c) {
            sum[c] += light.v[c];
            square[c] += light.v[c] * light.v[c];
        }
    }
    for (int c = 0; c < 3; ++c) {
        mean[c] = sum[c] / samples;
        variance[c] = fmax(square[c] / samples - mean[c] * mean[c], 0) / (samples - 1);
    }
}
#endif
