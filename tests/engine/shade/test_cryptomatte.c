#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/shade/cryptomatte.h"

static float as_float(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* The pairs of the specification's own tests (cryptomatte_utilities_tests.py), two of
 * them in UTF-8. They agree with an independent MurmurHash3. */
static void published_names_and_ids(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        float id;
    } pairs[] = {
        {"hello", 6.0705627102400005616e-17f},
        {"cube", -4.08461912519e+15f},
        {"sphere", 2.79018604383e+15f},
        {"plane", 3.66557617593e-11f},
        {"\xd1\x80\xd0\xb0\xd0\xb2\xd0\xbd\xd0\xb8\xd0\xbd\xd0\xb0",
         -1.3192631212399999468e-25f},
        {"m\xc3\xa4"
         "dchen",
         6.2361298211599995797e+25f},
    };
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; ++i)
        assert_true(as_float(pbnds_cryptomatte_id(pairs[i].name)) == pairs[i].id);
}

/* Every length of the last, incomplete word. */
static void murmur3_of_short_keys(void **state)
{
    (void)state;
    assert_int_equal(pbnds_murmur3_32("", 0, 0), 0u);
    assert_int_equal(pbnds_murmur3_32("a", 1, 0), 0x3c2569b2u);
    assert_int_equal(pbnds_murmur3_32("ab", 2, 0), 0x9bbfd75fu);
    assert_int_equal(pbnds_murmur3_32("abc", 3, 0), 0xb3dd93fau);
    assert_int_equal(pbnds_murmur3_32("CryptoObject", 12, 0), 0x3ae39a58u);
    assert_int_equal(pbnds_murmur3_32("", 0, 1), 0x514e28b7u);
}

/* n17 and n535 hash to exponents 0 and 255: a denormal and an infinity or NaN. */
static void ids_are_normal_floats(void **state)
{
    (void)state;
    assert_int_equal(pbnds_murmur3_32("n17", 3, 0), 0x000738c5u);
    assert_int_equal(pbnds_cryptomatte_id("n17"), 0x008738c5u);
    assert_int_equal(pbnds_murmur3_32("n535", 4, 0), 0xff8d97efu);
    assert_int_equal(pbnds_cryptomatte_id("n535"), 0xff0d97efu);
    char name[16];
    for (int i = 0; i < 20000; ++i) {
        snprintf(name, sizeof name, "n%d", i);
        assert_true(isnormal(as_float(pbnds_cryptomatte_id(name))));
    }
}

static void ranks_are_sorted_and_merged(void **state)
{
    (void)state;
    struct pbnds_cryptomatte *c = NULL;
    struct pbnds_error error;
    assert_int_equal(pbnds_cryptomatte_create(2, 1, &c, &error), PBNDS_OK);
    assert_string_equal(c->layers[0].name, "CryptoObject");
    assert_string_equal(c->layers[1].name, "CryptoMaterial");
    const uint32_t a = pbnds_cryptomatte_id("a"), b = pbnds_cryptomatte_id("b"),
                   d = pbnds_cryptomatte_id("d");
    struct pbnds_cryptomatte_part parts[] = {
        {a, 0.125f}, {b, 0.25f}, {d, 0.25f}, {a, 0.25f}};
    pbnds_cryptomatte_store(&c->layers[1], 1, parts, 4);
    static const float shares[] = {0.375f, 0.25f, 0.25f, 0.0f, 0.0f, 0.0f};
    const uint32_t ids[] = {a, b, d, 0, 0, 0};
    for (int r = 0; r < PBNDS_CRYPTOMATTE_RANKS; ++r) {
        assert_near(c->layers[1].share[r][1], shares[r], 0.0);
        assert_memory_equal(&c->layers[1].id[r][1], &ids[r], sizeof ids[r]);
        assert_near(c->layers[1].share[r][0], 0.0, 0.0);
        assert_near(c->layers[0].share[r][1], 0.0, 0.0);
    }
    /* Nine parts: the six greatest stay. */
    struct pbnds_cryptomatte_part many[9];
    for (uint32_t k = 0; k < 9; ++k)
        many[k] = (struct pbnds_cryptomatte_part){0x3f800000u + k, (float)k / 64.0f};
    pbnds_cryptomatte_store(&c->layers[0], 0, many, 9);
    for (int r = 0; r < PBNDS_CRYPTOMATTE_RANKS; ++r)
        assert_near(c->layers[0].share[r][0], (8 - r) / 64.0, 0.0);
    pbnds_cryptomatte_free(c);
}

static void manifests_name_what_has_a_mesh(void **state)
{
    (void)state;
    struct pbnds_object objects[4] = {{"roof \"A\""}, {"unused"}, {""}, {"b\\\n"}};
    struct pbnds_material materials[3];
    for (int i = 0; i < 3; ++i)
        materials[i] = pbnds_material_default();
    snprintf(materials[0].name, sizeof materials[0].name, "cube");
    struct pbnds_mesh meshes[5];
    memset(meshes, 0, sizeof meshes);
    static const uint32_t nodes[] = {3, 0, 2, 0, 77};
    for (int i = 0; i < 5; ++i) {
        meshes[i].object_id = nodes[i];
        meshes[i].material = i == 4 ? 2 : 0;
    }
    materials[2].name[0] = 0;
    const struct pbnds_scene scene = {.meshes = meshes,
                                      .mesh_count = 5,
                                      .materials = materials,
                                      .material_count = 3,
                                      .objects = objects,
                                      .object_count = 4};
    struct pbnds_cryptomatte *c = NULL;
    struct pbnds_error error;
    assert_int_equal(pbnds_cryptomatte_create(1, 1, &c, &error), PBNDS_OK);
    assert_int_equal(pbnds_cryptomatte_name(c, &scene, &error), PBNDS_OK);
    char want[256];
    snprintf(want, sizeof want,
             "{\"b\\\\\\u000a\":\"%08x\",\"node_2\":\"%08x\",\"node_77\":\"%08x\","
             "\"roof \\\"A\\\"\":\"%08x\"}",
             pbnds_cryptomatte_id("b\\\n"), pbnds_cryptomatte_id("node_2"),
             pbnds_cryptomatte_id("node_77"), pbnds_cryptomatte_id("roof \"A\""));
    assert_string_equal(c->layers[0].manifest, want);
    snprintf(want, sizeof want, "{\"cube\":\"d9682f08\",\"material_2\":\"%08x\"}",
             pbnds_cryptomatte_id("material_2"));
    assert_string_equal(c->layers[1].manifest, want);
    pbnds_cryptomatte_free(c);
    pbnds_cryptomatte_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(published_names_and_ids),
        cmocka_unit_test(murmur3_of_short_keys),
        cmocka_unit_test(ids_are_normal_floats),
        cmocka_unit_test(ranks_are_sorted_and_merged),
        cmocka_unit_test(manifests_name_what_has_a_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
