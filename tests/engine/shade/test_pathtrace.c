/* The reference path tracer against closed forms, a naive path tracer, and ggx. */
#include "tests/test.h"

#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
#include "engine/shade/bsdf.h"
#include "engine/shade/pathtrace.h"
#include "tests/engine/shade/fixture.h"
#include "tests/engine/shade/lobe.h"

static const struct pbnds_vec3 ZERO = {0.0f, 0.0f, 0.0f};

static void trace(const struct fixture *f, int spp, int bounces,
                  struct pbnds_image *radiance, struct pbnds_image *direct)
{
    struct pbnds_error error;
    const struct pbnds_pathtrace_options options = {.spp = spp, .max_bounces = bounces};
    must(pbnds_pathtrace(&f->job, &options, radiance, direct, &error), &error);
}

static struct pbnds_vec3 eval(const void *b, struct pbnds_vec3 wo, struct pbnds_vec3 wi)
{
    return pbnds_bsdf_eval(b, wo, wi);
}

/* Directional albedo of pixel i's material, red. */
static double albedo_of(const struct fixture *f, size_t i)
{
    const struct pbnds_gbuffer *g = &f->gbuffer;
    const struct pbnds_bsdf bsdf = pbnds_bsdf_from_gbuffer(g, i);
    const struct lobe lobe = {.brdf = &bsdf, .eval = eval, .frame = bsdf.frame};
    const struct pbnds_vec3 wo =
        pbnds_gbuffer_wo(g, (int)(i % (size_t)g->width), (int)(i / (size_t)g->width));
    return quadrature_albedo(&lobe, pbnds_to_local(&bsdf.frame, wo), 128);
}

/* Nothing else is in sight of a convex body: a white furnace shows its albedo, all
 * direct. */
static void a_cube_in_a_furnace_shows_its_albedo(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = matte(1.0f);
    m.roughness = 0.6f;
    m.ior_f0 = 0.04f;
    const struct pbnds_mesh mesh = cube(1.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_light(&f, 8, light_white);
    fixture_view(&f, pbnds_vec3_make(2.0f, 2.5f, 4.0f), ZERO, 9, 9);
    struct pbnds_image radiance, direct;
    trace(&f, 1024, 0, &radiance, &direct);
    int covered = 0;
    for (size_t i = 0; i < 81; ++i) {
        if (!(f.gbuffer.coverage[i] > 0.0f)) {
            assert_near(radiance.data[3 * i], 0.0, 0.0);
            continue;
        }
        ++covered;
        assert_near(radiance.data[3 * i], albedo_of(&f, i), 0.01);
    }
    assert_true(covered > 20);
    assert_memory_equal(radiance.data, direct.data, 81 * 3 * sizeof(float));
    pbnds_image_free(&radiance);
    pbnds_image_free(&direct);
    fixture_free(&f);
}

static void inside_a_glowing_box(struct fixture *f, float albedo, int width, int height)
{
    struct pbnds_material m = matte(albedo);
    m.emissive = pbnds_splat(0.5f);
    const struct pbnds_mesh mesh = cube(1.0f, 0);
    fixture_scene(f, &mesh, 1, &m, 1);
    fixture_view(f, pbnds_vec3_make(0.3f, -0.2f, 0.9f), ZERO, width, height);
}

/* One bounce inside a closed box that glows with e everywhere: e (1 + albedo(wo)),
 * exactly; all of them: e / (1 - albedo) with an albedo between the least and the
 * greatest. */
static void a_glowing_box_adds_up_its_bounces(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_image radiance, direct;
    inside_a_glowing_box(&f, 0.6f, 8, 8);
    trace(&f, 1024, 1, &radiance, &direct);
    double least = 1.0, most = 0.0;
    for (size_t i = 0; i < 64; ++i) {
        const double albedo = albedo_of(&f, i);
        assert_near(f.gbuffer.coverage[i], 1.0, 0.0);
        assert_near(radiance.data[3 * i], 0.5 * (1.0 + albedo), 0.004);
        assert_near(direct.data[3 * i], 0.5, 0.0);
    }
    for (float cos_o = 0.01f; cos_o < 1.0f; cos_o += 0.02f) {
        const struct pbnds_bsdf bsdf = pbnds_bsdf_from_gbuffer(&f.gbuffer, 0);
        const struct lobe lobe = {.brdf = &bsdf, .eval = eval, .frame = bsdf.frame};
        const double albedo = quadrature_albedo(&lobe, direction(cos_o, 0.0f), 64);
        least = fmin(least, albedo);
        most = fmax(most, albedo);
    }
    pbnds_image_free(&radiance);
    pbnds_image_free(&direct);
    trace(&f, 1024, 200, &radiance, NULL);
    const double mean = covered_mean(&f, &radiance, 0);
    assert_true(most - least < 0.1);
    assert_true(mean > 0.5 / (1.0 - least) && mean < 0.5 / (1.0 - most));
    /* what eight bounces leave out is albedo^9 of it */
    pbnds_image_free(&radiance);
    trace(&f, 1024, 0, &radiance, NULL);
    assert_near(covered_mean(&f, &radiance, 0) / mean, 1.0 - pow(0.6, 9.0), 0.003);
    pbnds_image_free(&radiance);
    fixture_free(&f);
}

/* The same integral without map sampling, MIS, strata or roulette: uniform hemispheres.
 */
static struct pbnds_vec3 naive(const struct fixture *f, const struct pbnds_bsdf *bsdf,
                               struct pbnds_vec3 p, struct pbnds_vec3 ng,
                               struct pbnds_vec3 wo, int depth, struct pbnds_rng *rng)
{
    const float z = pbnds_rng_float(rng);
    const struct pbnds_vec3 wi = pbnds_to_world(
        &bsdf->frame, direction(z, 2.0f * PBNDS_PI * pbnds_rng_float(rng)));
    if (pbnds_dot(wi, ng) <= 0.0f) return ZERO;
    const struct pbnds_ray ray = {pbnds_offset_origin(p, ng), wi};
    struct pbnds_hit hit;
    struct pbnds_vec3 light = ZERO;
    pbnds_accel_intersect(f->accel, &ray, &hit);
    if (hit.mesh == UINT32_MAX) {
        if (f->envmap) light = pbnds_envmap_eval(f->envmap, wi);
    } else if (depth > 0) {
        struct pbnds_surface s;
        const struct pbnds_vec3 back = pbnds_scale(wi, -1.0f);
        pbnds_scene_surface(&f->scene, &hit, back, 0.0f, &s);
        const struct pbnds_bsdf next = pbnds_bsdf_from_surface(&s);
        light = pbnds_add(s.emission,
                          naive(f, &next, s.position, s.ng, back, depth - 1, rng));
    }
    return pbnds_scale(pbnds_mul(pbnds_bsdf_eval(bsdf, wo, wi), light),
                       z * 2.0f * PBNDS_PI);
}

/* Balls of matte, gloss and metal on a floor, a glowing tile, a sky with a broad sun.
 */
static void still_life(struct fixture *f, int width, int height)
{
    struct pbnds_material m[4] = {matte(0.7f), matte(0.6f), matte(0.9f), matte(0.2f)};
    m[0].ior_f0 = m[1].ior_f0 = 0.04f;
    m[1].roughness = 0.5f;
    m[1].base_color.y = 0.2f;
    m[2].metallic = 1.0f;
    m[2].roughness = 0.5f;
    m[3].emissive = pbnds_vec3_make(2.0f, 3.0f, 4.0f);
    const struct pbnds_mesh meshes[4] = {
        floor_at(0.0f, 4.0f, 0),
        sphere(pbnds_vec3_make(-0.8f, 0.8f, 0.0f), 0.8f, 12, 1),
        sphere(pbnds_vec3_make(0.8f, 0.7f, 0.2f), 0.7f, 12, 2),
        quad(pbnds_vec3_make(-2.0f, 2.4f, -2.0f), pbnds_vec3_make(4.0f, 0.0f, 0.0f),
             pbnds_vec3_make(0.0f, 0.0f, 4.0f), 3)};
    fixture_scene(f, meshes, 4, m, 4);
    fixture_light(f, 8, light_sunny);
    fixture_view(f, pbnds_vec3_make(0.2f, 1.6f, 4.5f),
                 pbnds_vec3_make(0.0f, 0.7f, 0.0f), width, height);
}

struct mean {
    double sum, square;
    int count;
};

static void add(struct mean *mean, double x)
{
    mean->sum += x;
    mean->square += x * x;
    ++mean->count;
}

/* Mean over one pixel of naive samples, with its standard error. */
static void naive_pixel(const struct fixture *f, size_t i, int depth, int samples,
                        struct mean *mean)
{
    const struct pbnds_gbuffer *g = &f->gbuffer;
    const struct pbnds_bsdf bsdf = pbnds_bsdf_from_gbuffer(g, i);
    const struct pbnds_vec3 p = {g->position[0][i], g->position[1][i],
                                 g->position[2][i]};
    const struct pbnds_vec3 ng = {g->geometric_normal[0][i], g->geometric_normal[1][i],
                                  g->geometric_normal[2][i]};
    const struct pbnds_vec3 wo =
        pbnds_gbuffer_wo(g, (int)(i % (size_t)g->width), (int)(i / (size_t)g->width));
    for (int s = 0; s < samples; ++s) {
        struct pbnds_rng rng = pbnds_rng_make(99, i, (uint64_t)s);
        add(mean,
            (double)(g->emission[0][i] + naive(f, &bsdf, p, ng, wo, depth, &rng).x));
    }
}

/* Five standard errors a pixel, three for the sum of all. A sample of the tracer is
 * taken to be as noisy as a naive one, which it is only for light that it finds by
 * chance. */
static void assert_agrees_with_naive(const struct fixture *f, int bounces)
{
    enum { NAIVE = 8192, TRACED = 4096 };
    struct pbnds_image radiance;
    trace(f, TRACED, bounces, &radiance, NULL);
    double difference = 0.0, variance = 0.0, total = 0.0;
    const size_t n = (size_t)radiance.width * (size_t)radiance.height;
    for (size_t i = 0; i < n; ++i) {
        if (!(f->gbuffer.coverage[i] > 0.0f)) continue;
        struct mean mean = {0};
        naive_pixel(f, i, bounces, NAIVE, &mean);
        const double value = mean.sum / mean.count;
        const double spread = mean.square / mean.count - value * value;
        const double error2 = spread / NAIVE + spread / TRACED;
        assert_near(radiance.data[3 * i], value, 5.0 * sqrt(error2) + 1e-4);
        difference += (double)radiance.data[3 * i] - value;
        variance += error2;
        total += value;
    }
    assert_near(difference, 0.0, 3.0 * sqrt(variance) + 1e-6);
    assert_true(sqrt(variance) < 0.02 * total); /* or else it proves nothing */
    pbnds_image_free(&radiance);
}

/* Nothing rare in it, so that the naive tracer's own estimate of its error holds. */
static struct pbnds_vec3 light_soft(float u, float v)
{
    return pbnds_vec3_make(1.5f + sinf(2.0f * PBNDS_PI * u), 1.0f, 0.2f + v);
}

static void mis_agrees_with_brute_force(void **state)
{
    (void)state;
    struct fixture f;
    still_life(&f, 6, 5);
    fixture_light(&f, 8, light_soft);
    assert_agrees_with_naive(&f, 1);
    assert_agrees_with_naive(&f, 8);
    f.job.envmap = NULL;
    pbnds_envmap_free(f.envmap);
    f.envmap = NULL;
    assert_agrees_with_naive(&f, 3);
    fixture_free(&f);
}

static void direct_agrees_with_ggx(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    struct pbnds_image radiance, direct, ggx;
    still_life(&f, 16, 12);
    trace(&f, 256, 0, &radiance, &direct);
    f.job.spp = 256;
    f.job.seed = 1234;
    must(pbnds_shade(pbnds_shader_find("ggx"), &f.job, &ggx, &error), &error);
    for (int c = 0; c < 3; ++c) {
        const double mean = covered_mean(&f, &direct, c);
        assert_near(covered_mean(&f, &ggx, c), mean, 0.003 * mean);
    }
    double extra = 0.0;
    for (size_t i = 0; i < 16 * 12 * 3; ++i) {
        assert_near(ggx.data[i], direct.data[i], 0.15 * (double)direct.data[i] + 0.02);
        assert_true(radiance.data[i] >= direct.data[i]);
        extra += (double)(radiance.data[i] - direct.data[i]);
    }
    assert_true(extra > 10.0); /* there is light between the surfaces */
    pbnds_image_free(&radiance);
    pbnds_image_free(&direct);
    pbnds_image_free(&ggx);
    fixture_free(&f);
}

/* No ray of a path may slip through an edge or start on the wrong side of a wall. */
static void a_closed_box_keeps_the_sky_out(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_image radiance, direct;
    const struct pbnds_material m = matte(0.8f);
    const struct pbnds_mesh mesh = cube(1.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_light(&f, 8, light_sunny);
    fixture_view(&f, pbnds_vec3_make(0.1f, 0.2f, 0.9f), ZERO, 16, 16);
    trace(&f, 64, 0, &radiance, &direct);
    for (size_t i = 0; i < 16 * 16 * 3; ++i) {
        assert_near(radiance.data[i], 0.0, 0.0);
        assert_near(direct.data[i], 0.0, 0.0);
    }
    pbnds_image_free(&radiance);
    pbnds_image_free(&direct);
    fixture_free(&f);
}

static void no_light_is_exactly_black(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_image radiance, direct;
    still_life(&f, 8, 6);
    f.scene.materials[3].emissive = ZERO;
    fixture_light(&f, 8, light_black);
    pbnds_gbuffer_free(&f.gbuffer);
    fixture_view(&f, pbnds_vec3_make(0.2f, 1.6f, 4.5f),
                 pbnds_vec3_make(0.0f, 0.7f, 0.0f), 8, 6);
    for (int without = 0; without < 2; ++without) {
        if (without) f.job.envmap = NULL;
        trace(&f, 16, 0, &radiance, &direct);
        for (size_t i = 0; i < 8 * 6 * 3; ++i) {
            assert_near(radiance.data[i], 0.0, 0.0);
            assert_near(direct.data[i], 0.0, 0.0);
        }
        pbnds_image_free(&radiance);
        pbnds_image_free(&direct);
    }
    fixture_free(&f);
}

static struct pbnds_vec3 light_double(float u, float v)
{
    return pbnds_scale(light_sunny(u, v), 2.0f);
}

/* Twice the light is twice the radiance: the same paths, each of twice the weight. */
static void radiance_is_linear_in_light(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_image one, two;
    still_life(&f, 8, 6);
    f.scene.materials[3].emissive = ZERO;
    pbnds_gbuffer_free(&f.gbuffer);
    fixture_view(&f, pbnds_vec3_make(0.2f, 1.6f, 4.5f),
                 pbnds_vec3_make(0.0f, 0.7f, 0.0f), 8, 6);
    trace(&f, 16, 0, &one, NULL);
    fixture_light(&f, 8, light_double);
    trace(&f, 16, 0, &two, NULL);
    for (size_t i = 0; i < 8 * 6 * 3; ++i)
        assert_near(two.data[i], 2.0f * one.data[i], 2e-5 * (double)two.data[i]);
    pbnds_image_free(&one);
    pbnds_image_free(&two);
    fixture_free(&f);
}

static void threads_do_not_matter_and_the_seed_does(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_image one, one_direct, other, other_direct;
    still_life(&f, 37, 21);
    const size_t size = 37 * 21 * 3 * sizeof(float);
    const int threads[] = {2, 5};
    pbnds_set_threads(1);
    trace(&f, 7, 0, &one, &one_direct);
    for (int t = 0; t < 2; ++t) {
        pbnds_set_threads(threads[t]);
        trace(&f, 7, 0, &other, &other_direct);
        assert_memory_equal(one.data, other.data, size);
        assert_memory_equal(one_direct.data, other_direct.data, size);
        pbnds_image_free(&other);
        pbnds_image_free(&other_direct);
    }
    f.job.seed = 8;
    trace(&f, 7, 0, &other, NULL);
    assert_memory_not_equal(one.data, other.data, size);
    pbnds_image_free(&other);
    pbnds_image_free(&one);
    pbnds_image_free(&one_direct);
    fixture_free(&f);
}

/* Root mean square difference between two estimates of `spp`, of the same scene. */
static double noise(struct fixture *f, int spp)
{
    struct pbnds_image a, b;
    double sum = 0.0;
    f->job.seed = 1;
    trace(f, spp, 0, &a, NULL);
    f->job.seed = 2;
    trace(f, spp, 0, &b, NULL);
    const size_t n = (size_t)a.width * (size_t)a.height * 3;
    for (size_t i = 0; i < n; ++i)
        sum += (double)(a.data[i] - b.data[i]) * (double)(a.data[i] - b.data[i]);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    return sqrt(sum / (double)n);
}

/* Independent samples would halve the noise where there are four times as many. */
static void strata_beat_independent_samples(void **state)
{
    (void)state;
    struct fixture f;
    const struct pbnds_material m = matte(0.8f);
    const struct pbnds_mesh mesh = cube(1.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_light(&f, 16, light_sunny);
    fixture_view(&f, pbnds_vec3_make(2.0f, 2.5f, 4.0f), ZERO, 24, 24);
    assert_true(noise(&f, 64) < 0.35 * noise(&f, 16));
    fixture_free(&f);
}

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    struct pbnds_image radiance, direct;
    struct pbnds_pathtrace_options options = {.spp = 4};
    still_life(&f, 4, 3);
    struct pbnds_shade_job job = f.job;
    job.scene = NULL;
    job.accel = NULL;
    assert_int_equal(pbnds_pathtrace(&job, &options, &radiance, &direct, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "needs the scene"));
    assert_null(radiance.data);
    assert_null(direct.data);
    options.spp = -1;
    assert_int_equal(pbnds_pathtrace(&f.job, &options, &radiance, NULL, &error),
                     PBNDS_ERROR_ARGUMENT);
    options.spp = 1;
    options.max_bounces = -1;
    assert_int_equal(pbnds_pathtrace(&f.job, &options, &radiance, NULL, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_null(radiance.data);
    fixture_free(&f);
}

static void stop_at_once(void *user, const char *stage, double done, double total)
{
    (void)user, (void)stage, (void)done, (void)total;
    pbnds_request_stop();
}

/* Last, because the flag cannot be lowered. */
static void a_stop_ends_the_call_with_nothing(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    struct pbnds_image radiance, direct;
    const struct pbnds_report report = {.progress = stop_at_once};
    const struct pbnds_pathtrace_options options = {.spp = 4};
    still_life(&f, 40, 30);
    pbnds_set_threads(
        1); /* others could finish before the caller's has its first tile */
    f.job.report = &report;
    assert_int_equal(pbnds_pathtrace(&f.job, &options, &radiance, &direct, &error),
                     PBNDS_ERROR_INTERRUPTED);
    assert_null(radiance.data);
    assert_null(direct.data);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cube_in_a_furnace_shows_its_albedo),
        cmocka_unit_test(a_glowing_box_adds_up_its_bounces),
        cmocka_unit_test(mis_agrees_with_brute_force),
        cmocka_unit_test(direct_agrees_with_ggx),
        cmocka_unit_test(a_closed_box_keeps_the_sky_out),
        cmocka_unit_test(no_light_is_exactly_black),
        cmocka_unit_test(radiance_is_linear_in_light),
        cmocka_unit_test(threads_do_not_matter_and_the_seed_does),
        cmocka_unit_test(strata_beat_independent_samples),
        cmocka_unit_test(bad_arguments_are_refused),
        cmocka_unit_test(a_stop_ends_the_call_with_nothing),
    };
    return cmocka_run_group_tests_name("engine/shade/pathtrace", tests, NULL, NULL);
}
