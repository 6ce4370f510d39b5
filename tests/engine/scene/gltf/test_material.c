/* Materials, textures and images. */
#include "tests/engine/scene/gltf/fixture.h"

static void materials_are_read(void **state)
{
    (void)state;
    struct pbnds_scene s;
    char *a = edit(square_json, "\"indices\":3", "\"indices\":3,\"material\":1");
    char *json = edit(
        a, "\"buffers\"",
        "\"materials\":[{},{\"name\":\"gold\",\"pbrMetallicRoughness\":{"
        "\"baseColorFactor\":"
        "[0.1,0.2,0.3,0.4],\"metallicFactor\":0.5,\"roughnessFactor\":0.25,"
        "\"baseColorTexture\":{\"index\":1,\"texCoord\":1},"
        "\"metallicRoughnessTexture\":{\"index\":0}},"
        "\"emissiveFactor\":[1,0.5,0],\"emissiveTexture\":{\"index\":2},"
        "\"alphaMode\":\"MASK\",\"alphaCutoff\":0.75,"
        "\"doubleSided\":true,\"extensions\":{\"KHR_materials_emissive_strength\":"
        "{\"emissiveStrength\":8},\"KHR_materials_ior\":{\"ior\":2},"
        "\"KHR_materials_specular\":{\"specularFactor\":0.5}}},"
        "{\"alphaMode\":\"BLEND\",\"extensions\":{\"KHR_materials_ior\":{\"ior\":0}}}],"
        "\"textures\":[{\"source\":0},{\"source\":0,\"sampler\":0},{\"source\":1},{"
        "\"source\":"
        "1}],\"samplers\":[{\"wrapS\":33071,\"wrapT\":33648,\"magFilter\":9728}],"
        "\"images\":[{\"uri\":\"data:image/png;base64," PNG_BASE64 "\"},"
        "{\"uri\":\"data:;base64," PNG_BASE64 "\"}],"
        "\"extensionsUsed\":[\"KHR_materials_ior\",\"KHR_lights_punctual\"],"
        "\"buffers\"");
    must_load(json, &square, sizeof square, &s);
    assert_int_equal(s.material_count, 4); /* the default at the end */
    assert_int_equal(s.meshes[0].material, 1);
    const struct pbnds_material *m = &s.materials[1];
    assert_string_equal(m->name, "gold");
    assert_near((double)m->base_color.w, 0.4, 1e-7);
    assert_near((double)m->metallic, 0.5, 0);
    assert_near((double)m->roughness, 0.25, 0);
    assert_near((double)m->ior_f0, 1.0 / 9.0, 1e-7);
    assert_near((double)m->specular, 0.5, 0);
    assert_vec3(m->emissive, 8, 4, 0, 0);
    assert_int_equal(m->alpha_mode, PBNDS_ALPHA_MASK);
    assert_near((double)m->alpha_cutoff, 0.75, 0);
    assert_true(m->double_sided);
    assert_int_equal(m->normal_texture.texture, -1);
    assert_int_equal(m->base_color_texture.texcoord, 1);
    assert_int_equal(s.materials[2].alpha_mode, PBNDS_ALPHA_BLEND);
    assert_near((double)s.materials[2].ior_f0, 1.0, 0);
    assert_near((double)s.materials[3].roughness, 1.0, 0);
    /* Three of four textures are used, both images decoded once. */
    assert_int_equal(s.texture_count, 3);
    assert_int_equal(s.image_count, 2);
    const struct pbnds_texture *t = &s.textures[m->base_color_texture.texture];
    assert_int_equal(t->wrap_u, PBNDS_WRAP_CLAMP);
    assert_int_equal(t->wrap_v, PBNDS_WRAP_MIRROR);
    assert_true(t->nearest);
    assert_ptr_equal(t->pixels,
                     s.textures[m->metallic_roughness_texture.texture].pixels);
    assert_ptr_not_equal(t->pixels, s.textures[m->emissive_texture.texture].pixels);
    const struct pbnds_vec4 c =
        pbnds_texture_sample(t, (struct pbnds_vec2){0.75f, 0.5f}, true);
    assert_near((double)c.x, 0, 0);
    assert_near((double)c.y, 1, 0);
    assert_near((double)c.w, 128.0 / 255.0, 1e-7);
    assert_non_null(strstr(warnings, "KHR_lights_punctual"));
    assert_null(strstr(warnings, "KHR_materials_ior"));
    pbnds_scene_free(&s);
    free(a);
    free(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
