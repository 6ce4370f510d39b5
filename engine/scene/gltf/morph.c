#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"

/* glTF 2.0, section 3.7.2.2: every attribute is its base value plus the weighted sum of
 * the targets' displacements. A tangent's handedness is not displaced. */

/** Adds one displacement to one attribute of three (or the first three of `width`). */
struct move {
    float *to;
    size_t width;
    float weight;
};

static enum pbnds_status add(struct pbnds_gltf_build *b, int64_t accessor,
                             const char *what, const struct move *moves, int count)
{
    const struct pbnds_gltf_accessor *a =
        accessor < 0 ? NULL : &b->g->doc.accessors[accessor];
    float *delta = NULL;
    bool wanted = false;
    for (int i = 0; i < count; ++i)
        wanted = wanted || (moves[i].to && moves[i].weight != 0.0f);
    if (!a || !wanted) return PBNDS_OK;
    const bool zeros = a->view < 0 && !a->sparse && !a->unpacked;
    if (zeros && a->count == b->file_vertices) return PBNDS_OK;
    if (pbnds_stop_requested()) return pbnds_fail_interrupted(b->g->error);
    PBNDS_TRY(pbnds_gltf_read_attribute(b, accessor, 3, what, &delta));
    for (int i = 0; i < count; ++i) {
        const struct move *m = &moves[i];
        if (!m->to || m->weight == 0.0f) continue;
        for (size_t v = 0; v < b->mesh.vertex_count; ++v) {
            const float *d = delta + 3 * (b->origin ? b->origin[v] : v);
            for (size_t k = 0; k < 3; ++k)
                m->to[v * m->width + k] += m->weight * d[k];
        }
    }
    free(delta);
    pbnds_gltf_refund(b->g, b->file_vertices, 3 * sizeof *delta);
    return PBNDS_OK;
}

static enum pbnds_status add_target(struct pbnds_gltf_build *b, size_t target,
                                    const float *now, const float *earlier)
{
    const struct pbnds_gltf_target *t = &b->primitive->targets[target];
    struct pbnds_mesh *m = &b->mesh;
    const float weight = now[target];
    const struct move position[2] = {
        {(float *)m->position, 3, weight},
        {(float *)m->previous, 3, earlier ? earlier[target] : 0.0f}};
    const struct move normal = {(float *)m->normal, 3, weight};
    /* Displacements of tangents that the file does not have mean nothing. */
    const struct move tangent = {b->own_tangents ? NULL : (float *)m->tangent, 4,
                                 weight};
    PBNDS_TRY(add(b, t->position, "POSITION of a morph target", position, 2));
    PBNDS_TRY(add(b, t->normal, "NORMAL of a morph target", &normal, 1));
    return add(b, t->tangent, "TANGENT of a morph target", &tangent, 1);
}

enum pbnds_status pbnds_gltf_morph(struct pbnds_gltf_build *b)
{
    struct pbnds_gltf_load_state *g = b->g;
    const size_t count = b->primitive->target_count;
    if (count == 0) return PBNDS_OK;
    float *weights[2] = {NULL, NULL};
    enum pbnds_status status = PBNDS_OK;
    for (int p = 0; p < g->pose_count && status == PBNDS_OK; ++p) {
        weights[p] = malloc(count * sizeof *weights[p]);
        status = weights[p] ? pbnds_gltf_morph_weights(g, &g->pose[p], b->node, count,
                                                       weights[p])
                            : pbnds_gltf_no_memory(g);
    }
    for (size_t i = 0; i < count && status == PBNDS_OK; ++i)
        status = add_target(b, i, weights[0], weights[1]);
    free(weights[0]);
    free(weights[1]);
    return status;
}
