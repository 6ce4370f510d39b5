/* Metallic-roughness; equations, frame and units are in bsdf.h. */
#include "engine/shade/bsdf.h"

#include <assert.h>
#include <math.h>

static const struct pbnds_vec3 BLACK = {0.0f, 0.0f, 0.0f};

/* fmaxf turns a NaN of a damaged file into the lower bound as well. */
static float unit(float x)
{
    return pbnds_clamp(x, 0.0f, 1.0f);
}

struct pbnds_bsdf pbnds_bsdf_make(struct pbnds_vec3 n, struct pbnds_vec3 base_color,
                                  float metallic, float roughness, struct pbnds_vec3 f0,
                                  float f90)
{
    const struct pbnds_vec3 base =
        pbnds_vec3_make(unit(base_color.x), unit(base_color.y), unit(base_color.z));
    const float m = unit(metallic);
    const struct pbnds_vec3 dielectric =
        pbnds_vec3_make(unit(f0.x), unit(f0.y), unit(f0.z));
    struct pbnds_bsdf bsdf;
    bsdf.frame = pbnds_frame_from_normal(n);
    bsdf.c_diff = pbnds_scale(base, 1.0f - m);
    bsdf.f0 = pbnds_max3(dielectric);
    bsdf.f90 = unit(f90);
    bsdf.ggx = pbnds_ggx_from_gltf(pbnds_lerp(dielectric, base, m),
                                   bsdf.f90 + m * (1.0f - bsdf.f90), unit(roughness));
    bsdf.row = pbnds_ggx_albedo_row(bsdf.ggx.alpha);
    const struct pbnds_ggx_albedo mean = pbnds_ggx_albedo_mean(bsdf.row);
    const float left = 1.0f - (bsdf.f0 * mean.a + bsdf.f90 * mean.b);
    bsdf.diffuse_scale = 1.0f / (PBNDS_PI * fmaxf(left, 1e-4f));
    return bsdf;
}

struct pbnds_bsdf pbnds_bsdf_from_surface(const struct pbnds_surface *s)
{
    return pbnds_bsdf_make(s->n, s->base_color, s->metallic, s->roughness, s->f0,
                           s->f90);
}

struct pbnds_bsdf pbnds_bsdf_from_gbuffer(const struct pbnds_gbuffer *gbuffer, size_t i)
{
    const struct pbnds_vec3 n = {gbuffer->normal[0][i], gbuffer->normal[1][i],
                                 gbuffer->normal[2][i]};
    const struct pbnds_vec3 base = {gbuffer->albedo[0][i], gbuffer->albedo[1][i],
                                    gbuffer->albedo[2][i]};
    const float metallic = gbuffer->metallic[i];
    /* specular = luminance(f0) = (1 - metallic) f0_d + metallic luminance(base), solved
     * for f0_d; a pure metal has no dielectric part to recover. */
    const float m = unit(metallic), dielectric = 1.0f - m;
    struct pbnds_vec3 f0 = {0.0f, 0.0f, 0.0f};
    float f90 = 1.0f;
    if (dielectric > 0.0f && gbuffer->f90) {
        const struct pbnds_vec3 both = {gbuffer->f0[0][i], gbuffer->f0[1][i],
                                        gbuffer->f0[2][i]};
        f0 = pbnds_scale(pbnds_mad(both, base, -m), 1.0f / dielectric);
        f90 = (gbuffer->f90[i] - m) / dielectric;
    } else if (dielectric > 0.0f) {
        const float share = gbuffer->specular[i] - m * pbnds_luminance(base);
        f0 = pbnds_splat(share / dielectric);
    }
    return pbnds_bsdf_make(n, base, metallic, gbuffer->roughness[i], f0, f90);
}

static bool has_diffuse(const struct pbnds_bsdf *bsdf)
{
    return pbnds_max3(bsdf->c_diff) > 0.0f;
}

/* 1 - E: what the dielectric's lobe leaves of light at this angle. */
static float left_over(const struct pbnds_bsdf *bsdf, float cosine)
{
    const struct pbnds_ggx_albedo e = pbnds_ggx_albedo(bsdf->row, cosine);
    return fmaxf(1.0f - (bsdf->f0 * e.a + bsdf->f90 * e.b), 0.0f);
}

static struct pbnds_vec3 diffuse_local(const struct pbnds_bsdf *bsdf,
                                       struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    if (wo.z <= 0.0f || wi.z <= 0.0f || !has_diffuse(bsdf)) return BLACK;
    const float coupling = left_over(bsdf, wo.z) * left_over(bsdf, wi.z);
    return pbnds_scale(bsdf->c_diff, coupling * bsdf->diffuse_scale);
}

static struct pbnds_vec3 eval_local(const struct pbnds_bsdf *bsdf, struct pbnds_vec3 wo,
                                    struct pbnds_vec3 wi)
{
    return pbnds_add(diffuse_local(bsdf, wo, wi), pbnds_ggx_eval(&bsdf->ggx, wo, wi));
}

/* Share of the samples that go to the specular lobe: the luminance of what each part
 * reflects of light from wo. Neither is starved, because wo is not all that counts. */
static float specular_share(const struct pbnds_bsdf *bsdf, float cos_o)
{
    if (!has_diffuse(bsdf)) return 1.0f;
    const struct pbnds_ggx_albedo e = pbnds_ggx_albedo(bsdf->row, cos_o);
    const float specular = pbnds_luminance(bsdf->ggx.f0) * e.a + bsdf->ggx.f90 * e.b;
    if (specular <= 0.0f) return 0.0f;
    const float diffuse =
        pbnds_luminance(bsdf->c_diff) * (1.0f - (bsdf->f0 * e.a + bsdf->f90 * e.b));
    return pbnds_clamp(specular / (specular + diffuse), 0.1f, 0.9f);
}

static float pdf_local(const struct pbnds_bsdf *bsdf, float share, struct pbnds_vec3 wo,
                       struct pbnds_vec3 wi)
{
    if (wo.z <= 0.0f || wi.z <= 0.0f) return 0.0f;
    return share * pbnds_ggx_pdf(&bsdf->ggx, wo, wi) +
           (1.0f - share) * (wi.z / PBNDS_PI);
}

struct pbnds_vec3 pbnds_bsdf_eval(const struct pbnds_bsdf *bsdf, struct pbnds_vec3 wo,
                                  struct pbnds_vec3 wi)
{
    return eval_local(bsdf, pbnds_to_local(&bsdf->frame, wo),
                      pbnds_to_local(&bsdf->frame, wi));
}

struct pbnds_vec3 pbnds_bsdf_diffuse(const struct pbnds_bsdf *bsdf,
                                     struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    return diffuse_local(bsdf, pbnds_to_local(&bsdf->frame, wo),
                         pbnds_to_local(&bsdf->frame, wi));
}

float pbnds_bsdf_pdf(const struct pbnds_bsdf *bsdf, struct pbnds_vec3 wo,
                     struct pbnds_vec3 wi)
{
    const struct pbnds_vec3 lo = pbnds_to_local(&bsdf->frame, wo);
    return pdf_local(bsdf, specular_share(bsdf, lo.z), lo,
                     pbnds_to_local(&bsdf->frame, wi));
}

/* Malley's method: the disc lifted to the hemisphere, density cos / pi. */
static struct pbnds_vec3 sample_cosine(float u1, float u2)
{
    const float r = sqrtf(u1), phi = 2.0f * PBNDS_PI * u2;
    return pbnds_vec3_make(r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(1.0f - u1, 0.0f)));
}

bool pbnds_bsdf_sample(const struct pbnds_bsdf *bsdf, struct pbnds_vec3 wo,
                       float u_lobe, float u1, float u2, struct pbnds_brdf_sample *out)
{
    const struct pbnds_vec3 lo = pbnds_to_local(&bsdf->frame, wo);
    if (lo.z <= 0.0f) return false;
    const float share = specular_share(bsdf, lo.z);
    struct pbnds_vec3 wi;
    if (u_lobe < share) {
        struct pbnds_brdf_sample specular;
        if (!pbnds_ggx_sample(&bsdf->ggx, lo, u1, u2, &specular)) return false;
        wi = specular.wi;
    } else {
        wi = sample_cosine(u1, u2);
    }
    out->pdf = pdf_local(bsdf, share, lo, wi);
    if (!(out->pdf > 0.0f)) return false;
    out->f = eval_local(bsdf, lo, wi);
    out->wi = pbnds_to_world(&bsdf->frame, wi);
    assert(isfinite(out->pdf) && out->f.x >= 0.0f && out->f.y >= 0.0f &&
           out->f.z >= 0.0f);
    return true;
}
