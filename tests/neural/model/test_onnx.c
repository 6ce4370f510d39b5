/* neural/model/onnx.c: what was written, decoded and evaluated by others, gives the numbers
 * of the network itself. The oracles are onnx_numpy.py (python3; numpy) and onnx_runtime.js
 * (node with onnxruntime-node in NODE_PATH); each is skipped where it is absent. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/rng.h"
#include "neural/model/onnx.h"

#define HERE PBNDS_SOURCE_DIR "/tests/neural/model/"

enum { LIGHTS = 3, HEIGHT = 32, WIDTH = 16 };

static struct pbnds_backend *backend;

/* Every op and every way through it: stride 2 with kernels 2 and 3, a view tensor into Add
 * and into Concat on either side, Concat within the view, dropout within and at the end, an
 * output below full resolution, and a row that nobody needs. */
enum {
    T_VIEW,
    T_DOWN3,
    T_POOL,
    T_JOIN,
    T_DROP,
    T_SIDE,
    T_LIGHT,
    T_L2,
    T_CAT_LV,
    T_CAT_VL,
    T_MIX,
    T_UP,
    T_SUM,
    T_WIDE,
    T_SHUFFLE,
    T_BOTH,
    T_LAST,
    T_UNUSED,
    T_END,
};
#define ROW(NAME, OP, A, B, ...)                                                       \
    {                                                                                  \
        .name = NAME, .op = PBNDS_OP_##OP, .in = {A, B}, __VA_ARGS__                   \
    }
static const struct pbnds_layer EVERY_OP[] = {
    [T_VIEW] = ROW("in.view", VIEW_INPUT, -1, -1, .channels = 5),
    [T_DOWN3] = ROW("down3", CONV, T_VIEW, -1, .channels = 6, .kernel = 3, .stride = 2,
                    .act = PBNDS_ACT_RELU),
    [T_POOL] = ROW("pool", POOL, T_DOWN3, -1, .channels = 0),
    [T_JOIN] = ROW("join", CONCAT, T_POOL, T_POOL, .channels = 0),
    [T_DROP] = ROW("drop", DROPOUT, T_JOIN, -1, .rate = 0.5f),
    [T_SIDE] = ROW("side", CONV, T_DROP, -1, .channels = 4, .kernel = 1, .stride = 1),
    [T_LIGHT] = ROW("in.light", LIGHT_INPUT, -1, -1, .channels = 3),
    [T_L2] = ROW("l2", CONV, T_LIGHT, -1, .channels = 7, .kernel = 2, .stride = 2),
    [T_CAT_LV] = ROW("cat.lv", CONCAT, T_L2, T_DOWN3, .channels = 0),
    [T_CAT_VL] = ROW("cat.vl", CONCAT, T_DOWN3, T_CAT_LV, .channels = 0),
    [T_MIX] = ROW("mix", CONV, T_CAT_VL, -1, .channels = 6, .kernel = 3, .stride = 1,
                  .act = PBNDS_ACT_RELU),
    [T_UP] = ROW("up", UP, T_MIX, -1, .channels = 8, .act = PBNDS_ACT_RELU),
    [T_SUM] = ROW("sum", ADD, T_MIX, T_DOWN3, .act = PBNDS_ACT_RELU),
    [T_WIDE] = ROW("wide", CONV, T_SUM, -1, .channels = 12, .kernel = 1, .stride = 1),
    [T_SHUFFLE] = ROW("shuffle", SHUFFLE, T_WIDE, -1, .channels = 0),
    [T_BOTH] = ROW("both", CONCAT, T_SHUFFLE, T_UP, .channels = 0),
    [T_LAST] = ROW("last", DROPOUT, T_BOTH, -1, .rate = 0.1f),
    [T_UNUSED] =
        ROW("unused", CONV, T_SUM, -1, .channels = 2, .kernel = 1, .stride = 1),
};

struct problem {
    struct pbnds_net *net;
    const struct pbnds_model *model;
    size_t view_in, light_in, light_out, view_out; /* floats */
    float *in, *out;
};

static struct problem make_problem(const struct pbnds_model *model)
{
    struct problem p = {.model = model};
    struct pbnds_error error = {""};
    if (pbnds_net_create(&model->table, backend, PBNDS_F32, &p.net, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    pbnds_net_init(p.net, 7);
    struct pbnds_rng rng = pbnds_rng_make(11, 0, 0);
    for (int i = 1; i < pbnds_net_tensor_count(p.net); i += 2) { /* biases too */
        const struct pbnds_param *b = pbnds_net_param(p.net, i);
        for (size_t k = 0; k < b->count; ++k)
            pbnds_net_params(p.net)[b->offset + k] = pbnds_rng_float(&rng) - 0.5f;
    }
    pbnds_net_params_changed(p.net);
    const size_t pixels = (size_t)HEIGHT * WIDTH;
    p.view_in = pixels * (size_t)model->view_channels;
    p.light_in = LIGHTS * pixels * (size_t)model->light_channels;
    const int ends[2] = {model->table.light_output, model->table.view_output};
    for (int i = 0; i < 2; ++i) {
        if (ends[i] < 0) continue;
        const struct pbnds_row_facts f = pbnds_net_row_facts(p.net, ends[i]);
        const size_t count = (pixels >> (2 * f.level)) * (size_t)f.channels;
        *(i ? &p.view_out : &p.light_out) = i ? count : LIGHTS * count;
    }
    p.in = malloc((p.view_in + p.light_in) * sizeof *p.in);
    p.out = malloc((p.light_out + p.view_out) * sizeof *p.out);
    assert_non_null(p.in);
    assert_non_null(p.out);
    for (size_t i = 0; i < p.view_in + p.light_in; ++i)
        p.in[i] = 2.0f * pbnds_rng_float(&rng) - 1.0f;
    const struct pbnds_pass pass = {
        .batch = 1, .lights = LIGHTS, .h = HEIGHT, .w = WIDTH};
    assert_int_equal(pbnds_net_forward_view(p.net, &pass, p.in,
                                            p.view_out ? p.out + p.light_out : NULL,
                                            NULL),
                     PBNDS_OK);
    assert_int_equal(
        pbnds_net_forward_light(p.net, &pass, p.in + p.view_in, p.out, NULL), PBNDS_OK);
    return p;
}

static void free_problem(struct problem *p)
{
    pbnds_net_free(p->net);
    free(p->in);
    free(p->out);
}

static int shell(const char *command)
{
    const int ran = system(command);
    return ran >= 0 && WIFEXITED(ran) ? WEXITSTATUS(ran) : -1;
}

static void put_inputs(const struct problem *p, const char *path)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    const size_t count = p->view_in + p->light_in;
    assert_int_equal(fwrite(p->in, sizeof *p->in, count, f), count);
    assert_int_equal(fclose(f), 0);
}

/* The oracle's outputs against ours. */
static void compare_outputs(const struct problem *p, const char *path)
{
    const size_t count = p->light_out + p->view_out;
    float *theirs = malloc((count + 1) * sizeof *theirs);
    FILE *f = fopen(path, "rb");
    assert_non_null(theirs);
    assert_non_null(f);
    assert_int_equal(fread(theirs, sizeof *theirs, count + 1, f), count);
    assert_int_equal(fclose(f), 0);
    double most = 0.0, spread = 0.0;
    for (size_t i = 0; i < count; ++i) {
        most = fmax(most, fabs((double)theirs[i] - (double)p->out[i]));
        spread = fmax(spread, fabs((double)p->out[i]));
    }
    free(theirs);
    assert_true(spread > 0.1); /* there is something to compare */
    assert_near(most, 0.0, 1e-4);
}

/* true: `tool` was there and agreed. */
static bool oracle_agrees(const struct pbnds_model *model, const char *tool,
                          const char *sizes)
{
    struct problem p = make_problem(model);
    char onnx[128], in[128], out[128], command[1024];
    (void)snprintf(onnx, sizeof onnx, "test_onnx_%d.onnx", (int)getpid());
    (void)snprintf(in, sizeof in, "test_onnx_%d.in", (int)getpid());
    (void)snprintf(out, sizeof out, "test_onnx_%d.out", (int)getpid());
    struct pbnds_error error = {""};
    char key[] = "k", value[] = "\"v\" \xc3\xa9";
    const struct pbnds_metadata extra = {key, value};
    if (pbnds_onnx_write(onnx, model, p.net, &extra, 1, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    put_inputs(&p, in);
    (void)snprintf(command, sizeof command, "%s %s %s %s %s 2>test_onnx.log", tool,
                   onnx, in, out, sizes);
    const int code = shell(command);
    if (code == 0) compare_outputs(&p, out);
    (void)remove(onnx);
    (void)remove(in);
    (void)remove(out);
    free_problem(&p);
    if (code == 77 || code == 127) return false;
    if (code != 0) fail_msg("%s: status %d, see test_onnx.log", command, code);
    return true;
}

static bool numpy_agrees(const struct pbnds_model *model)
{
    char sizes[64];
    (void)snprintf(sizes, sizeof sizes, "%d %d %d", LIGHTS, HEIGHT, WIDTH);
    return oracle_agrees(model, "/usr/bin/python3 " HERE "onnx_numpy.py", sizes);
}

static bool runtime_agrees(const struct pbnds_model *model)
{
    char sizes[64];
    (void)snprintf(sizes, sizeof sizes, "%d %d %d %d", model->view_channels, LIGHTS,
                   HEIGHT, WIDTH);
    return oracle_agrees(model, "node " HERE "onnx_runtime.js", sizes);
}

static struct pbnds_model every_op(int light_output, int view_output)
{
    return (struct pbnds_model){
        .name = "every-op",
        .version = 1,
        .table = {EVERY_OP, T_END, light_output, view_output},
        .view_channels = 5,
        .light_channels = 3,
    };
}

static void every_op_agrees(void **state, bool (*agrees)(const struct pbnds_model *))
{
    (void)state;
    const int ends[][2] = {{T_BOTH, T_SIDE}, {T_SUM, -1}, {T_LAST, T_DROP}};
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; ++i) {
        const struct pbnds_model model = every_op(ends[i][0], ends[i][1]);
        if (!agrees(&model)) skip();
    }
}

static void shipped_agree(void **state, bool (*agrees)(const struct pbnds_model *))
{
    (void)state;
    if (!agrees(pbnds_model_find("transport"))) skip();
    if (!agrees(pbnds_model_find("pbnds+"))) skip();
}

static void every_op_agrees_with_numpy(void **state)
{
    every_op_agrees(state, numpy_agrees);
}

static void shipped_models_agree_with_numpy(void **state)
{
    shipped_agree(state, numpy_agrees);
}

static void every_op_agrees_with_onnx_runtime(void **state)
{
    every_op_agrees(state, runtime_agrees);
}

static void shipped_models_agree_with_onnx_runtime(void **state)
{
    shipped_agree(state, runtime_agrees);
}

static void what_cannot_be_written_is_said(void **state)
{
    (void)state;
    struct problem p = make_problem(pbnds_model_find("transport"));
    struct pbnds_error error = {""};
    assert_int_equal(
        pbnds_onnx_write("no/such/folder/x.onnx", p.model, p.net, NULL, 0, &error),
        PBNDS_ERROR_IO);
    assert_non_null(strstr(error.message, "no/such/folder"));
    free_problem(&p);
}

int main(void)
{
    if (pbnds_backend_create_onednn(&backend, NULL) != PBNDS_OK) return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_op_agrees_with_numpy),
        cmocka_unit_test(shipped_models_agree_with_numpy),
        cmocka_unit_test(every_op_agrees_with_onnx_runtime),
        cmocka_unit_test(shipped_models_agree_with_onnx_runtime),
        cmocka_unit_test(what_cannot_be_written_is_said),
    };
    const int failed =
        cmocka_run_group_tests_name("neural/model/onnx", tests, NULL, NULL);
    pbnds_backend_free(backend);
    return failed;
}
