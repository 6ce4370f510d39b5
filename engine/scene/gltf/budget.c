#include <stdlib.h>

#include "engine/scene/gltf/load.h"

/* Instances are copies, and an accessor without data costs a file nothing: a small file
 * can ask for much. What its geometry takes is bounded in 64 bits, first by a sum over
 * the scene before anything is built, then again at every allocation. */

enum { MAX_MESHES = 1 << 24 };

/* What a node refers to is read for each node anew, and a thousand morph targets may be
 * one accessor: time is bounded too, by what is read in all, in multiples of the budget. */
enum { WORK = 2 };

static enum pbnds_status too_large(struct pbnds_gltf_load_state *g)
{
    return pbnds_fail(
        g->error, PBNDS_ERROR_MEMORY,
        "%s: its geometry takes more than %llu MiB or %d meshes; use a smaller scene "
        "(or see --max-geometry)",
        g->name, (unsigned long long)(g->max_geometry >> 20), (int)MAX_MESHES);
}

enum pbnds_status pbnds_gltf_charge(struct pbnds_gltf_load_state *g, uint64_t count,
                                    uint64_t size)
{
    const uint64_t left = g->max_geometry - g->geometry_bytes;
    if (size && count > left / size) return too_large(g);
    g->geometry_bytes += count * size;
    return PBNDS_OK;
}

void pbnds_gltf_refund(struct pbnds_gltf_load_state *g, uint64_t count, uint64_t size)
{
    g->geometry_bytes -= count * size;
}

enum pbnds_status pbnds_gltf_work(struct pbnds_gltf_load_state *g, uint64_t count,
                                  uint64_t size)
{
    const uint64_t limit =
        g->max_geometry < UINT64_MAX / WORK ? g->max_geometry * WORK : UINT64_MAX;
    if (size && count > (limit - g->work_bytes) / size) {
        return pbnds_fail(
            g->error, PBNDS_ERROR_MEMORY,
            "%s: reads the same data over and over, more than %llu MiB in "
            "all; use a simpler scene (or see --max-geometry)",
            g->name, (unsigned long long)(limit >> 20));
    }
    g->work_bytes += count * size;
    return pbnds_stop_requested() ? pbnds_fail_interrupted(g->error) : PBNDS_OK;
}

static uint64_t count_of(const struct pbnds_gltf_document *d, int64_t accessor)
{
    if (accessor < 0) return 0;
    const uint64_t count = d->accessors[accessor].count;
    return count < UINT32_MAX ? count : UINT32_MAX;
}

/** What the vertices and indices of a mesh take at least, once for each of its nodes. */
static uint64_t least_size(const struct pbnds_gltf_document *d, int64_t mesh)
{
    uint64_t size = 0;
    for (size_t i = 0; i < d->meshes[mesh].primitive_count; ++i) {
        const struct pbnds_gltf_primitive *p = &d->meshes[mesh].primitives[i];
        uint64_t vertex = sizeof(struct pbnds_vec3);
        if (p->normal >= 0) vertex += sizeof(struct pbnds_vec3);
        if (p->normal >= 0 && p->tangent >= 0) vertex += sizeof(struct pbnds_vec4);
        if (p->uv[0] >= 0) vertex += sizeof(struct pbnds_vec2);
        if (p->uv[1] >= 0) vertex += sizeof(struct pbnds_vec2);
        if (p->color >= 0) vertex += sizeof(struct pbnds_vec4);
        const uint64_t indices =
            count_of(d, p->indices >= 0 ? p->indices : p->position);
        size += count_of(d, p->position) * vertex + indices * sizeof(uint32_t);
    }
    return size;
}

/** The sums over the scene; the size stops growing where it is too large. */
struct needs {
    uint64_t meshes, cameras, lights, size;
};

static enum pbnds_status add_mesh(struct pbnds_gltf_load_state *g, size_t node,
                                  struct needs *needs)
{
    const int64_t mesh = g->doc.nodes[node].mesh;
    uint64_t instances = 0;
    PBNDS_TRY(pbnds_gltf_instance_count(g, node, &instances));
    const uint64_t primitives = g->doc.meshes[mesh].primitive_count;
    const uint64_t size = least_size(&g->doc, mesh);
    if (instances > MAX_MESHES || primitives > MAX_MESHES) return too_large(g);
    needs->meshes += instances * primitives;
    if (needs->meshes > MAX_MESHES ||
        needs->meshes > g->max_geometry / sizeof(struct pbnds_mesh)) {
        return too_large(g);
    }
    if (size && instances > (g->max_geometry - needs->size) / size) return too_large(g);
    needs->size += instances * size;
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_make_room(struct pbnds_gltf_load_state *g)
{
    struct needs needs = {0, 0, 0, 0};
    struct pbnds_scene *s = g->scene;
    for (size_t i = 0; i < g->doc.node_count; ++i) {
        const struct pbnds_gltf_node *n = &g->doc.nodes[i];
        if (!g->in_scene[i]) continue;
        if (n->mesh >= 0) PBNDS_TRY(add_mesh(g, i, &needs));
        needs.cameras += n->camera >= 0;
        needs.lights += n->light >= 0;
    }
    PBNDS_TRY(pbnds_gltf_charge(g, needs.meshes, sizeof *s->meshes));
    s->meshes = calloc((size_t)needs.meshes + 1, sizeof *s->meshes);
    s->cameras = calloc((size_t)needs.cameras + 1, sizeof *s->cameras);
    s->lights = calloc((size_t)needs.lights + 1, sizeof *s->lights);
    s->objects = calloc(g->doc.node_count + 1, sizeof *s->objects);
    bool fine = s->meshes && s->cameras && s->lights && s->objects;
    if (g->pose_count == 2) {
        s->previous_cameras =
            calloc((size_t)needs.cameras + 1, sizeof *s->previous_cameras);
        fine = fine && s->previous_cameras;
    }
    return fine ? PBNDS_OK
                : pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for meshes",
                             g->name);
}
