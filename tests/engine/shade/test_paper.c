/* engine/shade/shader_paper.c against formulas written out in double precision. */
#include "tests/test.h"

#include "engine/core/parallel.h"
#include "engine/shade/shader_paper.h"
#include "tests/engine/shade/fixture.h"

static double positive(double x)
{
    return x > 0.0 ? x : 0.0;
}

struct angles {
    double n_l, n_v, n_h, h_v;
};

static struct angles angles_of(struct pbnds_vec3 n, struct pbnds_vec3 v,
                               struct pbnds_vec3 l)
{
    const double h[3] = {(double)l.x + (double)v.x, (double)l.y + (double)v.y,
                         (double)l.z + (double)v.z};
    const double length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    struct angles a;
    a.n_l = positive((double)pbnds_dot(n, l));
    a.n_v = positive((double)pbnds_dot(n, v));
    a.n_h = positive(((double)n.x * h[0] + (double)n.y * h[1] + (double)n.z * h[2]) /
                     length);
    a.h_v = positive(((double)v.x * h[0] + (double)v.y * h[1] + (double)v.z * h[2]) /
                     length);
    return a;
}

static double naive_blinn_phong(const struct angles *a, double albedo, double s,
                                double r)
{
    (void)r;
    return albedo * a->n_l + s * pow(a->n_h, 16.0);
}

static double naive_ggx(const struct angles *a, double albedo, double s, double r)
{
    const double pi = acos(-1.0), k = (1.0 + r) * (1.0 + r) / 8.0;
    const double g_l = 0.5 / fmax(a->n_l * (1.0 - k) + k, 0.01);
    const double g_v = 0.5 / fmax(a->n_v * (1.0 - k) + k, 0.01);
    const double r2 = fmax(r * r, 0.01);
    const double d = fmin(exp(2.0 / r2 * (a->n_h - 1.0)) / (pi * r2), 1.0);
    const double f0 = 0.04 * (1.0 - s) + albedo * s;
    const double f = f0 + (1.0 - f0) * pow(1.0 - a->h_v, 5.0);
    return (1.0 - s) * albedo / pi + d * f * g_l * g_v;
}

/* A sphere of a material with some of everything, in front of the sunny map. */
static void ball(struct fixture *f, float metallic, float roughness)
{
    struct pbnds_material m = matte(0.7f);
    m.base_color.y = 0.4f;
    m.metallic = metallic;
    m.roughness = roughness;
    m.ior_f0 = 0.04f;
    m.emissive.z = 0.05f;
    const struct pbnds_mesh mesh = sphere(pbnds_splat(0.0f), 1.0f, 12, 0);
    fixture_scene(f, &mesh, 1, &m, 1);
    fixture_light(f, 32, light_sunny);
    fixture_view(f, pbnds_vec3_make(0.3f, 0.5f, 3.5f), pbnds_splat(0.0f), 12, 12);
}

static void assert_matches(const struct fixture *f, const char *name, int count,
                           double (*naive)(const struct angles *, double, double,
                                           double))
{
    struct pbnds_error error;
    struct pbnds_image image;
    const struct pbnds_gbuffer *g = &f->gbuffer;
    must(pbnds_shade(pbnds_shader_find(name), &f->job, &image, &error), &error);
    for (size_t i = 0; i < 144; ++i)
        for (size_t c = 0; c < 3; ++c) {
            double sum = 0.0;
            const struct pbnds_vec3 n = {g->normal[0][i], g->normal[1][i],
                                         g->normal[2][i]};
            const struct pbnds_vec3 v =
                pbnds_gbuffer_wo(g, (int)(i % 12), (int)(i / 12));
            for (int j = 0; j < count && g->coverage[i] > 0.0f; ++j) {
                const struct pbnds_vec3 l = pbnds_paper_direction(f->job.seed, j);
                const struct pbnds_vec3 light = pbnds_envmap_eval(f->envmap, l);
                const double radiance = (double)(c == 0   ? light.x
                                                 : c == 1 ? light.y
                                                          : light.z);
                const struct angles a = angles_of(n, v, l);
                sum += naive(&a, (double)g->albedo[c][i], (double)g->specular[i],
                             (double)g->roughness[i]) *
                       radiance * 2.0 * acos(-1.0) * a.n_l;
            }
            const double expected =
                fmin(fmax(sum / count + (double)g->emission[c][i], 0.0), 1.0);
            assert_near(image.data[3 * i + c], expected, 1e-4);
        }
    pbnds_image_free(&image);
}

static void formulas_match_the_naive_loops(void **state)
{
    (void)state;
    const float materials[][2] = {
        {0.0f, 0.6f}, {0.0f, 0.05f}, {1.0f, 0.3f}, {0.5f, 1.0f}};
    for (size_t m = 0; m < sizeof materials / sizeof *materials; ++m) {
        struct fixture f;
        ball(&f, materials[m][0], materials[m][1]);
        assert_matches(&f, "paper-blinn-phong", 128, naive_blinn_phong);
        assert_matches(&f, "paper-ggx", 128, naive_ggx);
        f.job.lights = 9;
        assert_matches(&f, "paper-ggx", 9, naive_ggx);
        fixture_free(&f);
    }
}

/* White, matte, L = 1: 0.51 of the light comes back; Blinn-Phong: the mean of
 * 2 pi n.l^2 over the sphere, pi/3 clamped away, here of albedo 0.5. */
static void the_white_furnace_gives_half(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    struct pbnds_image image;
    const struct pbnds_material m[2] = {matte(1.0f), matte(0.5f)};
    const struct pbnds_mesh meshes[2] = {
        quad(pbnds_vec3_make(-9.0f, 0.0f, 9.0f), pbnds_vec3_make(9.0f, 0.0f, 0.0f),
             pbnds_vec3_make(0.0f, 0.0f, -18.0f), 0),
        quad(pbnds_vec3_make(0.0f, 0.0f, 9.0f), pbnds_vec3_make(9.0f, 0.0f, 0.0f),
             pbnds_vec3_make(0.0f, 0.0f, -18.0f), 1)};
    fixture_scene(&f, meshes, 2, m, 2);
    fixture_light(&f, 8, light_white);
    fixture_view(&f, pbnds_vec3_make(0.0f, 3.0f, 0.0f), pbnds_splat(0.0f), 2, 1);
    f.job.lights = 100000;
    must(pbnds_shade(pbnds_shader_find("paper-ggx"), &f.job, &image, &error), &error);
    assert_near(image.data[0], 0.51, 0.01);
    pbnds_image_free(&image);
    must(pbnds_shade(pbnds_shader_find("paper-blinn-phong"), &f.job, &image, &error),
         &error);
    assert_near(image.data[0], 1.0, 0.0);
    assert_near(image.data[3], 0.5 * acos(-1.0) / 3.0, 0.01);
    pbnds_image_free(&image);
    fixture_free(&f);
}

/* The mean of z is 0 +- 1/sqrt(3 n), of z^2 1/3, of |phi sectors| equal. */
static void directions_are_uniform_over_the_sphere(void **state)
{
    (void)state;
    enum { N = 40000 };
    double z = 0.0, z2 = 0.0, x2 = 0.0, xy = 0.0;
    for (int i = 0; i < N; ++i) {
        const struct pbnds_vec3 l = pbnds_paper_direction(1, i);
        assert_near(pbnds_length(l), 1.0, 1e-5);
        z += (double)l.z / N;
        z2 += (double)(l.z * l.z) / N;
        x2 += (double)(l.x * l.x) / N;
        xy += (double)(l.x * l.y) / N;
    }
    assert_near(z, 0.0, 0.012);
    assert_near(z2, 1.0 / 3.0, 0.006);
    assert_near(x2, 1.0 / 3.0, 0.006);
    assert_near(xy, 0.0, 0.006);
}

static void no_light_is_exactly_black(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    struct pbnds_image image;
    ball(&f, 0.0f, 0.5f);
    fixture_light(&f, 8, light_black);
    for (int without = 0; without < 2; ++without) {
        if (without) f.job.envmap = NULL;
        for (int s = 0; s < 2; ++s) {
            const char *name = s ? "paper-ggx" : "paper-blinn-phong";
            must(pbnds_shade(pbnds_shader_find(name), &f.job, &image, &error), &error);
            for (size_t i = 0; i < 144; ++i) {
                assert_near(image.data[3 * i], 0.0, 0.0);
                assert_near(image.data[3 * i + 2], f.gbuffer.emission[2][i], 0.0);
            }
            pbnds_image_free(&image);
        }
    }
    fixture_free(&f);
}

static void threads_do_not_matter_and_the_seed_does(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    struct pbnds_image one, five, other;
    ball(&f, 0.0f, 0.5f);
    const struct pbnds_shader *ggx = pbnds_shader_find("paper-ggx");
    pbnds_set_threads(1);
    must(pbnds_shade(ggx, &f.job, &one, &error), &error);
    pbnds_set_threads(5);
    must(pbnds_shade(ggx, &f.job, &five, &error), &error);
    f.job.seed = 8;
    must(pbnds_shade(ggx, &f.job, &other, &error), &error);
    const size_t size = 144 * 3 * sizeof *one.data;
    assert_memory_equal(one.data, five.data, size);
    assert_memory_not_equal(one.data, other.data, size);
    pbnds_image_free(&one);
    pbnds_image_free(&five);
    pbnds_image_free(&other);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(formulas_match_the_naive_loops),
        cmocka_unit_test(the_white_furnace_gives_half),
        cmocka_unit_test(directions_are_uniform_over_the_sphere),
        cmocka_unit_test(no_light_is_exactly_black),
        cmocka_unit_test(threads_do_not_matter_and_the_seed_does),
    };
    return cmocka_run_group_tests_name("engine/shade/paper", tests, NULL, NULL);
}
