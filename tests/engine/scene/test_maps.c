/* Prefiltered maps: levels against means by hand, levels of detail against geometry. */
#include "tests/test.h"

#include "engine/scene/lookup.h"
#include "tests/engine/scene/fixture.h"

/* The unit square in the plane z = 0; u to the right, v down, from 0 to 1. */
struct square {
    struct fixture f;
    struct pbnds_vec3 p[4], n[4];
    struct pbnds_vec4 t[4];
    struct pbnds_vec2 uv[4];
    uint32_t index[6];
};

static void make_square(struct square *s)
{
    static const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    memset(s, 0, sizeof *s);
    memcpy(s->index, index, sizeof index);
    fixture_init(&s->f);
    for (int i = 0; i < 4; ++i) {
        const float x = i == 1 || i == 2 ? 1.0f : 0.0f, y = i >= 2 ? 1.0f : 0.0f;
        s->p[i] = pbnds_vec3_make(x, y, 0.0f);
        s->n[i] = pbnds_vec3_make(0.0f, 0.0f, 1.0f);
        s->t[i] = (struct pbnds_vec4){1.0f, 0.0f, 0.0f, 1.0f};
        s->uv[i] = (struct pbnds_vec2){x, 1.0f - y};
    }
    struct pbnds_mesh *mesh = fixture_mesh(&s->f, s->p, 4, s->index, 2);
    mesh->normal = s->n;
    mesh->tangent = s->t;
    mesh->uv[0] = s->uv;
    s->f.scene.material_count = 1;
}

/* A texture of the caller's texels, filtered. */
static int add_texture(struct square *s, float *texels, int width, int height)
{
    const int i = fixture_texture(&s->f, texels, width, height);
    s->f.textures[i].nearest = false;
    return i;
}

static void prefilter(struct square *s, uint64_t budget)
{
    struct pbnds_error error;
    if (pbnds_scene_prefilter(&s->f.scene, budget, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
}

static double texel(const struct pbnds_bundle *b, int level, int x, int y, int c)
{
    const size_t at = b->at[level] + (size_t)y * (size_t)b->width[level] + (size_t)x;
    return b->texels[at * (size_t)b->channels + (size_t)c] / 65535.0;
}

static void each_level_is_the_mean_of_its_share(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    float texels[5 * 3 * 4];
    for (int i = 0; i < 15; ++i) {
        texels[4 * i] = (float)i / 15.0f; /* occlusion is red */
        texels[4 * i + 1] = texels[4 * i + 2] = texels[4 * i + 3] = 1.0f;
    }
    s.f.materials[0].occlusion_texture.texture = add_texture(&s, texels, 5, 3);
    prefilter(&s, 0);
    assert_int_equal(s.f.scene.maps->count, 1);
    const struct pbnds_bundle *b = &s.f.scene.maps->bundles[0];
    assert_int_equal(b->channels, 4);
    assert_int_equal(b->levels, 3);
    assert_int_equal(b->width[1], 2);
    assert_int_equal(b->height[1], 1);
    assert_int_equal(b->width[2], 1);
    for (int i = 0; i < 15; ++i)
        assert_near(texel(b, 0, i % 5, i / 5, 0), i / 15.0, 1e-5);
    /* Five columns on two: 2.5 each; three rows on one. The middle row is the mean. */
    assert_near(texel(b, 1, 0, 0, 0), (5 + 6 + 0.5 * 7) / 2.5 / 15.0, 1e-5);
    assert_near(texel(b, 1, 1, 0, 0), (0.5 * 7 + 8 + 9) / 2.5 / 15.0, 1e-5);
    assert_near(texel(b, 2, 0, 0, 0), 7.0 / 15.0, 2e-5);
    pbnds_maps_free(s.f.scene.maps);
}

static void colours_are_averaged_as_light_and_by_alpha(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    float texels[8] = {0.0f, 1.0f, 0.5f, 0.25f, 1.0f, 0.0f, 0.5f, 0.75f};
    s.f.materials[0].base_color_texture.texture = add_texture(&s, texels, 2, 1);
    prefilter(&s, 0);
    const struct pbnds_bundle *b = &s.f.scene.maps->bundles[0];
    const double half = pow((0.5 + 0.055) / 1.055, 2.4);
    assert_near(texel(b, 1, 0, 0, 0), 0.5, 1e-5); /* not the light of code 0.5 */
    assert_near(texel(b, 1, 0, 0, 2), half, 1e-5);
    assert_int_equal(b->kept[PBNDS_MAP_BASE_COLOR], 3);
    s.f.materials[0].alpha_mode = PBNDS_ALPHA_BLEND;
    prefilter(&s, 0); /* again: the old maps are released */
    b = &s.f.scene.maps->bundles[0];
    assert_int_equal(b->kept[PBNDS_MAP_BASE_COLOR], 4);
    assert_near(texel(b, 1, 0, 0, 3), 0.5, 1e-5);
    assert_near(texel(b, 1, 0, 0, 0), 0.75, 1e-5);
    assert_near(texel(b, 1, 0, 0, 1), 0.25, 1e-5);
    pbnds_maps_free(s.f.scene.maps);
}

static void maps_go_together_when_they_can(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    static float a[4 * 4 * 4], other[2 * 2 * 4];
    for (int i = 0; i < 64; ++i)
        a[i] = (float)i / 64.0f;
    struct pbnds_material *m = &s.f.materials[0];
    m->base_color_texture.texture = add_texture(&s, a, 4, 4);
    m->normal_texture.texture = m->occlusion_texture.texture =
        m->base_color_texture.texture;
    m->metallic_roughness_texture.texture = add_texture(&s, other, 2, 2);
    m->specular_texture.texture = fixture_texture(&s.f, other, 2, 2); /* nearest */
    m->emissive_texture.texture = m->base_color_texture.texture; /* but emits nothing */
    s.f.materials[1] = *m;
    s.f.scene.material_count = 2;
    prefilter(&s, 0);
    const struct pbnds_maps *maps = s.f.scene.maps;
    assert_int_equal(maps->count, 2); /* the second material shares the first's */
    const int *bundle = maps->materials[0].bundle;
    assert_int_equal(bundle[PBNDS_MAP_BASE_COLOR], bundle[PBNDS_MAP_NORMAL]);
    assert_int_equal(bundle[PBNDS_MAP_BASE_COLOR], bundle[PBNDS_MAP_OCCLUSION]);
    assert_int_equal(maps->bundles[bundle[PBNDS_MAP_NORMAL]].channels, 8);
    assert_true(bundle[PBNDS_MAP_METALLIC_ROUGHNESS] >= 0 &&
                bundle[PBNDS_MAP_METALLIC_ROUGHNESS] != bundle[PBNDS_MAP_NORMAL]);
    assert_int_equal(bundle[PBNDS_MAP_SPECULAR], -1);
    assert_int_equal(bundle[PBNDS_MAP_EMISSIVE], -1);
    assert_memory_equal(&maps->materials[0], &maps->materials[1],
                        sizeof maps->materials[0]);
    /* 21 texels of 8 channels take 336 bytes, 5 of 4 take 40. */
    prefilter(&s, 100);
    assert_int_equal(s.f.scene.maps->count, 1);
    assert_int_equal(s.f.scene.maps->materials[0].bundle[PBNDS_MAP_NORMAL], -1);
    assert_true(s.f.scene.maps->materials[0].bundle[PBNDS_MAP_METALLIC_ROUGHNESS] == 0);
    pbnds_maps_free(s.f.scene.maps);
}

static float red_at(const struct square *s, float footprint, struct pbnds_vec3 wo)
{
    const struct pbnds_hit hit = {1.0f, 0.3f, 0.4f, 0, 0};
    struct pbnds_surface q;
    pbnds_scene_surface(&s->f.scene, &hit, pbnds_normalize(wo), footprint, &q);
    return q.occlusion;
}

/* 64 x 64 texels whose every level is one value would say nothing: here level k of the
 * chain is overwritten with the value k / 8, so that what is read is the level itself. */
static void the_level_follows_from_the_cone(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    static float texels[64 * 64 * 4];
    s.f.materials[0].occlusion_texture.texture = add_texture(&s, texels, 64, 64);
    prefilter(&s, 0);
    const struct pbnds_bundle *b = &s.f.scene.maps->bundles[0];
    assert_int_equal(b->levels, 7);
    for (int level = 0; level < 7; ++level)
        for (int i = 0; i < b->width[level] * b->height[level]; ++i)
            b->texels[(b->at[level] + (size_t)i) * 4] =
                (uint16_t)(65535.0 * level / 8.0 + 0.5);
    const struct pbnds_vec3 front = {0.0f, 0.0f, 1.0f}, slant = {1.7320508f, 0, 1};
    for (int k = -2; k <= 8; ++k) { /* a cone of 2^k texels */
        const double level = k < 0 ? 0 : (k > 6 ? 6 : k);
        assert_near(red_at(&s, ldexpf(1.0f / 64.0f, k), front), level / 8.0, 1e-4);
    }
    assert_near(red_at(&s, 3.0f / 64.0f, front), log2(3.0) / 8.0, 2e-3);
    /* Seen at 60 degrees, a cone covers twice as much: one level more. */
    assert_near(red_at(&s, 4.0f / 64.0f, slant), 3.0 / 8.0, 1e-3);
    /* A transform by three makes texels three times as dense. */
    struct pbnds_texture_ref *ref = &s.f.materials[0].occlusion_texture;
    const float thrice[6] = {3.0f, 0, 0, 0, 3.0f, 0};
    memcpy(ref->transform, thrice, sizeof thrice);
    ref->transformed = true;
    assert_near(red_at(&s, 0.0f, front), 0.0, 0.0); /* the finest, of the texture */
    pbnds_maps_free(s.f.scene.maps);
    s.f.scene.maps = NULL;
    prefilter(&s, 0);
    assert_near(s.f.scene.maps->bundles[0].density, 9.0 * 64.0 * 64.0, 1e-3);
    pbnds_maps_free(s.f.scene.maps);
}

static void a_fine_lookup_is_the_texture_s(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    float texels[7 * 5 * 4];
    struct pbnds_rng rng = pbnds_rng_make(5, 0, 0);
    for (int i = 0; i < 7 * 5 * 4; ++i)
        texels[i] = pbnds_rng_float(&rng);
    const int texture = add_texture(&s, texels, 7, 5);
    s.f.materials[0].occlusion_texture.texture = texture;
    s.f.materials[0].base_color_texture.texture = texture;
    for (int mode = 0; mode < 9; ++mode) {
        s.f.textures[texture].wrap_u = (enum pbnds_wrap)(mode % 3);
        s.f.textures[texture].wrap_v = (enum pbnds_wrap)(mode / 3);
        prefilter(&s, 0);
        const struct pbnds_bundle *b = &s.f.scene.maps->bundles[0];
        for (int i = 0; i < 500; ++i) {
            const struct pbnds_vec2 uv = {8.0f * pbnds_rng_float(&rng) - 4.0f,
                                          8.0f * pbnds_rng_float(&rng) - 4.0f};
            float got[PBNDS_BUNDLE_CHANNELS];
            pbnds_bundle_sample(b, uv, -1.0f, got);
            const struct pbnds_vec4 c =
                pbnds_texture_sample(&s.f.textures[texture], uv, true);
            const struct pbnds_vec4 d =
                pbnds_texture_sample(&s.f.textures[texture], uv, false);
            const struct pbnds_vec4 base =
                pbnds_map_value(b, PBNDS_MAP_BASE_COLOR, got);
            assert_near(base.x, c.x, 2e-5);
            assert_near(base.z, c.z, 2e-5);
            assert_near(pbnds_map_value(b, PBNDS_MAP_OCCLUSION, got).x, d.x, 2e-5);
        }
    }
    const float odd[] = {NAN, INFINITY, -INFINITY, 1e30f, 1e6f, -0.0f};
    for (int i = 0; i < 36; ++i) {
        float got[PBNDS_BUNDLE_CHANNELS];
        pbnds_bundle_sample(&s.f.scene.maps->bundles[0],
                            (struct pbnds_vec2){odd[i % 6], odd[i / 6]}, odd[i % 6],
                            got);
        assert_true(got[0] >= 0.0f && got[0] <= 1.0001f);
    }
    pbnds_maps_free(s.f.scene.maps);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_level_is_the_mean_of_its_share),
        cmocka_unit_test(colours_are_averaged_as_light_and_by_alpha),
        cmocka_unit_test(maps_go_together_when_they_can),
        cmocka_unit_test(the_level_follows_from_the_cone),
        cmocka_unit_test(a_fine_lookup_is_the_texture_s),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
