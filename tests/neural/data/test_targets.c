/* Targets: what a sample's files say, and that the parts add up. */
#include "tests/neural/data/fixture_data.h"

#include "engine/core/parallel.h"
#include "engine/shade/tiles.h"
#include "neural/data/olat.h"
#include "neural/data/targets.h"

static char folder[] = "test_targets_assets";
static struct pbnds_dataset_source ROOT[] = {{folder, 0.0}};

static int clean(void **state)
{
    (void)state;
    return system("rm -rf test_targets_*") == 0 ? 0 : -1;
}

static int set_up(void **state)
{
    if (clean(state) != 0) return -1;
    fixture_assets(folder);
    return 0;
}

static void must(enum pbnds_status status, const struct pbnds_error *error)
{
    if (status != PBNDS_OK) fail_msg("%s", error->message);
}

/* Draws, renders and writes sample 0 of the split into DIR. */
static void make(const struct pbnds_dataset_recipe *recipe, enum pbnds_split split,
                 const char *dir, struct pbnds_targets *targets)
{
    struct pbnds_error error = {{0}};
    struct pbnds_drawer *drawer;
    struct pbnds_draw draw;
    must(pbnds_drawer_create(recipe, &drawer, &error), &error);
    must(pbnds_draw(drawer, split, 0, &draw, &error), &error);
    must(pbnds_targets_render(recipe, &draw, targets, &error), &error);
    must(pbnds_make_folder(dir, &error), &error);
    must(pbnds_sample_write(dir, recipe, &draw, targets, &error), &error);
    pbnds_draw_free(&draw);
    pbnds_drawer_free(drawer);
}

static void read_exr(const char *dir, const char *name, struct pbnds_exr *exr)
{
    char path[256];
    struct pbnds_error error = {{0}};
    (void)snprintf(path, sizeof path, "%s/%s", dir, name);
    must(pbnds_exr_read(path, exr, &error), &error);
}

static const struct pbnds_exr_channel *channel(const struct pbnds_exr *exr,
                                               const char *layer, int c)
{
    char name[64];
    (void)snprintf(name, sizeof name, "%s%c", layer, "RGB"[c]);
    const struct pbnds_exr_channel *found = pbnds_exr_find(exr, name);
    if (!found) fail_msg("no channel %s", name);
    return found;
}

static void the_parts_add_up_in_the_file(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    recipe.variance = true;
    recipe.spp = 16;
    struct pbnds_targets targets;
    make(&recipe, PBNDS_SPLIT_TRAIN, "test_targets_parts", &targets);
    struct pbnds_exr exr;
    read_exr("test_targets_parts", "sample.exr", &exr);
    double spread = 0.0, indirect = 0.0;
    for (int c = 0; c < 3; ++c) {
        const struct pbnds_exr_channel *all = channel(&exr, "", c),
                                       *direct = channel(&exr, "direct.", c),
                                       *rest = channel(&exr, "indirect.", c),
                                       *variance = channel(&exr, "variance.", c);
        assert_int_equal(all->type, PBNDS_EXR_HALF);
        assert_int_equal(variance->type, PBNDS_EXR_FLOAT);
        for (size_t i = 0; i < 32u * 32u; ++i) {
            const float a = ((float *)all->data)[i], d = ((float *)direct->data)[i],
                        r = ((float *)rest->data)[i];
            const float v = ((float *)variance->data)[i];
            assert_near(a, d + r, 0x1p-10 * (double)a + 1e-7);
            assert_near(a, targets.radiance.data[3 * i + (size_t)c],
                        0x1p-11 * (double)a + 1e-7);
            assert_near(v, targets.variance.data[3 * i + (size_t)c],
                        0x1p-8 * (double)v);
            spread += (double)v;
            indirect += (double)r;
        }
    }
    assert_true(spread > 0.0);
    assert_true(indirect > 0.0);
    pbnds_exr_free(&exr);
    pbnds_targets_free(&targets);
}

/* The file's light map is the one that lit the scene: made again from it, the radiance is
 * the same to the bit. */
static void the_light_of_the_file_is_the_light_of_the_scene(void **state)
{
    (void)state;
    struct pbnds_exr exr;
    read_exr("test_targets_parts", "light.exr", &exr);
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    struct pbnds_targets targets;
    make(&recipe, PBNDS_SPLIT_TRAIN, "test_targets_light", &targets);
    for (int c = 0; c < 3; ++c) {
        const struct pbnds_exr_channel *plane = channel(&exr, "", c);
        assert_int_equal(plane->type, PBNDS_EXR_HALF);
        const size_t count = (size_t)exr.width * (size_t)exr.height;
        for (size_t i = 0; i < count; ++i)
            assert_true(((float *)plane->data)[i] ==
                        targets.light.data[3 * i + (size_t)c]);
    }
    pbnds_exr_free(&exr);
    pbnds_targets_free(&targets);
}

static void what_was_not_asked_for_is_not_there(void **state)
{
    (void)state;
    struct pbnds_sample sample;
    struct pbnds_error error = {{0}};
    const unsigned everything = PBNDS_SAMPLE_VARIANCE | PBNDS_SAMPLE_OLAT;
    must(pbnds_sample_load("test_targets_light", everything, &sample, &error), &error);
    assert_null(sample.variance.data);
    assert_int_equal(sample.olat.count, 0);
    assert_null(sample.gbuffer.ao);
    pbnds_sample_free(&sample);
    must(pbnds_sample_load("test_targets_parts", 0, &sample, &error), &error);
    assert_null(sample.variance.data); /* there, but not asked for */
    pbnds_sample_free(&sample);
    must(pbnds_sample_load("test_targets_parts", everything, &sample, &error), &error);
    assert_non_null(sample.variance.data);
    pbnds_sample_free(&sample);
}

static bool folders_agree(const char *a, const char *b)
{
    for (int i = 0; pbnds_sample_file(i); ++i) {
        char x[128], y[128];
        (void)snprintf(x, sizeof x, "%s/%s", a, pbnds_sample_file(i));
        (void)snprintf(y, sizeof y, "%s/%s", b, pbnds_sample_file(i));
        if (!fixture_same(x, y)) return false;
    }
    return true;
}

static void full_recipe(struct pbnds_dataset_recipe *recipe)
{
    *recipe = fixture_recipe(ROOT, 10);
    recipe->variance = recipe->ao = true;
    recipe->olat = 6;
    recipe->olat_spp = 8;
    recipe->spp = 8;
}

/* Directions, pictures and bits go together: a pixel that sees a light faces it and shines
 * in it. */
static void check_olat(const struct pbnds_sample *sample,
                       const struct pbnds_targets *targets)
{
    const struct pbnds_gbuffer *g = &targets->gbuffer;
    int seen = 0, hidden = 0;
    for (int k = 0; k < 6; ++k) {
        const struct pbnds_vec3 wi = sample->olat.wi[k];
        assert_near(pbnds_length(wi), 1.0, 1e-5);
        assert_true(wi.x == targets->olat.wi[k].x && wi.z == targets->olat.wi[k].z);
        for (size_t i = 0; i < 32u * 32u; ++i) {
            if (!isfinite(g->depth[i])) continue;
            const bool sees = sample->olat.visibility[i] >> k & 1u;
            const struct pbnds_vec3 n = pbnds_gbuffer_vec3(g->geometric_normal, i);
            const float got = sample->olat.images[k].data[3 * i];
            assert_near(got, targets->olat.images[k].data[3 * i],
                        0x1p-11 * (double)got + 1e-7);
            if (sees) assert_true(pbnds_dot(n, wi) > 0.0f && got > 0.0f);
            hidden += !sees && pbnds_dot(n, wi) > 0.0f;
            seen += sees;
        }
    }
    assert_true(seen > 100 && hidden > 10);
}

static void everything_is_written_and_read(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe;
    struct pbnds_targets targets;
    struct pbnds_sample sample;
    struct pbnds_error error = {{0}};
    full_recipe(&recipe);
    make(&recipe, PBNDS_SPLIT_TRAIN, "test_targets_full", &targets);
    const unsigned everything = PBNDS_SAMPLE_VARIANCE | PBNDS_SAMPLE_OLAT;
    must(pbnds_sample_load("test_targets_full", everything, &sample, &error), &error);
    assert_int_equal(sample.olat.count, 6);
    assert_non_null(sample.variance.data);
    assert_non_null(sample.gbuffer.ao);
    check_olat(&sample, &targets);
    float least = 1.0f, most = 0.0f;
    for (size_t i = 0; i < 32u * 32u; ++i) {
        if (!isfinite(targets.gbuffer.depth[i])) continue;
        assert_near(sample.gbuffer.ao[i], targets.gbuffer.ao[i], 1e-3);
        least = fminf(least, sample.gbuffer.ao[i]);
        most = fmaxf(most, sample.gbuffer.ao[i]);
    }
    assert_true(least < 0.9f && most == 1.0f);
    pbnds_sample_free(&sample);
    must(pbnds_sample_load("test_targets_full", 0, &sample, &error), &error);
    assert_int_equal(sample.olat.count, 0); /* there, but not asked for */
    assert_null(sample.olat.images);
    pbnds_sample_free(&sample);
    pbnds_targets_free(&targets);
}

/* The radiance does not change with what is asked for beside it; nor does anything with
 * the threads and tiles. */
static void targets_do_not_disturb_each_other(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe, plain;
    struct pbnds_targets targets;
    full_recipe(&recipe);
    plain = recipe;
    plain.variance = plain.ao = false;
    plain.olat = 0;
    make(&plain, PBNDS_SPLIT_TRAIN, "test_targets_plain", &targets);
    float *radiance = targets.radiance.data;
    targets.radiance.data = NULL;
    pbnds_targets_free(&targets);
    pbnds_set_threads(3);
    pbnds_set_tile_side(5);
    make(&recipe, PBNDS_SPLIT_TRAIN, "test_targets_again", &targets);
    pbnds_set_tile_side(0);
    pbnds_set_threads(0);
    assert_memory_equal(radiance, targets.radiance.data,
                        3 * 32 * 32 * sizeof *radiance);
    assert_true(folders_agree("test_targets_full", "test_targets_again"));
    free(radiance);
    pbnds_targets_free(&targets);
}

/* What is tested against is never touched: the same bytes with and without. */
static void the_test_split_is_never_denoised(void **state)
{
    (void)state;
    static const char *const PLAIN[] = {"test_targets_a0", "test_targets_a1",
                                        "test_targets_a2"};
    static const char *const CLEAN[] = {"test_targets_b0", "test_targets_b1",
                                        "test_targets_b2"};
    struct pbnds_dataset_recipe recipe;
    full_recipe(&recipe);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        const bool test = s == PBNDS_SPLIT_TEST;
        struct pbnds_targets targets;
        recipe.denoise = false;
        make(&recipe, (enum pbnds_split)s, PLAIN[s], &targets);
        assert_false(targets.denoised);
        pbnds_targets_free(&targets);
        recipe.denoise = true;
        make(&recipe, (enum pbnds_split)s, CLEAN[s], &targets);
        assert_true(targets.denoised == !test);
        pbnds_targets_free(&targets);
        assert_true(folders_agree(PLAIN[s], CLEAN[s]) == test);
        char path[64];
        uint8_t *text;
        size_t size;
        (void)snprintf(path, sizeof path, "%s/sample.json", CLEAN[s]);
        assert_int_equal(pbnds_file_read(path, 1 << 20, &text, &size, NULL), PBNDS_OK);
        cJSON *json = cJSON_ParseWithLength((const char *)text, size);
        assert_int_equal(cJSON_IsTrue(cJSON_GetObjectItem(json, "denoised")), !test);
        cJSON_Delete(json);
        free(text);
    }
}

/* Emission is exact and stays so: it is neither filtered nor counted twice. */
static void denoising_leaves_emission_alone(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    struct pbnds_error error = {{0}};
    struct pbnds_drawer *drawer;
    struct pbnds_draw draw;
    struct pbnds_targets raw, clean;
    must(pbnds_drawer_create(&recipe, &drawer, &error), &error);
    must(pbnds_draw(drawer, PBNDS_SPLIT_TRAIN, 0, &draw, &error), &error);
    for (int i = 0; i < draw.scene->material_count; ++i)
        draw.scene->materials[i].emissive = pbnds_vec3_make(64.0f, 32.0f, 16.0f);
    must(pbnds_targets_render(&recipe, &draw, &raw, &error), &error);
    recipe.denoise = true;
    must(pbnds_targets_render(&recipe, &draw, &clean, &error), &error);
    assert_null(clean.variance.data); /* was needed, but not asked for */
    double changed = 0.0, before = 0.0, after = 0.0;
    for (size_t i = 0; i < 32u * 32u; ++i) {
        if (!isfinite(raw.gbuffer.depth[i])) continue;
        const double emission = (double)raw.gbuffer.emission[0][i];
        assert_near(emission, 64.0, 0.0);
        assert_true((double)clean.direct.data[3 * i] >= emission);
        changed +=
            fabs((double)(clean.radiance.data[3 * i] - raw.radiance.data[3 * i]));
        before += (double)raw.direct.data[3 * i] - emission;
        after += (double)clean.direct.data[3 * i] - emission;
    }
    assert_true(changed > 0.0);
    assert_near(after / before, 1.0, 0.1);
    pbnds_targets_free(&raw);
    pbnds_targets_free(&clean);
    pbnds_draw_free(&draw);
    pbnds_drawer_free(drawer);
}

/* Lights of the map first, apart from each other, then directions all over the sphere. */
static void lights_are_of_the_map_and_of_everywhere(void **state)
{
    (void)state;
    struct pbnds_image image;
    struct pbnds_envmap *envmap;
    struct pbnds_error error = {{0}};
    must(pbnds_image_init(&image, 64, 32, 3, &error), &error);
    for (size_t i = 0; i < 3u * 64u * 32u; ++i)
        image.data[i] = 0.1f;
    for (int c = 0; c < 3; ++c)
        pbnds_image_at(&image, 40, 8)[c] = 5000.0f;
    must(pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &envmap, &error),
         &error);
    const float phi = 2.0f * PBNDS_PI * (40.5f / 64.0f - 0.5f),
                theta = PBNDS_PI * 8.5f / 32.0f;
    const struct pbnds_vec3 sun = {sinf(theta) * cosf(phi), cosf(theta),
                                   sinf(theta) * sinf(phi)};
    for (uint64_t seed = 0; seed < 20; ++seed) {
        struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
        struct pbnds_vec3 wi[8], sum = pbnds_splat(0.0f);
        assert_int_equal(pbnds_olat_choose(envmap, 8, &rng, wi), 4);
        assert_true(pbnds_dot(wi[0], sun) > 0.999f);
        for (int i = 0; i < 8; ++i) {
            assert_near(pbnds_length(wi[i]), 1.0, 1e-5);
            if (i >= 4) sum = pbnds_add(sum, wi[i]);
            for (int k = 0; k < i && i < 4; ++k)
                assert_true(pbnds_dot(wi[i], wi[k]) < 0.985f);
        }
        assert_true(pbnds_length(sum) < 1.2f); /* of four: they balance */
    }
    memset(image.data, 0, 3u * 64u * 32u * sizeof *image.data);
    pbnds_envmap_free(envmap);
    must(pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &envmap, &error),
         &error);
    struct pbnds_rng rng = pbnds_rng_make(1, 0, 0);
    struct pbnds_vec3 wi[8];
    assert_int_equal(pbnds_olat_choose(envmap, 8, &rng, wi), 0); /* a black map */
    pbnds_envmap_free(envmap);
    pbnds_image_free(&image);
}

static void damaged_lights_are_refused(void **state)
{
    (void)state;
    static const char *const JSON[] = {
        "{}",
        "{\"olat\":{\"wi\":[[1,0]]}}",
        "{\"olat\":{\"wi\":[[1,1,0]]}}",
        "{\"olat\":{\"wi\":[[1,0,\"x\"]]}}",
        "{\"olat\":{\"wi\":3}}",
        "",
        /* more lights than the file has */
        "{\"olat\":{\"wi\":[[1,0,0],[1,0,0],[1,0,0],[1,0,0],[1,0,0],[0,1,0],[0,1,0]]}}",
    };
    struct pbnds_sample sample;
    struct pbnds_error error = {{0}};
    for (size_t i = 0; i < sizeof JSON / sizeof *JSON; ++i) {
        assert_int_equal(pbnds_file_write("test_targets_again/sample.json", JSON[i],
                                          strlen(JSON[i]), NULL),
                         PBNDS_OK);
        assert_int_equal(
            pbnds_sample_load("test_targets_again", PBNDS_SAMPLE_OLAT, &sample, &error),
            PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, "olat"));
        assert_null(sample.gbuffer.storage);
    }
    must(pbnds_sample_load("test_targets_again", 0, &sample, &error), &error);
    pbnds_sample_free(&sample);
}

/* A light beyond half's range is kept, not clipped. */
static void a_fierce_light_stays_float(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    struct pbnds_error error = {{0}};
    struct pbnds_drawer *drawer;
    struct pbnds_draw draw;
    struct pbnds_targets targets;
    must(pbnds_drawer_create(&recipe, &drawer, &error), &error);
    must(pbnds_draw(drawer, PBNDS_SPLIT_TRAIN, 0, &draw, &error), &error);
    draw.light.data[3 * 5000] = 1e6f;
    must(pbnds_targets_render(&recipe, &draw, &targets, &error), &error);
    must(pbnds_make_folder("test_targets_fierce", &error), &error);
    must(pbnds_sample_write("test_targets_fierce", &recipe, &draw, &targets, &error),
         &error);
    struct pbnds_exr exr;
    read_exr("test_targets_fierce", "light.exr", &exr);
    assert_int_equal(channel(&exr, "", 0)->type, PBNDS_EXR_FLOAT);
    assert_true(((float *)channel(&exr, "", 0)->data)[5000] == 1e6f);
    pbnds_exr_free(&exr);
    pbnds_targets_free(&targets);
    pbnds_draw_free(&draw);
    pbnds_drawer_free(drawer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_parts_add_up_in_the_file),
        cmocka_unit_test(the_light_of_the_file_is_the_light_of_the_scene),
        cmocka_unit_test(what_was_not_asked_for_is_not_there),
        cmocka_unit_test(everything_is_written_and_read),
        cmocka_unit_test(targets_do_not_disturb_each_other),
        cmocka_unit_test(the_test_split_is_never_denoised),
        cmocka_unit_test(denoising_leaves_emission_alone),
        cmocka_unit_test(lights_are_of_the_map_and_of_everywhere),
        cmocka_unit_test(damaged_lights_are_refused),
        cmocka_unit_test(a_fierce_light_stays_float),
    };
    return cmocka_run_group_tests_name("neural/data/targets", tests, set_up, clean);
}
