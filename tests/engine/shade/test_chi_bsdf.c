/* The mixture of bsdf.c against its density, from Lambert's cosine alone to half
 * metal; metal is the lobe of test_chi_ggx.c. */
#include "engine/shade/bsdf.h"
#include "tests/engine/shade/chi_squared.h"
#include "tests/engine/shade/lobe.h"

struct view {
    struct pbnds_bsdf bsdf;
    struct pbnds_vec3 wo;
};

static double pdf(const void *self, struct pbnds_vec3 w)
{
    const struct view *v = self;
    return (double)pbnds_bsdf_pdf(&v->bsdf, v->wo, w);
}

static bool sample(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w)
{
    const struct view *v = self;
    const float u0 = pbnds_rng_float(rng), u1 = pbnds_rng_float(rng),
                u2 = pbnds_rng_float(rng);
    struct pbnds_brdf_sample s;
    if (!pbnds_bsdf_sample(&v->bsdf, v->wo, u0, u1, u2, &s)) return false;
    *w = s.wi;
    return true;
}

struct material {
    float metallic, roughness, f0, f90;
    double power;
};

enum { MATERIALS = 4, VIEWS = 3 };

static void samples_follow_their_density(void **state)
{
    (void)state;
    const struct material materials[MATERIALS] = {
        {0.0f, 0.5f, 0.0f, 0.0f, 1.0}, /* the cosine alone */
        {0.0f, 0.5f, 0.04f, 1.0f, 1.0},
        {0.3f, 0.8f, 0.1f, 0.5f, 1.0},
        {0.5f, 0.1f, 0.04f, 1.0f, 3.0}};
    const float cosines[VIEWS] = {1.0f, 0.5f, 0.05f};
    const struct pbnds_vec3 n = pbnds_normalize(pbnds_vec3_make(0.3f, -0.5f, -0.7f));
    for (int m = 0; m < MATERIALS; ++m)
        for (int c = 0; c < VIEWS; ++c) {
            const struct material *p = &materials[m];
            const struct pbnds_vec3 wo = direction(cosines[c], 2.0f);
            const struct pbnds_vec3 mirror = {-wo.x, -wo.y, wo.z};
            struct view view;
            view.bsdf =
                pbnds_bsdf_make(n, pbnds_vec3_make(0.9f, 0.7f, 0.5f), p->metallic,
                                p->roughness, pbnds_splat(p->f0), p->f90);
            view.wo = pbnds_to_world(&view.bsdf.frame, wo);
            const struct chi_sampler sampler = {
                .self = &view,
                .pdf = pdf,
                .sample = sample,
                .pole = p->power > 1.0 ? pbnds_to_world(&view.bsdf.frame, mirror) : n,
                .power = p->power};
            char what[96];
            (void)snprintf(what, sizeof what, "metallic %g, roughness %g, cosine %g",
                           (double)p->metallic, (double)p->roughness,
                           (double)cosines[c]);
            assert_chi_squared(&sampler, (uint64_t)(10 * m + c), MATERIALS * VIEWS,
                               what);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_follow_their_density),
    };
    return cmocka_run_group_tests_name("engine/shade/chi_bsdf", tests, NULL, NULL);
}
