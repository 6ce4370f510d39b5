/* Emitting triangles; see light_emissive.h. */
#include "engine/shade/light_emissive.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/report.h"
#include "engine/scene/accel.h"

enum { PROBES = 8 }; /* points that stand for a textured triangle */

static const struct pbnds_vec3 BLACK = {0.0f, 0.0f, 0.0f};

static bool emits(const struct pbnds_scene *scene, const struct pbnds_mesh *mesh)
{
    const struct pbnds_material *m = &scene->materials[mesh->material];
    return !m->unlit && pbnds_max3(m->emissive) > 0.0f;
}

/* Emission and opacity are the same all over the mesh. */
static bool uniform(const struct pbnds_mesh *mesh, const struct pbnds_material *m)
{
    if (m->emissive_texture.texture >= 0) return false;
    return m->alpha_mode == PBNDS_ALPHA_OPAQUE ||
           (!mesh->color && m->base_color_texture.texture < 0);
}

static float presence(const struct pbnds_material *m, float alpha)
{
    if (m->alpha_mode == PBNDS_ALPHA_OPAQUE) return 1.0f;
    if (m->alpha_mode == PBNDS_ALPHA_MASK)
        return alpha >= m->alpha_cutoff ? 1.0f : 0.0f;
    return pbnds_clamp(alpha, 0.0f, 1.0f);
}

static void corners(const struct pbnds_scene *scene, uint32_t mesh, uint32_t triangle,
                    struct pbnds_vec3 p[3])
{
    const struct pbnds_mesh *m = &scene->meshes[mesh];
    for (int k = 0; k < 3; ++k)
        p[k] = m->position[m->index[3 * (size_t)triangle + (size_t)k]];
}

/* Twice the area along the normal, in double: products of short edges leave float. */
static void normal_area(const struct pbnds_vec3 p[3], double n[3])
{
    const double a[3] = {(double)p[1].x - (double)p[0].x,
                         (double)p[1].y - (double)p[0].y,
                         (double)p[1].z - (double)p[0].z};
    const double b[3] = {(double)p[2].x - (double)p[0].x,
                         (double)p[2].y - (double)p[0].y,
                         (double)p[2].z - (double)p[0].z};
    n[0] = a[1] * b[2] - a[2] * b[1];
    n[1] = a[2] * b[0] - a[0] * b[2];
    n[2] = a[0] * b[1] - a[1] * b[0];
}

static struct pbnds_vec3 radiance_at(const struct pbnds_scene *scene,
                                     const struct pbnds_hit *hit, struct pbnds_vec3 wo)
{
    const struct pbnds_mesh *mesh = &scene->meshes[hit->mesh];
    const struct pbnds_material *m = &scene->materials[mesh->material];
    if (uniform(mesh, m)) return pbnds_scale(m->emissive, presence(m, m->base_color.w));
    struct pbnds_surface surface;
    pbnds_scene_surface(scene, hit, wo, 0.0f, &surface);
    return pbnds_scale(surface.emission, presence(m, surface.alpha));
}

/* Uniform on the triangle: the square folded along its diagonal would tear points apart
 * that are neighbours in u, so the root of one number it is (Turk 1990). */
static void barycentric(float u1, float u2, struct pbnds_hit *hit)
{
    const float root = sqrtf(u1);
    hit->u = root * (1.0f - u2);
    hit->v = root * u2;
}

static float mean_luminance(const struct pbnds_scene *scene, uint32_t mesh,
                            uint32_t triangle, struct pbnds_vec3 n)
{
    const struct pbnds_mesh *m = &scene->meshes[mesh];
    const int count = uniform(m, &scene->materials[m->material]) ? 1 : PROBES;
    float sum = 0.0f;
    for (int k = 0; k < count; ++k) {
        /* Hammersley points: the radical inverse of three bits beside the index */
        const int turned = (k & 1) << 2 | (k & 2) | (k & 4) >> 2;
        struct pbnds_hit hit = {.mesh = mesh, .triangle = triangle};
        barycentric(((float)k + 0.5f) / PROBES, ((float)turned + 0.5f) / PROBES, &hit);
        sum += pbnds_luminance(radiance_at(scene, &hit, n));
    }
    return sum / (float)count;
}

static void measure(void *context, size_t i, int thread)
{
    (void)thread;
    const struct pbnds_emissive *e = context;
    const size_t first = e->first[i];
    if (first == SIZE_MAX) return;
    for (size_t k = 0; k < e->scene->meshes[i].triangle_count; ++k) {
        struct pbnds_emissive_triangle *t = &e->triangles[first + k];
        struct pbnds_vec3 p[3];
        double n[3];
        t->mesh = (uint32_t)i;
        t->triangle = (uint32_t)k;
        corners(e->scene, t->mesh, t->triangle, p);
        normal_area(p, n);
        const double twice = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        t->area = (float)(0.5 * twice);
        t->power = 0.0f;
        if (!(t->area > 0.0f) || !isfinite(t->area)) continue;
        const struct pbnds_vec3 wo = {(float)(n[0] / twice), (float)(n[1] / twice),
                                      (float)(n[2] / twice)};
        const float mean = mean_luminance(e->scene, t->mesh, t->triangle, wo);
        const float power = 2.0f * PBNDS_PI * t->area * mean;
        if (power > 0.0f && isfinite(power)) t->power = power;
    }
}

enum pbnds_status pbnds_emissive_create(const struct pbnds_scene *scene,
                                        struct pbnds_emissive *emissive,
                                        struct pbnds_error *error)
{
    memset(emissive, 0, sizeof *emissive);
    emissive->scene = scene;
    const size_t meshes = scene->mesh_count > 0 ? (size_t)scene->mesh_count : 0;
    emissive->first = malloc((meshes + 1) * sizeof *emissive->first);
    for (size_t i = 0; emissive->first && i < meshes; ++i) {
        const bool lit = emits(scene, &scene->meshes[i]);
        emissive->first[i] = lit ? emissive->count : SIZE_MAX;
        if (lit) emissive->count += scene->meshes[i].triangle_count;
    }
    if (emissive->count > 0 && emissive->count < SIZE_MAX / sizeof *emissive->triangles)
        emissive->triangles = malloc(emissive->count * sizeof *emissive->triangles);
    if (!emissive->first || (emissive->count > 0 && !emissive->triangles)) {
        const size_t count = emissive->count;
        pbnds_emissive_free(emissive);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "out of memory for %zu triangles that emit light", count);
    }
    if (emissive->count > 0) pbnds_parallel_for(meshes, measure, emissive);
    if (!pbnds_stop_requested()) return PBNDS_OK;
    pbnds_emissive_free(emissive);
    return pbnds_fail_interrupted(error);
}

void pbnds_emissive_free(struct pbnds_emissive *emissive)
{
    free(emissive->triangles);
    free(emissive->first);
    memset(emissive, 0, sizeof *emissive);
}

size_t pbnds_emissive_find(const struct pbnds_emissive *emissive, uint32_t mesh,
                           uint32_t triangle)
{
    const size_t first = emissive->first[mesh];
    return first == SIZE_MAX ? SIZE_MAX : first + triangle;
}

float pbnds_emissive_pdf(const struct pbnds_emissive *emissive, size_t index, float t,
                         float cos_l)
{
    return t * t / (emissive->triangles[index].area * fabsf(cos_l));
}

bool pbnds_emissive_sample(const struct pbnds_emissive *emissive, size_t index,
                           struct pbnds_vec3 from, float u1, float u2,
                           struct pbnds_emissive_sample *out)
{
    const struct pbnds_emissive_triangle *t = &emissive->triangles[index];
    struct pbnds_vec3 p[3];
    double n[3];
    corners(emissive->scene, t->mesh, t->triangle, p);
    normal_area(p, n);
    out->hit.mesh = t->mesh;
    out->hit.triangle = t->triangle;
    barycentric(u1, u2, &out->hit);
    const struct pbnds_vec3 point = pbnds_mad(
        pbnds_mad(pbnds_scale(p[0], 1.0f - out->hit.u - out->hit.v), p[1], out->hit.u),
        p[2], out->hit.v);
    const struct pbnds_vec3 way = pbnds_sub(point, from);
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    out->hit.t = pbnds_length(way);
    if (!(length > 0.0) || !(out->hit.t > 0.0f) || !isfinite(out->hit.t)) return false;
    out->wi = pbnds_scale(way, 1.0f / out->hit.t);
    struct pbnds_vec3 ng = {(float)(n[0] / length), (float)(n[1] / length),
                            (float)(n[2] / length)};
    const float cos_l = pbnds_dot(ng, out->wi);
    if (cos_l > 0.0f) ng = pbnds_sub(BLACK, ng);
    out->reach = pbnds_offset_origin(point, ng);
    out->pdf = pbnds_emissive_pdf(emissive, index, out->hit.t, cos_l);
    return out->pdf > 0.0f && isfinite(out->pdf);
}

struct pbnds_vec3 pbnds_emissive_radiance(const struct pbnds_emissive *emissive,
                                          const struct pbnds_emissive_sample *sample)
{
    return radiance_at(emissive->scene, &sample->hit, pbnds_scale(sample->wi, -1.0f));
}
