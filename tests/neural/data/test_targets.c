/* Targets: what a sample's files say, and that the parts add up. */
#include "tests/neural/data/fixture_data.h"

#include "engine/core/parallel.h"
#include "neural/data/targets.h"

static char folder[] = "test_targets_assets";
static struct pbnds_dataset_source ROOT[] = {{folder, 0.0}};

static int clean(void **state)
{
    (void)state;
    return system("rm -rf test_targets_*") == 0 ? 0 : -1;
}

static int set_up(void **state)
{
    if (clean(state) != 0) return -1;
    fixture_assets(folder);
    return 0;
}

static void must(enum pbnds_status status, const struct pbnds_error *error)
{
    if (status != PBNDS_OK) fail_msg("%s", error->message);
}

/* Draws, renders and writes sample 0 of the split into DIR. */
static void make(const struct pbnds_dataset_recipe *recipe, enum pbnds_split split,
                 const char *dir, struct pbnds_targets *targets)
{
    struct pbnds_error error = {{0}};
    struct pbnds_drawer *drawer;
    struct pbnds_draw draw;
    must(pbnds_drawer_create(recipe, &drawer, &error), &error);
    must(pbnds_draw(drawer, split, 0, &draw, &error), &error);
    must(pbnds_targets_render(recipe, &draw, targets, &error), &error);
    must(pbnds_make_folder(dir, &error), &error);
    must(pbnds_sample_write(dir, recipe, &draw, targets, &error), &error);
    pbnds_draw_free(&draw);
    pbnds_drawer_free(drawer);
}

static void read_exr(const char *dir, const char *name, struct pbnds_exr *exr)
{
    char path[256];
    struct pbnds_error error = {{0}};
    (void)snprintf(path, sizeof path, "%s/%s", dir, name);
    must(pbnds_exr_read(path, exr, &error), &error);
}

static const struct pbnds_exr_channel *channel(const struct pbnds_exr *exr,
                                               const char *layer, int c)
{
    char name[64];
    (void)snprintf(name, sizeof name, "%s%c", layer, "RGB"[c]);
    const struct pbnds_exr_channel *found = pbnds_exr_find(exr, name);
    if (!found) fail_msg("no channel %s", name);
    return found;
}

static void the_parts_add_up_in_the_file(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    recipe.variance = true;
    recipe.spp = 16;
    struct pbnds_targets targets;
    make(&recipe, PBNDS_SPLIT_TRAIN, "test_targets_parts", &targets);
    struct pbnds_exr exr;
    read_exr("test_targets_parts", "sample.exr", &exr);
    double spread = 0.0, indirect = 0.0;
    for (int c = 0; c < 3; ++c) {
        const struct pbnds_exr_channel *all = channel(&exr, "", c),
                                       *direct = channel(&exr, "direct.", c),
                                       *rest = channel(&exr, "indirect.", c),
                                       *variance = channel(&exr, "variance.", c);
        assert_int_equal(all->type, PBNDS_EXR_HALF);
        assert_int_equal(variance->type, PBNDS_EXR_FLOAT);
        for (size_t i = 0; i < 32u * 32u; ++i) {
            const float a = ((float *)all->data)[i], d = ((float *)direct->data)[i],
                        r = ((float *)rest->data)[i];
            const float v = ((float *)variance->data)[i];
            assert_near(a, d + r, 0x1p-10 * (double)a + 1e-7);
            assert_near(a, targets.radiance.data[3 * i + (size_t)c],
                        0x1p-11 * (double)a + 1e-7);
            assert_near(v, targets.variance.data[3 * i + (size_t)c],
                        0x1p-8 * (double)v);
            spread += (double)v;
            indirect += (double)r;
        }
    }
    assert_true(spread > 0.0);
    assert_true(indirect > 0.0);
    pbnds_exr_free(&exr);
    pbnds_targets_free(&targets);
}

/* The file's light map is the one that lit the scene: made again from it, the radiance is
 * the same to the bit. */
static void the_light_of_the_file_is_the_light_of_the_scene(void **state)
{
    (void)state;
    struct pbnds_exr exr;
    read_exr("test_targets_parts", "light.exr", &exr);
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    struct pbnds_targets targets;
    make(&recipe, PBNDS_SPLIT_TRAIN, "test_targets_light", &targets);
    for (int c = 0; c < 3; ++c) {
        const struct pbnds_exr_channel *plane = channel(&exr, "", c);
        assert_int_equal(plane->type, PBNDS_EXR_HALF);
        const size_t count = (size_t)exr.width * (size_t)exr.height;
        for (size_t i = 0; i < count; ++i)
            assert_true(((float *)plane->data)[i] ==
                        targets.light.data[3 * i + (size_t)c]);
    }
    pbnds_exr_free(&exr);
    pbnds_targets_free(&targets);
}

static void what_was_not_asked_for_is_not_there(void **state)
{
    (void)state;
    struct pbnds_sample sample;
    struct pbnds_error error = {{0}};
    const unsigned everything = PBNDS_SAMPLE_VARIANCE | PBNDS_SAMPLE_OLAT;
    must(pbnds_sample_load("test_targets_light", everything, &sample, &error), &error);
    assert_null(sample.variance.data);
    assert_int_equal(sample.olat.count, 0);
    assert_null(sample.gbuffer.ao);
    pbnds_sample_free(&sample);
    must(pbnds_sample_load("test_targets_parts", 0, &sample, &error), &error);
    assert_null(sample.variance.data); /* there, but not asked for */
    pbnds_sample_free(&sample);
    must(pbnds_sample_load("test_targets_parts", everything, &sample, &error), &error);
    assert_non_null(sample.variance.data);
    pbnds_sample_free(&sample);
}

/* A light beyond half's range is kept, not clipped. */
static void a_fierce_light_stays_float(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    struct pbnds_error error = {{0}};
    struct pbnds_drawer *drawer;
    struct pbnds_draw draw;
    struct pbnds_targets targets;
    must(pbnds_drawer_create(&recipe, &drawer, &error), &error);
    must(pbnds_draw(drawer, PBNDS_SPLIT_TRAIN, 0, &draw, &error), &error);
    draw.light.data[3 * 5000] = 1e6f;
    must(pbnds_targets_render(&recipe, &draw, &targets, &error), &error);
    must(pbnds_make_folder("test_targets_fierce", &error), &error);
    must(pbnds_sample_write("test_targets_fierce", &recipe, &draw, &targets, &error),
         &error);
    struct pbnds_exr exr;
    read_exr("test_targets_fierce", "light.exr", &exr);
    assert_int_equal(channel(&exr, "", 0)->type, PBNDS_EXR_FLOAT);
    assert_true(((float *)channel(&exr, "", 0)->data)[5000] == 1e6f);
    pbnds_exr_free(&exr);
    pbnds_targets_free(&targets);
    pbnds_draw_free(&draw);
    pbnds_drawer_free(drawer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_parts_add_up_in_the_file),
        cmocka_unit_test(the_light_of_the_file_is_the_light_of_the_scene),
        cmocka_unit_test(what_was_not_asked_for_is_not_there),
        cmocka_unit_test(a_fierce_light_stays_float),
    };
    return cmocka_run_group_tests_name("neural/data/targets", tests, set_up, clean);
}
