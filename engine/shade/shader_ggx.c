/* "ggx": the glTF metallic-roughness material under the light map, direct light only.
 */
#include "engine/shade/direct.h"
#include "engine/shade/shader_table.h"

static void load(union pbnds_direct_lobe *lobe, const struct pbnds_gbuffer *gbuffer,
                 size_t i)
{
    lobe->bsdf = pbnds_bsdf_from_gbuffer(gbuffer, i);
}

static struct pbnds_vec3 eval(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                              struct pbnds_vec3 wi)
{
    return pbnds_bsdf_eval(&lobe->bsdf, wo, wi);
}

static float pdf(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                 struct pbnds_vec3 wi)
{
    return pbnds_bsdf_pdf(&lobe->bsdf, wo, wi);
}

static bool sample(const union pbnds_direct_lobe *lobe, struct pbnds_vec3 wo,
                   float u_lobe, float u1, float u2, struct pbnds_brdf_sample *out)
{
    return pbnds_bsdf_sample(&lobe->bsdf, wo, u_lobe, u1, u2, out);
}

static enum pbnds_status shade(const struct pbnds_shader *self,
                               const struct pbnds_shade_job *job,
                               struct pbnds_image *radiance, struct pbnds_error *error)
{
    static const struct pbnds_direct_model model = {.name = "ggx",
                                                    .spp = 64,
                                                    .shadows = true,
                                                    .load = load,
                                                    .eval = eval,
                                                    .pdf = pdf,
                                                    .sample = sample};
    (void)self;
    return pbnds_direct(&model, job, radiance, error);
}

static const struct pbnds_shader_ops ops = {
    .name = "ggx",
    .channels = PBNDS_CHANNELS_LIT,
    .about =
        "glTF metallic-roughness (GGX), direct light; shadows where the scene is known",
    .shade = shade,
};
const struct pbnds_shader pbnds_shader_ggx = {.ops = &ops};
