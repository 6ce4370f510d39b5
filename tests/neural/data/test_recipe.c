/* Recipe files: what they say is what is made, and a typing error is told. */
#include "tests/neural/data/fixture_data.h"

static enum pbnds_status parse(const char *text, struct pbnds_dataset_recipe *recipe,
                               struct pbnds_error *error)
{
    return pbnds_dataset_recipe_parse(text, strlen(text), "r.json", "root", recipe,
                                      error);
}

static void every_key_reaches_its_place(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe r;
    struct pbnds_error error = {{0}};
    const char *text =
        "{\"about\": \"all keys\", \"scenes\": [\"a\", {\"path\": \"/b\", \"share\": "
        "0.25}], \"envs\": [{\"path\": \"c\"}], \"worlds\": {\"train\": 7, \"test\": "
        "2}, \"world_share\": 0.5, \"world_seed\": 11, \"skies\": {\"val\": 3}, "
        "\"sky_share\": 0.125, \"count\": {\"train\": 30, \"val\": 4, \"test\": 5}, "
        "\"size\": [96, 64], \"spp\": 17, \"seed\": 9007199254740991, \"format\": "
        "\"tar\", \"per_tar\": 13, \"materials\": {\"randomize\": 0.1, "
        "\"swap_textures\": 0.2}, \"lights\": {\"mix\": 0.3, \"hard\": 0.4, \"dark\": "
        "0.6}, \"targets\": {\"variance\": true, \"ao\": true, \"olat\": 8, "
        "\"olat_spp\": 16, \"denoise\": true}}";
    if (parse(text, &r, &error) != PBNDS_OK) fail_msg("%s", error.message);
    assert_int_equal(r.scene_count, 2);
    assert_string_equal(r.scenes[0].path, "root/a");
    assert_string_equal(r.scenes[1].path, "/b");
    assert_true(r.scenes[0].share == 0.0 && r.scenes[1].share == 0.25);
    assert_int_equal(r.env_count, 1);
    assert_string_equal(r.envs[0].path, "root/c");
    assert_int_equal(r.worlds[PBNDS_SPLIT_TRAIN], 7);
    assert_int_equal(r.worlds[PBNDS_SPLIT_TEST], 2);
    assert_int_equal(r.skies[PBNDS_SPLIT_VAL], 3);
    assert_true(r.world_share == 0.5 && r.sky_share == 0.125);
    assert_int_equal(r.world_seed, 11);
    assert_true(r.count[0] == 30 && r.count[1] == 4 && r.count[2] == 5);
    assert_true(r.width == 96 && r.height == 64 && r.spp == 17);
    assert_true(r.seed == 9007199254740991u);
    assert_int_equal(r.format, PBNDS_DATASET_TAR);
    assert_int_equal(r.per_tar, 13);
    assert_true(r.randomize_materials == 0.1 && r.swap_textures == 0.2);
    assert_true(r.mix_lights == 0.3 && r.hard_lights == 0.4 && r.dark_lights == 0.6);
    assert_true(r.variance && r.ao && r.denoise && r.olat == 8 && r.olat_spp == 16);
    pbnds_dataset_recipe_free(&r);
}

/* A description is a recipe again, but for what it leaves out. */
static void a_description_reads_back(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe r, again;
    assert_int_equal(parse("{\"worlds\": {\"train\": 7}, \"spp\": 9, \"size\": [8, 9],"
                           "\"lights\": {\"hard\": 0.5}, \"targets\": {\"olat\": 3}}",
                           &r, NULL),
                     PBNDS_OK);
    cJSON *json = cJSON_CreateObject();
    pbnds_dataset_recipe_describe(&r, json);
    char *text = cJSON_Print(json);
    struct pbnds_error error = {{0}};
    if (parse(text, &again, &error) != PBNDS_OK) fail_msg("%s", error.message);
    assert_memory_equal(&r, &again, sizeof r);
    cJSON_free(text);
    cJSON_Delete(json);
    pbnds_dataset_recipe_free(&r);
    pbnds_dataset_recipe_free(&again);
}

static void what_is_wrong_is_told(void **state)
{
    (void)state;
    static const struct {
        const char *text, *told;
    } CASES[] = {
        {"[]", "not a JSON object"},
        {"{", "not a JSON object"},
        {"{\"sead\": 1}", "sead"},
        {"{\"spp\": 0}", "spp"},
        {"{\"spp\": 1.5}", "whole"},
        {"{\"spp\": \"9\"}", "spp"},
        {"{\"seed\": -1}", "seed"},
        {"{\"seed\": 1e300}", "seed"},
        {"{\"size\": [128]}", "size"},
        {"{\"size\": [4, 99999]}", "size"},
        {"{\"scenes\": \"a\"}", "scenes"},
        {"{\"scenes\": [{\"path\": \"a\", \"shar\": 1}]}", "scenes"},
        {"{\"scenes\": [{\"path\": \"a\", \"share\": 2}]}", "share"},
        {"{\"scenes\": [\"a\"], \"scenes\": [\"b\"]}", "twice"},
        {"{\"scenes\": [\"a\", 3]}", "scenes"},
        {"{\"count\": 3}", "count"},
        {"{\"count\": {\"trian\": 3}}", "trian"},
        {"{\"count\": {\"train\": -3}}", "train"},
        {"{\"format\": \"zip\"}", "format"},
        {"{\"lights\": {\"hard\": 1.5}}", "lights.hard"},
        {"{\"lights\": {\"spp\": 1}}", "lights.spp"},
        {"{\"targets\": {\"ao\": 1}}", "targets.ao"},
        {"{\"targets\": 1}", "targets"},
        {"{\"hard\": 0.5}", "hard"},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof CASES[0]; ++i) {
        struct pbnds_dataset_recipe r;
        struct pbnds_error error = {{0}};
        if (parse(CASES[i].text, &r, &error) != PBNDS_ERROR_FORMAT)
            fail_msg("%s: was taken", CASES[i].text);
        if (!strstr(error.message, CASES[i].told) || !strstr(error.message, "r.json"))
            fail_msg("%s: '%s'", CASES[i].text, error.message);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_reaches_its_place),
        cmocka_unit_test(a_description_reads_back),
        cmocka_unit_test(what_is_wrong_is_told),
    };
    return cmocka_run_group_tests_name("neural/data/recipe", tests, NULL, NULL);
}
