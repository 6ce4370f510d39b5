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
        "\"extensionsUsed\":[\"KHR_materials_ior\",\"EXT_of_nobody\"],"
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
    assert_non_null(strstr(warnings, "EXT_of_nobody"));
    assert_null(strstr(warnings, "KHR_materials_ior"));
    pbnds_scene_free(&s);
    free(a);
    free(json);
}

/* ---- extensions of materials ---------------------------------------------------- */

#define IMAGE "\"images\":[{\"uri\":\"data:image/png;base64," PNG_BASE64 "\"}]"

/** Loads the square with these materials and seven textures of one image. */
static enum pbnds_status load_materials(const char *materials, struct pbnds_scene *s)
{
    const size_t size = strlen(materials) + 1024;
    char *members = malloc(size);
    (void)snprintf(members, size,
                   "\"materials\":[%s],\"textures\":[{\"source\":0},{\"source\":0},"
                   "{\"source\":0},{\"source\":0},{\"source\":0},{\"source\":0},"
                   "{\"source\":0}]," IMAGE ",\"buffers\"",
                   materials);
    char *json = edit(square_json, "\"buffers\"", members);
    const enum pbnds_status status = load(json, &square, sizeof square, s);
    free(json);
    free(members);
    return status;
}

static void load_material(const char *material, struct pbnds_scene *s)
{
    if (load_materials(material, s) != PBNDS_OK) fail_msg("%s", fault.message);
    assert_int_equal(s->material_count, 2);
    assert_string_equal(warnings, "");
}

static void specular_is_read(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_material("{\"extensions\":{\"KHR_materials_specular\":{"
                  "\"specularFactor\":0.25,\"specularColorFactor\":[2,0.5,0],"
                  "\"specularTexture\":{\"index\":3},"
                  "\"specularColorTexture\":{\"index\":4,\"texCoord\":1}}}}",
                  &s);
    const struct pbnds_material *m = &s.materials[0];
    assert_near(m->specular, 0.25, 0);
    assert_vec3(m->specular_color, 2, 0.5, 0, 0); /* above one is allowed */
    assert_near(m->ior_f0, 0.04, 1e-7);
    assert_int_equal(m->specular_texture.texture, 0); /* the first that is used */
    assert_int_equal(m->specular_color_texture.texture, 1);
    assert_int_equal(m->specular_color_texture.texcoord, 1);
    assert_int_equal(m->base_color_texture.texture, -1);
    assert_false(m->unlit || m->specular_glossiness);
    assert_int_equal(s.texture_count, 2);
    assert_int_equal(s.image_count, 1);
    pbnds_scene_free(&s);
    /* An empty object is all defaults. */
    load_material("{\"extensions\":{\"KHR_materials_specular\":{}}}", &s);
    assert_near(s.materials[0].specular, 1, 0);
    assert_vec3(s.materials[0].specular_color, 1, 1, 1, 0);
    pbnds_scene_free(&s);
}

static void specular_glossiness_is_read(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_material(
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,1],"
        "\"baseColorTexture\":{\"index\":0},"
        "\"metallicRoughnessTexture\":{\"index\":1}},"
        "\"normalTexture\":{\"index\":2,\"scale\":-0.5},"
        "\"occlusionTexture\":{\"index\":5,\"strength\":0.75},"
        "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{"
        "\"diffuseFactor\":[0.1,0.2,0.3,0.4],\"diffuseTexture\":{\"index\":3},"
        "\"specularFactor\":[0.5,0.6,0.7],\"glossinessFactor\":0.75,"
        "\"specularGlossinessTexture\":{\"index\":4}}}}",
        &s);
    const struct pbnds_material *m = &s.materials[0];
    assert_true(m->specular_glossiness && !m->unlit);
    assert_near(m->base_color.x, 0.1, 1e-7);
    assert_near(m->base_color.w, 0.4, 1e-7);
    assert_vec3(m->specular_color, 0.5, 0.6, 0.7, 1e-7);
    assert_near(m->roughness, 0.25, 0); /* 1 - glossiness */
    assert_near(m->metallic, 0, 0);
    assert_near(m->normal_scale, -0.5, 0);
    assert_near(m->occlusion_strength, 0.75, 0);
    assert_int_equal(m->base_color_texture.texture, 0);
    assert_int_equal(m->metallic_roughness_texture.texture, -1);
    assert_int_equal(m->normal_texture.texture, 1);
    assert_int_equal(m->occlusion_texture.texture, 2);
    assert_int_equal(m->specular_color_texture.texture, 3);
    assert_int_equal(m->specular_texture.texture, -1);
    pbnds_scene_free(&s);
    load_material("{\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{}}}", &s);
    assert_true(s.materials[0].specular_glossiness);
    assert_near(s.materials[0].roughness, 0, 0);
    assert_near(s.materials[0].base_color.y, 1, 0);
    assert_vec3(s.materials[0].specular_color, 1, 1, 1, 0);
    pbnds_scene_free(&s);
}

/* What is unlit shows the base colour of the core, whatever else it says. */
static void unlit_is_read(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_material("{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0,1]},"
                  "\"extensions\":{\"KHR_materials_unlit\":{},"
                  "\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":"
                  "[0,0,0,1]}}}",
                  &s);
    assert_true(s.materials[0].unlit && !s.materials[0].specular_glossiness);
    assert_near(s.materials[0].base_color.y, 0.5, 0);
    pbnds_scene_free(&s);
}

/* ---- KHR_texture_transform ------------------------------------------------------- */

static struct pbnds_vec2 apply(const struct pbnds_texture_ref *ref, float u, float v)
{
    const float *t = ref->transform;
    return (struct pbnds_vec2){t[0] * u + t[1] * v + t[2], t[3] * u + t[4] * v + t[5]};
}

static void assert_maps(const struct pbnds_texture_ref *ref, float u, float v, double x,
                        double y)
{
    const struct pbnds_vec2 at = apply(ref, u, v);
    assert_near(at.x, x, 1e-6);
    assert_near(at.y, y, 1e-6);
}

#define TRANSFORM(members) "\"extensions\":{\"KHR_texture_transform\":{" members "}}"

/* The extension's own examples, and three turned corners worked out by hand. */
static void transforms_are_folded(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_material(
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":"
        "0," TRANSFORM(
            "\"offset\":[0,1],\"rotation\":1.57079632679,"
            "\"scale\":[0.5,0.5]") "},"
                                   "\"metallicRoughnessTexture\":{"
                                   "\"index\":1," TRANSFORM(
                                       "\"off"
                                       "set\""
                                       ":[0,"
                                       "1],"
                                       "\"sca"
                                       "le\":"
                                       "[1,-"
                                       "1],"
                                       "\"tex"
                                       "Coord"
                                       "\":1") "}},\"normalTexture\":{\"index\":"
                                               "2," TRANSFORM(
                                                   "\"rotation\":0") "},"
                                                                     "\"occl"
                                                                     "usionT"
                                                                     "exture"
                                                                     "\":{"
                                                                     "\"inde"
                                                                     "x\":3,"
                                                                     "\"texC"
                                                                     "oord\""
                                                                     ":1"
                                                                     "," TRANSFORM(
                                                                         "\"texCoord\":"
                                                                         "0") "},"
                                                                              "\"emissi"
                                                                              "veTextur"
                                                                              "e\":{"
                                                                              "\"index"
                                                                              "\":"
                                                                              "4"
                                                                              "," TRANSFORM(
                                                                                  "\"ro"
                                                                                  "tati"
                                                                                  "on\""
                                                                                  ":1."
                                                                                  "5707"
                                                                                  "9632"
                                                                                  "679,"
                                                                                  "\"sc"
                                                                                  "ale"
                                                                                  "\":["
                                                                                  "2,3]"
                                                                                  ",\"o"
                                                                                  "ffse"
                                                                                  "t\":"
                                                                                  "[10,"
                                                                                  "20]") "},\"extensions\":{\"KHR_materials_specular\":{\"specularTexture\":{"
                                                                                         "\"index\":5," TRANSFORM(
                                                                                             "\"offset\":[0.25,0]") "},\"specularColorTexture\":{\"index\":6}}}}",
        &s);
    const struct pbnds_material *m = &s.materials[0];
    /* The lower left quarter of the image, turned clockwise by 90 degrees: its left edge
     * from the bottom up lies along the top from the left. */
    const struct pbnds_texture_ref *r = &m->base_color_texture;
    assert_true(r->transformed);
    assert_maps(r, 0, 0, 0, 1);
    assert_maps(r, 1, 0, 0, 0.5);
    assert_maps(r, 0, 1, 0.5, 1);
    r = &m->metallic_roughness_texture;
    assert_int_equal(r->texcoord, 1);
    assert_maps(r, 0.25f, 0.25f, 0.25, 0.75);
    /* Nothing to do: the identity. */
    assert_false(m->normal_texture.transformed);
    assert_false(m->occlusion_texture.transformed);
    assert_int_equal(m->occlusion_texture.texcoord, 0);
    assert_false(m->specular_color_texture.transformed);
    /* First scaled, then turned, then moved. */
    r = &m->emissive_texture;
    assert_maps(r, 1, 0, 10, 18);
    assert_maps(r, 0, 1, 13, 20);
    r = &m->specular_texture;
    assert_true(r->transformed);
    assert_maps(r, 0, 0, 0.25, 0);
    pbnds_scene_free(&s);
}

/* The map turned by 90 degrees: u' = v, which grows downward, v' = -u. The tangents that
 * the file lacks turn with it, its UVs stay. */
static void a_turned_normal_map_turns_its_tangents(void **state)
{
    (void)state;
    static const char *const maps[2] = {
        "{\"normalTexture\":{\"index\":0}}",
        "{\"normalTexture\":{\"index\":0," TRANSFORM(
            "\"rotation\":1.57079632679,\"scale\":[0.5,2],\"offset\":[3,4]") "}}"};
    for (int turned = 0; turned < 2; ++turned) {
        for (int flat = 0; flat < 2; ++flat) { /* without normals: three of each */
            struct pbnds_scene s;
            char members[1024];
            (void)snprintf(members, sizeof members,
                           "\"materials\":[%s],\"textures\":[{\"source\":0}]," IMAGE
                           ",\"buffers\"",
                           maps[turned]);
            char *a = edit(square_json, "\"buffers\"", members);
            char *b = edit(a, "\"indices\":3", "\"indices\":3,\"material\":0");
            char *json =
                flat ? edit(b, "\"NORMAL\":1,", "") : edit(b, "asset", "asset");
            must_load(json, &square, sizeof square, &s);
            const struct pbnds_mesh *m = &s.meshes[0];
            assert_non_null(m->tangent);
            for (size_t i = 0; i < m->vertex_count; ++i) {
                const struct pbnds_vec4 t = m->tangent[i];
                assert_vec3(pbnds_vec3_make(t.x, t.y, t.z), turned ? 0 : 1,
                            turned ? -1 : 0, 0, 1e-6);
                assert_true(t.w == 1.0f);
                assert_near(m->uv[0][i].x, m->position[i].x, 0);
                assert_near(m->uv[0][i].y, 1.0f - m->position[i].y, 0);
            }
            pbnds_scene_free(&s);
            free(a);
            free(b);
            free(json);
        }
    }
}

static void transforms_must_be_sane(void **state)
{
    (void)state;
    static const char *const bad[] = {"\"scale\":[1e300,1]", "\"offset\":[0,-1e39]",
                                      "\"scale\":[1,2e6]"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        struct pbnds_scene s;
        char material[256];
        (void)snprintf(material, sizeof material,
                       "{\"normalTexture\":{\"index\":0," TRANSFORM("%s") "}}", bad[i]);
        assert_int_equal(load_materials(material, &s), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(fault.message, "KHR_texture_transform"));
    }
}

static void only_two_texture_coordinates(void **state)
{
    (void)state;
    struct pbnds_scene s;
    const char *materials = "{\"normalTexture\":{\"index\":0,\"texCoord\":2},"
                            "\"emissiveTexture\":{\"index\":1," TRANSFORM(
                                "\"texCoord\":7") "},"
                                                  "\"occlusionTexture\":{\"index\":2}}";
    assert_int_equal(load_materials(materials, &s), PBNDS_OK);
    assert_int_equal(s.materials[0].normal_texture.texture, -1);
    assert_int_equal(s.materials[0].emissive_texture.texture, -1);
    assert_int_equal(s.materials[0].occlusion_texture.texture, 0);
    const char *first = strstr(warnings, "TEXCOORD_2");
    assert_non_null(first);
    assert_null(strstr(first + 1, "TEXCOORD")); /* told once */
    pbnds_scene_free(&s);
}

static void dangling_textures_are_told(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "{\"occlusionTexture\":{\"index\":7}}",
        "{\"extensions\":{\"KHR_materials_specular\":{\"specularTexture\":{"
        "\"index\":7}}}}",
        "{\"extensions\":{\"KHR_materials_specular\":{\"specularColorTexture\":{"
        "\"index\":-1}}}}",
        "{\"extensions\":{\"KHR_materials_specular\":{\"specularColorTexture\":{"
        "\"index\":0.5}}}}",
        "{\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{"
        "\"specularGlossinessTexture\":{\"index\":4294967296}}}}",
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        struct pbnds_scene s;
        if (load_materials(bad[i], &s) != PBNDS_ERROR_FORMAT) fail_msg("%s", bad[i]);
    }
    /* What is no object is no extension. */
    struct pbnds_scene s;
    load_material("{\"extensions\":{\"KHR_materials_specular\":7,"
                  "\"KHR_materials_ior\":[],\"KHR_materials_unlit\":\"x\"}}",
                  &s);
    assert_false(s.materials[0].unlit);
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_are_read),
        cmocka_unit_test(specular_is_read),
        cmocka_unit_test(specular_glossiness_is_read),
        cmocka_unit_test(unlit_is_read),
        cmocka_unit_test(transforms_are_folded),
        cmocka_unit_test(a_turned_normal_map_turns_its_tangents),
        cmocka_unit_test(transforms_must_be_sane),
        cmocka_unit_test(only_two_texture_coordinates),
        cmocka_unit_test(dangling_textures_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
