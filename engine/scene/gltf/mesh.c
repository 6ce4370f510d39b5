#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"
#include "engine/scene/tangent.h"

/** A primitive being built and what it is built from. */
struct build {
    struct pbnds_gltf_load_state *g;
    const struct pbnds_gltf_primitive *primitive;
    const struct pbnds_gltf_node *node;
    const struct pbnds_mat4 *world; /**< of the node                             */
    struct pbnds_mat4 *skin;        /**< one a vertex, NULL when not skinned     */
    struct pbnds_mesh *mesh;
};

static enum pbnds_status no_memory(struct pbnds_gltf_load_state *g)
{
    return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for its geometry",
                      g->name);
}

static enum pbnds_status charge(struct pbnds_gltf_load_state *g, uint64_t count,
                                uint64_t size)
{
    g->geometry_bytes += count * size; /* count < 2^32 each: no overflow */
    if (g->geometry_bytes <= PBNDS_GLTF_MAX_GEOMETRY) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_MEMORY,
                      "%s: its geometry takes more than 8 GiB", g->name);
}

/** A vertex attribute as floats, malloc'd; NULL when the primitive has none. */
static enum pbnds_status read_attribute(struct build *b, int64_t accessor, int width,
                                        const char *what, float **out)
{
    struct pbnds_gltf_load_state *g = b->g;
    const struct pbnds_gltf_accessor *a = NULL;
    *out = NULL;
    if (accessor < 0) return PBNDS_OK;
    PBNDS_TRY(pbnds_gltf_accessor_at(g, accessor, width, what, &a));
    if (a->count != b->mesh->vertex_count) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: %s has %llu elements for %zu vertices", g->name, what,
                          (unsigned long long)a->count, b->mesh->vertex_count);
    }
    PBNDS_TRY(charge(g, a->count, sizeof(float) * (uint64_t)width));
    float *data = calloc((size_t)a->count * (size_t)width + 1, sizeof *data);
    if (!data) return no_memory(g);
    const enum pbnds_status status = pbnds_gltf_read_floats(g, a, what, data);
    if (status != PBNDS_OK) {
        free(data);
        return status;
    }
    *out = data;
    return PBNDS_OK;
}

/** COLOR_0 has three components or four. */
static enum pbnds_status read_color(struct build *b)
{
    const int64_t index = b->primitive->color;
    const bool rgb = index >= 0 && (uint64_t)index < b->g->doc.accessor_count &&
                     b->g->doc.accessors[index].width == 3;
    float *data = NULL;
    PBNDS_TRY(read_attribute(b, index, rgb ? 3 : 4, "COLOR_0", &data));
    if (!data) return PBNDS_OK;
    const size_t count = b->mesh->vertex_count;
    b->mesh->color = calloc(count + 1, sizeof *b->mesh->color);
    if (!b->mesh->color) {
        free(data);
        return no_memory(b->g);
    }
    for (size_t i = 0; i < count; ++i) {
        const float *c = data + i * (rgb ? 3 : 4);
        b->mesh->color[i] = (struct pbnds_vec4){c[0], c[1], c[2], rgb ? 1.0f : c[3]};
    }
    free(data);
    return PBNDS_OK;
}

/* The vector types are plain floats in order: an array of them is read as floats. */
_Static_assert(sizeof(struct pbnds_vec2) == 8, "pbnds_vec2 has padding");
_Static_assert(sizeof(struct pbnds_vec3) == 12, "pbnds_vec3 has padding");
_Static_assert(sizeof(struct pbnds_vec4) == 16, "pbnds_vec4 has padding");

static enum pbnds_status read_vertices(struct build *b)
{
    const struct pbnds_gltf_primitive *p = b->primitive;
    struct pbnds_mesh *m = b->mesh;
    const struct pbnds_gltf_accessor *a = NULL;
    PBNDS_TRY(pbnds_gltf_accessor_at(b->g, p->position, 3, "POSITION", &a));
    if (a->count > UINT32_MAX) {
        return pbnds_fail(b->g->error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: a mesh has more than 2^32 vertices", b->g->name);
    }
    m->vertex_count = (size_t)a->count;
    float *data = NULL;
    PBNDS_TRY(read_attribute(b, p->position, 3, "POSITION", &data));
    m->position = (struct pbnds_vec3 *)(void *)data;
    PBNDS_TRY(read_attribute(b, p->normal, 3, "NORMAL", &data));
    m->normal = (struct pbnds_vec3 *)(void *)data;
    /* Without normals tangents mean nothing: glTF 2.0, section 3.7.2.1. */
    PBNDS_TRY(read_attribute(b, m->normal ? p->tangent : -1, 4, "TANGENT", &data));
    m->tangent = (struct pbnds_vec4 *)(void *)data;
    for (int set = 0; set < 2; ++set) {
        PBNDS_TRY(
            read_attribute(b, p->uv[set], 2, set ? "TEXCOORD_1" : "TEXCOORD_0", &data));
        m->uv[set] = (struct pbnds_vec2 *)(void *)data;
    }
    return read_color(b);
}

/** Writes a triangle of a strip or fan unless it has no area by construction. */
static void emit(struct pbnds_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    if (a == b || b == c || c == a) return;
    uint32_t *out = m->index + 3 * m->triangle_count++;
    out[0] = a;
    out[1] = b;
    out[2] = c;
}

/** Makes a list of triangles of the primitive's indices; glTF 2.0, section 3.7.2.1. */
static void make_triangles(struct pbnds_mesh *m, int mode, const uint32_t *index,
                           size_t count)
{
    if (mode == 4) {
        m->triangle_count = count / 3;
        memcpy(m->index, index, m->triangle_count * 3 * sizeof *index);
        return;
    }
    for (size_t i = 0; i + 2 < count; ++i) {
        if (mode == 5)
            emit(m, index[i], index[i + 1 + i % 2], index[i + 2 - i % 2]);
        else
            emit(m, index[i + 1], index[i + 2], index[0]);
    }
}

static enum pbnds_status read_triangles(struct build *b)
{
    struct pbnds_gltf_load_state *g = b->g;
    const struct pbnds_gltf_accessor *a = NULL;
    uint64_t count = b->mesh->vertex_count;
    if (b->primitive->indices >= 0) {
        PBNDS_TRY(pbnds_gltf_accessor_at(g, b->primitive->indices, 1, "indices", &a));
        count = a->count;
    }
    const int mode = b->primitive->mode;
    const uint64_t room = mode == 4 ? count : 3 * count;
    if (count > UINT32_MAX) {
        return pbnds_fail(g->error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: a mesh has more than 2^32 indices", g->name);
    }
    PBNDS_TRY(charge(g, room, sizeof(uint32_t)));
    uint32_t *index = calloc((size_t)count + 1, sizeof *index);
    b->mesh->index = calloc((size_t)room + 1, sizeof *index);
    if (!index || !b->mesh->index) {
        free(index);
        return no_memory(g);
    }
    enum pbnds_status status = PBNDS_OK;
    if (a) {
        status = pbnds_gltf_read_indices(g, a, b->mesh->vertex_count, index);
    } else {
        for (size_t i = 0; i < count; ++i)
            index[i] = (uint32_t)i;
    }
    if (status == PBNDS_OK) make_triangles(b->mesh, mode, index, (size_t)count);
    free(index);
    return status;
}

/** Joint matrices: world transform of the joint times its inverse bind matrix. */
static enum pbnds_status joint_matrices(struct build *b,
                                        const struct pbnds_gltf_skin *skin,
                                        struct pbnds_mat4 *joints)
{
    struct pbnds_gltf_load_state *g = b->g;
    const size_t count = skin->joints.count;
    float *bind = NULL;
    if (skin->inverse_bind >= 0) {
        const struct pbnds_gltf_accessor *a = NULL;
        PBNDS_TRY(pbnds_gltf_accessor_at(g, skin->inverse_bind, 16,
                                         "inverseBindMatrices", &a));
        if (a->count < count || a->component != PBNDS_GLTF_FLOAT) {
            return pbnds_fail(
                g->error, PBNDS_ERROR_FORMAT,
                "%s: a skin has too few inverse bind matrices, or not floats", g->name);
        }
        bind = calloc((size_t)a->count * 16 + 1, sizeof *bind);
        if (!bind) return no_memory(g);
        const enum pbnds_status status =
            pbnds_gltf_read_floats(g, a, "inverseBindMatrices", bind);
        if (status != PBNDS_OK) {
            free(bind);
            return status;
        }
    }
    for (size_t i = 0; i < count; ++i) {
        struct pbnds_mat4 inverse = pbnds_mat4_identity();
        if (bind) memcpy(inverse.m, bind + 16 * i, sizeof inverse.m);
        joints[i] = pbnds_mat4_mul(&g->world[skin->joints.items[i]], &inverse);
    }
    free(bind);
    return PBNDS_OK;
}

/** The weighted sum of up to four joint matrices; glTF 2.0, section 3.7.3.3. */
static bool blend(const struct pbnds_mat4 *joints, size_t joint_count,
                  const float *index, const float *weight, struct pbnds_mat4 *out)
{
    float sum = 0.0f;
    *out = (struct pbnds_mat4){{0}};
    for (int k = 0; k < 4; ++k) {
        if (!(weight[k] > 0.0f)) continue;
        if (!(index[k] >= 0.0f && index[k] < (float)joint_count)) return false;
        const struct pbnds_mat4 *j = &joints[(size_t)index[k]];
        for (int i = 0; i < 16; ++i)
            out->m[i] += weight[k] * j->m[i];
        sum += weight[k];
    }
    if (sum == 0.0f)
        *out = pbnds_mat4_identity();
    else
        for (int i = 0; i < 16; ++i)
            out->m[i] /= sum;
    return true;
}

static enum pbnds_status blend_all(struct build *b, const struct pbnds_mat4 *joints,
                                   size_t joint_count)
{
    struct pbnds_gltf_load_state *g = b->g;
    const size_t count = b->mesh->vertex_count;
    float *index = NULL, *weight = NULL;
    enum pbnds_status status =
        read_attribute(b, b->primitive->joints, 4, "JOINTS_0", &index);
    if (status == PBNDS_OK) {
        status = read_attribute(b, b->primitive->weights, 4, "WEIGHTS_0", &weight);
    }
    if (status == PBNDS_OK) status = charge(g, count, sizeof *b->skin);
    if (status == PBNDS_OK) {
        b->skin = calloc(count + 1, sizeof *b->skin);
        if (!b->skin) status = no_memory(g);
    }
    for (size_t i = 0; i < count && status == PBNDS_OK; ++i) {
        if (blend(joints, joint_count, index + 4 * i, weight + 4 * i, &b->skin[i]))
            continue;
        status = pbnds_fail(
            g->error, PBNDS_ERROR_FORMAT,
            "%s: vertex %zu refers to a joint that its skin does not have", g->name, i);
    }
    free(index);
    free(weight);
    return status;
}

/** Skinning in the rest pose: the matrices that stand in for the node's transform. */
static enum pbnds_status read_skin(struct build *b)
{
    struct pbnds_gltf_load_state *g = b->g;
    if (b->node->skin < 0 || b->primitive->joints < 0 || b->primitive->weights < 0) {
        return PBNDS_OK;
    }
    g->more_joints = g->more_joints || b->primitive->more_joints;
    const struct pbnds_gltf_skin *skin = &g->doc.skins[b->node->skin];
    struct pbnds_mat4 *joints = calloc(skin->joints.count + 1, sizeof *joints);
    if (!joints) return no_memory(g);
    enum pbnds_status status = joint_matrices(b, skin, joints);
    if (status == PBNDS_OK) status = blend_all(b, joints, skin->joints.count);
    free(joints);
    return status;
}

/** Unit vector, or zero where there is no direction. */
static struct pbnds_vec3 direction(struct pbnds_vec3 v)
{
    const float length = pbnds_length(v);
    return length > 0.0f && length < INFINITY ? pbnds_scale(v, 1.0f / length)
                                              : pbnds_splat(0.0f);
}

/* A normal goes with the inverse transpose: the cofactor matrix up to the determinant,
 * whose sign matters. */
static void transform_vertex(struct pbnds_mesh *m, size_t i,
                             const struct pbnds_mat4 *world)
{
    const float side = pbnds_mat4_det3(world) < 0.0f ? -1.0f : 1.0f;
    m->position[i] = pbnds_mat4_point(world, m->position[i]);
    if (m->normal) {
        m->normal[i] =
            direction(pbnds_scale(pbnds_mat4_normal(world, m->normal[i]), side));
    }
    if (m->tangent) {
        const struct pbnds_vec4 t = m->tangent[i];
        const struct pbnds_vec3 d =
            direction(pbnds_mat4_vector(world, pbnds_vec3_make(t.x, t.y, t.z)));
        m->tangent[i] = (struct pbnds_vec4){d.x, d.y, d.z, t.w < 0.0f ? -side : side};
    }
}

/** Where a normal or tangent is missing (zero in the file, or crushed by a scale of
 * zero), the mean of the faces around, and any tangent. */
static enum pbnds_status repair(struct build *b)
{
    struct pbnds_mesh *m = b->mesh;
    bool broken = false;
    for (size_t i = 0; m->normal && i < m->vertex_count && !broken; ++i) {
        broken = pbnds_dot(m->normal[i], m->normal[i]) == 0.0f;
    }
    if (broken) {
        struct pbnds_vec3 *mean = calloc(m->vertex_count, sizeof *mean);
        if (!mean) return no_memory(b->g);
        for (size_t i = 0; i < 3 * m->triangle_count; ++i) {
            const uint32_t *t = m->index + i - i % 3;
            const struct pbnds_vec3 a = m->position[t[0]];
            const struct pbnds_vec3 n = pbnds_cross(pbnds_sub(m->position[t[1]], a),
                                                    pbnds_sub(m->position[t[2]], a));
            mean[m->index[i]] = pbnds_add(mean[m->index[i]], n);
        }
        for (size_t i = 0; i < m->vertex_count; ++i) {
            if (pbnds_dot(m->normal[i], m->normal[i]) != 0.0f) continue;
            m->normal[i] = direction(mean[i]);
            if (pbnds_dot(m->normal[i], m->normal[i]) == 0.0f) {
                m->normal[i] = pbnds_vec3_make(0, 1, 0);
            }
        }
        free(mean);
    }
    for (size_t i = 0; m->tangent && i < m->vertex_count; ++i) {
        struct pbnds_vec4 *t = &m->tangent[i];
        if (t->x != 0.0f || t->y != 0.0f || t->z != 0.0f) continue;
        const struct pbnds_vec3 any = pbnds_frame_from_normal(m->normal[i]).t;
        *t = (struct pbnds_vec4){any.x, any.y, any.z, t->w};
    }
    return PBNDS_OK;
}

static enum pbnds_status to_world(struct build *b)
{
    struct pbnds_mesh *m = b->mesh;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        transform_vertex(m, i, b->skin ? &b->skin[i] : b->world);
        const struct pbnds_vec3 p = m->position[i];
        if (!(isfinite(p.x) && isfinite(p.y) && isfinite(p.z))) {
            return pbnds_fail(
                b->g->error, PBNDS_ERROR_FORMAT,
                "%s: vertex %zu of mesh \"%s\" is not finite in the scene", b->g->name,
                i, m->name);
        }
    }
    /* A mirror turns front to back; a skinned mesh is mirrored as a whole or not at
     * all. */
    if (pbnds_mat4_det3(b->skin ? &b->skin[0] : b->world) < 0.0f) {
        for (size_t i = 0; i < m->triangle_count; ++i) {
            const uint32_t swap = m->index[3 * i + 1];
            m->index[3 * i + 1] = m->index[3 * i + 2];
            m->index[3 * i + 2] = swap;
        }
    }
    return repair(b);
}

/** Tangents are needed where a normal map is and the file has none. */
static enum pbnds_status add_tangents(struct build *b)
{
    struct pbnds_mesh *m = b->mesh;
    const struct pbnds_texture_ref map =
        b->g->scene->materials[m->material].normal_texture;
    if (map.texture < 0 || m->tangent || !m->uv[map.texcoord]) return PBNDS_OK;
    PBNDS_TRY(charge(b->g, m->vertex_count, sizeof *m->tangent));
    return pbnds_mesh_tangents(m, map.texcoord, b->g->name, b->g->error);
}

static enum pbnds_status build_mesh(struct build *b)
{
    PBNDS_TRY(read_vertices(b));
    PBNDS_TRY(read_triangles(b));
    if (b->mesh->triangle_count == 0) return PBNDS_OK;
    PBNDS_TRY(read_skin(b));
    PBNDS_TRY(to_world(b));
    return add_tangents(b);
}

static void drop_mesh(struct pbnds_mesh *m)
{
    free(m->position);
    free(m->normal);
    free(m->tangent);
    free(m->uv[0]);
    free(m->uv[1]);
    free(m->color);
    free(m->index);
    *m = (struct pbnds_mesh){0};
}

enum pbnds_status pbnds_gltf_node_meshes(struct pbnds_gltf_load_state *g, size_t node)
{
    const struct pbnds_gltf_node *n = &g->doc.nodes[node];
    const struct pbnds_gltf_mesh *source = &g->doc.meshes[n->mesh];
    for (size_t i = 0; i < source->primitive_count; ++i) {
        const struct pbnds_gltf_primitive *p = &source->primitives[i];
        if (p->mode < 0 || p->mode > 6) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT, "%s: mesh %lld has mode %d",
                              g->name, (long long)n->mesh, p->mode);
        }
        if (p->mode < 4 || p->position < 0) {
            ++g->skipped_primitives;
            continue;
        }
        struct pbnds_mesh *mesh = &g->scene->meshes[g->scene->mesh_count++];
        struct build b = {g, p, n, &g->world[node], NULL, mesh};
        pbnds_gltf_name(mesh->name, source->name[0] ? source->name : n->name, "mesh",
                        (size_t)n->mesh);
        mesh->object_id = (uint32_t)node;
        mesh->material = pbnds_gltf_material_of(g, p);
        g->morphs = g->morphs || p->morphed;
        const enum pbnds_status status = build_mesh(&b);
        free(b.skin);
        if (status != PBNDS_OK) return status; /* the scene frees what there is */
        if (mesh->triangle_count == 0) {
            drop_mesh(mesh);
            --g->scene->mesh_count;
        }
    }
    return PBNDS_OK;
}
