#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"

/* glTF 2.0, section 3.7.3: a vertex goes with the weighted sum of its joints' matrices,
 *     M = sum_k w_k world(joint_k) inverseBind_k / sum_k w_k,
 * over all sets JOINTS_n, WEIGHTS_n, after the morph targets; the transform of the node
 * that has the mesh is not used. */

bool pbnds_gltf_is_skinned(const struct pbnds_gltf_build *b)
{
    return b->g->doc.nodes[b->node].skin >= 0 && b->primitive->influence_count > 0;
}

/** The inverse bind matrices, malloc'd; *bind stays NULL where they are the identity. */
static enum pbnds_status read_bind(struct pbnds_gltf_load_state *g,
                                   const struct pbnds_gltf_skin *skin, float **bind)
{
    static const char what[] = "inverseBindMatrices";
    const struct pbnds_gltf_accessor *a = NULL;
    if (skin->inverse_bind < 0) return PBNDS_OK;
    PBNDS_TRY(pbnds_gltf_accessor_at(g, skin->inverse_bind, 16, what, &a));
    const size_t count = skin->joints.count;
    if (a->count < count || a->component != PBNDS_GLTF_FLOAT) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: a skin has too few inverse bind matrices, or not floats",
                          g->name);
    }
    *bind = malloc((count * 16 + 1) * sizeof **bind);
    if (!*bind) return pbnds_gltf_no_memory(g);
    return pbnds_gltf_read_some(g, a, what, 0, count, *bind);
}

/** Fills the joint matrices of a skin: many nodes may have the same. */
static enum pbnds_status make_joints(struct pbnds_gltf_load_state *g,
                                     const struct pbnds_gltf_skin *skin,
                                     struct pbnds_gltf_joints *out)
{
    const size_t count = skin->joints.count;
    float *bind = NULL;
    PBNDS_TRY(pbnds_gltf_work(g, count, 2 * sizeof(struct pbnds_mat4)));
    enum pbnds_status status = read_bind(g, skin, &bind);
    for (int p = 0; p < g->pose_count && status == PBNDS_OK; ++p) {
        status = pbnds_gltf_charge(g, count, sizeof *out->world[p]);
        if (status != PBNDS_OK) break;
        out->world[p] = malloc((count + 1) * sizeof *out->world[p]);
        if (!out->world[p]) status = pbnds_gltf_no_memory(g);
        for (size_t i = 0; i < count && status == PBNDS_OK; ++i) {
            struct pbnds_mat4 inverse = pbnds_mat4_identity();
            if (bind) memcpy(inverse.m, bind + 16 * i, sizeof inverse.m);
            out->world[p][i] =
                pbnds_mat4_mul(&g->pose[p].world[skin->joints.items[i]], &inverse);
        }
    }
    free(bind);
    return status;
}

static enum pbnds_status find_joints(struct pbnds_gltf_load_state *g, int64_t skin,
                                     struct pbnds_gltf_skinning *out)
{
    if (!g->joints) {
        g->joints = calloc(g->doc.skin_count + 1, sizeof *g->joints);
        if (!g->joints) return pbnds_gltf_no_memory(g);
    }
    struct pbnds_gltf_joints *joints = &g->joints[skin];
    if (!joints->world[0]) PBNDS_TRY(make_joints(g, &g->doc.skins[skin], joints));
    out->joints = joints;
    out->joint_count = g->doc.skins[skin].joints.count;
    return PBNDS_OK;
}

void pbnds_gltf_free_joints(struct pbnds_gltf_load_state *g)
{
    for (size_t i = 0; g->joints && i < g->doc.skin_count; ++i) {
        free(g->joints[i].world[0]);
        free(g->joints[i].world[1]);
    }
    free(g->joints);
    g->joints = NULL;
}

static enum pbnds_status read_set(struct pbnds_gltf_build *b, size_t set,
                                  struct pbnds_gltf_skinning *out)
{
    const struct pbnds_gltf_influence *from = &b->primitive->influences[set];
    PBNDS_TRY(
        pbnds_gltf_read_attribute(b, from->joints, 4, "JOINTS", &out->index[set]));
    PBNDS_TRY(
        pbnds_gltf_read_attribute(b, from->weights, 4, "WEIGHTS", &out->weight[set]));
    for (size_t i = 0; i < 4 * b->file_vertices; ++i) {
        const float joint = out->index[set][i];
        if (!(out->weight[set][i] > 0.0f)) continue;
        if (joint >= 0.0f && joint < (float)out->joint_count) continue;
        return pbnds_fail(
            b->g->error, PBNDS_ERROR_FORMAT,
            "%s: vertex %zu refers to a joint that its skin does not have", b->g->name,
            i / 4);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_skin_open(struct pbnds_gltf_build *b,
                                       struct pbnds_gltf_skinning *skin)
{
    struct pbnds_gltf_load_state *g = b->g;
    const size_t sets = b->primitive->influence_count;
    *skin = (struct pbnds_gltf_skinning){.sets = sets};
    skin->index = calloc(sets + 1, sizeof *skin->index);
    skin->weight = calloc(sets + 1, sizeof *skin->weight);
    if (!skin->index || !skin->weight) return pbnds_gltf_no_memory(g);
    PBNDS_TRY(find_joints(g, g->doc.nodes[b->node].skin, skin));
    for (size_t i = 0; i < sets; ++i)
        PBNDS_TRY(read_set(b, i, skin));
    return PBNDS_OK;
}

void pbnds_gltf_skin_close(struct pbnds_gltf_build *b, struct pbnds_gltf_skinning *skin)
{
    const uint64_t size = 4 * sizeof(float);
    for (size_t i = 0; i < skin->sets; ++i) {
        if (skin->index && skin->index[i])
            pbnds_gltf_refund(b->g, b->file_vertices, size);
        if (skin->weight && skin->weight[i])
            pbnds_gltf_refund(b->g, b->file_vertices, size);
        free(skin->index ? skin->index[i] : NULL);
        free(skin->weight ? skin->weight[i] : NULL);
    }
    free(skin->index);
    free(skin->weight);
    *skin = (struct pbnds_gltf_skinning){0};
}

struct pbnds_mat4 pbnds_gltf_skin_matrix(const struct pbnds_gltf_skinning *skin,
                                         int pose, size_t vertex)
{
    struct pbnds_mat4 sum = {{0}};
    float total = 0.0f;
    for (size_t i = 0; i < 4 * skin->sets; ++i) {
        const size_t at = 4 * vertex + i % 4;
        const float weight = skin->weight[i / 4][at];
        if (!(weight > 0.0f)) continue;
        const struct pbnds_mat4 *joint =
            &skin->joints->world[pose][(size_t)skin->index[i / 4][at]];
        for (int k = 0; k < 16; ++k)
            sum.m[k] += weight * joint->m[k];
        total += weight;
    }
    if (total == 0.0f) return pbnds_mat4_identity(); /* held by nothing */
    for (int k = 0; k < 16; ++k)
        sum.m[k] /= total;
    return sum;
}
