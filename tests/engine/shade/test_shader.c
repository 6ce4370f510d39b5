/* engine/shade/shader.c: the table, its checks, its clean failures. */
#include "tests/test.h"

#include <string.h>

#include "engine/core/parallel.h"
#include "tests/engine/shade/fixture.h"

static void the_table_has_every_name_once(void **state)
{
    (void)state;
    const char *names[] = {"blinn-phong", "ggx", "paper-blinn-phong", "paper-ggx",
                           "reference"};
    int count = 0;
    while (pbnds_shader_at(count))
        ++count;
    assert_int_equal(count, 5);
    for (int i = 0; i < 5; ++i) {
        const struct pbnds_shader *shader = pbnds_shader_find(names[i]);
        assert_non_null(shader);
        assert_ptr_equal(shader, pbnds_shader_at(i));
        assert_string_equal(shader->ops->name, names[i]);
        assert_true(strlen(shader->ops->about) > 0);
        assert_true((shader->ops->channels & PBNDS_CHANNEL_NORMAL) != 0);
        assert_null(shader->ops->destroy);
        assert_int_equal(shader->ops->needs_scene, i == 4);
    }
    assert_null(pbnds_shader_find("gg"));
    assert_null(pbnds_shader_find(""));
    assert_null(pbnds_shader_find(NULL));
    assert_null(pbnds_shader_at(-1));
    assert_null(pbnds_shader_at(5));
}

static void ball(struct fixture *f)
{
    const struct pbnds_material m = matte(0.6f);
    const struct pbnds_mesh mesh = sphere(pbnds_splat(0.0f), 1.0f, 8, 0);
    fixture_scene(f, &mesh, 1, &m, 1);
    fixture_light(f, 8, light_sunny);
    fixture_view(f, pbnds_vec3_make(0.0f, 0.0f, 4.0f), pbnds_splat(0.0f), 9, 7);
}

static void assert_refused(const char *name, const struct pbnds_shade_job *job,
                           const char *word)
{
    struct pbnds_error error;
    struct pbnds_image image;
    assert_int_equal(pbnds_shade(pbnds_shader_find(name), job, &image, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_null(image.data);
    assert_non_null(strstr(error.message, word));
    assert_non_null(strstr(error.message, name));
}

static void bad_jobs_are_refused(void **state)
{
    (void)state;
    struct fixture f;
    ball(&f);
    struct pbnds_shade_job job = f.job;
    job.scene = NULL;
    job.accel = NULL;
    assert_refused("reference", &job,
                   "needs the scene; give a .glb, or choose ggx, neural");
    job = f.job;
    job.accel = NULL;
    assert_refused("reference", &job, "needs the scene");
    job = f.job;
    job.spp = -1;
    assert_refused("ggx", &job, "-1 samples");
    job = f.job;
    job.lights = -4;
    assert_refused("paper-ggx", &job, "-4 lights");
    job = f.job;
    job.gbuffer = NULL;
    assert_refused("ggx", &job, "no G-buffer");
    const struct pbnds_gbuffer empty = {0};
    job.gbuffer = &empty;
    assert_refused("blinn-phong", &job, "no G-buffer");
    fixture_free(&f);
}

/* Every row: the right size, light where something was hit, nothing elsewhere, without
 * a scene too where the table says so. */
static void every_row_shades_the_covered_pixels(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    ball(&f);
    f.job.spp = 16;
    for (int i = 0; pbnds_shader_at(i); ++i)
        for (int with_scene = 0; with_scene < 2; ++with_scene) {
            const struct pbnds_shader *shader = pbnds_shader_at(i);
            struct pbnds_shade_job job = f.job;
            struct pbnds_image image;
            if (!with_scene && shader->ops->needs_scene) continue;
            if (!with_scene) job.scene = NULL, job.accel = NULL;
            must(pbnds_shade(shader, &job, &image, &error), &error);
            assert_int_equal(image.width, 9);
            assert_int_equal(image.height, 7);
            assert_int_equal(image.channels, 3);
            for (size_t p = 0; p < 63; ++p) {
                if (f.gbuffer.coverage[p] > 0.0f)
                    assert_true(image.data[3 * p] > 0.0f);
                else
                    assert_near(image.data[3 * p], 0.0, 0.0);
            }
            pbnds_image_free(&image);
        }
    fixture_free(&f);
}

/* Last, because the flag cannot be lowered. */
static void a_stop_leaves_nothing_behind(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    ball(&f);
    pbnds_request_stop();
    for (int i = 0; pbnds_shader_at(i); ++i) {
        struct pbnds_image image;
        assert_int_equal(pbnds_shade(pbnds_shader_at(i), &f.job, &image, &error),
                         PBNDS_ERROR_INTERRUPTED);
        assert_null(image.data);
    }
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_has_every_name_once),
        cmocka_unit_test(bad_jobs_are_refused),
        cmocka_unit_test(every_row_shades_the_covered_pixels),
        cmocka_unit_test(a_stop_leaves_nothing_behind),
    };
    return cmocka_run_group_tests_name("engine/shade/shader", tests, NULL, NULL);
}
