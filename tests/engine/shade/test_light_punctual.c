/* engine/shade/light_punctual.c against the extension's text and the power of a lamp. */
#include "tests/test.h"

#include "engine/shade/light_punctual.h"

static const double PI = 3.14159265358979323846;

static struct pbnds_light lamp(enum pbnds_light_kind kind)
{
    struct pbnds_light light = {.kind = kind,
                                .position = {1.0f, 2.0f, -3.0f},
                                .direction = {0.0f, -0.6f, 0.8f},
                                .intensity = {8.0f, 4.0f, 2.0f},
                                .range = INFINITY,
                                .cos_inner = 0.9f,
                                .cos_outer = 0.5f};
    return light;
}

static struct pbnds_vec3 beside(const struct pbnds_light *light, float x, float y,
                                float z)
{
    return pbnds_add(light->position, pbnds_vec3_make(x, y, z));
}

static void a_sun_is_the_same_everywhere(void **state)
{
    (void)state;
    const struct pbnds_light sun = lamp(PBNDS_LIGHT_DIRECTIONAL);
    struct pbnds_punctual s;
    assert_true(pbnds_light_punctual(&sun, pbnds_vec3_make(1e6f, -3.0f, 0.0f), &s));
    assert_near(s.wi.x, 0.0, 0.0);
    assert_near(s.wi.y, 0.6, 1e-7);
    assert_near(s.wi.z, -0.8, 1e-7);
    assert_true(isinf(s.distance));
    assert_near(s.irradiance.x, 8.0, 0.0);
    assert_near(s.irradiance.z, 2.0, 0.0);
}

static void a_point_falls_off_with_the_square(void **state)
{
    (void)state;
    const struct pbnds_light light = lamp(PBNDS_LIGHT_POINT);
    struct pbnds_punctual s;
    assert_true(pbnds_light_punctual(&light, beside(&light, 0.0f, -4.0f, 3.0f), &s));
    assert_near(s.distance, 5.0, 1e-6);
    assert_near(s.wi.y, 0.8, 1e-6);
    assert_near(s.wi.z, -0.6, 1e-6);
    assert_near(s.irradiance.x, 8.0 / 25.0, 1e-6);
    assert_near(s.irradiance.y, 4.0 / 25.0, 1e-6);
    /* so close that the square is too small for a float: no infinity comes out */
    assert_false(pbnds_light_punctual(&light, light.position, &s));
    const struct pbnds_light origin = {
        .kind = PBNDS_LIGHT_POINT, .intensity = {1.0f, 1.0f, 1.0f}, .range = INFINITY};
    assert_false(
        pbnds_light_punctual(&origin, pbnds_vec3_make(1e-20f, 0.0f, 0.0f), &s));
    assert_false(pbnds_light_punctual(&origin, pbnds_splat(INFINITY), &s));
    assert_false(pbnds_light_punctual(&origin, pbnds_splat(NAN), &s));
}

static void the_range_fades_it_out(void **state)
{
    (void)state;
    struct pbnds_light light = lamp(PBNDS_LIGHT_POINT);
    light.range = 4.0f;
    struct pbnds_punctual s;
    assert_true(pbnds_light_punctual(&light, beside(&light, 2.0f, 0.0f, 0.0f), &s));
    assert_near(s.irradiance.x, 8.0 / 4.0 * (1.0 - 1.0 / 16.0), 1e-6);
    assert_true(pbnds_light_punctual(&light, beside(&light, 3.99f, 0.0f, 0.0f), &s));
    assert_false(pbnds_light_punctual(&light, beside(&light, 4.0f, 0.0f, 0.0f), &s));
    assert_false(pbnds_light_punctual(&light, beside(&light, 9.0f, 0.0f, 0.0f), &s));
}

/* Watts through a sphere of any radius: 4 pi I of a point; of a spot the integral of its
 * falloff, which over t = (c - outer) / (inner - outer) is 2 pi I ((1 - inner) +
 * (inner - outer) / 3). */
static double watts(const struct pbnds_light *light, float radius)
{
    enum { N = 512 };
    double sum = 0.0;
    const struct pbnds_frame frame = pbnds_frame_from_normal(light->direction);
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < 16; ++j) {
            const float z = 2.0f * ((float)i + 0.5f) / N - 1.0f;
            const float r = sqrtf(1.0f - z * z), phi = (float)j * PBNDS_PI / 8.0f;
            const struct pbnds_vec3 way = pbnds_to_world(
                &frame, pbnds_vec3_make(r * cosf(phi), r * sinf(phi), z));
            struct pbnds_punctual s;
            if (pbnds_light_punctual(light, pbnds_mad(light->position, way, radius),
                                     &s))
                sum += (double)s.irradiance.x;
        }
    return sum * 4.0 * PI * (double)(radius * radius) / (N * 16.0);
}

static void power_does_not_depend_on_the_radius(void **state)
{
    (void)state;
    const struct pbnds_light point = lamp(PBNDS_LIGHT_POINT);
    const struct pbnds_light spot = lamp(PBNDS_LIGHT_SPOT);
    const double cone = 2.0 * PI * 8.0 * ((1.0 - 0.9) + (0.9 - 0.5) / 3.0);
    for (float radius = 0.1f; radius < 100.0f; radius *= 7.0f) {
        assert_near(watts(&point, radius), 32.0 * PI, 0.01);
        assert_near(watts(&spot, radius), cone, 1e-3 * cone);
    }
}

static void a_spot_has_an_edge(void **state)
{
    (void)state;
    struct pbnds_light spot = lamp(PBNDS_LIGHT_SPOT);
    spot.direction = pbnds_vec3_make(0.0f, -1.0f, 0.0f);
    struct pbnds_punctual s;
    /* the cosines of the three points below: 1, 0.8 and 0.5 - epsilon */
    assert_true(pbnds_light_punctual(&spot, beside(&spot, 0.0f, -1.0f, 0.0f), &s));
    assert_near(s.irradiance.x, 8.0, 1e-5);
    assert_true(pbnds_light_punctual(&spot, beside(&spot, 0.6f, -0.8f, 0.0f), &s));
    assert_near(s.irradiance.x, 8.0 * 0.75 * 0.75, 1e-5);
    assert_false(
        pbnds_light_punctual(&spot, beside(&spot, 0.0f, -0.499f, 0.8666f), &s));
    assert_false(pbnds_light_punctual(&spot, beside(&spot, 0.0f, 1.0f, 0.0f), &s));
    /* equal angles are a hard edge, not a division by zero */
    spot.cos_inner = spot.cos_outer;
    assert_true(pbnds_light_punctual(&spot, beside(&spot, 0.0f, -0.502f, 0.8649f), &s));
    assert_near(s.irradiance.x, 8.0, 1e-2);
    assert_false(
        pbnds_light_punctual(&spot, beside(&spot, 0.0f, -0.499f, 0.8666f), &s));
}

static void a_black_lamp_gives_nothing(void **state)
{
    (void)state;
    struct pbnds_light light = lamp(PBNDS_LIGHT_POINT);
    light.intensity = pbnds_splat(0.0f);
    struct pbnds_punctual s;
    assert_false(pbnds_light_punctual(&light, pbnds_splat(0.0f), &s));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_sun_is_the_same_everywhere),
        cmocka_unit_test(a_point_falls_off_with_the_square),
        cmocka_unit_test(the_range_fades_it_out),
        cmocka_unit_test(power_does_not_depend_on_the_radius),
        cmocka_unit_test(a_spot_has_an_edge),
        cmocka_unit_test(a_black_lamp_gives_nothing),
    };
    return cmocka_run_group_tests_name("engine/shade/light_punctual", tests, NULL,
                                       NULL);
}
