/* engine/scene/envmap*.c against quadrature, naive sums and the conventions'
 * definitions. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/rng.h"
#include "engine/scene/envmap.h"

static const double TAU = 6.283185307179586;

/* ------------------------------------------------------------------ helpers */

static struct pbnds_image blank(int width, int height)
{
    struct pbnds_image image;
    assert_int_equal(pbnds_image_init(&image, width, height, 3, NULL), PBNDS_OK);
    return image;
}

static void put(const struct pbnds_image *image, int x, int y, float r, float g,
                float b)
{
    float *p = pbnds_image_at(image, x, y);
    p[0] = r;
    p[1] = g;
    p[2] = b;
}

static struct pbnds_envmap *build(const struct pbnds_image *image,
                                  enum pbnds_env_convention convention, float yaw,
                                  float strength)
{
    struct pbnds_envmap *map;
    struct pbnds_error error = {""};
    if (pbnds_envmap_create(image, convention, yaw, strength, &map, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    return map;
}

/* A sky with a gradient, a black band, coloured noise and a small sun. */
static struct pbnds_image sky(int width, int height)
{
    struct pbnds_image image = blank(width, height);
    struct pbnds_rng rng = pbnds_rng_make(7, 0, 0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float up = 1.0f - (float)y / (float)height;
            const float n = pbnds_rng_float(&rng);
            const int band = y > height / 2 && y < height / 2 + 3;
            if (!band) put(&image, x, y, 0.2f * n, up * n, up * (1.0f - n));
        }
    put(&image, width / 3, height / 4, 9000.0f, 7000.0f, 5000.0f);
    put(&image, (width / 3 + 1) % width, height / 4, 9000.0f, 7000.0f, 5000.0f);
    return image;
}

static struct pbnds_vec3 at_angles(double theta, double phi)
{
    return pbnds_vec3_make((float)(sin(theta) * cos(phi)), (float)cos(theta),
                           (float)(sin(theta) * sin(phi)));
}

/* Quadrature node i of n * 2n over the sphere, uniform in cos(theta) and phi. */
static struct pbnds_vec3 node(int i, int n)
{
    const double c = 1.0 - 2.0 * (i / (2 * n) + 0.5) / n;
    return at_angles(acos(c), TAU * (i % (2 * n) + 0.5) / (2 * n));
}

static void assert_same(struct pbnds_vec3 a, struct pbnds_vec3 b, double tol)
{
    assert_near((double)a.x, (double)b.x, tol);
    assert_near((double)a.y, (double)b.y, tol);
    assert_near((double)a.z, (double)b.z, tol);
}

/* Angle by the chord: exact where the cosine is not. */
static double angle_between(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return 2.0 * asin(fmin(0.5 * (double)pbnds_length(pbnds_sub(a, b)), 1.0));
}

/* The integral of the image over the sphere, and of L max(0, n w), texel by texel with
   subdivided texels: knows nothing of the code under test but the gltf convention. */
static void integrate(const struct pbnds_image *image, struct pbnds_vec3 n,
                      int subdivide, double power[3], double irradiance[3])
{
    memset(power, 0, 3 * sizeof *power);
    memset(irradiance, 0, 3 * sizeof *irradiance);
    const int h = image->height * subdivide, w = image->width * subdivide;
    for (int y = 0; y < h; ++y) {
        const double c0 = cos(0.5 * TAU * y / h), c1 = cos(0.5 * TAU * (y + 1) / h);
        for (int x = 0; x < w; ++x) {
            const double solid_angle = TAU / w * (c0 - c1);
            const double c = 0.5 * (c0 + c1), s = sqrt(1.0 - c * c);
            const double phi = TAU * ((x + 0.5) / w - 0.5);
            const double facing = (double)n.x * s * cos(phi) + (double)n.y * c +
                                  (double)n.z * s * sin(phi);
            const float *p = pbnds_image_at(image, x / subdivide, y / subdivide);
            for (int k = 0; k < 3; ++k) {
                power[k] += (double)p[k] * solid_angle;
                irradiance[k] += (double)p[k] * solid_angle * fmax(facing, 0.0);
            }
        }
    }
}

/* -------------------------------------------------------------- conventions */

/* The bright texel is put where the convention's definition says that +X, a direction
   of azimuth 37 degrees, and -Z are; it must be seen there and nowhere else. */
static void a_texel_is_seen_where_its_convention_says(void **state)
{
    (void)state;
    static const double turn[] = {0.0, -0.25, 0.25, 0.5};
    static const double azimuth[] = {0.0, 37.0, -90.0, 179.0, 90.0};
    enum { W = 64, H = 32 };
    for (int convention = 0; convention < 4; ++convention)
        for (int i = 0; i < 5; ++i) {
            const double u = 0.5 + azimuth[i] / 360.0 + turn[convention] + 0.25 / W;
            struct pbnds_image image = blank(W, H);
            put(&image, (int)floor((u - floor(u)) * W), H / 4, 1.0f, 2.0f, 3.0f);
            struct pbnds_envmap *map =
                build(&image, (enum pbnds_env_convention)convention, 0.0f, 1.0f);
            const double theta = 0.25 * TAU * (H / 4 + 0.5) / (0.5 * H);
            const double phi = TAU * (azimuth[i] / 360.0 + 0.25 / W);
            assert_same(pbnds_envmap_eval(map, at_angles(theta, phi)),
                        pbnds_vec3_make(1.0f, 2.0f, 3.0f), 0.0);
            assert_same(pbnds_envmap_eval(map, at_angles(theta, phi + TAU * 1.25 / W)),
                        pbnds_splat(0.0f), 0.0);
            assert_same(pbnds_envmap_eval(map, at_angles(0.5 * TAU - theta, phi)),
                        pbnds_splat(0.0f), 0.0);
            pbnds_envmap_free(map);
            pbnds_image_free(&image);
        }
}

/* Known answers in words: the gltf centre column is +X, u = 3/4 is +Z, row 0 is up. */
static void the_default_convention_is_that_of_gltf(void **state)
{
    (void)state;
    struct pbnds_image image = blank(8, 4);
    for (int x = 0; x < 8; ++x) {
        put(&image, x, 0, 10.0f, 0.0f, 0.0f);
        put(&image, x, 3, 20.0f, 0.0f, 0.0f);
        for (int y = 1; y < 3; ++y)
            put(&image, x, y, 0.0f, (float)x, 0.0f);
    }
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    const float e = 0.1f; /* a little past the texel's edge, towards growing u */
    static const struct pbnds_vec3 up = {0, 1, 0}, down = {0, -1, 0};
    assert_near((double)pbnds_envmap_eval(map, up).x, 10.0, 0.0);
    assert_near((double)pbnds_envmap_eval(map, down).x, 20.0, 0.0);
    assert_near((double)pbnds_envmap_eval(map, pbnds_vec3_make(1, 0, e)).y, 4.0, 0.0);
    assert_near((double)pbnds_envmap_eval(map, pbnds_vec3_make(-e, 0, 1)).y, 6.0, 0.0);
    assert_near((double)pbnds_envmap_eval(map, pbnds_vec3_make(-1, 0, -e)).y, 0.0, 0.0);
    assert_near((double)pbnds_envmap_eval(map, pbnds_vec3_make(-1, 0, e)).y, 7.0, 0.0);
    assert_near((double)pbnds_envmap_eval(map, pbnds_vec3_make(e, 0, -1)).y, 2.0, 0.0);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

static void yaw_turns_the_light_about_y(void **state)
{
    (void)state;
    enum { W = 64, H = 32 };
    struct pbnds_image image = blank(W, H);
    put(&image, W / 2, H / 2, 1.0f, 1.0f, 1.0f); /* just right of +X */
    const float e = 0.04f;
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 90.0f, 1.0f);
    /* R_y(90 degrees) takes +X to -Z and +Z to +X */
    assert_near((double)pbnds_envmap_eval(map, pbnds_vec3_make(e, -e, -1)).x, 1.0, 0.0);
    assert_near((double)pbnds_envmap_eval(map, pbnds_vec3_make(1, -e, e)).x, 0.0, 0.0);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);

    /* any yaw: L(w) = L_map(R_y(-yaw) w) */
    image = sky(W, H);
    struct pbnds_envmap *still = build(&image, PBNDS_ENV_FALCOR, 0.0f, 1.0f);
    static const float yaws[] = {12.5f, -200.0f, 725.3f, 359.99f};
    for (int k = 0; k < 4; ++k) {
        struct pbnds_envmap *turned = build(&image, PBNDS_ENV_FALCOR, yaws[k], 1.0f);
        const double a = -(double)yaws[k] * TAU / 360.0;
        int differ = 0;
        for (int i = 0; i < 20000; ++i) {
            const struct pbnds_vec3 w = node(i, 100);
            const struct pbnds_vec3 back = {
                (float)(cos(a) * (double)w.x + sin(a) * (double)w.z), w.y,
                (float)(cos(a) * (double)w.z - sin(a) * (double)w.x)};
            const struct pbnds_vec3 x = pbnds_envmap_eval(still, back);
            const struct pbnds_vec3 y = pbnds_envmap_eval(turned, w);
            differ += memcmp(&x, &y, sizeof x) != 0;
        }
        assert_true(differ < 10); /* rounding at a texel's edge */
        pbnds_envmap_free(turned);
    }
    pbnds_envmap_free(still);
    pbnds_image_free(&image);
}

static void names_of_conventions_round_trip(void **state)
{
    (void)state;
    for (int i = 0; i < 4; ++i) {
        enum pbnds_env_convention found;
        const char *name = pbnds_env_convention_name((enum pbnds_env_convention)i);
        assert_true(pbnds_env_convention_parse(name, &found));
        assert_int_equal((int)found, i);
    }
    enum pbnds_env_convention c = PBNDS_ENV_PBNDS;
    assert_false(pbnds_env_convention_parse("GLTF", &c));
    assert_false(pbnds_env_convention_parse("", &c));
    assert_int_equal((int)c, PBNDS_ENV_PBNDS);
}

/* ----------------------------------------------------------------- sampling */

static void pdf_integrates_to_one(void **state)
{
    (void)state;
    struct pbnds_image image = sky(24, 11);
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_OPENEXR, 33.0f, 2.0f);
    enum { N = 1200 };
    double sum = 0.0;
    for (int i = 0; i < 2 * N * N; ++i)
        sum += (double)pbnds_envmap_pdf(map, node(i, N)) * 2.0 * TAU / (2.0 * N * N);
    assert_near(sum, 1.0, 2e-3);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

/* Pearson's statistic over the texels themselves, bins of small expectation pooled. */
static void samples_follow_the_pdf(void **state)
{
    (void)state;
    enum { W = 32, H = 17, N = 400000 };
    struct pbnds_image image = sky(W, H);
    put(&image, W / 3, H / 4, 40.0f, 40.0f, 40.0f);
    put(&image, W / 3 + 1, H / 4, 40.0f, 40.0f, 40.0f);
    put(&image, 5, 0, 60.0f, 60.0f, 60.0f); /* at the pole */
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    static int hits[W * H];
    memset(hits, 0, sizeof hits);
    struct pbnds_rng rng = pbnds_rng_make(1, 2, 3);
    for (int i = 0; i < N; ++i) {
        const float u1 = pbnds_rng_float(&rng), u2 = pbnds_rng_float(&rng);
        const struct pbnds_env_sample s = pbnds_envmap_sample(map, u1, u2);
        const double phi = atan2((double)s.wi.z, (double)s.wi.x);
        const double theta = acos((double)s.wi.y);
        const int x = (int)((0.5 + phi / TAU) * W), y = (int)(2.0 * theta / TAU * H);
        ++hits[(y < H ? y : H - 1) * W + (x < W ? x : W - 1)];
    }
    double chi2 = 0.0, pooled_hits = 0.0, pooled = 0.0;
    int bins = 0;
    for (int i = 0; i < W * H; ++i) {
        const int x = i % W, y = i / W;
        const double theta = 0.5 * TAU * (y + 0.5) / H;
        const double solid_angle =
            TAU / W * (cos(0.5 * TAU * y / H) - cos(0.5 * TAU * (y + 1) / H));
        const struct pbnds_vec3 w = at_angles(theta, TAU * ((x + 0.5) / W - 0.5));
        const double expected = N * solid_angle * (double)pbnds_envmap_pdf(map, w);
        if (expected < 10.0) {
            pooled += expected;
            pooled_hits += hits[i];
            continue;
        }
        chi2 += (hits[i] - expected) * (hits[i] - expected) / expected;
        ++bins;
    }
    if (pooled > 10.0) chi2 += (pooled_hits - pooled) * (pooled_hits - pooled) / pooled;
    /* mean bins, variance 2 bins: five sigma */
    assert_true(bins > 300);
    assert_near(chi2, bins, 5.0 * sqrt(2.0 * bins));
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

/* Within a texel the density is constant, so cos(theta) and phi must be uniform there.
 */
static void samples_fill_their_texel_evenly(void **state)
{
    (void)state;
    struct pbnds_image image = blank(4, 2);
    put(&image, 1, 0, 1.0f, 1.0f, 1.0f);
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    enum { N = 64 };
    double cos_sum = 0.0, phi_sum = 0.0;
    for (int i = 0; i < N * N; ++i) {
        const struct pbnds_env_sample s = pbnds_envmap_sample(
            map, ((float)(i / N) + 0.5f) / N, ((float)(i % N) + 0.5f) / N);
        cos_sum += (double)s.wi.y / (N * N);
        phi_sum += atan2((double)s.wi.z, (double)s.wi.x) / (N * N);
        assert_near((double)s.pdf, 4.0 / TAU, 1e-6); /* 1 / (quarter of a hemisphere) */
    }
    assert_near(cos_sum, 0.5, 1e-5);
    assert_near(phi_sum, -0.125 * TAU, 1e-5);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

static void sample_eval_and_pdf_agree_exactly(void **state)
{
    (void)state;
    static const int sizes[][2] = {{1, 1}, {2, 1}, {64, 32}, {1000, 501}, {9000, 9}};
    for (int k = 0; k < 5; ++k) {
        struct pbnds_image image = blank(sizes[k][0], sizes[k][1]);
        struct pbnds_rng rng = pbnds_rng_make(3, (uint64_t)k, 0);
        for (int i = 0; i < sizes[k][0] * sizes[k][1]; ++i)
            put(&image, i % sizes[k][0], i / sizes[k][0], pbnds_rng_float(&rng),
                pbnds_rng_float(&rng), pbnds_rng_float(&rng));
        struct pbnds_envmap *map = build(&image, PBNDS_ENV_PBNDS, 77.7f, 0.5f);
        for (int i = 0; i < 100000; ++i) {
            float u1 = pbnds_rng_float(&rng), u2 = pbnds_rng_float(&rng);
            if (i % 8 == 0) u1 = 0.0f;
            if (i % 8 == 1) u2 = 0.0f;
            if (i % 8 == 2) u1 = 1.0f - 0x1p-24f;
            if (i % 8 == 3) u2 = 1.0f;
            const struct pbnds_env_sample s = pbnds_envmap_sample(map, u1, u2);
            assert_same(s.radiance, pbnds_envmap_eval(map, s.wi), 0.0);
            assert_near((double)s.pdf, (double)pbnds_envmap_pdf(map, s.wi), 0.0);
            assert_true(s.pdf > 0.0f);
            assert_near((double)pbnds_length(s.wi), 1.0, 5e-7);
        }
        pbnds_envmap_free(map);
        pbnds_image_free(&image);
    }
}

static void sampled_irradiance_equals_quadrature(void **state)
{
    (void)state;
    struct pbnds_image image = sky(48, 24);
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    const struct pbnds_vec3 n = pbnds_normalize(pbnds_vec3_make(0.3f, 0.8f, -0.5f));
    double power[3], expected[3], sum[3] = {0.0, 0.0, 0.0};
    integrate(&image, n, 8, power, expected);
    enum { N = 400 };
    for (int i = 0; i < N * N; ++i) {
        const struct pbnds_env_sample s = pbnds_envmap_sample(
            map, ((float)(i / N) + 0.5f) / N, ((float)(i % N) + 0.5f) / N);
        const double f =
            fmax((double)pbnds_dot(n, s.wi), 0.0) / (double)s.pdf / (N * N);
        sum[0] += f * (double)s.radiance.x;
        sum[1] += f * (double)s.radiance.y;
        sum[2] += f * (double)s.radiance.z;
    }
    for (int k = 0; k < 3; ++k)
        assert_near(sum[k], expected[k], 2e-3 * expected[k]);
    const struct pbnds_vec3 mean = pbnds_envmap_mean(map);
    assert_near((double)mean.x, power[0] / (2.0 * TAU), 1e-5 * (double)mean.x);
    assert_near((double)mean.z, power[2] / (2.0 * TAU), 1e-5 * (double)mean.z);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

static void a_black_map_gives_nothing(void **state)
{
    (void)state;
    struct pbnds_image image = blank(16, 8);
    for (int k = 0; k < 2; ++k) { /* black by its texels, then by its strength */
        if (k == 1) put(&image, 3, 3, 1.0f, 1.0f, 1.0f);
        struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 0.0f, k ? 0.0f : 1.0f);
        const struct pbnds_env_sample s = pbnds_envmap_sample(map, 0.3f, 0.7f);
        assert_near((double)s.pdf, 0.0, 0.0);
        assert_same(s.radiance, pbnds_splat(0.0f), 0.0);
        assert_near((double)pbnds_length(s.wi), 1.0, 1e-6);
        struct pbnds_env_light lights[4];
        assert_int_equal(pbnds_envmap_cluster(map, 4, lights), 0);
        assert_same(pbnds_envmap_eval_cone(map, s.wi, 1.0f), pbnds_splat(0.0f), 0.0);
        pbnds_envmap_free(map);
    }
    pbnds_image_free(&image);
}

/* --------------------------------------------------------------- bad input */

static void bad_input_is_refused_or_cleaned(void **state)
{
    (void)state;
    struct pbnds_envmap *map;
    struct pbnds_error error;
    struct pbnds_image image;
    assert_int_equal(pbnds_image_init(&image, 4, 2, 4, NULL), PBNDS_OK);
    assert_int_equal(
        pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &map, &error),
        PBNDS_ERROR_ARGUMENT);
    assert_null(map);
    pbnds_image_free(&image);
    assert_int_equal(
        pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &map, &error),
        PBNDS_ERROR_ARGUMENT); /* empty */
    image = blank(4, 2);
    static const float bad[][2] = {
        {NAN, 1}, {INFINITY, 1}, {0, NAN}, {0, -1}, {0, INFINITY}};
    for (int i = 0; i < 5; ++i)
        assert_int_equal(pbnds_envmap_create(&image, PBNDS_ENV_GLTF, bad[i][0],
                                             bad[i][1], &map, &error),
                         PBNDS_ERROR_ARGUMENT);
    assert_int_equal(pbnds_envmap_create(&image, (enum pbnds_env_convention)9, 0.0f,
                                         1.0f, &map, &error),
                     PBNDS_ERROR_ARGUMENT);
    put(&image, 0, 0, NAN, -1.0f, 2.0f);
    put(&image, 1, 0, INFINITY, 1.0f, 1.0f);
    map = build(&image, PBNDS_ENV_GLTF, 0.0f, 1e30f);
    double total = 0.0;
    for (int i = 0; i < 5000; ++i) {
        const struct pbnds_vec3 w = node(i, 50), l = pbnds_envmap_eval(map, w);
        assert_true(isfinite(l.x) && isfinite(l.y) && isfinite(l.z));
        assert_true(l.x >= 0.0f && l.y >= 0.0f && l.z >= 0.0f);
        total += (double)pbnds_envmap_pdf(map, w) * 2.0 * TAU / 5000.0;
    }
    assert_near(total, 1.0, 1e-2);
    /* directions that are none must not read outside */
    static const float odd[] = {0.0f, NAN, INFINITY, -INFINITY, -0.0f};
    for (int i = 0; i < 125; ++i) {
        const struct pbnds_vec3 w = {odd[i % 5], odd[i / 5 % 5], odd[i / 25]};
        assert_true(isfinite(pbnds_envmap_eval(map, w).x));
        assert_true(isfinite(pbnds_envmap_eval_cone(map, w, odd[i % 4]).x));
    }
    (void)pbnds_envmap_sample(map, NAN, 2.0f);
    (void)pbnds_envmap_sample(map, -1.0f, NAN);
    pbnds_envmap_free(map);
    pbnds_envmap_free(NULL);
    pbnds_image_free(&image);
}

static void a_missing_file_is_an_io_error_that_names_it(void **state)
{
    (void)state;
    struct pbnds_envmap *map;
    struct pbnds_error error;
    assert_int_equal(pbnds_envmap_load("no/such/light.hdr", PBNDS_ENV_GLTF, 0.0f, 1.0f,
                                       &map, &error),
                     PBNDS_ERROR_IO);
    assert_null(map);
    assert_non_null(strstr(error.message, "no/such/light.hdr"));
}

/* -------------------------------------------------------------------- cones */

/* Cosine-free mean over the cone of solid angle omega about w, by quadrature. */
static struct pbnds_vec3 cone_mean(const struct pbnds_envmap *map, struct pbnds_vec3 w,
                                   double omega)
{
    enum { N = 48 };
    const struct pbnds_frame frame = pbnds_frame_from_normal(w);
    double sum[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < N * N; ++i) {
        const double c = 1.0 - omega / TAU * (i / N + 0.5) / N;
        const double s = sqrt(fmax(1.0 - c * c, 0.0));
        const double phi = TAU * (i % N + 0.5) / N;
        const struct pbnds_vec3 local = {(float)(s * cos(phi)), (float)(s * sin(phi)),
                                         (float)c};
        const struct pbnds_vec3 l =
            pbnds_envmap_eval(map, pbnds_to_world(&frame, local));
        sum[0] += (double)l.x / (N * N);
        sum[1] += (double)l.y / (N * N);
        sum[2] += (double)l.z / (N * N);
    }
    return pbnds_vec3_make((float)sum[0], (float)sum[1], (float)sum[2]);
}

static void a_cone_is_linear_in_the_map(void **state)
{
    (void)state;
    struct pbnds_image a = sky(100, 51), b = blank(100, 51), both = blank(100, 51);
    for (int i = 0; i < 100 * 51 * 3; ++i) {
        b.data[i] = 3.0f * (float)(i % 7);
        both.data[i] = a.data[i] + b.data[i];
    }
    struct pbnds_envmap *map_a = build(&a, PBNDS_ENV_GLTF, 10.0f, 1.0f);
    struct pbnds_envmap *map_b = build(&b, PBNDS_ENV_GLTF, 10.0f, 1.0f);
    struct pbnds_envmap *map = build(&both, PBNDS_ENV_GLTF, 10.0f, 1.0f);
    for (int i = 0; i < 2000; ++i) {
        const struct pbnds_vec3 w = node(i * 37 % 5000, 50);
        const float omega = powf(10.0f, -5.0f + 6.2f * (float)i / 2000.0f);
        const struct pbnds_vec3 sum =
            pbnds_add(pbnds_envmap_eval_cone(map_a, w, omega),
                      pbnds_envmap_eval_cone(map_b, w, omega));
        const struct pbnds_vec3 c = pbnds_envmap_eval_cone(map, w, omega);
        assert_same(c, sum, 1e-5 * (1.0 + (double)pbnds_max3(sum)));
    }
    pbnds_envmap_free(map_a);
    pbnds_envmap_free(map_b);
    pbnds_envmap_free(map);
    pbnds_image_free(&a);
    pbnds_image_free(&b);
    pbnds_image_free(&both);
}

static void a_cone_of_all_directions_is_the_mean(void **state)
{
    (void)state;
    static const int sizes[][2] = {{64, 32}, {100, 51}, {7, 3}, {3, 9}, {1, 1}};
    for (int k = 0; k < 5; ++k) {
        struct pbnds_image image = sky(sizes[k][0], sizes[k][1]);
        struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 10.0f, 1.0f);
        const struct pbnds_vec3 mean = pbnds_envmap_mean(map);
        const double tol = 1e-5 * (double)pbnds_max3(mean);
        for (int i = 0; i < 50; ++i)
            assert_same(pbnds_envmap_eval_cone(map, node(i, 5), 2.0f * (float)TAU),
                        mean, tol);
        pbnds_envmap_free(map);
        pbnds_image_free(&image);
    }
}

/* A constant map, any cone; and a cone wider than the seam sees both of its sides. */
static void cones_are_normalised_and_cross_the_seam(void **state)
{
    (void)state;
    struct pbnds_image image = blank(60, 31);
    for (int i = 0; i < 60 * 31 * 3; ++i)
        image.data[i] = 2.5f;
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 0.0f, 2.0f);
    for (int i = 0; i < 5000; ++i)
        assert_same(
            pbnds_envmap_eval_cone(map, node(i, 50), 1e-5f * powf(1.003f, (float)i)),
            pbnds_splat(5.0f), 1e-5);
    pbnds_envmap_free(map);
    memset(image.data, 0, 60 * 31 * 3 * sizeof *image.data);
    put(&image, 0, 15, 1.0f, 0.0f, 0.0f);
    put(&image, 59, 15, 0.0f, 1.0f, 0.0f);
    map = build(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    const struct pbnds_vec3 l =
        pbnds_envmap_eval_cone(map, pbnds_vec3_make(-1.0f, 0.0f, 0.0f), 0.05f);
    assert_true(l.x > 0.0f);
    assert_near((double)l.x, (double)l.y, 1e-6);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

static void cones_are_close_to_quadrature(void **state)
{
    (void)state;
    enum { W = 256, H = 128 };
    struct pbnds_image image = blank(W, H); /* smooth, with a warm bright side */
    for (int y = 0; y < H; ++y)
        for (int x = 0; x < W; ++x) {
            const struct pbnds_vec3 w =
                at_angles(0.5 * TAU * (y + 0.5) / H, TAU * ((x + 0.5) / W - 0.5));
            const float side = 0.6f * w.x + 0.64f * w.y + 0.48f * w.z;
            put(&image, x, y, expf(4.0f * side), 1.0f + 0.9f * w.z, 1.0f + 0.9f * w.y);
        }
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    static const float omegas[] = {0.001f, 0.01f, 0.1f, 0.5f, 2.0f};
    static const double tolerance[] = {0.003, 0.005, 0.03, 0.09, 0.18};
    for (int k = 0; k < 5; ++k) {
        double error = 0.0, norm = 0.0;
        for (int i = 0; i < 200; ++i) {
            const struct pbnds_vec3 w = node(i, 10);
            const struct pbnds_vec3 c = pbnds_envmap_eval_cone(map, w, omegas[k]);
            const struct pbnds_vec3 e = cone_mean(map, w, (double)omegas[k]);
            const struct pbnds_vec3 d = pbnds_sub(c, e);
            error += (double)pbnds_dot(d, d);
            norm += (double)pbnds_dot(e, e);
        }
        assert_near(sqrt(error / norm), 0.0, tolerance[k]);
    }
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

/* ----------------------------------------------------------------- clusters */

static void cluster_powers_sum_to_the_integral(void **state)
{
    (void)state;
    struct pbnds_image image = sky(120, 59);
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 25.0f, 1.0f);
    static struct pbnds_env_light lights[8192], again[8192];
    double power[3], unused[3];
    integrate(&image, pbnds_splat(0.0f), 1, power, unused);
    static const int counts[] = {1, 2, 3, 16, 64, 1000, 8192};
    for (int k = 0; k < 7; ++k) {
        const int n = pbnds_envmap_cluster(map, counts[k], lights);
        if (counts[k] <= 1000)
            assert_int_equal(n, counts[k]);
        else /* every texel that is not black */
            assert_int_equal(n, 120 * 57);
        double sum[3] = {0.0, 0.0, 0.0};
        for (int i = 0; i < n; ++i) {
            sum[0] += (double)lights[i].power.x;
            sum[1] += (double)lights[i].power.y;
            sum[2] += (double)lights[i].power.z;
            assert_near((double)pbnds_length(lights[i].wi), 1.0, 1e-6);
        }
        for (int c = 0; c < 3; ++c)
            assert_near(sum[c], power[c], 1e-6 * power[c]);
        assert_int_equal(pbnds_envmap_cluster(map, counts[k], again), n);
        assert_memory_equal(lights, again, (size_t)n * sizeof *lights);
    }
    assert_int_equal(pbnds_envmap_cluster(map, 0, lights), 0);
    assert_int_equal(pbnds_envmap_cluster(map, -3, lights), 0);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

static void a_lone_sun_is_one_light_in_its_direction(void **state)
{
    (void)state;
    struct pbnds_image image = blank(512, 256);
    put(&image, 100, 60, 300.0f, 200.0f, 100.0f);
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 90.0f, 2.0f);
    struct pbnds_env_light lights[64];
    assert_int_equal(pbnds_envmap_cluster(map, 64, lights), 1);
    const struct pbnds_vec3 before =
        at_angles(0.5 * TAU * 60.5 / 256, TAU * (100.5 / 512 - 0.5));
    /* R_y(90 degrees): (x, y, z) to (z, y, -x) */
    const struct pbnds_vec3 sun = {before.z, before.y, -before.x};
    assert_near(angle_between(lights[0].wi, sun), 0.0, 1e-4);
    const double solid_angle =
        TAU / 512 * (cos(0.5 * TAU * 60 / 256) - cos(0.5 * TAU * 61 / 256));
    assert_near((double)lights[0].power.x, 600.0 * solid_angle,
                1e-6 * solid_angle * 600.0);
    pbnds_envmap_free(map);

    /* in a dim sky the sun still has a light to itself */
    for (int i = 0; i < 512 * 256 * 3; ++i)
        image.data[i] += 1e-3f;
    map = build(&image, PBNDS_ENV_GLTF, 90.0f, 2.0f);
    const int n = pbnds_envmap_cluster(map, 16, lights);
    assert_int_equal(n, 16);
    int suns = 0;
    for (int i = 0; i < n; ++i)
        if (angle_between(lights[i].wi, sun) < 0.03) ++suns;
    assert_int_equal(suns, 1);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

/* Equal energies: a constant map in 2^k lights of about the same power, spread evenly.
 */
static void a_constant_map_is_cut_evenly(void **state)
{
    (void)state;
    struct pbnds_image image = blank(256, 128);
    for (int i = 0; i < 256 * 128 * 3; ++i)
        image.data[i] = 1.0f;
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    struct pbnds_env_light lights[64];
    assert_int_equal(pbnds_envmap_cluster(map, 1, lights), 1);
    assert_near((double)pbnds_length(lights[0].wi), 1.0,
                1e-6); /* mean cancels: centre */
    assert_near((double)lights[0].power.y, 2.0 * TAU, 1e-4);
    assert_int_equal(pbnds_envmap_cluster(map, 64, lights), 64);
    struct pbnds_vec3 sum = pbnds_splat(0.0f);
    for (int i = 0; i < 64; ++i) {
        assert_true(lights[i].power.x > 0.5f * 2.0f * (float)TAU / 64.0f);
        assert_true(lights[i].power.x < 2.0f * 2.0f * (float)TAU / 64.0f);
        sum = pbnds_mad(sum, lights[i].wi, lights[i].power.x);
    }
    assert_near((double)pbnds_length(sum), 0.0, 0.05);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

/* --------------------------------------------------------------------- bake */

static void bake_keeps_energy_and_orientation(void **state)
{
    (void)state;
    struct pbnds_image image = sky(128, 64), baked, again;
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_FALCOR, 41.3f, 3.0f);
    const struct pbnds_vec3 mean = pbnds_envmap_mean(map);
    static const int sizes[][2] = {{128, 64}, {64, 32},  {32, 16},
                                   {50, 23},  {300, 97}, {1, 1}};
    for (int k = 0; k < 6; ++k) {
        assert_int_equal(pbnds_envmap_bake(map, sizes[k][0], sizes[k][1], &baked, NULL),
                         PBNDS_OK);
        assert_int_equal(baked.channels, 3);
        struct pbnds_envmap *second = build(&baked, PBNDS_ENV_GLTF, 0.0f, 1.0f);
        assert_same(pbnds_envmap_mean(second), mean, 1e-5 * (double)pbnds_max3(mean));
        pbnds_envmap_free(second);
        pbnds_image_free(&baked);
    }
    pbnds_envmap_free(map);
    /* turns by whole texels and same size: exactly the map */
    map = build(&image, PBNDS_ENV_PBNDS, 45.0f, 1.0f);
    assert_int_equal(pbnds_envmap_bake(map, 128, 64, &baked, NULL), PBNDS_OK);
    struct pbnds_envmap *second = build(&baked, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 128; ++x) {
            const struct pbnds_vec3 w =
                at_angles(0.5 * TAU * (y + 0.4) / 64, TAU * (x + 0.6) / 128);
            assert_same(pbnds_envmap_eval(map, w), pbnds_envmap_eval(second, w), 0.0);
        }
    /* baking what is baked changes nothing */
    assert_int_equal(pbnds_envmap_bake(second, 128, 64, &again, NULL), PBNDS_OK);
    assert_memory_equal(again.data, baked.data, 128 * 64 * 3 * sizeof(float));
    pbnds_image_free(&again);
    pbnds_image_free(&baked);
    pbnds_envmap_free(second);
    struct pbnds_error error;
    assert_int_equal(pbnds_envmap_bake(map, 0, 64, &baked, &error),
                     PBNDS_ERROR_ARGUMENT);
    pbnds_envmap_free(map);
    pbnds_image_free(&image);
}

/* A smooth map turned by a fraction of a texel and halved is still the same light. */
static void bake_of_a_smooth_map_is_close_to_it(void **state)
{
    (void)state;
    enum { W = 256, H = 128 };
    struct pbnds_image image = blank(W, H), baked;
    for (int y = 0; y < H; ++y)
        for (int x = 0; x < W; ++x) {
            const struct pbnds_vec3 w =
                at_angles(0.5 * TAU * (y + 0.5) / H, TAU * ((x + 0.5) / W - 0.5));
            put(&image, x, y, expf(w.x), expf(w.y), expf(w.z));
        }
    struct pbnds_envmap *map = build(&image, PBNDS_ENV_OPENEXR, -17.77f, 1.0f);
    assert_int_equal(pbnds_envmap_bake(map, W / 2, H / 2, &baked, NULL), PBNDS_OK);
    struct pbnds_envmap *second = build(&baked, PBNDS_ENV_GLTF, 0.0f, 1.0f);
    for (int i = 0; i < 20000; ++i)
        assert_same(pbnds_envmap_eval(second, node(i, 100)),
                    pbnds_envmap_eval(map, node(i, 100)), 0.12);
    pbnds_envmap_free(second);
    pbnds_envmap_free(map);
    pbnds_image_free(&baked);
    pbnds_image_free(&image);
}

/* ------------------------------------------------------------ a real picture */

static void a_real_map_is_lit_alike_by_its_clusters(void **state)
{
    (void)state;
    const char *path = PBNDS_SHARED_DATA "/hdri/brown_photostudio_02.hdr";
    if (access(path, R_OK) != 0) skip();
    struct pbnds_envmap *map;
    struct pbnds_error error;
    if (pbnds_envmap_load(path, PBNDS_ENV_GLTF, 0.0f, 1.0f, &map, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    struct pbnds_image image;
    assert_int_equal(pbnds_envmap_bake(map, 128, 64, &image, &error), PBNDS_OK);
    static struct pbnds_env_light lights[64];
    assert_int_equal(pbnds_envmap_cluster(map, 64, lights), 64);
    for (int i = 0; i < 50; ++i) {
        const struct pbnds_vec3 n = node(i, 5);
        double power[3], exact[3], sum = 0.0;
        integrate(&image, n, 1, power, exact);
        for (int k = 0; k < 64; ++k)
            sum +=
                (double)(lights[k].power.y * fmaxf(pbnds_dot(n, lights[k].wi), 0.0f));
        assert_near(sum, exact[1], 0.03 * exact[1] + 0.005 * power[1]);
    }
    pbnds_image_free(&image);
    pbnds_envmap_free(map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_texel_is_seen_where_its_convention_says),
        cmocka_unit_test(the_default_convention_is_that_of_gltf),
        cmocka_unit_test(yaw_turns_the_light_about_y),
        cmocka_unit_test(names_of_conventions_round_trip),
        cmocka_unit_test(pdf_integrates_to_one),
        cmocka_unit_test(samples_follow_the_pdf),
        cmocka_unit_test(samples_fill_their_texel_evenly),
        cmocka_unit_test(sample_eval_and_pdf_agree_exactly),
        cmocka_unit_test(sampled_irradiance_equals_quadrature),
        cmocka_unit_test(a_black_map_gives_nothing),
        cmocka_unit_test(bad_input_is_refused_or_cleaned),
        cmocka_unit_test(a_missing_file_is_an_io_error_that_names_it),
        cmocka_unit_test(a_cone_is_linear_in_the_map),
        cmocka_unit_test(a_cone_of_all_directions_is_the_mean),
        cmocka_unit_test(cones_are_normalised_and_cross_the_seam),
        cmocka_unit_test(cones_are_close_to_quadrature),
        cmocka_unit_test(cluster_powers_sum_to_the_integral),
        cmocka_unit_test(a_lone_sun_is_one_light_in_its_direction),
        cmocka_unit_test(a_constant_map_is_cut_evenly),
        cmocka_unit_test(bake_keeps_energy_and_orientation),
        cmocka_unit_test(bake_of_a_smooth_map_is_close_to_it),
        cmocka_unit_test(a_real_map_is_lit_alike_by_its_clusters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
