/* A whole training step of each model (inputs, network, loss, gradient of every parameter)
 * against PyTorch in double (step_torch.py). Skipped where there is no torch. */
#include "tests/neural/fixture.h"

#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

#include "neural/train/batch.h"
#include "neural/transport.h"

enum { VIEWS = 2, CROP = 16, SIZE = 24 };

/* A sample made by hand. Its targets are far from any prediction: no kink of an L1. */
static struct pbnds_train_item make_item(void)
{
    struct pbnds_gbuffer g = fixture_walls(SIZE, SIZE);
    struct pbnds_train_item item = {.loaded = true};
    assert_int_equal(pbnds_view_create(&g, &item.view, NULL), PBNDS_OK);
    pbnds_gbuffer_free(&g);
    item.envmap = fixture_env(1.0f, 11);
    item.light_count =
        pbnds_envmap_cluster(item.envmap, PBNDS_DATASET_LIGHTS, item.lights);
    const size_t count = (size_t)SIZE * SIZE;
    item.radiance = calloc(3 * count, sizeof(float));
    item.direct = calloc(3 * count, sizeof(float));
    item.specular = calloc(3 * count, sizeof(float));
    item.visibility = calloc(count, sizeof(uint32_t));
    item.march.thin = calloc(count, sizeof(uint32_t));
    item.march.thick = calloc(count, sizeof(uint32_t));
    struct pbnds_vec3 wi[PBNDS_DATASET_LIGHTS];
    for (int k = 0; k < PBNDS_DATASET_LIGHTS; ++k)
        wi[k] = item.lights[k].wi;
    pbnds_view_march(&item.view, wi, PBNDS_DATASET_LIGHTS, &item.march);
    struct pbnds_rng rng = pbnds_rng_make(3, 0, 0);
    for (size_t i = 0; i < count; ++i) {
        item.visibility[i] = (uint32_t)pbnds_rng_u64(&rng);
        for (size_t c = 0; c < 3; ++c) {
            item.specular[3 * i + c] = pbnds_rng_float(&rng);
            item.direct[3 * i + c] = i % 2 ? 40.0f : 0.0f;
            item.radiance[3 * i + c] = i % 2 ? 90.0f : i % 4 ? 0.6f : 0.0f;
        }
    }
    return item;
}

struct step {
    struct pbnds_layer layers[128]; /* the model's, without dropout: masks are random */
    struct pbnds_net_table table;
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    struct pbnds_train_item item;
    struct pbnds_batch batch;
    struct pbnds_task_view views[VIEWS];
    double loss;
};

static void run_step(struct step *s, const struct pbnds_task_ops *ops, int lights)
{
    *s = (struct step){.table = ops->model->table};
    assert_true(s->table.layer_count <= 128);
    for (int r = 0; r < s->table.layer_count; ++r) {
        s->layers[r] = ops->model->table.layers[r];
        s->layers[r].rate = 0.0f;
    }
    s->table.layers = s->layers;
    assert_int_equal(pbnds_backend_create_onednn(&s->backend, NULL), PBNDS_OK);
    assert_int_equal(pbnds_net_create(&s->table, s->backend, PBNDS_F32, &s->net, NULL),
                     PBNDS_OK);
    pbnds_net_init(s->net, 5);
    s->item = make_item();
    const struct pbnds_task task = {.model = ops->model, .lights = lights};
    assert_int_equal(
        pbnds_batch_init(&s->batch, ops, &task, s->net, VIEWS, CROP, lights, NULL),
        PBNDS_OK);
    for (int v = 0; v < VIEWS; ++v) {
        s->views[v] = (struct pbnds_task_view){.item = &s->item,
                                               .window = {4 * v, 3, CROP, CROP},
                                               .key = 77u + (uint64_t)v,
                                               .train = true};
    }
    struct pbnds_task_loss loss;
    pbnds_net_zero_grads(s->net);
    assert_int_equal(pbnds_batch_run(&s->batch, s->views, true, 9, &loss, NULL),
                     PBNDS_OK);
    s->loss = loss.total;
}

static void free_step(struct step *s)
{
    pbnds_batch_free(&s->batch);
    pbnds_train_item_free(&s->item);
    pbnds_net_free(s->net);
    pbnds_backend_free(s->backend);
}

static void put(FILE *f, const float *values, size_t count)
{
    assert_int_equal(fwrite(values, sizeof *values, count, f), count);
}

static void put_vec(FILE *f, struct pbnds_vec3 v)
{
    put(f, (const float[]){v.x, v.y, v.z}, 3);
}

/* Pixel i of the crop of view v in the sample. */
static size_t source_of(const struct step *s, int v, int i)
{
    const struct pbnds_window w = s->views[v].window;
    return (size_t)(w.y + i / CROP) * SIZE + (size_t)(w.x + i % CROP);
}

static void put_plane(FILE *f, const struct step *s, const float *plane,
                      size_t channels)
{
    for (int v = 0; v < VIEWS; ++v) {
        for (int i = 0; i < CROP * CROP; ++i)
            put(f, plane + channels * source_of(s, v, i), channels);
    }
}

/* What each light gives: (f_diffuse + w f_specular) E max(n.l, 0), E B, is it seen. */
static void put_lights(FILE *f, const struct step *s, int what)
{
    const struct pbnds_train_item *item = &s->item;
    for (int v = 0; v < VIEWS; ++v) {
        for (int k = 0; k < PBNDS_DATASET_LIGHTS; ++k) {
            const struct pbnds_vec3 wi =
                pbnds_camera_from_world_vector(&item->view.camera, item->lights[k].wi);
            for (int i = 0; i < CROP * CROP; ++i) {
                const size_t at = source_of(s, v, i);
                const struct pbnds_transport_pixel p =
                    pbnds_transport_pixel(&item->view, at);
                const struct pbnds_vec3 power = item->lights[k].power;
                const float seen = (float)(item->visibility[at] >> k & 1u);
                struct pbnds_vec3 a = pbnds_splat(0.0f);
                if (p.covered) a = pbnds_mul(power, pbnds_transport_direct(&p, wi));
                if (what == 0) put_vec(f, a);
                if (what == 1) put_vec(f, pbnds_mul(power, p.b));
                if (what == 2) put(f, &seen, 1);
            }
        }
    }
}

static void put_problem(const struct step *s, bool transport, const char *table_path,
                        const char *in_path)
{
    FILE *table = fopen(table_path, "w"), *in = fopen(in_path, "wb");
    assert_non_null(table);
    assert_non_null(in);
    const int lights = s->batch.task.lights;
    (void)fprintf(table, "%d %d %d %d %d %d\n", VIEWS, lights, CROP, CROP,
                  s->table.light_output, s->table.view_output);
    for (int r = 0; r < s->table.layer_count; ++r) {
        const struct pbnds_layer *l = &s->layers[r];
        (void)fprintf(table, "%d %d %d %d %d %d %d\n", (int)l->op, l->in[0], l->in[1],
                      l->channels, l->kernel, l->stride, l->act == PBNDS_ACT_RELU);
    }
    const struct pbnds_model *model = s->batch.task.model;
    const size_t pixels = (size_t)VIEWS * CROP * CROP;
    put(in, pbnds_net_params(s->net), pbnds_net_param_count(s->net));
    put(in, s->batch.view_input, pixels * (size_t)model->view_channels);
    put(in, s->batch.light_input,
        pixels * (size_t)lights * (size_t)model->light_channels);
    for (int v = 0; v < VIEWS; ++v) {
        for (int i = 0; i < CROP * CROP; ++i) {
            const float mask = s->item.view.plane[PBNDS_PLANE_MASK][source_of(s, v, i)];
            put(in, &(float){mask > 0.0f ? 1.0f : 0.0f}, 1);
        }
    }
    put_plane(in, s, s->item.radiance, 3);
    if (transport) {
        put_plane(in, s, s->item.direct, 3);
        put_plane(in, s, s->item.specular, 3);
        for (int what = 0; what < 3; ++what)
            put_lights(in, s, what);
    }
    assert_int_equal(fclose(table), 0);
    assert_int_equal(fclose(in), 0);
}

/* Largest difference of a tensor's gradient over its largest element. */
static double gradients_apart(const struct step *s, const float *theirs)
{
    double worst = 0.0;
    for (int t = 0; t < pbnds_net_tensor_count(s->net); ++t) {
        const struct pbnds_param *p = pbnds_net_param(s->net, t);
        const float *ours = pbnds_net_grads(s->net) + p->offset;
        double most = 0.0, apart = 0.0;
        for (size_t i = 0; i < p->count; ++i) {
            const double x = (double)theirs[p->offset + i];
            most = fmax(most, fabs(x));
            apart = fmax(apart, fabs(x - (double)ours[i]));
        }
        if (most == 0.0) fail_msg("%s: no gradient", p->name);
        worst = fmax(worst, apart / most);
    }
    return worst;
}

static void step_agrees(const struct pbnds_task_ops *ops, int lights)
{
    struct step *s = malloc(sizeof *s);
    assert_non_null(s);
    run_step(s, ops, lights);
    const char *table = "test_step.table", *in = "test_step.in", *out = "test_step.out";
    put_problem(s, ops->transport, table, in);
    char command[512];
    (void)snprintf(command, sizeof command,
                   "/usr/bin/python3 " PBNDS_SOURCE_DIR
                   "/tests/neural/train/step_torch.py %s %s %s %s 2>test_step.log",
                   ops->model->name, table, in, out);
    const int ran = system(command);
    const int code = ran >= 0 && WIFEXITED(ran) ? WEXITSTATUS(ran) : -1;
    const bool absent = code == 77 || code == 127; /* no torch, no python */
    if (!absent) {
        if (code != 0) fail_msg("%s: status %d, see test_step.log", command, code);
        const size_t count = 1 + pbnds_net_param_count(s->net);
        float *theirs = malloc(count * sizeof *theirs);
        FILE *f = fopen(out, "rb");
        assert_non_null(f);
        assert_non_null(theirs);
        assert_int_equal(fread(theirs, sizeof *theirs, count, f), count);
        assert_int_equal(fclose(f), 0);
        assert_true(s->loss > 0.01);
        assert_near(s->loss / (double)theirs[0], 1.0, 1e-6);
        assert_near(gradients_apart(s, theirs + 1), 0.0, 1e-5);
        free(theirs);
    }
    (void)remove(table);
    (void)remove(in);
    (void)remove(out);
    free_step(s);
    free(s);
    if (absent) skip();
}

static void transport_step_is_torchs(void **state)
{
    (void)state;
    step_agrees(&pbnds_task_transport, PBNDS_DATASET_LIGHTS);
}

static void pbnds_plus_step_is_torchs(void **state)
{
    (void)state;
    step_agrees(&pbnds_task_pbnds_plus, 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transport_step_is_torchs),
        cmocka_unit_test(pbnds_plus_step_is_torchs),
    };
    return cmocka_run_group_tests_name("neural/train/step", tests, NULL, NULL);
}
