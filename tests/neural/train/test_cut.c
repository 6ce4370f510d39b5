/* Windows, mirrors and exposure: a sample that was mirrored here is the sample of the scene
 * that was mirrored before anything was made of it. */
#include "tests/neural/train/fixture_item.h"

#include "neural/train/cut.h"

enum { W = 40, H = 32 };

/* A camera that stands askew, and its mirror M = C diag(-1, 1, 1) C^-1 of directions. */
static struct pbnds_camera askew(void)
{
    struct pbnds_camera camera = {.yfov = 0.7f};
    camera.world_from_camera = pbnds_mat4_look_at(pbnds_vec3_make(1.0f, 2.0f, 3.0f),
                                                  pbnds_vec3_make(-2.0f, 0.5f, 0.3f),
                                                  pbnds_vec3_make(0.2f, 1.0f, 0.1f));
    return camera;
}

static struct pbnds_vec3 reflect(const struct pbnds_camera *camera, struct pbnds_vec3 v)
{
    struct pbnds_vec3 c = pbnds_camera_from_world_vector(camera, v);
    c.x = -c.x;
    return pbnds_mat4_vector(&camera->world_from_camera, c);
}

static void set_normal(struct pbnds_gbuffer *g, size_t i, struct pbnds_vec3 n)
{
    const float v[3] = {n.x, n.y, n.z};
    for (int c = 0; c < 3; ++c)
        g->normal[c][i] = g->geometric_normal[c][i] = v[c];
}

/* Hills and a gap, other materials everywhere; seen askew. Mirrored: the scene's mirror
 * image under the same camera. */
static struct pbnds_gbuffer scene(bool mirrored)
{
    struct pbnds_gbuffer g;
    assert_int_equal(pbnds_gbuffer_init(&g, W, H, NULL), PBNDS_OK);
    g.camera = askew();
    for (int y = 0; y < H; ++y) {
        for (int x = 0; x < W; ++x) {
            const int from = mirrored ? W - 1 - x : x;
            const size_t i = (size_t)y * W + (size_t)x;
            struct pbnds_rng rng = pbnds_rng_make(5, (uint64_t)from, (uint64_t)y);
            if (from < 5 && y < 9) {
                g.depth[i] = INFINITY;
                continue;
            }
            g.depth[i] = 3.0f + 0.03f * (float)from + sinf(0.4f * (float)(from + y));
            g.coverage[i] = 1.0f;
            for (int c = 0; c < 3; ++c)
                g.albedo[c][i] = pbnds_rng_float(&rng);
            g.roughness[i] = pbnds_rng_float(&rng);
            g.metallic[i] = pbnds_rng_float(&rng);
            g.specular[i] = 0.04f + 0.9f * g.metallic[i];
            struct pbnds_vec3 n = pbnds_normalize(
                pbnds_vec3_make(2.0f * pbnds_rng_float(&rng) - 1.0f,
                                2.0f * pbnds_rng_float(&rng) - 1.0f, 1.2f));
            n = pbnds_mat4_vector(&g.camera.world_from_camera, n);
            set_normal(&g, i, mirrored ? reflect(&g.camera, n) : n);
        }
    }
    return g;
}

static struct pbnds_train_item sample_of(bool mirrored)
{
    struct pbnds_gbuffer g = scene(mirrored);
    struct pbnds_envmap *envmap = fixture_env(1.0f, 4);
    struct pbnds_env_light lights[PBNDS_DATASET_LIGHTS] = {{.wi = {0.0f, 1.0f, 0.0f}}};
    const int count = pbnds_envmap_cluster(envmap, PBNDS_DATASET_LIGHTS, lights);
    for (int k = 0; k < PBNDS_DATASET_LIGHTS && mirrored; ++k)
        lights[k].wi = reflect(&g.camera, lights[k].wi);
    const struct pbnds_train_item item = fixture_item_of(&g, envmap, lights, count);
    pbnds_gbuffer_free(&g);
    return item;
}

static struct pbnds_train_item cut_of(const struct pbnds_train_item *item,
                                      struct pbnds_cut cut)
{
    struct pbnds_train_item out;
    assert_int_equal(pbnds_train_item_cut(item, &cut, &out, NULL), PBNDS_OK);
    return out;
}

static const struct pbnds_cut MIRROR = {.window = {0, 0, W, H}, .mirror = true};

static void features_are_those_of_the_mirrored_scene(void **state)
{
    (void)state;
    struct pbnds_train_item item = sample_of(false), there = sample_of(true);
    struct pbnds_train_item cut = cut_of(&item, MIRROR);
    for (int k = 0; k < PBNDS_PLANE_COUNT; ++k) {
        for (size_t i = 0; i < W * H; ++i)
            assert_near(cut.view.plane[k][i], there.view.plane[k][i], 2e-5);
    }
    for (size_t i = 0; i < W * H; ++i)
        assert_true(cut.view.depth[i] == there.view.depth[i]);
    const struct pbnds_feature_table *table = &pbnds_features_transport;
    const int channels = pbnds_features_light_channels(table);
    float *a = malloc(sizeof *a * W * H * (size_t)channels);
    float *b = malloc(sizeof *b * W * H * (size_t)channels);
    int dithered = 0, marched = 0;
    for (int k = 0; k < PBNDS_DATASET_LIGHTS; ++k) {
        const struct pbnds_light_source mine = {.wi = cut.lights[k].wi, .bit = k};
        const struct pbnds_light_source theirs = {.wi = there.lights[k].wi, .bit = k};
        const struct pbnds_window all = {0, 0, W, H};
        pbnds_features_light(table, &cut.view, &cut.march, &mine, all, a);
        pbnds_features_light(table, &there.view, &there.march, &theirs, all, b);
        for (int i = 0; i < W * H * channels; ++i) {
            const int plane = table->light[i % channels].plane;
            if (plane == PBNDS_LIGHT_MARCH_THIN || plane == PBNDS_LIGHT_MARCH_THICK) {
                ++marched; /* its dither is not symmetric */
                dithered += a[i] != b[i];
            } else {
                assert_near(a[i], b[i], 2e-5);
            }
        }
    }
    assert_true(dithered < marched / 20);
    free(a);
    free(b);
    pbnds_train_cut_free(&cut);
    pbnds_train_item_free(&item);
    pbnds_train_item_free(&there);
}

/* Unshadowed light of all clusters at one pixel. */
static struct pbnds_vec3 direct_at(const struct pbnds_train_item *item, size_t i)
{
    const struct pbnds_transport_pixel pixel = pbnds_transport_pixel(&item->view, i);
    struct pbnds_vec3 sum = pbnds_splat(0.0f);
    for (int k = 0; pixel.covered && k < item->light_count; ++k) {
        const struct pbnds_vec3 wi =
            pbnds_camera_from_world_vector(&item->view.camera, item->lights[k].wi);
        sum = pbnds_add(
            sum, pbnds_mul(item->lights[k].power, pbnds_transport_direct(&pixel, wi)));
    }
    return sum;
}

static void analytic_light_is_the_mirrored_picture(void **state)
{
    (void)state;
    struct pbnds_train_item item = sample_of(false), there = sample_of(true);
    struct pbnds_train_item cut = cut_of(&item, MIRROR);
    double least = HUGE_VAL, most = 0.0;
    for (size_t i = 0; i < W * H; ++i) {
        const size_t j = i / W * W + (W - 1 - i % W);
        const struct pbnds_vec3 a = direct_at(&cut, i), b = direct_at(&item, j),
                                c = direct_at(&there, i);
        const double scale = 1.0 + (double)pbnds_luminance(b);
        assert_near((double)pbnds_length(pbnds_sub(a, b)) / scale, 0.0, 3e-5);
        assert_near((double)pbnds_length(pbnds_sub(a, c)) / scale, 0.0, 3e-5);
        least = fmin(least, (double)pbnds_luminance(b));
        most = fmax(most, (double)pbnds_luminance(b));
        for (size_t k = 0; k < 3; ++k) {
            assert_true(cut.radiance[3 * i + k] == item.radiance[3 * j + k]);
            assert_true(cut.direct[3 * i + k] == item.direct[3 * j + k]);
            assert_true(cut.specular[3 * i + k] == item.specular[3 * j + k]);
        }
        assert_true(cut.visibility[i] == item.visibility[j]);
        assert_true(cut.march.thin[i] == item.march.thin[j]);
        assert_true(cut.march.thick[i] == item.march.thick[j]);
    }
    assert_true(most > 2.0 * least); /* something is to be seen */
    pbnds_train_cut_free(&cut);
    pbnds_train_item_free(&item);
    pbnds_train_item_free(&there);
}

/* A window is what the image shows there, and the mirror of a mirror is the image. */
static void windows_and_two_mirrors(void **state)
{
    (void)state;
    struct pbnds_train_item item = sample_of(false);
    struct pbnds_cut how = {.window = {7, 9, 16, 12}};
    struct pbnds_train_item plain = cut_of(&item, how);
    how.mirror = true;
    struct pbnds_train_item once = cut_of(&item, how);
    how.window = (struct pbnds_window){0, 0, 16, 12};
    struct pbnds_train_item twice = cut_of(&once, how);
    assert_int_equal(plain.view.width, 16);
    assert_int_equal(plain.view.height, 12);
    for (size_t i = 0; i < 16 * 12; ++i) {
        const size_t source = (9 + i / 16) * W + 7 + i % 16;
        for (int k = 0; k < PBNDS_PLANE_COUNT; ++k) {
            assert_true(plain.view.plane[k][i] == item.view.plane[k][source]);
            assert_true(twice.view.plane[k][i] == item.view.plane[k][source]);
        }
        assert_true(plain.view.depth[i] == item.view.depth[source]);
        for (size_t c = 0; c < 3; ++c)
            assert_true(plain.specular[3 * i + c] == item.specular[3 * source + c]);
        assert_true(plain.visibility[i] == item.visibility[source]);
        assert_true(twice.visibility[i] == item.visibility[source]);
    }
    assert_memory_equal(&plain.view.camera, &item.view.camera, sizeof item.view.camera);
    assert_memory_equal(&twice.view.camera, &item.view.camera, sizeof item.view.camera);
    pbnds_train_cut_free(&twice);
    pbnds_train_cut_free(&once);
    pbnds_train_cut_free(&plain);
    pbnds_train_item_free(&item);
}

static void exposure_is_of_light_and_targets(void **state)
{
    (void)state;
    struct pbnds_train_item item = sample_of(false);
    struct pbnds_train_item cut =
        cut_of(&item, (struct pbnds_cut){.window = {0, 0, W, H}, .stops = -1.0f});
    assert_true(cut.stops == -1.0f);
    for (int k = 0; k < PBNDS_DATASET_LIGHTS; ++k) {
        assert_true(cut.lights[k].power.x == 0.5f * item.lights[k].power.x);
        assert_true(cut.lights[k].wi.y == item.lights[k].wi.y);
    }
    for (size_t i = 0; i < 3 * W * H; ++i) {
        assert_true(cut.radiance[i] == 0.5f * item.radiance[i]);
        assert_true(cut.direct[i] == 0.5f * item.direct[i]);
        assert_true(cut.specular[i] == 0.5f * item.specular[i]);
    }
    for (size_t i = 0; i < W * H; ++i)
        assert_true(cut.view.plane[PBNDS_PLANE_ALBEDO_R][i] ==
                    item.view.plane[PBNDS_PLANE_ALBEDO_R][i]);
    pbnds_train_cut_free(&cut);
    pbnds_train_item_free(&item);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(features_are_those_of_the_mirrored_scene),
        cmocka_unit_test(analytic_light_is_the_mirrored_picture),
        cmocka_unit_test(windows_and_two_mirrors),
        cmocka_unit_test(exposure_is_of_light_and_targets),
    };
    return cmocka_run_group_tests_name("neural/train/cut", tests, NULL, NULL);
}
