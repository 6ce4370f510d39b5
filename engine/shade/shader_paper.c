/* "paper-blinn-phong" and "paper-ggx": formulas and their errors are in shader_paper.h.
 */
#include "engine/shade/shader_paper.h"

#include <math.h>
#include <stdlib.h>

#include "engine/core/rng.h"
#include "engine/shade/brdf_ggx.h"
#include "engine/shade/shader_table.h"
#include "engine/shade/tiles.h"

typedef struct pbnds_vec3 brdf(const struct pbnds_paper_material *m,
                               struct pbnds_vec3 v, struct pbnds_vec3 l);

struct light {
    struct pbnds_vec3 l, radiance;
};

struct pass {
    const struct pbnds_shade_job *job;
    struct pbnds_image *radiance;
    brdf *b;
    struct light *lights;
    int count;
};

static float positive_dot(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return fmaxf(pbnds_dot(a, b), 0.0f);
}

/* l + v vanishes where they oppose each other; zero then, as a guarded normalisation
 * has it. */
static struct pbnds_vec3 half_vector(struct pbnds_vec3 l, struct pbnds_vec3 v)
{
    const struct pbnds_vec3 sum = pbnds_add(l, v);
    return pbnds_scale(sum, 1.0f / fmaxf(pbnds_length(sum), 1e-12f));
}

struct pbnds_vec3 pbnds_paper_direction(uint64_t seed, int i)
{
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, (uint64_t)i);
    const float z = 1.0f - 2.0f * pbnds_rng_float(&rng);
    const float phi = 2.0f * PBNDS_PI * pbnds_rng_float(&rng);
    const float r = sqrtf(fmaxf(1.0f - z * z, 0.0f));
    return pbnds_vec3_make(r * cosf(phi), r * sinf(phi), z);
}

struct pbnds_vec3 pbnds_paper_blinn_phong(const struct pbnds_paper_material *m,
                                          struct pbnds_vec3 v, struct pbnds_vec3 l)
{
    const float n_h = positive_dot(m->n, half_vector(l, v));
    const float n_h2 = n_h * n_h, n_h4 = n_h2 * n_h2, n_h8 = n_h4 * n_h4;
    return pbnds_add(pbnds_scale(m->albedo, positive_dot(m->n, l)),
                     pbnds_splat(m->specular * (n_h8 * n_h8)));
}

static float visibility(float k, float cosine)
{
    return 0.5f / fmaxf(cosine * (1.0f - k) + k, 1e-2f);
}

struct pbnds_vec3 pbnds_paper_ggx(const struct pbnds_paper_material *m,
                                  struct pbnds_vec3 v, struct pbnds_vec3 l)
{
    const float r = m->roughness, s = m->specular;
    const struct pbnds_vec3 h = half_vector(l, v);
    const struct pbnds_vec3 f0 =
        pbnds_add(pbnds_splat(0.04f * (1.0f - s)), pbnds_scale(m->albedo, s));
    const struct pbnds_vec3 f = pbnds_schlick(f0, 1.0f, positive_dot(h, v));
    const float k = (1.0f + r) * (1.0f + r) / 8.0f;
    const float vis =
        visibility(k, positive_dot(m->n, l)) * visibility(k, positive_dot(m->n, v));
    const float a = fmaxf(r * r, 1e-2f);
    const float lobe = expf(2.0f / a * (positive_dot(m->n, h) - 1.0f)) / (PBNDS_PI * a);
    return pbnds_mad(pbnds_scale(m->albedo, (1.0f - s) / PBNDS_PI), f,
                     fminf(lobe, 1.0f) * vis);
}

static struct pbnds_vec3 shade_pixel(const struct pass *pass, int x, int y, size_t i)
{
    const struct pbnds_gbuffer *g = pass->job->gbuffer;
    const struct pbnds_paper_material m = {
        .albedo = {g->albedo[0][i], g->albedo[1][i], g->albedo[2][i]},
        .n = {g->normal[0][i], g->normal[1][i], g->normal[2][i]},
        .roughness = g->roughness[i],
        .specular = g->specular[i]};
    const struct pbnds_vec3 v = pbnds_gbuffer_wo(g, x, y);
    struct pbnds_vec3 sum = {0.0f, 0.0f, 0.0f};
    for (int j = 0; j < pass->count; ++j) {
        const struct light *light = &pass->lights[j];
        const float cos_i = pbnds_dot(m.n, light->l);
        if (cos_i <= 0.0f) continue;
        sum =
            pbnds_mad(sum, pbnds_mul(pass->b(&m, v, light->l), light->radiance), cos_i);
    }
    return pbnds_scale(sum, 2.0f * PBNDS_PI / (float)pass->count);
}

static void shade_tile(void *context, const struct pbnds_tile *tile)
{
    const struct pass *pass = context;
    const struct pbnds_gbuffer *g = pass->job->gbuffer;
    for (int y = tile->y0; y < tile->y1 && !pbnds_stop_requested(); ++y)
        for (int x = tile->x0; x < tile->x1; ++x) {
            const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
            if (!(g->coverage[i] > 0.0f)) continue;
            const struct pbnds_vec3 sum = shade_pixel(pass, x, y, i);
            float *out = pbnds_image_at(pass->radiance, x, y);
            out[0] = pbnds_clamp(sum.x + g->emission[0][i], 0.0f, 1.0f);
            out[1] = pbnds_clamp(sum.y + g->emission[1][i], 0.0f, 1.0f);
            out[2] = pbnds_clamp(sum.z + g->emission[2][i], 0.0f, 1.0f);
        }
}

static enum pbnds_status shade_with(brdf *b, const char *name,
                                    const struct pbnds_shade_job *job,
                                    struct pbnds_image *radiance,
                                    struct pbnds_error *error)
{
    struct pass pass = {.job = job, .radiance = radiance, .b = b};
    pass.count = job->lights > 0 ? job->lights : 128;
    pass.lights = calloc((size_t)pass.count, sizeof *pass.lights);
    if (!pass.lights)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: no memory for %d light directions; ask for fewer", name,
                          pass.count);
    for (int i = 0; i < pass.count; ++i) {
        pass.lights[i].l = pbnds_paper_direction(job->seed, i);
        if (job->envmap)
            pass.lights[i].radiance = pbnds_envmap_eval(job->envmap, pass.lights[i].l);
    }
    const enum pbnds_status status =
        pbnds_for_tiles(job->gbuffer->width, job->gbuffer->height, 16, job->report,
                        name, shade_tile, &pass, error);
    free(pass.lights);
    return status;
}

static enum pbnds_status shade_blinn_phong(const struct pbnds_shader *self,
                                           const struct pbnds_shade_job *job,
                                           struct pbnds_image *radiance,
                                           struct pbnds_error *error)
{
    return shade_with(pbnds_paper_blinn_phong, self->ops->name, job, radiance, error);
}

static enum pbnds_status shade_ggx(const struct pbnds_shader *self,
                                   const struct pbnds_shade_job *job,
                                   struct pbnds_image *radiance,
                                   struct pbnds_error *error)
{
    return shade_with(pbnds_paper_ggx, self->ops->name, job, radiance, error);
}

static const struct pbnds_shader_ops ops_blinn_phong = {
    .name = "paper-blinn-phong",
    .channels = PBNDS_CHANNELS_LIT,
    .about = "Blinn-Phong as the paper's baseline has it, errors included",
    .shade = shade_blinn_phong,
};
const struct pbnds_shader pbnds_shader_paper_blinn_phong = {.ops = &ops_blinn_phong};

static const struct pbnds_shader_ops ops_ggx = {
    .name = "paper-ggx",
    .channels = PBNDS_CHANNELS_LIT,
    .about = "GGX as the paper's baseline has it, errors included",
    .shade = shade_ggx,
};
const struct pbnds_shader pbnds_shader_paper_ggx = {.ops = &ops_ggx};
