#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"

/* Meshes into the world: by the transform of a node, of its instances, or of joints. */

struct pbnds_vec3 pbnds_gltf_direction(struct pbnds_vec3 v)
{
    const float length = pbnds_length(v);
    if (length > 1e-15f && length < INFINITY) return pbnds_scale(v, 1.0f / length);
    /* Squares have left the range of float where the vector has not. */
    const float most = fmaxf(fabsf(v.x), fmaxf(fabsf(v.y), fabsf(v.z)));
    const bool finite = isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
    if (!finite || most == 0.0f) return pbnds_splat(0.0f);
    v = pbnds_vec3_make(v.x / most, v.y / most, v.z / most);
    return pbnds_scale(v, 1.0f / pbnds_length(v));
}

/** Twice the area of a triangle times its normal. */
static struct pbnds_vec3 face_area(const struct pbnds_mesh *m, const uint32_t *t)
{
    const struct pbnds_vec3 a = m->position[t[0]];
    return pbnds_cross(pbnds_sub(m->position[t[1]], a),
                       pbnds_sub(m->position[t[2]], a));
}

/** Where a tangent has no direction it gets any that goes with the normal; of the face
 *  where the mesh has no normals. */
static void repair_tangents(struct pbnds_mesh *m)
{
    for (size_t i = 0; i < m->vertex_count + 3 * m->triangle_count; ++i) {
        /* the corners of all faces first, then vertices of none */
        const bool corner = i < 3 * m->triangle_count;
        const size_t v = corner ? m->index[i] : i - 3 * m->triangle_count;
        struct pbnds_vec4 *t = &m->tangent[v];
        if (t->x != 0.0f || t->y != 0.0f || t->z != 0.0f) continue;
        struct pbnds_vec3 n = pbnds_splat(0.0f);
        if (m->normal) n = m->normal[v];
        if (!m->normal && corner)
            n = pbnds_gltf_direction(face_area(m, m->index + i - i % 3));
        if (pbnds_dot(n, n) == 0.0f) n = pbnds_vec3_make(0, 1, 0);
        const struct pbnds_vec3 any = pbnds_frame_from_normal(n).t;
        *t = (struct pbnds_vec4){any.x, any.y, any.z, t->w};
    }
}

enum pbnds_status pbnds_gltf_mesh_repair(struct pbnds_gltf_load_state *g,
                                         struct pbnds_mesh *m)
{
    bool broken = false;
    for (size_t i = 0; m->normal && i < m->vertex_count && !broken; ++i) {
        broken = pbnds_dot(m->normal[i], m->normal[i]) == 0.0f;
    }
    if (broken) {
        struct pbnds_vec3 *mean = calloc(m->vertex_count, sizeof *mean);
        if (!mean) return pbnds_gltf_no_memory(g);
        for (size_t i = 0; i < 3 * m->triangle_count; ++i) {
            const struct pbnds_vec3 n = face_area(m, m->index + i - i % 3);
            mean[m->index[i]] = pbnds_add(mean[m->index[i]], n);
        }
        for (size_t i = 0; i < m->vertex_count; ++i) {
            if (pbnds_dot(m->normal[i], m->normal[i]) != 0.0f) continue;
            m->normal[i] = pbnds_gltf_direction(mean[i]);
            if (pbnds_dot(m->normal[i], m->normal[i]) == 0.0f) {
                m->normal[i] = pbnds_vec3_make(0, 1, 0);
            }
        }
        free(mean);
    }
    if (m->tangent) repair_tangents(m);
    return PBNDS_OK;
}

uint64_t pbnds_gltf_mesh_size(const struct pbnds_mesh *m)
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

/* A normal goes with the inverse transpose: the cofactor matrix up to the determinant,
 * whose sign matters. */
static void transform_vertex(struct pbnds_mesh *m, size_t i,
                             const struct pbnds_mat4 *world)
{
    const float side = pbnds_mat4_det3(world) < 0.0f ? -1.0f : 1.0f;
    m->position[i] = pbnds_mat4_point(world, m->position[i]);
    if (m->normal) {
        m->normal[i] = pbnds_gltf_direction(
            pbnds_scale(pbnds_mat4_normal(world, m->normal[i]), side));
    }
    if (m->tangent) {
        const struct pbnds_vec4 t = m->tangent[i];
        const struct pbnds_vec3 d = pbnds_gltf_direction(
            pbnds_mat4_vector(world, pbnds_vec3_make(t.x, t.y, t.z)));
        m->tangent[i] = (struct pbnds_vec4){d.x, d.y, d.z, t.w < 0.0f ? -side : side};
    }
}

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
    /* A mirror turns front to back. Joints may mirror a part: most vertices decide. */
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
    return pbnds_gltf_mesh_repair(b->g, m);
}

void pbnds_gltf_mesh_free(struct pbnds_mesh *m)
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
    PBNDS_TRY(pbnds_gltf_charge(g, pbnds_gltf_mesh_size(from), 1));
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
    pbnds_gltf_mesh_free(to);
    return pbnds_gltf_no_memory(g);
}

/** One mesh of the scene for each instance; the last takes the arrays of the build. */
enum pbnds_status pbnds_gltf_add_instances(struct pbnds_gltf_build *b,
                                           const struct pbnds_mat4 *local,
                                           uint64_t count)
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

enum pbnds_status pbnds_gltf_add_skinned(struct pbnds_gltf_build *b)
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
