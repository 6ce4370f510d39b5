#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"
#include "engine/scene/tangent.h"

/* A primitive is read in the frame of its mesh, gets its tangents and morph targets
 * there, and is then copied into the world: once for its node, or once an instance. */

/** Tangents for a normal map that KHR_texture_transform turns are those of the UVs that
 *  look it up; the UVs themselves stay, other textures use them too. */
static enum pbnds_status turned_tangents(struct pbnds_gltf_build *b,
                                         const struct pbnds_texture_ref *map)
{
    struct pbnds_gltf_load_state *g = b->g;
    struct pbnds_mesh *m = &b->mesh;
    const size_t count = m->vertex_count;
    const float *t = map->transform;
    PBNDS_TRY(pbnds_gltf_charge(g, count, sizeof *m->uv[0]));
    struct pbnds_vec2 *kept = malloc((count + 1) * sizeof *kept);
    if (!kept) return pbnds_gltf_no_memory(g);
    for (size_t i = 0; i < count; ++i) {
        struct pbnds_vec2 *uv = &m->uv[map->texcoord][i];
        kept[i] = *uv;
        uv->x = t[0] * kept[i].x + t[1] * kept[i].y + t[2];
        uv->y = t[3] * kept[i].x + t[4] * kept[i].y + t[5];
    }
    const enum pbnds_status status =
        pbnds_mesh_tangents(m, map->texcoord, &b->origin, g->name, g->error);
    for (size_t i = 0; i < m->vertex_count && status == PBNDS_OK; ++i)
        m->uv[map->texcoord][i] = kept[b->origin ? b->origin[i] : i];
    free(kept);
    pbnds_gltf_refund(g, count, sizeof *kept);
    return status;
}

/** Tangents are needed where a normal map is and the file has none. They are those of
 *  the mesh at rest: no morph target, no joint and no scale of a node changes them. */
static enum pbnds_status add_tangents(struct pbnds_gltf_build *b)
{
    struct pbnds_mesh *m = &b->mesh;
    const struct pbnds_texture_ref map =
        b->g->scene->materials[m->material].normal_texture;
    if (map.texture < 0 || m->tangent || !m->uv[map.texcoord]) return PBNDS_OK;
    for (size_t i = 0; m->normal && i < m->vertex_count; ++i)
        m->normal[i] = pbnds_gltf_direction(m->normal[i]);
    PBNDS_TRY(pbnds_gltf_mesh_repair(b->g, m));
    const uint64_t before = pbnds_gltf_mesh_size(m), need = pbnds_mesh_tangents_need(m);
    PBNDS_TRY(pbnds_gltf_charge(b->g, need, 1));
    if (map.transformed) {
        PBNDS_TRY(turned_tangents(b, &map));
    } else {
        PBNDS_TRY(
            pbnds_mesh_tangents(m, map.texcoord, &b->origin, b->g->name, b->g->error));
    }
    pbnds_gltf_refund(b->g, need, 1);
    b->own_tangents = true;
    return pbnds_gltf_charge(b->g, pbnds_gltf_mesh_size(m) - before, 1);
}

/** Room for the earlier positions where something may have moved. */
static enum pbnds_status keep_earlier(struct pbnds_gltf_build *b)
{
    struct pbnds_gltf_load_state *g = b->g;
    struct pbnds_mesh *m = &b->mesh;
    if (g->pose_count < 2) return PBNDS_OK;
    const bool still = memcmp(&g->pose[0].world[b->node], &g->pose[1].world[b->node],
                              sizeof(struct pbnds_mat4)) == 0;
    if (still && !pbnds_gltf_is_skinned(b) && b->primitive->target_count == 0) {
        return PBNDS_OK;
    }
    PBNDS_TRY(pbnds_gltf_charge(g, m->vertex_count, sizeof *m->previous));
    m->previous = malloc((m->vertex_count + 1) * sizeof *m->previous);
    if (!m->previous) return pbnds_gltf_no_memory(g);
    memcpy(m->previous, m->position, m->vertex_count * sizeof *m->previous);
    return PBNDS_OK;
}

static enum pbnds_status build_local(struct pbnds_gltf_build *b)
{
    PBNDS_TRY(pbnds_gltf_read_vertices(b));
    PBNDS_TRY(pbnds_gltf_read_triangles(b));
    if (b->mesh.triangle_count == 0) return PBNDS_OK;
    PBNDS_TRY(add_tangents(b));
    PBNDS_TRY(keep_earlier(b));
    return pbnds_gltf_morph(b);
}

static enum pbnds_status add_primitive(struct pbnds_gltf_build *b,
                                       const struct pbnds_mat4 *local, uint64_t count)
{
    struct pbnds_mesh *m = &b->mesh;
    const struct pbnds_gltf_node *n = &b->g->doc.nodes[b->node];
    const char *name = b->g->doc.meshes[n->mesh].name;
    pbnds_gltf_name(m->name, name[0] ? name : n->name, "mesh", (size_t)n->mesh);
    m->object_id = (uint32_t)b->node;
    m->material = pbnds_gltf_material_of(b->g, b->primitive);
    PBNDS_TRY(build_local(b));
    if (m->triangle_count == 0 || count == 0) return PBNDS_OK;
    return pbnds_gltf_is_skinned(b) ? pbnds_gltf_add_skinned(b)
                                    : pbnds_gltf_add_instances(b, local, count);
}

static enum pbnds_status add_primitives(struct pbnds_gltf_load_state *g, size_t node,
                                        const struct pbnds_mat4 *local, uint64_t count)
{
    const int64_t mesh = g->doc.nodes[node].mesh;
    const struct pbnds_gltf_mesh *source = &g->doc.meshes[mesh];
    for (size_t i = 0; i < source->primitive_count; ++i) {
        const struct pbnds_gltf_primitive *p = &source->primitives[i];
        if (p->mode < 0 || p->mode > PBNDS_GLTF_FAN) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT, "%s: mesh %lld has mode %d",
                              g->name, (long long)mesh, p->mode);
        }
        if (p->mode < PBNDS_GLTF_TRIANGLES || p->position < 0) {
            ++g->skipped_primitives;
            continue;
        }
        struct pbnds_gltf_build b = {.g = g, .primitive = p, .node = node};
        const enum pbnds_status status = add_primitive(&b, local, count);
        free(b.origin);
        pbnds_gltf_mesh_free(&b.mesh);
        PBNDS_TRY(status);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_node_meshes(struct pbnds_gltf_load_state *g, size_t node)
{
    uint64_t count = 0;
    PBNDS_TRY(pbnds_gltf_instance_count(g, node, &count));
    PBNDS_TRY(pbnds_gltf_charge(g, count, sizeof(struct pbnds_mat4)));
    struct pbnds_mat4 *local = malloc(((size_t)count + 1) * sizeof *local);
    if (!local) return pbnds_gltf_no_memory(g);
    enum pbnds_status status = pbnds_gltf_instances(g, node, count, local);
    if (status == PBNDS_OK) status = add_primitives(g, node, local, count);
    free(local);
    pbnds_gltf_refund(g, count, sizeof *local);
    return status;
}
