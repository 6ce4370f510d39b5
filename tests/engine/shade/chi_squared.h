/* Do the directions of a sampler follow the density that it states? Pearson's chi-squared
 * test with the parameters of pbrt-v4's tests (Pharr, Jakob and Humphreys 2023): 10^6
 * samples in 80 x 160 bins of (theta, phi), a significance of 0.01 shared by the runs of a
 * test after Sidak, cells of less than five expected samples pooled. The density is
 * integrated over each bin by adaptive quadrature. What the sampler turns down is a cell
 * of its own, which must hold what the density leaves of 1.
 *
 * With one seed a run always ends the same: a test that passes once passes always. */
#ifndef PBNDS_TESTS_ENGINE_SHADE_CHI_SQUARED_H
#define PBNDS_TESTS_ENGINE_SHADE_CHI_SQUARED_H

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "engine/core/vec.h"
#include "tests/test.h"

enum { CHI_THETA = 80, CHI_PHI = 160, CHI_BINS = CHI_THETA * CHI_PHI };
enum { CHI_SAMPLES = 1000000, CHI_POOL = 5, CHI_DEPTH = 5, CHI_FORCED = 4 };
#define CHI_SIGNIFICANCE 0.01

struct chi_sampler {
    const void *self;
    double (*pdf)(const void *self, struct pbnds_vec3 w); /* 1/sr */
    /* false: the sample is turned down */
    bool (*sample)(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w);
    struct pbnds_vec3 pole; /* unit: theta = 0 */
    /* theta = pi t^power, t = i / 80: 1 as pbrt has it; more makes the bins finer around
     * the pole, for narrow lobes. 0 means 1. */
    double power;
    bool
        edges; /* the density ends within bins, as that of a lamp: look closely there */
};

struct chi_cell {
    double expected, observed;
};

struct chi_grid {
    const struct chi_sampler *sampler;
    struct pbnds_frame frame;
    double power;
};

static inline double chi_pi(void)
{
    return 3.14159265358979323846;
}

/* Upper tail of the gamma distribution, Q(a, x): the series of P below a + 1, Lentz's
 * continued fraction above (Abramowitz and Stegun 6.5.29 and 6.5.31). */
static inline double chi_gamma_q(double a, double x)
{
    if (!(x > 0.0)) return 1.0;
    const double scale = exp(a * log(x) - x - lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (double n = a + 1.0; term > 1e-16 * sum; n += 1.0) {
            term *= x / n;
            sum += term;
        }
        return 1.0 - scale * sum;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d;
    for (int i = 1; i < 100000; ++i) {
        const double n = -i * (i - a);
        b += 2.0;
        d = 1.0 / (n * d + b);
        c = b + n / c;
        h *= d * c;
        if (fabs(d * c - 1.0) < 1e-14) break;
    }
    return scale * h;
}

/* Probability that chi-squared of so many degrees is larger. */
static inline double chi_tail(double chi, double degrees)
{
    return chi_gamma_q(degrees / 2.0, chi / 2.0);
}

static inline double chi_density(const struct chi_grid *g, double theta, double phi)
{
    const double s = sin(theta);
    const struct pbnds_vec3 w = {(float)(s * cos(phi)), (float)(s * sin(phi)),
                                 (float)cos(theta)};
    return g->sampler->pdf(g->sampler->self, pbnds_to_world(&g->frame, w)) * s;
}

/* Gauss-Legendre, 3 x 3. */
static inline double chi_cell_rule(const struct chi_grid *g, const double *t,
                                   const double *p)
{
    static const double x[3] = {-0.7745966692414834, 0.0, 0.7745966692414834};
    static const double w[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    const double dt = t[1] - t[0], dp = p[1] - p[0];
    double sum = 0.0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            sum += w[i] * w[j] *
                   chi_density(g, t[0] + dt * 0.5 * (1.0 + x[i]),
                               p[0] + dp * 0.5 * (1.0 + x[j]));
    return sum * dt * dp;
}

/* Halves the cell both ways until halving changes little, `forced` times in any case. */
static inline double chi_integral(const struct chi_grid *g, const double *t,
                                  const double *p, double whole, int depth, int forced)
{
    const double tm = 0.5 * (t[0] + t[1]), pm = 0.5 * (p[0] + p[1]);
    const double ts[3] = {t[0], tm, t[1]}, ps[3] = {p[0], pm, p[1]};
    double part[4], sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        part[i] = chi_cell_rule(g, ts + i / 2, ps + i % 2);
        sum += part[i];
    }
    const bool settled = forced <= 0 && fabs(sum - whole) <= 3e-3 * sum + 1e-8;
    if (depth == 0 || settled) return sum;
    sum = 0.0;
    for (int i = 0; i < 4; ++i)
        sum += chi_integral(g, ts + i / 2, ps + i % 2, part[i], depth - 1, forced - 1);
    return sum;
}

static inline double chi_edge(const struct chi_grid *g, int i)
{
    return chi_pi() * pow((double)i / CHI_THETA, g->power);
}

static inline double chi_mass(const struct chi_grid *g, int i, int j, int forced)
{
    const double t[2] = {chi_edge(g, i), chi_edge(g, i + 1)};
    const double p[2] = {2.0 * chi_pi() * j / CHI_PHI,
                         2.0 * chi_pi() * (j + 1) / CHI_PHI};
    return chi_integral(g, t, p, chi_cell_rule(g, t, p), CHI_DEPTH, forced);
}

/* Has the bin neighbours with and without density, itself counted? */
static inline bool chi_on_edge(const struct chi_cell *cells, int i, int j)
{
    bool empty = false, full = false;
    for (int y = i - 1; y <= i + 1; ++y)
        for (int x = j + CHI_PHI - 1; x <= j + CHI_PHI + 1; ++x) {
            if (y < 0 || y >= CHI_THETA) continue;
            const bool has = cells[y * CHI_PHI + x % CHI_PHI].observed > 0.0;
            full = full || has;
            empty = empty || !has;
        }
    return empty && full;
}

/* Where a density ends within a bin the first nodes may all miss what is there. */
static inline double chi_expect(const struct chi_grid *g, struct chi_cell *cells)
{
    double total = 0.0;
    for (int i = 0; i < CHI_BINS; ++i)
        cells[i].observed = cells[i].expected =
            chi_mass(g, i / CHI_PHI, i % CHI_PHI, 0);
    for (int i = 0; i < CHI_BINS; ++i) {
        if (g->sampler->edges && chi_on_edge(cells, i / CHI_PHI, i % CHI_PHI))
            cells[i].expected = chi_mass(g, i / CHI_PHI, i % CHI_PHI, CHI_FORCED);
        total += cells[i].expected;
    }
    for (int i = 0; i < CHI_BINS; ++i) {
        cells[i].expected *= CHI_SAMPLES;
        cells[i].observed = 0.0;
    }
    return total;
}

static inline int chi_bin(const struct chi_grid *g, struct pbnds_vec3 w)
{
    const struct pbnds_vec3 l = pbnds_to_local(&g->frame, w);
    const double x = (double)l.x, y = (double)l.y;
    const double theta = atan2(sqrt(x * x + y * y), (double)l.z);
    const double turn = atan2(y, x) / (2.0 * chi_pi());
    int i = (int)(pow(theta / chi_pi(), 1.0 / g->power) * CHI_THETA);
    int j = (int)((turn < 0.0 ? turn + 1.0 : turn) * CHI_PHI);
    i = i >= CHI_THETA ? CHI_THETA - 1 : i;
    j = j >= CHI_PHI ? CHI_PHI - 1 : j;
    return i * CHI_PHI + j;
}

static inline int chi_by_expected(const void *a, const void *b)
{
    const double p = ((const struct chi_cell *)a)->expected,
                 q = ((const struct chi_cell *)b)->expected;
    return (p > q) - (p < q);
}

/* Pearson's statistic over the cells, small ones pooled; its tail probability. */
static inline double chi_statistic(struct chi_cell *cells, int count)
{
    struct chi_cell pool = {0.0, 0.0};
    double chi = 0.0, degrees = -1.0; /* the counts sum to the samples */
    qsort(cells, (size_t)count, sizeof *cells, chi_by_expected);
    for (int i = 0; i < count; ++i) {
        const double e = cells[i].expected, o = cells[i].observed;
        /* a region of no density got more than rounding can bring there */
        if (e <= 0.0 && o > 1e-5 * CHI_SAMPLES) return 0.0;
        if (e < CHI_POOL || (pool.expected > 0.0 && pool.expected < CHI_POOL)) {
            pool.expected += e;
            pool.observed += o;
        } else {
            chi += (o - e) * (o - e) / e;
            degrees += 1.0;
        }
    }
    if (pool.expected > 0.0) {
        const double d = pool.observed - pool.expected;
        chi += d * d / pool.expected;
        degrees += 1.0;
    }
    return degrees > 0.0 ? chi_tail(chi, degrees) : 1.0;
}

/* The probability of a deviation this large if the sampler is right. */
static inline double chi_probability(const struct chi_sampler *sampler, uint64_t seed)
{
    static struct chi_cell cells[CHI_BINS + 1];
    const struct chi_grid grid = {sampler, pbnds_frame_from_normal(sampler->pole),
                                  sampler->power > 0.0 ? sampler->power : 1.0};
    memset(cells, 0, sizeof cells);
    const double total = chi_expect(&grid, cells);
    if (!(total < 1.001)) return 0.0; /* more than 1, or not a number */
    cells[CHI_BINS].expected = fmax(1.0 - total, 0.0) * CHI_SAMPLES;
    for (uint64_t i = 0; i < CHI_SAMPLES; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(seed, 0, i);
        struct pbnds_vec3 w;
        const bool kept = sampler->sample(sampler->self, &rng, &w);
        cells[kept ? chi_bin(&grid, w) : CHI_BINS].observed += 1.0;
    }
    return chi_statistic(cells, CHI_BINS + 1);
}

/* Of `runs` right samplers all pass with probability 1 - CHI_SIGNIFICANCE. */
static inline double chi_threshold(int runs)
{
    return 1.0 - pow(1.0 - CHI_SIGNIFICANCE, 1.0 / runs);
}

static inline void assert_chi_squared(const struct chi_sampler *sampler, uint64_t seed,
                                      int runs, const char *what)
{
    const double p = chi_probability(sampler, seed);
    if (!(p >= chi_threshold(runs)))
        fail_msg("%s: samples differ from their density, p = %g", what, p);
}
#endif
