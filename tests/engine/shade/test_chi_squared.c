/* The chi-squared test itself: known values, a right sampler, and slightly wrong ones. */
#include "tests/engine/shade/chi_squared.h"

/* Tables of the chi-squared distribution: the 0.05 and 0.01 quantiles. */
static void tails_have_their_tabulated_values(void **state)
{
    (void)state;
    const double cases[][3] = {{3.841459, 1.0, 0.05},       {6.634897, 1.0, 0.01},
                               {18.307038, 10.0, 0.05},     {124.342113, 100.0, 0.05},
                               {1074.679449, 1000.0, 0.05}, {1106.969, 1000.0, 0.01},
                               {0.5, 2.0, 0.7788008}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        assert_near(chi_tail(cases[i][0], cases[i][1]), cases[i][2],
                    2e-7 + 1e-4 * cases[i][2]);
    assert_near(chi_tail(0.0, 5.0), 1.0, 0.0);
    assert_near(chi_tail(1e5, 5.0), 0.0, 1e-300);
    assert_near(chi_tail(5000.0, 5000.0), 0.4973, 5e-4);
    assert_near(chi_threshold(1), 0.01, 1e-15);
    assert_near(pow(1.0 - chi_threshold(7), 7.0), 0.99, 1e-12);
}

/* A density cos^m / norm about +z, drawn with an exponent that may differ. */
struct lobe {
    double states, draws;
};

static double pdf(const void *self, struct pbnds_vec3 w)
{
    const struct lobe *l = self;
    if (w.z <= 0.0f) return 0.0;
    return (l->states + 1.0) / (2.0 * chi_pi()) * pow((double)w.z, l->states);
}

static bool sample(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w)
{
    const struct lobe *l = self;
    const double u = (double)pbnds_rng_float(rng), v = (double)pbnds_rng_float(rng);
    const double z = pow(1.0 - u, 1.0 / (l->draws + 1.0)), s = sqrt(1.0 - z * z);
    *w = pbnds_vec3_make((float)(s * cos(2.0 * chi_pi() * v)),
                         (float)(s * sin(2.0 * chi_pi() * v)), (float)z);
    return true;
}

static struct chi_sampler of(const struct lobe *lobe)
{
    return (struct chi_sampler){
        .self = lobe, .pdf = pdf, .sample = sample, .pole = {0.0f, 0.0f, 1.0f}};
}

static void a_right_sampler_passes(void **state)
{
    (void)state;
    const struct lobe cosine = {1.0, 1.0}, narrow = {1000.0, 1000.0};
    struct chi_sampler s = of(&cosine);
    assert_chi_squared(&s, 1, 4, "cosine");
    s.power = 2.0;
    assert_chi_squared(&s, 2, 4, "cosine in uneven bins");
    /* the horizon cuts through the bins */
    s.pole = pbnds_normalize(pbnds_vec3_make(0.5f, -0.7f, 0.3f));
    s.power = 1.0;
    assert_chi_squared(&s, 3, 4, "cosine in tilted bins");
    s = of(&narrow);
    s.power = 3.0;
    assert_chi_squared(&s, 4, 4, "a narrow lobe");
}

static void wrong_samplers_fail(void **state)
{
    (void)state;
    const struct lobe wide = {1.0, 0.95}, flat = {1.0, 0.0}, narrow = {1000.0, 950.0};
    struct chi_sampler s = of(&wide);
    assert_true(chi_probability(&s, 1) < 1e-3);
    s = of(&flat);
    assert_true(chi_probability(&s, 1) < 1e-12);
    s = of(&narrow);
    s.power = 3.0;
    assert_true(chi_probability(&s, 1) < 1e-3);
}

/* A density twice, or 0.97 of, what it should be. */
static double doubled(const void *self, struct pbnds_vec3 w)
{
    return 2.0 * pdf(self, w);
}

static double thinned(const void *self, struct pbnds_vec3 w)
{
    return 0.97 * pdf(self, w);
}

/* Directions below the horizon, where the density is zero: one in a thousand. */
static bool leaks(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w)
{
    (void)sample(self, rng, w);
    if (pbnds_rng_float(rng) < 1e-3f) w->z = -w->z;
    return true;
}

/* Turns down three in a hundred, which is what `thinned` says. */
static bool picky(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w)
{
    (void)sample(self, rng, w);
    return pbnds_rng_float(rng) >= 0.03f;
}

static void lost_and_misplaced_samples_are_seen(void **state)
{
    (void)state;
    const struct lobe cosine = {1.0, 1.0};
    struct chi_sampler s = of(&cosine);
    s.pdf = doubled;
    assert_near(chi_probability(&s, 1), 0.0, 0.0);
    s.pdf = thinned;
    assert_true(chi_probability(&s, 1) < 1e-12);
    s.sample = picky;
    assert_chi_squared(&s, 5, 1, "a sampler that turns some down");
    s.pdf = pdf;
    assert_true(chi_probability(&s, 1) < 1e-12);
    s.sample = leaks;
    assert_near(chi_probability(&s, 1), 0.0, 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tails_have_their_tabulated_values),
        cmocka_unit_test(a_right_sampler_passes),
        cmocka_unit_test(wrong_samplers_fail),
        cmocka_unit_test(lost_and_misplaced_samples_are_seen),
    };
    return cmocka_run_group_tests_name("engine/shade/chi_squared", tests, NULL, NULL);
}
