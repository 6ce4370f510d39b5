/* Assets: split by folder or name, weighed by share, procedural ones among them. */
#include "tests/neural/data/fixture_data.h"

#include "neural/data/assets.h"

static int clean(void **state)
{
    (void)state;
    return system("rm -rf test_assets_*") == 0 ? 0 : -1;
}

static char a_folder[] = "test_assets_a", b_folder[] = "test_assets_b";

static int make(void **state)
{
    if (clean(state) != 0) return -1;
    for (int i = 0; i < 6; ++i) {
        char path[128];
        const char *folder = i < 4 ? "test_assets_a/train" : "test_assets_b/train";
        assert_int_equal(pbnds_make_folder(folder, NULL), PBNDS_OK);
        (void)snprintf(path, sizeof path, "%s/shape%d.gltf", folder, i);
        fixture_gltf(path, 1.0f + 0.1f * (float)i);
    }
    return 0;
}

static struct pbnds_dataset_recipe recipe_of(struct pbnds_dataset_source *sources,
                                             int count)
{
    struct pbnds_dataset_recipe recipe;
    pbnds_dataset_recipe_init(&recipe);
    recipe.scenes = sources;
    recipe.scene_count = count;
    return recipe;
}

/* Share of u in [0, 1) that picks an asset whose name begins so. */
static double share_of(const struct pbnds_asset_list *list, enum pbnds_split split,
                       const char *begin)
{
    int hits = 0;
    for (int i = 0; i < 10000; ++i) {
        const struct pbnds_asset *a =
            pbnds_assets_pick(list, split, ((double)i + 0.5) / 10000.0);
        assert_non_null(a);
        assert_int_equal(a->split, split);
        hits += strncmp(a->stem, begin, strlen(begin)) == 0;
    }
    return (double)hits / 10000.0;
}

static struct pbnds_asset_list find(const struct pbnds_dataset_recipe *recipe,
                                    enum pbnds_asset_kind kind)
{
    struct pbnds_asset_list list;
    struct pbnds_error error = {{0}};
    if (pbnds_assets_find(recipe, kind, &list, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    return list;
}

static void shares_are_kept(void **state)
{
    (void)state;
    struct pbnds_dataset_source sources[2] = {{a_folder, 0.3}, {b_folder, 0.0}};
    struct pbnds_dataset_recipe recipe = recipe_of(sources, 2);
    recipe.worlds[PBNDS_SPLIT_TRAIN] = 50;
    recipe.worlds[PBNDS_SPLIT_TEST] = 5;
    recipe.world_share = 0.5;
    struct pbnds_asset_list list = find(&recipe, PBNDS_ASSET_SCENE);
    assert_int_equal(list.count, 6 + 55);
    assert_near(share_of(&list, PBNDS_SPLIT_TRAIN, "world_"), 0.5, 1e-3);
    for (int i = 0; i < 6; ++i) {
        char stem[16];
        (void)snprintf(stem, sizeof stem, "shape%d", i);
        /* 0.3 for the four of a; what is left, 0.2, for the two of b */
        assert_near(share_of(&list, PBNDS_SPLIT_TRAIN, stem), i < 4 ? 0.075 : 0.1,
                    1e-3);
    }
    /* One source alone takes all of its split, whatever its share. */
    assert_near(share_of(&list, PBNDS_SPLIT_TEST, "world_"), 1.0, 0.0);
    assert_null(pbnds_assets_pick(&list, PBNDS_SPLIT_VAL, 0.5));
    pbnds_assets_free(&list);
    recipe.worlds[PBNDS_SPLIT_TRAIN] = 0;
    sources[0].share = sources[1].share = 0.9; /* beyond one: relative */
    list = find(&recipe, PBNDS_ASSET_SCENE);
    assert_near(share_of(&list, PBNDS_SPLIT_TRAIN, "shape0"), 0.125, 1e-3);
    assert_near(share_of(&list, PBNDS_SPLIT_TRAIN, "shape5"), 0.25, 1e-3);
    pbnds_assets_free(&list);
}

static void procedural_assets_belong_to_one_split(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = recipe_of(NULL, 0);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        recipe.worlds[s] = recipe.skies[s] = 20;
    struct pbnds_asset_list worlds = find(&recipe, PBNDS_ASSET_SCENE);
    struct pbnds_asset_list skies = find(&recipe, PBNDS_ASSET_LIGHT);
    assert_int_equal(worlds.count, 60);
    assert_int_equal(skies.count, 60);
    for (int i = 0; i < 60; ++i) {
        assert_null(worlds.items[i].path);
        assert_int_equal(worlds.items[i].split, i / 20);
        for (int k = 0; k < i; ++k) {
            assert_true(worlds.items[i].number != worlds.items[k].number);
            assert_string_not_equal(worlds.items[i].stem, worlds.items[k].stem);
        }
        assert_string_not_equal(worlds.items[i].stem, skies.items[i].stem);
    }
    /* More of one split leave the others as they are. */
    const uint64_t number = worlds.items[25].number;
    pbnds_assets_free(&worlds);
    recipe.worlds[PBNDS_SPLIT_TRAIN] = 40;
    worlds = find(&recipe, PBNDS_ASSET_SCENE);
    assert_true(worlds.items[45].number == number);
    pbnds_assets_free(&worlds);
    pbnds_assets_free(&skies);
}

static void the_order_of_arguments_does_not_matter(void **state)
{
    (void)state;
    struct pbnds_dataset_source ab[2] = {{a_folder, 0.0}, {b_folder, 0.4}};
    struct pbnds_dataset_source ba[2] = {{b_folder, 0.4}, {a_folder, 0.0}};
    const struct pbnds_dataset_recipe x = recipe_of(ab, 2), y = recipe_of(ba, 2);
    struct pbnds_asset_list p = find(&x, PBNDS_ASSET_SCENE);
    struct pbnds_asset_list q = find(&y, PBNDS_ASSET_SCENE);
    assert_int_equal(p.count, q.count);
    for (int i = 0; i < p.count; ++i) {
        assert_string_equal(p.items[i].stem, q.items[i].stem);
        assert_true(p.items[i].hash == q.items[i].hash);
        assert_near(p.items[i].below, q.items[i].below, 0.0);
    }
    pbnds_assets_free(&p);
    pbnds_assets_free(&q);
}

static void names_without_folders_are_split_by_their_hash(void **state)
{
    (void)state;
    char *text = strdup("test_assets_flat");
    assert_non_null(text);
    assert_int_equal(pbnds_make_folder(text, NULL), PBNDS_OK);
    for (int i = 0; i < 60; ++i) {
        char path[128];
        (void)snprintf(path, sizeof path, "test_assets_flat/thing%d.gltf", i);
        fixture_gltf(path, 1.0f + 0.01f * (float)i);
    }
    struct pbnds_dataset_source flat[1] = {{text, 0.0}};
    const struct pbnds_dataset_recipe recipe = recipe_of(flat, 1);
    struct pbnds_asset_list list = find(&recipe, PBNDS_ASSET_SCENE);
    const int train = list.first[1], val = list.first[2] - list.first[1];
    assert_true(train > 36 && val > 0 && list.count - train - val > 0);
    pbnds_assets_free(&list);
    free(text);
}

static void what_is_missing_is_named(void **state)
{
    (void)state;
    static char nowhere[] = "test_assets_nowhere";
    struct pbnds_dataset_source sources[1] = {{nowhere, 0.0}};
    struct pbnds_dataset_recipe recipe = recipe_of(sources, 1);
    struct pbnds_asset_list list;
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_assets_find(&recipe, PBNDS_ASSET_SCENE, &list, &error),
                     PBNDS_ERROR_IO);
    assert_non_null(strstr(error.message, nowhere));
    assert_int_equal(list.count, 0);
    sources[0].path = a_folder; /* scenes, but no light map */
    recipe.envs = sources;
    recipe.env_count = 1;
    assert_int_equal(pbnds_assets_find(&recipe, PBNDS_ASSET_LIGHT, &list, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, ".hdr"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_are_kept),
        cmocka_unit_test(procedural_assets_belong_to_one_split),
        cmocka_unit_test(the_order_of_arguments_does_not_matter),
        cmocka_unit_test(names_without_folders_are_split_by_their_hash),
        cmocka_unit_test(what_is_missing_is_named),
    };
    return cmocka_run_group_tests_name("neural/data/assets", tests, make, clean);
}
