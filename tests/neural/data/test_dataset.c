/* Data sets: samples are pure functions of (recipe, seed, id), splits never mix. */
#include "tests/neural/data/fixture_data.h"

#include "engine/core/parallel.h"

static char folder[] = "test_dataset_assets";
static struct pbnds_dataset_source ROOT[] = {{folder, 0.0}};

/* What a run that was killed left behind. */
static int clean(void **state)
{
    (void)state;
    return system("rm -rf test_dataset_*") == 0 ? 0 : -1;
}

static int count_of(const char *dir, enum pbnds_split split)
{
    struct pbnds_sample_list list;
    assert_int_equal(pbnds_dataset_list(dir, split, &list, NULL), PBNDS_OK);
    const int count = list.count;
    pbnds_sample_list_free(&list);
    return count;
}

static void make_shard(const struct pbnds_dataset_recipe *recipe, int index, int count,
                       const char *dir)
{
    struct pbnds_error error = {{0}};
    const struct pbnds_dataset_options options = {.shard = {index, count}};
    if (pbnds_dataset_make(recipe, &options, dir, NULL, NULL, &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
}

static void make(const struct pbnds_dataset_recipe *recipe, const char *dir)
{
    make_shard(recipe, 0, 1, dir);
}

static void samples_do_not_depend_on_how_they_were_made(void **state)
{
    (void)state;
    fixture_assets(folder);
    const struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 12);
    pbnds_set_threads(1);
    make(&recipe, "test_dataset_whole");
    pbnds_set_threads(3);
    for (int shard = 2; shard >= 0; --shard) { /* in parts, the other way round */
        make_shard(&recipe, shard, 3, "test_dataset_parts");
    }
    pbnds_set_threads(0);
    assert_int_equal(count_of("test_dataset_whole", PBNDS_SPLIT_TRAIN), 10);
    assert_int_equal(count_of("test_dataset_whole", PBNDS_SPLIT_VAL), 1);
    assert_int_equal(count_of("test_dataset_whole", PBNDS_SPLIT_TEST), 1);
    for (int id = 0; id < 12; ++id) {
        const char *split = id == 10 ? "val" : id == 11 ? "test" : "train";
        const int index = id < 10 ? id : 0;
        static const char *const FILES[] = {"sample.exr", "light.exr", "sample.json"};
        for (int f = 0; f < 3; ++f) {
            char a[128], b[128];
            (void)snprintf(a, sizeof a, "test_dataset_whole/%s/%06d/%s", split, index,
                           FILES[f]);
            (void)snprintf(b, sizeof b, "test_dataset_parts/%s/%06d/%s", split, index,
                           FILES[f]);
            assert_true(fixture_same(a, b));
        }
    }
    char whole[17], parts[17];
    assert_int_equal(pbnds_dataset_hash("test_dataset_whole", whole, NULL), PBNDS_OK);
    assert_int_equal(pbnds_dataset_hash("test_dataset_parts", parts, NULL), PBNDS_OK);
    assert_string_equal(whole, parts);
    fixture_remove("test_dataset_parts");
}

static void a_sample_reads_back_whole(void **state)
{
    (void)state;
    struct pbnds_sample sample;
    struct pbnds_error error = {{0}};
    if (pbnds_sample_load("test_dataset_whole/val/000000", 0, &sample, &error) !=
        PBNDS_OK) {
        fail_msg("%s", error.message);
    }
    int covered = 0, visible = 0, brighter = 0;
    for (size_t i = 0; i < 32u * 32u; ++i) {
        if (!isfinite(sample.gbuffer.depth[i])) {
            assert_int_equal(sample.visibility[i], 0);
            continue;
        }
        ++covered;
        visible += sample.visibility[i] != 0;
        brighter += sample.radiance.data[3 * i] >= sample.direct.data[3 * i];
    }
    assert_true(covered > 150); /* the camera check promises 15 % */
    assert_true(visible > covered / 2);
    assert_int_equal(brighter, covered); /* direct light is a part of all light */
    struct pbnds_env_light lights[PBNDS_DATASET_LIGHTS];
    assert_true(pbnds_envmap_cluster(sample.envmap, PBNDS_DATASET_LIGHTS, lights) > 8);
    pbnds_sample_free(&sample);
}

static void missing_samples_are_made_and_the_others_kept(void **state)
{
    (void)state;
    const char *kept = "test_dataset_whole/train/000000/sample.json";
    struct stat before, after;
    assert_int_equal(stat(kept, &before), 0);
    fixture_remove("test_dataset_whole/train/000003");
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 12);
    make(&recipe, "test_dataset_whole");
    assert_int_equal(count_of("test_dataset_whole", PBNDS_SPLIT_TRAIN), 10);
    assert_int_equal(stat(kept, &after), 0);
    assert_true(before.st_ino == after.st_ino);
}

static void another_recipe_is_refused(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 12);
    recipe.spp = 5;
    struct pbnds_error error = {{0}};
    assert_int_equal(
        pbnds_dataset_make(&recipe, NULL, "test_dataset_whole", NULL, NULL, &error),
        PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "another recipe"));
}

static void an_asset_in_two_splits_is_refused(void **state)
{
    (void)state;
    fixture_gltf("test_dataset_assets/test/copy.gltf",
                 1.0f); /* the bytes of train/shape0 */
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 12);
    struct pbnds_error error = {{0}};
    assert_int_equal(
        pbnds_dataset_make(&recipe, NULL, "test_dataset_leak", NULL, NULL, &error),
        PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "split"));
    assert_int_equal(unlink("test_dataset_assets/test/copy.gltf"), 0);
}

static char warned[1024];

static void remember(void *user, const char *sentence)
{
    (void)user;
    (void)snprintf(warned, sizeof warned, "%s", sentence);
}

static void a_broken_asset_costs_its_samples_only(void **state)
{
    (void)state;
    assert_int_equal(
        pbnds_file_write("test_dataset_assets/val/shape1.gltf", "{", 1, NULL),
        PBNDS_OK);
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    const struct pbnds_report report = {.warn = remember};
    assert_int_equal(
        pbnds_dataset_make(&recipe, NULL, "test_dataset_broken", &report, NULL, NULL),
        PBNDS_OK);
    assert_int_equal(count_of("test_dataset_broken", PBNDS_SPLIT_TRAIN), 8);
    assert_int_equal(count_of("test_dataset_broken", PBNDS_SPLIT_VAL), 0);
    assert_non_null(strstr(warned, "1 samples left out"));
    fixture_remove("test_dataset_broken");
}

static void a_data_set_of_nothing_fails(void **state)
{
    (void)state;
    assert_int_equal(pbnds_make_folder("test_dataset_bad", NULL), PBNDS_OK);
    assert_int_equal(pbnds_file_write("test_dataset_bad/shape.gltf", "{", 1, NULL),
                     PBNDS_OK);
    fixture_light("test_dataset_bad/light.exr", 20);
    static char bad_folder[] = "test_dataset_bad";
    struct pbnds_dataset_source bad[] = {{bad_folder, 0.0}};
    struct pbnds_dataset_recipe recipe = fixture_recipe(bad, 3);
    struct pbnds_error error = {{0}};
    const enum pbnds_status status =
        pbnds_dataset_make(&recipe, NULL, "test_dataset_nothing", NULL, NULL, &error);
    /* which split the hash chose decides between the two sentences */
    assert_true(status == PBNDS_ERROR_FORMAT || status == PBNDS_ERROR_ARGUMENT);
    fixture_remove("test_dataset_bad");
    static char train_folder[] = "test_dataset_bad/train";
    struct pbnds_dataset_source train[] = {{train_folder, 0.0}};
    assert_int_equal(pbnds_make_folder(train_folder, NULL), PBNDS_OK);
    assert_int_equal(
        pbnds_file_write("test_dataset_bad/train/shape.gltf", "{", 1, NULL), PBNDS_OK);
    fixture_light("test_dataset_bad/train/light.exr", 20);
    recipe = fixture_recipe(train, 3);
    assert_int_equal(
        pbnds_dataset_make(&recipe, NULL, "test_dataset_nothing", NULL, NULL, &error),
        PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "shape.gltf"));
    assert_int_not_equal(access("test_dataset_nothing/dataset.json", F_OK), 0);
}

/* Only folders below what was given count, and the deepest of them. */
static void folders_above_do_not_decide_the_split(void **state)
{
    (void)state;
    fixture_assets("test_dataset_deep/test/set");
    static char deep[] = "test_dataset_deep/test/set";
    struct pbnds_dataset_source root[] = {{deep, 0.0}};
    struct pbnds_dataset_recipe recipe = fixture_recipe(root, 10);
    make(&recipe, "test_dataset_split");
    assert_int_equal(count_of("test_dataset_split", PBNDS_SPLIT_TRAIN), 8);
    assert_int_equal(count_of("test_dataset_split", PBNDS_SPLIT_VAL), 1);
    assert_int_equal(count_of("test_dataset_split", PBNDS_SPLIT_TEST), 1);
    assert_int_equal(pbnds_make_folder("test_dataset_nest/train/test", NULL), PBNDS_OK);
    fixture_gltf("test_dataset_nest/train/test/a.gltf", 1.0f);
    fixture_light("test_dataset_nest/train/test/a.exr", 20);
    static char nest_folder[] = "test_dataset_nest";
    struct pbnds_dataset_source nest[] = {{nest_folder, 0.0}};
    recipe = fixture_recipe(nest, 1);
    recipe.count[PBNDS_SPLIT_TRAIN] = 0;
    recipe.count[PBNDS_SPLIT_TEST] = 2;
    make(&recipe, "test_dataset_nested");
    assert_int_equal(count_of("test_dataset_nested", PBNDS_SPLIT_TEST), 2);
}

/* What a kill left in a sample's temporary folder does not end up in the sample. */
static void leftovers_of_a_kill_are_swept(void **state)
{
    (void)state;
    fixture_remove("test_dataset_whole/train/000000");
    assert_int_equal(pbnds_make_folder("test_dataset_whole/train/.tmp-000000", NULL),
                     PBNDS_OK);
    assert_int_equal(
        pbnds_file_write("test_dataset_whole/train/.tmp-000000/.tmp-1-sample.exr", "x",
                         1, NULL),
        PBNDS_OK);
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 12);
    make(&recipe, "test_dataset_whole");
    assert_int_equal(access("test_dataset_whole/train/000000/sample.exr", F_OK), 0);
    assert_int_not_equal(
        access("test_dataset_whole/train/000000/.tmp-1-sample.exr", F_OK), 0);
}

static void damaged_samples_are_refused(void **state)
{
    (void)state;
    struct pbnds_sample sample;
    struct pbnds_error error = {{0}};
    const char *file = "test_dataset_whole/test/000000/sample.exr";
    assert_int_equal(truncate(file, 3000), 0);
    assert_true(pbnds_sample_load("test_dataset_whole/test/000000", 0, &sample,
                                  &error) != PBNDS_OK);
    assert_non_null(strstr(error.message, "000000/sample.exr"));
    assert_int_equal(pbnds_dataset_list("test_dataset_nowhere", PBNDS_SPLIT_TRAIN,
                                        &(struct pbnds_sample_list){0}, &error),
                     PBNDS_ERROR_IO);
    fixture_remove("test_dataset_whole");
    fixture_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_do_not_depend_on_how_they_were_made),
        cmocka_unit_test(a_sample_reads_back_whole),
        cmocka_unit_test(missing_samples_are_made_and_the_others_kept),
        cmocka_unit_test(leftovers_of_a_kill_are_swept),
        cmocka_unit_test(another_recipe_is_refused),
        cmocka_unit_test(an_asset_in_two_splits_is_refused),
        cmocka_unit_test(a_broken_asset_costs_its_samples_only),
        cmocka_unit_test(a_data_set_of_nothing_fails),
        cmocka_unit_test(folders_above_do_not_decide_the_split),
        cmocka_unit_test(damaged_samples_are_refused),
    };
    return cmocka_run_group_tests_name("neural/data/dataset", tests, clean, clean);
}
