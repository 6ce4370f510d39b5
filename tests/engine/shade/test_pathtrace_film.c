/* Where the paths of the reference start and what becomes of them: layers before the sky,
 * edges of pixels, variance, the noise target. */
#include "engine/core/parallel.h"
#include "tests/engine/shade/fixture.h"

static const struct pbnds_vec3 ZERO = {0.0f, 0.0f, 0.0f};

static struct pbnds_material lambert(float albedo)
{
    struct pbnds_material m = matte(albedo);
    m.specular = 0.0f;
    return m;
}

static struct pbnds_material pane(float alpha)
{
    struct pbnds_material m = lambert(0.0f);
    m.alpha_mode = PBNDS_ALPHA_BLEND;
    m.base_color.w = alpha;
    return m;
}

/* One triangle, upright across the z axis, that fills every view of these tests. */
static struct pbnds_mesh wall(float z, int material)
{
    struct pbnds_mesh mesh = new_mesh(3, 1, material);
    mesh.position[0] = pbnds_vec3_make(-90.0f, -60.0f, z);
    mesh.position[1] = pbnds_vec3_make(90.0f, -60.0f, z);
    mesh.position[2] = pbnds_vec3_make(0.0f, 120.0f, z);
    mesh.index[1] = 1;
    mesh.index[2] = 2;
    return mesh;
}

/* Everything that the reference gives. */
struct picture {
    struct pbnds_image radiance, direct, variance, alpha;
    int taken;
};

static void take(const struct fixture *f, int spp, struct picture *p)
{
    struct pbnds_error error;
    struct pbnds_shade_job job = f->job;
    const struct pbnds_pathtrace_options options = {.spp = spp};
    job.variance = &p->variance;
    job.alpha = &p->alpha;
    job.taken = &p->taken;
    must(pbnds_pathtrace(&job, &options, &p->radiance, &p->direct, &error), &error);
}

static void drop(struct picture *p)
{
    pbnds_image_free(&p->radiance);
    pbnds_image_free(&p->direct);
    pbnds_image_free(&p->variance);
    pbnds_image_free(&p->alpha);
}

/* Channel 0 of pixel i before a background of the given radiance. */
static double shown(const struct picture *p, size_t i, double background)
{
    const double c = (double)p->alpha.data[i];
    return c * (double)p->radiance.data[3 * i] + (1.0 - c) * background;
}

static double mean_shown(const struct picture *p, double background)
{
    const size_t n = (size_t)p->radiance.width * (size_t)p->radiance.height;
    double sum = 0.0;
    for (size_t i = 0; i < n; ++i)
        sum += shown(p, i, background) / (double)n;
    return sum;
}

/* alpha e + (1 - alpha) sky, for a pane that glows with e before a white sky, and behind
 * one that does not; opaque behind it, the sky is gone. */
static void panes_before_the_sky(void **state)
{
    (void)state;
    struct fixture f;
    struct picture p;
    struct pbnds_material m[3] = {pane(0.3f), pane(0.6f), lambert(0.0f)};
    m[1].emissive = pbnds_splat(2.0f);
    m[2].emissive = pbnds_splat(5.0f);
    struct pbnds_mesh meshes[3] = {wall(0.0f, 0)};
    fixture_scene(&f, meshes, 1, m, 3);
    fixture_light(&f, 4, light_white);
    fixture_view(&f, pbnds_vec3_make(0.0f, 0.0f, 5.0f), ZERO, 16, 16);
    assert_near(f.gbuffer.coverage[0], 0.0, 0.0); /* alpha < 1/2: the first is none */
    take(&f, 256, &p);
    assert_near(mean_shown(&p, 1.0), 0.7, 0.005);
    assert_near(mean_shown(&p, 0.0), 0.0, 0.0);
    drop(&p);
    fixture_free(&f);

    meshes[0] = wall(0.0f, 0);
    meshes[1] = wall(-1.0f, 1);
    fixture_scene(&f, meshes, 2, m, 3);
    fixture_light(&f, 4, light_white);
    fixture_view(&f, pbnds_vec3_make(0.0f, 0.0f, 5.0f), ZERO, 16, 16);
    take(&f, 256, &p);
    assert_near(mean_shown(&p, 1.0), 0.7 * (0.6 * 2.0 + 0.4), 0.01);
    assert_near(mean_shown(&p, 0.0), 0.7 * 0.6 * 2.0, 0.01);
    drop(&p);
    fixture_free(&f);

    meshes[0] = wall(0.0f, 0);
    meshes[1] = wall(-1.0f, 1);
    meshes[2] = wall(-2.0f, 2);
    fixture_scene(&f, meshes, 3, m, 3);
    fixture_view(&f, pbnds_vec3_make(0.0f, 0.0f, 5.0f), ZERO, 16, 16);
    take(&f, 256, &p);
    for (size_t i = 0; i < 256; ++i)
        assert_near(p.alpha.data[i], 1.0, 0.0);
    assert_near(mean_shown(&p, 9.0), 0.7 * (0.6 * 2.0 + 0.4 * 5.0), 0.0075);
    drop(&p);
    fixture_free(&f);
}

/* The eye's ray and the sky's light go through the same triangle: each lets 1 - alpha
 * pass, and independently. */
static void a_layer_counts_once_a_ray(void **state)
{
    (void)state;
    struct fixture f;
    struct picture p;
    const struct pbnds_material m[2] = {pane(0.3f), lambert(0.8f)};
    struct pbnds_mesh meshes[2] = {wall(0.0f, 0), wall(-0.01f, 1)};
    fixture_scene(&f, meshes, 2, m, 2);
    fixture_light(&f, 4, light_white);
    fixture_view(&f, pbnds_vec3_make(0.0f, 0.0f, 5.0f), ZERO, 16, 16);
    take(&f, 256, &p);
    assert_near(mean_shown(&p, 0.0), 0.7 * 0.7 * 0.8, 0.004);
    drop(&p);
    fixture_free(&f);
}

/* Where nothing blends, and behind opaque surfaces, the G-buffer's surfaces are the first
 * ones, and there is no other coverage. */
static void opaque_pixels_start_at_the_gbuffer(void **state)
{
    (void)state;
    struct fixture f, g;
    struct picture p, q;
    const struct pbnds_material m[2] = {lambert(0.6f), pane(0.5f)};
    struct pbnds_mesh meshes[2] = {sphere(ZERO, 1.0f, 8, 0)};
    fixture_scene(&f, meshes, 1, m, 2);
    fixture_light(&f, 4, light_sunny);
    fixture_view(&f, pbnds_vec3_make(0.0f, 0.0f, 5.0f), ZERO, 12, 12);
    take(&f, 16, &p);
    assert_null(p.alpha.data);
    /* a pane far below the view, in the shade of nothing */
    meshes[0] = sphere(ZERO, 1.0f, 8, 0);
    meshes[1] = floor_at(-50.0f, 0.01f, 1);
    fixture_scene(&g, meshes, 2, m, 2);
    fixture_light(&g, 4, light_sunny);
    fixture_view(&g, pbnds_vec3_make(0.0f, 0.0f, 5.0f), ZERO, 12, 12);
    take(&g, 16, &q);
    for (size_t i = 0; i < 144; ++i) {
        assert_near(q.alpha.data[i], f.gbuffer.coverage[i], 0.0);
        for (size_t c = 0; c < 3; ++c)
            assert_near(q.radiance.data[3 * i + c], p.radiance.data[3 * i + c],
                        1e-5 * (double)p.radiance.data[3 * i + c]);
    }
    drop(&p);
    drop(&q);
    fixture_free(&f);
    fixture_free(&g);
}

/* A glowing square that covers 2.5 x 2.5 pixels' sides of an anti-aliased picture. */
static void edges_cover_their_share(void **state)
{
    (void)state;
    struct fixture f;
    struct picture p;
    struct pbnds_material m = lambert(0.0f);
    m.emissive = pbnds_splat(4.0f);
    const struct pbnds_mesh mesh =
        quad(pbnds_vec3_make(-1.25f, -1.25f, 0.0f), pbnds_vec3_make(2.5f, 0.0f, 0.0f),
             pbnds_vec3_make(0.0f, 2.5f, 0.0f), 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_view(&f, pbnds_vec3_make(0.0f, 0.0f, 5.0f), ZERO, 4, 4);
    struct pbnds_camera *camera = &f.gbuffer.camera; /* pixels of one metre's side */
    camera->orthographic = true;
    camera->ymag = 2.0f;
    f.gbuffer.samples = 16;
    take(&f, 1024, &p);
    for (size_t i = 0; i < 16; ++i) {
        const double x = i % 4 == 0 || i % 4 == 3 ? 0.25 : 1.0;
        const double y = i / 4 == 0 || i / 4 == 3 ? 0.25 : 1.0;
        assert_near(p.alpha.data[i], x * y, 0.01);
        assert_near(p.radiance.data[3 * i], 4.0, 1e-4);
        assert_near(shown(&p, i, 1.0), 1.0 + 3.0 * x * y, 0.03);
    }
    drop(&p);
    fixture_free(&f);
}

/* A sunny ball on a floor with a lamp: something of everything. */
static void scene_of_noise(struct fixture *f, int side)
{
    struct pbnds_material m[3] = {lambert(0.7f), matte(0.8f), lambert(0.0f)};
    m[1].ior_f0 = 0.04f;
    m[1].roughness = 0.4f;
    m[2].emissive = pbnds_vec3_make(6.0f, 4.0f, 2.0f);
    const struct pbnds_mesh meshes[3] = {
        floor_at(0.0f, 4.0f, 0), sphere(pbnds_vec3_make(0.0f, 0.8f, 0.0f), 0.8f, 10, 1),
        quad(pbnds_vec3_make(-2.0f, 0.2f, -1.0f), pbnds_vec3_make(0.6f, 0.0f, -0.6f),
             pbnds_vec3_make(0.0f, 1.4f, 0.0f), 2)};
    fixture_scene(f, meshes, 3, m, 3);
    fixture_light(f, 8, light_sunny);
    fixture_view(f, pbnds_vec3_make(0.2f, 1.8f, 4.5f),
                 pbnds_vec3_make(0.0f, 0.6f, 0.0f), side, side);
}

/* The estimate from one picture against the spread of many: from above, but not by far. */
static void variance_is_an_estimate_from_above(void **state)
{
    (void)state;
    enum { PICTURES = 48, SIDE = 8, VALUES = 3 * SIDE * SIDE };
    struct fixture f;
    double sum[VALUES] = {0.0}, square[VALUES] = {0.0}, estimate = 0.0, spread = 0.0;
    scene_of_noise(&f, SIDE);
    for (int k = 0; k < PICTURES; ++k) {
        struct picture p;
        f.job.seed = 100u + (uint64_t)k;
        take(&f, 64, &p);
        assert_int_equal(p.taken, 64);
        for (int i = 0; i < VALUES; ++i) {
            const double x = (double)p.radiance.data[i];
            sum[i] += x / PICTURES;
            square[i] += x * x / PICTURES;
            assert_true(p.variance.data[i] >= 0.0f);
            estimate += (double)p.variance.data[i] / PICTURES;
        }
        drop(&p);
    }
    for (int i = 0; i < VALUES; ++i)
        spread += (square[i] - sum[i] * sum[i]) * PICTURES / (PICTURES - 1);
    print_message("estimated variance / variance: %.3f\n", estimate / spread);
    assert_true(estimate > 0.9 * spread);
    assert_true(estimate < 2.5 * spread);
    fixture_free(&f);
}

/* Independent samples, for once: of a pane that glows the light is alpha e with variance
 * e^2 alpha (1 - alpha) / n, and chance has no low discrepancy. */
static void variance_of_pure_chance(void **state)
{
    (void)state;
    struct fixture f;
    struct picture p;
    struct pbnds_material m = pane(0.3f);
    m.emissive = pbnds_splat(2.0f);
    const struct pbnds_mesh mesh = wall(0.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_view(&f, pbnds_vec3_make(0.0f, 0.0f, 5.0f), ZERO, 16, 16);
    const int counts[3] = {2, 100, 256};
    for (int k = 0; k < 3; ++k) {
        double mean = 0.0;
        take(&f, counts[k], &p);
        for (size_t i = 0; i < 256; ++i)
            mean += (double)p.variance.data[3 * i] / 256.0;
        const double want = 4.0 * 0.21 / counts[k];
        assert_near(mean, want, 0.1 * want);
        drop(&p);
    }
    take(&f, 1, &p);
    assert_null(p.variance.data); /* one sample says nothing of its variance */
    drop(&p);
    fixture_free(&f);
}

/* The definition of pathtrace.h. */
static double noise_of(const struct fixture *f, const struct picture *p)
{
    double error = 0.0, sum = 0.0, values = 0.0;
    const size_t n = (size_t)p->radiance.width * (size_t)p->radiance.height * 3;
    for (size_t i = 0; i < n; ++i) {
        const double covered =
            (double)(p->alpha.data ? p->alpha.data : f->gbuffer.coverage)[i / 3];
        if (covered == 0.0) continue;
        values += 1.0;
        error += (double)p->variance.data[i];
        sum += covered * (double)p->radiance.data[i];
    }
    return sqrt(error / values) / (sum / values);
}

static void the_noise_target_stops(void **state)
{
    (void)state;
    struct fixture f;
    struct picture p, q, plain;
    scene_of_noise(&f, 12);
    const size_t size = 12 * 12 * 3 * sizeof(float);
    f.job.noise = 0.015f;
    pbnds_set_threads(1);
    take(&f, 4096, &p);
    assert_true(p.taken < 4096 && p.taken >= 8 * 32 && p.taken % 32 == 0);
    assert_true(noise_of(&f, &p) < 0.015);
    pbnds_set_threads(3);
    take(&f, 4096, &q);
    assert_int_equal(p.taken, q.taken);
    assert_memory_equal(p.radiance.data, q.radiance.data, size);
    assert_memory_equal(p.variance.data, q.variance.data, size);
    drop(&q);
    print_message("%d samples, noise %g\n", p.taken, noise_of(&f, &p));
    /* a wish twice as fine takes longer */
    f.job.noise = 0.0075f;
    take(&f, 1 << 14, &q);
    assert_true(q.taken > 2 * p.taken && q.taken < 1 << 14);
    assert_true(noise_of(&f, &q) < 0.0075);
    print_message("%d samples, noise %g\n", q.taken, noise_of(&f, &q));
    drop(&p);
    drop(&q);
    /* what cannot be reached ends at spp, with the very picture that has no target */
    f.job.noise = 1e-6f;
    take(&f, 200, &p);
    f.job.noise = 0.0f;
    take(&f, 200, &plain);
    assert_int_equal(p.taken, 200);
    assert_int_equal(plain.taken, 200);
    assert_memory_equal(p.radiance.data, plain.radiance.data, size);
    assert_memory_equal(p.direct.data, plain.direct.data, size);
    assert_memory_equal(p.variance.data, plain.variance.data, size);
    drop(&p);
    drop(&plain);
    fixture_free(&f);
}

/* What is asked for beside the picture does not change it. */
static void one_seed_one_picture(void **state)
{
    (void)state;
    struct fixture f;
    struct picture p;
    struct pbnds_image alone;
    struct pbnds_error error;
    const struct pbnds_pathtrace_options options = {.spp = 50};
    scene_of_noise(&f, 12);
    f.scene.materials[1].alpha_mode = PBNDS_ALPHA_BLEND;
    f.scene.materials[1].base_color.w = 0.5f;
    pbnds_accel_free(f.accel);
    must(pbnds_accel_create(&f.scene, &f.accel, &error), &error);
    f.job.accel = f.accel;
    take(&f, 50, &p);
    pbnds_set_threads(2);
    must(pbnds_pathtrace(&f.job, &options, &alone, NULL, &error), &error);
    assert_memory_equal(alone.data, p.radiance.data, 12 * 12 * 3 * sizeof(float));
    pbnds_image_free(&alone);
    drop(&p);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(panes_before_the_sky),
        cmocka_unit_test(a_layer_counts_once_a_ray),
        cmocka_unit_test(opaque_pixels_start_at_the_gbuffer),
        cmocka_unit_test(edges_cover_their_share),
        cmocka_unit_test(variance_is_an_estimate_from_above),
        cmocka_unit_test(variance_of_pure_chance),
        cmocka_unit_test(the_noise_target_stops),
        cmocka_unit_test(one_seed_one_picture),
    };
    return cmocka_run_group_tests_name("engine/shade/pathtrace_film", tests, NULL,
                                       NULL);
}
