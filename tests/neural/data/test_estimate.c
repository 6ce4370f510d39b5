/* A dry run leaves nothing behind and its bytes are those of the data set. */
#include "tests/neural/data/fixture_data.h"

#include <dirent.h>

#include "neural/data/estimate.h"

static char assets[] = "test_estimate_assets";
static struct pbnds_dataset_source ROOT[] = {{assets, 0.0}};

static int clean(void **state)
{
    (void)state;
    return system("rm -rf test_estimate_*") == 0 ? 0 : -1;
}

static double bytes_of(const char *folder)
{
    static const char *const FILES[] = {"sample.exr", "light.exr", "sample.json"};
    double bytes = 0.0;
    for (int f = 0; f < 3; ++f) {
        char path[300];
        struct stat info;
        (void)snprintf(path, sizeof path, "%s/%s", folder, FILES[f]);
        assert_int_equal(stat(path, &info), 0);
        bytes += (double)info.st_size;
    }
    return bytes;
}

/* Fewer samples than pilots: every one is tried, so the bytes are near exact (noise of
 * fewer samples a pixel packs a little worse). */
static void bytes_are_those_of_the_data_set(void **state)
{
    (void)state;
    fixture_assets(assets);
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    recipe.spp = 32;
    struct pbnds_error error = {{0}};
    struct pbnds_dataset_cost cost;
    assert_int_equal(pbnds_make_folder("test_estimate_scratch", NULL), PBNDS_OK);
    if (pbnds_dataset_estimate(&recipe, "test_estimate_scratch", NULL, &cost, &error) !=
        PBNDS_OK)
        fail_msg("%s", error.message);
    assert_int_equal(cost.count, 10);
    assert_int_equal(cost.pilots, 10);
    assert_int_equal(cost.failed, 0);
    assert_true(cost.core_seconds > 0.0);
    assert_int_equal(rmdir("test_estimate_scratch"), 0); /* nothing was left in it */
    assert_int_equal(
        pbnds_dataset_make(&recipe, NULL, "test_estimate_data", NULL, NULL, NULL),
        PBNDS_OK);
    double bytes = 0.0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        struct pbnds_sample_list list;
        assert_int_equal(
            pbnds_dataset_list("test_estimate_data", (enum pbnds_split)s, &list, NULL),
            PBNDS_OK);
        for (int i = 0; i < list.count; ++i)
            bytes += bytes_of(list.folders[i]);
        pbnds_sample_list_free(&list);
    }
    if (fabs(cost.bytes - bytes) > 0.1 * bytes)
        fail_msg("%.0f bytes told, %.0f are there", cost.bytes, bytes);
}

static void scenes_that_cannot_be_read_are_counted(void **state)
{
    (void)state;
    assert_int_equal(
        pbnds_file_write("test_estimate_assets/val/shape1.gltf", "{", 1, NULL),
        PBNDS_OK);
    const struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    struct pbnds_dataset_cost cost;
    assert_int_equal(pbnds_dataset_estimate(&recipe, ".", NULL, &cost, NULL), PBNDS_OK);
    assert_int_equal(cost.failed, 1);
    struct pbnds_error error = {{0}};
    struct pbnds_dataset_recipe val = recipe;
    val.every_split = false;
    val.count[PBNDS_SPLIT_TRAIN] = val.count[PBNDS_SPLIT_TEST] = 0;
    assert_int_equal(pbnds_dataset_estimate(&val, ".", NULL, &cost, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "shape1.gltf"));
    assert_int_equal(
        pbnds_dataset_estimate(&recipe, "test_estimate_nowhere", NULL, &cost, &error),
        PBNDS_ERROR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_those_of_the_data_set),
        cmocka_unit_test(scenes_that_cannot_be_read_are_counted),
    };
    return cmocka_run_group_tests_name("neural/data/estimate", tests, clean, clean);
}
