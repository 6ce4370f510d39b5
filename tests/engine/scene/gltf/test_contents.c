/* What a file lists. */
#include "engine/core/file.h"
#include "tests/engine/scene/gltf/builder.h"

static void write_built(const struct builder *b, const char *rest, const char *path)
{
    static char json[32768];
    size_t size = 0;
    (void)snprintf(
        json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu}],"
        "\"bufferViews\":[%s],\"accessors\":[%s],%s}",
        b->size, b->views, b->accessors, rest);
    uint8_t *glb = make_glb(json, b->bin, (b->size + 3) / 4 * 4, &size);
    assert_int_equal(pbnds_file_write(path, glb, size, &fault), PBNDS_OK);
    free(glb);
}

static void everything_is_listed(void **state)
{
    (void)state;
    static const float times[] = {0, 0.5f, 2.25f}, longer[] = {1, 4}, places[9] = {0};
    struct builder b = build_square();
    (void)add_floats(&b, times, 3, 1);
    (void)add_floats(&b, longer, 2, 1);
    (void)add_floats(&b, places, 3, 3);
    write_built(
        &b,
        "\"scene\":1,\"scenes\":[{\"name\":\"a\",\"nodes\":[0]},{\"nodes\":[0,1]}],"
        "\"nodes\":[{},{}],\"skins\":[{\"joints\":[0,1],\"name\":\"bones\"}],"
        "\"animations\":[{\"name\":\"run\",\"samplers\":[{\"input\":4,\"output\":6},"
        "{\"input\":5,\"output\":6}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":"
        "0,"
        "\"path\":\"translation\"}}]},{\"samplers\":[{\"input\":4,\"output\":6},"
        "{\"input\":5,\"output\":6}],\"channels\":[{\"sampler\":1,\"target\":{\"node\":"
        "0,"
        "\"path\":\"translation\"}},{\"sampler\":0,\"target\":{\"node\":1,"
        "\"path\":\"translation\"}}]}],"
        "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"red\"},"
        "{\"name\":\"blue\"}]}}",
        "contents.glb");
    struct pbnds_gltf_contents c;
    assert_int_equal(pbnds_gltf_list("contents.glb", NULL, &c, &fault), PBNDS_OK);
    assert_int_equal(c.scene_count, 2);
    assert_int_equal(c.default_scene, 1);
    assert_string_equal(c.scenes[0].name, "a");
    assert_string_equal(c.scenes[1].name, "scene 1");
    assert_int_equal(c.scenes[1].count, 2);
    assert_int_equal(c.animation_count, 2);
    assert_string_equal(c.animations[0].name, "run");
    assert_near(c.animations[0].seconds, 2.25, 0);
    assert_near(c.animations[1].seconds, 4, 0);
    assert_int_equal(c.animations[1].count, 2);
    assert_int_equal(c.variant_count, 2);
    assert_string_equal(c.variants[1].name, "blue");
    assert_int_equal(c.skin_count, 1);
    assert_string_equal(c.skins[0].name, "bones");
    assert_int_equal(c.skins[0].count, 2);
    pbnds_gltf_contents_free(&c);
    pbnds_gltf_contents_free(&c);
    /* What is listed can be chosen. */
    const struct pbnds_gltf_options options = {.scene = "scene 1"};
    struct pbnds_scene s;
    assert_int_equal(pbnds_gltf_load("contents.glb", &options, NULL, &s, &fault),
                     PBNDS_OK);
    pbnds_scene_free(&s);
}

static void nothing_is_listed_of_a_bad_file(void **state)
{
    (void)state;
    struct pbnds_gltf_contents c;
    assert_int_equal(pbnds_gltf_list("not-there.glb", NULL, &c, &fault),
                     PBNDS_ERROR_IO);
    assert_null(c.scenes);
    struct builder b = build_square();
    write_built(
        &b,
        "\"nodes\":[{}],\"animations\":[{\"samplers\":[{\"input\":0,\"output\":0}]"
        ",\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
        "\"scale\"}}]}]",
        "contents-bad.glb");
    assert_int_equal(pbnds_gltf_list("contents-bad.glb", NULL, &c, &fault),
                     PBNDS_ERROR_FORMAT);
    assert_null(c.animations);
    assert_non_null(strstr(fault.message, "contents-bad.glb"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_is_listed),
        cmocka_unit_test(nothing_is_listed_of_a_bad_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
