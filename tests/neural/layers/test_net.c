/* A network with every op in both scopes: against PyTorch, against central differences,
 * in chunks of lights, in bfloat16, again and at another thread count; and tables that
 * must be refused. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "engine/core/parallel.h"
#include "engine/core/report.h"
#include "engine/core/rng.h"
#include "neural/layers/net.h"
#include "neural/layers/net_internal.h"

enum { ROWS = 23, VOUT = 7, LOUT = 21, B = 2, N = 3, SIDE = 8, KEY = 77 };

#define CONV(n, a, c, k, s, act)                                                       \
    {                                                                                  \
        n, PBNDS_OP_CONV, {a, -1}, c, k, s, act, 0.0f, 0.0f                            \
    }
#define OTHER(n, op, a, b, c, act, rate)                                               \
    {                                                                                  \
        n, PBNDS_OP_##op, {a, b}, c, 0, 0, act, rate, 0.0f                             \
    }

static const struct pbnds_layer all_ops[ROWS] = {
    [0] = OTHER("view", VIEW_INPUT, -1, -1, 5, PBNDS_ACT_NONE, 0.0f),
    [1] = CONV("v1", 0, 6, 3, 1, PBNDS_ACT_RELU),
    [2] = CONV("v2", 1, 8, 2, 2, PBNDS_ACT_RELU),
    [3] = CONV("v3", 2, 8, 3, 2, PBNDS_ACT_NONE),
    [4] = OTHER("v_drop", DROPOUT, 3, -1, 0, PBNDS_ACT_NONE, 0.25f),
    [5] = OTHER("v_up", UP, 4, -1, 8, PBNDS_ACT_RELU, 0.0f),
    [6] = OTHER("v_cat", CONCAT, 5, 2, 0, PBNDS_ACT_NONE, 0.0f),
    [7] = CONV("v_out", 6, 3, 1, 1, PBNDS_ACT_NONE),
    [8] = OTHER("light", LIGHT_INPUT, -1, -1, 4, PBNDS_ACT_NONE, 0.0f),
    [9] = OTHER("pool", POOL, 8, -1, 0, PBNDS_ACT_NONE, 0.0f),
    [10] = CONV("l1", 9, 16, 3, 1, PBNDS_ACT_NONE),
    [11] = OTHER("add_view", ADD, 10, 6, 0, PBNDS_ACT_RELU, 0.0f),
    [12] = CONV("l2", 11, 12, 3, 1, PBNDS_ACT_RELU),
    [13] = OTHER("twice", ADD, 12, 12, 0, PBNDS_ACT_NONE, 0.0f),
    [14] = OTHER("cat_view", CONCAT, 2, 13, 0, PBNDS_ACT_NONE, 0.0f),
    [15] = CONV("l3", 14, 12, 1, 1, PBNDS_ACT_RELU),
    [16] = OTHER("shuffle", SHUFFLE, 15, -1, 0, PBNDS_ACT_NONE, 0.0f),
    [17] = OTHER("up", UP, 15, -1, 3, PBNDS_ACT_NONE, 0.0f),
    [18] = OTHER("sum", ADD, 16, 17, 0, PBNDS_ACT_NONE, 0.0f),
    [19] = OTHER("drop", DROPOUT, 18, -1, 0, PBNDS_ACT_NONE, 0.5f),
    [20] = OTHER("cat_v1", CONCAT, 19, 1, 0, PBNDS_ACT_NONE, 0.0f),
    [21] = CONV("l_out", 20, 2, 3, 1, PBNDS_ACT_NONE),
    [22] = CONV("dead", 20, 2, 3, 1, PBNDS_ACT_NONE),
};

static struct pbnds_backend *make_backend(bool dnn)
{
    struct pbnds_backend *b;
    struct pbnds_error error;
    if (dnn ? pbnds_backend_create_onednn(&b, &error)
            : pbnds_backend_create_reference(&b, &error)) {
        fail_msg("%s", error.message);
    }
    return b;
}

static void fill(float *p, size_t count, uint64_t seed)
{
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
    for (size_t i = 0; i < count; ++i)
        p[i] = 2.0f * pbnds_rng_float(&rng) - 1.0f;
}

enum {
    VIEW_IN = B * SIDE * SIDE * 5,
    VIEW_OUT = B * SIDE / 2 * SIDE / 2 * 3,
    LIGHT_IN = B * N * SIDE * SIDE * 4,
    LIGHT_OUT = B * N * SIDE * SIDE * 2,
};

/** A net on the table of all ops, its data and its results. */
struct work {
    struct pbnds_layer layers[ROWS];
    struct pbnds_net_table table;
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    float view_in[VIEW_IN], light_in[LIGHT_IN], d_view[VIEW_OUT], d_light[LIGHT_OUT];
    float view_out[VIEW_OUT], light_out[LIGHT_OUT];
};

static struct work *make_work(bool dnn, enum pbnds_dtype dtype, bool dropout)
{
    struct work *w = calloc(1, sizeof *w);
    struct pbnds_error error;
    memcpy(w->layers, all_ops, sizeof all_ops);
    if (!dropout) w->layers[4].rate = w->layers[19].rate = 0.0f;
    w->table = (struct pbnds_net_table){w->layers, ROWS, LOUT, VOUT};
    w->backend = make_backend(dnn);
    if (pbnds_net_create(&w->table, w->backend, dtype, &w->net, &error)) {
        fail_msg("%s", error.message);
    }
    pbnds_net_init(w->net, 9);
    for (int i = 1; i < pbnds_net_tensor_count(w->net); i += 2) { /* biases too */
        const struct pbnds_param *p = pbnds_net_param(w->net, i);
        fill(pbnds_net_params(w->net) + p->offset, p->count, (uint64_t)i);
    }
    pbnds_net_params_changed(w->net);
    fill(w->view_in, VIEW_IN, 1001);
    fill(w->light_in, LIGHT_IN, 1002);
    fill(w->d_view, VIEW_OUT, 1003);
    fill(w->d_light, LIGHT_OUT, 1004);
    return w;
}

static void free_work(struct work *w)
{
    pbnds_net_free(w->net);
    pbnds_backend_free(w->backend);
    free(w);
}

#define MUST(call)                                                                     \
    do {                                                                               \
        struct pbnds_error error = {""};                                               \
        if (call) fail_msg("%s", error.message);                                       \
    } while (0)

static struct pbnds_pass pass_of(int lights, bool train)
{
    return (struct pbnds_pass){.batch = B,
                               .lights = lights,
                               .h = SIDE,
                               .w = SIDE,
                               .train = train,
                               .dropout_key = KEY};
}

static void forward(struct work *w, bool train)
{
    const struct pbnds_pass pass = pass_of(N, train);
    MUST(pbnds_net_forward_view(w->net, &pass, w->view_in, w->view_out, &error));
    MUST(pbnds_net_forward_light(w->net, &pass, w->light_in, w->light_out, &error));
}

static void backward(struct work *w)
{
    const struct pbnds_pass pass = pass_of(N, true);
    MUST(pbnds_net_backward_light(w->net, &pass, w->d_light, &error));
    MUST(pbnds_net_backward_view(w->net, &pass, w->d_view, &error));
}

/** Root mean square of the difference over that of b. */
static double distance(const float *a, const float *b, size_t count)
{
    double d = 0.0, s = 0.0;
    for (size_t i = 0; i < count; ++i) {
        d += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
        s += (double)b[i] * (double)b[i];
    }
    return sqrt(d / (s + 1e-30));
}

/** The worst distance over the tensors; rows without gradient must have none. */
static double tensor_distance(const struct pbnds_net *net, const float *a,
                              const float *b)
{
    double worst = 0.0;
    for (int i = 0; i < pbnds_net_tensor_count(net); ++i) {
        const struct pbnds_param *p = pbnds_net_param(net, i);
        const double d = distance(a + p->offset, b + p->offset, p->count);
        if (!(d <= worst)) worst = d;
    }
    return worst;
}

/* --- gradients -------------------------------------------------------------------- */

static double loss(struct work *w)
{
    double sum = 0.0;
    pbnds_net_params_changed(w->net);
    forward(w, true);
    for (int i = 0; i < VIEW_OUT; ++i)
        sum += (double)w->view_out[i] * (double)w->d_view[i];
    for (int i = 0; i < LIGHT_OUT; ++i) {
        sum += (double)w->light_out[i] * (double)w->d_light[i];
    }
    return sum;
}

/** With fixed dropout masks the loss is piecewise linear in each parameter: small steps
 *  that cross a kink are few, and are told by two step sizes that disagree. */
static void test_gradients_are_central_differences(void **state)
{
    (void)state;
    struct work *w = make_work(false, PBNDS_F32, true);
    float *params = pbnds_net_params(w->net), *grads = pbnds_net_grads(w->net);
    forward(w, true);
    backward(w);
    int checked = 0, kinks = 0;
    for (size_t i = 0; i < pbnds_net_param_count(w->net); i += 61) {
        double slope[2];
        const float old = params[i];
        for (int k = 0; k < 2; ++k) {
            const float step = k ? 0x1p-9f : 0x1p-8f;
            params[i] = old + step;
            const double up = loss(w);
            params[i] = old - step;
            slope[k] = (up - loss(w)) / (2.0 * (double)step);
        }
        params[i] = old;
        ++checked;
        if (fabs(slope[0] - slope[1]) > 2e-3) {
            ++kinks;
        } else {
            assert_near(grads[i], slope[1], 4e-3);
        }
    }
    assert_true(checked > 70 && kinks < checked / 3);
    free_work(w);
}

static void write_floats(FILE *f, const float *p, size_t count)
{
    assert_int_equal(fwrite(p, sizeof *p, count, f), count);
}

/** The masks that the net draws, as factors. */
static void write_mask(FILE *f, int row, size_t count, float rate)
{
    float *ones = malloc(count * sizeof *ones);
    for (size_t i = 0; i < count; ++i)
        ones[i] = 1.0f;
    for (size_t v = 0; v < B; ++v) { /* each view has its own */
        const uint64_t key = pbnds_mix64(KEY ^ (uint64_t)v << 32);
        float *part = ones + v * (count / B);
        pbnds_dropout(PBNDS_F32, count / B, pbnds_mix64(key ^ (uint64_t)row), rate, part,
                      part);
    }
    write_floats(f, ones, count);
    free(ones);
}

static void write_problem(const struct work *w)
{
    FILE *table = fopen("net_torch.txt", "w"), *data = fopen("net_torch_in.bin", "wb");
    assert_non_null(table);
    assert_non_null(data);
    fprintf(table, "%d %d %d %d %d %d\n", B, N, SIDE, SIDE, LOUT, VOUT);
    for (int r = 0; r < ROWS; ++r) {
        const struct pbnds_layer *l = &w->layers[r];
        fprintf(table, "%d %d %d %d %d %d %d\n", (int)l->op, l->in[0], l->in[1],
                l->channels, l->kernel, l->stride, l->act == PBNDS_ACT_RELU);
    }
    write_floats(data, pbnds_net_params(w->net), pbnds_net_param_count(w->net));
    write_floats(data, w->view_in, VIEW_IN);
    write_floats(data, w->light_in, LIGHT_IN);
    write_mask(data, 4, B * (SIDE / 4) * (SIDE / 4) * 8, w->layers[4].rate);
    write_mask(data, 19, B * N * SIDE * SIDE * 3, w->layers[19].rate);
    write_floats(data, w->d_light, LIGHT_OUT);
    write_floats(data, w->d_view, VIEW_OUT);
    fclose(table);
    fclose(data);
}

static void test_agrees_with_torch(void **state)
{
    (void)state;
    struct work *w = make_work(true, PBNDS_F32, true);
    const size_t count = pbnds_net_param_count(w->net);
    float *light_out = malloc(sizeof w->light_out),
          *view_out = malloc(sizeof w->view_out);
    float *grads = malloc(count * sizeof *grads);
    write_problem(w);
    const int ran = system("/usr/bin/python3 " PBNDS_SOURCE_DIR
                           "/tests/neural/layers/net_torch.py net_torch.txt "
                           "net_torch_in.bin net_torch_out.bin 2>net_torch.log");
    const int code = ran >= 0 && WIFEXITED(ran) ? WEXITSTATUS(ran) : -1;
    const bool absent = code == 77 || code == 127; /* no torch, no python */
    if (!absent) {
        assert_int_equal(code, 0);
        forward(w, true);
        backward(w);
        FILE *f = fopen("net_torch_out.bin", "rb");
        assert_non_null(f);
        assert_int_equal(fread(light_out, sizeof *light_out, LIGHT_OUT, f), LIGHT_OUT);
        assert_int_equal(fread(view_out, sizeof *view_out, VIEW_OUT, f), VIEW_OUT);
        assert_int_equal(fread(grads, sizeof *grads, count, f), count);
        fclose(f);
        assert_near(distance(w->light_out, light_out, LIGHT_OUT), 0.0, 2e-6);
        assert_near(distance(w->view_out, view_out, VIEW_OUT), 0.0, 2e-6);
        assert_near(tensor_distance(w->net, pbnds_net_grads(w->net), grads), 0.0, 5e-6);
    }
    free(light_out);
    free(view_out);
    free(grads);
    free_work(w);
    if (absent) skip();
}

static void test_backends_agree(void **state)
{
    (void)state;
    struct work *a = make_work(true, PBNDS_F32, true);
    struct work *b = make_work(false, PBNDS_F32, true);
    for (int k = 0; k < 2; ++k) {
        forward(k ? b : a, true);
        backward(k ? b : a);
    }
    assert_near(distance(a->light_out, b->light_out, LIGHT_OUT), 0.0, 2e-6);
    assert_near(distance(a->view_out, b->view_out, VIEW_OUT), 0.0, 2e-6);
    assert_near(
        tensor_distance(a->net, pbnds_net_grads(a->net), pbnds_net_grads(b->net)), 0.0,
        5e-6);
    free_work(a);
    free_work(b);
}

/* --- lights in chunks ------------------------------------------------------------- */

/** Copies lights [first, first + n) of each view of [B, N, size]. */
static void pick(const float *all, float *some, int first, int n, size_t size)
{
    for (size_t b = 0; b < B; ++b) {
        memcpy(some + b * (size_t)n * size, all + (b * N + (size_t)first) * size,
               (size_t)n * size * sizeof *some);
    }
}

static void run_chunk(struct work *w, int first, int n, bool train, float *out)
{
    const size_t in_size = SIDE * SIDE * 4, out_size = SIDE * SIDE * 2;
    const struct pbnds_pass pass = pass_of(n, train);
    float *in = malloc(B * (size_t)n * in_size * sizeof *in);
    float *d = malloc(B * (size_t)n * out_size * sizeof *d);
    float *y = malloc(B * (size_t)n * out_size * sizeof *y);
    pick(w->light_in, in, first, n, in_size);
    pick(w->d_light, d, first, n, out_size);
    MUST(pbnds_net_forward_light(w->net, &pass, in, y, &error));
    if (train) MUST(pbnds_net_backward_light(w->net, &pass, d, &error));
    for (size_t b = 0; b < B; ++b) {
        memcpy(out + (b * N + (size_t)first) * out_size, y + b * (size_t)n * out_size,
               (size_t)n * out_size * sizeof *out);
    }
    free(in);
    free(d);
    free(y);
}

static void test_chunks_of_lights_equal_all_at_once(void **state)
{
    (void)state;
    struct work *a = make_work(true, PBNDS_F32, false);
    struct work *b = make_work(true, PBNDS_F32, false);
    const struct pbnds_pass pass = pass_of(N, true);
    forward(a, true);
    backward(a);
    MUST(pbnds_net_forward_view(b->net, &pass, b->view_in, b->view_out, &error));
    run_chunk(b, 0, 2, true, b->light_out);
    run_chunk(b, 2, 1, true, b->light_out);
    MUST(pbnds_net_backward_view(b->net, &pass, b->d_view, &error));
    assert_near(distance(b->light_out, a->light_out, LIGHT_OUT), 0.0, 1e-6);
    assert_near(
        tensor_distance(a->net, pbnds_net_grads(b->net), pbnds_net_grads(a->net)), 0.0,
        2e-6);
    free_work(a);
    free_work(b);
}

/** Outputs of inference do not depend on training's bookkeeping, and dropout is off. */
static void test_inference_equals_training_without_dropout(void **state)
{
    (void)state;
    struct work *a = make_work(true, PBNDS_F32, true); /* rates are set */
    struct work *b = make_work(true, PBNDS_F32, false);
    const struct pbnds_pass pass = pass_of(N, false);
    forward(b, true);
    for (int round = 0; round < 2; ++round) {
        MUST(pbnds_net_forward_view(a->net, &pass, a->view_in, a->view_out, &error));
        run_chunk(a, 0, 1, false, a->light_out);
        run_chunk(a, 1, 2, false, a->light_out);
        assert_near(distance(a->light_out, b->light_out, LIGHT_OUT), 0.0, 1e-6);
        assert_near(distance(a->view_out, b->view_out, VIEW_OUT), 0.0, 1e-6);
    }
    free_work(a);
    free_work(b);
}

static void test_memory_is_reused(void **state)
{
    (void)state;
    struct work *a = make_work(true, PBNDS_F32, true);
    struct work *b = make_work(true, PBNDS_F32, true);
    size_t settled = 0;
    for (int round = 0; round < 4; ++round) {
        forward(a, true);
        backward(a);
        forward(b, false);
        if (round == 1) settled = pbnds_arena_bytes(&a->net->arena);
        if (round > 1) assert_int_equal(pbnds_arena_bytes(&a->net->arena), settled);
    }
    assert_true(2 * pbnds_arena_bytes(&b->net->arena) <
                pbnds_arena_bytes(&a->net->arena));
    free_work(a);
    free_work(b);
}

/* --- numbers ---------------------------------------------------------------------- */

static void test_bf16_tracks_f32(void **state)
{
    (void)state;
    struct work *a = make_work(true, PBNDS_F32, true);
    struct work *b = make_work(true, PBNDS_BF16, true);
    const struct pbnds_pass pass = pass_of(N, true);
    struct pbnds_error error;
    const enum pbnds_status status =
        pbnds_net_forward_view(b->net, &pass, b->view_in, b->view_out, &error);
    if (status == PBNDS_OK) {
        for (int k = 0; k < 2; ++k) {
            forward(k ? b : a, true);
            backward(k ? b : a);
        }
        assert_near(distance(b->light_out, a->light_out, LIGHT_OUT), 0.0, 0.01);
        assert_near(distance(b->view_out, a->view_out, VIEW_OUT), 0.0, 0.01);
        assert_near(
            tensor_distance(a->net, pbnds_net_grads(b->net), pbnds_net_grads(a->net)),
            0.0, 0.06);
        assert_near(distance(pbnds_net_grads(b->net), pbnds_net_grads(a->net),
                             pbnds_net_param_count(a->net)),
                    0.0, 0.03);
    }
    free_work(a);
    free_work(b);
    if (status != PBNDS_OK) {
        assert_int_equal(status, PBNDS_ERROR_UNSUPPORTED);
        skip();
    }
}

static void test_same_bits_again(void **state)
{
    (void)state;
    struct work *a = make_work(true, PBNDS_F32, true);
    struct work *b = make_work(true, PBNDS_F32, true);
    const size_t bytes = pbnds_net_param_count(a->net) * sizeof(float);
    pbnds_set_threads(2);
    forward(a, true);
    backward(a);
    forward(b, true);
    backward(b);
    assert_memory_equal(a->light_out, b->light_out, sizeof a->light_out);
    assert_memory_equal(pbnds_net_grads(a->net), pbnds_net_grads(b->net), bytes);
    pbnds_set_threads(1);
    pbnds_net_zero_grads(b->net);
    forward(b, true);
    backward(b);
    pbnds_set_threads(1);
    assert_memory_equal(a->light_out, b->light_out, sizeof a->light_out);
    assert_memory_equal(a->view_out, b->view_out, sizeof a->view_out);
    assert_near(
        tensor_distance(a->net, pbnds_net_grads(b->net), pbnds_net_grads(a->net)), 0.0,
        2e-6);
    free_work(a);
    free_work(b);
}

static void test_dropout_statistics(void **state)
{
    (void)state;
    enum { COUNT = 1 << 18 };
    float *x = malloc(COUNT * sizeof *x), *y = malloc(COUNT * sizeof *y);
    for (int i = 0; i < COUNT; ++i)
        x[i] = 1.0f;
    size_t both = 0, kept[2] = {0, 0};
    for (uint64_t key = 0; key < 2; ++key) {
        pbnds_dropout(PBNDS_F32, COUNT, pbnds_mix64(key), 0.3f, x, y);
        for (int i = 0; i < COUNT; ++i) {
            assert_true(y[i] == 0.0f || y[i] == 1.0f / (1.0f - 0.3f));
            kept[key] += y[i] != 0.0f;
        }
    }
    pbnds_dropout(PBNDS_F32, COUNT, pbnds_mix64(0), 0.3f, y, x);
    for (int i = 0; i < COUNT; ++i)
        both += x[i] != 0.0f;
    const double sigma = sqrt(0.3 * 0.7 / COUNT);
    assert_near((double)kept[0] / COUNT, 0.7, 5 * sigma);
    assert_near((double)kept[1] / COUNT, 0.7, 5 * sigma);
    assert_near((double)both / COUNT, 0.49, 5 * sigma); /* keys are independent */
    free(x);
    free(y);
}

static void test_dropout_follows_the_key(void **state)
{
    (void)state;
    struct work *w = make_work(true, PBNDS_F32, true);
    struct pbnds_pass pass = pass_of(N, true);
    float *first = malloc(sizeof w->light_out);
    forward(w, true);
    memcpy(first, w->light_out, sizeof w->light_out);
    forward(w, true);
    assert_memory_equal(first, w->light_out, sizeof w->light_out);
    pass.dropout_key = KEY + 1;
    MUST(pbnds_net_forward_light(w->net, &pass, w->light_in, w->light_out, &error));
    assert_true(distance(w->light_out, first, LIGHT_OUT) > 0.05);
    free(first);
    free_work(w);
}

static void test_init_is_kaiming(void **state)
{
    (void)state;
    const struct pbnds_layer layers[] = {
        OTHER("in", VIEW_INPUT, -1, -1, 64, PBNDS_ACT_NONE, 0.0f),
        CONV("relu", 0, 64, 3, 1, PBNDS_ACT_RELU),
        CONV("plain", 1, 256, 1, 1, PBNDS_ACT_NONE),
        {"small", PBNDS_OP_UP, {2, -1}, 64, 0, 0, PBNDS_ACT_NONE, 0.0f, 0.5f},
    };
    const struct pbnds_layer level0 = CONV("down", 1, 64, 2, 2, PBNDS_ACT_NONE);
    struct pbnds_layer all[5] = {layers[0], layers[1], level0, layers[2], layers[3]};
    all[3].in[0] = 2;
    all[4].in[0] = 3;
    const struct pbnds_net_table table = {all, 5, -1, 4};
    const double expected[] = {sqrt(2.0 / (64 * 9)), sqrt(1.0 / (64 * 4)),
                               sqrt(1.0 / 64), 0.5 * sqrt(1.0 / 256)};
    struct pbnds_backend *b = make_backend(false);
    struct pbnds_net *net, *again;
    MUST(pbnds_net_create(&table, b, PBNDS_F32, &net, &error));
    MUST(pbnds_net_create(&table, b, PBNDS_F32, &again, &error));
    pbnds_net_init(net, 5);
    pbnds_net_init(again, 5);
    assert_memory_equal(pbnds_net_params(net), pbnds_net_params(again),
                        pbnds_net_param_count(net) * sizeof(float));
    for (int i = 0; i < 4; ++i) {
        const struct pbnds_param *p = pbnds_net_param(net, 2 * i);
        double sum = 0.0, square = 0.0, fourth = 0.0;
        for (size_t k = 0; k < p->count; ++k) {
            const double v = (double)pbnds_net_params(net)[p->offset + k] / expected[i];
            sum += v;
            square += v * v;
            fourth += v * v * v * v;
        }
        const double n = (double)p->count;
        assert_near(sum / n, 0.0, 5.0 / sqrt(n));
        assert_near(square / n, 1.0, 5.0 * sqrt(2.0 / n));
        assert_near(fourth / n, 3.0, 5.0 * sqrt(96.0 / n)); /* a normal distribution */
        const struct pbnds_param *bias = pbnds_net_param(net, 2 * i + 1);
        for (size_t k = 0; k < bias->count; ++k) {
            assert_near(pbnds_net_params(net)[bias->offset + k], 0.0, 0.0);
        }
    }
    pbnds_net_free(net);
    pbnds_net_free(again);
    pbnds_backend_free(b);
}

static void test_names_shapes_and_counts(void **state)
{
    (void)state;
    struct work *w = make_work(false, PBNDS_F32, true);
    size_t offset = 0;
    for (int i = 0; i < pbnds_net_tensor_count(w->net); ++i) {
        const struct pbnds_param *p = pbnds_net_param(w->net, i);
        assert_int_equal(p->offset, offset);
        offset += p->count;
    }
    assert_int_equal(offset, pbnds_net_param_count(w->net));
    assert_null(pbnds_net_param(w->net, -1));
    assert_null(pbnds_net_param(w->net, pbnds_net_tensor_count(w->net)));
    const struct pbnds_param *up = pbnds_net_param(w->net, 6);
    assert_string_equal(up->name, "v_up.weight");
    assert_int_equal(up->rank, 4);
    const int iohw[] = {8, 8, 2, 2};
    assert_memory_equal(up->shape, iohw, sizeof iohw);
    const struct pbnds_param *l3 = pbnds_net_param(w->net, 14);
    assert_string_equal(l3->name, "l3.weight");
    const int oihw[] = {12, 20, 1, 1};
    assert_memory_equal(l3->shape, oihw, sizeof oihw);
    assert_string_equal(pbnds_net_param(w->net, 15)->name, "l3.bias");
    assert_int_equal(pbnds_net_deepest_level(w->net), 2);
    double view, light;
    pbnds_net_macs(w->net, 8, 8, &view, &light);
    assert_near(
        view,
        64 * 6 * 5 * 9 + 16 * 8 * 6 * 4 + 4 * 8 * 8 * 9 + 16 * 8 * 8 + 16 * 3 * 16, 0);
    assert_near(light,
                16 * 16 * 4 * 9 + 16 * 12 * 16 * 9 + 16 * 12 * 20 + 64 * 3 * 12 +
                    64 * 2 * 9 * 9,
                0);
    free_work(w);
}

/* --- refusals --------------------------------------------------------------------- */

static void test_bad_tables_are_refused(void **state)
{
    (void)state;
    static const struct {
        int row;
        struct pbnds_layer layer;
        const char *word; /* in the sentence */
    } bad[] = {
        {1, CONV("v1", 0, 6, 5, 1, PBNDS_ACT_RELU), "kernel 5"},
        {1, CONV("v1", 0, 6, 2, 1, PBNDS_ACT_RELU), "stride 1"},
        {1, CONV("v1", 0, 0, 3, 1, PBNDS_ACT_RELU), "channels"},
        {1, CONV("v1", 0, 100000, 3, 1, PBNDS_ACT_RELU), "100000"},
        {1, CONV("v1", 1, 6, 3, 1, PBNDS_ACT_RELU), "row 1"},
        {1, CONV("v1", -1, 6, 3, 1, PBNDS_ACT_RELU), "row -1"},
        {1, CONV("v1", 0, 6, 3, 1, (enum pbnds_act)7), "activation 7"},
        {1, CONV("view", 0, 6, 3, 1, PBNDS_ACT_NONE), "same name"},
        {1, CONV("", 0, 6, 3, 1, PBNDS_ACT_NONE), "name"},
        {1, CONV(NULL, 0, 6, 3, 1, PBNDS_ACT_NONE), "name"},
        {1, OTHER("v1", UP, 0, -1, 6, PBNDS_ACT_NONE, 0.0f), "larger"},
        {1, OTHER("v1", VIEW_INPUT, -1, -1, 6, PBNDS_ACT_NONE, 0.0f), "already"},
        {4, OTHER("v_drop", DROPOUT, 3, -1, 0, PBNDS_ACT_NONE, 1.0f), "rate 1"},
        {4, OTHER("v_drop", DROPOUT, 3, -1, 9, PBNDS_ACT_NONE, 0.1f), "channels"},
        {6, OTHER("v_cat", CONCAT, 5, 1, 0, PBNDS_ACT_NONE, 0.0f), "levels 1 and 0"},
        {6, OTHER("v_cat", CONCAT, 5, 2, 0, PBNDS_ACT_RELU, 0.0f), "activation"},
        {7, CONV("v_out", 11, 3, 1, 1, PBNDS_ACT_NONE), "not before"},
        {11, OTHER("add_view", ADD, 10, 5, 0, PBNDS_ACT_RELU, 0.0f), "16 and 8"},
        {16, OTHER("shuffle", SHUFFLE, 9, -1, 3, PBNDS_ACT_NONE, 0.0f), "not 3"},
        {16, {"shuffle", (enum pbnds_op)44, {15, -1}, 0, 0, 0, 0, 0.0f, 0.0f}, "op 44"},
        {7, OTHER("v_out", SHUFFLE, 1, -1, 0, PBNDS_ACT_NONE, 0.0f), "divide by 4"},
        {21, CONV("l_out", 6, 2, 3, 1, PBNDS_ACT_NONE), "view scope"},
    };
    struct pbnds_backend *b = make_backend(false);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        struct pbnds_layer layers[ROWS];
        struct pbnds_error error = {""};
        struct pbnds_net *net;
        char row[32];
        memcpy(layers, all_ops, sizeof layers);
        layers[bad[i].row] = bad[i].layer;
        const struct pbnds_net_table table = {layers, ROWS, LOUT, VOUT};
        assert_int_equal(pbnds_net_create(&table, b, PBNDS_F32, &net, &error),
                         PBNDS_ERROR_ARGUMENT);
        assert_null(net);
        (void)snprintf(row, sizeof row, "row %d \"", bad[i].row);
        if (!strstr(error.message, row) || !strstr(error.message, bad[i].word)) {
            fail_msg("case %zu: %s", i, error.message);
        }
    }
    pbnds_backend_free(b);
}

static void test_bad_passes_are_refused(void **state)
{
    (void)state;
    struct work *w = make_work(false, PBNDS_F32, true);
    struct pbnds_error fault;
    struct pbnds_pass pass = pass_of(N, true), odd = pass, other = pass;
    odd.w = SIDE + 2; /* the deepest level is 2: multiples of 4 */
    assert_int_equal(pbnds_net_forward_view(w->net, &odd, w->view_in, NULL, &fault),
                     PBNDS_ERROR_ARGUMENT);
    odd.w = 0;
    assert_int_equal(pbnds_net_forward_view(w->net, &odd, w->view_in, NULL, &fault),
                     PBNDS_ERROR_ARGUMENT);
    odd = pass;
    odd.batch = odd.lights = 1 << 20;
    assert_int_equal(pbnds_net_forward_light(w->net, &odd, w->light_in, NULL, &fault),
                     PBNDS_ERROR_ARGUMENT);
    assert_int_equal(pbnds_net_forward_light(w->net, &pass, w->light_in, NULL, &fault),
                     PBNDS_ERROR_ARGUMENT); /* no view yet */
    assert_int_equal(pbnds_net_forward_view(w->net, &pass, NULL, NULL, &fault),
                     PBNDS_ERROR_ARGUMENT);
    MUST(pbnds_net_forward_view(w->net, &pass, w->view_in, NULL, &error));
    assert_int_equal(pbnds_net_backward_light(w->net, &pass, w->d_light, &fault),
                     PBNDS_ERROR_ARGUMENT); /* nothing to go back over */
    other.h = 2 * SIDE;
    assert_int_equal(pbnds_net_forward_light(w->net, &other, w->light_in, NULL, &fault),
                     PBNDS_ERROR_ARGUMENT);
    pass.train = false;
    MUST(pbnds_net_forward_light(w->net, &pass, w->light_in, NULL, &error));
    assert_int_equal(pbnds_net_backward_light(w->net, &pass, w->d_light, &fault),
                     PBNDS_ERROR_ARGUMENT); /* its activations were not kept */
    free_work(w);
}

/** The last test: a stop, once requested, stays. */
static void test_a_stop_ends_the_pass(void **state)
{
    (void)state;
    struct work *w = make_work(false, PBNDS_F32, true);
    const struct pbnds_pass pass = pass_of(N, false);
    struct pbnds_error error;
    pbnds_request_stop();
    assert_int_equal(pbnds_net_forward_view(w->net, &pass, w->view_in, NULL, &error),
                     PBNDS_ERROR_INTERRUPTED);
    free_work(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gradients_are_central_differences),
        cmocka_unit_test(test_agrees_with_torch),
        cmocka_unit_test(test_backends_agree),
        cmocka_unit_test(test_chunks_of_lights_equal_all_at_once),
        cmocka_unit_test(test_inference_equals_training_without_dropout),
        cmocka_unit_test(test_memory_is_reused),
        cmocka_unit_test(test_bf16_tracks_f32),
        cmocka_unit_test(test_same_bits_again),
        cmocka_unit_test(test_dropout_statistics),
        cmocka_unit_test(test_dropout_follows_the_key),
        cmocka_unit_test(test_init_is_kaiming),
        cmocka_unit_test(test_names_shapes_and_counts),
        cmocka_unit_test(test_bad_tables_are_refused),
        cmocka_unit_test(test_bad_passes_are_refused),
        cmocka_unit_test(test_a_stop_ends_the_pass),
    };
    pbnds_set_threads(1); /* other tests run beside this one */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
