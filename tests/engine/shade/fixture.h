/* Scenes of a few quads built by hand, and everything a shading job needs around them.
 */
#ifndef PBNDS_TESTS_ENGINE_SHADE_FIXTURE_H
#define PBNDS_TESTS_ENGINE_SHADE_FIXTURE_H

#include <stdlib.h>
#include <string.h>

#include "engine/shade/pathtrace.h"
#include "tests/test.h"

struct fixture {
    struct pbnds_scene scene;
    struct pbnds_accel *accel;
    struct pbnds_envmap *envmap;
    struct pbnds_gbuffer gbuffer;
    struct pbnds_shade_job job;
};

static inline void must(enum pbnds_status status, const struct pbnds_error *error)
{
    if (status != PBNDS_OK) fail_msg("%s", error->message);
}

static inline void *must_alloc(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) fail_msg("no memory");
    return p;
}

/* The glTF default material with a colour: matte (f0 = 0 means no specular lobe at all
 * but for the grazing Fresnel rise). */
static inline struct pbnds_material matte(float albedo)
{
    struct pbnds_material m = pbnds_material_default();
    m.base_color = (struct pbnds_vec4){albedo, albedo, albedo, 1.0f};
    m.metallic = 0.0f;
    m.ior_f0 = 0.0f;
    m.double_sided = true; /* the fixtures care little for winding */
    return m;
}

static inline struct pbnds_mesh new_mesh(size_t vertices, size_t triangles,
                                         int material)
{
    struct pbnds_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.vertex_count = vertices;
    mesh.triangle_count = triangles;
    mesh.position = must_alloc(vertices, sizeof *mesh.position);
    mesh.index = must_alloc(3 * triangles, sizeof *mesh.index);
    mesh.material = material;
    return mesh;
}

/* Parallelogram o, o + a, o + a + b, o + b. */
static inline struct pbnds_mesh quad(struct pbnds_vec3 o, struct pbnds_vec3 a,
                                     struct pbnds_vec3 b, int material)
{
    static const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    struct pbnds_mesh mesh = new_mesh(4, 2, material);
    mesh.position[0] = o;
    mesh.position[1] = pbnds_add(o, a);
    mesh.position[2] = pbnds_add(mesh.position[1], b);
    mesh.position[3] = pbnds_add(o, b);
    memcpy(mesh.index, index, sizeof index);
    return mesh;
}

/* Horizontal square of the given half side at height y. */
static inline struct pbnds_mesh floor_at(float y, float half, int material)
{
    return quad(pbnds_vec3_make(-half, y, half),
                pbnds_vec3_make(2.0f * half, 0.0f, 0.0f),
                pbnds_vec3_make(0.0f, 0.0f, -2.0f * half), material);
}

/* Axis-aligned cube about the origin. */
static inline struct pbnds_mesh cube(float half, int material)
{
    static const uint32_t index[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6,
                                       0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7,
                                       0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    struct pbnds_mesh mesh = new_mesh(8, 12, material);
    for (int i = 0; i < 8; ++i)
        mesh.position[i] = pbnds_vec3_make(i & 1 ? half : -half, i & 2 ? half : -half,
                                           i & 4 ? half : -half);
    memcpy(mesh.index, index, sizeof index);
    return mesh;
}

/* Sphere about `centre` with smooth normals. */
static inline struct pbnds_mesh sphere(struct pbnds_vec3 centre, float radius,
                                       int rings, int material)
{
    const int columns = 2 * rings;
    struct pbnds_mesh mesh = new_mesh((size_t)((rings + 1) * (columns + 1)),
                                      (size_t)(2 * rings * columns), material);
    mesh.normal = must_alloc(mesh.vertex_count, sizeof *mesh.normal);
    size_t v = 0, t = 0;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j <= columns; ++j, ++v) {
            const float theta = PBNDS_PI * (float)i / (float)rings;
            const float phi = 2.0f * PBNDS_PI * (float)j / (float)columns;
            mesh.normal[v] = pbnds_vec3_make(sinf(theta) * cosf(phi), cosf(theta),
                                             -sinf(theta) * sinf(phi));
            mesh.position[v] = pbnds_mad(centre, mesh.normal[v], radius);
        }
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < columns; ++j) {
            const uint32_t a = (uint32_t)(i * (columns + 1) + j), b = a + 1;
            const uint32_t c = a + (uint32_t)columns + 1, d = c + 1;
            const uint32_t two[6] = {a, c, d, a, d, b};
            memcpy(mesh.index + 3 * t, two, sizeof two);
            t += 2;
        }
    return mesh;
}

/* Takes the meshes over; builds the BVH. */
static inline void fixture_scene(struct fixture *f, const struct pbnds_mesh *meshes,
                                 int mesh_count, const struct pbnds_material *materials,
                                 int material_count)
{
    struct pbnds_error error;
    memset(f, 0, sizeof *f);
    struct pbnds_scene *scene = &f->scene;
    scene->meshes = must_alloc((size_t)mesh_count, sizeof *meshes);
    memcpy(scene->meshes, meshes, (size_t)mesh_count * sizeof *meshes);
    scene->mesh_count = mesh_count;
    scene->materials = must_alloc((size_t)material_count, sizeof *materials);
    memcpy(scene->materials, materials, (size_t)material_count * sizeof *materials);
    scene->material_count = material_count;
    scene->lo = pbnds_splat(INFINITY);
    scene->hi = pbnds_splat(-INFINITY);
    for (int m = 0; m < mesh_count; ++m) {
        scene->triangle_count += meshes[m].triangle_count;
        for (size_t v = 0; v < meshes[m].vertex_count; ++v) {
            const struct pbnds_vec3 p = meshes[m].position[v];
            scene->lo =
                pbnds_vec3_make(fminf(scene->lo.x, p.x), fminf(scene->lo.y, p.y),
                                fminf(scene->lo.z, p.z));
            scene->hi =
                pbnds_vec3_make(fmaxf(scene->hi.x, p.x), fmaxf(scene->hi.y, p.y),
                                fmaxf(scene->hi.z, p.z));
        }
    }
    must(pbnds_accel_create(scene, &f->accel, &error), &error);
    f->job.scene = scene;
    f->job.accel = f->accel;
    f->job.shadows = -1;
    f->job.seed = 7;
}

/* A texture of float texels for the scene, nearest, repeated; its index is 0. */
static inline void fixture_texture_rgba(struct fixture *f, const float *texels,
                                        int width, int height)
{
    struct pbnds_scene *scene = &f->scene;
    const size_t size = 4 * (size_t)width * (size_t)height * sizeof *texels;
    scene->images = must_alloc(1, sizeof *scene->images);
    scene->textures = must_alloc(1, sizeof *scene->textures);
    scene->image_count = scene->texture_count = 1;
    scene->images[0].width = width;
    scene->images[0].height = height;
    scene->images[0].channels = 4;
    scene->images[0].f32 = must_alloc(1, size);
    memcpy(scene->images[0].f32, texels, size);
    scene->textures[0].pixels = &scene->images[0];
    scene->textures[0].nearest = true;
}

/* Looks from eye at target; 40 degrees. */
static inline void fixture_view(struct fixture *f, struct pbnds_vec3 eye,
                                struct pbnds_vec3 target, int width, int height)
{
    struct pbnds_error error;
    struct pbnds_camera camera;
    memset(&camera, 0, sizeof camera);
    const struct pbnds_vec3 up =
        fabsf(eye.x - target.x) + fabsf(eye.z - target.z) < 1e-6f
            ? pbnds_vec3_make(0.0f, 0.0f, -1.0f)
            : pbnds_vec3_make(0.0f, 1.0f, 0.0f);
    camera.world_from_camera = pbnds_mat4_look_at(eye, target, up);
    camera.yfov = 40.0f * PBNDS_PI / 180.0f;
    must(pbnds_gbuffer_raycast(&f->scene, f->accel, &camera, width, height, NULL,
                               &f->gbuffer, &error),
         &error);
    f->job.gbuffer = &f->gbuffer;
}

/* A light map from a function of direction's texel: rows x 2 rows. */
static inline void fixture_light(struct fixture *f, int rows,
                                 struct pbnds_vec3 (*radiance)(float u, float v))
{
    struct pbnds_error error;
    struct pbnds_image image;
    must(pbnds_image_init(&image, 2 * rows, rows, 3, &error), &error);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < 2 * rows; ++x) {
            const struct pbnds_vec3 l = radiance(((float)x + 0.5f) / (float)(2 * rows),
                                                 ((float)y + 0.5f) / (float)rows);
            float *out = pbnds_image_at(&image, x, y);
            out[0] = l.x, out[1] = l.y, out[2] = l.z;
        }
    pbnds_envmap_free(f->envmap);
    must(pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &f->envmap, &error),
         &error);
    pbnds_image_free(&image);
    f->job.envmap = f->envmap;
}

static inline struct pbnds_vec3 light_white(float u, float v)
{
    (void)u, (void)v;
    return pbnds_splat(1.0f);
}

static inline struct pbnds_vec3 light_black(float u, float v)
{
    (void)u, (void)v;
    return pbnds_splat(0.0f);
}

/* A dim sky, a bright small sun 45 degrees up, a dark ground. */
static inline struct pbnds_vec3 light_sunny(float u, float v)
{
    const bool sun = fabsf(u - 0.5f) < 0.02f && fabsf(v - 0.25f) < 0.04f;
    if (sun) return pbnds_vec3_make(120.0f, 100.0f, 80.0f);
    return v < 0.5f ? pbnds_vec3_make(0.3f, 0.5f, 0.9f) : pbnds_splat(0.05f);
}

static inline void fixture_free(struct fixture *f)
{
    pbnds_gbuffer_free(&f->gbuffer);
    pbnds_accel_free(f->accel);
    pbnds_scene_free(&f->scene);
    pbnds_envmap_free(f->envmap);
    memset(f, 0, sizeof *f);
}

/* Mean over the covered pixels of one channel. */
static inline double covered_mean(const struct fixture *f,
                                  const struct pbnds_image *image, int channel)
{
    double sum = 0.0, count = 0.0;
    const size_t n = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < n; ++i) {
        if (!(f->gbuffer.coverage[i] > 0.0f)) continue;
        sum += (double)image->data[3 * i + (size_t)channel];
        count += 1.0;
    }
    assert_true(count > 0.0);
    return sum / count;
}
#endif
