/* Directional albedo of GGX by table; see ggx_albedo.h. */
#include "engine/shade/ggx_albedo.h"

#include <math.h>

#include "engine/shade/ggx_albedo_table.h"

/* PBNDS_GGX_ALPHA_MIN^(1/4), where the rows begin. */
#define FIRST 0.177827941f

static float fourth_root(float x)
{
    return sqrtf(sqrtf(x));
}

struct pbnds_ggx_albedo_row pbnds_ggx_albedo_row(float alpha)
{
    const float last = (float)(PBNDS_GGX_ALBEDO_ROWS - 1);
    const float x = (fourth_root(fmaxf(alpha, 0.0f)) - FIRST) * (last / (1.0f - FIRST));
    const float clamped = pbnds_clamp(x, 0.0f, last);
    struct pbnds_ggx_albedo_row row;
    row.row = clamped < last ? (int)clamped : PBNDS_GGX_ALBEDO_ROWS - 2;
    row.part = clamped - (float)row.row;
    return row;
}

static struct pbnds_ggx_albedo mix(struct pbnds_ggx_albedo p, struct pbnds_ggx_albedo q,
                                   float t)
{
    return (struct pbnds_ggx_albedo){p.a + (q.a - p.a) * t, p.b + (q.b - p.b) * t};
}

struct pbnds_ggx_albedo pbnds_ggx_albedo(struct pbnds_ggx_albedo_row row, float cosine)
{
    const float last = (float)(PBNDS_GGX_ALBEDO_COLUMNS - 1);
    const float x = fourth_root(pbnds_clamp(cosine, 0.0f, 1.0f)) * last;
    const int j = x < last ? (int)x : PBNDS_GGX_ALBEDO_COLUMNS - 2;
    const struct pbnds_ggx_albedo *near = &TABLE[row.row][j];
    const struct pbnds_ggx_albedo *next = &TABLE[row.row + 1][j];
    return mix(mix(near[0], next[0], row.part), mix(near[1], next[1], row.part),
               x - (float)j);
}

struct pbnds_ggx_albedo pbnds_ggx_albedo_mean(struct pbnds_ggx_albedo_row row)
{
    return mix(MEAN[row.row], MEAN[row.row + 1], row.part);
}
