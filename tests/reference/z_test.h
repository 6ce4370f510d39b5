/* The per-pixel Z-test of Mitsuba's render tests (Subr and Arvo 2007, "Statistical
 * Hypothesis Testing for Assessing Monte Carlo Estimators"): of two estimates of each
 * value of a picture, with the variances of both, how many agree?
 *
 *     z = (a - b) / sqrt(var a + var b),  p = erfc(|z| / sqrt 2)
 *
 * A value agrees where p is above 1 - (1 - 0.01)^(1/n): the level 0.01 of the whole
 * picture, shared by n values (Sidak 1967). The picture is accepted where 99.75 % agree. */
#ifndef PBNDS_TESTS_REFERENCE_Z_TEST_H
#define PBNDS_TESTS_REFERENCE_Z_TEST_H

#include <math.h>
#include <stddef.h>

#define Z_TEST_LEVEL  0.01
#define Z_TEST_ACCEPT 0.9975

struct z_test {
    size_t count, agreeing;
    double greatest; /* |z| */
    double sum_difference, sum_variance;
    double sum, sum_error; /* for the mean relative standard error */
};

static inline void z_test_add(struct z_test *test, size_t values, double a,
                              double var_a, double b, double var_b)
{
    const double variance = var_a + var_b, difference = a - b;
    /* two exact zeros agree; so do values that round-off alone parts */
    const double floor = 1e-6 * fabs(b);
    const double z = difference / sqrt(variance + floor * floor + 1e-30);
    const double level = 1 - pow(1 - Z_TEST_LEVEL, 1.0 / (double)values);
    ++test->count;
    test->agreeing += erfc(fabs(z) / sqrt(2.0)) > level;
    test->greatest = fmax(test->greatest, fabs(z));
    test->sum_difference += difference;
    test->sum_variance += variance;
    test->sum += b;
    test->sum_error += sqrt(variance);
}

static inline double z_test_share(const struct z_test *test)
{
    return (double)test->agreeing / (double)test->count;
}

/* z of the sum of all values, and its p: one more test, of the whole. */
static inline double z_test_whole(const struct z_test *test)
{
    return test->sum_difference / sqrt(test->sum_variance + 1e-30);
}
#endif
