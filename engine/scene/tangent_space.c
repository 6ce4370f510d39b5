#include "engine/scene/tangent_space.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

/** What a triangle is to the groups around its corners. */
struct face {
    struct pbnds_vec3 u; /* unit dP/du, or zero                                   */
    bool degenerate;     /* two corners are in one place: no part of any group    */
    bool flexible;       /* no area in the picture, or a derivative is zero       */
    bool preserving;     /* the picture is not mirrored on it                     */
};

struct edge {
    uint32_t hi, corner; /* the larger vertex; where it starts in its triangle */
};

struct work {
    const struct pbnds_tangent_input *in;
    uint32_t *vertex;   /* of each corner, after welding                            */
    uint32_t *neighbor; /* 3 a triangle: across the edge from this corner to the
                           next; NONE                                               */
    struct face *face;
    uint32_t *group;
    size_t group_count;
    bool *group_preserving;
    uint32_t *representative; /* a vertex of the input for each group: its normal   */
};

static uint32_t next3(uint32_t corner)
{
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

static uint32_t previous3(uint32_t corner)
{
    return corner % 3 == 0 ? corner + 2 : corner - 1;
}

static bool same_place(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool is_large(float x)
{
    return fabsf(x) > FLT_MIN && fabsf(x) < INFINITY;
}

static struct pbnds_vec3 unit_or_same(struct pbnds_vec3 v)
{
    const float length = pbnds_length(v);
    return is_large(length) ? pbnds_scale(v, 1.0f / length) : v;
}

/** The unit direction of v's part that is perpendicular to n. */
static struct pbnds_vec3 flatten(struct pbnds_vec3 v, struct pbnds_vec3 n)
{
    return unit_or_same(pbnds_mad(v, n, -pbnds_dot(n, v)));
}

/* ---- 1. welding ------------------------------------------------------------------ */

static bool same_vertex(const struct pbnds_tangent_input *in, uint32_t a, uint32_t b)
{
    return same_place(in->position[a], in->position[b]) &&
           same_place(in->normal[a], in->normal[b]) && in->uv[a].x == in->uv[b].x &&
           in->uv[a].y == in->uv[b].y;
}

static uint64_t mix(uint64_t hash, float value)
{
    const float x = value == 0.0f ? 0.0f : value; /* -0 is 0 */
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 29;
}

static uint64_t hash_of(const struct pbnds_tangent_input *in, uint32_t i)
{
    const struct pbnds_vec3 p = in->position[i], n = in->normal[i];
    uint64_t h = mix(mix(mix(0, p.x), p.y), p.z);
    h = mix(mix(mix(h, n.x), n.y), n.z);
    return mix(mix(h, in->uv[i].x), in->uv[i].y);
}

/** The first vertex that is the same, for each; open addressing. */
static bool weld(struct work *w)
{
    const struct pbnds_tangent_input *in = w->in;
    size_t size = 16;
    while (size < 2 * in->vertex_count)
        size *= 2;
    uint32_t *table = malloc(size * sizeof *table);
    uint32_t *first = malloc((in->vertex_count + 1) * sizeof *first);
    if (table && first) {
        memset(table, 0xff, size * sizeof *table);
        for (uint32_t i = 0; i < in->vertex_count; ++i) {
            size_t at = (size_t)hash_of(in, i) & (size - 1);
            while (table[at] != NONE && !same_vertex(in, table[at], i))
                at = (at + 1) & (size - 1);
            if (table[at] == NONE) table[at] = i;
            first[i] = table[at];
        }
        for (size_t c = 0; c < 3 * in->triangle_count; ++c)
            w->vertex[c] = first[in->index[c]];
    }
    const bool fine = table && first;
    free(table);
    free(first);
    return fine;
}

/* ---- 2. triangles ------------------------------------------------------------------ */

/* With d1, d2 the edges from corner 0 and (s, t) theirs in the picture, up to the factor
 * 1 / area:  dP/du = t2 d1 - t1 d2,  dP/dv = s1 d2 - s2 d1,  area = s1 t2 - s2 t1. */
static struct face measure(const struct pbnds_tangent_input *in, const uint32_t *v)
{
    const struct pbnds_vec3 *p = in->position;
    const struct pbnds_vec2 *uv = in->uv;
    const struct pbnds_vec3 d1 = pbnds_sub(p[v[1]], p[v[0]]);
    const struct pbnds_vec3 d2 = pbnds_sub(p[v[2]], p[v[0]]);
    const float s1 = uv[v[1]].x - uv[v[0]].x, t1 = uv[v[1]].y - uv[v[0]].y;
    const float s2 = uv[v[2]].x - uv[v[0]].x, t2 = uv[v[2]].y - uv[v[0]].y;
    const float area = s1 * t2 - s2 * t1;
    struct face f = {
        .degenerate = same_place(p[v[0]], p[v[1]]) || same_place(p[v[1]], p[v[2]]) ||
                      same_place(p[v[2]], p[v[0]]),
        .flexible = true,
        .preserving = area > 0.0f,
    };
    if (!is_large(area) || f.degenerate) return f;
    const float sign = area > 0.0f ? 1.0f : -1.0f;
    const struct pbnds_vec3 u = pbnds_sub(pbnds_scale(d1, t2), pbnds_scale(d2, t1));
    const struct pbnds_vec3 w = pbnds_sub(pbnds_scale(d2, s1), pbnds_scale(d1, s2));
    const float u_length = pbnds_length(u), v_length = pbnds_length(w);
    if (is_large(u_length)) f.u = pbnds_scale(u, sign / u_length);
    f.flexible = !is_large(u_length / fabsf(area)) || !is_large(v_length / fabsf(area));
    return f;
}

/* ---- 3. neighbours and groups ------------------------------------------------------ */

static uint32_t lower_end(const struct work *w, uint32_t corner)
{
    const uint32_t a = w->vertex[corner], b = w->vertex[next3(corner)];
    return a < b ? a : b;
}

static uint32_t upper_end(const struct work *w, uint32_t corner)
{
    const uint32_t a = w->vertex[corner], b = w->vertex[next3(corner)];
    return a > b ? a : b;
}

static int compare_edges(const void *x, const void *y)
{
    const struct edge *a = x, *b = y;
    if (a->hi != b->hi) return a->hi < b->hi ? -1 : 1;
    return a->corner < b->corner ? -1 : a->corner > b->corner;
}

/** Pairs the edges between two vertices: each with the first later one that runs the
 * other way and is free. Edges that wait all run the same way. */
static void pair_edges(struct work *w, const struct edge *edges, size_t count)
{
    size_t waiting =
        0; /* the first edge that waits; those that were taken are skipped */
    for (size_t i = 0; i < count; ++i) {
        const uint32_t b = edges[i].corner;
        while (waiting < i && w->neighbor[edges[waiting].corner] != NONE)
            ++waiting;
        if (waiting == i) continue;
        const uint32_t a = edges[waiting].corner;
        if (w->vertex[a] == w->vertex[b]) continue; /* the same way: waits too */
        w->neighbor[a] = b / 3;
        w->neighbor[b] = a / 3;
    }
}

/** Sorts the edges by their ends: into buckets by the lower one, then inside of each. */
static bool find_neighbors(struct work *w)
{
    const size_t corners = 3 * w->in->triangle_count, vertices = w->in->vertex_count;
    struct edge *edges = malloc((corners + 1) * sizeof *edges);
    size_t *start = calloc(vertices + 2, sizeof *start);
    if (!edges || !start) {
        free(edges);
        free(start);
        return false;
    }
    for (uint32_t c = 0; c < corners; ++c)
        if (!w->face[c / 3].degenerate) ++start[lower_end(w, c) + 2];
    for (size_t v = 2; v < vertices + 2; ++v)
        start[v] += start[v - 1];
    for (uint32_t c = 0; c < corners; ++c) {
        if (w->face[c / 3].degenerate) continue;
        edges[start[lower_end(w, c) + 1]++] = (struct edge){upper_end(w, c), c};
    }
    for (size_t v = 0; v < vertices; ++v) {
        const size_t end = start[v + 1];
        qsort(edges + start[v], end - start[v], sizeof *edges, compare_edges);
        for (size_t i = start[v]; i < end;) {
            size_t run = i + 1;
            while (run < end && edges[run].hi == edges[i].hi)
                ++run;
            pair_edges(w, edges + i, run - i);
            i = run;
        }
    }
    free(edges);
    free(start);
    return true;
}

static uint32_t corner_at(const struct work *w, uint32_t triangle, uint32_t vertex)
{
    const uint32_t c = 3 * triangle;
    if (w->vertex[c] == vertex) return c;
    return w->vertex[c + 1] == vertex ? c + 1 : c + 2;
}

/** Takes a triangle's corner into a group, unless it is in one or faces the other way. */
static bool join(struct work *w, uint32_t corner, uint32_t group)
{
    struct face *f = &w->face[corner / 3];
    if (w->group[corner] != NONE) return false;
    const uint32_t *own = w->group + corner / 3 * 3;
    if (f->flexible && own[0] == NONE && own[1] == NONE && own[2] == NONE)
        f->preserving = w->group_preserving[group];
    if (f->preserving != w->group_preserving[group]) return false;
    w->group[corner] = group;
    return true;
}

/** A new group at a corner: walks around its vertex to both sides as far as it gets. */
static void gather(struct work *w, uint32_t corner)
{
    const uint32_t group = (uint32_t)w->group_count++, vertex = w->vertex[corner];
    w->group_preserving[group] = w->face[corner / 3].preserving;
    w->representative[group] = vertex;
    w->group[corner] = group;
    for (int side = 0; side < 2; ++side) {
        uint32_t at = corner;
        for (;;) {
            const uint32_t over = w->neighbor[side ? previous3(at) : at];
            if (over == NONE) break;
            at = corner_at(w, over, vertex);
            if (!join(w, at, group)) break;
        }
    }
}

static void find_groups(struct work *w)
{
    for (uint32_t c = 0; c < 3 * w->in->triangle_count; ++c) {
        const struct face *f = &w->face[c / 3];
        if (f->degenerate || f->flexible || w->group[c] != NONE) continue;
        gather(w, c);
    }
}

/** Triangles without an area have what others have at the same vertex. */
static void lend(struct work *w, uint32_t *lender)
{
    const size_t corners = 3 * w->in->triangle_count;
    memset(lender, 0xff, w->in->vertex_count * sizeof *lender);
    for (size_t c = 0; c < corners; ++c) {
        if (lender[w->vertex[c]] == NONE) lender[w->vertex[c]] = w->group[c];
    }
    for (size_t c = 0; c < corners; ++c) {
        if (w->face[c / 3].degenerate) w->group[c] = lender[w->vertex[c]];
    }
}

/* ---- 4. tangents ------------------------------------------------------------------- */

/** The angle of a triangle at a corner, seen along the normal. */
static float corner_angle(const struct work *w, uint32_t corner, struct pbnds_vec3 n)
{
    const struct pbnds_vec3 *p = w->in->position;
    const struct pbnds_vec3 at = p[w->vertex[corner]];
    const struct pbnds_vec3 a =
        flatten(pbnds_sub(p[w->vertex[previous3(corner)]], at), n);
    const struct pbnds_vec3 b = flatten(pbnds_sub(p[w->vertex[next3(corner)]], at), n);
    return acosf(pbnds_clamp(pbnds_dot(a, b), -1.0f, 1.0f));
}

static void sum_up(const struct work *w, struct pbnds_vec4 *tangent)
{
    for (uint32_t c = 0; c < 3 * w->in->triangle_count; ++c) {
        const uint32_t group = w->group[c];
        const struct face *f = &w->face[c / 3];
        if (group == NONE || f->flexible) continue;
        const struct pbnds_vec3 n = w->in->normal[w->representative[group]];
        const struct pbnds_vec3 u = flatten(f->u, n);
        const float angle = corner_angle(w, c, n);
        struct pbnds_vec4 *t = &tangent[group];
        t->x += angle * u.x;
        t->y += angle * u.y;
        t->z += angle * u.z;
    }
    for (size_t i = 0; i < w->group_count; ++i) {
        struct pbnds_vec4 *t = &tangent[i];
        const struct pbnds_vec3 sum = {t->x, t->y, t->z};
        const float length = pbnds_length(sum);
        const struct pbnds_vec3 unit =
            is_large(length) ? pbnds_scale(sum, 1.0f / length) : pbnds_splat(0.0f);
        /* v of glTF runs down in the picture, green of a normal map upwards. */
        *t = (struct pbnds_vec4){unit.x, unit.y, unit.z,
                                 w->group_preserving[i] ? -1.0f : 1.0f};
    }
}

static bool run(struct work *w, struct pbnds_tangent_groups *out)
{
    const struct pbnds_tangent_input *in = w->in;
    if (!weld(w)) return false;
    for (size_t t = 0; t < in->triangle_count; ++t)
        w->face[t] = measure(in, w->vertex + 3 * t);
    if (!find_neighbors(w)) return false;
    find_groups(w);
    uint32_t *lender = malloc((in->vertex_count + 1) * sizeof *lender);
    out->tangent = calloc(w->group_count + 1, sizeof *out->tangent);
    if (!lender || !out->tangent) {
        free(lender);
        return false;
    }
    sum_up(w, out->tangent);
    lend(w, lender);
    free(lender);
    out->group_count = w->group_count;
    return true;
}

bool pbnds_tangent_space(const struct pbnds_tangent_input *in,
                         struct pbnds_tangent_groups *out)
{
    const size_t corners = 3 * in->triangle_count;
    struct work w = {
        .in = in,
        .vertex = malloc((corners + 1) * sizeof *w.vertex),
        .neighbor = malloc((corners + 1) * sizeof *w.neighbor),
        .face = malloc((in->triangle_count + 1) * sizeof *w.face),
        .group = malloc((corners + 1) * sizeof *w.group),
        .group_preserving = malloc((corners + 1) * sizeof *w.group_preserving),
        .representative = malloc((corners + 1) * sizeof *w.representative),
    };
    *out = (struct pbnds_tangent_groups){.group = w.group};
    bool fine = w.vertex && w.neighbor && w.face && w.group && w.group_preserving &&
                w.representative;
    if (fine) {
        memset(w.neighbor, 0xff, corners * sizeof *w.neighbor);
        memset(w.group, 0xff, corners * sizeof *w.group);
        fine = run(&w, out);
    }
    free(w.vertex);
    free(w.neighbor);
    free(w.face);
    free(w.group_preserving);
    free(w.representative);
    if (!fine) pbnds_tangent_groups_free(out);
    return fine;
}

void pbnds_tangent_groups_free(struct pbnds_tangent_groups *groups)
{
    free(groups->group);
    free(groups->tangent);
    *groups = (struct pbnds_tangent_groups){0};
}
