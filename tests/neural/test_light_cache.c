/* neural/light_cache.c: against the transport pass itself, under lights whose projection
 * is known; the file, and what is wrong with files. */
#include "tests/neural/fixture.h"

#include <stdio.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "neural/light_cache.h"
#include "neural/model/model.h"
#include "neural/shader_neural.h"

enum { N = 12, WIDTH = 50, HEIGHT = 40 };

static const struct pbnds_shader *make_shader(const char *name, uint64_t seed)
{
    static char path[64];
    (void)snprintf(path, sizeof path, "test_cache_%d.safetensors", (int)getpid());
    const struct pbnds_model *model = pbnds_model_find(name);
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    const struct pbnds_shader *shader;
    assert_int_equal(pbnds_backend_create_onednn(&backend, NULL), PBNDS_OK);
    assert_int_equal(pbnds_net_create(&model->table, backend, PBNDS_F32, &net, NULL),
                     PBNDS_OK);
    pbnds_net_init(net, seed);
    assert_int_equal(pbnds_weights_save(path, model, net, NULL, 0, NULL), PBNDS_OK);
    pbnds_net_free(net);
    pbnds_backend_free(backend);
    assert_int_equal(pbnds_shader_neural_create(path, PBNDS_F32, &shader, NULL),
                     PBNDS_OK);
    (void)unlink(path);
    return shader;
}

static struct pbnds_light_cache make_cache(const struct pbnds_shader *shader,
                                           const struct pbnds_gbuffer *g,
                                           int directions, size_t memory)
{
    const struct pbnds_shade_job job = {
        .gbuffer = g, .shadows = -1, .max_memory = memory};
    struct pbnds_light_cache cache;
    struct pbnds_error error = {{0}};
    if (pbnds_light_cache_make(shader, &job, directions, &cache, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    return cache;
}

/* All light from around direction j: a lamp of one texel of a fine map. */
static struct pbnds_envmap *lamp_at(struct pbnds_vec3 w, float irradiance)
{
    enum { W = 512, H = 256 };
    struct pbnds_image image;
    struct pbnds_envmap *env;
    assert_int_equal(pbnds_image_init(&image, W, H, 3, NULL), PBNDS_OK);
    const float u = 0.5f + atan2f(w.z, w.x) / (2.0f * PBNDS_PI),
                v = acosf(w.y) / PBNDS_PI;
    const int x = (int)(u * W) % W, y = (int)(v * H);
    const float solid_angle =
        2.0f * PBNDS_PI / W *
        (cosf(PBNDS_PI * (float)y / H) - cosf(PBNDS_PI * (float)(y + 1) / H));
    for (int c = 0; c < 3; ++c)
        pbnds_image_at(&image, x, y)[c] = irradiance / solid_angle;
    assert_int_equal(
        pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, NULL), PBNDS_OK);
    pbnds_image_free(&image);
    return env;
}

static void projection_keeps_energy_and_place(void **state)
{
    (void)state;
    struct pbnds_vec3 e[64];
    struct pbnds_envmap *env = fixture_env(1.0f, 3);
    assert_int_equal(pbnds_light_cache_project(env, 64, e, NULL), PBNDS_OK);
    struct pbnds_vec3 sum = pbnds_splat(0.0f);
    for (int j = 0; j < 64; ++j) {
        assert_true(e[j].x >= 0.0f);
        sum = pbnds_add(sum, e[j]);
    }
    const struct pbnds_vec3 mean = pbnds_envmap_mean(env);
    assert_near((double)sum.x, 4.0 * M_PI * (double)mean.x, 2e-3 * (double)sum.x);
    assert_near((double)sum.z, 4.0 * M_PI * (double)mean.z, 2e-3 * (double)sum.z);
    pbnds_envmap_free(env);
    for (int j = 3; j < 64; j += 20) {
        env = lamp_at(pbnds_light_cache_direction(j, 64), 2.0f);
        assert_int_equal(pbnds_light_cache_project(env, 64, e, NULL), PBNDS_OK);
        assert_true(e[j].y > 1.6f);
        pbnds_envmap_free(env);
    }
    assert_int_equal(pbnds_light_cache_project(NULL, 64, e, NULL), PBNDS_OK);
    assert_true(e[5].x == 0.0f);
}

static struct pbnds_image relight(const struct pbnds_light_cache *cache,
                                  const struct pbnds_gbuffer *g,
                                  const struct pbnds_envmap *env)
{
    const struct pbnds_shade_job job = {.gbuffer = g, .envmap = env, .shadows = -1};
    struct pbnds_image image;
    assert_int_equal(pbnds_light_cache_shade(cache, &job, &image, NULL), PBNDS_OK);
    return image;
}

/* One lamp in each direction of the lattice: their sum is what each is given alone. With
 * the projected irradiance as clusters the transport pass gives the same picture, but for
 * 8 bits a direction and, where the lobe is narrow, four looks in place of 24. */
static void a_lamp_gives_what_the_network_says(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(WIDTH, HEIGHT);
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i)
        g.roughness[i] = 0.7f; /* no narrow lobe */
    g.emission[2][20 * WIDTH + 25] = 3.0f;
    const struct pbnds_shader *shader = make_shader("transport", 4);
    struct pbnds_light_cache cache = make_cache(shader, &g, N, 0);
    assert_int_equal(cache.glossy, 0);
    const struct pbnds_vec3 w = pbnds_light_cache_direction(4, N);
    struct pbnds_envmap *env = lamp_at(w, 2.0f);
    struct pbnds_vec3 e[N];
    assert_int_equal(pbnds_light_cache_project(env, N, e, NULL), PBNDS_OK);
    struct pbnds_image cached = relight(&cache, &g, env);
    double *want = calloc(WIDTH * HEIGHT * 3, sizeof *want), most = 0.0;
    for (int j = 0; j < N; ++j) {
        if (!(e[j].x > 0.0f)) continue;
        /* a map with that lamp alone is one cluster */
        struct pbnds_envmap *alone = lamp_at(pbnds_light_cache_direction(j, N), e[j].x);
        const struct pbnds_shade_job job = {
            .gbuffer = &g, .envmap = alone, .shadows = -1, .lights = 1};
        struct pbnds_image one;
        assert_int_equal(pbnds_shade(shader, &job, &one, NULL), PBNDS_OK);
        for (size_t i = 0; i < WIDTH * HEIGHT * 3; ++i) {
            want[i] += (double)one.data[i] - (double)g.emission[i % 3][i / 3];
        }
        pbnds_image_free(&one);
        pbnds_envmap_free(alone);
    }
    for (size_t i = 0; i < WIDTH * HEIGHT * 3; ++i)
        most = fmax(most, want[i]);
    assert_true(most > 0.05);
    for (size_t i = 0; i < WIDTH * HEIGHT * 3; ++i) {
        assert_near((double)cached.data[i], want[i] + (double)g.emission[i % 3][i / 3],
                    0.02 * most);
    }
    free(want);
    pbnds_image_free(&cached);
    pbnds_envmap_free(env);
    pbnds_light_cache_free(&cache);
    pbnds_shader_neural_free(shader);
    pbnds_gbuffer_free(&g);
}

/* Under one colour everywhere a map has neither places nor directions to lose. */
static void narrow_lobes_see_the_map(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(WIDTH, HEIGHT);
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i) {
        g.roughness[i] = 0.2f;
        g.metallic[i] = 1.0f; /* nothing but the lobe and what is indirect */
    }
    struct pbnds_image grey;
    struct pbnds_envmap *env;
    assert_int_equal(pbnds_image_init(&grey, 64, 32, 3, NULL), PBNDS_OK);
    for (size_t i = 0; i < 64 * 32 * 3; ++i)
        grey.data[i] = 0.5f;
    assert_int_equal(pbnds_envmap_create(&grey, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, NULL),
                     PBNDS_OK);
    pbnds_image_free(&grey);
    const struct pbnds_shader *shader = make_shader("transport", 4);
    struct pbnds_light_cache cache = make_cache(shader, &g, N, 0);
    assert_int_equal(cache.glossy, cache.covered);
    struct pbnds_image with = relight(&cache, &g, env);
    for (size_t i = 0; i < cache.glossy; ++i)
        memset(cache.gloss[i].weight, 0, sizeof cache.gloss[i].weight);
    struct pbnds_image without = relight(&cache, &g, env);
    for (size_t i = 0; i < cache.glossy; ++i) {
        const size_t p = 3 * (size_t)cache.gloss[i].pixel;
        const struct pbnds_cache_gloss *lobe = &cache.gloss[i];
        /* occlusion O is within (0, 1), G about 0.5 albedo */
        for (size_t c = 0; c < 3; ++c) {
            const float gloss = with.data[p + c] - without.data[p + c];
            const float white = 0.5f * g.albedo[c][lobe->pixel];
            assert_true(gloss > 0.2f * white && gloss < 1.1f * white);
        }
    }
    pbnds_image_free(&with);
    pbnds_image_free(&without);
    pbnds_light_cache_free(&cache);
    pbnds_shader_neural_free(shader);
    pbnds_envmap_free(env);
    pbnds_gbuffer_free(&g);
}

static void the_file_holds_it_all(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(WIDTH, HEIGHT);
    struct pbnds_envmap *env = fixture_env(1.0f, 3);
    const struct pbnds_shader *shader = make_shader("transport", 4);
    const struct pbnds_shader *other = make_shader("transport", 5);
    const struct pbnds_shader *plus = make_shader("pbnds+", 5);
    struct pbnds_light_cache cache = make_cache(shader, &g, N, 0), again;
    struct pbnds_light_cache tight = make_cache(shader, &g, N, 1);
    struct pbnds_error error = {{0}};
    char path[64];
    (void)snprintf(path, sizeof path, "test_cache_%d.bin", (int)getpid());
    assert_int_equal(pbnds_light_cache_write(path, &cache, &error), PBNDS_OK);
    assert_int_equal(pbnds_light_cache_read(path, &again, &error), PBNDS_OK);
    assert_int_equal(cache.size, again.size);
    assert_memory_equal(cache.storage, again.storage, cache.size);
    /* tiles leave no trace */
    assert_int_equal(cache.size, tight.size);
    assert_memory_equal(cache.storage + 64, tight.storage + 64, cache.size - 64);
    struct pbnds_image a = relight(&cache, &g, env), b = relight(&again, &g, env);
    assert_memory_equal(a.data, b.data, WIDTH * HEIGHT * 3 * sizeof(float));
    assert_int_equal(pbnds_light_cache_check(path, &again, shader, &g, &error),
                     PBNDS_OK);
    assert_int_equal(pbnds_light_cache_check(path, &again, other, &g, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "other weights"));
    assert_int_equal(pbnds_light_cache_check(path, &again, plus, &g, &error),
                     PBNDS_ERROR_ARGUMENT);
    g.normal[0][20 * WIDTH + 20] += 1e-3f;
    assert_int_equal(pbnds_light_cache_check(path, &again, shader, &g, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "another G-buffer"));
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_light_cache_free(&again);

    /* every byte of it counts; any of them may be wrong */
    uint8_t *bytes;
    size_t size;
    assert_int_equal(pbnds_file_read(path, 1u << 30, &bytes, &size, NULL), PBNDS_OK);
    (void)unlink(path);
    for (size_t k = 0; k < size; k += k < 64 ? 1 : 997) {
        for (int how = 0; how < 2; ++how) {
            const size_t length = how == 0 ? size : k;
            uint8_t *copy = malloc(length + 1);
            memcpy(copy, bytes, length);
            if (how == 0) copy[k] ^= 0x41;
            assert_int_equal(
                pbnds_light_cache_parse("damaged", copy, length, &again, &error),
                PBNDS_ERROR_FORMAT);
            assert_non_null(strstr(error.message, "damaged: "));
            assert_null(again.storage);
        }
    }
    free(bytes);
    pbnds_light_cache_free(&cache);
    pbnds_light_cache_free(&tight);
    pbnds_shader_neural_free(shader);
    pbnds_shader_neural_free(other);
    pbnds_shader_neural_free(plus);
    pbnds_envmap_free(env);
    pbnds_gbuffer_free(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(projection_keeps_energy_and_place),
        cmocka_unit_test(a_lamp_gives_what_the_network_says),
        cmocka_unit_test(narrow_lobes_see_the_map),
        cmocka_unit_test(the_file_holds_it_all),
    };
    return cmocka_run_group_tests_name("neural/light_cache", tests, NULL, NULL);
}
