#include <stdlib.h>

#include "engine/scene/gltf/load.h"

/** A node's own transform as the file has it: 16 numbers, or translation, rotation and
 *  scale. */
static enum pbnds_status rest_transform(struct pbnds_gltf_load_state *g, size_t index,
                                        struct pbnds_gltf_trs *out)
{
    const struct pbnds_gltf_node *n = &g->doc.nodes[index];
    const bool fine = (n->matrix_count == 0 || n->matrix_count == 16) &&
                      (n->translation_count == 0 || n->translation_count == 3) &&
                      (n->rotation_count == 0 || n->rotation_count == 4) &&
                      (n->scale_count == 0 || n->scale_count == 3);
    if (!fine) {
        return pbnds_fail(
            g->error, PBNDS_ERROR_FORMAT,
            "%s: the transform of node %zu has the wrong number of values", g->name,
            index);
    }
    *out = (struct pbnds_gltf_trs){
        .matrix = n->matrix_count ? n->matrix : NULL,
        .rotation = {0.0, 0.0, 0.0, 1.0},
        .scale = {1.0, 1.0, 1.0},
    };
    for (size_t i = 0; i < n->translation_count; ++i)
        out->translation[i] = n->translation[i];
    for (size_t i = 0; i < n->rotation_count; ++i)
        out->rotation[i] = n->rotation[i];
    for (size_t i = 0; i < n->scale_count; ++i)
        out->scale[i] = n->scale[i];
    return PBNDS_OK;
}

struct pbnds_mat4 pbnds_gltf_matrix(const struct pbnds_gltf_trs *trs)
{
    const double *t = trs->translation, *q = trs->rotation, *s = trs->scale;
    if (trs->matrix) {
        struct pbnds_mat4 m;
        for (int i = 0; i < 16; ++i)
            m.m[i] = (float)trs->matrix[i];
        return m;
    }
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    struct pbnds_vec4 rotation = {0.0f, 0.0f, 0.0f, 1.0f};
    if (length > 0.0) {
        rotation = (struct pbnds_vec4){(float)(q[0] / length), (float)(q[1] / length),
                                       (float)(q[2] / length), (float)(q[3] / length)};
    }
    return pbnds_mat4_from_trs(pbnds_vec3_make((float)t[0], (float)t[1], (float)t[2]),
                               rotation,
                               pbnds_vec3_make((float)s[0], (float)s[1], (float)s[2]));
}

/** parent[child] for every node; a child has one parent (glTF 2.0, section 3.5.2). */
static enum pbnds_status find_parents(struct pbnds_gltf_load_state *g, int64_t *parent)
{
    const struct pbnds_gltf_document *d = &g->doc;
    for (size_t i = 0; i < d->node_count; ++i)
        parent[i] = -1;
    for (size_t i = 0; i < d->node_count; ++i) {
        for (size_t k = 0; k < d->nodes[i].child_count; ++k) {
            const int child = d->nodes[i].children[k];
            if (child < 0 || (size_t)child >= d->node_count) {
                return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                                  "%s: node %zu has child %d, which does not exist",
                                  g->name, i, child);
            }
            if (parent[child] >= 0) {
                return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                                  "%s: node %d has more than one parent", g->name,
                                  child);
            }
            parent[child] = (int64_t)i;
        }
    }
    return PBNDS_OK;
}

static const char *scene_name(const struct pbnds_gltf_document *d, size_t i)
{
    return d->scenes[i].name;
}

static enum pbnds_status find_roots(struct pbnds_gltf_load_state *g,
                                    const int64_t *parent, bool *root)
{
    const struct pbnds_gltf_document *d = &g->doc;
    size_t scene = d->scene < 0 ? 0 : (size_t)d->scene;
    if (g->options->scene) {
        PBNDS_TRY(pbnds_gltf_choose(g, g->options->scene, "scene", d->scene_count,
                                    scene_name, &scene));
    } else if (d->scene_count == 0) {
        for (size_t i = 0; i < d->node_count; ++i)
            root[i] = parent[i] < 0;
        return PBNDS_OK;
    }
    for (size_t i = 0; i < d->scenes[scene].nodes.count; ++i) {
        const int node = d->scenes[scene].nodes.items[i];
        if (node < 0 || (size_t)node >= d->node_count || parent[node] >= 0) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: scene %zu lists node %d, which is not a root node",
                              g->name, scene, node);
        }
        root[node] = true;
    }
    return PBNDS_OK;
}

/** Every node after its parent, found by a walk down from every root without recursion
 *  (joints may lie outside of the scene). A node that no root leads to is in a cycle. */
static enum pbnds_status sort(struct pbnds_gltf_load_state *g, const int64_t *parent,
                              size_t *order)
{
    const struct pbnds_gltf_document *d = &g->doc;
    size_t known = 0;
    for (size_t i = 0; i < d->node_count; ++i)
        if (parent[i] < 0) order[known++] = i;
    for (size_t done = 0; done < known; ++done) {
        const struct pbnds_gltf_node *n = &d->nodes[order[done]];
        for (size_t k = 0; k < n->child_count; ++k)
            order[known++] = (size_t)n->children[k];
    }
    if (known == d->node_count) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                      "%s: its nodes are not a tree, some are their own ancestors",
                      g->name);
}

static enum pbnds_status place(struct pbnds_gltf_load_state *g,
                               struct pbnds_gltf_pose *pose, const int64_t *parent,
                               const size_t *order, struct pbnds_gltf_trs *trs)
{
    const size_t count = g->doc.node_count;
    for (size_t i = 0; i < count; ++i)
        PBNDS_TRY(rest_transform(g, i, &trs[i]));
    if (g->animation) PBNDS_TRY(pbnds_gltf_animate(g, pose->time, trs));
    for (size_t k = 0; k < count; ++k) {
        const size_t i = order[k];
        const struct pbnds_mat4 local = pbnds_gltf_matrix(&trs[i]);
        pose->world[i] =
            parent[i] < 0 ? local : pbnds_mat4_mul(&pose->world[parent[i]], &local);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_place_nodes(struct pbnds_gltf_load_state *g)
{
    const size_t count = g->doc.node_count;
    int64_t *parent = calloc(count + 1, sizeof *parent);
    size_t *order = calloc(count + 1, sizeof *order); /* one parent each: it fits */
    struct pbnds_gltf_trs *trs = calloc(count + 1, sizeof *trs);
    g->in_scene = calloc(count + 1, sizeof *g->in_scene);
    bool fine = parent && order && trs && g->in_scene;
    for (int p = 0; p < g->pose_count; ++p) {
        g->pose[p].world = calloc(count + 1, sizeof *g->pose[p].world);
        fine = fine && g->pose[p].world;
    }
    enum pbnds_status status = fine ? PBNDS_OK
                                    : pbnds_fail(g->error, PBNDS_ERROR_MEMORY,
                                                 "%s: no memory for nodes", g->name);
    if (status == PBNDS_OK) status = find_parents(g, parent);
    if (status == PBNDS_OK) status = find_roots(g, parent, g->in_scene);
    if (status == PBNDS_OK) status = sort(g, parent, order);
    for (size_t k = 0; k < count && status == PBNDS_OK; ++k) {
        const size_t i = order[k];
        if (parent[i] >= 0) g->in_scene[i] = g->in_scene[parent[i]];
    }
    for (int p = 0; p < g->pose_count && status == PBNDS_OK; ++p)
        status = place(g, &g->pose[p], parent, order, trs);
    free(parent);
    free(order);
    free(trs);
    return status;
}
