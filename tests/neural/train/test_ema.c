/* neural/train/ema.c against the sum that it stands for. */
#include "tests/test.h"

#include "engine/core/rng.h"
#include "neural/train/ema.h"

enum { COUNT = 3, STEPS = 40 };

static float param_at(int step, int i)
{
    struct pbnds_rng rng = pbnds_rng_make(9, (uint64_t)step, (uint64_t)i);
    return 2.0f * pbnds_rng_float(&rng) - 1.0f + (float)i;
}

static void set(float params[COUNT], int step)
{
    for (int i = 0; i < COUNT; ++i)
        params[i] = param_at(step, i);
}

/* The mean is a sum over all steps: each one's rate times what later ones leave of it. */
static void is_a_weighted_sum(void **state)
{
    (void)state;
    struct pbnds_ema ema;
    float params[COUNT];
    set(params, 0);
    assert_int_equal(pbnds_ema_init(&ema, 0.8, COUNT, params, NULL), PBNDS_OK);
    for (int s = 1; s <= STEPS; ++s) {
        set(params, s);
        pbnds_ema_update(&ema, (uint64_t)s, params);
    }
    for (int i = 0; i < COUNT; ++i) {
        double sum = 0.0, left = 1.0;
        for (int s = STEPS; s >= 1; --s) {
            /* (1 + t) / (10 + t) passes 0.8 at t = 35 */
            const double decay = s >= 35 ? 0.8 : (1.0 + s) / (10.0 + s);
            sum += left * (1.0 - decay) * (double)param_at(s, i);
            left *= decay;
        }
        sum += left * (double)param_at(0, i);
        assert_near((double)ema.mean[i], sum, 2e-6);
    }
    pbnds_ema_free(&ema);
    assert_null(ema.mean);
}

static void swapping_twice_changes_nothing(void **state)
{
    (void)state;
    struct pbnds_ema ema;
    float params[COUNT];
    set(params, 1);
    assert_int_equal(pbnds_ema_init(&ema, 0.9, COUNT, params, NULL), PBNDS_OK);
    set(params, 2);
    pbnds_ema_swap(&ema, params);
    for (int i = 0; i < COUNT; ++i)
        assert_true(params[i] == param_at(1, i) && ema.mean[i] == param_at(2, i));
    pbnds_ema_swap(&ema, params);
    for (int i = 0; i < COUNT; ++i)
        assert_true(params[i] == param_at(2, i) && ema.mean[i] == param_at(1, i));
    pbnds_ema_free(&ema);
}

static void off_does_nothing(void **state)
{
    (void)state;
    struct pbnds_ema ema;
    float params[COUNT];
    set(params, 3);
    assert_int_equal(pbnds_ema_init(&ema, 0.0, COUNT, params, NULL), PBNDS_OK);
    assert_null(ema.mean);
    pbnds_ema_update(&ema, 1, params);
    pbnds_ema_swap(&ema, params);
    for (int i = 0; i < COUNT; ++i)
        assert_true(params[i] == param_at(3, i));
    pbnds_ema_free(&ema);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_a_weighted_sum),
        cmocka_unit_test(swapping_twice_changes_nothing),
        cmocka_unit_test(off_does_nothing),
    };
    return cmocka_run_group_tests_name("neural/train/ema", tests, NULL, NULL);
}
