/* The visible normals of brdf_ggx.c against their density, smooth to rough, steep to
 * grazing. */
#include "engine/shade/brdf_ggx.h"
#include "tests/engine/shade/chi_squared.h"
#include "tests/engine/shade/lobe.h"

struct view {
    struct pbnds_ggx ggx;
    struct pbnds_vec3 wo;
};

static double pdf(const void *self, struct pbnds_vec3 w)
{
    const struct view *v = self;
    return (double)pbnds_ggx_pdf(&v->ggx, v->wo, w);
}

static bool sample(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w)
{
    const struct view *v = self;
    const float u1 = pbnds_rng_float(rng), u2 = pbnds_rng_float(rng);
    struct pbnds_brdf_sample s;
    if (!pbnds_ggx_sample(&v->ggx, v->wo, u1, u2, &s)) return false;
    *w = s.wi;
    return true;
}

enum { ALPHAS = 4, VIEWS = 3 };

/* The narrow lobes lie about the mirror direction, where the bins are finest. */
static void visible_normals_follow_their_density(void **state)
{
    (void)state;
    const float alphas[ALPHAS] = {PBNDS_GGX_ALPHA_MIN, 0.05f, 0.3f, 1.0f};
    const double powers[ALPHAS] = {4.0, 2.0, 1.0, 1.0};
    const float cosines[VIEWS] = {1.0f, 0.5f, 0.05f};
    for (int a = 0; a < ALPHAS; ++a)
        for (int c = 0; c < VIEWS; ++c) {
            const struct view view = {{pbnds_splat(1.0f), 1.0f, alphas[a]},
                                      direction(cosines[c], 0.7f)};
            const struct pbnds_vec3 mirror = {-view.wo.x, -view.wo.y, view.wo.z};
            const struct chi_sampler sampler = {
                .self = &view,
                .pdf = pdf,
                .sample = sample,
                .pole = powers[a] > 1.0 ? mirror : pbnds_vec3_make(0.0f, 0.0f, 1.0f),
                .power = powers[a]};
            char what[96];
            (void)snprintf(what, sizeof what, "alpha %g, cosine %g", (double)alphas[a],
                           (double)cosines[c]);
            assert_chi_squared(&sampler, (uint64_t)(10 * a + c), ALPHAS * VIEWS, what);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(visible_normals_follow_their_density),
    };
    return cmocka_run_group_tests_name("engine/shade/chi_ggx", tests, NULL, NULL);
}
