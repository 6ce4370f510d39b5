/* Direct light (ggx, blinn-phong) against quadrature over the map's texels and
 * geometry. */
#include "tests/test.h"

#include <string.h>

#include "engine/core/parallel.h"
#include "engine/shade/direct.h"
#include "tests/engine/shade/fixture.h"

enum { W = 8, H = 6, ROWS = 16 };

static void shade(const struct fixture *f, const char *name, struct pbnds_image *image)
{
    struct pbnds_error error;
    must(pbnds_shade(pbnds_shader_find(name), &f->job, image, &error), &error);
}

static struct pbnds_material glossy(float metallic, float roughness)
{
    struct pbnds_material m = matte(0.8f);
    m.base_color.z = 0.3f;
    m.metallic = metallic;
    m.roughness = roughness;
    m.ior_f0 = 0.04f;
    return m;
}

/* One ball over a floor. */
static void still_life(struct fixture *f, float metallic, float roughness)
{
    const struct pbnds_material m[2] = {glossy(0.0f, 0.7f),
                                        glossy(metallic, roughness)};
    const struct pbnds_mesh meshes[2] = {
        floor_at(0.0f, 4.0f, 0),
        sphere(pbnds_vec3_make(0.0f, 1.0f, 0.0f), 1.0f, 16, 1)};
    fixture_scene(f, meshes, 2, m, 2);
    fixture_light(f, ROWS, light_sunny);
    fixture_view(f, pbnds_vec3_make(0.5f, 2.0f, 5.0f),
                 pbnds_vec3_make(0.0f, 0.7f, 0.0f), W, H);
}

/* The integral over every texel of the map, n x n directions in each; shadow edges
 * cross texels, so they want more. */
static struct pbnds_vec3 brute_force(const struct fixture *f, size_t i,
                                     bool blinn_phong, bool shadows)
{
    const struct pbnds_gbuffer *g = &f->gbuffer;
    const struct pbnds_bsdf bsdf = pbnds_bsdf_from_gbuffer(g, i);
    const struct pbnds_blinn_phong bp = pbnds_blinn_phong_make(&bsdf);
    const struct pbnds_vec3 wo = pbnds_gbuffer_wo(g, (int)(i % W), (int)(i / W));
    const struct pbnds_vec3 ng = {g->geometric_normal[0][i], g->geometric_normal[1][i],
                                  g->geometric_normal[2][i]};
    const struct pbnds_vec3 p = {g->position[0][i], g->position[1][i],
                                 g->position[2][i]};
    const int n = shadows ? 12 : 6, rows = n * ROWS;
    const double cell = acos(-1.0) / rows; /* the angle of a step, both ways */
    double sum[3] = {0.0, 0.0, 0.0};
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < 2 * rows; ++x) {
            const float theta = (float)cell * ((float)y + 0.5f);
            const float phi = (float)cell * ((float)x + 0.5f);
            const struct pbnds_vec3 wi = {sinf(theta) * cosf(phi), cosf(theta),
                                          sinf(theta) * sinf(phi)};
            const float cos_i = pbnds_dot(bsdf.frame.n, wi);
            if (cos_i <= 0.0f) continue;
            const struct pbnds_ray ray = {pbnds_offset_origin(p, ng), wi};
            if (shadows && (pbnds_dot(ng, wi) <= 0.0f ||
                            pbnds_accel_occluded(f->accel, &ray, INFINITY)))
                continue;
            const struct pbnds_vec3 r = blinn_phong
                                            ? pbnds_blinn_phong_eval(&bp, wo, wi)
                                            : pbnds_bsdf_eval(&bsdf, wo, wi);
            const struct pbnds_vec3 l = pbnds_envmap_eval(f->envmap, wi);
            const double weight = (double)cos_i * sin((double)theta) * cell * cell;
            sum[0] += (double)(r.x * l.x) * weight;
            sum[1] += (double)(r.y * l.y) * weight;
            sum[2] += (double)(r.z * l.z) * weight;
        }
    return pbnds_vec3_make((float)sum[0], (float)sum[1], (float)sum[2]);
}

/* Every pixel within `each` of the quadrature, and the image's mean within a tenth. */
static void assert_matches(struct fixture *f, const char *name, bool shadows,
                           double each)
{
    struct pbnds_image image;
    f->job.spp = 1024;
    f->job.shadows = shadows;
    shade(f, name, &image);
    double difference = 0.0, total = 0.0;
    for (size_t i = 0; i < W * H; ++i) {
        if (!(f->gbuffer.coverage[i] > 0.0f)) {
            assert_near(image.data[3 * i], 0.0, 0.0);
            continue;
        }
        const struct pbnds_vec3 e = brute_force(f, i, name[0] == 'b', shadows);
        assert_near(image.data[3 * i], e.x, each * (double)e.x + 1e-3);
        assert_near(image.data[3 * i + 1], e.y, each * (double)e.y + 1e-3);
        assert_near(image.data[3 * i + 2], e.z, each * (double)e.z + 1e-3);
        difference += (double)(image.data[3 * i] - e.x);
        total += (double)e.x;
    }
    assert_near(difference / total, 0.0, each / 10.0);
    pbnds_image_free(&image);
}

static void sampling_matches_quadrature(void **state)
{
    (void)state;
    const float materials[][2] = {{0.0f, 1.0f}, {0.0f, 0.4f}, {1.0f, 0.35f}};
    for (size_t m = 0; m < sizeof materials / sizeof *materials; ++m) {
        struct fixture f;
        still_life(&f, materials[m][0], materials[m][1]);
        assert_matches(&f, "ggx", false, 0.03);
        assert_matches(&f, "blinn-phong", false, 0.03);
        fixture_free(&f);
    }
}

static void shadowed_sampling_matches_quadrature(void **state)
{
    (void)state;
    struct fixture f;
    still_life(&f, 0.0f, 0.5f);
    assert_matches(&f, "ggx", true, 0.05);
    fixture_free(&f);
}

static double one_pixel(struct fixture *f, const char *name)
{
    struct pbnds_image image;
    shade(f, name, &image);
    const float value = image.data[0];
    pbnds_image_free(&image);
    return (double)value;
}

/* One pixel that looks straight down at the floor, under a white sky. */
static void looking_down(struct fixture *f, const struct pbnds_mesh *meshes, int count)
{
    struct pbnds_material m[2] = {glossy(0.0f, 0.8f), matte(0.0f)};
    fixture_scene(f, meshes, count, m, 2);
    fixture_light(f, 8, light_white);
    fixture_view(f, pbnds_vec3_make(0.0f, 3.0f, 0.0f), pbnds_splat(0.0f), 1, 1);
    f->job.spp = 4096;
}

/* A wall beside the point hides half of the sky's azimuths (all but a sliver on top),
 * and seen along the normal every azimuth counts the same. */
static void a_wall_takes_half_of_the_sky(void **state)
{
    (void)state;
    struct fixture f;
    const struct pbnds_mesh meshes[2] = {floor_at(0.0f, 2.0f, 0),
                                         quad(pbnds_vec3_make(0.1f, -1.0f, -500.0f),
                                              pbnds_vec3_make(0.0f, 0.0f, 1000.0f),
                                              pbnds_vec3_make(0.0f, 500.0f, 0.0f), 1)};
    looking_down(&f, meshes, 2);
    f.job.shadows = 0;
    const double open = one_pixel(&f, "ggx");
    f.job.shadows = 1;
    assert_near(one_pixel(&f, "ggx"), 0.5 * open, 0.005 * open);
    const double walled = one_pixel(&f, "ggx");
    /* -1: on for ggx, off for blinn-phong */
    f.job.shadows = -1;
    assert_near(one_pixel(&f, "ggx"), walled, 0.0);
    const double phong = one_pixel(&f, "blinn-phong");
    f.job.shadows = 0;
    assert_near(one_pixel(&f, "blinn-phong"), phong, 0.0);
    f.job.shadows = 1;
    assert_near(one_pixel(&f, "blinn-phong"), 0.5 * phong, 0.005 * phong);
    /* no scene, no shadows, whatever is asked */
    f.job.scene = NULL;
    f.job.accel = NULL;
    assert_near(one_pixel(&f, "ggx"), open, 0.0);
    fixture_free(&f);
}

static void under_a_lid_it_is_dark(void **state)
{
    (void)state;
    struct fixture f;
    const struct pbnds_mesh meshes[2] = {floor_at(0.0f, 50.0f, 0),
                                         floor_at(4.0f, 5000.0f, 1)};
    looking_down(&f, meshes, 2);
    f.job.shadows = 0;
    assert_true(one_pixel(&f, "ggx") > 0.5);
    f.job.shadows = 1;
    assert_near(one_pixel(&f, "ggx"), 0.0, 2e-3);
    fixture_free(&f);
}

/* White below the horizon only. */
static struct pbnds_vec3 light_below(float u, float v)
{
    (void)u;
    return pbnds_splat(v > 0.5f ? 1.0f : 0.0f);
}

/* A floor whose vertex normals lean by 60 degrees: seen by the shading normal light
 * from below the floor would come in; with shadows the floor itself keeps it out. */
static void light_does_not_leak_through_the_surface(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_mesh mesh = floor_at(0.0f, 2.0f, 0);
    mesh.normal = must_alloc(4, sizeof *mesh.normal);
    for (int i = 0; i < 4; ++i)
        mesh.normal[i] = pbnds_vec3_make(0.8660254f, 0.5f, 0.0f);
    looking_down(&f, &mesh, 1);
    fixture_light(&f, 8, light_below);
    f.job.shadows = 0;
    assert_true(one_pixel(&f, "ggx") > 0.1);
    f.job.shadows = 1;
    assert_near(one_pixel(&f, "ggx"), 0.0, 0.0);
    fixture_free(&f);
}

/* The floor under one or two lamps of the file; f0 = f90 = 0 makes it Lambert's. */
static void under_lamps(struct fixture *f, const struct pbnds_mesh *meshes, int count,
                        const struct pbnds_light *lights, int light_count, float alpha)
{
    struct pbnds_material m[2] = {matte(0.8f), matte(0.5f)};
    m[0].specular = 0.0f;
    m[1].base_color.w = alpha;
    m[1].alpha_mode = alpha < 1.0f ? PBNDS_ALPHA_BLEND : PBNDS_ALPHA_OPAQUE;
    fixture_scene(f, meshes, count, m, 2);
    f->scene.lights = must_alloc((size_t)light_count, sizeof *lights);
    memcpy(f->scene.lights, lights, (size_t)light_count * sizeof *lights);
    f->scene.light_count = light_count;
    fixture_view(f, pbnds_vec3_make(0.0f, 3.0f, 0.0f), pbnds_splat(0.0f), 1, 1);
}

static const struct pbnds_light LAMP = {.kind = PBNDS_LIGHT_POINT,
                                        .position = {3.0f, 4.0f, 0.0f},
                                        .intensity = {50.0f, 50.0f, 50.0f},
                                        .range = INFINITY};
static const struct pbnds_light SUN = {.kind = PBNDS_LIGHT_DIRECTIONAL,
                                       .direction = {0.0f, -0.6f, 0.8f},
                                       .intensity = {2.0f, 2.0f, 2.0f},
                                       .range = INFINITY};

/* rho / pi I cos / d^2 of a lamp 5 m away at a cosine of 4/5, and rho / pi E cos. */
static void lamps_have_their_closed_form(void **state)
{
    (void)state;
    const double lamp = 0.8 / acos(-1.0) * 50.0 * 0.8 / 25.0;
    const double sun = 0.8 / acos(-1.0) * 2.0 * 0.6;
    const struct pbnds_light both[2] = {LAMP, SUN};
    const char *names[] = {"ggx", "blinn-phong"};
    for (int s = 0; s < 2; ++s)
        for (int shadows = 0; shadows < 2; ++shadows) {
            struct fixture f;
            const struct pbnds_mesh mesh = floor_at(0.0f, 2.0f, 0);
            under_lamps(&f, &mesh, 1, both, 2, 1.0f);
            f.job.shadows = shadows;
            assert_near(one_pixel(&f, names[s]), lamp + sun, 2e-5);
            /* the map's light comes on top: rho of a white one */
            fixture_light(&f, 8, light_white);
            f.job.spp = 256;
            assert_near(one_pixel(&f, names[s]), lamp + sun + 0.8, 1e-3);
            f.job.envmap = NULL;
            f.scene.light_count = 1;
            assert_near(one_pixel(&f, names[s]), lamp, 2e-5);
            f.scene.light_count = 0;
            assert_near(one_pixel(&f, names[s]), 0.0, 0.0);
            f.scene.light_count = 2;
            f.job.scene = NULL; /* a G-buffer from a file knows no lights */
            f.job.accel = NULL;
            assert_near(one_pixel(&f, names[s]), 0.0, 0.0);
            fixture_free(&f);
        }
}

/* A sheet below the lamp hides it, above it does not; a sheet that blends hides its
 * alpha, whichever light comes through. */
static void lamps_throw_shadows(void **state)
{
    (void)state;
    const double lamp = 0.8 / acos(-1.0) * 50.0 * 0.8 / 25.0;
    const float heights[] = {3.5f, 4.5f}, alphas[] = {1.0f, 0.3f};
    for (int h = 0; h < 2; ++h)
        for (int a = 0; a < 2; ++a) {
            struct fixture f;
            const struct pbnds_vec3 o = {1.5f, heights[h], -1.0f};
            const struct pbnds_mesh meshes[2] = {
                floor_at(0.0f, 2.0f, 0), quad(o, pbnds_vec3_make(4.0f, 0.0f, 0.0f),
                                              pbnds_vec3_make(0.0f, 0.0f, 2.0f), 1)};
            under_lamps(&f, meshes, 2, &LAMP, 1, alphas[a]);
            f.job.spp = 4096;
            const double seen = h == 1 ? 1.0 : a == 0 ? 0.0 : 0.7;
            const double noise = seen < 1.0 && seen > 0.0 ? 0.03 : 1e-5;
            assert_near(one_pixel(&f, "ggx") / lamp, seen, noise); /* on by default */
            f.job.shadows = 0;
            assert_near(one_pixel(&f, "ggx") / lamp, 1.0, 1e-5);
            fixture_free(&f);
        }
}

/* Under a white sky and a huge sheet of alpha 0.3 0.7 of the light is left. */
static void the_map_shines_through_what_blends(void **state)
{
    (void)state;
    struct fixture f;
    const struct pbnds_mesh meshes[2] = {floor_at(0.0f, 2.0f, 0),
                                         floor_at(4.0f, 5000.0f, 1)};
    under_lamps(&f, meshes, 2, &LAMP, 0, 0.3f);
    fixture_light(&f, 8, light_white);
    f.job.spp = 4096;
    assert_near(one_pixel(&f, "ggx"), 0.8 * 0.7, 0.01);
    fixture_free(&f);
}

/* Half of the pixel sees the floor, half nothing: the radiance is that of the floor, and
 * what covers how much is left to who composes the picture (shader.h). */
static void a_half_covered_pixel_has_the_whole_radiance(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    const struct pbnds_mesh mesh =
        quad(pbnds_vec3_make(0.0f, 0.0f, 5.0f), pbnds_vec3_make(5.0f, 0.0f, 0.0f),
             pbnds_vec3_make(0.0f, 0.0f, -10.0f), 0);
    under_lamps(&f, &mesh, 1, &SUN, 1, 1.0f);
    const struct pbnds_camera camera = f.gbuffer.camera;
    const struct pbnds_raycast_options options = {.samples = 256};
    pbnds_gbuffer_free(&f.gbuffer);
    must(pbnds_gbuffer_raycast(&f.scene, f.accel, &camera, 1, 1, &options, &f.gbuffer,
                               &error),
         &error);
    assert_near(f.gbuffer.coverage[0], 0.5, 0.02);
    assert_near(one_pixel(&f, "ggx"), 0.8 / acos(-1.0) * 2.0 * 0.6, 1e-5);
    fixture_free(&f);
}

/* KHR_materials_specular in colour, half metal, through ray caster and planes. */
static void the_gbuffer_keeps_the_surface(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = glossy(0.4f, 0.5f);
    m.specular = 0.7f;
    m.specular_color = pbnds_vec3_make(2.0f, 0.5f, 0.1f);
    const struct pbnds_mesh mesh = floor_at(0.0f, 2.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_view(&f, pbnds_vec3_make(1.0f, 3.0f, 0.5f), pbnds_splat(0.0f), 1, 1);
    assert_non_null(f.gbuffer.f90);
    const struct pbnds_vec3 wo = pbnds_gbuffer_wo(&f.gbuffer, 0, 0);
    const struct pbnds_ray ray = {pbnds_vec3_make(1.0f, 3.0f, 0.5f),
                                  pbnds_scale(wo, -1.0f)};
    struct pbnds_hit hit;
    struct pbnds_surface surface;
    pbnds_accel_intersect(f.accel, &ray, &hit);
    pbnds_scene_surface(&f.scene, &hit, wo, 0.0f, &surface);
    const struct pbnds_bsdf a = pbnds_bsdf_from_surface(&surface);
    const struct pbnds_bsdf b = pbnds_bsdf_from_gbuffer(&f.gbuffer, 0);
    const struct pbnds_vec3 wi = pbnds_normalize(pbnds_vec3_make(-0.6f, 0.5f, 0.2f));
    const struct pbnds_vec3 p = pbnds_bsdf_eval(&a, wo, wi);
    const struct pbnds_vec3 q = pbnds_bsdf_eval(&b, wo, wi);
    assert_near(a.f0, 0.7 * 0.08, 1e-6);
    assert_near(a.f90, 0.7, 1e-6);
    assert_near(q.x, p.x, 1e-5 * (double)p.x);
    assert_near(q.y, p.y, 1e-5 * (double)p.y);
    assert_near(q.z, p.z, 1e-5 * (double)p.z);
    assert_near(pbnds_bsdf_pdf(&b, wo, wi), pbnds_bsdf_pdf(&a, wo, wi), 1e-5);
    fixture_free(&f);
}

static void no_light_is_exactly_the_emission(void **state)
{
    (void)state;
    const char *names[] = {"ggx", "blinn-phong"};
    struct fixture f;
    struct pbnds_material m = glossy(0.2f, 0.4f);
    m.emissive = pbnds_vec3_make(0.0f, 0.25f, 3.0f);
    const struct pbnds_mesh mesh = floor_at(0.0f, 2.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_view(&f, pbnds_vec3_make(0.0f, 3.0f, 0.0f), pbnds_splat(0.0f), 2, 2);
    for (int black = 0; black < 2; ++black) {
        if (black) fixture_light(&f, 8, light_black);
        for (int s = 0; s < 2; ++s) {
            struct pbnds_image image;
            shade(&f, names[s], &image);
            for (size_t i = 0; i < 4; ++i) {
                assert_near(image.data[3 * i], 0.0, 0.0);
                assert_near(image.data[3 * i + 1], 0.25, 0.0);
                assert_near(image.data[3 * i + 2], 3.0, 0.0);
            }
            pbnds_image_free(&image);
        }
    }
    fixture_free(&f);
}

static void threads_do_not_matter_and_the_seed_does(void **state)
{
    (void)state;
    const char *names[] = {"ggx", "blinn-phong"};
    struct fixture f;
    still_life(&f, 0.0f, 0.5f);
    const size_t size = W * H * 3 * sizeof(float);
    for (int s = 0; s < 2; ++s) {
        struct pbnds_image one, other;
        f.job.seed = 7;
        pbnds_set_threads(1);
        shade(&f, names[s], &one);
        const int threads[] = {2, 5};
        for (int t = 0; t < 2; ++t) {
            pbnds_set_threads(threads[t]);
            shade(&f, names[s], &other);
            assert_memory_equal(one.data, other.data, size);
            pbnds_image_free(&other);
        }
        f.job.seed = 8;
        shade(&f, names[s], &other);
        assert_memory_not_equal(one.data, other.data, size);
        pbnds_image_free(&other);
        pbnds_image_free(&one);
    }
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sampling_matches_quadrature),
        cmocka_unit_test(shadowed_sampling_matches_quadrature),
        cmocka_unit_test(a_wall_takes_half_of_the_sky),
        cmocka_unit_test(under_a_lid_it_is_dark),
        cmocka_unit_test(light_does_not_leak_through_the_surface),
        cmocka_unit_test(lamps_have_their_closed_form),
        cmocka_unit_test(lamps_throw_shadows),
        cmocka_unit_test(the_map_shines_through_what_blends),
        cmocka_unit_test(a_half_covered_pixel_has_the_whole_radiance),
        cmocka_unit_test(the_gbuffer_keeps_the_surface),
        cmocka_unit_test(no_light_is_exactly_the_emission),
        cmocka_unit_test(threads_do_not_matter_and_the_seed_does),
    };
    return cmocka_run_group_tests_name("engine/shade/direct", tests, NULL, NULL);
}
