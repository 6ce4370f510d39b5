/* The a-trous filter: what it smooths, what it must leave alone. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
#include "neural/data/atrous.h"

enum { SIDE = 48, PIXELS = SIDE * SIDE };

/* A white plane seen from above, all in one depth; its right half may face elsewhere. */
static void plane(struct pbnds_gbuffer *g, bool bent)
{
    assert_int_equal(pbnds_gbuffer_init(g, SIDE, SIDE, NULL), PBNDS_OK);
    g->camera.world_from_camera = pbnds_mat4_identity();
    g->camera.yfov = 1.0f;
    g->samples = 1;
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            const size_t i = (size_t)(y * SIDE + x);
            const bool right = bent && x >= SIDE / 2;
            for (int c = 0; c < 3; ++c)
                g->albedo[c][i] = 0.8f;
            g->normal[0][i] = g->geometric_normal[0][i] = right ? 0.8f : 0.0f;
            g->normal[2][i] = g->geometric_normal[2][i] = right ? 0.6f : 1.0f;
            g->position[0][i] = 0.02f * (float)x;
            g->position[1][i] = 0.02f * (float)(SIDE - y);
            g->position[2][i] = -1.0f;
            g->depth[i] = g->coverage[i] = g->roughness[i] = 1.0f;
            g->specular[i] = 0.04f;
        }
    }
}

static void image(struct pbnds_image *out)
{
    assert_int_equal(pbnds_image_init(out, SIDE, SIDE, 3, NULL), PBNDS_OK);
}

static void fill(struct pbnds_image *out, float value)
{
    for (size_t i = 0; i < 3 * PIXELS; ++i)
        out->data[i] = value;
}

/* Uniform noise of the given half width about what is there, the same in all channels. */
static void add_noise(struct pbnds_image *out, float width)
{
    struct pbnds_rng rng = pbnds_rng_make(4, 0, 0);
    for (size_t i = 0; i < PIXELS; ++i) {
        const float d = width * (2.0f * pbnds_rng_float(&rng) - 1.0f);
        for (size_t c = 0; c < 3; ++c)
            out->data[3 * i + c] += d;
    }
}

static void filter(const struct pbnds_gbuffer *g, const struct pbnds_image *variance,
                   struct pbnds_image *a, struct pbnds_image *b)
{
    struct pbnds_image *const images[2] = {a, b};
    struct pbnds_error error = {{0}};
    if (pbnds_atrous(g, variance, images, b ? 2 : 1, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
}

static double spread(const struct pbnds_image *a, double about)
{
    double sum = 0.0;
    for (size_t i = 0; i < PIXELS; ++i) {
        const double d = (double)a->data[3 * i] - about;
        sum += d * d / PIXELS;
    }
    return sum;
}

static void noise_goes_and_the_mean_stays(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_image a, variance;
    plane(&g, false);
    image(&a);
    image(&variance);
    fill(&a, 1.0f);
    add_noise(&a, 0.3f);
    fill(&variance, 0.03f); /* 0.3^2 / 3 */
    const double before = spread(&a, 1.0);
    filter(&g, &variance, &a, NULL);
    double mean = 0.0;
    for (size_t i = 0; i < PIXELS; ++i)
        mean += (double)a.data[3 * i] / PIXELS;
    print_message("spread %.5f, then %.5f; mean %.4f\n", before, spread(&a, 1.0), mean);
    assert_true(spread(&a, 1.0) < before / 5.0);
    assert_near(mean, 1.0, 0.01);
    pbnds_image_free(&a);
    pbnds_image_free(&variance);
    pbnds_gbuffer_free(&g);
}

/* A shadow that the estimate is sure of is no noise. */
static void a_sure_edge_stays(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_image a, variance;
    plane(&g, false);
    image(&a);
    image(&variance);
    fill(&variance, 1e-6f);
    for (size_t i = 0; i < 3 * PIXELS; ++i)
        a.data[i] = i / 3 % SIDE < 20 ? 0.1f : 1.0f;
    filter(&g, &variance, &a, NULL);
    for (size_t i = 0; i < 3 * PIXELS; ++i)
        assert_near(a.data[i], i / 3 % SIDE < 20 ? 0.1 : 1.0, 1e-4);
    pbnds_image_free(&a);
    pbnds_image_free(&variance);
    pbnds_gbuffer_free(&g);
}

/* Where the surface turns, light does not cross, however noisy it is. */
static void light_does_not_cross_a_crease(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_image a, variance;
    plane(&g, true);
    image(&a);
    image(&variance);
    fill(&variance, 10.0f);
    for (size_t i = 0; i < 3 * PIXELS; ++i)
        a.data[i] = i / 3 % SIDE < SIDE / 2 ? 0.5f : 1.0f;
    filter(&g, &variance, &a, NULL);
    for (size_t i = 0; i < 3 * PIXELS; ++i)
        assert_near(a.data[i], i / 3 % SIDE < SIDE / 2 ? 0.5 : 1.0, 1e-3);
    pbnds_image_free(&a);
    pbnds_image_free(&variance);
    pbnds_gbuffer_free(&g);
}

/* A texture is divided out, so it comes back sharp from the noisiest light. */
static void textures_stay(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_image a, variance;
    plane(&g, false);
    image(&a);
    image(&variance);
    fill(&variance, 10.0f);
    for (size_t i = 0; i < PIXELS; ++i) {
        g.specular[i] = 0.0f;
        for (size_t c = 0; c < 3; ++c) {
            g.albedo[c][i] = (i * (c + 3)) % 7 < 3 ? 0.2f : 0.9f;
            a.data[3 * i + c] = 2.0f * g.albedo[c][i];
        }
    }
    filter(&g, &variance, &a, NULL);
    for (size_t i = 0; i < PIXELS; ++i) {
        for (size_t c = 0; c < 3; ++c)
            assert_near(a.data[3 * i + c], 2.0 * (double)g.albedo[c][i], 1e-4);
    }
    pbnds_image_free(&a);
    pbnds_image_free(&variance);
    pbnds_gbuffer_free(&g);
}

/* All images by the weights of the first: parts of a sum stay parts of it. Pixels without
 * a surface are not looked at, and threads change nothing. */
static void sums_stay_sums(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_image all, part, rest, again, variance;
    plane(&g, true);
    image(&all), image(&part), image(&rest), image(&again), image(&variance);
    fill(&part, 1.0f);
    add_noise(&part, 0.5f);
    for (size_t i = 0; i < 3 * PIXELS; ++i) {
        rest.data[i] = 0.3f + 0.2f * sinf(0.01f * (float)i);
        all.data[i] = part.data[i] + rest.data[i];
        variance.data[i] = 0.05f;
    }
    g.coverage[77] = 0.0f;
    g.depth[77] = INFINITY;
    part.data[3 * 77] = 123.0f;
    memcpy(again.data, all.data, 3 * PIXELS * sizeof *all.data);
    filter(&g, &variance, &all, &part);
    pbnds_set_threads(3);
    filter(&g, &variance, &again, &rest);
    pbnds_set_threads(0);
    assert_memory_equal(again.data, all.data, 3 * PIXELS * sizeof *all.data);
    assert_true(part.data[3 * 77] == 123.0f);
    for (size_t i = 0; i < 3 * PIXELS; ++i)
        if (i / 3 != 77) assert_near(all.data[i], part.data[i] + rest.data[i], 1e-4);
    pbnds_image_free(&all);
    pbnds_image_free(&part);
    pbnds_image_free(&rest);
    pbnds_image_free(&again);
    pbnds_image_free(&variance);
    pbnds_gbuffer_free(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_goes_and_the_mean_stays),
        cmocka_unit_test(a_sure_edge_stays),
        cmocka_unit_test(light_does_not_cross_a_crease),
        cmocka_unit_test(textures_stay),
        cmocka_unit_test(sums_stay_sums),
    };
    return cmocka_run_group_tests_name("neural/data/atrous", tests, NULL, NULL);
}
