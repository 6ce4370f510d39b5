/* One light at a time: against formulas, renders of one light, and their sum. */
#include "tests/engine/shade/fixture.h"

#include "engine/core/parallel.h"
#include "engine/shade/pathtrace_olat.h"
#include "engine/shade/tiles.h"
#include "tests/reference/z_test.h"

enum { LIGHTS = 4, SIDE = 12, PIXELS = SIDE * SIDE };

static const struct pbnds_vec3 TO_LIGHT[LIGHTS] = {
    {0.3f, 0.8f, 0.5f}, {-0.7f, 0.3f, 0.6f}, {0.9f, 0.2f, -0.4f}, {0.1f, -0.9f, 0.4f}};

static void directions(struct pbnds_vec3 wi[LIGHTS])
{
    for (int k = 0; k < LIGHTS; ++k)
        wi[k] = pbnds_normalize(TO_LIGHT[k]);
}

static struct pbnds_light lamp(struct pbnds_vec3 wi, float irradiance)
{
    return (struct pbnds_light){.kind = PBNDS_LIGHT_DIRECTIONAL,
                                .direction = pbnds_scale(wi, -1.0f),
                                .intensity = pbnds_splat(irradiance),
                                .range = INFINITY};
}

/* A corner of a room with a rough metal block, a red ball and a pane that lets half of the
 * light through, if asked; everything throws light on everything. */
static void room(struct fixture *f, bool pane)
{
    struct pbnds_material m[4] = {matte(0.7f), matte(0.6f), matte(0.8f), matte(0.5f)};
    m[1].base_color = (struct pbnds_vec4){0.8f, 0.2f, 0.1f, 1.0f};
    m[2].metallic = 1.0f;
    m[2].roughness = 0.5f;
    m[3].alpha_mode = PBNDS_ALPHA_BLEND;
    m[3].base_color.w = 0.5f;
    struct pbnds_mesh meshes[6];
    meshes[0] = floor_at(-1.0f, 4.0f, 0);
    meshes[1] =
        quad(pbnds_vec3_make(-2.0f, -1.0f, -2.0f), pbnds_vec3_make(5.0f, 0.0f, 0.0f),
             pbnds_vec3_make(0.0f, 3.0f, 0.0f), 0);
    meshes[2] = cube(0.6f, 2);
    meshes[3] = sphere(pbnds_vec3_make(1.3f, -0.3f, 0.6f), 0.7f, 12, 1);
    meshes[4] =
        quad(pbnds_vec3_make(-1.0f, -1.0f, 1.5f), pbnds_vec3_make(2.0f, 0.0f, 0.0f),
             pbnds_vec3_make(0.0f, 1.6f, 0.0f), 3);
    fixture_scene(f, meshes, pane ? 5 : 4, m, 4);
    if (!pane) /* fixture_scene() did not take it over */
        free(meshes[4].position), free(meshes[4].index);
    fixture_view(f, pbnds_vec3_make(2.5f, 2.0f, 5.5f),
                 pbnds_vec3_make(0.2f, -0.3f, 0.0f), SIDE, SIDE);
}

static void trace_olat(const struct fixture *f, int spp, int bounces,
                       const struct pbnds_vec3 *wi, int count,
                       struct pbnds_image *images)
{
    struct pbnds_error error;
    const struct pbnds_pathtrace_options options = {.spp = spp, .max_bounces = bounces};
    must(pbnds_pathtrace_olat(&f->job, &options, wi, count, images, NULL, &error),
         &error);
}

static void free_images(struct pbnds_image *images, int count)
{
    for (int k = 0; k < count; ++k)
        pbnds_image_free(&images[k]);
}

static void a_lambert_plane_reflects_the_cosine(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = matte(0.6f);
    m.specular = 0.0f;
    m.emissive = pbnds_splat(3.0f); /* is in none of them */
    struct pbnds_mesh mesh = floor_at(0.0f, 5.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_view(&f, pbnds_vec3_make(0.0f, 3.0f, 3.0f), pbnds_splat(0.0f), 8, 8);
    struct pbnds_vec3 wi[LIGHTS];
    struct pbnds_image images[LIGHTS];
    directions(wi);
    trace_olat(&f, 4, 8, wi, LIGHTS, images);
    for (int k = 0; k < LIGHTS; ++k) {
        const double expected = 0.6 / 3.14159265358979 * fmax((double)wi[k].y, 0.0);
        for (size_t i = 0; i < 3 * 64; ++i)
            assert_near(images[k].data[i], expected, 1e-5);
    }
    free_images(images, LIGHTS);
    fixture_free(&f);
}

/* Two white Lambert planes at a right angle reflect into each other; what the second one
 * sends back under a light that only it sees has no formula here, but without bounces
 * there is nothing, and with them there is. */
static void a_light_round_the_corner_needs_a_bounce(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = matte(0.8f);
    struct pbnds_mesh meshes[2];
    meshes[0] = floor_at(0.0f, 4.0f, 0);
    meshes[1] =
        quad(pbnds_vec3_make(-4.0f, 0.0f, -1.0f), pbnds_vec3_make(8.0f, 0.0f, 0.0f),
             pbnds_vec3_make(0.0f, 4.0f, 0.0f), 0);
    fixture_scene(&f, meshes, 2, &m, 1);
    fixture_view(&f, pbnds_vec3_make(0.0f, 4.0f, 2.0f),
                 pbnds_vec3_make(0.0f, 0.0f, 1.0f), 4, 4);
    const struct pbnds_vec3 along = {0.0f, 0.0f, 1.0f}; /* grazes the floor */
    struct pbnds_image one;
    trace_olat(&f, 64, 1, &along, 1, &one);
    for (size_t i = 0; i < 16;
         ++i) /* F = (1 - d / sqrt(d^2 + h^2)) / 2, of a long wall */
        assert_true(one.data[3 * i] > 0.0f);
    const double d = (double)f.gbuffer.position[2][5] + 1.0, h = 4.0;
    const double form = 0.5 * (1.0 - d / sqrt(d * d + h * h));
    assert_near(one.data[3 * 5], 0.8 * 0.8 / 3.14159265358979 * form, 0.02);
    pbnds_image_free(&one);
    fixture_free(&f);
}

/* Renders of the reference under one light, or all with their irradiances, are the naive
 * twin: other paths, other numbers, the same mean. */
static void judge(struct fixture *f, const struct pbnds_vec3 *wi, int count,
                  const float *irradiance, const struct pbnds_image *images)
{
    enum { SPP = 2048 };
    struct pbnds_error error;
    struct pbnds_image radiance, variance;
    struct pbnds_light lights[LIGHTS];
    for (int k = 0; k < count; ++k)
        lights[k] = lamp(wi[k], irradiance[k]);
    f->scene.lights = lights;
    f->scene.light_count = count;
    struct pbnds_shade_job job = f->job;
    job.variance = &variance;
    job.seed = 91;
    const struct pbnds_pathtrace_options options = {.spp = SPP, .max_bounces = 3};
    must(pbnds_pathtrace(&job, &options, &radiance, NULL, &error), &error);
    struct z_test test = {0};
    for (size_t i = 0; i < 3 * PIXELS; ++i) {
        double sum = 0.0;
        for (int k = 0; k < count; ++k)
            sum += (double)irradiance[k] * (double)images[k].data[i];
        /* the pass's own error is not known, but no more than that of the render */
        const double v = (double)variance.data[i];
        z_test_add(&test, 3 * PIXELS, sum, v, (double)radiance.data[i], v);
    }
    print_message("%zu values: %.2f %% agree, greatest |z| %.2f, z of the sum %.2f, "
                  "relative error %.4f\n",
                  test.count, 100.0 * z_test_share(&test), test.greatest,
                  z_test_whole(&test), test.sum_error / test.sum);
    assert_true(test.sum_error / test.sum < 0.05);
    assert_true(z_test_share(&test) >= Z_TEST_ACCEPT);
    assert_true(fabs(z_test_whole(&test)) < 4.0);
    f->scene.lights = NULL;
    f->scene.light_count = 0;
    pbnds_image_free(&radiance);
    pbnds_image_free(&variance);
}

static void they_add_up_to_a_render(bool pane)
{
    struct fixture f;
    struct pbnds_vec3 wi[LIGHTS];
    struct pbnds_image images[LIGHTS];
    static const float IRRADIANCE[LIGHTS] = {2.0f, 5.0f, 0.5f, 1.0f}, ONE[1] = {1.0f};
    room(&f, pane);
    directions(wi);
    trace_olat(&f, 2048, 3, wi, LIGHTS, images);
    judge(&f, wi, LIGHTS, IRRADIANCE, images);
    judge(&f, &wi[1], 1, ONE, &images[1]);
    free_images(images, LIGHTS);
    fixture_free(&f);
}

static void lights_add_up(void **state)
{
    (void)state;
    they_add_up_to_a_render(false);
}

static void lights_through_a_pane_add_up(void **state)
{
    (void)state;
    they_add_up_to_a_render(true);
}

/* A light's picture does not depend on which others are asked along with it. */
static void company_changes_nothing(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_vec3 wi[LIGHTS];
    struct pbnds_image images[LIGHTS], alone;
    room(&f, false);
    directions(wi);
    trace_olat(&f, 16, 4, wi, LIGHTS, images);
    trace_olat(&f, 16, 4, &wi[2], 1, &alone);
    assert_memory_equal(images[2].data, alone.data, 3 * PIXELS * sizeof(float));
    free_images(images, LIGHTS);
    pbnds_image_free(&alone);
    fixture_free(&f);
}

static void threads_and_tiles_change_nothing(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_vec3 wi[LIGHTS];
    struct pbnds_image images[LIGHTS], again[LIGHTS];
    room(&f, true);
    directions(wi);
    trace_olat(&f, 8, 4, wi, LIGHTS, images);
    pbnds_set_threads(3);
    pbnds_set_tile_side(5);
    trace_olat(&f, 8, 4, wi, LIGHTS, again);
    pbnds_set_tile_side(0);
    pbnds_set_threads(0);
    for (int k = 0; k < LIGHTS; ++k)
        assert_memory_equal(images[k].data, again[k].data, 3 * PIXELS * sizeof(float));
    free_images(images, LIGHTS);
    free_images(again, LIGHTS);
    fixture_free(&f);
}

/* The variance is that of pictures of other seeds, or more: it is an estimate from above. */
static void the_variance_is_that_of_other_seeds(void **state)
{
    (void)state;
    enum { SEEDS = 24, SPP = 32 };
    struct fixture f;
    struct pbnds_vec3 wi[LIGHTS];
    double sum[PIXELS] = {0}, square[PIXELS] = {0}, estimate = 0.0, truth = 0.0;
    room(&f, false);
    directions(wi);
    for (int seed = 0; seed < SEEDS; ++seed) {
        struct pbnds_image image, variance;
        struct pbnds_error error;
        const struct pbnds_pathtrace_options options = {.spp = SPP, .max_bounces = 2};
        f.job.seed = (uint64_t)seed;
        must(pbnds_pathtrace_olat(&f.job, &options, &wi[1], 1, &image, &variance,
                                  &error),
             &error);
        for (size_t i = 0; i < PIXELS; ++i) {
            const double x = (double)image.data[3 * i];
            sum[i] += x;
            square[i] += x * x;
            estimate += (double)variance.data[3 * i] / SEEDS;
        }
        pbnds_image_free(&image);
        pbnds_image_free(&variance);
    }
    for (size_t i = 0; i < PIXELS; ++i)
        truth += (square[i] - sum[i] * sum[i] / SEEDS) / (SEEDS - 1);
    print_message("estimated variance / variance: %.3f\n", estimate / truth);
    assert_true(estimate > 0.8 * truth && estimate < 4.0 * truth);
    fixture_free(&f);
}

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    struct pbnds_image images[LIGHTS];
    struct pbnds_vec3 wi[LIGHTS];
    room(&f, false);
    directions(wi);
    struct pbnds_shade_job job = f.job;
    const struct pbnds_pathtrace_options options = {.spp = 1}, negative = {.spp = -1};
    assert_int_equal(pbnds_pathtrace_olat(&job, &options, wi, 0, images, NULL, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_int_equal(pbnds_pathtrace_olat(&job, &options, wi, PBNDS_OLAT_LIGHTS + 1,
                                          images, NULL, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_int_equal(pbnds_pathtrace_olat(&job, &negative, wi, 1, images, NULL, &error),
                     PBNDS_ERROR_ARGUMENT);
    job.scene = NULL;
    assert_int_equal(pbnds_pathtrace_olat(&job, &options, wi, 1, images, NULL, &error),
                     PBNDS_ERROR_ARGUMENT);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lambert_plane_reflects_the_cosine),
        cmocka_unit_test(a_light_round_the_corner_needs_a_bounce),
        cmocka_unit_test(lights_add_up),
        cmocka_unit_test(lights_through_a_pane_add_up),
        cmocka_unit_test(company_changes_nothing),
        cmocka_unit_test(threads_and_tiles_change_nothing),
        cmocka_unit_test(the_variance_is_that_of_other_seeds),
        cmocka_unit_test(bad_arguments_are_refused),
    };
    return cmocka_run_group_tests_name("engine/shade/pathtrace_olat", tests, NULL,
                                       NULL);
}
