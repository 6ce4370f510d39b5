/* Samples in memory: the budget holds, and a sample is the same whenever it is loaded and
 * from whatever it is read. */
#include "tests/neural/data/fixture_data.h"

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
#include "neural/train/items.h"

static char folder_of_assets[] = "test_items_assets";
static struct pbnds_dataset_source ROOT[] = {{folder_of_assets, 0.0}};
static const char *const DATA[] = {"test_items_folders", "test_items_tar"};

static int setup(void **state)
{
    (void)state;
    pbnds_set_threads(1);
    if (system("rm -rf test_items_*") != 0) return -1;
    fixture_assets(folder_of_assets);
    for (int f = 0; f < 2; ++f) {
        struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 20);
        recipe.spp = 1;
        recipe.format = f == 0 ? PBNDS_DATASET_FOLDERS : PBNDS_DATASET_TAR;
        recipe.per_tar = 3;
        if (pbnds_dataset_make(&recipe, NULL, DATA[f], NULL, NULL, NULL) != PBNDS_OK)
            return -1;
    }
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    return system("rm -rf test_items_*") == 0 ? 0 : -1;
}

static const struct pbnds_train_item *get(struct pbnds_train_items *items, int list,
                                          int i)
{
    const struct pbnds_train_item *item;
    struct pbnds_error error = {{0}};
    if (pbnds_train_items_get(items, list, i, &item, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    return item;
}

static struct pbnds_train_items open_items(int format, size_t budget)
{
    struct pbnds_train_items items;
    assert_int_equal(pbnds_train_items_open(&items, DATA[format], true, budget, NULL),
                     PBNDS_OK);
    assert_int_equal(items.list[PBNDS_ITEMS_TRAIN].count, 16);
    assert_int_equal(items.list[PBNDS_ITEMS_VAL].count, 2);
    return items;
}

static void assert_same_item(const struct pbnds_train_item *a,
                             const struct pbnds_train_item *b)
{
    const size_t count = (size_t)a->view.width * (size_t)a->view.height;
    assert_int_equal(a->view.width, b->view.width);
    assert_memory_equal(a->view.storage, b->view.storage,
                        count * (PBNDS_PLANE_COUNT + 1) * sizeof(float));
    assert_memory_equal(a->lights, b->lights, sizeof a->lights);
    assert_memory_equal(a->radiance, b->radiance, 3 * count * sizeof(float));
    assert_memory_equal(a->direct, b->direct, 3 * count * sizeof(float));
    assert_memory_equal(a->specular, b->specular, 3 * count * sizeof(float));
    assert_memory_equal(a->visibility, b->visibility, count * sizeof(uint32_t));
    assert_memory_equal(a->march.thin, b->march.thin, count * sizeof(uint32_t));
}

static void tars_hold_the_same(void **state)
{
    (void)state;
    struct pbnds_train_items a = open_items(0, 0), b = open_items(1, 0);
    for (int i = 0; i < 16; ++i)
        assert_same_item(get(&a, PBNDS_ITEMS_TRAIN, i), get(&b, PBNDS_ITEMS_TRAIN, i));
    for (int i = 0; i < 2; ++i)
        assert_same_item(get(&a, PBNDS_ITEMS_VAL, i), get(&b, PBNDS_ITEMS_VAL, i));
    assert_int_equal(a.loaded, 18);
    (void)get(&a, PBNDS_ITEMS_TRAIN, 3);
    assert_int_equal(a.loaded, 18);
    pbnds_train_items_free(&a);
    pbnds_train_items_free(&b);
}

static void the_budget_holds(void **state)
{
    (void)state;
    struct pbnds_train_items all = open_items(0, 0);
    const size_t one = pbnds_train_item_bytes(get(&all, PBNDS_ITEMS_TRAIN, 0));
    const size_t budget = 3 * one + one / 2;
    struct pbnds_train_items few = open_items(1, budget);
    struct pbnds_rng rng = pbnds_rng_make(8, 0, 0);
    for (int k = 0; k < 60; ++k) {
        const int list = k % 7 == 0, count = list ? 2 : 16;
        const int i = (int)(pbnds_rng_u64(&rng) % (uint64_t)count);
        pbnds_train_items_turn(&few);
        assert_same_item(get(&few, list, i), get(&all, list, i));
        assert_true(few.bytes <= budget);
    }
    assert_true(few.most <= budget && few.most > 2 * one);
    assert_true(few.loaded > 30 && few.loaded < 60); /* some were still there */
    pbnds_train_items_free(&few);
    pbnds_train_items_free(&all);
}

/* What was drawn in this turn stays, be the budget as small as it may. */
static void a_turn_keeps_its_samples(void **state)
{
    (void)state;
    struct pbnds_train_items items = open_items(0, 1);
    pbnds_train_items_turn(&items);
    const struct pbnds_train_item *a = get(&items, PBNDS_ITEMS_TRAIN, 4);
    const struct pbnds_train_item *b = get(&items, PBNDS_ITEMS_TRAIN, 9);
    assert_true(a->loaded && b->loaded && items.loaded == 2);
    assert_ptr_equal(get(&items, PBNDS_ITEMS_TRAIN, 4), a);
    pbnds_train_items_turn(&items);
    (void)get(&items, PBNDS_ITEMS_TRAIN, 5);
    assert_true(!a->loaded && !b->loaded);
    assert_int_equal(items.loaded, 3);
    pbnds_train_items_free(&items);
}

static void what_is_not_there_is_told(void **state)
{
    (void)state;
    struct pbnds_train_items items;
    struct pbnds_error error = {{0}};
    assert_int_equal(
        pbnds_train_items_open(&items, "test_items_nowhere", true, 0, &error),
        PBNDS_ERROR_IO);
    items = open_items(0, 0);
    fixture_remove("test_items_folders/train/000007/light.exr");
    const struct pbnds_train_item *item;
    assert_int_equal(pbnds_train_items_get(&items, PBNDS_ITEMS_TRAIN, 7, &item, &error),
                     PBNDS_ERROR_IO);
    assert_non_null(strstr(error.message, "000007"));
    assert_int_equal(items.bytes, 0);
    pbnds_train_items_free(&items);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tars_hold_the_same),
        cmocka_unit_test(the_budget_holds),
        cmocka_unit_test(a_turn_keeps_its_samples),
        cmocka_unit_test(what_is_not_there_is_told),
    };
    return cmocka_run_group_tests_name("neural/train/items", tests, setup, teardown);
}
