#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"
#include "engine/scene/tangent.h"

/* A primitive is read in the frame of its mesh, gets its tangents and morph targets
 * there, and is then copied into the world: once for its node, or once an instance. */

/** Modes of a primitive; those below are points and lines. */
enum { TRIANGLES = 4, STRIP = 5, FAN = 6 };

enum pbnds_status pbnds_gltf_no_memory(struct pbnds_gltf_load_state *g)
{
    return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for its geometry",
                      g->name);
}

enum pbnds_status pbnds_gltf_read_attribute(struct pbnds_gltf_build *b,
                                            int64_t accessor, int width,
                                            const char *what, float **out)
{
    struct pbnds_gltf_load_state *g = b->g;
    const struct pbnds_gltf_accessor *a = NULL;
    *out = NULL;
    if (accessor < 0) return PBNDS_OK;
    PBNDS_TRY(pbnds_gltf_accessor_at(g, accessor, width, what, &a));
    if (a->count != b->file_vertices) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: %s has %llu elements for %zu vertices", g->name, what,
                          (unsigned long long)a->count, b->file_vertices);
    }
    PBNDS_TRY(pbnds_gltf_charge(g, a->count, sizeof(float) * (uint64_t)width));
    float *data = calloc((size_t)a->count * (size_t)width + 1, sizeof *data);
    if (!data) return pbnds_gltf_no_memory(g);
    const enum pbnds_status status = pbnds_gltf_read_floats(g, a, what, data);
    if (status != PBNDS_OK) {
        free(data);
        return status;
    }
    *out = data;
    return PBNDS_OK;
}

/** COLOR_0 has three components or four. */
static enum pbnds_status read_color(struct pbnds_gltf_build *b)
{
    const int64_t index = b->primitive->color;
    const bool rgb = index >= 0 && b->g->doc.accessors[index].width == 3;
    struct pbnds_mesh *m = &b->mesh;
    float *data = NULL;
    PBNDS_TRY(pbnds_gltf_read_attribute(b, index, rgb ? 3 : 4, "COLOR_0", &data));
    if (!rgb) {
        m->color = (struct pbnds_vec4 *)(void *)data;
        return PBNDS_OK;
    }
    enum pbnds_status status =
        pbnds_gltf_charge(b->g, m->vertex_count, sizeof *m->color);
    if (status == PBNDS_OK) {
        m->color = malloc((m->vertex_count + 1) * sizeof *m->color);
        if (!m->color) status = pbnds_gltf_no_memory(b->g);
    }
    for (size_t i = 0; m->color && i < m->vertex_count; ++i) {
        const float *c = data + 3 * i;
        m->color[i] = (struct pbnds_vec4){c[0], c[1], c[2], 1.0f};
    }
    free(data);
    pbnds_gltf_refund(b->g, m->vertex_count, 3 * sizeof *data);
    return status;
}

/* The vector types are plain floats in order: an array of them is read as floats. */
_Static_assert(sizeof(struct pbnds_vec2) == 8, "pbnds_vec2 has padding");
_Static_assert(sizeof(struct pbnds_vec3) == 12, "pbnds_vec3 has padding");
_Static_assert(sizeof(struct pbnds_vec4) == 16, "pbnds_vec4 has padding");

static enum pbnds_status read_vertices(struct pbnds_gltf_build *b)
{
    const struct pbnds_gltf_primitive *p = b->primitive;
    struct pbnds_mesh *m = &b->mesh;
    const struct pbnds_gltf_accessor *a = NULL;
    PBNDS_TRY(pbnds_gltf_accessor_at(b->g, p->position, 3, "POSITION", &a));
    if (a->count > UINT32_MAX) {
        return pbnds_fail(b->g->error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: a mesh has more than 2^32 vertices", b->g->name);
    }
    b->file_vertices = m->vertex_count = (size_t)a->count;
    float *data = NULL;
    PBNDS_TRY(pbnds_gltf_read_attribute(b, p->position, 3, "POSITION", &data));
    m->position = (struct pbnds_vec3 *)(void *)data;
    PBNDS_TRY(pbnds_gltf_read_attribute(b, p->normal, 3, "NORMAL", &data));
    m->normal = (struct pbnds_vec3 *)(void *)data;
    /* Without normals faces are flat, and tangents mean nothing: section 3.7.2.1. */
    PBNDS_TRY(
        pbnds_gltf_read_attribute(b, m->normal ? p->tangent : -1, 4, "TANGENT", &data));
    m->tangent = (struct pbnds_vec4 *)(void *)data;
    for (int set = 0; set < 2; ++set) {
        PBNDS_TRY(pbnds_gltf_read_attribute(b, p->uv[set], 2,
                                            set ? "TEXCOORD_1" : "TEXCOORD_0", &data));
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
    if (mode == TRIANGLES) {
        m->triangle_count = count / 3;
        memcpy(m->index, index, m->triangle_count * 3 * sizeof *index);
        return;
    }
    for (size_t i = 0; i + 2 < count; ++i) {
        if (mode == STRIP)
            emit(m, index[i], index[i + 1 + i % 2], index[i + 2 - i % 2]);
        else
            emit(m, index[i + 1], index[i + 2], index[0]);
    }
}

static enum pbnds_status read_triangles(struct pbnds_gltf_build *b)
{
    struct pbnds_gltf_load_state *g = b->g;
    const struct pbnds_gltf_accessor *a = NULL;
    uint64_t count = b->mesh.vertex_count;
    if (b->primitive->indices >= 0) {
        PBNDS_TRY(pbnds_gltf_accessor_at(g, b->primitive->indices, 1, "indices", &a));
        count = a->count;
    }
    const int mode = b->primitive->mode;
    const uint64_t room = mode == TRIANGLES ? count : 3 * count;
    if (count > UINT32_MAX) {
        return pbnds_fail(g->error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: a mesh has more than 2^32 indices", g->name);
    }
    PBNDS_TRY(pbnds_gltf_charge(g, room, sizeof(uint32_t)));
    uint32_t *index = calloc((size_t)count + 1, sizeof *index);
    b->mesh.index = calloc((size_t)room + 1, sizeof *index);
    if (!index || !b->mesh.index) {
        free(index);
        return pbnds_gltf_no_memory(g);
    }
    enum pbnds_status status = PBNDS_OK;
    if (a) {
        status = pbnds_gltf_read_indices(g, a, b->mesh.vertex_count, index);
    } else {
        for (size_t i = 0; i < count; ++i)
            index[i] = (uint32_t)i;
    }
    if (status == PBNDS_OK) make_triangles(&b->mesh, mode, index, (size_t)count);
    free(index);
    return status;
}

/** Unit vector, or zero where there is no direction. */
static struct pbnds_vec3 direction(struct pbnds_vec3 v)
{
    const float length = pbnds_length(v);
    return length > 0.0f && length < INFINITY ? pbnds_scale(v, 1.0f / length)
                                              : pbnds_splat(0.0f);
}

/** Where a normal or tangent is missing (zero in the file, or crushed by a scale of
 *  zero): the mean of the faces around, and any tangent. */
static enum pbnds_status repair(struct pbnds_gltf_load_state *g, struct pbnds_mesh *m)
{
    bool broken = false;
    for (size_t i = 0; m->normal && i < m->vertex_count && !broken; ++i) {
        broken = pbnds_dot(m->normal[i], m->normal[i]) == 0.0f;
    }
    if (broken) {
        struct pbnds_vec3 *mean = calloc(m->vertex_count, sizeof *mean);
        if (!mean) return pbnds_gltf_no_memory(g);
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
    for (size_t i = 0; m->normal && m->tangent && i < m->vertex_count; ++i) {
        struct pbnds_vec4 *t = &m->tangent[i];
        if (t->x != 0.0f || t->y != 0.0f || t->z != 0.0f) continue;
        const struct pbnds_vec3 any = pbnds_frame_from_normal(m->normal[i]).t;
        *t = (struct pbnds_vec4){any.x, any.y, any.z, t->w};
    }
    return PBNDS_OK;
}

/* ---- in the frame of the mesh ------------------------------------------------------ */

/** Bytes of the arrays of a mesh, at least. */
static uint64_t size_of(const struct pbnds_mesh *m)
{
    uint64_t vertex = sizeof *m->position;
    if (m->previous) vertex += sizeof *m->previous;
    if (m->normal) vertex += sizeof *m->normal;
    if (m->tangent) vertex += sizeof *m->tangent;
    if (m->uv[0]) vertex += sizeof *m->uv[0];
    if (m->uv[1]) vertex += sizeof *m->uv[1];
    if (m->color) vertex += sizeof *m->color;
    return m->vertex_count * vertex + m->triangle_count * 3 * sizeof *m->index;
}

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
        m->normal[i] = direction(m->normal[i]);
    PBNDS_TRY(repair(b->g, m));
    const uint64_t before = size_of(m), need = pbnds_mesh_tangents_need(m);
    PBNDS_TRY(pbnds_gltf_charge(b->g, need, 1));
    if (map.transformed) {
        PBNDS_TRY(turned_tangents(b, &map));
    } else {
        PBNDS_TRY(
            pbnds_mesh_tangents(m, map.texcoord, &b->origin, b->g->name, b->g->error));
    }
    pbnds_gltf_refund(b->g, need, 1);
    b->own_tangents = true;
    return pbnds_gltf_charge(b->g, size_of(m) - before, 1);
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
    PBNDS_TRY(read_vertices(b));
    PBNDS_TRY(read_triangles(b));
    if (b->mesh.triangle_count == 0) return PBNDS_OK;
    PBNDS_TRY(add_tangents(b));
    PBNDS_TRY(keep_earlier(b));
    return pbnds_gltf_morph(b);
}

/* ---- into the world ------------------------------------------------------------------ */

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

/** A mirror turns front to back. Joints may mirror a part: most vertices decide. */
static void turn_faces(struct pbnds_mesh *m)
{
    for (size_t i = 0; i < m->triangle_count; ++i) {
        const uint32_t swap = m->index[3 * i + 1];
        m->index[3 * i + 1] = m->index[3 * i + 2];
        m->index[3 * i + 2] = swap;
    }
}

static bool is_finite(struct pbnds_vec3 p)
{
    return isfinite(p.x) && isfinite(p.y) && isfinite(p.z);
}

/** The transform of every vertex in both poses: of the joints, or one for all. */
struct placing {
    const struct pbnds_gltf_skinning *skin; /**< NULL: `world` */
    struct pbnds_mat4 world[2];
};

static struct pbnds_mat4 matrix_at(const struct placing *p, int pose, size_t vertex)
{
    return p->skin ? pbnds_gltf_skin_matrix(p->skin, pose, vertex) : p->world[pose];
}

static enum pbnds_status to_world(struct pbnds_gltf_build *b, struct pbnds_mesh *m,
                                  const struct placing *place)
{
    size_t mirrored = 0;
    bool moved = false;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const size_t vertex = b->origin ? b->origin[i] : i;
        const struct pbnds_mat4 now = matrix_at(place, 0, vertex);
        transform_vertex(m, i, &now);
        mirrored += pbnds_mat4_det3(&now) < 0.0f;
        bool finite = is_finite(m->position[i]);
        if (m->previous) {
            const struct pbnds_mat4 before = matrix_at(place, 1, vertex);
            m->previous[i] = pbnds_mat4_point(&before, m->previous[i]);
            finite = finite && is_finite(m->previous[i]);
        }
        if (finite) continue;
        return pbnds_fail(b->g->error, PBNDS_ERROR_FORMAT,
                          "%s: vertex %zu of mesh \"%s\" is not finite in the scene",
                          b->g->name, vertex, m->name);
    }
    if (2 * mirrored > m->vertex_count) turn_faces(m);
    if (m->previous) {
        moved = memcmp(m->previous, m->position,
                       m->vertex_count * sizeof *m->previous) != 0;
    }
    if (m->previous && !moved) {
        free(m->previous);
        m->previous = NULL;
        pbnds_gltf_refund(b->g, m->vertex_count, sizeof *m->previous);
    }
    return repair(b->g, m);
}

static void drop_mesh(struct pbnds_mesh *m)
{
    free(m->position);
    free(m->previous);
    free(m->normal);
    free(m->tangent);
    free(m->uv[0]);
    free(m->uv[1]);
    free(m->color);
    free(m->index);
    *m = (struct pbnds_mesh){0};
}

static void *copy(const void *from, size_t count, size_t size, bool *fine)
{
    if (!from) return NULL;
    void *to = malloc(count * size + 1);
    if (to)
        memcpy(to, from, count * size);
    else
        *fine = false;
    return to;
}

static enum pbnds_status copy_mesh(struct pbnds_gltf_load_state *g,
                                   const struct pbnds_mesh *from, struct pbnds_mesh *to)
{
    const size_t n = from->vertex_count;
    bool fine = true;
    PBNDS_TRY(pbnds_gltf_charge(g, size_of(from), 1));
    *to = *from;
    to->position = copy(from->position, n, sizeof *to->position, &fine);
    to->previous = copy(from->previous, n, sizeof *to->previous, &fine);
    to->normal = copy(from->normal, n, sizeof *to->normal, &fine);
    to->tangent = copy(from->tangent, n, sizeof *to->tangent, &fine);
    to->uv[0] = copy(from->uv[0], n, sizeof *to->uv[0], &fine);
    to->uv[1] = copy(from->uv[1], n, sizeof *to->uv[1], &fine);
    to->color = copy(from->color, n, sizeof *to->color, &fine);
    to->index = copy(from->index, 3 * from->triangle_count, sizeof *to->index, &fine);
    if (fine) return PBNDS_OK;
    drop_mesh(to);
    return pbnds_gltf_no_memory(g);
}

/** One mesh of the scene for each instance; the last takes the arrays of the build. */
static enum pbnds_status add_instances(struct pbnds_gltf_build *b,
                                       const struct pbnds_mat4 *local, uint64_t count)
{
    struct pbnds_gltf_load_state *g = b->g;
    struct placing place = {.skin = NULL};
    for (uint64_t i = 0; i < count; ++i) {
        struct pbnds_mesh *mesh = &g->scene->meshes[g->scene->mesh_count];
        if (i + 1 < count) {
            PBNDS_TRY(copy_mesh(g, &b->mesh, mesh));
        } else {
            *mesh = b->mesh;
            b->mesh = (struct pbnds_mesh){0};
        }
        ++g->scene->mesh_count; /* the scene frees it from here on */
        for (int p = 0; p < g->pose_count; ++p)
            place.world[p] = pbnds_mat4_mul(&g->pose[p].world[b->node], &local[i]);
        PBNDS_TRY(to_world(b, mesh, &place));
        if (pbnds_stop_requested()) return pbnds_fail_interrupted(g->error);
    }
    return PBNDS_OK;
}

static enum pbnds_status add_skinned(struct pbnds_gltf_build *b)
{
    struct pbnds_gltf_load_state *g = b->g;
    struct pbnds_gltf_skinning skin;
    enum pbnds_status status = pbnds_gltf_skin_open(b, &skin);
    if (status == PBNDS_OK) {
        struct pbnds_mesh *mesh = &g->scene->meshes[g->scene->mesh_count++];
        const struct placing place = {.skin = &skin};
        *mesh = b->mesh;
        b->mesh = (struct pbnds_mesh){0};
        status = to_world(b, mesh, &place);
    }
    pbnds_gltf_skin_close(b, &skin);
    return status;
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
    return pbnds_gltf_is_skinned(b) ? add_skinned(b) : add_instances(b, local, count);
}

static enum pbnds_status add_primitives(struct pbnds_gltf_load_state *g, size_t node,
                                        const struct pbnds_mat4 *local, uint64_t count)
{
    const int64_t mesh = g->doc.nodes[node].mesh;
    const struct pbnds_gltf_mesh *source = &g->doc.meshes[mesh];
    for (size_t i = 0; i < source->primitive_count; ++i) {
        const struct pbnds_gltf_primitive *p = &source->primitives[i];
        if (p->mode < 0 || p->mode > FAN) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT, "%s: mesh %lld has mode %d",
                              g->name, (long long)mesh, p->mode);
        }
        if (p->mode < TRIANGLES || p->position < 0) {
            ++g->skipped_primitives;
            continue;
        }
        struct pbnds_gltf_build b = {.g = g, .primitive = p, .node = node};
        const enum pbnds_status status = add_primitive(&b, local, count);
        free(b.origin);
        drop_mesh(&b.mesh);
        PBNDS_TRY(status);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_node_meshes(struct pbnds_gltf_load_state *g, size_t node)
{
    uint64_t count = 0;
    PBNDS_TRY(pbnds_gltf_instance_count(g, node, &count));
    struct pbnds_mat4 *local = malloc(((size_t)count + 1) * sizeof *local);
    if (!local) return pbnds_gltf_no_memory(g);
    enum pbnds_status status = pbnds_gltf_instances(g, node, count, local);
    if (status == PBNDS_OK) status = add_primitives(g, node, local, count);
    free(local);
    return status;
}
