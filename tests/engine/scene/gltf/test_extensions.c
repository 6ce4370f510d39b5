/* Which extensions are read, told of, or refused. */
#include "tests/engine/scene/gltf/fixture.h"

/** The square with these root members. */
static enum pbnds_status load_root(const char *members, struct pbnds_scene *s)
{
    char text[4096];
    (void)snprintf(text, sizeof text, "%s,\"buffers\"", members);
    char *json = edit(square_json, "\"buffers\"", text);
    const enum pbnds_status status = load(json, &square, sizeof square, s);
    free(json);
    return status;
}

static int lines(const char *text)
{
    int count = 0;
    for (; *text; ++text)
        count += *text == '\n';
    return count;
}

static void what_is_read_is_silent(void **state)
{
    (void)state;
    static const char *const read[] = {
        "KHR_materials_specular",
        "KHR_materials_ior",
        "KHR_materials_emissive_strength",
        "KHR_materials_unlit",
        "KHR_materials_variants",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_texture_transform",
        "KHR_mesh_quantization",
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "EXT_texture_webp",
        "KHR_lights_punctual",
        "EXT_mesh_gpu_instancing",
    };
    for (size_t i = 0; i < sizeof read / sizeof read[0]; ++i) {
        struct pbnds_scene s;
        char members[256];
        (void)snprintf(members, sizeof members,
                       "\"extensionsUsed\":[\"%s\"],\"extensionsRequired\":[\"%s\"]",
                       read[i], read[i]);
        if (load_root(members, &s) != PBNDS_OK) fail_msg("%s", fault.message);
        assert_string_equal(warnings, "");
        pbnds_scene_free(&s);
    }
}

static void what_is_unknown_is_named_in_one_warning(void **state)
{
    (void)state;
    struct pbnds_scene s;
    assert_int_equal(load_root("\"extensionsUsed\":[\"KHR_materials_ior\",\"ACME_a\","
                               "\"ACME_b\",\"ACME_a\",\"KHR_texture_basisu\"]",
                               &s),
                     PBNDS_OK);
    pbnds_scene_free(&s);
    assert_int_equal(lines(warnings), 1);
    assert_non_null(strstr(warnings, "ACME_a, ACME_b, KHR_texture_basisu"));
    assert_null(strstr(warnings, "KHR_materials_ior"));
}

static void layers_are_left_out_and_told(void **state)
{
    (void)state;
    struct pbnds_scene s;
    assert_int_equal(
        load_root("\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":"
                  "[0.5,0.25,1,1]},\"extensions\":{\"KHR_materials_transmission\":{"
                  "\"transmissionFactor\":1},\"KHR_materials_clearcoat\":{"
                  "\"clearcoatFactor\":1}}}],"
                  "\"extensionsUsed\":[\"KHR_materials_transmission\","
                  "\"KHR_materials_clearcoat\",\"KHR_materials_sheen\","
                  "\"KHR_materials_volume\"]",
                  &s),
        PBNDS_OK);
    assert_int_equal(lines(warnings), 2);
    assert_non_null(strstr(warnings, "KHR_materials_clearcoat, KHR_materials_sheen: "
                                     "only the base material"));
    assert_non_null(
        strstr(warnings, "KHR_materials_transmission, KHR_materials_volume: no light"));
    assert_non_null(strstr(warnings, "opaque with their base colour"));
    assert_int_equal(s.materials[0].alpha_mode, PBNDS_ALPHA_OPAQUE);
    assert_near(s.materials[0].base_color.y, 0.25, 0);
    pbnds_scene_free(&s);
}

static void what_is_required_is_refused_with_a_remedy(void **state)
{
    (void)state;
    struct pbnds_scene s;
    assert_int_equal(load_root("\"extensionsRequired\":[\"KHR_texture_transform\","
                               "\"ACME_a\",\"KHR_materials_transmission\",\"ACME_a\"]",
                               &s),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(fault.message, "ACME_a, KHR_materials_transmission,"));
    assert_null(strstr(fault.message, "KHR_texture_transform"));
    assert_non_null(strstr(fault.message, "Blender"));
    assert_int_equal(load_root("\"extensionsRequired\":[\"KHR_texture_basisu\"]", &s),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(
        strstr(fault.message, "the extension KHR_texture_basisu, which is"));
    assert_non_null(strstr(fault.message, "gltf-transform ktxdecompress"));
    assert_int_equal(load_root("\"extensionsRequired\":[\"EXT_texture_avif\"]", &s),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(fault.message, "gltf-transform png"));
    assert_int_equal(load_root("\"extensionsRequired\":[\"KHR_texture_basisu\","
                               "\"KHR_materials_sheen\"]",
                               &s),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(
        strstr(fault.message, "extensions KHR_texture_basisu, KHR_materials_sheen, "));
    assert_non_null(strstr(fault.message, "without them"));
}

/* Long names and long lists end in a sentence all the same. */
static void hostile_lists_are_cut_short(void **state)
{
    (void)state;
    struct pbnds_scene s;
    const size_t size = 400000;
    char *members = malloc(size);
    size_t used = (size_t)snprintf(members, size, "\"extensionsUsed\":[");
    for (int i = 0; i < 1000; ++i) {
        used += (size_t)snprintf(members + used, size - used, "%s\"X_%d_%0300d\"",
                                 i ? "," : "", i, 0);
    }
    (void)snprintf(members + used, size - used, "],\"buffers\"");
    char *json = edit(square_json, "\"buffers\"", members);
    must_load(json, &square, sizeof square, &s);
    assert_int_equal(lines(warnings), 1);
    assert_non_null(strstr(warnings, "X_0_"));
    assert_non_null(strstr(warnings, "..."));
    pbnds_scene_free(&s);
    char *required = edit(json, "extensionsUsed", "extensionsRequired");
    assert_int_equal(load(required, &square, sizeof square, &s),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(fault.message, "not supported"));
    assert_non_null(strstr(fault.message, "Blender"));
    free(required);
    free(json);
    free(members);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_read_is_silent),
        cmocka_unit_test(what_is_unknown_is_named_in_one_warning),
        cmocka_unit_test(layers_are_left_out_and_told),
        cmocka_unit_test(what_is_required_is_refused_with_a_remedy),
        cmocka_unit_test(hostile_lists_are_cut_short),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
