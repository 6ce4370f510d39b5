/* engine/shade/shader_paper.c against formulas written out in double precision. */
#include "tests/test.h"

#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
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

/* The formulas of shader_paper.h once more, in float and in the order in which they stand
 * there, channel by channel, with nothing of ours but the inputs: the published numbers
 * are float too, so the results must have the same bits. */
static float dot3(const float *a, const float *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static float above_zero(float x)
{
    return x > 0.0f ? x : 0.0f;
}

struct plain {
    float n[3], v[3], l[3], h[3];
};

static struct plain plain_of(struct pbnds_vec3 n, struct pbnds_vec3 v,
                             struct pbnds_vec3 l)
{
    struct plain p = {{n.x, n.y, n.z}, {v.x, v.y, v.z}, {l.x, l.y, l.z}, {0}};
    const float sum[3] = {l.x + v.x, l.y + v.y, l.z + v.z};
    const float length = sqrtf(dot3(sum, sum));
    const float inverse = 1.0f / (length > 1e-12f ? length : 1e-12f);
    for (int c = 0; c < 3; ++c)
        p.h[c] = sum[c] * inverse;
    return p;
}

static float float_blinn_phong(const struct plain *p, float albedo, float s, float r)
{
    (void)r;
    float power = above_zero(dot3(p->n, p->h));
    for (int i = 0; i < 4; ++i)
        power *= power;
    return albedo * above_zero(dot3(p->n, p->l)) + s * power;
}

static float float_visibility(float k, float cosine)
{
    const float x = cosine * (1.0f - k) + k;
    return 0.5f / (x > 0.01f ? x : 0.01f);
}

static float float_ggx(const struct plain *p, float albedo, float s, float r)
{
    const float pi = 3.14159265358979323846f;
    const float f0 = 0.04f * (1.0f - s) + albedo * s;
    const float away = 1.0f - above_zero(dot3(p->h, p->v));
    const float m = away > 0.0f ? away : 0.0f;
    const float f = f0 + (1.0f - f0) * (m * m * m * m * m);
    const float k = (1.0f + r) * (1.0f + r) / 8.0f;
    const float v = float_visibility(k, above_zero(dot3(p->n, p->l))) *
                    float_visibility(k, above_zero(dot3(p->n, p->v)));
    const float a = r * r > 0.01f ? r * r : 0.01f;
    const float lobe =
        expf(2.0f / a * (above_zero(dot3(p->n, p->h)) - 1.0f)) / (pi * a);
    const float d = lobe < 1.0f ? lobe : 1.0f;
    return albedo * ((1.0f - s) / pi) + f * (d * v);
}

static struct pbnds_vec3 any_direction(struct pbnds_rng *rng)
{
    const float z = 2.0f * pbnds_rng_float(rng) - 1.0f;
    const float phi = 6.2831853f * pbnds_rng_float(rng), s = sqrtf(1.0f - z * z);
    return pbnds_vec3_make(s * cosf(phi), s * sinf(phi), z);
}

static void assert_bits(float a, float b, const char *what, int i)
{
    if (memcmp(&a, &b, sizeof a) != 0)
        fail_msg("%s, case %d: %a is not %a", what, i, (double)a, (double)b);
}

static void the_formulas_have_the_same_bits(void **state)
{
    (void)state;
    for (int i = 0; i < 200000; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(4, 0, (uint64_t)i);
        const struct pbnds_vec3 n = any_direction(&rng), v = any_direction(&rng);
        const struct pbnds_vec3 l =
            i % 1000 ? any_direction(&rng) : pbnds_scale(v, -1.0f);
        const float s = i % 7 ? pbnds_rng_float(&rng) : 0.0f;
        const struct pbnds_paper_material m = {
            .albedo = {pbnds_rng_float(&rng), pbnds_rng_float(&rng), 1.0f},
            .n = n,
            .roughness = i % 5 ? pbnds_rng_float(&rng) : 0.0f,
            .specular = s};
        const float albedo[3] = {m.albedo.x, m.albedo.y, m.albedo.z};
        const struct plain p = plain_of(n, v, l);
        const struct pbnds_vec3 b = pbnds_paper_blinn_phong(&m, v, l);
        const struct pbnds_vec3 g = pbnds_paper_ggx(&m, v, l);
        const float bs[3] = {b.x, b.y, b.z}, gs[3] = {g.x, g.y, g.z};
        for (int c = 0; c < 3; ++c) {
            assert_bits(bs[c], float_blinn_phong(&p, albedo[c], s, m.roughness),
                        "paper-blinn-phong", i);
            assert_bits(gs[c], float_ggx(&p, albedo[c], s, m.roughness), "paper-ggx",
                        i);
        }
    }
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

/* clamp(sum_j B(l_j) L_j <n.l_j> (2 pi / N) + emission, 0, 1), pixel by pixel. */
static void assert_same_picture(const struct fixture *f, const char *name,
                                float (*b)(const struct plain *, float, float, float))
{
    struct pbnds_error error;
    struct pbnds_image image;
    const struct pbnds_gbuffer *g = &f->gbuffer;
    must(pbnds_shade(pbnds_shader_find(name), &f->job, &image, &error), &error);
    for (int i = 0; i < 144; ++i)
        for (int c = 0; c < 3; ++c) {
            const struct pbnds_vec3 n = {g->normal[0][i], g->normal[1][i],
                                         g->normal[2][i]};
            const struct pbnds_vec3 v = pbnds_gbuffer_wo(g, i % 12, i / 12);
            float sum = 0.0f;
            for (int j = 0; j < 128 && g->coverage[i] > 0.0f; ++j) {
                const struct pbnds_vec3 l = pbnds_paper_direction(f->job.seed, j);
                const struct pbnds_vec3 light = pbnds_envmap_eval(f->envmap, l);
                const float radiance[3] = {light.x, light.y, light.z};
                const struct plain p = plain_of(n, v, l);
                const float n_l = dot3(p.n, p.l);
                if (n_l <= 0.0f) continue;
                sum += b(&p, g->albedo[c][i], g->specular[i], g->roughness[i]) *
                       radiance[c] * n_l;
            }
            sum *= 2.0f * 3.14159265358979323846f / 128.0f;
            sum += g->emission[c][i];
            assert_bits(image.data[3 * i + c],
                        sum < 0.0f   ? 0.0f
                        : sum > 1.0f ? 1.0f
                                     : sum,
                        name, i);
        }
    pbnds_image_free(&image);
}

static void the_pictures_have_the_same_bits(void **state)
{
    (void)state;
    struct fixture f;
    ball(&f, 0.3f, 0.4f);
    assert_same_picture(&f, "paper-blinn-phong", float_blinn_phong);
    assert_same_picture(&f, "paper-ggx", float_ggx);
    fixture_free(&f);
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
        cmocka_unit_test(the_formulas_have_the_same_bits),
        cmocka_unit_test(the_pictures_have_the_same_bits),
        cmocka_unit_test(formulas_match_the_naive_loops),
        cmocka_unit_test(the_white_furnace_gives_half),
        cmocka_unit_test(directions_are_uniform_over_the_sphere),
        cmocka_unit_test(no_light_is_exactly_black),
        cmocka_unit_test(threads_do_not_matter_and_the_seed_does),
    };
    return cmocka_run_group_tests_name("engine/shade/paper", tests, NULL, NULL);
}
