/* Whole renders by the reference whose answer is a formula: lights. */
#include "tests/engine/shade/fixture.h"

static const struct pbnds_vec3 ZERO = {0.0f, 0.0f, 0.0f};

/* Nothing but the diffuse lobe: no Fresnel at any angle. */
static struct pbnds_material lambert(float albedo)
{
    struct pbnds_material m = matte(albedo);
    m.specular = 0.0f;
    return m;
}

/* A Lambert floor at y = 0 below the given meshes; one pixel looks at its origin along a
 * slant. */
static void floor_and(struct fixture *f, const struct pbnds_mesh *more, int count,
                      struct pbnds_material *m, int materials)
{
    struct pbnds_mesh meshes[4];
    m[0] = lambert(0.5f);
    meshes[0] = floor_at(0.0f, 10.0f, 0);
    for (int i = 0; i < count; ++i)
        meshes[1 + i] = more[i];
    fixture_scene(f, meshes, 1 + count, m, materials);
}

static void look_at_origin(struct fixture *f)
{
    fixture_view(f, pbnds_vec3_make(6.0f, 0.6f, 0.0f), ZERO, 1, 1);
    assert_near(f->gbuffer.coverage[0], 1.0, 0.0);
    assert_near(f->gbuffer.position[0][0], 0.0, 1e-4);
}

static double traced(const struct fixture *f, int spp, int bounces, int channel)
{
    struct pbnds_image image;
    struct pbnds_error error;
    const struct pbnds_pathtrace_options options = {.spp = spp, .max_bounces = bounces};
    must(pbnds_pathtrace(&f->job, &options, &image, NULL, &error), &error);
    const double value = (double)image.data[channel];
    pbnds_image_free(&image);
    return value;
}

static void set_light(struct fixture *f, struct pbnds_light light)
{
    f->scene.lights = must_alloc(1, sizeof light);
    f->scene.lights[0] = light;
    f->scene.light_count = 1;
}

/* albedo / pi I cos / d^2, exactly: nothing is left to chance. */
static void a_point_light_over_a_plane(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m[1];
    floor_and(&f, NULL, 0, m, 1);
    look_at_origin(&f);
    set_light(&f, (struct pbnds_light){.kind = PBNDS_LIGHT_POINT,
                                       .position = {1.0f, 2.0f, 2.0f},
                                       .intensity = {10.0f, 20.0f, 30.0f},
                                       .range = INFINITY});
    const double pi = (double)PBNDS_PI, factor = 0.5 / pi * (2.0 / 3.0) / 9.0;
    for (int c = 0; c < 3; ++c)
        assert_near(traced(&f, 4, 0, c), factor * 10.0 * (c + 1), 1e-4);
    f.scene.lights[0].range = 3.5f; /* the recommended window */
    assert_near(traced(&f, 4, 0, 0), factor * 10.0 * (1.0 - pow(3.0 / 3.5, 4.0)), 1e-4);
    f.scene.lights[0].position.y = -2.0f; /* below the floor */
    assert_near(traced(&f, 4, 0, 0), 0.0, 0.0);
    fixture_free(&f);
}

static void a_spot_and_a_directional_light(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m[1];
    floor_and(&f, NULL, 0, m, 1);
    look_at_origin(&f);
    const double pi = (double)PBNDS_PI;
    set_light(&f, (struct pbnds_light){.kind = PBNDS_LIGHT_DIRECTIONAL,
                                       .direction = {0.0f, -0.6f, 0.8f},
                                       .intensity = {3.0f, 3.0f, 3.0f}});
    assert_near(traced(&f, 4, 0, 0), 0.5 / pi * 3.0 * 0.6, 1e-5);
    /* 20 degrees off its axis, between cones of 10 and 30 */
    const double off = 20.0 * pi / 180.0, inner = cos(10.0 * pi / 180.0),
                 outer = cos(30.0 * pi / 180.0);
    f.scene.lights[0] =
        (struct pbnds_light){.kind = PBNDS_LIGHT_SPOT,
                             .position = {0.0f, 2.0f, 0.0f},
                             .direction = {(float)sin(off), (float)-cos(off), 0.0f},
                             .intensity = {8.0f, 8.0f, 8.0f},
                             .range = INFINITY,
                             .cos_inner = (float)inner,
                             .cos_outer = (float)outer};
    const double s = (cos(off) - outer) / (inner - outer);
    assert_near(traced(&f, 4, 0, 0), 0.5 / pi * 8.0 / 4.0 * s * s, 1e-4);
    fixture_free(&f);
}

/* Twelve equal lights around: every choice gives the same, whichever is drawn. */
static void many_point_lights_sum(void **state)
{
    (void)state;
    enum { LIGHTS = 12 };
    struct fixture f;
    struct pbnds_material m[1];
    floor_and(&f, NULL, 0, m, 1);
    look_at_origin(&f);
    f.scene.lights = must_alloc(LIGHTS, sizeof *f.scene.lights);
    f.scene.light_count = LIGHTS;
    for (int i = 0; i < LIGHTS; ++i) {
        const float phi = 2.0f * PBNDS_PI * (float)i / LIGHTS;
        f.scene.lights[i] =
            (struct pbnds_light){.kind = PBNDS_LIGHT_POINT,
                                 .position = {cosf(phi), 1.0f, sinf(phi)},
                                 .intensity = {1.0f, 1.0f, 1.0f},
                                 .range = INFINITY};
    }
    const double want =
        LIGHTS * 0.5 / (double)PBNDS_PI * sqrt(0.5) / 2.0; /* cos / d^2 */
    assert_near(traced(&f, 16, 0, 0), want, 1e-4 * want);
    fixture_free(&f);
}

/* Irradiance of the middle of a square of side 2a at height h: pi L F, with F four times
 * the form factor of a parallel rectangle over its corner (Howell, C-11). */
static void a_square_emitter_has_its_form_factor(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m[2];
    m[1] = lambert(0.0f);
    m[1].emissive = pbnds_vec3_make(5.0f, 2.0f, 1.0f);
    const struct pbnds_mesh panel = floor_at(1.5f, 1.0f, 1);
    floor_and(&f, &panel, 1, m, 2);
    look_at_origin(&f);
    const double x = 1.0 / 1.5, r = sqrt(1.0 + x * x), pi = (double)PBNDS_PI;
    const double factor = 4.0 / (2.0 * pi) * 2.0 * (x / r) * atan(x / r);
    for (int c = 0; c < 3; ++c) {
        const double l = c == 0 ? 5.0 : c == 1 ? 2.0 : 1.0;
        assert_near(traced(&f, 4096, 1, c), 0.5 * l * factor, 0.003 * l * factor);
    }
    fixture_free(&f);
}

/* The same where the emitter is made of 20 000 triangles of a sphere: pi L (R/d)^2 cos. */
static void a_sphere_of_many_triangles(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m[2];
    m[1] = lambert(0.0f);
    m[1].emissive = pbnds_splat(10.0f);
    const struct pbnds_mesh ball =
        sphere(pbnds_vec3_make(0.0f, 3.0f, 0.0f), 1.0f, 72, 1);
    floor_and(&f, &ball, 1, m, 2);
    look_at_origin(&f);
    const double want = 0.5 * 10.0 / 9.0;
    assert_near(traced(&f, 4096, 1, 0), want, 0.006 * want);
    fixture_free(&f);
}

/* Light of an emitter that no point of the choice's estimate sees: a texture that is
 * black but for a thin line. */
static void a_light_that_the_estimate_misses(void **state)
{
    (void)state;
    enum { WIDE = 64 };
    struct fixture f;
    struct pbnds_material m[2];
    float texels[4 * WIDE] = {0.0f};
    m[1] = lambert(0.0f);
    m[1].emissive = pbnds_splat(1.0f);
    m[1].emissive_texture.texture = 0;
    struct pbnds_mesh panel = floor_at(1.0f, 2.0f, 1);
    panel.uv[0] = must_alloc(4, sizeof *panel.uv[0]);
    for (int i = 0; i < 4; ++i)
        panel.uv[0][i].x = 0.5f + 0.25f * panel.position[i].x;
    for (int i = 0; i < 4; ++i)
        texels[4 * (WIDE / 2) + i] = 1.0f; /* x from 0 to 1/16, all along z */
    floor_and(&f, &panel, 1, m, 2);
    fixture_texture_rgba(&f, texels, WIDE, 1);
    look_at_origin(&f);
    const double want = traced(&f, 1 << 16, 1, 0);
    /* a thin strip of width w and half length b over its middle, at height 1:
     * E = L w integral of (1 + z^2)^-2 over [-b, b] = L w (b / (1 + b^2) + atan b) */
    const double b = 2.0, w = 1.0 / 16.0;
    const double strip = w * (b / (1.0 + b * b) + atan(b));
    assert_near(want, 0.5 / (double)PBNDS_PI * strip, 0.02 * want);
    fixture_free(&f);
}

/* All walls alike: every point of a closed box sees e / (1 - rho), whatever the
 * box. One path has a standard deviation of about 1.5 here. */
static void a_closed_white_box(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = lambert(0.8f);
    m.emissive = pbnds_vec3_make(0.5f, 1.0f, 0.25f);
    const struct pbnds_mesh mesh = cube(1.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_view(&f, pbnds_vec3_make(0.3f, -0.2f, 0.9f), ZERO, 4, 4);
    struct pbnds_image image;
    struct pbnds_error error;
    const struct pbnds_pathtrace_options options = {.spp = 4096, .max_bounces = 300};
    must(pbnds_pathtrace(&f.job, &options, &image, NULL, &error), &error);
    for (size_t i = 0; i < 16; ++i) {
        assert_near(image.data[3 * i], 2.5, 0.1);
        assert_near(image.data[3 * i + 1], 5.0, 0.2);
        assert_near(image.data[3 * i + 2], 1.25, 0.05);
    }
    assert_near(covered_mean(&f, &image, 0), 2.5, 0.02);
    pbnds_image_free(&image);
    fixture_free(&f);
}

/* Emission of a pixel itself, both sides, and of an unlit surface. */
static void emitters_are_seen(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m[2] = {lambert(0.0f), lambert(0.0f)};
    m[0].emissive = pbnds_vec3_make(3.0f, 2.0f, 1.0f);
    m[1].unlit = true;
    m[1].base_color = (struct pbnds_vec4){0.25f, 0.5f, 0.75f, 1.0f};
    for (int side = 0; side < 2; ++side) {
        for (int unlit = 0; unlit < 2; ++unlit) {
            const struct pbnds_mesh mesh = floor_at(0.0f, 5.0f, unlit);
            fixture_scene(&f, &mesh, 1, m, 2);
            fixture_view(&f, pbnds_vec3_make(0.0f, side ? -2.0f : 2.0f, 0.1f), ZERO, 1,
                         1);
            assert_near(traced(&f, 4, 0, 0), unlit ? 0.25 : 3.0, 1e-6);
            assert_near(traced(&f, 4, 0, 2), unlit ? 0.75 : 1.0, 1e-6);
            fixture_free(&f);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_point_light_over_a_plane),
        cmocka_unit_test(a_spot_and_a_directional_light),
        cmocka_unit_test(many_point_lights_sum),
        cmocka_unit_test(a_square_emitter_has_its_form_factor),
        cmocka_unit_test(a_sphere_of_many_triangles),
        cmocka_unit_test(a_light_that_the_estimate_misses),
        cmocka_unit_test(a_closed_white_box),
        cmocka_unit_test(emitters_are_seen),
    };
    return cmocka_run_group_tests_name("engine/shade/pathtrace_light", tests, NULL,
                                       NULL);
}
