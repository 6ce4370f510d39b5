/* neural/transport.c: the analytic half of the transport equation against quadrature.
 */
#include "tests/neural/fixture.h"

#include "neural/transport.h"

static struct pbnds_envmap *constant_env(float radiance)
{
    struct pbnds_image image;
    assert_int_equal(pbnds_image_init(&image, 16, 8, 3, NULL), PBNDS_OK);
    for (int i = 0; i < 16 * 8 * 3; ++i)
        image.data[i] = radiance;
    struct pbnds_envmap *env;
    assert_int_equal(
        pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, NULL), PBNDS_OK);
    pbnds_image_free(&image);
    return env;
}

/* Diffuse and specular by clusters plus specular by the whole map are the whole BRDF.
 */
static void parts_sum_to_the_brdf_under_constant_light(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(40, 40);
    struct pbnds_view v;
    assert_int_equal(pbnds_view_create(&g, &v, NULL), PBNDS_OK);
    struct pbnds_envmap *env = constant_env(2.0f);
    int checked = 0;
    for (int x = 12; x < 38; x += 5) {
        const size_t i = (size_t)(40 * (x % 2 ? 10 : 30) + x);
        const struct pbnds_transport_pixel p = pbnds_transport_pixel(&v, i);
        assert_true(p.covered);
        struct pbnds_vec3 sum = pbnds_transport_specular(&p, &v, env);
        double whole = 0.0, parts = (double)sum.y;
        enum { N = 400 };
        for (int a = 0; a < N; ++a) { /* 2 pi / N^2 solid angle each, cos uniform */
            for (int b = 0; b < N; ++b) {
                const float z = ((float)a + 0.5f) / N;
                const float phi = 2.0f * PBNDS_PI * ((float)b + 0.5f) / N;
                const float r = sqrtf(1.0f - z * z);
                const struct pbnds_vec3 wi = pbnds_to_world(
                    &p.bsdf.frame, pbnds_vec3_make(r * cosf(phi), r * sinf(phi), z));
                const double solid = 2.0 * 3.14159265358979 / ((double)N * N);
                const float cosine = fmaxf(pbnds_dot(p.bsdf.frame.n, wi), 0.0f);
                whole += 2.0 * solid *
                         (double)(pbnds_bsdf_eval(&p.bsdf, p.wo, wi).y * cosine);
                parts += 2.0 * solid * (double)pbnds_transport_direct(&p, wi).y;
            }
        }
        assert_near(parts / whole, 1.0, 0.02);
        ++checked;
    }
    assert_true(checked >= 5);
    pbnds_envmap_free(env);
    pbnds_view_free(&v);
    pbnds_gbuffer_free(&g);
}

static void specular_is_linear_in_the_map(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(24, 24);
    struct pbnds_view v;
    assert_int_equal(pbnds_view_create(&g, &v, NULL), PBNDS_OK);
    struct pbnds_envmap *one = fixture_env(1.0f, 3), *three = fixture_env(3.0f, 3),
                        *black = constant_env(0.0f);
    double total = 0.0;
    for (size_t i = 0; i < 24u * 24u; ++i) {
        const struct pbnds_transport_pixel p = pbnds_transport_pixel(&v, i);
        const double a = (double)pbnds_transport_specular(&p, &v, one).x;
        const double b = (double)pbnds_transport_specular(&p, &v, three).x;
        assert_near(b, 3.0 * a, 1e-5 * (1.0 + 3.0 * a));
        assert_true(pbnds_transport_specular(&p, &v, black).x == 0.0f);
        total += a;
    }
    assert_true(total > 0.1);
    pbnds_envmap_free(one);
    pbnds_envmap_free(three);
    pbnds_envmap_free(black);
    pbnds_view_free(&v);
    pbnds_gbuffer_free(&g);
}

static void output_functions_have_their_slopes(void **state)
{
    (void)state;
    for (float s = -6.0f; s <= 6.0f; s += 0.5f) {
        const float h = 1e-2f;
        const double slope = (double)(pbnds_transport_indirect(s + h) -
                                      pbnds_transport_indirect(s - h)) /
                             (2.0 * (double)h);
        assert_near((double)pbnds_transport_indirect_slope(s), slope, 1e-3);
        assert_true(pbnds_transport_indirect(s) >= 0.0f);
        assert_true(pbnds_transport_visibility(s) > 0.0f &&
                    pbnds_transport_visibility(s) < 1.0f);
    }
    assert_near((double)pbnds_transport_indirect(40.0f), 38.0, 1e-5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_sum_to_the_brdf_under_constant_light),
        cmocka_unit_test(specular_is_linear_in_the_map),
        cmocka_unit_test(output_functions_have_their_slopes),
    };
    return cmocka_run_group_tests_name("neural/transport", tests, NULL, NULL);
}
