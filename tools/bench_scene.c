#include "tools/bench_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/scene/maps.h"
#include "engine/scene/packet.h"

enum { RINGS = 360, COLUMNS = 720, CELLS = 512, MAP = 2048, MAPS = 3 };
static const float half_side = 3.0f; /* of the ground, metres */

/* Bumps of the unit sphere: a few waves of falling height. */
static float radius_at(float theta, float phi)
{
    float r = 1.0f;
    for (int k = 1; k <= 5; ++k) {
        const float f = (float)(3 * k);
        r += 0.05f / (float)k * sinf(f * theta + (float)k) * cosf(f * phi);
    }
    return r;
}

static bool allocate_mesh(struct pbnds_mesh *mesh, size_t vertices, size_t triangles)
{
    mesh->vertex_count = vertices;
    mesh->triangle_count = triangles;
    mesh->position = calloc(vertices, sizeof *mesh->position);
    mesh->normal = calloc(vertices, sizeof *mesh->normal);
    mesh->tangent = calloc(vertices, sizeof *mesh->tangent);
    mesh->uv[0] = calloc(vertices, sizeof *mesh->uv[0]);
    mesh->index = calloc(3 * triangles, sizeof *mesh->index);
    return mesh->position && mesh->normal && mesh->tangent && mesh->uv[0] &&
           mesh->index;
}

static struct pbnds_vec3 bumpy(float theta, float phi)
{
    const float r = radius_at(theta, phi);
    return pbnds_vec3_make(r * sinf(theta) * cosf(phi), r * cosf(theta) + 0.95f,
                           -r * sinf(theta) * sinf(phi));
}

static void sphere_vertex(struct pbnds_mesh *mesh, size_t i, int ring, int column)
{
    const float step = PBNDS_PI / (float)RINGS;
    const float theta = step * (float)ring;
    const float phi = 2.0f * PBNDS_PI * (float)(column % COLUMNS) / (float)COLUMNS;
    const struct pbnds_vec3 out = {sinf(theta) * cosf(phi), cosf(theta),
                                   -sinf(theta) * sinf(phi)};
    /* The normal from differences; at the poles the sphere's own is near enough. */
    const struct pbnds_vec3 across =
        pbnds_sub(bumpy(theta, phi + 0.5f * step), bumpy(theta, phi - 0.5f * step));
    const struct pbnds_vec3 down =
        pbnds_sub(bumpy(theta + 0.5f * step, phi), bumpy(theta - 0.5f * step, phi));
    struct pbnds_vec3 n = pbnds_cross(down, across);
    const bool pole = ring == 0 || ring == RINGS;
    n = pole ? out : pbnds_normalize(n);
    struct pbnds_vec3 t = pole ? pbnds_vec3_make(-sinf(phi), 0.0f, -cosf(phi)) : across;
    t = pbnds_normalize(pbnds_mad(t, n, -pbnds_dot(t, n)));
    mesh->position[i] = bumpy(theta, phi);
    mesh->normal[i] = n;
    mesh->tangent[i] = (struct pbnds_vec4){t.x, t.y, t.z, 1.0f};
    mesh->uv[0][i] = (struct pbnds_vec2){2.0f * (float)column / (float)COLUMNS,
                                         (float)ring / (float)RINGS};
}

static void fill_sphere(struct pbnds_mesh *mesh)
{
    size_t i = 0;
    for (int ring = 0; ring <= RINGS; ++ring)
        for (int column = 0; column <= COLUMNS; ++column)
            sphere_vertex(mesh, i++, ring, column);
    uint32_t *index = mesh->index;
    for (uint32_t ring = 0; ring < RINGS; ++ring) {
        for (uint32_t column = 0; column < COLUMNS; ++column) {
            const uint32_t a = ring * (COLUMNS + 1) + column, b = a + COLUMNS + 1;
            const uint32_t quad[6] = {a, b, b + 1, a, b + 1, a + 1};
            /* At a pole one of the two has no area. */
            const bool top = ring == 0, bottom = ring == RINGS - 1;
            memcpy(index, quad + (bottom ? 3 : 0), 3 * sizeof *index);
            if (!top && !bottom) memcpy(index + 3, quad + 3, 3 * sizeof *index);
            index += top || bottom ? 3 : 6;
        }
    }
}

static float ground_height(float x, float z)
{
    return 0.03f * (sinf(4.0f * x + 1.0f) * cosf(3.0f * z) +
                    0.4f * sinf(11.0f * x) * sinf(13.0f * z + 2.0f));
}

static void fill_ground(struct pbnds_mesh *mesh)
{
    const float step = 2.0f * half_side / (float)CELLS;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const float u = (float)(i % (CELLS + 1)), v = (float)(i / (CELLS + 1));
        const float x = u * step - half_side, z = v * step - half_side;
        const float dx = ground_height(x + step, z) - ground_height(x - step, z);
        const float dz = ground_height(x, z + step) - ground_height(x, z - step);
        const struct pbnds_vec3 t = {2.0f * step, dx, 0.0f},
                                b = {0.0f, dz, 2.0f * step};
        const struct pbnds_vec3 along = pbnds_normalize(t);
        mesh->position[i] = pbnds_vec3_make(x, ground_height(x, z), z);
        mesh->normal[i] = pbnds_normalize(pbnds_cross(b, t));
        mesh->tangent[i] = (struct pbnds_vec4){along.x, along.y, along.z, 1.0f};
        mesh->uv[0][i] = (struct pbnds_vec2){x, z};
    }
    uint32_t *index = mesh->index;
    for (uint32_t v = 0; v < CELLS; ++v) {
        for (uint32_t u = 0; u < CELLS; ++u, index += 6) {
            const uint32_t a = v * (CELLS + 1) + u, b = a + CELLS + 1;
            const uint32_t quad[6] = {a, b, b + 1, a, b + 1, a + 1};
            memcpy(index, quad, sizeof quad);
        }
    }
}

static uint8_t code(float x)
{
    return (uint8_t)(255.0f * pbnds_clamp(x, 0.0f, 1.0f) + 0.5f);
}

/* Waves that repeat with the map; different ones in each map and channel. */
static void fill_map(struct pbnds_pixels *image, int map, const float sine[MAP])
{
    for (int y = 0; y < MAP; ++y) {
        for (int x = 0; x < MAP; ++x) {
            uint8_t *p = image->u8 + 4 * ((size_t)y * MAP + (size_t)x);
            for (int c = 0; c < 3; ++c) {
                const int a = x * (5 + 8 * map + c) + 3 * y;
                const int b = y * (7 + 9 * c + 2 * map) + 2 * x;
                const float w = 0.5f + 0.25f * (sine[a % MAP] + sine[b % MAP]);
                p[c] = code(map < 2 ? w : (c == 2 ? 0.95f : 0.4f + 0.2f * w));
            }
            p[3] = 255;
        }
    }
}

static bool allocate(struct pbnds_scene *scene)
{
    scene->meshes = calloc(2, sizeof *scene->meshes);
    scene->materials = calloc(2, sizeof *scene->materials);
    scene->textures = calloc(MAPS, sizeof *scene->textures);
    scene->images = calloc(MAPS, sizeof *scene->images);
    if (!scene->meshes || !scene->materials || !scene->textures || !scene->images)
        return false;
    scene->mesh_count = scene->material_count = 2;
    scene->texture_count = scene->image_count = MAPS;
    for (int i = 0; i < MAPS; ++i) {
        scene->images[i] = (struct pbnds_pixels){.width = MAP, .height = MAP};
        scene->images[i].channels = 4;
        scene->images[i].u8 = malloc((size_t)MAP * MAP * 4);
        if (!scene->images[i].u8) return false;
        scene->textures[i].pixels = &scene->images[i];
    }
    return allocate_mesh(&scene->meshes[0], (size_t)(RINGS + 1) * (COLUMNS + 1),
                         (size_t)(2 * RINGS - 2) * COLUMNS) &&
           allocate_mesh(&scene->meshes[1], (size_t)(CELLS + 1) * (CELLS + 1),
                         (size_t)2 * CELLS * CELLS);
}

enum pbnds_status tool_bench_scene(struct pbnds_scene *scene,
                                   struct pbnds_camera *camera,
                                   struct pbnds_error *error)
{
    *scene = (struct pbnds_scene){.mesh_count = 0};
    if (!allocate(scene)) {
        pbnds_scene_free(scene);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "bench: no memory for the scene");
    }
    fill_sphere(&scene->meshes[0]);
    fill_ground(&scene->meshes[1]);
    float sine[MAP];
    for (int i = 0; i < MAP; ++i)
        sine[i] = sinf(2.0f * PBNDS_PI * (float)i / (float)MAP);
    for (int i = 0; i < MAPS; ++i)
        fill_map(&scene->images[i], i, sine);
    for (int i = 0; i < 2; ++i) {
        struct pbnds_material *m = &scene->materials[i];
        *m = pbnds_material_default();
        m->base_color_texture.texture = 0;
        m->metallic_roughness_texture.texture = 1;
        m->normal_texture.texture = 2;
        scene->meshes[i].material = i;
        scene->meshes[i].object_id = (uint32_t)i;
        scene->triangle_count += scene->meshes[i].triangle_count;
    }
    scene->lo = pbnds_vec3_make(-half_side, -0.2f, -half_side);
    scene->hi = pbnds_vec3_make(half_side, 2.1f, half_side);
    *camera = (struct pbnds_camera){.yfov = 40.0f * PBNDS_PI / 180.0f};
    camera->world_from_camera = pbnds_mat4_look_at(pbnds_vec3_make(0.6f, 2.3f, 2.1f),
                                                   pbnds_vec3_make(0.0f, 0.8f, 0.0f),
                                                   pbnds_vec3_make(0.0f, 1.0f, 0.0f));
    PBNDS_TRY(pbnds_scene_pack(scene, error));
    return pbnds_scene_prefilter(scene, 0, error);
}
