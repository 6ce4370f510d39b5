/* What a sample shows is a pure function of (recipe, split, index): whatever was drawn
 * before it, in any order. Its light has the mean luminance that was drawn. */
#include "tests/neural/data/fixture_data.h"

#include "neural/data/draw.h"
#include "neural/data/draw_lamps.h"

static char folder[] = "test_draw_assets";
static struct pbnds_dataset_source ROOT[] = {{folder, 0.0}};

static int clean(void **state)
{
    (void)state;
    return system("rm -rf test_draw_assets") == 0 ? 0 : -1;
}

/* Everything that makes a sample, in a word and a text. */
struct print {
    uint64_t hash;
    char *notes;
};

static uint64_t add(uint64_t hash, const void *data, size_t size)
{
    const unsigned char *p = data;
    for (size_t i = 0; i < size; ++i) /* FNV-1a */
        hash = (hash ^ p[i]) * 0x100000001b3u;
    return hash;
}

static struct print print_of(struct pbnds_drawer *drawer, int index)
{
    struct pbnds_draw d;
    struct pbnds_error error = {{0}};
    if (pbnds_draw(drawer, PBNDS_SPLIT_TRAIN, index, &d, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    struct print p = {0xcbf29ce484222325u, cJSON_Print(d.notes)};
    p.hash = add(p.hash, d.light.data,
                 3 * sizeof(float) * (size_t)d.light.width * (size_t)d.light.height);
    p.hash = add(p.hash, d.camera.world_from_camera.m, sizeof(float[16]));
    p.hash = add(p.hash, &d.camera.yfov, sizeof d.camera.yfov);
    for (int i = 0; i < d.scene->material_count; ++i) {
        const struct pbnds_material *m = &d.scene->materials[i];
        p.hash = add(p.hash, &m->base_color, sizeof m->base_color);
        p.hash = add(p.hash, &m->roughness, sizeof m->roughness);
        p.hash = add(p.hash, &m->metallic, sizeof m->metallic);
        p.hash = add(p.hash, &m->base_color_texture.texture, sizeof(int));
    }
    assert_non_null(p.notes);
    pbnds_draw_free(&d);
    return p;
}

static struct pbnds_dataset_recipe recipe_of_all(void)
{
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    recipe.randomize_materials = 0.6;
    recipe.swap_textures = 0.5;
    recipe.mix_lights = 0.4;
    recipe.hard_lights = 0.4;
    recipe.dark_lights = 0.2;
    return recipe;
}

static void draws_do_not_depend_on_what_came_before(void **state)
{
    (void)state;
    enum { COUNT = 6 };
    fixture_assets(folder);
    struct pbnds_dataset_recipe recipe = recipe_of_all();
    recipe.worlds[PBNDS_SPLIT_TRAIN] = 2;
    recipe.skies[PBNDS_SPLIT_TRAIN] = 2;
    recipe.world_share = recipe.sky_share = 0.5;
    recipe.randomize_materials = recipe.swap_textures = 0.8;
    struct pbnds_drawer *drawer;
    struct print forward[COUNT];
    int worlds = 0, skies = 0;
    assert_int_equal(pbnds_drawer_create(&recipe, &drawer, NULL), PBNDS_OK);
    for (int i = 0; i < COUNT; ++i) {
        forward[i] = print_of(drawer, i);
        worlds += strstr(forward[i].notes, "\"world_") != NULL;
        skies += strstr(forward[i].notes, "\"sky_") != NULL;
    }
    pbnds_drawer_free(drawer);
    assert_true(worlds > 0 && worlds < COUNT && skies > 0);
    assert_int_equal(pbnds_drawer_create(&recipe, &drawer, NULL), PBNDS_OK);
    for (int i = COUNT - 1; i >= 0; --i) { /* also of the scene that is loaded */
        const struct print back = print_of(drawer, i);
        assert_string_equal(back.notes, forward[i].notes);
        assert_true(back.hash == forward[i].hash);
        assert_true(i == 0 || forward[i].hash != forward[i - 1].hash);
        free(back.notes);
        free(forward[i].notes);
    }
    pbnds_drawer_free(drawer);
}

static double note(const struct pbnds_draw *d, const char *name)
{
    const cJSON *item = cJSON_GetObjectItem(d->notes, name);
    assert_non_null(item);
    return item->valuedouble;
}

static void the_light_is_as_bright_as_was_drawn(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = recipe_of_all();
    struct pbnds_drawer *drawer;
    assert_int_equal(pbnds_drawer_create(&recipe, &drawer, NULL), PBNDS_OK);
    int hard = 0, mixed = 0, dark = 0, tilted = 0;
    for (int i = 0; i < 60; ++i) {
        struct pbnds_draw d;
        assert_int_equal(pbnds_draw(drawer, PBNDS_SPLIT_TRAIN, i, &d, NULL), PBNDS_OK);
        const double mean = note(&d, "mean_luminance");
        assert_near(pbnds_map_luminance(&d.light), mean, 1e-4 * mean);
        assert_true(mean > 1e-4 && mean < 2.001);
        assert_int_equal(d.light.width, PBNDS_DATASET_LIGHT_WIDTH);
        hard += cJSON_GetObjectItem(d.notes, "lamps") != NULL;
        mixed += cJSON_GetObjectItem(d.notes, "mixed_light") != NULL;
        tilted += cJSON_GetObjectItem(d.notes, "tilt_deg") != NULL;
        dark += mean < 0.125; /* without them: 2^-3 at least */
        assert_string_equal(d.env->stem,
                            cJSON_GetObjectItem(d.notes, "light")->valuestring);
        assert_near(d.yaw_deg, note(&d, "yaw_deg"), 1e-3);
        pbnds_draw_free(&d);
    }
    assert_true(hard > 12 && hard < 36);
    assert_true(mixed > 5 && mixed < 26); /* 0.4 of the others */
    assert_true(dark > 4 && dark < 22);
    assert_true(tilted < 10);
    pbnds_drawer_free(drawer);
}

/* A map and its lamp turn together: its brightest texel comes to every azimuth. */
static void yaw_and_mixing_are_what_the_notes_say(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    recipe.dark_lights = 0.0;
    struct pbnds_drawer *drawer;
    assert_int_equal(pbnds_drawer_create(&recipe, &drawer, NULL), PBNDS_OK);
    for (int i = 0; i < 12; ++i) {
        struct pbnds_draw d;
        assert_int_equal(pbnds_draw(drawer, PBNDS_SPLIT_TRAIN, i, &d, NULL), PBNDS_OK);
        /* The lamp is texel (4, 1) of 16 x 8: u = 4.5 / 16, texels 64 to 79 of 256. */
        const double turn = note(&d, "yaw_deg");
        const double u = 72.0 - turn / 360.0 * 256.0;
        const int x = (int)floor(u - 256.0 * floor(u / 256.0));
        if (!cJSON_GetObjectItem(d.notes, "tilt_deg")) {
            const float *lit = pbnds_image_at(&d.light, x, 20);
            const float *dim = pbnds_image_at(&d.light, (x + 128) % 256, 20);
            assert_near(lit[0] / dim[0], 150.0, 0.1);
            assert_near(dim[0], 0.2 * note(&d, "strength"), 1e-5);
        }
        pbnds_draw_free(&d);
    }
    pbnds_drawer_free(drawer);
}

static void a_black_light_map_is_said_so(void **state)
{
    (void)state;
    float plane[16 * 8] = {0.0f};
    struct pbnds_exr_channel channels[3] = {{"R", PBNDS_EXR_FLOAT, plane},
                                            {"G", PBNDS_EXR_FLOAT, plane},
                                            {"B", PBNDS_EXR_FLOAT, plane}};
    const struct pbnds_exr exr = {.width = 16,
                                  .height = 8,
                                  .compression = PBNDS_EXR_NONE,
                                  .channels = channels,
                                  .channel_count = 3};
    assert_int_equal(pbnds_exr_write("test_draw_assets/train/light0.exr", &exr, NULL),
                     PBNDS_OK);
    const struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    struct pbnds_drawer *drawer;
    struct pbnds_draw d;
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_drawer_create(&recipe, &drawer, NULL), PBNDS_OK);
    assert_int_equal(pbnds_draw(drawer, PBNDS_SPLIT_TRAIN, 0, &d, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "black"));
    pbnds_drawer_free(drawer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draws_do_not_depend_on_what_came_before),
        cmocka_unit_test(the_light_is_as_bright_as_was_drawn),
        cmocka_unit_test(yaw_and_mixing_are_what_the_notes_say),
        cmocka_unit_test(a_black_light_map_is_said_so),
    };
    return cmocka_run_group_tests_name("neural/data/draw", tests, clean, clean);
}
