/* engine/shade/brdf_blinn_phong.c against its closed forms. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "engine/shade/brdf_blinn_phong.h"
#include "tests/engine/shade/lobe.h"

static const struct pbnds_vec3 WHITE = {1.0f, 1.0f, 1.0f};

static struct pbnds_vec3 eval(const void *b, struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    return pbnds_blinn_phong_eval(b, wo, wi);
}

static float pdf(const void *b, struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    return pbnds_blinn_phong_pdf(b, wo, wi);
}

static bool sample(const void *b, struct pbnds_vec3 wo, float u_lobe, float u1,
                   float u2, struct pbnds_brdf_sample *out)
{
    return pbnds_blinn_phong_sample(b, wo, u_lobe, u1, u2, out);
}

static struct lobe lobe_of(const struct pbnds_blinn_phong *b)
{
    return (struct lobe){
        .brdf = b, .eval = eval, .pdf = pdf, .sample = sample, .frame = b->frame};
}

static struct pbnds_blinn_phong make(float metallic, float roughness, float f0)
{
    const struct pbnds_vec3 n = pbnds_normalize(pbnds_vec3_make(-0.3f, 0.8f, 0.2f));
    const struct pbnds_bsdf bsdf =
        pbnds_bsdf_make(n, WHITE, metallic, roughness, pbnds_splat(f0), 1.0f);
    return pbnds_blinn_phong_make(&bsdf);
}

static void exponent_follows_roughness(void **state)
{
    (void)state;
    assert_near(pbnds_blinn_phong_exponent(1.0f), 0.0, 0.0);
    assert_near(pbnds_blinn_phong_exponent(0.5f), 2.0 / (0.25 * 0.25) - 2.0, 1e-5);
    assert_near(pbnds_blinn_phong_exponent(0.0f), 2e6 - 2.0, 1.0);
}

/* Without a specular part the model is Lambert's: exactly the albedo, from anywhere. */
static void diffuse_furnace_is_exact(void **state)
{
    (void)state;
    const struct pbnds_blinn_phong b = make(0.0f, 0.5f, 0.0f);
    const struct lobe lobe = lobe_of(&b);
    double kept;
    for (float cos_o = 0.1f; cos_o <= 1.0f; cos_o += 0.3f) {
        assert_near(sampled_albedo(&lobe, direction(cos_o, 1.0f), 256, &kept), 1.0,
                    1e-5);
        assert_near(kept, 1.0, 0.0);
        assert_near(quadrature_albedo(&lobe, direction(cos_o, 1.0f), 64), 1.0, 1e-5);
    }
}

/* White metal along the normal: all of the light, at every exponent. */
static void specular_furnace_closes_along_the_normal(void **state)
{
    (void)state;
    double kept;
    for (float roughness = 0.0f; roughness <= 1.0f; roughness += 0.05f) {
        const struct pbnds_blinn_phong b = make(1.0f, roughness, 0.0f);
        const struct lobe lobe = lobe_of(&b);
        assert_near(sampled_albedo(&lobe, direction(1.0f, 0.0f), 1 << 14, &kept), 1.0,
                    2e-3);
    }
    /* the hand-made case m = 0: a constant lobe of 1 / pi */
    const struct pbnds_blinn_phong chalk = make(1.0f, 1.0f, 0.0f);
    assert_near(chalk.peak, 1.0 / acos(-1.0), 1e-7);
}

static void off_the_normal_it_only_loses(void **state)
{
    (void)state;
    double kept;
    for (float metallic = 0.0f; metallic <= 1.0f; metallic += 0.5f)
        for (float roughness = 0.0f; roughness <= 1.0f; roughness += 0.1f)
            for (float cos_o = 0.02f; cos_o <= 1.0f; cos_o += 0.07f) {
                const struct pbnds_blinn_phong b = make(metallic, roughness, 0.5f);
                const struct lobe lobe = lobe_of(&b);
                const double albedo =
                    sampled_albedo(&lobe, direction(cos_o, 2.0f), 4096, &kept);
                if (!(albedo >= 0.0 && albedo <= 1.005))
                    fail_msg("metallic %g roughness %g cos %g reflects %g",
                             (double)metallic, (double)roughness, (double)cos_o,
                             albedo);
            }
}

static void sampling_agrees_with_quadrature(void **state)
{
    (void)state;
    const float cases[][3] = {{0.0f, 0.5f, 0.04f},
                              {0.0f, 0.7f, 0.5f},
                              {1.0f, 1.0f, 0.0f},
                              {1.0f, 0.5f, 0.0f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        for (float cos_o = 0.2f; cos_o <= 1.0f; cos_o += 0.4f) {
            const struct pbnds_blinn_phong b =
                make(cases[i][0], cases[i][1], cases[i][2]);
            const struct lobe lobe = lobe_of(&b);
            const struct pbnds_vec3 wo = direction(cos_o, 0.7f);
            double kept;
            const double sampled = sampled_albedo(&lobe, wo, 1 << 15, &kept);
            assert_near(sampled, quadrature_albedo(&lobe, wo, 400), 3e-3);
            assert_near(kept, quadrature_pdf(&lobe, wo, 400), 3e-3);
        }
}

/* At m = 2e6 the float cosine of a degree-wide lobe has no digits left: sin must be
 * used. */
static void narrow_lobes_keep_their_shape(void **state)
{
    (void)state;
    const struct pbnds_blinn_phong b = make(1.0f, 0.0f, 0.0f);
    const struct lobe lobe = lobe_of(&b);
    double kept;
    assert_near(sampled_albedo(&lobe, direction(0.9f, 0.3f), 4096, &kept), 0.81, 2e-3);
    const struct pbnds_vec3 wo = direction(1.0f, 0.0f);
    /* h tilted by 1e-3: (1 - 1e-6)^(m/2) = e^-1 of the peak */
    const struct pbnds_vec3 wi = {sinf(2e-3f), 0.0f, cosf(2e-3f)};
    const struct pbnds_frame *f = &b.frame;
    const double peak = (double)eval(&b, pbnds_to_world(f, wo),
                                     pbnds_to_world(f, direction(1.0f, 0.0f)))
                            .x;
    const double off = (double)eval(&b, pbnds_to_world(f, wo), pbnds_to_world(f, wi)).x;
    assert_near(off / peak, exp(-1.0), 2e-3);
}

static void eval_is_reciprocal(void **state)
{
    (void)state;
    const struct pbnds_blinn_phong b = make(0.3f, 0.5f, 0.04f);
    const struct pbnds_vec3 p = pbnds_to_world(&b.frame, direction(0.3f, 0.1f)),
                            q = pbnds_to_world(&b.frame, direction(0.8f, 2.0f));
    const double f = (double)eval(&b, p, q).x;
    assert_near(eval(&b, q, p).x, f, 1e-5 * f);
}

static void below_the_horizon_is_black(void **state)
{
    (void)state;
    const struct pbnds_blinn_phong b = make(0.3f, 0.5f, 0.04f);
    const struct pbnds_vec3 up = pbnds_to_world(&b.frame, direction(0.5f, 0.0f)),
                            down = pbnds_to_world(&b.frame, direction(-0.1f, 0.0f));
    struct pbnds_brdf_sample s;
    assert_near(eval(&b, up, down).x, 0.0, 0.0);
    assert_near(eval(&b, down, up).x, 0.0, 0.0);
    assert_near(pdf(&b, up, down), 0.0, 0.0);
    assert_false(sample(&b, down, 0.1f, 0.5f, 0.5f, &s));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exponent_follows_roughness),
        cmocka_unit_test(diffuse_furnace_is_exact),
        cmocka_unit_test(specular_furnace_closes_along_the_normal),
        cmocka_unit_test(off_the_normal_it_only_loses),
        cmocka_unit_test(sampling_agrees_with_quadrature),
        cmocka_unit_test(narrow_lobes_keep_their_shape),
        cmocka_unit_test(eval_is_reciprocal),
        cmocka_unit_test(below_the_horizon_is_black),
    };
    return cmocka_run_group_tests_name("engine/shade/brdf_blinn_phong", tests, NULL,
                                       NULL);
}
