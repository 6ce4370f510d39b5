#include "engine/scene/tangent.h"

#include <stdlib.h>
#include <string.h>

#include "engine/scene/tangent_space.h"

#define NONE UINT32_MAX

/** Work of tangent_space.c and of this file a triangle: a generous bound of both. */
enum { WORK_A_TRIANGLE = 320 };

/* ---- vertices that are copies of others ---------------------------------------------- */

/** New vertices: vertex i is a copy of what was vertex origin[i]. */
struct order {
    const uint32_t *origin;
    size_t count;
    bool failed;
};

static void *follow(struct order *o, const void *from, size_t size)
{
    if (!from) return NULL;
    uint8_t *to = malloc(o->count * size + 1);
    o->failed = o->failed || !to;
    for (size_t i = 0; to && i < o->count; ++i)
        memcpy(to + i * size, (const uint8_t *)from + o->origin[i] * size, size);
    return to;
}

static void free_attributes(struct pbnds_mesh *m)
{
    free(m->position);
    free(m->previous);
    free(m->normal);
    free(m->uv[0]);
    free(m->uv[1]);
    free(m->color);
}

/** Every attribute but the tangents; the mesh is as it was when there is no memory. */
static bool copy_vertices(struct pbnds_mesh *m, const uint32_t *origin, size_t count)
{
    struct order o = {origin, count, false};
    struct pbnds_mesh grown = *m;
    grown.position = follow(&o, m->position, sizeof *m->position);
    grown.previous = follow(&o, m->previous, sizeof *m->previous);
    grown.normal = follow(&o, m->normal, sizeof *m->normal);
    for (int set = 0; set < 2; ++set)
        grown.uv[set] = follow(&o, m->uv[set], sizeof *m->uv[set]);
    grown.color = follow(&o, m->color, sizeof *m->color);
    grown.vertex_count = count;
    free_attributes(o.failed ? &grown : m);
    if (!o.failed) *m = grown;
    return !o.failed;
}

/** Three vertices for each triangle. */
static bool unshare(struct pbnds_mesh *m, uint32_t **origin)
{
    const size_t corners = 3 * m->triangle_count;
    *origin = malloc((corners + 1) * sizeof **origin);
    if (!*origin) return false;
    memcpy(*origin, m->index, corners * sizeof **origin);
    if (!copy_vertices(m, *origin, corners)) return false;
    for (size_t i = 0; i < corners; ++i)
        m->index[i] = (uint32_t)i;
    return true;
}

/* ---- splitting ------------------------------------------------------------------------ */

/** Who has which tangent. Vertices from `before` on are copies; `group` is of each
 * vertex, `source` of each copy. */
struct split {
    const struct pbnds_mesh *mesh;
    const struct pbnds_tangent_groups *groups;
    uint32_t *group, *origin;
    uint32_t *table; /* copies, found by vertex and tangent; open addressing */
    size_t table_size, before, count;
};

static bool same_tangent(const struct split *s, uint32_t a, uint32_t b)
{
    return a == b || (a != NONE && b != NONE &&
                      memcmp(&s->groups->tangent[a], &s->groups->tangent[b],
                             sizeof *s->groups->tangent) == 0);
}

/** Each vertex keeps the tangent of its first corner that has one.
 *  @return how many corners want another */
static size_t keep_first(struct split *s)
{
    const size_t corners = 3 * s->mesh->triangle_count;
    const uint32_t *index = s->mesh->index, *group = s->groups->group;
    size_t others = 0;
    for (size_t c = 0; c < corners; ++c) {
        uint32_t *kept = &s->group[index[c]];
        if (*kept == NONE) *kept = group[c];
        others += group[c] != NONE && !same_tangent(s, *kept, group[c]);
    }
    return others;
}

static size_t hash_of(const struct split *s, uint32_t vertex, uint32_t group)
{
    uint32_t bits[4];
    memcpy(bits, &s->groups->tangent[group], sizeof bits);
    uint64_t h = vertex;
    for (int i = 0; i < 4; ++i) {
        h = (h ^ bits[i]) * 0x9e3779b97f4a7c15u;
        h ^= h >> 29;
    }
    return (size_t)h & (s->table_size - 1);
}

/** The copy of `vertex` that has the tangent of `group`, made when there is none. */
static uint32_t copy_of(struct split *s, uint32_t vertex, uint32_t group)
{
    size_t at = hash_of(s, vertex, group);
    for (; s->table[at] != NONE; at = (at + 1) & (s->table_size - 1)) {
        const uint32_t copy = s->table[at];
        if (s->origin[copy] == vertex && same_tangent(s, s->group[copy], group))
            return copy;
    }
    const uint32_t copy = (uint32_t)s->count++;
    s->table[at] = copy;
    s->origin[copy] = vertex;
    s->group[copy] = group;
    return copy;
}

static bool make_room(struct split *s, size_t others)
{
    const size_t most = s->before + others;
    s->table_size = 16;
    while (s->table_size < 2 * others)
        s->table_size *= 2;
    s->table = malloc(s->table_size * sizeof *s->table);
    s->origin = malloc(most * sizeof *s->origin);
    uint32_t *group = realloc(s->group, most * sizeof *group);
    if (group) s->group = group;
    if (!s->table || !s->origin || !group) return false;
    memset(s->table, 0xff, s->table_size * sizeof *s->table);
    for (size_t i = 0; i < s->before; ++i)
        s->origin[i] = (uint32_t)i;
    return true;
}

/** Gives every corner a vertex whose tangent is its own. */
static bool split(struct pbnds_mesh *m, struct split *s)
{
    const size_t others = keep_first(s);
    if (others == 0) return true;
    uint32_t *index = malloc(3 * m->triangle_count * sizeof *index);
    bool fine = index && make_room(s, others);
    for (size_t c = 0; fine && c < 3 * m->triangle_count; ++c) {
        const uint32_t v = m->index[c], group = s->groups->group[c];
        const bool kept = group == NONE || same_tangent(s, s->group[v], group);
        index[c] = kept ? v : copy_of(s, v, group);
    }
    fine = fine && copy_vertices(m, s->origin, s->count);
    if (fine) memcpy(m->index, index, 3 * m->triangle_count * sizeof *index);
    free(index);
    return fine;
}

/* ---- the whole ------------------------------------------------------------------------ */

static struct pbnds_vec4 tangent_of(const struct split *s, size_t vertex,
                                    struct pbnds_vec3 n)
{
    const uint32_t group = s->group[vertex];
    struct pbnds_vec4 t = {0.0f, 0.0f, 0.0f, 1.0f};
    if (group != NONE) t = s->groups->tangent[group];
    if (t.x != 0.0f || t.y != 0.0f || t.z != 0.0f) return t;
    const struct pbnds_vec3 any = pbnds_frame_from_normal(n).t;
    return (struct pbnds_vec4){any.x, any.y, any.z, t.w};
}

/** `flat`: normals of a mesh that has none and whose triangles share no vertex, so that
 * none will be added; else NULL. */
static bool fill(struct pbnds_mesh *m, int set, const struct pbnds_vec3 *flat,
                 uint32_t **origin)
{
    const struct pbnds_tangent_input in = {m->position, flat ? flat : m->normal,
                                           m->uv[set],  m->vertex_count,
                                           m->index,    m->triangle_count};
    struct pbnds_tangent_groups groups;
    if (!pbnds_tangent_space(&in, &groups)) return false;
    struct split s = {.mesh = m,
                      .groups = &groups,
                      .group = malloc((m->vertex_count + 1) * sizeof *s.group),
                      .before = m->vertex_count,
                      .count = m->vertex_count};
    bool fine = s.group != NULL;
    if (fine) memset(s.group, 0xff, m->vertex_count * sizeof *s.group);
    fine = fine && split(m, &s);
    m->tangent = fine ? malloc((s.count + 1) * sizeof *m->tangent) : NULL;
    fine = fine && m->tangent;
    for (size_t i = 0; fine && i < s.count; ++i)
        m->tangent[i] = tangent_of(&s, i, flat ? flat[i] : m->normal[i]);
    if (fine && s.count > s.before) {
        *origin = s.origin;
        s.origin = NULL;
    }
    free(s.group);
    free(s.origin);
    free(s.table);
    pbnds_tangent_groups_free(&groups);
    return fine;
}

/** The normals of flat faces for a mesh whose triangles share no vertex. */
static struct pbnds_vec3 *face_normals(const struct pbnds_mesh *m)
{
    struct pbnds_vec3 *normal = malloc((m->vertex_count + 1) * sizeof *normal);
    for (size_t i = 0; normal && i < m->vertex_count; i += 3) {
        const struct pbnds_vec3 *p = m->position + i;
        const struct pbnds_vec3 n =
            pbnds_cross(pbnds_sub(p[1], p[0]), pbnds_sub(p[2], p[0]));
        const float length = pbnds_length(n);
        const bool fine = length > 0.0f && length < INFINITY;
        normal[i] = fine ? pbnds_scale(n, 1.0f / length) : pbnds_vec3_make(0, 0, 1);
        normal[i + 1] = normal[i + 2] = normal[i];
    }
    return normal;
}

static bool fill_flat(struct pbnds_mesh *m, int set, uint32_t **origin)
{
    if (!unshare(m, origin)) return false;
    struct pbnds_vec3 *normal = face_normals(m);
    uint32_t *unused = NULL;
    const bool fine = normal && fill(m, set, normal, &unused);
    free(unused);
    free(normal);
    return fine;
}

enum pbnds_status pbnds_mesh_tangents(struct pbnds_mesh *mesh, int set,
                                      uint32_t **origin, const char *name,
                                      struct pbnds_error *error)
{
    uint32_t *order = NULL;
    if (origin) *origin = NULL;
    bool fine = mesh->triangle_count < UINT32_MAX / 3 - 1;
    /* The largest number stands for "none", and copies may be one a corner. */
    fine = fine && mesh->vertex_count < UINT32_MAX - 3 * mesh->triangle_count;
    if (fine) {
        fine =
            mesh->normal ? fill(mesh, set, NULL, &order) : fill_flat(mesh, set, &order);
    }
    if (!fine) {
        free(order);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for tangents",
                          name);
    }
    if (origin)
        *origin = order;
    else
        free(order);
    return PBNDS_OK;
}

uint64_t pbnds_mesh_tangents_need(const struct pbnds_mesh *m)
{
    uint64_t vertex = sizeof *m->position + sizeof *m->tangent + 3 * sizeof *m->index;
    if (m->previous) vertex += sizeof *m->previous;
    if (m->normal) vertex += sizeof *m->normal;
    for (int set = 0; set < 2; ++set)
        if (m->uv[set]) vertex += sizeof *m->uv[set];
    if (m->color) vertex += sizeof *m->color;
    /* Attributes are copied to grow: the old ones and the new ones stand side by side. */
    const uint64_t corners = 3 * (uint64_t)m->triangle_count;
    return (corners + m->vertex_count) * vertex +
           (uint64_t)m->triangle_count * WORK_A_TRIANGLE +
           (uint64_t)m->vertex_count * 32;
}
