/* Hard lights have the energy that their shape and radiance have, at any size. */
#include "tests/test.h"

#include "neural/data/draw_lamps.h"

static const double pi = 3.14159265358979323846;

/* Integrals over the sphere: of the map, and of the map times the cosine to `n`. */
static void integrate(const struct pbnds_image *map, struct pbnds_vec3 n,
                      double power[3], double facing[3])
{
    for (int c = 0; c < 3; ++c)
        power[c] = facing[c] = 0.0;
    for (int y = 0; y < map->height; ++y) {
        const double area =
            2.0 * pi / map->width *
            (cos(pi * y / map->height) - cos(pi * (y + 1) / map->height));
        const double polar = pi * (y + 0.5) / map->height;
        for (int x = 0; x < map->width; ++x) {
            const double azimuth = 2.0 * pi * ((x + 0.5) / map->width - 0.5);
            const double cosine = (double)n.x * sin(polar) * cos(azimuth) +
                                  (double)n.y * cos(polar) +
                                  (double)n.z * sin(polar) * sin(azimuth);
            for (int c = 0; c < 3; ++c) {
                const double l = (double)pbnds_image_at(map, x, y)[c];
                power[c] += area * l;
                facing[c] += area * l * fmax(cosine, 0.0);
            }
        }
    }
}

static struct pbnds_lamp lamp_at(struct pbnds_vec3 d, float half_x, float half_y)
{
    struct pbnds_lamp lamp = {.direction = pbnds_normalize(d),
                              .half_x = half_x,
                              .half_y = half_y,
                              .power = {3.0f, 2.0f, 0.5f}};
    lamp.side = pbnds_frame_from_normal(lamp.direction).t;
    return lamp;
}

static void a_lamp_keeps_its_power_at_any_size(void **state)
{
    (void)state;
    static const struct pbnds_vec3 DIRECTIONS[] = {
        {0, 1, 0},           {0, -1, 0},          {-1, 0, 0},
        {-1, 0.001f, 1e-5f}, {0.3f, 0.7f, -0.2f}, {0.01f, 1, 0.003f}};
    static const float RADII[] = {1e-5f, 0.0035f, 0.02f, 0.09f, 0.4f};
    static const int WIDTHS[] = {256, 64, 30};
    for (int i = 0; i < 6 * 5 * 3; ++i) {
        const struct pbnds_lamp lamp = lamp_at(DIRECTIONS[i % 6], RADII[i / 6 % 5],
                                               i % 2 ? RADII[i / 6 % 5] : 0.0f);
        struct pbnds_image map;
        const int width = WIDTHS[i / 30];
        assert_int_equal(pbnds_image_init(&map, width, width / 2, 3, NULL), PBNDS_OK);
        pbnds_lamp_add(&lamp, &map);
        double power[3], facing[3];
        integrate(&map, lamp.direction, power, facing);
        assert_near(power[0], 3.0, 3e-5);
        assert_near(power[1], 2.0, 2e-5);
        assert_near(power[2], 0.5, 5e-6);
        assert_near((double)pbnds_map_luminance(&map) * 4.0 * pi,
                    0.2126 * 3.0 + 0.7152 * 2.0 + 0.0722 * 0.5, 3e-5);
        pbnds_image_free(&map);
    }
}

/* A disc of radiance L and radius r: power 2 pi L (1 - cos r), irradiance of what faces it
 * pi L sin^2 r, the ratio (1 + cos r) / 2. */
static void a_disc_lights_as_a_disc(void **state)
{
    (void)state;
    for (int i = 0; i < 4; ++i) {
        const double r = 0.1 + 0.2 * i;
        const struct pbnds_lamp lamp =
            lamp_at(pbnds_vec3_make(0.3f, 0.5f, -0.7f), (float)r, 0.0f);
        struct pbnds_image map;
        assert_int_equal(pbnds_image_init(&map, 256, 128, 3, NULL), PBNDS_OK);
        pbnds_lamp_add(&lamp, &map);
        double power[3], facing[3];
        integrate(&map, lamp.direction, power, facing);
        assert_near(facing[0] / power[0], 0.5 * (1.0 + cos(r)), 1e-3);
        const double radiance = 3.0 / (2.0 * pi * (1.0 - cos(r)));
        int dark = 0, bright = 0;
        for (int k = 0; k < 256 * 128; ++k) {
            dark += map.data[3 * k] == 0.0f;
            bright += fabs((double)map.data[3 * k] - radiance) < 0.03 * radiance;
        }
        assert_true(dark + bright > 256 * 128 * 97 / 100); /* others: at the edge */
        assert_true(bright > 20);
        pbnds_image_free(&map);
    }
}

static void black_bodies_go_from_red_to_blue(void **state)
{
    (void)state;
    const struct pbnds_vec3 white = pbnds_black_body(6504.0f);
    assert_near(white.x, 1.0, 0.05); /* D65 is a little greener */
    assert_near(white.y, 1.0, 0.04);
    assert_near(white.z, 1.0, 0.04);
    float before = INFINITY;
    for (float kelvin = 1700.0f; kelvin < 25000.0f; kelvin *= 1.01f) {
        const struct pbnds_vec3 c = pbnds_black_body(kelvin);
        assert_near(pbnds_luminance(c), 1.0, 1e-5);
        assert_true(c.x < before + 0.003f); /* the splines meet there */
        before = c.x;
        assert_true(c.x > 0.0f && c.y > 0.0f && c.z >= 0.0f);
    }
    assert_true(pbnds_black_body(2700.0f).x > 3.0f * pbnds_black_body(2700.0f).z);
    assert_true(pbnds_black_body(12000.0f).z > 1.3f * pbnds_black_body(12000.0f).x);
}

static void drawn_lamps_are_of_unit_luminance_and_hard(void **state)
{
    (void)state;
    int hard = 0, boxes = 0;
    for (int i = 0; i < 40; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(5, (uint64_t)i, 2);
        struct pbnds_image map;
        assert_int_equal(pbnds_image_init(&map, 256, 128, 3, NULL), PBNDS_OK);
        cJSON *notes = cJSON_CreateObject();
        pbnds_draw_lamps(&rng, &map, notes);
        assert_near(pbnds_map_luminance(&map), 1.0, 1e-4);
        float top = 0.0f;
        for (int k = 0; k < 3 * 256 * 128; ++k) {
            assert_true(map.data[k] >= 0.0f && map.data[k] < INFINITY);
            top = fmaxf(top, map.data[k]);
        }
        hard += top > 200.0f;
        const cJSON *lamps = cJSON_GetObjectItem(notes, "lamps");
        assert_true(cJSON_GetArraySize(lamps) >= 1 && cJSON_GetArraySize(lamps) <= 4);
        const double half =
            cJSON_GetObjectItem(lamps->child, "half_x_deg")->valuedouble;
        assert_true(half > 0.19 && half < 25.1);
        boxes += half > 5.001;
        pbnds_image_free(&map);
        cJSON_Delete(notes);
    }
    assert_true(hard > 12 && boxes > 8 && boxes < 28);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lamp_keeps_its_power_at_any_size),
        cmocka_unit_test(a_disc_lights_as_a_disc),
        cmocka_unit_test(black_bodies_go_from_red_to_blue),
        cmocka_unit_test(drawn_lamps_are_of_unit_luminance_and_hard),
    };
    return cmocka_run_group_tests_name("neural/data/draw_lamps", tests, NULL, NULL);
}
