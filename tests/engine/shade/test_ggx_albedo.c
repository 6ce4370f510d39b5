/* engine/shade/ggx_albedo.c against its integral. `--print [N]` prints the table instead:
 * that is engine/shade/ggx_albedo_table.h, before clang-format. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "engine/shade/ggx_albedo.h"
#include "tests/engine/shade/lobe.h"
#include "tests/reference/ggx_albedo.h"

enum { ROWS = PBNDS_GGX_ALBEDO_ROWS, COLUMNS = PBNDS_GGX_ALBEDO_COLUMNS };

static struct pbnds_ggx_albedo entry(int i, int j)
{
    /* the last row is the far end of the last step */
    const struct pbnds_ggx_albedo_row row = {i < ROWS - 1 ? i : ROWS - 2,
                                             i < ROWS - 1 ? 0.0f : 1.0f};
    return pbnds_ggx_albedo(row, (float)naive_column_cosine(j));
}

static void every_entry_is_its_integral(void **state)
{
    (void)state;
    for (int i = 0; i < ROWS; ++i)
        for (int j = 0; j < COLUMNS; ++j) {
            const struct pbnds_ggx_albedo e = entry(i, j);
            /* along the normal all azimuths cut off at the same height: finer */
            const struct naive_albedo n =
                naive_ggx_albedo(naive_column_cosine(j), naive_row_alpha(i),
                                 j == COLUMNS - 1 ? 512 : 128);
            if (!(fabs((double)e.a - n.a) < 2e-4) || !(fabs((double)e.b - n.b) < 2e-4))
                fail_msg("row %d column %d holds %g %g, the integrals are %g %g", i, j,
                         (double)e.a, (double)e.b, n.a, n.b);
        }
}

/* The mean of the interpolant, so that a white furnace closes. */
static void means_are_those_of_the_rows(void **state)
{
    (void)state;
    double total = 0.0;
    for (int j = 0; j < COLUMNS; ++j)
        total += naive_mean_weight(j);
    assert_near(total, 1.0, 1e-12);
    for (int i = 0; i < ROWS; ++i) {
        double a = 0.0, b = 0.0;
        for (int j = 0; j < COLUMNS; ++j) {
            a += (double)entry(i, j).a * naive_mean_weight(j);
            b += (double)entry(i, j).b * naive_mean_weight(j);
        }
        const struct pbnds_ggx_albedo_row row = {i < ROWS - 1 ? i : ROWS - 2,
                                                 i < ROWS - 1 ? 0.0f : 1.0f};
        assert_near(pbnds_ggx_albedo_mean(row).a, a, 5e-6);
        assert_near(pbnds_ggx_albedo_mean(row).b, b, 5e-6);
    }
}

static void between_the_entries_it_is_close(void **state)
{
    (void)state;
    double square = 0.0, most = 0.0;
    enum { N = 300 };
    for (int i = 0; i < N; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(11, 0, (uint64_t)i);
        const float u = pbnds_rng_float(&rng), v = pbnds_rng_float(&rng);
        const float mu = i % 3 == 0 ? u : i % 3 == 1 ? u * u : u * u * u;
        const float alpha = fmaxf(i & 1 ? v * v : v * v * v * v, PBNDS_GGX_ALPHA_MIN);
        const struct pbnds_ggx_albedo e =
            pbnds_ggx_albedo(pbnds_ggx_albedo_row(alpha), mu);
        const struct naive_albedo n = naive_ggx_albedo((double)mu, (double)alpha, 256);
        const double plastic = 0.04 * ((double)e.a - n.a) + ((double)e.b - n.b);
        const double white = ((double)e.a - n.a) + ((double)e.b - n.b);
        square += plastic * plastic / N;
        most = fmax(most, fmax(fabs(plastic), fabs(white)));
    }
    assert_true(most < 6e-3);
    assert_true(sqrt(square) < 4e-4);
}

/* Seen along the normal at alpha = 1 a white lobe returns 1 - ln 2 and the Fresnel part
 * next to nothing; and a smooth one is a mirror: A + B = 1, B = (1 - cos)^5. */
static void known_values(void **state)
{
    (void)state;
    const struct pbnds_ggx_albedo rough =
        pbnds_ggx_albedo(pbnds_ggx_albedo_row(1.0f), 1.0f);
    assert_near(rough.a + rough.b, 1.0 - log(2.0), 2e-5);
    for (float mu = 0.1f; mu <= 1.0f; mu += 0.09f) {
        const struct pbnds_ggx_albedo smooth =
            pbnds_ggx_albedo(pbnds_ggx_albedo_row(0.0f), mu);
        assert_near(smooth.a + smooth.b, 1.0, 1e-3);
        assert_near(smooth.b, pow(1.0 - (double)mu, 5.0), 2.5e-3);
    }
}

/* The naive integral shares its sampling with the lobe's; here is none: f_r itself over
 * the hemisphere. */
static void the_integral_is_that_of_the_lobe(void **state)
{
    (void)state;
    enum { N = 300 };
    const float alphas[] = {0.3f, 0.6f, 1.0f};
    for (int k = 0; k < 3; ++k)
        for (float mu = 0.1f; mu <= 1.0f; mu += 0.3f) {
            const struct pbnds_ggx a = {pbnds_splat(1.0f), 0.0f, alphas[k]};
            const struct pbnds_vec3 wo = direction(mu, 0.0f);
            double sum = 0.0;
            for (int i = 0; i < N * N; ++i) {
                const float z = ((float)(i / N) + 0.5f) / N;
                const float phi = PBNDS_PI * ((float)(i % N) + 0.5f) / N;
                sum += (double)(pbnds_ggx_eval(&a, wo, direction(z, phi)).x * z);
            }
            assert_near(pbnds_ggx_albedo(pbnds_ggx_albedo_row(alphas[k]), mu).a,
                        sum * 2.0 * acos(-1.0) / (N * N), 2.5e-3);
        }
}

static void wild_arguments_stay_in_the_table(void **state)
{
    (void)state;
    const float wild[] = {-1.0f, 0.0f, 1.0f, 7.0f, INFINITY, NAN};
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) {
            const struct pbnds_ggx_albedo e =
                pbnds_ggx_albedo(pbnds_ggx_albedo_row(wild[i]), wild[j]);
            assert_true(e.a >= 0.0f && e.b >= 0.0f && e.a + e.b <= 1.0001f);
        }
}

static void print_table(int n)
{
    printf("/* Printed by test_ggx_albedo --print; see ggx_albedo.h. */\n"
           "#ifndef PBNDS_ENGINE_SHADE_GGX_ALBEDO_TABLE_H\n"
           "#define PBNDS_ENGINE_SHADE_GGX_ALBEDO_TABLE_H\n\n"
           "#include \"engine/shade/ggx_albedo.h\"\n\n"
           "/* A and B; rows by alpha, columns by cosine. */\n"
           "static const struct pbnds_ggx_albedo\n"
           "    TABLE[PBNDS_GGX_ALBEDO_ROWS][PBNDS_GGX_ALBEDO_COLUMNS] = {\n");
    double mean[ROWS][2];
    memset(mean, 0, sizeof mean);
    for (int i = 0; i < ROWS; ++i) {
        printf("{ /* alpha %.5f */\n", naive_row_alpha(i));
        for (int j = 0; j < COLUMNS; ++j) {
            const struct naive_albedo e =
                naive_ggx_albedo(naive_column_cosine(j), naive_row_alpha(i), n);
            const double a = round(e.a * 1e5) * 1e-5, b = round(e.b * 1e5) * 1e-5;
            mean[i][0] += a * naive_mean_weight(j);
            mean[i][1] += b * naive_mean_weight(j);
            printf("{%.5ff, %.5ff},%s", a, b, j % 4 == 3 ? "\n" : " ");
        }
        printf("},\n");
    }
    printf("};\n\n/* 2 integral of the row's interpolant times the cosine. */\n"
           "static const struct pbnds_ggx_albedo MEAN[PBNDS_GGX_ALBEDO_ROWS] = {\n");
    for (int i = 0; i < ROWS; ++i)
        printf("{%.7ff, %.7ff},%s", mean[i][0], mean[i][1], i % 3 == 2 ? "\n" : " ");
    printf("};\n\n#endif /* PBNDS_ENGINE_SHADE_GGX_ALBEDO_TABLE_H */\n");
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_entry_is_its_integral),
        cmocka_unit_test(means_are_those_of_the_rows),
        cmocka_unit_test(between_the_entries_it_is_close),
        cmocka_unit_test(known_values),
        cmocka_unit_test(the_integral_is_that_of_the_lobe),
        cmocka_unit_test(wild_arguments_stay_in_the_table),
    };
    if (argc > 1 && strcmp(argv[1], "--print") == 0) {
        print_table(argc > 2 ? atoi(argv[2]) : 512);
        return 0;
    }
    return cmocka_run_group_tests_name("engine/shade/ggx_albedo", tests, NULL, NULL);
}
