/* libFuzzer target: any bytes as a .glb or .gltf that may open no file, as it is and with
 * its variant, its animation and its motion. Whatever loads must be sound. */
#include <math.h>
#include <stdlib.h>

#include "tests/fuzz/gltf_input.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(bool holds)
{
    if (!holds) abort();
}

static bool finite3(struct pbnds_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static bool is_unit(struct pbnds_vec3 v)
{
    return fabsf(pbnds_length(v) - 1.0f) < 1e-3f;
}

static void check_vertex(const struct pbnds_mesh *m, size_t i)
{
    demand(finite3(m->position[i]));
    if (m->previous) demand(finite3(m->previous[i]));
    if (m->normal) demand(is_unit(m->normal[i]));
    if (m->tangent) {
        const struct pbnds_vec4 t = m->tangent[i];
        demand(is_unit(pbnds_vec3_make(t.x, t.y, t.z)) && fabsf(t.w) == 1.0f);
    }
    for (int set = 0; set < 2; ++set) {
        if (!m->uv[set]) continue;
        demand(isfinite(m->uv[set][i].x) && isfinite(m->uv[set][i].y));
    }
    if (m->color) demand(isfinite(m->color[i].x) && isfinite(m->color[i].w));
}

static void check_mesh(const struct pbnds_scene *scene, const struct pbnds_mesh *m)
{
    demand(m->material >= 0 && m->material < scene->material_count);
    demand(m->object_id < (uint32_t)scene->object_count);
    demand(m->triangle_count > 0);
    for (size_t k = 0; k < 3 * m->triangle_count; ++k)
        demand(m->index[k] < m->vertex_count);
    for (size_t k = 0; k < m->vertex_count; ++k)
        check_vertex(m, k);
}

static void check_ref(const struct pbnds_scene *scene,
                      const struct pbnds_texture_ref *ref)
{
    demand(ref->texture < scene->texture_count);
    demand(ref->texture < 0 || ref->texcoord == 0 || ref->texcoord == 1);
    for (int i = 0; i < 6 && ref->texture >= 0 && ref->transformed; ++i)
        demand(isfinite(ref->transform[i]));
}

static void check_material(const struct pbnds_scene *scene,
                           const struct pbnds_material *m)
{
    const struct pbnds_texture_ref *const refs[] = {
        &m->base_color_texture,    &m->metallic_roughness_texture, &m->normal_texture,
        &m->emissive_texture,      &m->occlusion_texture,          &m->specular_texture,
        &m->specular_color_texture};
    for (size_t i = 0; i < sizeof refs / sizeof refs[0]; ++i)
        check_ref(scene, refs[i]);
    demand(m->metallic >= 0.0f && m->metallic <= 1.0f);
    demand(m->roughness >= 0.0f && m->roughness <= 1.0f);
    demand(finite3(m->emissive) && finite3(m->specular_color) && isfinite(m->ior_f0));
}

static void check(const struct pbnds_scene *scene)
{
    for (int i = 0; i < scene->mesh_count; ++i)
        check_mesh(scene, &scene->meshes[i]);
    for (int i = 0; i < scene->material_count; ++i)
        check_material(scene, &scene->materials[i]);
    for (int i = 0; i < scene->texture_count; ++i) {
        const struct pbnds_pixels *p = scene->textures[i].pixels;
        demand(p && p->width > 0 && p->height > 0 && (p->u8 || p->f32));
    }
    for (int i = 0; i < scene->light_count; ++i) {
        const struct pbnds_light *l = &scene->lights[i];
        demand(finite3(l->position) && is_unit(l->direction) && finite3(l->intensity));
        demand(l->range > 0.0f && l->cos_inner >= l->cos_outer);
    }
    for (int i = 0; i < scene->camera_count; ++i) {
        for (int k = 0; k < 16; ++k)
            demand(isfinite(scene->cameras[i].world_from_camera.m[k]));
    }
}

static void load(const uint8_t *data, size_t size,
                 const struct pbnds_gltf_options *options)
{
    struct pbnds_scene scene;
    if (fuzz_load(data, size, options, &scene) == PBNDS_OK) check(&scene);
    pbnds_scene_free(&scene);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct pbnds_gltf_options plain = fuzz_options(),
                                    moving = fuzz_options_moving(),
                                    variant = fuzz_options_variant();
    struct pbnds_gltf_options late = plain;
    late.posed = true;
    late.time = 1e6;
    load(data, size, &plain);
    load(data, size, &late);
    load(data, size, &moving);
    load(data, size, &variant);
    return 0;
}
