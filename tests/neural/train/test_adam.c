/* neural/train/adam.c against a twin in double, closed forms and torch.optim. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "neural/train/adam.h"

enum { COUNT = 5, STEPS = 12 };

/* Gradients of the three tests: g[step][i], over nine decades, with exact zeros. */
static void make_grads(float g[STEPS][COUNT])
{
    struct pbnds_rng rng = pbnds_rng_make(1, 2, 3);
    for (int s = 0; s < STEPS; ++s) {
        for (int i = 0; i < COUNT; ++i) {
            const float x = 2.0f * pbnds_rng_float(&rng) - 1.0f;
            g[s][i] = i == 4 && s < 3 ? 0.0f : x * powf(10.0f, (float)(2 * i - 6));
        }
    }
}

static void run_ours(float decay, float lr, float p[COUNT])
{
    float g[STEPS][COUNT];
    struct pbnds_adam adam;
    struct pbnds_error error;
    make_grads(g);
    assert_int_equal(pbnds_adam_init(&adam, COUNT, &error), PBNDS_OK);
    adam.weight_decay = decay;
    for (int i = 0; i < COUNT; ++i)
        p[i] = (float)(i - 2);
    for (int s = 0; s < STEPS; ++s)
        pbnds_adam_step(&adam, lr, g[s], p);
    assert_int_equal(adam.step, STEPS);
    pbnds_adam_free(&adam);
    assert_null(adam.m);
}

/* Algorithm 2 of Loshchilov and Hutter, line by line. */
static void follows_the_paper_in_double(void **state)
{
    (void)state;
    for (int k = 0; k < 2; ++k) {
        const double decay = k * 0.1, lr = 0.05;
        float p[COUNT], g[STEPS][COUNT];
        double q[COUNT], m[COUNT] = {0}, v[COUNT] = {0};
        make_grads(g);
        run_ours((float)decay, (float)lr, p);
        for (int i = 0; i < COUNT; ++i) {
            q[i] = i - 2;
            for (int s = 0; s < STEPS; ++s) {
                const double x = (double)g[s][i];
                m[i] = 0.9 * m[i] + 0.1 * x;
                v[i] = 0.999 * v[i] + 0.001 * x * x;
                const double mh = m[i] / (1.0 - pow(0.9, s + 1));
                const double vh = v[i] / (1.0 - pow(0.999, s + 1));
                q[i] -= lr * decay * q[i] + lr * mh / (sqrt(vh) + 1e-8);
            }
            assert_near((double)p[i], q[i], 2e-6 * (1.0 + fabs(q[i])));
        }
    }
}

/* With bias correction the first step is lr sign(g), whatever the size of g. */
static void first_step_has_length_lr(void **state)
{
    (void)state;
    const float g[3] = {1e-3f, -1e6f, 0.0f};
    float p[3] = {1.0f, 1.0f, 1.0f};
    struct pbnds_adam adam;
    struct pbnds_error error;
    assert_int_equal(pbnds_adam_init(&adam, 3, &error), PBNDS_OK);
    pbnds_adam_step(&adam, 0.25f, g, p);
    assert_near((double)p[0], 0.75, 1e-5);
    assert_near((double)p[1], 1.25, 1e-5);
    assert_near((double)p[2], 1.0, 0.0);
    pbnds_adam_free(&adam);
}

/* Decay alone shrinks parameters by (1 - lr decay) a step: it is decoupled. */
static void decay_is_decoupled(void **state)
{
    (void)state;
    const float g[1] = {0.0f};
    float p[1] = {2.0f};
    struct pbnds_adam adam;
    struct pbnds_error error;
    assert_int_equal(pbnds_adam_init(&adam, 1, &error), PBNDS_OK);
    adam.weight_decay = 0.5f;
    for (int s = 0; s < 10; ++s)
        pbnds_adam_step(&adam, 0.1f, g, p);
    assert_near((double)p[0], 2.0 * pow(0.95, 10), 1e-6);
    pbnds_adam_free(&adam);
}

static void agrees_with_torch(void **state)
{
    (void)state;
    const char *script = "test_adam.py";
    FILE *file = fopen(script, "w");
    float g[STEPS][COUNT];
    make_grads(g);
    assert_non_null(file);
    (void)fputs("import torch\nG=[", file);
    for (int s = 0; s < STEPS; ++s) {
        (void)fputs("[", file);
        for (int i = 0; i < COUNT; ++i)
            (void)fprintf(file, "%.9g,", (double)g[s][i]);
        (void)fputs("],", file);
    }
    (void)fputs(
        "]\nG=torch.tensor(G)\n"
        "for make in (lambda p: torch.optim.Adam(p, lr=0.05),\n"
        "             lambda p: torch.optim.AdamW(p, lr=0.05, weight_decay=0.1)):\n"
        "    p = torch.arange(-2.0, 3.0).requires_grad_()\n"
        "    o = make([p])\n"
        "    for g in G:\n"
        "        p.grad = g.clone()\n"
        "        o.step()\n"
        "    print(*['%.9g' % x for x in p.tolist()])\n",
        file);
    assert_int_equal(fclose(file), 0);
    FILE *torch = popen("/usr/bin/python3 test_adam.py 2>/dev/null", "r");
    assert_non_null(torch);
    double theirs[2 * COUNT];
    int read = 0;
    while (read < 2 * COUNT && fscanf(torch, "%lf", &theirs[read]) == 1)
        ++read;
    (void)pclose(torch);
    (void)remove(script);
    if (read == 0) skip(); /* no torch here */
    assert_int_equal(read, 2 * COUNT);
    for (int k = 0; k < 2; ++k) {
        float p[COUNT];
        run_ours((float)k * 0.1f, 0.05f, p);
        for (int i = 0; i < COUNT; ++i) {
            const double t = theirs[k * COUNT + i];
            assert_near((double)p[i], t, 2e-6 * (1.0 + fabs(t)));
        }
    }
}

static void clipping_keeps_the_direction(void **state)
{
    (void)state;
    float g[2] = {3.0f, -4.0f};
    assert_near(pbnds_clip_norm(g, 2, 10.0), 5.0, 0.0);
    assert_near((double)g[0], 3.0, 0.0);
    assert_near(pbnds_clip_norm(g, 2, 0.0), 5.0, 0.0); /* 0: never clip */
    assert_near((double)g[1], -4.0, 0.0);
    assert_near(pbnds_clip_norm(g, 2, 1.0), 5.0, 0.0);
    assert_near((double)g[0], 0.6, 1e-7);
    assert_near((double)g[1], -0.8, 1e-7);
    float large[2] = {3e30f, 4e30f}; /* squares overflow float */
    assert_near(pbnds_clip_norm(large, 2, 1.0) / 5e30, 1.0, 1e-6);
    assert_near((double)large[1], 0.8, 1e-6);
}

static void bad_gradients_are_reported_and_left(void **state)
{
    (void)state;
    float g[3] = {3.0f, NAN, 4.0f}, h[3] = {3.0f, -INFINITY, 4.0f};
    assert_true(isnan(pbnds_clip_norm(g, 3, 1.0)));
    assert_near((double)g[0], 3.0, 0.0);
    assert_true(isinf(pbnds_clip_norm(h, 3, 1.0)));
    assert_near((double)h[2], 4.0, 0.0);
    assert_near(pbnds_clip_norm(g, 0, 1.0), 0.0, 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(follows_the_paper_in_double),
        cmocka_unit_test(first_step_has_length_lr),
        cmocka_unit_test(decay_is_decoupled),
        cmocka_unit_test(agrees_with_torch),
        cmocka_unit_test(clipping_keeps_the_direction),
        cmocka_unit_test(bad_gradients_are_reported_and_left),
    };
    return cmocka_run_group_tests_name("neural/train/adam", tests, NULL, NULL);
}
