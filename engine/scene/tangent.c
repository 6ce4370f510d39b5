#include "engine/scene/tangent.h"

#include <stdlib.h>

/** What a vertex gathers from its triangles. */
struct sums {
    struct pbnds_vec3 u, v, n; /* directions of growing u and v; face normals */
};

static float corner_angle(struct pbnds_vec3 a, struct pbnds_vec3 b, struct pbnds_vec3 c)
{
    const struct pbnds_vec3 e = pbnds_sub(b, a), f = pbnds_sub(c, a);
    const float x = pbnds_dot(e, f), y = pbnds_length(pbnds_cross(e, f));
    return x == 0.0f && y == 0.0f ? 0.0f : atan2f(y, x);
}

static struct pbnds_vec3 unit_or_zero(struct pbnds_vec3 a)
{
    const float length = pbnds_length(a);
    return length > 0.0f && length < INFINITY ? pbnds_scale(a, 1.0f / length)
                                              : pbnds_splat(0.0f);
}

/** dP/du and dP/dv of one triangle (Lengyel 2001, "Computing Tangent Space Basis
 * Vectors for an Arbitrary Mesh"), as unit vectors so that large triangles weigh no
 * more. */
static void add_triangle(const struct pbnds_mesh *mesh, int set, const uint32_t *index,
                         struct sums *sums)
{
    struct pbnds_vec3 p[3];
    struct pbnds_vec2 t[3];
    for (int k = 0; k < 3; ++k) {
        p[k] = mesh->position[index[k]];
        t[k] = mesh->uv[set][index[k]];
    }
    const struct pbnds_vec3 e = pbnds_sub(p[1], p[0]), f = pbnds_sub(p[2], p[0]);
    const float eu = t[1].x - t[0].x, ev = t[1].y - t[0].y;
    const float fu = t[2].x - t[0].x, fv = t[2].y - t[0].y;
    const float sign = eu * fv - fu * ev < 0.0f ? -1.0f : 1.0f;
    const float used = eu * fv - fu * ev != 0.0f ? sign : 0.0f;
    struct sums face = {
        unit_or_zero(pbnds_sub(pbnds_scale(e, fv * used), pbnds_scale(f, ev * used))),
        unit_or_zero(pbnds_sub(pbnds_scale(f, eu * used), pbnds_scale(e, fu * used))),
        unit_or_zero(pbnds_cross(e, f)),
    };
    for (int k = 0; k < 3; ++k) {
        struct sums *s = &sums[index[k]];
        const float angle = corner_angle(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
        s->u = pbnds_mad(s->u, face.u, angle);
        s->v = pbnds_mad(s->v, face.v, angle);
        s->n = pbnds_mad(s->n, face.n, angle);
    }
}

static struct pbnds_vec4 finish(const struct sums *s, const struct pbnds_vec3 *normal)
{
    struct pbnds_vec3 n = normal ? *normal : unit_or_zero(s->n);
    if (pbnds_dot(n, n) == 0.0f) n = pbnds_vec3_make(0, 0, 1);
    struct pbnds_vec3 t = unit_or_zero(pbnds_mad(s->u, n, -pbnds_dot(n, s->u)));
    if (pbnds_dot(t, t) == 0.0f) t = pbnds_frame_from_normal(n).t;
    /* v grows downwards in the picture, green of a normal map upwards. */
    const float w = pbnds_dot(pbnds_cross(n, t), s->v) > 0.0f ? -1.0f : 1.0f;
    return (struct pbnds_vec4){t.x, t.y, t.z, w};
}

enum pbnds_status pbnds_mesh_tangents(struct pbnds_mesh *mesh, int set,
                                      const char *name, struct pbnds_error *error)
{
    struct sums *sums = calloc(mesh->vertex_count + 1, sizeof *sums);
    mesh->tangent = calloc(mesh->vertex_count + 1, sizeof *mesh->tangent);
    if (!sums || !mesh->tangent) {
        free(sums);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for tangents",
                          name);
    }
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        add_triangle(mesh, set, mesh->index + 3 * i, sums);
    }
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        mesh->tangent[i] = finish(&sums[i], mesh->normal ? &mesh->normal[i] : NULL);
    }
    free(sums);
    return PBNDS_OK;
}
