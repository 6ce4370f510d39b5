/** Small scenes in memory for the tests of the ray caster and what stands on it. */
#ifndef PBNDS_TESTS_SCENE_FIXTURE_H
#define PBNDS_TESTS_SCENE_FIXTURE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "engine/scene/scene.h"

enum { FIXTURE_MAX = 4 };

/** A scene whose arrays live in this struct; mesh arrays are the test's own. */
struct fixture {
    struct pbnds_scene scene;
    struct pbnds_mesh meshes[FIXTURE_MAX];
    struct pbnds_material materials[FIXTURE_MAX];
    struct pbnds_texture textures[FIXTURE_MAX];
    struct pbnds_pixels images[FIXTURE_MAX];
};

/** Empty, with one grey default material. */
static inline void fixture_init(struct fixture *f)
{
    memset(f, 0, sizeof *f);
    f->scene.meshes = f->meshes;
    f->scene.materials = f->materials;
    f->scene.textures = f->textures;
    f->scene.images = f->images;
    for (int i = 0; i < FIXTURE_MAX; ++i) {
        struct pbnds_material *m = &f->materials[i];
        *m = pbnds_material_default();
        m->base_color = (struct pbnds_vec4){0.5f, 0.5f, 0.5f, 1.0f};
        m->metallic = 0.0f;
        m->double_sided = true; /* the fixtures care little for winding */
        m->normal_scale = 1.0f;
        m->alpha_cutoff = 0.5f;
        m->base_color_texture.texture = -1;
        m->metallic_roughness_texture.texture = -1;
        m->normal_texture.texture = -1;
        m->emissive_texture.texture = -1;
    }
    f->scene.material_count = FIXTURE_MAX;
}

static inline struct pbnds_mesh *fixture_mesh(struct fixture *f,
                                              struct pbnds_vec3 *position,
                                              size_t vertices, uint32_t *index,
                                              size_t triangles)
{
    struct pbnds_mesh *mesh = &f->meshes[f->scene.mesh_count];
    mesh->position = position;
    mesh->vertex_count = vertices;
    mesh->index = index;
    mesh->triangle_count = triangles;
    mesh->object_id = (uint32_t)f->scene.mesh_count + 10u;
    f->scene.mesh_count += 1;
    f->scene.triangle_count += triangles;
    return mesh;
}

/** A texture of 4-channel float texels, nearest, repeated. @return its index */
static inline int fixture_texture(struct fixture *f, float *texels, int width,
                                  int height)
{
    const int i = f->scene.texture_count++;
    f->scene.image_count = f->scene.texture_count;
    f->images[i].width = width;
    f->images[i].height = height;
    f->images[i].channels = 4;
    f->images[i].f32 = texels;
    f->textures[i].pixels = &f->images[i];
    f->textures[i].nearest = true;
    return i;
}

/** A sphere of smooth normals, closed: the poles are single vertices and the seam is
 *  shared. Free position, normal and index. */
static inline struct pbnds_mesh *fixture_sphere(struct fixture *f,
                                                struct pbnds_vec3 center, float radius,
                                                uint32_t rings)
{
    const uint32_t around = 2 * rings, body = (rings - 1) * around;
    const size_t vertices = body + 2, triangles = 2 * (size_t)body;
    struct pbnds_vec3 *p = malloc(vertices * sizeof *p),
                      *n = malloc(vertices * sizeof *n);
    uint32_t *index = malloc(3 * triangles * sizeof *index);
    for (uint32_t r = 0; r + 1 < rings; ++r) {
        const float theta = PBNDS_PI * (float)(r + 1) / (float)rings;
        for (uint32_t a = 0; a < around; ++a) {
            const float phi = 2.0f * PBNDS_PI * (float)a / (float)around;
            n[r * around + a] = pbnds_vec3_make(sinf(theta) * cosf(phi), cosf(theta),
                                                sinf(theta) * sinf(phi));
        }
    }
    n[body] = pbnds_vec3_make(0.0f, 1.0f, 0.0f);
    n[body + 1] = pbnds_vec3_make(0.0f, -1.0f, 0.0f);
    for (size_t i = 0; i < vertices; ++i)
        p[i] = pbnds_mad(center, n[i], radius);
    uint32_t *at = index;
    for (uint32_t a = 0; a < around; ++a) {
        const uint32_t b = (a + 1) % around, last = (rings - 2) * around;
        const uint32_t caps[6] = {body, b, a, body + 1, last + a, last + b};
        memcpy(at, caps, sizeof caps);
        at += 6;
        for (uint32_t r = 0; r + 2 < rings; ++r) {
            const uint32_t u = r * around, d = u + around;
            const uint32_t quad[6] = {u + a, u + b, d + a, u + b, d + b, d + a};
            memcpy(at, quad, sizeof quad);
            at += 6;
        }
    }
    struct pbnds_mesh *mesh = fixture_mesh(f, p, vertices, index, triangles);
    mesh->normal = n;
    return mesh;
}

static inline float fixture_uniform(struct pbnds_rng *rng, float lo, float hi)
{
    return lo + (hi - lo) * pbnds_rng_float(rng);
}

static inline struct pbnds_vec3 fixture_direction(struct pbnds_rng *rng)
{
    const float z = fixture_uniform(rng, -1.0f, 1.0f);
    const float phi = fixture_uniform(rng, 0.0f, 2.0f * PBNDS_PI);
    const float s = sqrtf(fmaxf(0.0f, 1.0f - z * z));
    return pbnds_normalize(pbnds_vec3_make(s * cosf(phi), s * sinf(phi), z));
}
#endif /* PBNDS_TESTS_SCENE_FIXTURE_H */
