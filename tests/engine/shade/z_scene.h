/* What the Z-tests share: the comparison of one scene's picture by the reference with that
 * of the naive path tracer, value by value. */
#ifndef PBNDS_TESTS_ENGINE_SHADE_Z_SCENE_H
#define PBNDS_TESTS_ENGINE_SHADE_Z_SCENE_H

#include "tests/engine/shade/fixture.h"
#include "tests/reference/brute_force.h"
#include "tests/reference/z_test.h"

struct z_scene {
    struct fixture f;
    struct brute brute;
    int naive_samples, spp;
    double
        most_error; /* mean relative standard error: a test with more proves little */
};

static inline void z_scene_sky(struct z_scene *z, int rows,
                               struct pbnds_vec3 (*sky)(float u, float v))
{
    fixture_light(&z->f, rows, sky);
    z->brute.sky = sky;
    z->brute.sky_rows = rows;
}

/* Traces both, and judges each channel of each pixel and their sum. */
static inline void z_scene_check(struct z_scene *z, int bounces)
{
    struct fixture *f = &z->f;
    struct pbnds_image radiance, variance, alpha;
    struct pbnds_error error;
    const struct pbnds_pathtrace_options options = {.spp = z->spp,
                                                    .max_bounces = bounces};
    struct pbnds_shade_job job = f->job;
    job.variance = &variance;
    job.alpha = &alpha;
    must(pbnds_pathtrace(&job, &options, &radiance, NULL, &error), &error);
    z->brute.scene = &f->scene;
    z->brute.max_bounces = bounces;
    const struct pbnds_gbuffer *g = &f->gbuffer;
    const size_t pixels = (size_t)g->width * (size_t)g->height;
    struct z_test test = {0};
    for (size_t i = 0; i < pixels; ++i) {
        double mean[3], var[3];
        const struct pbnds_ray ray = pbnds_camera_ray(
            &g->camera, g->width, g->height, (float)(i % (size_t)g->width) + 0.5f,
            (float)(i / (size_t)g->width) + 0.5f);
        brute_pixel(&z->brute, &ray, i, z->naive_samples, mean, var);
        const double covered = alpha.data ? (double)alpha.data[i] : 1.0;
        for (size_t c = 0; c < 3; ++c) {
            const double value = covered * (double)radiance.data[3 * i + c];
            z_test_add(&test, 3 * pixels, value, (double)variance.data[3 * i + c],
                       mean[c], var[c]);
        }
    }
    pbnds_image_free(&radiance);
    pbnds_image_free(&variance);
    pbnds_image_free(&alpha);
    const double relative = test.sum_error / test.sum, whole = z_test_whole(&test);
    print_message("%zu values: %.2f %% agree, greatest |z| %.2f, z of the sum %.2f, "
                  "relative error %.4f\n",
                  test.count, 100.0 * z_test_share(&test), test.greatest, whole,
                  relative);
    assert_true(relative < z->most_error);
    assert_true(z_test_share(&test) >= Z_TEST_ACCEPT);
    assert_true(fabs(whole) < 4.0);
}

/* Nothing rare in it: uniform samples must find it. */
static inline struct pbnds_vec3 z_soft_sky(float u, float v)
{
    return pbnds_vec3_make(0.6f + 0.5f * sinf(2.0f * PBNDS_PI * u), 0.5f,
                           0.2f + 0.6f * v);
}
#endif
