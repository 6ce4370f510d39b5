#include "engine/scene/scene.h"

#include <stdlib.h>
#include <string.h>

#include "engine/scene/maps.h"

struct pbnds_material pbnds_material_default(void)
{
    const struct pbnds_texture_ref none = {.texture = -1};
    struct pbnds_material m = {
        .base_color = {1.0f, 1.0f, 1.0f, 1.0f},
        .metallic = 1.0f,
        .roughness = 1.0f,
        .ior_f0 = 0.04f,
        .specular = 1.0f,
        .specular_color = {1.0f, 1.0f, 1.0f},
        .normal_scale = 1.0f,
        .occlusion_strength = 1.0f,
        .alpha_cutoff = 0.5f,
        .base_color_texture = none,
        .metallic_roughness_texture = none,
        .normal_texture = none,
        .emissive_texture = none,
        .occlusion_texture = none,
        .specular_texture = none,
        .specular_color_texture = none,
    };
    memcpy(m.name, "default", sizeof "default");
    return m;
}

static void mesh_free(struct pbnds_mesh *mesh)
{
    free(mesh->position);
    free(mesh->previous);
    free(mesh->normal);
    free(mesh->tangent);
    free(mesh->uv[0]);
    free(mesh->uv[1]);
    free(mesh->color);
    free(mesh->packed);
    free(mesh->index);
}

void pbnds_scene_free(struct pbnds_scene *scene)
{
    if (!scene) return;
    for (int i = 0; i < scene->mesh_count; ++i)
        mesh_free(&scene->meshes[i]);
    for (int i = 0; i < scene->image_count; ++i)
        pbnds_pixels_free(&scene->images[i]);
    pbnds_maps_free(scene->maps);
    free(scene->meshes);
    free(scene->materials);
    free(scene->textures);
    free(scene->images);
    free(scene->cameras);
    free(scene->previous_cameras);
    free(scene->lights);
    free(scene->objects);
    *scene = (struct pbnds_scene){0};
}
