#include "scenes/generator/deform.h"

#include "scenes/generator/noise.h"

static float relief_height(enum gen_relief relief, struct pbnds_vec3 p, int octaves,
                           uint32_t seed)
{
    const float n = gen_fbm(p, octaves, 0, seed);
    if (relief == GEN_RIDGED) return 1.0f - 2.5f * fabsf(n);
    if (relief == GEN_CRATERED) return -fmaxf(0.0f, 1.0f - 3.0f * fabsf(n - 0.2f));
    return 1.4f * n;
}

void gen_displace(struct gen_mesh *m, enum gen_relief relief, float frequency,
                  float height, int octaves, uint32_t seed)
{
    gen_mesh_shade(m, 180.0f); /* the same normal for all vertices at one place */
    if (m->failed) return;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const struct pbnds_vec3 p = m->position[i];
        const float h =
            height * relief_height(relief, pbnds_scale(p, frequency), octaves, seed);
        m->position[i] = pbnds_mad(p, m->normal[i], h);
    }
}

void gen_twist(struct gen_mesh *m, float turn)
{
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const struct pbnds_vec3 p = m->position[i];
        const float c = cosf(turn * p.y), s = sinf(turn * p.y);
        m->position[i] = pbnds_vec3_make(c * p.x + s * p.z, p.y, c * p.z - s * p.x);
    }
}

void gen_taper(struct gen_mesh *m, float rate)
{
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const float s = fmaxf(0.05f, 1.0f + rate * m->position[i].y);
        m->position[i].x *= s;
        m->position[i].z *= s;
    }
}

void gen_bend(struct gen_mesh *m, float curvature)
{
    if (fabsf(curvature) < 1e-3f) return;
    const float radius = 1.0f / curvature;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const struct pbnds_vec3 p = m->position[i];
        const float a = p.y * curvature, r = radius - p.x;
        m->position[i] = pbnds_vec3_make(radius - r * cosf(a), r * sinf(a), p.z);
    }
}
