/* "blinn-phong": the normalised empirical model under the light map, direct light only.
 */
#include "engine/shade/direct.h"
#include "engine/shade/shader_table.h"

static void load(union pbnds_direct_lobe *lobe, const struct pbnds_gbuffer *gbuffer,
                 size_t i)
{
    const struct pbnds_bsdf bsdf = pbnds_bsdf_from_gbuffer(gbuffer, i);
    lobe->blinn_phong = pbnds_blinn_phong_make(&bsdf);
}

static struct pbnds_vec3 eval(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                              struct pbnds_vec3 wi)
{
    return pbnds_blinn_phong_eval(&lobe->blinn_phong, wo, wi);
}

static float pdf(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                 struct pbnds_vec3 wi)
{
    return pbnds_blinn_phong_pdf(&lobe->blinn_phong, wo, wi);
}

static bool sample(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                   float u_lobe, float u1, float u2, struct pbnds_brdf_sample *out)
{
    return pbnds_blinn_phong_sample(&lobe->blinn_phong, wo, u_lobe, u1, u2, out);
}

static enum pbnds_status shade(const struct pbnds_shader *self,
                               const struct pbnds_shade_job *job,
                               struct pbnds_image *radiance, struct pbnds_error *error)
{
    static const struct pbnds_direct_model model = {.name = "blinn-phong",
                                                    .spp = 64,
                                                    .shadows = false,
                                                    .load = load,
                                                    .eval = eval,
                                                    .pdf = pdf,
                                                    .sample = sample};
    (void)self;
    return pbnds_direct(&model, job, radiance, error);
}

static const struct pbnds_shader_ops ops = {
    .name = "blinn-phong",
    .channels = PBNDS_CHANNELS_LIT,
    .about = "normalised Blinn-Phong, direct light, no shadows unless asked",
    .shade = shade,
};
const struct pbnds_shader pbnds_shader_blinn_phong = {.ops = &ops};
