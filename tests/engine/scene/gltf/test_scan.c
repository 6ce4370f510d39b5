/* The pass over the JSON before the parser: what it makes readable, what it stops. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/engine/scene/gltf/fixture.h"

/** Loads the square with one edit. */
static enum pbnds_status try_edit(const char *from, const char *to,
                                  const struct pbnds_gltf_options *options)
{
    struct pbnds_scene s;
    char *json = edit(square_json, from, to);
    const enum pbnds_status status =
        load_with(json, &square, sizeof square, options, &s);
    if (status == PBNDS_OK) assert_sound(&s);
    pbnds_scene_free(&s);
    free(json);
    return status;
}

static void whole_numbers_may_have_a_fraction(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to;
        enum pbnds_status status;
    } cases[] = {
        {"\"count\":4", "\"count\":4.0", PBNDS_OK},
        {"\"count\":4", "\"count\":4.000e0", PBNDS_OK},
        {"\"count\":4", "\"count\":0.4e1", PBNDS_OK},
        {"\"count\":4", "\"count\":400E-2", PBNDS_OK},
        {"\"indices\":3", "\"indices\":3.0", PBNDS_OK},
        {"\"byteLength\":144", "\"byteLength\":144.0", PBNDS_OK},
        {"\"byteOffset\":128", "\"byteOffset\":128.00", PBNDS_OK},
        {"\"componentType\":5123", "\"componentType\":5123.0", PBNDS_OK},
        {"\"mesh\":0", "\"mesh\":0.0", PBNDS_OK},
        {"[{\"nodes\":[0]}]", "[{\"nodes\":[0.0]}]", PBNDS_OK},
        {"\"POSITION\":0", "\"POSITION\":0.0", PBNDS_OK},
        {"\"count\":4", "\"count\":4.5", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":4e-1", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":-4.0", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":04.0", PBNDS_ERROR_FORMAT}, /* no JSON */
        {"\"count\":4", "\"count\":4.", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":4.e0", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":1e99", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":1e-99999999999", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":9007199254740992", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":4294967296", PBNDS_ERROR_FORMAT}, /* not 0 */
        {"\"mesh\":0", "\"mesh\":4294967296.0", PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":128", "\"byteOffset\":4294967424", PBNDS_ERROR_FORMAT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const enum pbnds_status status = try_edit(cases[i].from, cases[i].to, NULL);
        if (status != cases[i].status) {
            fail_msg("%s gives %d, not %d: %s", cases[i].to, status, cases[i].status,
                     status ? fault.message : "");
        }
    }
}

static void real_numbers_stay_what_they_are(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_edit("{\"mesh\":0}", "{\"mesh\":0,\"translation\":[1.0,0.25,-2.0]}", &s);
    assert_near((double)s.lo.x, 1.0, 0);
    assert_near((double)s.lo.y, 0.25, 0);
    assert_near((double)s.lo.z, -2.0, 0);
    pbnds_scene_free(&s);
    load_edit("{\"mesh\":0}", "{\"mesh\":0,\"scale\":[1.5e1,2E0,1e-2]}", &s);
    assert_near((double)s.hi.x, 15.0, 1e-6);
    assert_near((double)s.hi.y, 2.0, 1e-6);
    pbnds_scene_free(&s);
}

/* An index accessor may have no bufferView: all zeros, or what its sparse part says. */
static void indices_may_be_sparse_only(void **state)
{
    (void)state;
    static const char plain[] =
        "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}";
    char *views =
        edit(square_json, "{\"buffer\":0,\"byteOffset\":128,\"byteLength\":12}",
             "{\"buffer\":0,\"byteOffset\":128,\"byteLength\":12},"
             "{\"buffer\":0,\"byteOffset\":144,\"byteLength\":6}");
    char *sized = edit(views, "\"byteLength\":144", "\"byteLength\":150");
    char *json =
        edit(sized, plain,
             "{\"componentType\":5123.0,\"count\":6,\"type\":\"SCALAR\",\"sparse\":{"
             "\"count\":6,\"indices\":{\"bufferView\":2,\"componentType\":5121},"
             "\"values\":{\"bufferView\":1}}}");
    struct {
        struct square square;
        uint8_t at[6];
        uint8_t pad[2];
    } bin = {square, {0, 1, 2, 3, 4, 5}, {0}};
    struct pbnds_scene s;
    must_load(json, &bin, sizeof bin, &s);
    assert_int_equal(s.triangle_count, 2);
    assert_int_equal(s.meshes[0].index[4], 2);
    pbnds_scene_free(&s);
    free(views);
    free(sized);
    free(json);
    assert_int_equal(
        try_edit(plain, "{\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}",
                 NULL),
        PBNDS_OK); /* six times vertex 0 */
    /* Extras of a primitive, before and after, do not get in the way. */
    assert_int_equal(
        try_edit("\"indices\":3", "\"extras\":7,\"indices\":3,\"extras\":{}", NULL),
        PBNDS_OK);
    assert_int_equal(try_edit("\"indices\":3", "\"indices\":9", NULL),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(try_edit("\"indices\":3", "\"extras\":9", NULL), PBNDS_OK);
}

static void lists_are_lists(void **state)
{
    (void)state;
    assert_int_equal(try_edit("\"scene\":0", "\"cameras\":{}", NULL),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(try_edit("\"scene\":0", "\"animations\":7", NULL),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(try_edit("\"primitives\":[", "\"primitives\":{},\"x\":[", NULL),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(try_edit("\"scene\":0", "\"lists\":{}", NULL), PBNDS_OK);
}

/** `count` times `item`, comma between, in brackets. */
static char *list_of(const char *head, const char *item, size_t count, const char *tail)
{
    const size_t size = strlen(item) + 1;
    char *out = malloc(strlen(head) + count * size + strlen(tail) + 1);
    char *at = out + sprintf(out, "%s", head);
    for (size_t i = 0; i < count; ++i) {
        memcpy(at, item, size - 1);
        at[size - 1] = i + 1 < count ? ',' : ' ';
        at += size;
    }
    strcpy(at, tail);
    return out;
}

/* A tiny document that becomes a large one: refused before anything is built. */
static void a_document_has_a_budget(void **state)
{
    (void)state;
    const struct pbnds_gltf_options tight = {.max_geometry = 64 << 20};
    static const struct {
        const char *head, *item, *tail;
        size_t count;
    } bombs[] = {
        {"\"materials\":[", "{}", "],\"scene\":0", 40000},
        {"\"cameras\":[", "{}", "],\"scene\":0", 100000},
        {"\"skins\":[", "{\"joints\":[0]}", "],\"scene\":0", 100000},
        {"\"extensions\":{\"X\":[", "0", "]},\"scene\":0", 300000},
        {"\"extensions\":{\"X\":[", "[]", "]},\"scene\":0", 300000},
    };
    for (size_t i = 0; i < sizeof bombs / sizeof bombs[0]; ++i) {
        char *text =
            list_of(bombs[i].head, bombs[i].item, bombs[i].count, bombs[i].tail);
        assert_int_equal(try_edit("\"scene\":0", text, &tight), PBNDS_ERROR_MEMORY);
        assert_non_null(strstr(fault.message, "--max-geometry"));
        free(text);
    }
    /* Extras are not kept: they cost the parser little. */
    char *text = list_of("\"extras\":[", "0", 300000, "],\"scene\":0");
    assert_int_equal(try_edit("\"scene\":0", text, &tight), PBNDS_OK);
    free(text);
}

/* Work that grows with the square of the file would take hours here. */
static void hostile_json_takes_linear_time(void **state)
{
    (void)state;
    /* Every sampler of an animation would copy the animation's extensions. */
    char *tree = list_of("\"animations\":[{\"extensions\":{\"X\":[", "0", 30000, "]},");
    char *samplers = list_of("\"samplers\":[", "{\"input\":0,\"output\":0}", 30000,
                             "],\"channels\":[]}],\"scene\":0");
    char *both = malloc(strlen(tree) + strlen(samplers) + 1);
    strcpy(both, tree);
    strcat(both, samplers);
    assert_int_equal(try_edit("\"scene\":0", both, NULL), PBNDS_OK);
    free(tree);
    free(samplers);
    free(both);
    static const struct {
        const char *head, *item, *tail;
        size_t count;
        enum pbnds_status status;
    } lists[] = {
        {"\"x\":{", "\"a\":1", "},\"scene\":0", 400000, PBNDS_OK},
        {"\"extensionsUsed\":[", "\"KHR_x\"", "],\"scene\":0", 200000, PBNDS_OK},
        {"\"scenes\":[", "{\"nodes\":[0]}", "],\"scene\":0", 100000, PBNDS_OK},
        {"\"x\":", "\"\\u0041\\\\\\\"\"", ",\"scene\":0", 1, PBNDS_OK},
        {"\"x\":[", "1e308", "],\"scene\":0", 200000, PBNDS_OK},
        {"\"x\":[", "0.00000000000000000000000000001e29", "],\"scene\":0", 100000,
         PBNDS_OK},
    };
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i) {
        char *text =
            list_of(lists[i].head, lists[i].item, lists[i].count, lists[i].tail);
        assert_int_equal(try_edit("\"scene\":0", text, NULL), lists[i].status);
        free(text);
    }
    /* A number of a million digits, a name of a million letters. */
    char *digits = list_of("\"x\":1", "", 1000000, ",\"scene\":0");
    for (char *p = digits; *p; ++p) {
        if (*p == ',' && p[1] == ',') *p = '9';
    }
    assert_int_equal(try_edit("\"scene\":0", digits, NULL), PBNDS_ERROR_FORMAT);
    free(digits);
}

static void many_nodes_are_fine(void **state)
{
    (void)state;
    char *nodes = list_of("\"nodes\":[{\"mesh\":0},", "{}", 300000, "]");
    assert_int_equal(try_edit("\"nodes\":[{\"mesh\":0}]", nodes, NULL), PBNDS_OK);
    free(nodes);
}

/* An integer that does not fit is a real number in an extension, not another one. */
static void large_numbers_of_extensions_keep_their_size(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_edit("\"scene\":0",
              "\"scene\":0,\"materials\":[{\"emissiveFactor\":[1,1,1],\"extensions\":{"
              "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":"
              "12345678901}}}]",
              &s);
    assert_near((double)s.materials[0].emissive.x, 12345678901.0, 1e5);
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_numbers_may_have_a_fraction),
        cmocka_unit_test(real_numbers_stay_what_they_are),
        cmocka_unit_test(indices_may_be_sparse_only),
        cmocka_unit_test(lists_are_lists),
        cmocka_unit_test(a_document_has_a_budget),
        cmocka_unit_test(hostile_json_takes_linear_time),
        cmocka_unit_test(many_nodes_are_fine),
        cmocka_unit_test(large_numbers_of_extensions_keep_their_size),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
