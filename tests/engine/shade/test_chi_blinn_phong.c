/* The mixture of brdf_blinn_phong.c against its density. */
#include "engine/shade/brdf_blinn_phong.h"
#include "tests/engine/shade/chi_squared.h"
#include "tests/engine/shade/lobe.h"

struct view {
    struct pbnds_blinn_phong lobe;
    struct pbnds_vec3 wo;
};

static double pdf(const void *self, struct pbnds_vec3 w)
{
    const struct view *v = self;
    return (double)pbnds_blinn_phong_pdf(&v->lobe, v->wo, w);
}

static bool sample(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w)
{
    const struct view *v = self;
    const float u0 = pbnds_rng_float(rng), u1 = pbnds_rng_float(rng),
                u2 = pbnds_rng_float(rng);
    struct pbnds_brdf_sample s;
    if (!pbnds_blinn_phong_sample(&v->lobe, v->wo, u0, u1, u2, &s)) return false;
    *w = s.wi;
    return true;
}

struct material {
    float metallic, roughness, f0;
    double power;
};

enum { MATERIALS = 5, VIEWS = 3 };

static void samples_follow_their_density(void **state)
{
    (void)state;
    const struct material materials[MATERIALS] = {{0.0f, 0.6f, 0.2f, 1.0},
                                                  {1.0f, 0.7f, 0.0f, 1.0},
                                                  {1.0f, 1.0f, 0.0f, 1.0},
                                                  {0.0f, 0.3f, 0.04f, 2.0},
                                                  {1.0f, 0.05f, 0.0f, 4.0}};
    const float cosines[VIEWS] = {1.0f, 0.6f, 0.1f};
    const struct pbnds_vec3 n = pbnds_normalize(pbnds_vec3_make(-0.3f, 0.8f, 0.2f));
    for (int m = 0; m < MATERIALS; ++m)
        for (int c = 0; c < VIEWS; ++c) {
            const struct material *p = &materials[m];
            const struct pbnds_bsdf bsdf =
                pbnds_bsdf_make(n, pbnds_vec3_make(0.9f, 0.7f, 0.5f), p->metallic,
                                p->roughness, pbnds_splat(p->f0), 1.0f);
            const struct pbnds_vec3 wo = direction(cosines[c], 2.0f);
            const struct pbnds_vec3 mirror = {-wo.x, -wo.y, wo.z};
            const struct view view = {pbnds_blinn_phong_make(&bsdf),
                                      pbnds_to_world(&bsdf.frame, wo)};
            const struct chi_sampler sampler = {
                .self = &view,
                .pdf = pdf,
                .sample = sample,
                .pole = p->power > 1.0 ? pbnds_to_world(&bsdf.frame, mirror) : n,
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
    return cmocka_run_group_tests_name("engine/shade/chi_blinn_phong", tests, NULL,
                                       NULL);
}
