/* KHR_materials_variants. */
#include "tests/engine/scene/gltf/fixture.h"

#define VARIANTS                                                                       \
    "\"materials\":[{\"name\":\"bare\"},{\"name\":\"wood\"},{\"name\":\"tin\"}],"      \
    "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"oak\"},"    \
    "{\"name\":\"steel\"},{\"name\":\"0\"},{\"name\":\"plain\"}]}},"

#define MAPPINGS(material)                                                             \
    "\"indices\":3,\"material\":0,\"extensions\":{\"KHR_materials_variants\":{"        \
    "\"mappings\":[{\"material\":" material ",\"variants\":[0]},"                      \
    "{\"material\":2,\"variants\":[2,1]}]}}"

static enum pbnds_status load_variant(const char *mappings, const char *variant,
                                      struct pbnds_scene *s)
{
    const struct pbnds_gltf_options options = {.variant = variant};
    char *a = edit(square_json, "\"buffers\"", VARIANTS "\"buffers\"");
    char *json = edit(a, "\"indices\":3", mappings);
    const enum pbnds_status status =
        load_with(json, &square, sizeof square, &options, s);
    free(a);
    free(json);
    return status;
}

static void a_variant_is_worn(void **state)
{
    (void)state;
    static const struct {
        const char *variant;
        int material;
    } cases[] = {
        {NULL, 0}, {"oak", 1},   {"steel", 2}, {"1", 2},
        {"3", 0},  {"plain", 0}, {"0", 2}, /* a name goes before an index */
        {"02", 2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_scene s;
        if (load_variant(MAPPINGS("1"), cases[i].variant, &s) != PBNDS_OK)
            fail_msg("%s", fault.message);
        assert_int_equal(s.meshes[0].material, cases[i].material);
        assert_string_equal(warnings, "");
        pbnds_scene_free(&s);
    }
    /* A primitive without mappings keeps what it has. */
    struct pbnds_scene s;
    assert_int_equal(load_variant("\"indices\":3,\"material\":1", "steel", &s),
                     PBNDS_OK);
    assert_int_equal(s.meshes[0].material, 1);
    pbnds_scene_free(&s);
}

static void an_unknown_variant_is_told_with_a_list(void **state)
{
    (void)state;
    struct pbnds_scene s;
    static const char *const wrong[] = {"Oak", "4",  "-1",
                                        "",    "1x", "99999999999999999999"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        assert_int_equal(load_variant(MAPPINGS("1"), wrong[i], &s),
                         PBNDS_ERROR_ARGUMENT);
        assert_non_null(strstr(fault.message, "oak, steel, 0, plain"));
    }
    const struct pbnds_gltf_options options = {.variant = "oak"};
    assert_int_equal(load_with(square_json, &square, sizeof square, &options, &s),
                     PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(fault.message, "no material variants"));
}

static void damaged_mappings_are_told(void **state)
{
    (void)state;
    struct pbnds_scene s;
    static const char *const materials[] = {"3", "-1", "\"x\"", "4294967297", "{}"};
    for (size_t i = 0; i < sizeof materials / sizeof materials[0]; ++i) {
        char mappings[512];
        (void)snprintf(mappings, sizeof mappings,
                       "\"indices\":3,\"extensions\":{\"KHR_materials_variants\":{"
                       "\"mappings\":[{\"material\":%s,\"variants\":[0]}]}}",
                       materials[i]);
        if (load_variant(mappings, NULL, &s) != PBNDS_ERROR_FORMAT)
            fail_msg("material %s", materials[i]);
    }
    /* What is of another kind is no mapping. */
    assert_int_equal(
        load_variant("\"indices\":3,\"extensions\":{\"KHR_materials_variants\":{"
                     "\"mappings\":[7,{\"variants\":1,\"material\":1}]}}",
                     "oak", &s),
        PBNDS_OK);
    assert_int_equal(s.meshes[0].material, 3); /* the default */
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_variant_is_worn),
        cmocka_unit_test(an_unknown_variant_is_told_with_a_list),
        cmocka_unit_test(damaged_mappings_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
