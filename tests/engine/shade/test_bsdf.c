/* engine/shade/bsdf.c: what any physical material must satisfy. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "engine/shade/bsdf.h"
#include "tests/engine/shade/lobe.h"

static const struct pbnds_vec3 WHITE = {1.0f, 1.0f, 1.0f};

static struct pbnds_vec3 eval(const void *b, struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    return pbnds_bsdf_eval(b, wo, wi);
}

static struct pbnds_vec3 diffuse(const void *b, struct pbnds_vec3 wo,
                                 struct pbnds_vec3 wi)
{
    return pbnds_bsdf_diffuse(b, wo, wi);
}

static float pdf(const void *b, struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    return pbnds_bsdf_pdf(b, wo, wi);
}

static bool sample(const void *b, struct pbnds_vec3 wo, float u_lobe, float u1,
                   float u2, struct pbnds_brdf_sample *out)
{
    return pbnds_bsdf_sample(b, wo, u_lobe, u1, u2, out);
}

static struct lobe lobe_of(const struct pbnds_bsdf *bsdf)
{
    return (struct lobe){
        .brdf = bsdf, .eval = eval, .pdf = pdf, .sample = sample, .frame = bsdf->frame};
}

/* A tilted surface: nothing may lean on +z. */
static struct pbnds_bsdf make(float metallic, float roughness, float dielectric_f0)
{
    const struct pbnds_vec3 n = pbnds_normalize(pbnds_vec3_make(0.3f, -0.5f, -0.7f));
    return pbnds_bsdf_make(n, WHITE, metallic, roughness, pbnds_splat(dielectric_f0),
                           1.0f);
}

/* Seen along the normal, wo.h = cos(theta / 2), so the diffuse albedo is the integral
 * of (1 - (1 - cos(theta/2))^5) 2 sin cos over theta, f0 = 0. */
static void diffuse_furnace_has_its_exact_value(void **state)
{
    (void)state;
    const struct pbnds_bsdf bsdf = make(0.0f, 1.0f, 0.0f);
    struct lobe lobe = lobe_of(&bsdf);
    lobe.eval = diffuse;
    double expected = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const double theta = (i + 0.5) / 2000.0 * acos(-1.0) / 2.0;
        expected += (1.0 - pow(1.0 - cos(theta / 2.0), 5.0)) * sin(2.0 * theta);
    }
    expected *= acos(-1.0) / 2.0 / 2000.0;
    assert_near(quadrature_albedo(&lobe, direction(1.0f, 0.0f), 200), expected, 1e-4);
}

/* At normal incidence a rough white metal is the GGX lobe alone: 1 - ln 2. */
static void metal_is_the_specular_lobe_alone(void **state)
{
    (void)state;
    const struct pbnds_bsdf bsdf = make(1.0f, 1.0f, 0.04f);
    struct lobe lobe = lobe_of(&bsdf);
    assert_near(quadrature_albedo(&lobe, direction(1.0f, 0.0f), 200), 1.0 - log(2.0),
                1e-4);
    lobe.eval = diffuse;
    assert_near(quadrature_albedo(&lobe, direction(0.5f, 0.0f), 50), 0.0, 0.0);
}

/* Of white smooth dielectrics more than 1 comes back at grazing view, because glTF's
 * 1 - F(wo.h) leaves the diffuse part nearly whole there; bsdf.h says how much. Nowhere
 * else, and neither part by itself. */
static void energy_stays_within_the_stated_bounds(void **state)
{
    (void)state;
    for (float metallic = 0.0f; metallic <= 1.0f; metallic += 0.5f)
        for (float roughness = 0.0f; roughness <= 1.0f; roughness += 0.25f)
            for (float f0 = 0.0f; f0 <= 1.0f; f0 = f0 * 2.0f + 0.04f) {
                const struct pbnds_bsdf bsdf = make(metallic, roughness, f0);
                struct lobe lobe = lobe_of(&bsdf);
                double kept, mean = 0.0;
                for (int i = 0; i < 10; ++i) {
                    const float cos_o = ((float)i + 0.5f) / 10.0f;
                    const struct pbnds_vec3 wo = direction(cos_o, 1.0f);
                    lobe.eval = eval;
                    const double albedo = sampled_albedo(&lobe, wo, 2048, &kept);
                    lobe.eval = diffuse;
                    const double matte = quadrature_albedo(&lobe, wo, 32);
                    const bool bright =
                        cos_o > 0.7f || roughness > 0.9f || metallic > 0.9f;
                    if (!(albedo > 0.0 && albedo < (bright ? 1.015 : 1.9)) ||
                        matte > 1.001)
                        fail_msg(
                            "metallic %g roughness %g f0 %g cos %g reflects %g, %g",
                            (double)metallic, (double)roughness, (double)f0,
                            (double)cos_o, albedo, matte);
                    mean += 2.0 * (double)cos_o * albedo / 10.0;
                }
                assert_true(mean < 1.05);
            }
}

static void sampling_agrees_with_quadrature(void **state)
{
    (void)state;
    const float cases[][3] = {{0.0f, 0.5f, 0.04f},
                              {0.0f, 1.0f, 0.0f},
                              {0.5f, 0.7f, 0.04f},
                              {1.0f, 0.4f, 0.0f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        for (float cos_o = 0.2f; cos_o <= 1.0f; cos_o += 0.4f) {
            const struct pbnds_bsdf bsdf = make(cases[i][0], cases[i][1], cases[i][2]);
            const struct lobe lobe = lobe_of(&bsdf);
            const struct pbnds_vec3 wo = direction(cos_o, 0.7f);
            double kept;
            const double sampled = sampled_albedo(&lobe, wo, 1 << 15, &kept);
            assert_near(sampled, quadrature_albedo(&lobe, wo, 300), 3e-3);
            assert_near(kept, quadrature_pdf(&lobe, wo, 300), 3e-3);
        }
}

static void samples_follow_their_density(void **state)
{
    (void)state;
    const float cases[][3] = {
        {0.0f, 0.5f, 0.04f}, {0.3f, 0.8f, 0.1f}, {1.0f, 0.6f, 0.0f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const struct pbnds_bsdf bsdf = make(cases[i][0], cases[i][1], cases[i][2]);
        const struct lobe lobe = lobe_of(&bsdf);
        const double excess = chi_square_excess(&lobe, direction(0.5f, 2.0f), 77 + i);
        assert_near(excess, 0.0, 4.0);
    }
}

static void a_sample_carries_its_own_value(void **state)
{
    (void)state;
    const struct pbnds_bsdf bsdf = make(0.4f, 0.5f, 0.04f);
    const struct pbnds_vec3 wo = pbnds_to_world(&bsdf.frame, direction(0.6f, 0.2f));
    int kept = 0;
    for (int i = 0; i < 1000; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(1, 2, (uint64_t)i);
        const float u0 = pbnds_rng_float(&rng), u1 = pbnds_rng_float(&rng),
                    u2 = pbnds_rng_float(&rng);
        struct pbnds_brdf_sample s;
        if (!pbnds_bsdf_sample(&bsdf, wo, u0, u1, u2, &s)) continue;
        ++kept;
        assert_near(pbnds_length(s.wi), 1.0, 1e-5);
        const struct pbnds_vec3 f = pbnds_bsdf_eval(&bsdf, wo, s.wi);
        assert_near(s.f.x, f.x, 1e-3 * (double)f.x + 1e-6);
        const double p = (double)pbnds_bsdf_pdf(&bsdf, wo, s.wi);
        assert_near(s.pdf, p, 1e-3 * p + 1e-6);
    }
    assert_true(kept > 900);
}

static void both_parts_are_reciprocal(void **state)
{
    (void)state;
    const struct pbnds_bsdf bsdf = make(0.3f, 0.4f, 0.08f);
    for (int i = 0; i < 50; ++i) {
        const float t = (float)i / 50.0f;
        const struct pbnds_vec3 p =
            pbnds_to_world(&bsdf.frame, direction(0.05f + 0.9f * t, t));
        const struct pbnds_vec3 q =
            pbnds_to_world(&bsdf.frame, direction(0.9f - 0.8f * t, 5.0f * t));
        const double f = (double)pbnds_bsdf_eval(&bsdf, p, q).x,
                     d = (double)pbnds_bsdf_diffuse(&bsdf, p, q).x;
        assert_near(pbnds_bsdf_eval(&bsdf, q, p).x, f, 1e-4 * f);
        assert_near(pbnds_bsdf_diffuse(&bsdf, q, p).x, d, 1e-5 * d);
    }
}

static void below_the_horizon_is_black(void **state)
{
    (void)state;
    const struct pbnds_bsdf bsdf = make(0.3f, 0.4f, 0.04f);
    const struct pbnds_vec3 up = pbnds_to_world(&bsdf.frame, direction(0.5f, 0.0f));
    const struct pbnds_vec3 down = pbnds_to_world(&bsdf.frame, direction(-0.1f, 0.0f));
    struct pbnds_brdf_sample s;
    assert_near(pbnds_bsdf_eval(&bsdf, up, down).x, 0.0, 0.0);
    assert_near(pbnds_bsdf_eval(&bsdf, down, up).x, 0.0, 0.0);
    assert_near(pbnds_bsdf_pdf(&bsdf, up, down), 0.0, 0.0);
    assert_near(pbnds_bsdf_pdf(&bsdf, down, up), 0.0, 0.0);
    assert_false(pbnds_bsdf_sample(&bsdf, down, 0.5f, 0.5f, 0.5f, &s));
}

static void parameters_are_kept_in_range(void **state)
{
    (void)state;
    const struct pbnds_vec3 n = {0.0f, 1.0f, 0.0f};
    const struct pbnds_vec3 wild = {-1.0f, 2.0f, NAN};
    const struct pbnds_bsdf b =
        pbnds_bsdf_make(n, wild, 0.0f, NAN, pbnds_splat(0.04f), 1.0f);
    assert_near(b.c_diff.x, 0.0, 0.0);
    assert_near(b.c_diff.y, 1.0, 0.0);
    assert_near(b.c_diff.z, 0.0, 0.0);
    assert_near(b.ggx.alpha, PBNDS_GGX_ALPHA_MIN, 0.0);
    assert_near(
        pbnds_bsdf_make(n, WHITE, 0.0f, 7.0f, pbnds_splat(0.04f), 1.0f).ggx.alpha, 1.0,
        0.0);
    assert_near(
        pbnds_bsdf_make(n, WHITE, 9.0f, 1.0f, pbnds_splat(0.04f), 1.0f).c_diff.y, 0.0,
        0.0);
}

static void the_gbuffer_round_trip_is_exact(void **state)
{
    (void)state;
    struct pbnds_error error;
    struct pbnds_gbuffer g;
    assert_int_equal(pbnds_gbuffer_init(&g, 2, 1, &error), PBNDS_OK);
    const size_t i = 1; /* not the first pixel, so that the index counts */
    for (float metallic = 0.0f; metallic <= 1.0f; metallic += 0.125f)
        for (float f0 = 0.0f; f0 <= 0.2f; f0 += 0.05f) {
            const struct pbnds_vec3 n =
                pbnds_normalize(pbnds_vec3_make(0.2f, 0.9f, -0.4f));
            const struct pbnds_vec3 base = {0.9f, 0.5f, 0.1f};
            const struct pbnds_bsdf b =
                pbnds_bsdf_make(n, base, metallic, 0.6f, pbnds_splat(f0), 1.0f);
            g.normal[0][i] = n.x, g.normal[1][i] = n.y, g.normal[2][i] = n.z;
            g.albedo[0][i] = base.x, g.albedo[1][i] = base.y, g.albedo[2][i] = base.z;
            g.metallic[i] = metallic;
            g.roughness[i] = 0.6f;
            g.specular[i] = pbnds_luminance(b.ggx.f0);
            const struct pbnds_bsdf r = pbnds_bsdf_from_gbuffer(&g, i);
            assert_near(r.ggx.f0.x, b.ggx.f0.x, 1e-6);
            assert_near(r.ggx.f0.y, b.ggx.f0.y, 1e-6);
            assert_near(r.ggx.f0.z, b.ggx.f0.z, 1e-6);
            assert_near(r.ggx.alpha, b.ggx.alpha, 0.0);
            assert_memory_equal(&r.c_diff, &b.c_diff, sizeof r.c_diff);
            assert_memory_equal(&r.frame, &b.frame, sizeof r.frame);
        }
    pbnds_gbuffer_free(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(diffuse_furnace_has_its_exact_value),
        cmocka_unit_test(metal_is_the_specular_lobe_alone),
        cmocka_unit_test(energy_stays_within_the_stated_bounds),
        cmocka_unit_test(sampling_agrees_with_quadrature),
        cmocka_unit_test(samples_follow_their_density),
        cmocka_unit_test(a_sample_carries_its_own_value),
        cmocka_unit_test(both_parts_are_reciprocal),
        cmocka_unit_test(below_the_horizon_is_black),
        cmocka_unit_test(parameters_are_kept_in_range),
        cmocka_unit_test(the_gbuffer_round_trip_is_exact),
    };
    return cmocka_run_group_tests_name("engine/shade/bsdf", tests, NULL, NULL);
}
