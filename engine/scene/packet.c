#include "engine/scene/packet.h"

#include <stdlib.h>

#include "engine/core/large.h"

static struct pbnds_vertex pack(const struct pbnds_mesh *m, size_t i)
{
    const struct pbnds_vec3 p = m->position[i], n = m->normal[i];
    struct pbnds_vec2 uv = {0.0f, 0.0f};
    struct pbnds_vec4 t = {0.0f, 0.0f, 0.0f, 0.0f};
    if (m->uv[0]) uv = m->uv[0][i];
    if (m->tangent) t = m->tangent[i];
    return (struct pbnds_vertex){
        {p.x, p.y, p.z, uv.x}, {n.x, n.y, n.z, uv.y}, {t.x, t.y, t.z, t.w}};
}

static enum pbnds_status pack_mesh(struct pbnds_mesh *mesh, struct pbnds_error *error)
{
    free(mesh->packed);
    mesh->packed = NULL;
    if (!mesh->normal || mesh->vertex_count == 0) return PBNDS_OK;
    if (mesh->vertex_count <= SIZE_MAX / sizeof *mesh->packed)
        mesh->packed = pbnds_large_alloc(mesh->vertex_count * sizeof *mesh->packed);
    if (!mesh->packed) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "mesh \"%s\": no memory for its %zu vertices once more",
                          mesh->name, mesh->vertex_count);
    }
    for (size_t i = 0; i < mesh->vertex_count; ++i)
        mesh->packed[i] = pack(mesh, i);
    return PBNDS_OK;
}

enum pbnds_status pbnds_scene_pack(struct pbnds_scene *scene, struct pbnds_error *error)
{
    for (int i = 0; i < scene->mesh_count; ++i)
        PBNDS_TRY(pack_mesh(&scene->meshes[i], error));
    return PBNDS_OK;
}
