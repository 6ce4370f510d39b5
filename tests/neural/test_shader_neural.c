/* The neural shading passes with random weights: what must hold whatever was learned.
 */
#include "tests/neural/fixture.h"

#include <stdio.h>
#include <unistd.h>

#include "engine/core/parallel.h"
#include "engine/shade/shader.h"
#include "neural/model/model.h"
#include "neural/shader_neural.h"

static const char *write_random_weights(const char *model_name)
{
    static char path[64];
    (void)snprintf(path, sizeof path, "test_shader_%d_%s.safetensors", (int)getpid(),
                   model_name);
    const struct pbnds_model *model = pbnds_model_find(model_name);
    assert_non_null(model);
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    assert_int_equal(pbnds_backend_create_onednn(&backend, NULL), PBNDS_OK);
    assert_int_equal(pbnds_net_create(&model->table, backend, PBNDS_F32, &net, NULL),
                     PBNDS_OK);
    pbnds_net_init(net, 7);
    assert_int_equal(pbnds_weights_save(path, model, net, NULL, 0, NULL), PBNDS_OK);
    pbnds_net_free(net);
    pbnds_backend_free(backend);
    return path;
}

static const struct pbnds_shader *make_shader(const char *model, enum pbnds_dtype dtype)
{
    const char *path = write_random_weights(model);
    const struct pbnds_shader *shader;
    struct pbnds_error error = {{0}};
    const enum pbnds_status status =
        pbnds_shader_neural_create(path, dtype, &shader, &error);
    (void)unlink(path);
    if (status != PBNDS_OK) fail_msg("%s", error.message);
    assert_string_equal(shader->ops->name, model);
    return shader;
}

static struct pbnds_image shade(const struct pbnds_shader *shader,
                                const struct pbnds_gbuffer *g,
                                const struct pbnds_envmap *env, int lights,
                                size_t memory)
{
    const struct pbnds_shade_job job = {.gbuffer = g,
                                        .envmap = env,
                                        .seed = 1,
                                        .lights = lights,
                                        .shadows = -1,
                                        .max_memory = memory};
    struct pbnds_image image;
    struct pbnds_error error = {{0}};
    if (pbnds_shade(shader, &job, &image, &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
    return image;
}

static double largest(const struct pbnds_image *image)
{
    double most = 0.0;
    const size_t n = (size_t)image->width * (size_t)image->height * 3;
    for (size_t i = 0; i < n; ++i) {
        assert_true(isfinite(image->data[i]));
        most = fmax(most, fabs((double)image->data[i]));
    }
    return most;
}

static double difference(const struct pbnds_image *a, const struct pbnds_image *b,
                         double scale)
{
    double most = 0.0;
    const size_t n = (size_t)a->width * (size_t)a->height * 3;
    for (size_t i = 0; i < n; ++i) {
        most = fmax(most, fabs((double)a->data[i] - scale * (double)b->data[i]));
    }
    return most;
}

static void transport_of_no_light_is_exactly_zero(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(37, 50); /* no multiple of 16 */
    struct pbnds_envmap *black = fixture_env(0.0f, 1);
    for (int dtype = PBNDS_F32; dtype <= PBNDS_BF16; ++dtype) {
        if (dtype == PBNDS_BF16 && !pbnds_backend_has_fast_bf16()) continue;
        const struct pbnds_shader *s =
            make_shader("transport", (enum pbnds_dtype)dtype);
        struct pbnds_image a = shade(s, &g, black, 0, 0), b = shade(s, &g, NULL, 0, 0);
        assert_true(largest(&a) == 0.0);
        assert_true(largest(&b) == 0.0);
        pbnds_image_free(&a);
        pbnds_image_free(&b);
        pbnds_shader_neural_free(s);
    }
    pbnds_envmap_free(black);
    pbnds_gbuffer_free(&g);
}

/* Lights of the file come on top of whatever the network says, as ggx shades them. */
static void lights_of_the_file_are_added(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(37, 50);
    for (int c = 0; c < 3; ++c)
        g.emission[c][20 * 37 + 18] = 0.25f;
    struct pbnds_envmap *env = fixture_env(1.0f, 5);
    struct pbnds_light sun = {.kind = PBNDS_LIGHT_DIRECTIONAL,
                              .direction = {0.0f, -0.6f, -0.8f},
                              .intensity = {12.0f, 8.0f, 4.0f},
                              .range = INFINITY};
    const struct pbnds_scene scene = {.lights = &sun, .light_count = 1};
    static const char *const models[] = {"transport", "pbnds+"};
    for (int m = 0; m < 2; ++m) {
        const struct pbnds_shader *s = make_shader(models[m], PBNDS_F32);
        struct pbnds_image map = shade(s, &g, env, 4, 0), both, lit;
        struct pbnds_shade_job job = {.gbuffer = &g,
                                      .envmap = env,
                                      .scene = &scene,
                                      .seed = 1,
                                      .lights = 4,
                                      .shadows = -1};
        assert_int_equal(pbnds_shade(s, &job, &both, NULL), PBNDS_OK);
        job.envmap = NULL;
        assert_int_equal(pbnds_shade(pbnds_shader_find("ggx"), &job, &lit, NULL),
                         PBNDS_OK);
        assert_true(largest(&lit) > 0.5);
        for (size_t i = 0; i < (size_t)37 * 50; ++i) {
            for (size_t c = 0; c < 3; ++c) {
                const double want = (double)map.data[3 * i + c] +
                                    (double)lit.data[3 * i + c] -
                                    (double)g.emission[c][i];
                assert_near(both.data[3 * i + c], want, 1e-5 * (1.0 + fabs(want)));
            }
        }
        pbnds_image_free(&map);
        pbnds_image_free(&both);
        pbnds_image_free(&lit);
        pbnds_shader_neural_free(s);
    }
    pbnds_envmap_free(env);
    pbnds_gbuffer_free(&g);
}

static void transport_scales_with_the_light(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(37, 50);
    struct pbnds_envmap *one = fixture_env(1.0f, 5), *many = fixture_env(64.0f, 5);
    const struct pbnds_shader *s = make_shader("transport", PBNDS_F32);
    struct pbnds_image a = shade(s, &g, one, 24, 0), b = shade(s, &g, many, 24, 0);
    assert_true(largest(&a) > 0.05);
    assert_true(difference(&b, &a, 64.0) <= 1e-5 * largest(&b));
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_shader_neural_free(s);
    pbnds_envmap_free(one);
    pbnds_envmap_free(many);
    pbnds_gbuffer_free(&g);
}

/* Memory for both lights at once in one window, or for one light at a time in several
 * windows: one picture, bit for bit. */
static void tiles_and_chunks_do_not_matter(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(197, 106);
    struct pbnds_envmap *env = fixture_env(1.0f, 9);
    static const char *const MODELS[] = {"transport", "pbnds+"};
    static const size_t MEMORY[] = {1, (size_t)32 << 20};
    for (int m = 0; m < 4; ++m) {
        const enum pbnds_dtype dtype = m < 2 ? PBNDS_F32 : PBNDS_BF16;
        if (dtype == PBNDS_BF16 && !pbnds_backend_has_fast_bf16()) continue;
        const struct pbnds_shader *s = make_shader(MODELS[m % 2], dtype);
        struct pbnds_image whole = shade(s, &g, env, 2, 0);
        struct pbnds_image tiled = shade(s, &g, env, 2, MEMORY[m % 2]);
        assert_true(largest(&whole) > 0.0);
        assert_true(difference(&whole, &tiled, 1.0) == 0.0);
        pbnds_image_free(&tiled);
        pbnds_image_free(&whole);
        pbnds_shader_neural_free(s);
    }
    pbnds_envmap_free(env);
    pbnds_gbuffer_free(&g);
}

static void any_size_is_shaded(void **state)
{
    (void)state;
    static const int SIZES[][2] = {{1, 1}, {3, 2}, {5, 90}, {200, 1}};
    struct pbnds_envmap *env = fixture_env(1.0f, 9);
    static const char *const MODELS[] = {"transport", "pbnds+"};
    for (int m = 0; m < 2; ++m) {
        const struct pbnds_shader *s = make_shader(MODELS[m], PBNDS_F32);
        for (size_t k = 0; k < sizeof SIZES / sizeof *SIZES; ++k) {
            struct pbnds_gbuffer g;
            assert_int_equal(pbnds_gbuffer_init(&g, SIZES[k][0], SIZES[k][1], NULL),
                             PBNDS_OK);
            g.camera = fixture_camera();
            for (int y = 0; y < g.height; ++y) {
                for (int x = 0; x < g.width; ++x)
                    fixture_pixel(&g, x, y, 2.0f, pbnds_vec3_make(0.0f, 0.0f, 1.0f));
            }
            struct pbnds_image image = shade(s, &g, env, 3, 0);
            assert_true(largest(&image) >= 0.0); /* finite */
            assert_true(m == 1 || largest(&image) > 0.0);
            pbnds_image_free(&image);
            pbnds_gbuffer_free(&g);
        }
        pbnds_shader_neural_free(s);
    }
    pbnds_envmap_free(env);
}

static void uncovered_pixels_stay_black_and_emission_is_exact(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(32, 32);
    const size_t lamp = 16 * 32 + 16;
    struct pbnds_envmap *env = fixture_env(1.0f, 2);
    static const char *const models[] = {"transport", "pbnds+"};
    for (int m = 0; m < 2; ++m) {
        const struct pbnds_shader *s = make_shader(models[m], PBNDS_F32);
        g.emission[1][lamp] = 0.0f;
        struct pbnds_image without = shade(s, &g, env, 0, 0);
        g.emission[1][lamp] = 7.5f;
        struct pbnds_image with = shade(s, &g, env, 0, 0),
                           dark = shade(s, &g, NULL, 0, 0);
        for (size_t i = 0; i < 32u * 32u; ++i) {
            if (g.coverage[i] > 0.0f) continue;
            assert_true(with.data[3 * i] == 0.0f && with.data[3 * i + 1] == 0.0f);
        }
        const double added =
            (double)with.data[3 * lamp + 1] - (double)without.data[3 * lamp + 1];
        assert_near(added, 7.5, 1e-5);
        if (m == 0) assert_near((double)dark.data[3 * lamp + 1], 7.5, 0.0);
        pbnds_image_free(&without);
        pbnds_image_free(&with);
        pbnds_image_free(&dark);
        pbnds_shader_neural_free(s);
    }
    pbnds_envmap_free(env);
    pbnds_gbuffer_free(&g);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(32, 48);
    struct pbnds_envmap *env = fixture_env(1.0f, 4);
    static const char *const MODELS[] = {"transport", "pbnds+"};
    for (int m = 0; m < 4; ++m) {
        const enum pbnds_dtype dtype = m < 2 ? PBNDS_F32 : PBNDS_BF16;
        if (dtype == PBNDS_BF16 && !pbnds_backend_has_fast_bf16()) continue;
        struct pbnds_image image[2];
        for (int k = 0; k < 2; ++k) {
            pbnds_set_threads(1 + k);
            const struct pbnds_shader *s = make_shader(MODELS[m % 2], dtype);
            image[k] = shade(s, &g, env, 12, 0);
            pbnds_shader_neural_free(s);
        }
        assert_true(difference(&image[0], &image[1], 1.0) == 0.0);
        pbnds_image_free(&image[0]);
        pbnds_image_free(&image[1]);
    }
    pbnds_set_threads(0);
    pbnds_envmap_free(env);
    pbnds_gbuffer_free(&g);
}

static void damaged_weights_are_refused(void **state)
{
    (void)state;
    const char *path = write_random_weights("transport");
    struct pbnds_error error = {{0}};
    const struct pbnds_shader *s;
    assert_int_equal(truncate(path, 5000), 0);
    assert_int_equal(pbnds_shader_neural_create(path, PBNDS_F32, &s, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, path));
    assert_null(s);
    (void)unlink(path);
    assert_int_equal(pbnds_shader_neural_create(path, PBNDS_F32, &s, &error),
                     PBNDS_ERROR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transport_of_no_light_is_exactly_zero),
        cmocka_unit_test(lights_of_the_file_are_added),
        cmocka_unit_test(transport_scales_with_the_light),
        cmocka_unit_test(tiles_and_chunks_do_not_matter),
        cmocka_unit_test(any_size_is_shaded),
        cmocka_unit_test(uncovered_pixels_stay_black_and_emission_is_exact),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(damaged_weights_are_refused),
    };
    return cmocka_run_group_tests_name("neural/shader_neural", tests, NULL, NULL);
}
