/* engine/shade/bsdf.c: what any physical material must satisfy. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "engine/shade/bsdf.h"
#include "tests/engine/shade/lobe.h"
#include "tests/reference/ggx_albedo.h"

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

static struct pbnds_bsdf make_specular(struct pbnds_vec3 base, float roughness,
                                       struct pbnds_vec3 f0, float f90)
{
    const struct pbnds_vec3 n = pbnds_normalize(pbnds_vec3_make(0.3f, -0.5f, -0.7f));
    return pbnds_bsdf_make(n, base, 0.0f, roughness, f0, f90);
}

/* Without a specular lobe there is nothing to couple to: f = c / pi, to the last digit or
 * two, and every sample is one of the cosine. */
static void without_specular_it_is_lambert(void **state)
{
    (void)state;
    const struct pbnds_vec3 base = {0.9f, 0.5f, 0.2f};
    const struct pbnds_bsdf b = make_specular(base, 0.4f, pbnds_splat(0.0f), 0.0f);
    const struct lobe lobe = lobe_of(&b);
    double kept;
    for (float cos_o = 0.01f; cos_o <= 1.0f; cos_o += 0.1f) {
        const struct pbnds_vec3 wo = pbnds_to_world(&b.frame, direction(cos_o, 2.0f));
        const struct pbnds_vec3 wi = pbnds_to_world(&b.frame, direction(0.3f, 1.0f));
        const struct pbnds_vec3 f = pbnds_bsdf_eval(&b, wo, wi);
        assert_near(f.x, 0.9 / acos(-1.0), 1e-7);
        assert_near(f.z, 0.2 / acos(-1.0), 1e-7);
        assert_near(sampled_albedo(&lobe, direction(cos_o, 2.0f), 512, &kept), 0.9,
                    1e-5);
        assert_near(kept, 1.0, 0.0);
    }
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

/* A white dielectric sends back all of a white furnace's light, at any roughness and from
 * anywhere; the specular part is measured apart from the table (tests/reference). */
static void a_white_dielectric_closes_the_furnace(void **state)
{
    (void)state;
    const float f0s[] = {0.0f, 0.04f, 0.3f};
    for (int k = 0; k < 3; ++k)
        for (float roughness = 0.0f; roughness <= 1.0f; roughness += 0.25f)
            for (float cos_o = 0.05f; cos_o <= 1.0f; cos_o += 0.1f) {
                const struct pbnds_bsdf bsdf = make(0.0f, roughness, f0s[k]);
                struct lobe lobe = lobe_of(&bsdf);
                lobe.eval = diffuse;
                const struct pbnds_vec3 wo = direction(cos_o, 1.0f);
                const struct naive_albedo e =
                    naive_ggx_albedo((double)cos_o, (double)bsdf.ggx.alpha, 96);
                const double specular = (double)f0s[k] * e.a + e.b;
                assert_near(specular + quadrature_albedo(&lobe, wo, 48), 1.0, 0.004);
            }
}

/* The same by the estimator that the renderers use, of all parts at once. */
static void the_sampled_furnace_closes_too(void **state)
{
    (void)state;
    double kept;
    for (float roughness = 0.0f; roughness <= 1.0f; roughness += 0.2f)
        for (float cos_o = 0.1f; cos_o <= 1.0f; cos_o += 0.15f) {
            const struct pbnds_bsdf bsdf = make(0.0f, roughness, 0.04f);
            const struct lobe lobe = lobe_of(&bsdf);
            assert_near(sampled_albedo(&lobe, direction(cos_o, 1.0f), 1 << 14, &kept),
                        1.0, 0.005);
        }
}

/* Every material and view, from the mirror to chalk: no more than 1.01 comes back, and
 * no part of it is negative. */
static void no_material_makes_light(void **state)
{
    (void)state;
    for (float metallic = 0.0f; metallic <= 1.0f; metallic += 0.5f)
        for (float roughness = 0.0f; roughness <= 1.0f; roughness += 0.125f)
            for (float f0 = 0.0f; f0 <= 1.0f; f0 = f0 * 2.0f + 0.04f)
                for (int i = 0; i < 12; ++i) {
                    const float t = ((float)i + 0.3f) / 12.0f, cos_o = t * t;
                    const struct pbnds_bsdf bsdf = make(metallic, roughness, f0);
                    struct lobe lobe = lobe_of(&bsdf);
                    double kept;
                    const struct pbnds_vec3 wo = direction(cos_o, 1.0f);
                    const double all = sampled_albedo(&lobe, wo, 4096, &kept);
                    lobe.eval = diffuse;
                    const double matte = quadrature_albedo(&lobe, wo, 12);
                    if (!(all > 0.3 && all <= 1.01) || !(matte >= 0.0 && matte <= 1.0))
                        fail_msg(
                            "metallic %g roughness %g f0 %g cos %g reflects %g, %g",
                            (double)metallic, (double)roughness, (double)f0,
                            (double)cos_o, all, matte);
                }
}

/* f0 in colour and an f90 below 1 (KHR_materials_specular): one factor for all channels,
 * that of the greatest f0, whose channel closes the furnace; the others are below. */
static void coloured_specular_shades_all_channels_alike(void **state)
{
    (void)state;
    const struct pbnds_vec3 f0 = {0.02f, 0.5f, 0.1f};
    const struct pbnds_bsdf b = make_specular(WHITE, 0.5f, f0, 0.6f);
    const struct pbnds_bsdf grey = make_specular(WHITE, 0.5f, pbnds_splat(0.5f), 0.6f);
    for (float cos_o = 0.1f; cos_o <= 1.0f; cos_o += 0.2f) {
        const struct pbnds_vec3 wo = pbnds_to_world(&b.frame, direction(cos_o, 2.0f));
        const struct pbnds_vec3 wi = pbnds_to_world(&b.frame, direction(0.3f, 1.0f));
        const struct pbnds_vec3 d = pbnds_bsdf_diffuse(&b, wo, wi);
        assert_near(d.x, d.y, 0.0);
        assert_near(d.z, d.y, 0.0);
        assert_near(pbnds_bsdf_diffuse(&grey, wo, wi).x, d.y, 0.0);
        const struct pbnds_vec3 s = pbnds_sub(pbnds_bsdf_eval(&b, wo, wi), d);
        const struct pbnds_vec3 h = pbnds_normalize(pbnds_add(wo, wi));
        const struct pbnds_vec3 expected = pbnds_schlick(f0, 0.6f, pbnds_dot(wo, h));
        assert_near(s.x / s.y, expected.x / expected.y, 1e-5);
        assert_near(s.z / s.y, expected.z / expected.y, 1e-5);
    }
}

/* Appendix B mixes two materials; here the mixture is one lobe. */
static void half_metal_is_half_of_each(void **state)
{
    (void)state;
    const struct pbnds_vec3 n = {0.0f, 0.0f, 1.0f}, base = {0.9f, 0.4f, 0.1f};
    const struct pbnds_vec3 f0 = {0.05f, 0.02f, 0.2f};
    const struct pbnds_bsdf metal = pbnds_bsdf_make(n, base, 1.0f, 0.4f, f0, 0.5f);
    const struct pbnds_bsdf plastic = pbnds_bsdf_make(n, base, 0.0f, 0.4f, f0, 0.5f);
    const struct pbnds_bsdf both = pbnds_bsdf_make(n, base, 0.3f, 0.4f, f0, 0.5f);
    for (float cos_o = 0.05f; cos_o <= 1.0f; cos_o += 0.2f) {
        const struct pbnds_vec3 wo = direction(cos_o, 0.0f), wi = direction(0.5f, 2.5f);
        const struct pbnds_vec3 expected = pbnds_lerp(
            pbnds_bsdf_eval(&plastic, wo, wi), pbnds_bsdf_eval(&metal, wo, wi), 0.3f);
        const struct pbnds_vec3 f = pbnds_bsdf_eval(&both, wo, wi);
        assert_near(f.x, expected.x, 1e-6 * (double)expected.x);
        assert_near(f.y, expected.y, 1e-6 * (double)expected.y);
        assert_near(f.z, expected.z, 1e-6 * (double)expected.z);
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

/* With the planes f0 and f90 the colour comes through as well. */
static void the_coloured_round_trip_is_exact(void **state)
{
    (void)state;
    const struct pbnds_vec3 n = pbnds_normalize(pbnds_vec3_make(0.2f, 0.9f, -0.4f));
    const struct pbnds_vec3 base = {0.9f, 0.5f, 0.1f}, f0 = {0.3f, 0.02f, 0.11f};
    const struct pbnds_vec3 wo = pbnds_normalize(pbnds_vec3_make(0.9f, 0.5f, 0.1f));
    const struct pbnds_vec3 wi = pbnds_normalize(pbnds_vec3_make(-0.5f, 0.6f, -0.4f));
    for (float metallic = 0.0f; metallic <= 1.0f; metallic += 0.0625f)
        for (float f90 = 0.0f; f90 <= 1.0f; f90 += 0.25f) {
            const struct pbnds_bsdf b =
                pbnds_bsdf_make(n, base, metallic, 0.6f, f0, f90);
            struct pbnds_vec3 p_n = n, p_base = base, p_f0 = b.ggx.f0;
            float p_metallic = metallic, p_roughness = 0.6f, p_f90 = b.ggx.f90;
            float p_specular = pbnds_luminance(b.ggx.f0);
            const struct pbnds_gbuffer g = {
                .width = 1,
                .height = 1,
                .normal = {&p_n.x, &p_n.y, &p_n.z},
                .albedo = {&p_base.x, &p_base.y, &p_base.z},
                .f0 = {&p_f0.x, &p_f0.y, &p_f0.z},
                .f90 = &p_f90,
                .metallic = &p_metallic,
                .roughness = &p_roughness,
                .specular = &p_specular,
            };
            const struct pbnds_bsdf r = pbnds_bsdf_from_gbuffer(&g, 0);
            const struct pbnds_vec3 f = pbnds_bsdf_eval(&b, wo, wi);
            const struct pbnds_vec3 again = pbnds_bsdf_eval(&r, wo, wi);
            assert_near(r.ggx.f90, b.ggx.f90, 1e-6);
            assert_near(again.x, f.x, 2e-6 * (double)f.x);
            assert_near(again.y, f.y, 2e-6 * (double)f.y);
            assert_near(again.z, f.z, 2e-6 * (double)f.z);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_specular_it_is_lambert),
        cmocka_unit_test(metal_is_the_specular_lobe_alone),
        cmocka_unit_test(a_white_dielectric_closes_the_furnace),
        cmocka_unit_test(the_sampled_furnace_closes_too),
        cmocka_unit_test(no_material_makes_light),
        cmocka_unit_test(coloured_specular_shades_all_channels_alike),
        cmocka_unit_test(half_metal_is_half_of_each),
        cmocka_unit_test(sampling_agrees_with_quadrature),
        cmocka_unit_test(a_sample_carries_its_own_value),
        cmocka_unit_test(both_parts_are_reciprocal),
        cmocka_unit_test(below_the_horizon_is_black),
        cmocka_unit_test(parameters_are_kept_in_range),
        cmocka_unit_test(the_gbuffer_round_trip_is_exact),
        cmocka_unit_test(the_coloured_round_trip_is_exact),
    };
    return cmocka_run_group_tests_name("engine/shade/bsdf", tests, NULL, NULL);
}
