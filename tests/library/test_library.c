/* What a user of the library does, linked once to the static and once to the shared one:
 * load, ray cast, shade, with the weights that ship. */
#include "tests/test.h"

#include <stdio.h>
#include <string.h>

#include "engine/scene/gltf.h"
#include "engine/shade/shader.h"
#include "neural/shader_neural.h"

static void a_scene_is_shaded(void **state)
{
    (void)state;
    struct pbnds_error error = {{0}};
    struct pbnds_scene scene;
    struct pbnds_accel *accel;
    struct pbnds_envmap *env;
    struct pbnds_gbuffer g;
    assert_int_equal(pbnds_gltf_load(PBNDS_SOURCE_DIR "/scenes/spheres.glb", NULL, NULL,
                                     &scene, &error),
                     PBNDS_OK);
    assert_int_equal(pbnds_accel_create(&scene, &accel, &error), PBNDS_OK);
    assert_int_equal(pbnds_envmap_load(PBNDS_SOURCE_DIR "/scenes/sky.hdr",
                                       PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, &error),
                     PBNDS_OK);
    assert_int_equal(pbnds_gbuffer_raycast(&scene, accel, &scene.cameras[0], 48, 48,
                                           NULL, &g, &error),
                     PBNDS_OK);
    static const char *const weights[] = {"transport", "pbnds_plus"};
    for (int m = 0; m < 2; ++m) {
        char path[512];
        (void)snprintf(path, sizeof path, "%s/neural/weights/%s.safetensors",
                       PBNDS_SOURCE_DIR, weights[m]);
        const struct pbnds_shader *shader;
        if (pbnds_shader_neural_create(path, PBNDS_F32, &shader, &error) != PBNDS_OK) {
            fail_msg("%s", error.message);
        }
        for (int lit = 0; lit < 2; ++lit) {
            const struct pbnds_shade_job job = {
                .gbuffer = &g, .envmap = lit ? env : NULL, .shadows = -1};
            struct pbnds_image image;
            assert_int_equal(pbnds_shade(shader, &job, &image, &error), PBNDS_OK);
            double sum = 0.0;
            for (int i = 0; i < 48 * 48 * 3; ++i)
                sum += (double)image.data[i];
            if (lit) assert_true(sum / (48.0 * 48.0 * 3.0) > 0.02);
            /* no light: exactly nothing from transport, next to nothing from pbnds+ */
            if (!lit)
                assert_true(m == 0 ? sum == 0.0 : sum / (48.0 * 48.0 * 3.0) < 0.02);
            pbnds_image_free(&image);
        }
        pbnds_shader_neural_free(shader);
    }
    pbnds_gbuffer_free(&g);
    pbnds_envmap_free(env);
    pbnds_accel_free(accel);
    pbnds_scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_scene_is_shaded)};
    return cmocka_run_group_tests_name("library", tests, NULL, NULL);
}
