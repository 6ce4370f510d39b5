/* Worlds and light maps in memory: pure functions of (seed, index) that load as they are. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/scene/gltf.h"
#include "scenes/generator/generate.h"

static void generate(uint64_t seed, uint64_t index, uint8_t **glb, size_t *size)
{
    struct pbnds_error error = {{0}};
    if (pbnds_world_generate(seed, index, glb, size, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
}

static bool same_world(uint64_t seed_a, uint64_t a, uint64_t seed_b, uint64_t b)
{
    uint8_t *glb_a, *glb_b;
    size_t size_a, size_b;
    generate(seed_a, a, &glb_a, &size_a);
    generate(seed_b, b, &glb_b, &size_b);
    const bool same = size_a == size_b && memcmp(glb_a, glb_b, size_a) == 0;
    free(glb_a);
    free(glb_b);
    return same;
}

static void a_world_is_a_function_of_seed_and_index(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 6; ++i)
        assert_true(same_world(7, i, 7, i));
    assert_false(same_world(7, 0, 7, 1));
    assert_false(same_world(7, 0, 8, 0));
    assert_false(same_world(1, 2, 2, 1));
    assert_true(same_world(UINT64_MAX, UINT64_MAX, UINT64_MAX, UINT64_MAX));
}

static void refuse(void *user, const char *sentence)
{
    (void)user;
    fail_msg("%s", sentence);
}

static void a_world_loads_without_a_word(void **state)
{
    (void)state;
    const struct pbnds_report report = {.warn = refuse};
    for (uint64_t i = 0; i < 12; ++i) {
        struct pbnds_error error = {{0}};
        struct pbnds_scene scene;
        uint8_t *glb;
        size_t size;
        generate(3, i, &glb, &size);
        if (pbnds_gltf_load_memory(glb, size, "world", NULL, NULL, &report, &scene,
                                   &error) != PBNDS_OK)
            fail_msg("world %d: %s", (int)i, error.message);
        free(glb);
        const struct pbnds_vec3 d = pbnds_sub(scene.hi, scene.lo);
        const float radius = 0.5f * pbnds_length(d);
        assert_in_range((int)(1000.0f * radius), 499, 2001);
        assert_near(pbnds_length(pbnds_add(scene.hi, scene.lo)), 0.0, 1e-3);
        pbnds_scene_free(&scene);
    }
}

static void a_light_map_is_a_function_of_seed_and_index(void **state)
{
    (void)state;
    enum { W = 32, H = 16, N = W * H * 3 };
    static float a[N], b[N];
    for (uint64_t i = 0; i < 40; ++i) {
        double sum = 0.0;
        pbnds_sky_generate(5, i, W, H, a);
        pbnds_sky_generate(5, i, W, H, b);
        assert_memory_equal(a, b, sizeof a);
        for (int k = 0; k < N; ++k) {
            assert_true(a[k] >= 0.0f && a[k] < 1e6f);
            sum += (double)a[k];
        }
        assert_true(sum > 0.0);
        pbnds_sky_generate(5, i + 1, W, H, b);
        assert_true(memcmp(a, b, sizeof a) != 0);
        pbnds_sky_generate(6, i, W, H, b);
        assert_true(memcmp(a, b, sizeof a) != 0);
    }
}

int main(void)
{
    pbnds_set_threads(1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_world_is_a_function_of_seed_and_index),
        cmocka_unit_test(a_world_loads_without_a_word),
        cmocka_unit_test(a_light_map_is_a_function_of_seed_and_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
