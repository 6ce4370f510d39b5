/* Normals of a mesh: weld points, gather the faces around each, split at creases. */
#include <stdlib.h>
#include <string.h>

#include "scenes/generator/mesh.h"

struct shade {
    const struct gen_mesh *mesh;
    uint32_t *point;         /* of a vertex: the first vertex at the same place   */
    uint32_t *first, *next;  /* corners around a point, as chains ending in NONE  */
    struct pbnds_vec3 *face; /* unit normal of each triangle                      */
    float *weight;           /* of each corner: area of its face times its angle  */
};

#define NONE UINT32_MAX

static uint64_t place_hash(struct pbnds_vec3 p)
{
    const float c[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; /* -0 becomes 0 */
    uint64_t h = 1469598103934665603u;
    uint32_t bits[3];
    memcpy(bits, c, sizeof bits);
    for (int i = 0; i < 3; ++i)
        h = (h ^ bits[i]) * 0x9e3779b97f4a7c15u;
    return h ^ (h >> 29);
}

static bool same(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* point[i]: the first vertex at the same place as i, and with the same normal if asked.
 */
static bool find_points(const struct gen_mesh *m, bool normals, uint32_t *point)
{
    size_t room = 16;
    while (room < m->vertex_count * 2)
        room *= 2;
    uint32_t *table = malloc(room * sizeof *table);
    if (!table) return false;
    memset(table, 0xff, room * sizeof *table);
    for (size_t i = 0; i < m->vertex_count; ++i) {
        size_t k = (size_t)place_hash(m->position[i]) & (room - 1);
        for (; table[k] != NONE; k = (k + 1) & (room - 1)) {
            const uint32_t j = table[k];
            if (same(m->position[i], m->position[j]) &&
                (!normals || same(m->normal[i], m->normal[j]))) {
                break;
            }
        }
        if (table[k] == NONE) table[k] = (uint32_t)i;
        point[i] = table[k];
    }
    free(table);
    return true;
}

void gen_mesh_weld(struct gen_mesh *m)
{
    uint32_t *point = malloc((m->vertex_count + 1) * sizeof *point);
    if (m->failed || !point || !find_points(m, true, point)) {
        m->failed = true;
        free(point);
        return;
    }
    size_t kept = 0;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        if (point[i] == i) {
            m->position[kept] = m->position[i];
            m->normal[kept] = m->normal[i];
            m->uv[kept] = m->uv[i];
            point[i] = (uint32_t)kept++;
        } else {
            point[i] = point[point[i]]; /* an earlier vertex: already renumbered */
        }
    }
    for (size_t i = 0; i < m->index_count; ++i)
        m->index[i] = point[m->index[i]];
    m->vertex_count = kept;
    free(point);
}

static void gather(struct shade *s)
{
    const struct gen_mesh *m = s->mesh;
    memset(s->first, 0xff, m->vertex_count * sizeof *s->first);
    for (size_t i = 0; i < m->index_count; i += 3) {
        struct pbnds_vec3 e[3];
        for (size_t k = 0; k < 3; ++k) {
            e[k] = pbnds_sub(m->position[m->index[i + (k + 1) % 3]],
                             m->position[m->index[i + k]]);
        }
        const struct pbnds_vec3 n = pbnds_cross(e[0], pbnds_scale(e[2], -1.0f));
        const float area = pbnds_length(n);
        s->face[i / 3] = area > 0.0f ? pbnds_scale(n, 1.0f / area) : pbnds_splat(0.0f);
        for (size_t k = 0; k < 3; ++k) {
            const struct pbnds_vec3 a = e[k], b = pbnds_scale(e[(k + 2) % 3], -1.0f);
            const float turn = atan2f(pbnds_length(pbnds_cross(a, b)), pbnds_dot(a, b));
            const uint32_t p = s->point[m->index[i + k]];
            s->weight[i + k] = area * turn;
            s->next[i + k] = s->first[p];
            s->first[p] = (uint32_t)(i + k);
        }
    }
}

static struct pbnds_vec3 corner_normal(const struct shade *s, size_t corner,
                                       float limit)
{
    const struct pbnds_vec3 own = s->face[corner / 3];
    struct pbnds_vec3 sum = pbnds_splat(0.0f);
    uint32_t c = s->first[s->point[s->mesh->index[corner]]];
    for (; c != NONE; c = s->next[c]) {
        const struct pbnds_vec3 n = s->face[c / 3];
        if (pbnds_dot(own, n) >= limit) sum = pbnds_mad(sum, n, s->weight[c]);
    }
    const float length = pbnds_length(sum);
    if (length > 0.0f) return pbnds_scale(sum, 1.0f / length);
    return pbnds_length(own) > 0.0f ? own : pbnds_vec3_make(0.0f, 1.0f, 0.0f);
}

/* Vertex of `out` for a corner: one per (vertex, normal); chains start at the vertex.
 */
static uint32_t emit(struct gen_mesh *out, const struct gen_mesh *m, uint32_t vertex,
                     struct pbnds_vec3 n, uint32_t *head, uint32_t **chain,
                     size_t *room)
{
    for (uint32_t k = head[vertex]; k != NONE; k = (*chain)[k]) {
        const struct pbnds_vec3 d = pbnds_sub(out->normal[k], n);
        if (pbnds_dot(d, d) < 1e-10f) return k;
    }
    const uint32_t k = gen_mesh_vertex(out, m->position[vertex], m->uv[vertex]);
    if (out->failed) return 0;
    if (k >= *room) {
        const size_t larger = *room ? *room * 2 : 1024;
        uint32_t *grown = realloc(*chain, larger * sizeof *grown);
        if (!grown) {
            out->failed = true;
            return 0;
        }
        *chain = grown;
        *room = larger;
    }
    out->normal[k] = n;
    (*chain)[k] = head[vertex];
    head[vertex] = k;
    return k;
}

void gen_mesh_shade(struct gen_mesh *m, float crease_deg)
{
    const size_t nv = m->vertex_count + 1, ni = m->index_count + 3;
    struct shade s = {
        .mesh = m,
        .point = malloc(nv * sizeof *s.point),
        .first = malloc(nv * sizeof *s.first),
        .next = malloc(ni * sizeof *s.next),
        .face = malloc(ni * sizeof *s.face),
        .weight = malloc(ni * sizeof *s.weight),
    };
    uint32_t *head = malloc(nv * sizeof *head), *chain = NULL;
    size_t room = 0;
    struct gen_mesh out = {.vertex_count = 0};
    if (m->failed || !s.point || !s.first || !s.next || !s.face || !s.weight || !head ||
        !find_points(m, false, s.point)) {
        m->failed = true;
        goto done;
    }
    gather(&s);
    memset(head, 0xff, nv * sizeof *head);
    const float limit =
        crease_deg >= 180.0f ? -2.0f : cosf(crease_deg * (PBNDS_PI / 180.0f));
    for (size_t i = 0; i < m->index_count && !out.failed; i += 3) {
        uint32_t t[3];
        for (size_t k = 0; k < 3; ++k) {
            const struct pbnds_vec3 n = corner_normal(&s, i + k, limit);
            t[k] = emit(&out, m, m->index[i + k], n, head, &chain, &room);
        }
        if (!out.failed) gen_mesh_triangle(&out, t[0], t[1], t[2]);
    }
    gen_mesh_free(m);
    *m = out;
done:
    free(s.point);
    free(s.first);
    free(s.next);
    free(s.face);
    free(s.weight);
    free(head);
    free(chain);
}
