#include "engine/scene/scene.h"

#include <stdlib.h>

static void mesh_free(struct pbnds_mesh *mesh)
{
    free(mesh->position);
    free(mesh->normal);
    free(mesh->tangent);
    free(mesh->uv[0]);
    free(mesh->uv[1]);
    free(mesh->color);
    free(mesh->index);
}

void pbnds_scene_free(struct pbnds_scene *scene)
{
    if (!scene) return;
    for (int i = 0; i < scene->mesh_count; ++i)
        mesh_free(&scene->meshes[i]);
    for (int i = 0; i < scene->image_count; ++i)
        pbnds_pixels_free(&scene->images[i]);
    free(scene->meshes);
    free(scene->materials);
    free(scene->textures);
    free(scene->images);
    free(scene->cameras);
    *scene = (struct pbnds_scene){0};
}
