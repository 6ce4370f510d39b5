/* The whole training step of both models: its gradient against central differences, and
 * the loop over chunks of lights against all lights at once. */
#include "tests/neural/train/fixture_item.h"

#include "neural/train/batch.h"

struct setup {
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    struct pbnds_train_item item;
    struct pbnds_batch batch;
    struct pbnds_task_view views[4];
};

static void start(struct setup *s, const struct pbnds_task_ops *ops, int lights,
                  int views, int chunk)
{
    *s = (struct setup){0};
    assert_int_equal(pbnds_backend_create_onednn(&s->backend, NULL), PBNDS_OK);
    assert_int_equal(
        pbnds_net_create(&ops->model->table, s->backend, PBNDS_F32, &s->net, NULL),
        PBNDS_OK);
    pbnds_net_init(s->net, 5);
    s->item = fixture_item(24);
    const struct pbnds_task task = {
        .model = ops->model, .lights = lights, .p_dark = 0.0, .lambda_zero = 1.0};
    assert_int_equal(
        pbnds_batch_init(&s->batch, ops, &task, s->net, views, 16, chunk, NULL),
        PBNDS_OK);
    for (int v = 0; v < 4; ++v) {
        s->views[v] =
            (struct pbnds_task_view){.item = &s->item,
                                     .window = {4 * (v % 2), 3 + v / 2, 16, 16},
                                     .key = 77u,
                                     .train = true};
    }
}

static void stop(struct setup *s)
{
    pbnds_batch_free(&s->batch);
    pbnds_train_item_free(&s->item);
    pbnds_net_free(s->net);
    pbnds_backend_free(s->backend);
}

static double loss_of(struct setup *s, bool train)
{
    struct pbnds_task_loss loss;
    assert_int_equal(pbnds_batch_run(&s->batch, s->views, train, 9, &loss, NULL),
                     PBNDS_OK);
    return loss.total;
}

/* Slope of the loss along a random direction in the space of all parameters; without
 * dropout, whose masks belong to training. */
static void check_gradient(const struct pbnds_task_ops *ops, int lights, int chunk,
                           double tolerance)
{
    struct setup s;
    start(&s, ops, lights, 2, chunk);
    pbnds_net_zero_grads(s.net);
    (void)loss_of(&s, true);
    const size_t count = pbnds_net_param_count(s.net);
    float *params = pbnds_net_params(s.net);
    float *kept = malloc(count * sizeof *kept), *grads = malloc(count * sizeof *grads);
    memcpy(kept, params, count * sizeof *kept);
    memcpy(grads, pbnds_net_grads(s.net), count * sizeof *grads);
    int checked = 0;
    for (int trial = 0; trial < 6; ++trial) {
        double predicted = 0.0, value[2];
        const double h = 5e-4;
        for (int side = 0; side < 2; ++side) {
            struct pbnds_rng rng = pbnds_rng_make(100, (uint64_t)trial, 0);
            for (size_t i = 0; i < count; ++i) {
                const float sign = pbnds_rng_float(&rng) < 0.5f ? -1.0f : 1.0f;
                /* along the gradient's own scale, so that every layer has a say */
                const float step = sign * fabsf(grads[i]);
                params[i] = kept[i] + (float)(side ? h : -h) * step;
                if (side == 0) predicted += (double)(step * grads[i]);
            }
            pbnds_net_params_changed(s.net);
            value[side] = loss_of(&s, true);
        }
        const double slope = (value[1] - value[0]) / (2.0 * h);
        if (fabs(predicted) < 1e-3) continue;
        assert_near(slope / predicted, 1.0, tolerance);
        ++checked;
    }
    assert_true(checked >= 3);
    free(kept);
    free(grads);
    stop(&s);
}

static void transport_gradient_is_right(void **state)
{
    (void)state;
    check_gradient(&pbnds_task_transport, PBNDS_DATASET_LIGHTS, 0, 0.03);
}

static void pbnds_plus_gradient_is_right(void **state)
{
    (void)state;
    check_gradient(&pbnds_task_pbnds_plus, 5, 0, 0.03);
    /* in chunks: the second forward must meet the dropout masks of the first */
    check_gradient(&pbnds_task_pbnds_plus, 5, 2, 0.03);
}

static void chunks_give_the_same_gradient(void **state)
{
    (void)state;
    static const struct pbnds_task_ops *const OPS[] = {&pbnds_task_transport};
    for (size_t m = 0; m < sizeof OPS / sizeof OPS[0]; ++m) {
        struct setup a, b;
        start(&a, OPS[m], PBNDS_DATASET_LIGHTS, 2, 32);
        start(&b, OPS[m], PBNDS_DATASET_LIGHTS, 2, 7); /* 7 x 4 + 4 */
        pbnds_net_zero_grads(a.net);
        pbnds_net_zero_grads(b.net);
        assert_near(loss_of(&a, true), loss_of(&b, true), 1e-5);
        double most = 0.0, apart = 0.0;
        for (size_t i = 0; i < pbnds_net_param_count(a.net); ++i) {
            const double x = (double)pbnds_net_grads(a.net)[i];
            most = fmax(most, fabs(x));
            apart = fmax(apart, fabs(x - (double)pbnds_net_grads(b.net)[i]));
        }
        assert_true(most > 0.0);
        assert_true(apart <= 1e-4 * most);
        stop(&a);
        stop(&b);
    }
}

/* Four views at once, by twos and one by one: the same loss and the same gradient, to
 * rounding, dropout masks and all. */
static void parts_of_a_step_add_up(void **state)
{
    (void)state;
    static const struct pbnds_task_ops *const OPS[] = {&pbnds_task_transport,
                                                       &pbnds_task_pbnds_plus};
    for (size_t m = 0; m < 2; ++m) {
        const int lights = m == 0 ? PBNDS_DATASET_LIGHTS : 3;
        float *whole = NULL;
        double total = 0.0;
        for (int views = 4; views >= 1; views /= 2) {
            struct setup s;
            start(&s, OPS[m], lights, views, 0);
            pbnds_net_zero_grads(s.net);
            s.batch.step_views = 4;
            double sum = 0.0;
            for (int first = 0; first < 4; first += views) {
                struct pbnds_task_loss loss;
                s.batch.first_view = first;
                assert_int_equal(
                    pbnds_batch_run(&s.batch, s.views + first, true, 9, &loss, NULL),
                    PBNDS_OK);
                sum += loss.total;
                assert_int_equal(s.batch.mse_count, views);
            }
            const size_t count = pbnds_net_param_count(s.net);
            const float *grads = pbnds_net_grads(s.net);
            if (!whole) {
                whole = malloc(count * sizeof *whole);
                memcpy(whole, grads, count * sizeof *whole);
                total = sum;
            }
            assert_near(sum, total, 1e-6 * total);
            double norm = 0.0, apart = 0.0;
            for (size_t i = 0; i < count; ++i) {
                norm += (double)(whole[i] * whole[i]);
                apart += pow((double)(grads[i] - whole[i]), 2.0);
            }
            assert_true(norm > 0.0);
            assert_true(sqrt(apart / norm) < 1e-5);
            stop(&s);
        }
        free(whole);
    }
}

/* Twice the light: pbnds+, which looks it up in the map, sees it too. */
static void exposure_reaches_the_network(void **state)
{
    (void)state;
    struct setup s;
    start(&s, &pbnds_task_pbnds_plus, 3, 1, 0);
    const int channels = s.batch.task.model->light_channels;
    float *plain = malloc(3u * 16u * 16u * (size_t)channels * sizeof *plain);
    float *bright = malloc(3u * 16u * 16u * (size_t)channels * sizeof *bright);
    s.batch.ops->light_input(&s.batch.task, &s.views[0], 0, 3, plain);
    s.item.stops = 1.0f;
    s.batch.ops->light_input(&s.batch.task, &s.views[0], 0, 3, bright);
    int lit = 0;
    for (int i = 0; i < 3 * 16 * 16;
         ++i) { /* the identity of log1p(L n.l) comes first */
        const double a = expm1((double)plain[i * channels]);
        assert_near(expm1((double)bright[i * channels]), 2.0 * a, 1e-5 * (1.0 + a));
        lit += a > 0.1;
    }
    assert_true(lit > 20);
    free(plain);
    free(bright);
    stop(&s);
}

/* With p_dark = 1 every sample is dark: the loss is lambda times the mean square. */
static void dark_samples_pay_for_light(void **state)
{
    (void)state;
    struct setup s;
    start(&s, &pbnds_task_pbnds_plus, 5, 1, 0);
    s.batch.task.p_dark = 1.0;
    struct pbnds_task_loss one, twice;
    assert_int_equal(pbnds_batch_run(&s.batch, s.views, true, 9, &one, NULL), PBNDS_OK);
    s.batch.task.lambda_zero = 2.0;
    assert_int_equal(pbnds_batch_run(&s.batch, s.views, true, 9, &twice, NULL),
                     PBNDS_OK);
    assert_true(one.total > 0.0 && one.mse < 0.0);
    assert_near(twice.total, 2.0 * one.total, 1e-6 * one.total);
    double mean_square = 0.0;
    int covered = 0;
    for (int i = 0; i < 16 * 16; ++i) {
        const int x = i % 16, y = 3 + i / 16;
        if (!(s.item.view.plane[PBNDS_PLANE_MASK][y * 24 + x] > 0.0f)) continue;
        ++covered;
        for (int c = 0; c < 3; ++c) {
            double mean = 0.0;
            for (int k = 0; k < 5; ++k) {
                mean +=
                    (double)s.batch.out[(size_t)(k * 256 + i) * 3 + (size_t)c] / 5.0;
            }
            const double display =
                mean <= 0.0031308 ? 12.92 * mean : 1.055 * pow(mean, 1.0 / 2.4) - 0.055;
            mean_square += display * display;
        }
    }
    assert_near(one.total, mean_square / (3.0 * covered), 1e-5 * one.total);
    stop(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transport_gradient_is_right),
        cmocka_unit_test(pbnds_plus_gradient_is_right),
        cmocka_unit_test(chunks_give_the_same_gradient),
        cmocka_unit_test(parts_of_a_step_add_up),
        cmocka_unit_test(exposure_reaches_the_network),
        cmocka_unit_test(dark_samples_pay_for_light),
    };
    return cmocka_run_group_tests_name("neural/train/batch", tests, NULL, NULL);
}
