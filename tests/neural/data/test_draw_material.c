/* Other materials: drawn within bounds, given back whole, lights and windows untouched. */
#include "tests/neural/data/fixture_scene.h"

#include "neural/data/draw_material.h"

enum { PLAIN, METAL, PAPER, CLOTH, BARE, GLOW, PANE, PICTURE, GLOSSY, UNUSED, COUNT };

static const char *const NAMES[COUNT] = {"plain",  "metal", "paper", "cloth",
                                         "bare",   "glow",  "pane",  "picture",
                                         "glossy", "unused"};

static struct pbnds_scene make_scene(void)
{
    struct pbnds_scene s;
    fixture_scene(&s);
    s.material_count = COUNT;
    s.maps = calloc(1, sizeof *s.maps);
    assert_non_null(s.maps);
    s.maps->bundles = calloc(1, sizeof *s.maps->bundles);
    s.maps->materials = calloc(COUNT, sizeof *s.maps->materials);
    assert_non_null(s.maps->materials);
    for (int i = 0; i < COUNT; ++i) {
        struct pbnds_material *m = &s.materials[i];
        *m = pbnds_material_default();
        (void)snprintf(m->name, sizeof m->name, "%s", NAMES[i]);
        m->metallic = i == METAL ? 1.0f : 0.0f;
        m->roughness = 0.5f;
        m->base_color = (struct pbnds_vec4){0.6f, 0.4f, 0.3f, 1.0f};
        m->base_color_texture.texture = i == PLAIN || i == METAL ? -1 : i;
        m->normal_texture.texture = i == CLOTH ? 20 : -1;
        for (int map = 0; map < PBNDS_MAP_COUNT; ++map)
            s.maps->materials[i].bundle[map] = 100 * i + map;
        if (i == UNUSED) continue;
        fixture_box(&s, pbnds_splat((float)i), pbnds_splat((float)i + 0.5f), false);
        s.meshes[i].material = i;
        if (i == BARE) continue; /* has no texture coordinates */
        s.meshes[i].uv[0] = calloc(8, sizeof *s.meshes[i].uv[0]);
    }
    s.materials[GLOW].emissive = pbnds_vec3_make(0.0f, 2.0f, 0.0f);
    s.materials[PANE].alpha_mode = PBNDS_ALPHA_BLEND;
    s.materials[PICTURE].unlit = true;
    s.materials[GLOSSY].specular_glossiness = true;
    return s;
}

static bool same_material(const struct pbnds_material *a,
                          const struct pbnds_material *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

static void check_bounds(const struct pbnds_material *m)
{
    const float c[3] = {m->base_color.x, m->base_color.y, m->base_color.z};
    for (int k = 0; k < 3; ++k)
        assert_true(c[k] >= 0.0f && c[k] <= 1.0f);
    assert_true(m->base_color.w == 1.0f);
    assert_true(m->roughness >= 0.03f && m->roughness <= 1.0f);
    assert_true(m->metallic == 0.0f || m->metallic == 1.0f);
    assert_true(m->normal_scale >= 0.0f && m->normal_scale <= 2.0f);
    assert_true(m->specular >= 0.3f && m->specular <= 1.0f);
    assert_true(m->ior_f0 >= 0.02f && m->ior_f0 <= 0.08f);
}

static void factors_are_drawn_within_bounds(void **state)
{
    (void)state;
    struct pbnds_scene s = make_scene();
    struct pbnds_material_store store;
    assert_int_equal(pbnds_materials_keep(&s, &store, NULL), PBNDS_OK);
    int to_metal = 0, from_metal = 0, shiny = 0, rough = 0, others = 0;
    for (int i = 0; i < 300; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(1, (uint64_t)i, 4);
        pbnds_materials_restore(&store, &s);
        pbnds_materials_randomize(&s, false, &rng);
        for (int m = 0; m < COUNT; ++m) {
            if (m == GLOW || m == PANE || m == PICTURE)
                assert_true(same_material(&s.materials[m], &store.materials[m]));
            else
                check_bounds(&s.materials[m]);
            assert_int_equal(s.materials[m].base_color_texture.texture,
                             store.materials[m].base_color_texture.texture);
        }
        /* What multiplies a texture never brightens it. */
        assert_true(s.materials[PAPER].base_color.x <= 1.0f);
        to_metal += s.materials[PLAIN].metallic > 0.5f;
        from_metal += s.materials[METAL].metallic < 0.5f;
        shiny += s.materials[PLAIN].roughness < 0.25f;
        rough += s.materials[PLAIN].roughness > 0.75f;
        others +=
            memcmp(&s.materials[PLAIN].base_color, &store.materials[PLAIN].base_color,
                   sizeof s.materials[PLAIN].base_color) != 0;
        assert_int_equal(s.materials[GLOSSY].metallic, 0);
        const struct pbnds_vec4 c = s.materials[PLAIN].base_color;
        if (s.materials[PLAIN].metallic > 0.5f) /* metals are bright */
            assert_true(0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z > 0.4f);
    }
    assert_true(to_metal > 25 && to_metal < 80);
    assert_true(from_metal > 45 && from_metal < 110);
    assert_true(shiny > 20 && rough > 20 && others > 280);
    pbnds_material_store_free(&store);
    pbnds_scene_free(&s);
}

static void skin_stays_skin(void **state)
{
    (void)state;
    struct pbnds_scene s = make_scene();
    struct pbnds_material_store store;
    assert_int_equal(pbnds_materials_keep(&s, &store, NULL), PBNDS_OK);
    float low = 1.0f, high = 0.0f;
    for (int i = 0; i < 100; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(2, (uint64_t)i, 4);
        pbnds_materials_restore(&store, &s);
        pbnds_materials_randomize(&s, true, &rng);
        const struct pbnds_material *m = &s.materials[PAPER];
        low = fminf(low, m->roughness);
        high = fmaxf(high, m->roughness);
        assert_true(m->roughness >= 0.3f && m->roughness <= 0.7f);
        assert_true(m->metallic == 0.0f);
        assert_true(m->base_color.x > 0.8f * 0.6f * 0.8f);
    }
    assert_true(low < 0.34f && high > 0.66f);
    pbnds_material_store_free(&store);
    pbnds_scene_free(&s);
}

static void maps_change_hands_whole(void **state)
{
    (void)state;
    struct pbnds_scene s = make_scene();
    struct pbnds_material_store store;
    assert_int_equal(pbnds_materials_keep(&s, &store, NULL), PBNDS_OK);
    bool seen[COUNT][COUNT] = {{false}};
    for (int i = 0; i < 60; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(3, (uint64_t)i, 4);
        pbnds_materials_restore(&store, &s);
        assert_int_equal(pbnds_materials_swap(&store, &s, &rng), 4);
        bool taken[COUNT] = {false};
        for (int m = 0; m < COUNT; ++m) {
            const int from = s.maps->materials[m].bundle[0] / 100;
            assert_false(taken[from]); /* nobody's maps are lost */
            taken[from] = true;
            seen[m][from] = true;
            for (int map = 0; map < PBNDS_MAP_COUNT; ++map)
                assert_int_equal(s.maps->materials[m].bundle[map], 100 * from + map);
            assert_int_equal(s.materials[m].base_color_texture.texture,
                             store.materials[from].base_color_texture.texture);
            assert_int_equal(s.materials[m].normal_texture.texture,
                             store.materials[from].normal_texture.texture);
            assert_string_equal(s.materials[m].name, NAMES[m]);
            const bool swaps = m == PLAIN || m == METAL || m == PAPER || m == CLOTH;
            if (swaps)
                assert_int_not_equal(from, m);
            else
                assert_true(same_material(&s.materials[m], &store.materials[m]));
        }
    }
    for (int a = PLAIN; a <= CLOTH; ++a) {
        for (int b = PLAIN; b <= CLOTH; ++b)
            assert_int_equal(seen[a][b], a != b);
    }
    pbnds_materials_restore(&store, &s);
    for (int m = 0; m < COUNT; ++m) {
        assert_true(same_material(&s.materials[m], &store.materials[m]));
        assert_int_equal(s.maps->materials[m].bundle[2], 100 * m + 2);
    }
    pbnds_material_store_free(&store);
    pbnds_scene_free(&s);
}

static void equal_streams_give_equal_materials(void **state)
{
    (void)state;
    struct pbnds_scene a = make_scene(), b = make_scene();
    struct pbnds_material_store store;
    assert_int_equal(pbnds_materials_keep(&a, &store, NULL), PBNDS_OK);
    for (int i = 0; i < 5; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(4, (uint64_t)i, 4);
        pbnds_materials_restore(&store, &a);
        (void)pbnds_materials_swap(&store, &a, &rng);
        pbnds_materials_randomize(&a, false, &rng);
    }
    struct pbnds_rng rng = pbnds_rng_make(4, 4, 4);
    (void)pbnds_materials_swap(&store, &b, &rng);
    pbnds_materials_randomize(&b, false, &rng);
    for (int m = 0; m < COUNT; ++m)
        assert_true(same_material(&a.materials[m], &b.materials[m]));
    pbnds_material_store_free(&store);
    pbnds_scene_free(&a);
    pbnds_scene_free(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(factors_are_drawn_within_bounds),
        cmocka_unit_test(skin_stays_skin),
        cmocka_unit_test(maps_change_hands_whole),
        cmocka_unit_test(equal_streams_give_equal_materials),
    };
    return cmocka_run_group_tests_name("neural/data/draw_material", tests, NULL, NULL);
}
