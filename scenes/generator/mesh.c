#include "scenes/generator/mesh.h"

#include <stdlib.h>
#include <string.h>

void gen_mesh_free(struct gen_mesh *m)
{
    free(m->position);
    free(m->normal);
    free(m->uv);
    free(m->tangent);
    free(m->index);
    *m = (struct gen_mesh){.vertex_count = 0};
}

static void *grow(struct gen_mesh *m, void *array, size_t count, size_t size)
{
    void *grown = realloc(array, count * size);
    if (grown) return grown;
    m->failed = true;
    return array;
}

static bool reserve_vertices(struct gen_mesh *m, size_t count)
{
    if (m->failed) return false;
    if (m->vertex_count + count <= m->vertex_room) return true;
    size_t room = m->vertex_room ? m->vertex_room : 256;
    while (room < m->vertex_count + count)
        room *= 2;
    m->position = grow(m, m->position, room, sizeof *m->position);
    m->normal = grow(m, m->normal, room, sizeof *m->normal);
    m->uv = grow(m, m->uv, room, sizeof *m->uv);
    if (!m->failed) m->vertex_room = room;
    return !m->failed;
}

static bool reserve_indices(struct gen_mesh *m, size_t count)
{
    if (m->failed) return false;
    if (m->index_count + count <= m->index_room) return true;
    size_t room = m->index_room ? m->index_room : 1024;
    while (room < m->index_count + count)
        room *= 2;
    m->index = grow(m, m->index, room, sizeof *m->index);
    if (!m->failed) m->index_room = room;
    return !m->failed;
}

/* sin(pi) and the like leave dust that would keep poles and axes from welding. */
static float snap(float x)
{
    return fabsf(x) < 1e-6f ? 0.0f : x;
}

uint32_t gen_mesh_vertex(struct gen_mesh *m, struct pbnds_vec3 p, struct pbnds_vec2 uv)
{
    if (!reserve_vertices(m, 1)) return 0;
    m->position[m->vertex_count] = pbnds_vec3_make(snap(p.x), snap(p.y), snap(p.z));
    m->normal[m->vertex_count] = pbnds_vec3_make(0.0f, 1.0f, 0.0f);
    m->uv[m->vertex_count] = uv;
    return (uint32_t)m->vertex_count++;
}

static bool same_place(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

void gen_mesh_triangle(struct gen_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    if (!reserve_indices(m, 3)) return;
    const struct pbnds_vec3 *p = m->position;
    if (same_place(p[a], p[b]) || same_place(p[b], p[c]) || same_place(p[c], p[a]))
        return;
    m->index[m->index_count++] = a;
    m->index[m->index_count++] = b;
    m->index[m->index_count++] = c;
}

void gen_mesh_quad(struct gen_mesh *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    gen_mesh_triangle(m, a, b, c);
    gen_mesh_triangle(m, a, c, d);
}

void gen_mesh_append(struct gen_mesh *m, const struct gen_mesh *other,
                     const struct pbnds_mat4 *transform)
{
    const uint32_t base = (uint32_t)m->vertex_count;
    const bool mirrors = pbnds_mat4_det3(transform) < 0.0f;
    if (other->failed) m->failed = true;
    if (!reserve_vertices(m, other->vertex_count)) return;
    if (!reserve_indices(m, other->index_count)) return;
    for (size_t i = 0; i < other->vertex_count; ++i) {
        const uint32_t k = gen_mesh_vertex(
            m, pbnds_mat4_point(transform, other->position[i]), other->uv[i]);
        m->normal[k] = pbnds_normalize(pbnds_mat4_normal(transform, other->normal[i]));
    }
    for (size_t i = 0; i < other->index_count; i += 3) {
        const uint32_t *t = other->index + i;
        const uint32_t b = mirrors ? t[2] : t[1], c = mirrors ? t[1] : t[2];
        gen_mesh_triangle(m, base + t[0], base + b, base + c);
    }
}

void gen_mesh_transform(struct gen_mesh *m, const struct pbnds_mat4 *transform)
{
    struct gen_mesh moved = {.vertex_count = 0};
    gen_mesh_append(&moved, m, transform);
    gen_mesh_free(m);
    *m = moved;
}

void gen_mesh_bounds(const struct gen_mesh *m, struct pbnds_vec3 *lo,
                     struct pbnds_vec3 *hi)
{
    *lo = pbnds_splat(INFINITY);
    *hi = pbnds_splat(-INFINITY);
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const struct pbnds_vec3 p = m->position[i];
        *lo = pbnds_vec3_make(fminf(lo->x, p.x), fminf(lo->y, p.y), fminf(lo->z, p.z));
        *hi = pbnds_vec3_make(fmaxf(hi->x, p.x), fmaxf(hi->y, p.y), fmaxf(hi->z, p.z));
    }
}

void gen_mesh_grid(struct gen_mesh *m, const struct gen_grid *g)
{
    const uint32_t base = (uint32_t)m->vertex_count, row = (uint32_t)g->nu + 1;
    for (int j = 0; j <= g->nv; ++j) {
        for (int i = 0; i <= g->nu; ++i) {
            const float u = (float)i / (float)g->nu, v = (float)j / (float)g->nv;
            const float pu = g->wrap_u && i == g->nu ? 0.0f : u;
            const float pv = g->wrap_v && j == g->nv ? 0.0f : v;
            const struct pbnds_vec2 uv = {u, 1.0f - v};
            (void)gen_mesh_vertex(m, g->point(g->context, pu, pv), uv);
        }
    }
    for (uint32_t j = 0; j < (uint32_t)g->nv; ++j) {
        for (uint32_t i = 0; i < (uint32_t)g->nu; ++i) {
            const uint32_t a = base + j * row + i;
            gen_mesh_quad(m, a, a + 1, a + row + 1, a + row);
        }
    }
}

void gen_mesh_box_uv(struct gen_mesh *m, float repeats_per_metre)
{
    struct gen_mesh out = {.vertex_count = 0};
    int64_t *made = malloc((m->vertex_count * 6 + 1) * sizeof *made);
    if (!made || m->failed) {
        m->failed = true;
        free(made);
        return;
    }
    for (size_t i = 0; i < m->vertex_count * 6; ++i)
        made[i] = -1;
    for (size_t i = 0; i < m->index_count; i += 3) {
        const uint32_t *t = m->index + i;
        const struct pbnds_vec3 *p = m->position;
        const struct pbnds_vec3 n =
            pbnds_cross(pbnds_sub(p[t[1]], p[t[0]]), pbnds_sub(p[t[2]], p[t[0]]));
        const struct pbnds_vec3 a = {fabsf(n.x), fabsf(n.y), fabsf(n.z)};
        const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
        const float along = axis == 0 ? n.x : axis == 1 ? n.y : n.z;
        const size_t side = (size_t)axis * 2 + (along < 0.0f);
        uint32_t corner[3];
        for (int k = 0; k < 3; ++k) {
            int64_t *slot = &made[(size_t)t[k] * 6 + side];
            if (*slot < 0) {
                const struct pbnds_vec3 q = p[t[k]];
                const float x = axis == 0 ? q.z : q.x, y = axis == 1 ? q.z : q.y;
                const struct pbnds_vec2 uv = {(along < 0.0f ? -x : x) *
                                                  repeats_per_metre,
                                              -y * repeats_per_metre};
                *slot = gen_mesh_vertex(&out, q, uv);
                if (!out.failed) out.normal[*slot] = m->normal[t[k]];
            }
            corner[k] = (uint32_t)*slot;
        }
        gen_mesh_triangle(&out, corner[0], corner[1], corner[2]);
    }
    free(made);
    gen_mesh_free(m);
    *m = out;
}

void gen_mesh_tangents(struct gen_mesh *m)
{
    struct pbnds_vec3 *along_u = calloc(m->vertex_count + 1, sizeof *along_u);
    struct pbnds_vec3 *along_v = calloc(m->vertex_count + 1, sizeof *along_v);
    free(m->tangent);
    m->tangent = malloc((m->vertex_count + 1) * sizeof *m->tangent);
    if (!along_u || !along_v || !m->tangent || m->failed) {
        m->failed = true;
        goto done;
    }
    for (size_t i = 0; i < m->index_count; i += 3) {
        const uint32_t *t = m->index + i;
        const struct pbnds_vec3 e1 = pbnds_sub(m->position[t[1]], m->position[t[0]]);
        const struct pbnds_vec3 e2 = pbnds_sub(m->position[t[2]], m->position[t[0]]);
        const struct pbnds_vec2 a = m->uv[t[0]], b = m->uv[t[1]], c = m->uv[t[2]];
        const float u1 = b.x - a.x, v1 = b.y - a.y, u2 = c.x - a.x, v2 = c.y - a.y;
        /* The sign alone: dividing by the tiny determinants of slivers would drown
         * others. */
        const float sign = u1 * v2 - u2 * v1 < 0.0f ? -1.0f : 1.0f;
        const struct pbnds_vec3 du =
            pbnds_scale(pbnds_sub(pbnds_scale(e1, v2), pbnds_scale(e2, v1)), sign);
        const struct pbnds_vec3 dv =
            pbnds_scale(pbnds_sub(pbnds_scale(e2, u1), pbnds_scale(e1, u2)), sign);
        for (int k = 0; k < 3; ++k) {
            along_u[t[k]] = pbnds_add(along_u[t[k]], du);
            along_v[t[k]] = pbnds_add(along_v[t[k]], dv);
        }
    }
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const struct pbnds_vec3 n = m->normal[i];
        struct pbnds_vec3 t = pbnds_mad(along_u[i], n, -pbnds_dot(n, along_u[i]));
        const float length = pbnds_length(t);
        t = length > 1e-20f ? pbnds_scale(t, 1.0f / length)
                            : pbnds_frame_from_normal(n).t;
        const float w = pbnds_dot(pbnds_cross(n, t), along_v[i]) > 0.0f ? -1.0f : 1.0f;
        m->tangent[i] = (struct pbnds_vec4){t.x, t.y, t.z, w};
    }
done:
    free(along_u);
    free(along_v);
}
