#include <stdlib.h>

#include "engine/scene/gltf/load.h"

/* EXT_mesh_gpu_instancing: each instance stands in the frame of its node,
 *     world = world(node) T R S. */

enum { PARTS = 3 };

static const char *const names[PARTS] = {"TRANSLATION of instances",
                                         "ROTATION of instances", "SCALE of instances"};

static void list_parts(const struct pbnds_gltf_instancing *n, int64_t parts[PARTS])
{
    parts[0] = n->translation;
    parts[1] = n->rotation;
    parts[2] = n->scale;
}

enum pbnds_status pbnds_gltf_instance_count(struct pbnds_gltf_load_state *g,
                                            size_t node, uint64_t *count)
{
    const struct pbnds_gltf_node *n = &g->doc.nodes[node];
    int64_t parts[PARTS];
    bool counted = false;
    *count = 1;
    if (!n->instancing.present) return PBNDS_OK;
    if (n->skin >= 0) { /* the joints say where a skinned mesh is, not the node */
        g->skinned_instances = true;
        return PBNDS_OK;
    }
    list_parts(&n->instancing, parts);
    for (int i = 0; i < PARTS; ++i) {
        if (parts[i] < 0) continue;
        const uint64_t found = g->doc.accessors[parts[i]].count;
        if (counted && found != *count) {
            return pbnds_fail(
                g->error, PBNDS_ERROR_FORMAT,
                "%s: the attributes of the instances of node %zu differ in number",
                g->name, node);
        }
        *count = found;
        counted = true;
    }
    return PBNDS_OK;
}

static enum pbnds_status read_part(struct pbnds_gltf_load_state *g, int64_t accessor,
                                   int width, const char *what, float **out)
{
    const struct pbnds_gltf_accessor *a = NULL;
    if (accessor < 0) return PBNDS_OK;
    PBNDS_TRY(pbnds_gltf_accessor_at(g, accessor, width, what, &a));
    *out = malloc((size_t)(a->count * (uint64_t)width + 1) * sizeof **out);
    return *out ? pbnds_gltf_read_floats(g, a, what, *out) : pbnds_gltf_no_memory(g);
}

static struct pbnds_mat4 matrix_of(float *const part[PARTS], uint64_t i)
{
    struct pbnds_gltf_trs trs = {
        .rotation = {0.0, 0.0, 0.0, 1.0},
        .scale = {1.0, 1.0, 1.0},
    };
    for (size_t k = 0; k < 3 && part[0]; ++k)
        trs.translation[k] = (double)part[0][3 * i + k];
    for (size_t k = 0; k < 4 && part[1]; ++k)
        trs.rotation[k] = (double)part[1][4 * i + k];
    for (size_t k = 0; k < 3 && part[2]; ++k)
        trs.scale[k] = (double)part[2][3 * i + k];
    return pbnds_gltf_matrix(&trs);
}

enum pbnds_status pbnds_gltf_instances(struct pbnds_gltf_load_state *g, size_t node,
                                       uint64_t count, struct pbnds_mat4 *local)
{
    static const int widths[PARTS] = {3, 4, 3};
    const struct pbnds_gltf_node *n = &g->doc.nodes[node];
    float *part[PARTS] = {NULL, NULL, NULL};
    int64_t parts[PARTS] = {-1, -1, -1};
    enum pbnds_status status = PBNDS_OK;
    if (n->instancing.present && n->skin < 0) list_parts(&n->instancing, parts);
    for (int i = 0; i < PARTS && status == PBNDS_OK; ++i)
        status = read_part(g, parts[i], widths[i], names[i], &part[i]);
    for (uint64_t i = 0; i < count && status == PBNDS_OK; ++i)
        local[i] = matrix_of(part, i);
    for (int i = 0; i < PARTS; ++i)
        free(part[i]);
    return status;
}
