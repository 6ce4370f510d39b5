/* Dual meshing ("surface nets", Gibson 1998): one vertex in each cell that the surface
 * crosses, one quad for each grid edge that it crosses; then a few Newton steps put the
 * vertices on the surface. */
#include <stdlib.h>

#include "scenes/generator/sdf.h"

struct lattice {
    const struct gen_sdf_field *field;
    struct pbnds_vec3 lo;
    float cell;
    int n[3];         /* corners on each axis */
    float *distance;  /* at the corners       */
    uint32_t *vertex; /* of each cell         */
};

static size_t corner_index(const struct lattice *g, int x, int y, int z)
{
    return ((size_t)z * (size_t)g->n[1] + (size_t)y) * (size_t)g->n[0] + (size_t)x;
}

static struct pbnds_vec3 corner_point(const struct lattice *g, int x, int y, int z)
{
    return pbnds_mad(g->lo, pbnds_vec3_make((float)x, (float)y, (float)z), g->cell);
}

enum { BLOCK = 4 };

/* Distances where the surface may pass; elsewhere the sign alone, from the block's
 * centre: the functions change by at most a metre and a half per metre. */
static void sample_block(const struct lattice *g, int bx, int by, int bz)
{
    const int x1 = bx + BLOCK < g->n[0] ? bx + BLOCK : g->n[0];
    const int y1 = by + BLOCK < g->n[1] ? by + BLOCK : g->n[1];
    const int z1 = bz + BLOCK < g->n[2] ? bz + BLOCK : g->n[2];
    const float half = 0.5f * (BLOCK - 1) * g->cell;
    const struct pbnds_vec3 centre =
        pbnds_add(corner_point(g, bx, by, bz), pbnds_splat(half));
    const float middle = gen_sdf_eval(g->field, centre);
    const float reach =
        1.5f * 1.7320508f * (half + g->cell) + 4.0f * fabsf(g->field->sdf->relief);
    const int far = fabsf(middle) > reach;
    for (int z = bz; z < z1; ++z) {
        for (int y = by; y < y1; ++y) {
            for (int x = bx; x < x1; ++x) {
                g->distance[corner_index(g, x, y, z)] =
                    far ? middle : gen_sdf_eval(g->field, corner_point(g, x, y, z));
            }
        }
    }
}

static struct pbnds_vec3 gradient(const struct gen_sdf_field *s, struct pbnds_vec3 p,
                                  float h)
{
    const struct pbnds_vec3 x = {h, 0.0f, 0.0f}, y = {0.0f, h, 0.0f},
                            z = {0.0f, 0.0f, h};
    const struct pbnds_vec3 g = {
        gen_sdf_eval(s, pbnds_add(p, x)) - gen_sdf_eval(s, pbnds_sub(p, x)),
        gen_sdf_eval(s, pbnds_add(p, y)) - gen_sdf_eval(s, pbnds_sub(p, y)),
        gen_sdf_eval(s, pbnds_add(p, z)) - gen_sdf_eval(s, pbnds_sub(p, z))};
    return pbnds_scale(g, 0.5f / h);
}

/* Mean of the crossings on the cell's twelve edges; false when it is all in or out. */
static bool cell_vertex(const struct lattice *g, int x, int y, int z,
                        struct pbnds_vec3 *p)
{
    float d[8];
    int inside = 0;
    for (int i = 0; i < 8; ++i) {
        d[i] =
            g->distance[corner_index(g, x + (i & 1), y + (i >> 1 & 1), z + (i >> 2))];
        inside += d[i] < 0.0f;
    }
    if (inside == 0 || inside == 8) return false;
    struct pbnds_vec3 sum = pbnds_splat(0.0f);
    int count = 0;
    for (int i = 0; i < 8; ++i) {
        for (int bit = 1; bit < 8; bit <<= 1) {
            const int j = i | bit;
            if (j == i || (d[i] < 0.0f) == (d[j] < 0.0f)) continue;
            const float t = d[i] / (d[i] - d[j]);
            sum = pbnds_add(sum,
                            pbnds_vec3_make((float)(i & 1) + (bit == 1 ? t : 0.0f),
                                            (float)(i >> 1 & 1) + (bit == 2 ? t : 0.0f),
                                            (float)(i >> 2) + (bit == 4 ? t : 0.0f)));
            ++count;
        }
    }
    *p = pbnds_mad(corner_point(g, x, y, z), sum, g->cell / (float)count);
    return true;
}

/* Two Newton steps along the gradient, none longer than a quarter of a cell. */
static struct pbnds_vec3 settle(const struct lattice *g, struct pbnds_vec3 p,
                                struct pbnds_vec3 *normal)
{
    const float h = 0.1f * g->cell;
    struct pbnds_vec3 n = gradient(g->field, p, h);
    for (int i = 0; i < 2; ++i) {
        const float slope = pbnds_dot(n, n);
        if (slope < 1e-8f) break;
        const float length = sqrtf(slope);
        const float step = pbnds_clamp(gen_sdf_eval(g->field, p) / length,
                                       -0.25f * g->cell, 0.25f * g->cell);
        p = pbnds_mad(p, n, -step / length);
        n = gradient(g->field, p, h);
    }
    const float length = pbnds_length(n);
    *normal = length > 1e-8f ? pbnds_scale(n, 1.0f / length) : pbnds_splat(0.57735f);
    return p;
}

static size_t cell_index(const struct lattice *g, int x, int y, int z)
{
    return ((size_t)z * (size_t)(g->n[1] - 1) + (size_t)y) * (size_t)(g->n[0] - 1) +
           (size_t)x;
}

static void make_vertices(const struct lattice *g, struct gen_mesh *m)
{
    for (int z = 0; z + 1 < g->n[2]; ++z) {
        for (int y = 0; y + 1 < g->n[1]; ++y) {
            for (int x = 0; x + 1 < g->n[0]; ++x) {
                struct pbnds_vec3 p, normal;
                if (!cell_vertex(g, x, y, z, &p)) continue;
                p = settle(g, p, &normal);
                const struct pbnds_vec2 none = {0.0f, 0.0f};
                const uint32_t v = gen_mesh_vertex(m, p, none);
                if (m->failed) return;
                m->normal[v] = normal;
                g->vertex[cell_index(g, x, y, z)] = v;
            }
        }
    }
}

/* Quad around a grid edge, split along its shorter diagonal. */
static void add_quad(struct gen_mesh *m, const uint32_t v[4])
{
    const struct pbnds_vec3 *p = m->position;
    const struct pbnds_vec3 a = pbnds_sub(p[v[0]], p[v[2]]),
                            b = pbnds_sub(p[v[1]], p[v[3]]);
    if (pbnds_dot(a, a) <= pbnds_dot(b, b)) {
        gen_mesh_quad(m, v[0], v[1], v[2], v[3]);
    } else {
        gen_mesh_quad(m, v[1], v[2], v[3], v[0]);
    }
}

static void make_quads(const struct lattice *g, struct gen_mesh *m)
{
    for (int z = 1; z + 1 < g->n[2]; ++z) {
        for (int y = 1; y + 1 < g->n[1]; ++y) {
            for (int x = 1; x + 1 < g->n[0]; ++x) {
                const int at[3] = {x, y, z};
                const bool in = g->distance[corner_index(g, x, y, z)] < 0.0f;
                for (int axis = 0; axis < 3; ++axis) {
                    int to[3] = {x, y, z};
                    ++to[axis];
                    const bool there =
                        g->distance[corner_index(g, to[0], to[1], to[2])] < 0.0f;
                    if (in == there) continue;
                    /* the four cells around the edge, counter-clockwise seen from +axis
                     */
                    const int r = (axis + 1) % 3, s = (axis + 2) % 3;
                    static const int step[4][2] = {{-1, -1}, {0, -1}, {0, 0}, {-1, 0}};
                    uint32_t v[4];
                    for (int k = 0; k < 4; ++k) {
                        int c[3] = {at[0], at[1], at[2]};
                        c[r] += step[k][0];
                        c[s] += step[k][1];
                        v[in ? k : 3 - k] = g->vertex[cell_index(g, c[0], c[1], c[2])];
                    }
                    add_quad(m, v);
                }
            }
        }
    }
}

void gen_sdf_mesh(const struct gen_sdf *s, struct pbnds_vec3 lo, struct pbnds_vec3 hi,
                  int cells, struct gen_mesh *m)
{
    const struct pbnds_vec3 extent = pbnds_sub(hi, lo);
    struct gen_sdf_field field;
    gen_sdf_prepare(&field, s);
    struct lattice g = {.field = &field, .cell = pbnds_max3(extent) / (float)cells};
    /* One cell more on each side: the surface must not leave the lattice. */
    g.lo = pbnds_sub(lo, pbnds_splat(1.5f * g.cell));
    g.n[0] = (int)ceilf(extent.x / g.cell) + 4;
    g.n[1] = (int)ceilf(extent.y / g.cell) + 4;
    g.n[2] = (int)ceilf(extent.z / g.cell) + 4;
    const size_t total = (size_t)g.n[0] * (size_t)g.n[1] * (size_t)g.n[2];
    struct gen_mesh made = {.vertex_count = 0};
    g.distance = malloc(total * sizeof *g.distance);
    g.vertex = malloc(total * sizeof *g.vertex);
    if (!g.distance || !g.vertex) {
        m->failed = true;
    } else {
        for (int z = 0; z < g.n[2]; z += BLOCK) {
            for (int y = 0; y < g.n[1]; y += BLOCK) {
                for (int x = 0; x < g.n[0]; x += BLOCK)
                    sample_block(&g, x, y, z);
            }
        }
        for (size_t i = 0; i < total;
             ++i) { /* what reaches the border is cut off there */
            const int x = (int)(i % (size_t)g.n[0]);
            const int y = (int)(i / (size_t)g.n[0] % (size_t)g.n[1]);
            const int z = (int)(i / (size_t)g.n[0] / (size_t)g.n[1]);
            if (x == 0 || y == 0 || z == 0 || x + 1 == g.n[0] || y + 1 == g.n[1] ||
                z + 1 == g.n[2]) {
                g.distance[i] = fmaxf(g.distance[i], 0.01f * g.cell);
            }
        }
        make_vertices(&g, &made);
        make_quads(&g, &made);
        gen_mesh_box_uv(&made, 1.0f);
        const struct pbnds_mat4 rest = pbnds_mat4_identity();
        gen_mesh_append(m, &made, &rest);
    }
    gen_mesh_free(&made);
    free(g.distance);
    free(g.vertex);
}
