/* The anti-aliased ray cast: areas, weights, layers, mattes, threads. */
#include <stdio.h>

#include "engine/core/parallel.h"
#include "engine/shade/cryptomatte.h"
#include "tests/engine/shade/fixture.h"

/* Eye at the origin, looks down -z; at depth 1 the image is 2 metres high. */
static struct pbnds_camera square_on(void)
{
    struct pbnds_camera c;
    memset(&c, 0, sizeof c);
    c.world_from_camera = pbnds_mat4_identity();
    c.yfov = PBNDS_PI / 2.0f;
    return c;
}

static struct pbnds_gbuffer cast(const struct fixture *f,
                                 const struct pbnds_camera *camera, int width,
                                 int height,
                                 const struct pbnds_raycast_options *options)
{
    struct pbnds_gbuffer g;
    struct pbnds_error error;
    must(pbnds_gbuffer_raycast(&f->scene, f->accel, camera, width, height, options, &g,
                               &error),
         &error);
    return g;
}

/* Rectangle [x0, x1] x [y0, y1] at depth d, facing the eye. */
static struct pbnds_mesh card(float x0, float y0, float x1, float y1, float d,
                              int material)
{
    struct pbnds_mesh mesh =
        quad(pbnds_vec3_make(x0, y0, -d), pbnds_vec3_make(x1 - x0, 0, 0),
             pbnds_vec3_make(0, y1 - y0, 0), material);
    mesh.object_id = (uint32_t)material;
    return mesh;
}

static struct pbnds_material colored(float r, float g, float b, float alpha)
{
    struct pbnds_material m = matte(0.5f);
    m.base_color = (struct pbnds_vec4){r, g, b, alpha};
    if (alpha < 1.0f) m.alpha_mode = PBNDS_ALPHA_BLEND;
    m.name[0] = 0;
    return m;
}

static double overlap(double a0, double a1, double b0, double b1)
{
    return fmax(0.0, fmin(a1, b1) - fmax(a0, b0));
}

/* Coverage is the area that the card takes of each pixel; the set of N points misses a
 * rectangle by less than (log2 N + 2) / N. */
static void coverage_is_area(void **state)
{
    (void)state;
    enum { SIDE = 8 };
    const float x0 = -0.61f, x1 = 0.43f, y0 = -0.37f, y1 = 0.716f;
    const struct pbnds_mesh mesh = card(x0, y0, x1, y1, 1.0f, 0);
    const struct pbnds_material material = colored(0.2f, 0.4f, 0.6f, 1.0f);
    struct fixture f;
    fixture_scene(&f, &mesh, 1, &material, 1);
    const struct pbnds_camera camera = square_on();
    static const int counts[] = {2, 5, 16, 64, 256};
    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; ++k) {
        const int n = counts[k];
        const struct pbnds_raycast_options options = {.samples = n};
        struct pbnds_gbuffer g = cast(&f, &camera, SIDE, SIDE, &options);
        assert_int_equal(g.samples, n);
        const double bound = (log2(n) + 2.0) / n;
        double total = 0.0;
        for (int y = 0; y < SIDE; ++y) {
            for (int x = 0; x < SIDE; ++x) {
                const size_t i = (size_t)y * SIDE + (size_t)x;
                const double left = 2.0 * x / SIDE - 1.0, top = 1.0 - 2.0 * y / SIDE;
                const double w = 2.0 / SIDE;
                const double area = overlap((double)x0, (double)x1, left, left + w) *
                                    overlap((double)y0, (double)y1, top - w, top) /
                                    (w * w);
                assert_near(g.coverage[i], area, area == 1.0 ? 0.0 : bound);
                total += (double)g.coverage[i];
                if (g.coverage[i] == 0.0f) {
                    assert_true(isinf(g.depth[i]));
                    assert_int_equal(g.object_id[i], UINT32_MAX);
                    continue;
                }
                /* One surface: its values are not diluted, to the bit. */
                assert_true(g.albedo[0][i] == 0.2f && g.albedo[2][i] == 0.6f);
                assert_true(g.normal[2][i] == 1.0f && g.roughness[i] == 1.0f);
                assert_near(g.depth[i], 1.0, 1e-6);
            }
        }
        const double exact = (double)((x1 - x0) * (y1 - y0)) * SIDE * SIDE / 4.0;
        assert_near(total / exact, 1.0, 2.0 / n);
        pbnds_gbuffer_free(&g);
    }
    fixture_free(&f);
}

/* Two cards share a pixel: the share of the first must be the same number whichever
 * channel it is read from, and the one that Cryptomatte gives. */
static void all_channels_have_the_same_weights(void **state)
{
    (void)state;
    const struct pbnds_mesh meshes[] = {card(-2, -2, 0.137f, 2, 1.0f, 0),
                                        card(-0.5f, -2, 2, 2, 1.5f, 1)};
    struct pbnds_material materials[2] = {colored(0.9f, 0.1f, 0.3f, 1.0f),
                                          colored(0.2f, 0.8f, 0.5f, 1.0f)};
    materials[0].roughness = 0.9f, materials[1].roughness = 0.3f;
    materials[0].metallic = 0.0f, materials[1].metallic = 1.0f;
    materials[0].emissive = pbnds_vec3_make(8, 2, 1);
    materials[1].specular = 0.5f;
    materials[0].ior_f0 = materials[1].ior_f0 = 0.04f;
    struct fixture f;
    fixture_scene(&f, meshes, 2, materials, 2);
    const struct pbnds_camera camera = square_on();
    const struct pbnds_raycast_options options = {
        .samples = 64,
        .optional = PBNDS_OPTIONAL_CRYPTOMATTE | PBNDS_OPTIONAL_MATERIAL_ID};
    struct pbnds_gbuffer g = cast(&f, &camera, 3, 3, &options);
    const size_t i = 4;
    assert_near(g.coverage[i], 1.0, 0.0);
    const double w = ((double)g.albedo[0][i] - 0.2) / (0.9 - 0.2);
    assert_true(w > 0.6 && w < 0.8); /* the edge lies at 0.137 of (-1/3, 1/3) */
    assert_near(g.albedo[1][i], 0.1 * w + 0.8 * (1 - w), 1e-6);
    assert_near(g.albedo[2][i], 0.3 * w + 0.5 * (1 - w), 1e-6);
    assert_near(g.roughness[i], 0.9 * w + 0.3 * (1 - w), 1e-6);
    assert_near(g.metallic[i], 1 - w, 1e-6);
    assert_near(g.emission[0][i], 8 * w, 1e-5);
    assert_near(g.depth[i], 1.0 * w + 1.5 * (1 - w), 1e-6);
    assert_near(g.position[2][i], -(double)g.depth[i], 1e-6);
    assert_near(g.f0[1][i], 0.04 * w + 0.8 * (1 - w), 1e-6);
    assert_near(g.f90[i], 1.0, 1e-6); /* of both: the half is of the non-metal part */
    assert_near(g.specular[i],
                0.2126 * (double)g.f0[0][i] + 0.7152 * (double)g.f0[1][i] +
                    0.0722 * (double)g.f0[2][i],
                1e-6);
    assert_int_equal(g.object_id[i], 0);
    assert_int_equal(g.material_id[i], 0);
    const struct pbnds_cryptomatte_layer *layer = &g.cryptomatte->layers[0];
    assert_near(layer->share[0][i], w, 1e-6);
    assert_near(layer->share[1][i], 1 - w, 1e-6);
    const uint32_t id = pbnds_cryptomatte_id("node_0");
    assert_memory_equal(&layer->id[0][i], &id, sizeof id);
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
}

/* Three sheets of alpha 0.25, 0.5, 0.75, one behind the other, before a wall. */
static void make_sheets(struct fixture *f)
{
    const struct pbnds_mesh meshes[] = {
        card(-9, -9, 9, 9, 1.0f, 0), card(-9, -9, 9, 9, 2.0f, 1),
        card(-9, -9, 9, 9, 3.0f, 2), card(-9, -9, 0, 9, 4.0f, 3)};
    const struct pbnds_material materials[] = {
        colored(1, 0, 0, 0.25f), colored(0, 1, 0, 0.5f), colored(0, 0, 1, 0.75f),
        colored(0, 0, 0, 1.0f)};
    fixture_scene(f, meshes, 4, materials, 4);
}

static void alpha_weighs_every_layer(void **state)
{
    (void)state;
    struct fixture f;
    make_sheets(&f);
    const struct pbnds_camera camera = square_on();
    for (int samples = 1; samples <= 4; samples += 3) {
        const struct pbnds_raycast_options options = {.samples = samples,
                                                      .through = PBNDS_THROUGH_ALPHA,
                                                      .optional =
                                                          PBNDS_OPTIONAL_CRYPTOMATTE};
        struct pbnds_gbuffer g = cast(&f, &camera, 2, 1, &options);
        assert_int_equal(g.through, PBNDS_THROUGH_ALPHA);
        const double weights[] = {0.25, 0.375, 0.28125, 0.09375};
        for (size_t i = 0; i < 2; ++i) { /* the wall stands on the left only */
            const double all = i == 0 ? 1.0 : 0.90625;
            assert_near(g.coverage[i], all, 1e-7);
            for (int c = 0; c < 3; ++c)
                assert_near(g.albedo[c][i], weights[c] / all, 1e-6);
            const double depth =
                weights[0] + 2 * weights[1] + 3 * weights[2] + (i ? 0 : 4 * weights[3]);
            assert_near(g.depth[i], depth / all, 1e-5);
            assert_int_equal(g.object_id[i], 1);
            const struct pbnds_cryptomatte_layer *layer = &g.cryptomatte->layers[1];
            static const int order[] = {1, 2, 0, 3};
            for (int r = 0; r < (i ? 3 : 4); ++r) {
                char name[32];
                snprintf(name, sizeof name, "material_%d", order[r]);
                const uint32_t id = pbnds_cryptomatte_id(name);
                assert_near(layer->share[r][i], weights[order[r]], 1e-7);
                assert_memory_equal(&layer->id[r][i], &id, sizeof id);
            }
            assert_near(layer->share[4][i], 0.0, 0.0);
        }
        pbnds_gbuffer_free(&g);
    }
    fixture_free(&f);
}

static void first_takes_what_is_half_opaque(void **state)
{
    (void)state;
    struct fixture f;
    make_sheets(&f);
    const struct pbnds_camera camera = square_on();
    for (int samples = 1; samples <= 16; samples += 15) {
        const struct pbnds_raycast_options options = {.samples = samples};
        struct pbnds_gbuffer g = cast(&f, &camera, 2, 2, &options);
        for (size_t i = 0; i < 4; ++i) {
            assert_near(g.coverage[i], 1.0, 0.0);
            assert_near(g.depth[i], 2.0, 1e-6);
            assert_near(g.albedo[1][i], 1.0, 0.0);
        }
        pbnds_gbuffer_free(&g);
    }
    fixture_free(&f);
}

/* The documented ends of the walk: 64 layers, or less than 1/1000 let through. */
static void the_walk_ends(void **state)
{
    (void)state;
    enum { SHEETS = 80 };
    struct pbnds_mesh meshes[SHEETS];
    for (int k = 0; k < SHEETS; ++k)
        meshes[k] = card(-9, -9, 9, 9, 1.0f + 0.01f * (float)k, 0);
    struct pbnds_material thin = colored(1, 1, 1, 1.0f / 64.0f);
    struct fixture f;
    fixture_scene(&f, meshes, SHEETS, &thin, 1);
    const struct pbnds_camera camera = square_on();
    const struct pbnds_raycast_options options = {.through = PBNDS_THROUGH_ALPHA};
    struct pbnds_gbuffer g = cast(&f, &camera, 1, 1, &options);
    assert_near(g.coverage[0], 1.0 - pow(63.0 / 64.0, 64), 1e-5);
    pbnds_gbuffer_free(&g);

    f.scene.materials[0].base_color.w = 0.75f; /* 4^-5 is the first below 1/1000 */
    g = cast(&f, &camera, 1, 1, &options);
    assert_near(g.coverage[0], 1.0 - pow(0.25, 5), 1e-6);
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
}

static void assert_same(const struct pbnds_gbuffer *a, const struct pbnds_gbuffer *b)
{
    const size_t size = (size_t)a->width * (size_t)a->height * sizeof(float);
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(a->albedo[c], b->albedo[c], size);
        assert_memory_equal(a->normal[c], b->normal[c], size);
        assert_memory_equal(a->geometric_normal[c], b->geometric_normal[c], size);
        assert_memory_equal(a->position[c], b->position[c], size);
        assert_memory_equal(a->emission[c], b->emission[c], size);
    }
    assert_memory_equal(a->specular, b->specular, size);
    assert_memory_equal(a->roughness, b->roughness, size);
    assert_memory_equal(a->metallic, b->metallic, size);
    assert_memory_equal(a->depth, b->depth, size);
    assert_memory_equal(a->coverage, b->coverage, size);
    assert_memory_equal(a->object_id, b->object_id, size);
    assert_memory_equal(a->ao, b->ao, size);
    assert_memory_equal(a->uv[1], b->uv[1], size);
    assert_memory_equal(a->motion[0], b->motion[0], size);
    assert_memory_equal(a->material_id, b->material_id, size);
}

static void make_spheres(struct fixture *f)
{
    struct pbnds_mesh meshes[] = {sphere(pbnds_vec3_make(-0.4f, 0, -3), 0.8f, 12, 0),
                                  sphere(pbnds_vec3_make(0.5f, 0.2f, -2), 0.6f, 9, 1),
                                  card(-4, -4, 4, 0.3f, 4.0f, 2)};
    meshes[1].object_id = 1;
    const struct pbnds_material materials[] = {
        colored(0.9f, 0.2f, 0.1f, 1.0f), colored(0.1f, 0.2f, 0.9f, 0.6f), matte(0.4f)};
    fixture_scene(f, meshes, 3, materials, 3);
}

enum {
    ALL = PBNDS_OPTIONAL_AO | PBNDS_OPTIONAL_UV | PBNDS_OPTIONAL_MOTION |
          PBNDS_OPTIONAL_MATERIAL_ID
};

/* One sample is the pixel's centre: asking for mattes changes no plane. */
static void one_sample_is_the_point_sampled_pass(void **state)
{
    (void)state;
    struct fixture f;
    make_spheres(&f);
    struct pbnds_camera camera = square_on(), before = square_on();
    before.world_from_camera.m[12] = 0.01f;
    struct pbnds_raycast_options options = {.optional = ALL,
                                            .previous_camera = &before};
    struct pbnds_gbuffer point = cast(&f, &camera, 61, 47, &options);
    options.optional |= PBNDS_OPTIONAL_CRYPTOMATTE;
    struct pbnds_gbuffer matted = cast(&f, &camera, 61, 47, &options);
    assert_same(&point, &matted);
    for (size_t i = 0; i < 61 * 47; ++i) {
        assert_near(matted.cryptomatte->layers[0].share[0][i], point.coverage[i], 0.0);
        assert_near(matted.cryptomatte->layers[1].share[1][i], 0.0, 0.0);
    }
    pbnds_gbuffer_free(&matted);
    pbnds_gbuffer_free(&point);
    fixture_free(&f);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    struct fixture f;
    make_spheres(&f);
    const struct pbnds_camera camera = square_on();
    for (int through = 0; through < 2; ++through) {
        const struct pbnds_raycast_options options = {
            .samples = 7,
            .through = (enum pbnds_through)through,
            .optional = (unsigned)ALL | PBNDS_OPTIONAL_CRYPTOMATTE};
        pbnds_set_threads(1);
        struct pbnds_gbuffer one = cast(&f, &camera, 53, 37, &options);
        for (int threads = 2; threads <= 5; threads += 3) {
            pbnds_set_threads(threads);
            struct pbnds_gbuffer many = cast(&f, &camera, 53, 37, &options);
            assert_same(&one, &many);
            const size_t planes =
                (size_t)2 * PBNDS_CRYPTOMATTE_LAYERS * PBNDS_CRYPTOMATTE_RANKS;
            assert_memory_equal(one.cryptomatte->storage, many.cryptomatte->storage,
                                planes * 53 * 37 * sizeof(float));
            pbnds_gbuffer_free(&many);
        }
        pbnds_gbuffer_free(&one);
    }
    pbnds_set_threads(1);
    fixture_free(&f);
}

/* What every pixel must keep, whatever was averaged in it. */
static void means_keep_the_contract(void **state)
{
    (void)state;
    struct fixture f;
    make_spheres(&f);
    const struct pbnds_camera camera = square_on();
    const struct pbnds_raycast_options options = {.samples = 9,
                                                  .through = PBNDS_THROUGH_ALPHA,
                                                  .optional =
                                                      PBNDS_OPTIONAL_CRYPTOMATTE};
    struct pbnds_gbuffer g = cast(&f, &camera, 64, 48, &options);
    int partial = 0;
    for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 64; ++x) {
            const size_t i = (size_t)y * 64 + (size_t)x;
            double shares = 0.0;
            for (int r = 0; r < PBNDS_CRYPTOMATTE_RANKS; ++r) {
                const float share = g.cryptomatte->layers[0].share[r][i];
                if (r > 0)
                    assert_true(share <= g.cryptomatte->layers[0].share[r - 1][i]);
                shares += (double)share;
            }
            assert_near(shares, g.coverage[i], 1e-6);
            if (g.coverage[i] == 0.0f) continue;
            partial += g.coverage[i] < 1.0f;
            const struct pbnds_vec3 n = {g.normal[0][i], g.normal[1][i],
                                         g.normal[2][i]};
            const struct pbnds_vec3 p = {g.position[0][i], g.position[1][i],
                                         g.position[2][i]};
            assert_near(pbnds_length(n), 1.0, 1e-6);
            assert_true(pbnds_dot(n, pbnds_gbuffer_wo(&g, x, y)) > 4e-4f);
            assert_near(g.depth[i], pbnds_camera_depth(&camera, p), 1e-5);
        }
    }
    assert_true(partial > 50);
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
}

/* Everything moved 0.1 m to the right at depth 1 while the camera moved 0.02 m to the
 * left: on 40 rows (20 pixels a metre) that is 2 + 0.4 pixels, at every sample. */
static void motion_of_mesh_and_camera(void **state)
{
    (void)state;
    struct pbnds_mesh mesh = card(-5, -5, 5, 5, 1.0f, 0);
    mesh.previous = must_alloc(4, sizeof *mesh.previous);
    for (int k = 0; k < 4; ++k)
        mesh.previous[k] = pbnds_sub(mesh.position[k], pbnds_vec3_make(0.1f, 0, 0));
    const struct pbnds_material material = matte(0.5f);
    struct fixture f;
    fixture_scene(&f, &mesh, 1, &material, 1);
    const struct pbnds_camera camera = square_on();
    struct pbnds_camera before = square_on();
    before.world_from_camera.m[12] = 0.02f;
    const struct pbnds_raycast_options options = {
        .samples = 5, .optional = PBNDS_OPTIONAL_MOTION, .previous_camera = &before};
    struct pbnds_gbuffer g = cast(&f, &camera, 40, 40, &options);
    for (size_t i = 0; i < 1600; ++i) {
        assert_near(g.motion[0][i], 2.4, 1e-4);
        assert_near(g.motion[1][i], 0.0, 1e-4);
    }
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
}

/* Last: the flag stays up. */
static void a_stop_leaves_nothing(void **state)
{
    (void)state;
    struct fixture f;
    make_spheres(&f);
    const struct pbnds_camera camera = square_on();
    const struct pbnds_raycast_options options = {
        .samples = 3, .optional = PBNDS_OPTIONAL_CRYPTOMATTE};
    struct pbnds_gbuffer g;
    struct pbnds_error error;
    pbnds_request_stop();
    assert_int_equal(
        pbnds_gbuffer_raycast(&f.scene, f.accel, &camera, 64, 64, &options, &g, &error),
        PBNDS_ERROR_INTERRUPTED);
    assert_null(g.storage);
    assert_null(g.cryptomatte);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coverage_is_area),
        cmocka_unit_test(all_channels_have_the_same_weights),
        cmocka_unit_test(alpha_weighs_every_layer),
        cmocka_unit_test(first_takes_what_is_half_opaque),
        cmocka_unit_test(the_walk_ends),
        cmocka_unit_test(one_sample_is_the_point_sampled_pass),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(means_keep_the_contract),
        cmocka_unit_test(motion_of_mesh_and_camera),
        cmocka_unit_test(a_stop_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
