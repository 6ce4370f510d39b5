/* neural/features.c against the definition in its header, and against the models'
 * tables. */
#include "tests/neural/fixture.h"

#include "neural/features.h"
#include "neural/model/model_pbnds_plus.h"
#include "neural/model/model_transport.h"

static void tables_agree_with_the_networks(void **state)
{
    (void)state;
    assert_int_equal(pbnds_features_view_channels(&pbnds_features_transport),
                     PBNDS_TRANSPORT_VIEW_CHANNELS);
    assert_int_equal(pbnds_features_light_channels(&pbnds_features_transport),
                     PBNDS_TRANSPORT_LIGHT_CHANNELS);
    assert_int_equal(pbnds_features_view_channels(&pbnds_features_pbnds_plus),
                     PBNDS_PLUS_VIEW_CHANNELS);
    assert_int_equal(pbnds_features_light_channels(&pbnds_features_pbnds_plus),
                     PBNDS_PLUS_LIGHT_CHANNELS);
    /* the paper's 14 inputs in the 8-band encoding */
    assert_int_equal(PBNDS_PLUS_VIEW_CHANNELS + PBNDS_PLUS_LIGHT_CHANNELS, 238);
}

static void encoding_is_frequency_major(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(20, 20);
    struct pbnds_view v;
    assert_int_equal(pbnds_view_create(&g, &v, NULL), PBNDS_OK);
    float dst[PBNDS_PLUS_VIEW_CHANNELS];
    const int x = 7, y = 12;
    pbnds_features_view(&pbnds_features_pbnds_plus, &v,
                        (struct pbnds_window){x, y, 1, 1}, dst);
    const struct pbnds_feature_table *t = &pbnds_features_pbnds_plus;
    for (int j = 0; j < t->view_count; ++j) {
        const double value = (double)v.plane[t->view[j].plane][y * 20 + x];
        assert_near((double)dst[j], value, 1e-6);
        for (int k = 0; k < 8; ++k) {
            const double angle = ldexp(value, k);
            assert_near((double)dst[11 * (1 + 2 * k) + j], sin(angle), 1e-4);
            assert_near((double)dst[11 * (2 + 2 * k) + j], cos(angle), 1e-4);
        }
    }
    pbnds_view_free(&v);
    pbnds_gbuffer_free(&g);
}

static void light_planes_follow_the_light(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(20, 20);
    struct pbnds_view v;
    assert_int_equal(pbnds_view_create(&g, &v, NULL), PBNDS_OK);
    const struct pbnds_light_source light = {
        .wi = pbnds_normalize(pbnds_vec3_make(0.0f, 1.0f, 1.0f)),
        .radiance = {4.0f, 0.0f, 1.0f}};
    float plus[PBNDS_PLUS_LIGHT_CHANNELS];
    pbnds_features_light(&pbnds_features_pbnds_plus, &v, NULL, &light,
                         (struct pbnds_window){10, 10, 1, 1}, plus);
    const double cosine = sqrt(0.5);
    assert_near((double)plus[0], log1p(4.0 * cosine), 1e-5);
    assert_near((double)plus[1], 0.0, 1e-7);
    assert_near((double)plus[2], log1p(cosine), 1e-5);

    uint32_t thin[400] = {0}, thick[400] = {0};
    const struct pbnds_march march = {thin, thick};
    thick[10 * 20 + 10] = 1u << 3;
    struct pbnds_light_source marched = light;
    marched.bit = 3;
    float transport[PBNDS_TRANSPORT_LIGHT_CHANNELS];
    pbnds_features_light(&pbnds_features_transport, &v, &march, &marched,
                         (struct pbnds_window){10, 10, 1, 1}, transport);
    assert_near((double)transport[0], cosine, 1e-5);
    assert_near((double)transport[3], cosine, 1e-5); /* l.y */
    assert_near((double)transport[5], 1.0, 0.0);     /* thin: open */
    assert_near((double)transport[6], 0.0, 0.0);     /* thick: blocked */
    pbnds_view_free(&v);
    pbnds_gbuffer_free(&g);
}

/* A window past the border repeats it; inside, a window is a cut of the whole. */
static void windows_cut_and_repeat(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(18, 13);
    struct pbnds_view v;
    assert_int_equal(pbnds_view_create(&g, &v, NULL), PBNDS_OK);
    enum { C = PBNDS_TRANSPORT_VIEW_CHANNELS };
    float *all = malloc(32 * 16 * C * sizeof *all), cut[4 * 4 * C];
    pbnds_features_view(&pbnds_features_transport, &v,
                        (struct pbnds_window){0, 0, 32, 16}, all);
    pbnds_features_view(&pbnds_features_transport, &v,
                        (struct pbnds_window){5, 6, 4, 4}, cut);
    for (int y = 0; y < 4; ++y) {
        assert_memory_equal(cut + y * 4 * C, all + ((6 + y) * 32 + 5) * C, 4 * C * 4);
    }
    for (int y = 0; y < 16; ++y) {
        const int sy = y < 13 ? y : 12;
        for (int x = 18; x < 32; ++x) {
            assert_memory_equal(all + (y * 32 + x) * C, all + (sy * 32 + 17) * C,
                                C * 4);
        }
    }
    free(all);
    pbnds_view_free(&v);
    pbnds_gbuffer_free(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_agree_with_the_networks),
        cmocka_unit_test(encoding_is_frequency_major),
        cmocka_unit_test(light_planes_follow_the_light),
        cmocka_unit_test(windows_cut_and_repeat),
    };
    return cmocka_run_group_tests_name("neural/features", tests, NULL, NULL);
}
