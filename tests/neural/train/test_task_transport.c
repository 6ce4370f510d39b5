/* What training minimises is what the shading pass renders: the same sample, the same
 * weights, the same error. A gradient test cannot see the two drift apart. */
#include "tests/neural/data/fixture_data.h"

#include "engine/shade/shader.h"
#include "neural/shader_neural.h"
#include "neural/train/batch.h"

static char folder_of_assets[] = "test_task_assets";
static struct pbnds_dataset_source ROOT[] = {{folder_of_assets, 0.0}};
static const char *const WEIGHTS = "test_task.safetensors";

static double rendered_error(const struct pbnds_sample *sample)
{
    const struct pbnds_shader *shader;
    assert_int_equal(pbnds_shader_neural_create(WEIGHTS, PBNDS_F32, &shader, NULL),
                     PBNDS_OK);
    const struct pbnds_shade_job job = {
        .gbuffer = &sample->gbuffer, .envmap = sample->envmap, .shadows = -1};
    struct pbnds_image image;
    assert_int_equal(pbnds_shade(shader, &job, &image, NULL), PBNDS_OK);
    double sum = 0.0;
    int covered = 0;
    for (size_t i = 0; i < 32u * 32u; ++i) {
        if (!(sample->gbuffer.coverage[i] > 0.0f)) continue;
        sum +=
            pbnds_task_display_error(image.data + 3 * i, sample->radiance.data + 3 * i);
        ++covered;
    }
    pbnds_image_free(&image);
    pbnds_shader_neural_free(shader);
    return sum / (3.0 * covered);
}

static void training_and_rendering_agree(void **state)
{
    (void)state;
    assert_int_equal(system("rm -rf test_task_*"), 0);
    fixture_assets(folder_of_assets);
    const struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 2);
    assert_int_equal(
        pbnds_dataset_make(&recipe, NULL, "test_task_data", NULL, NULL, NULL),
        PBNDS_OK);
    const struct pbnds_task_ops *ops = &pbnds_task_transport;
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    assert_int_equal(pbnds_backend_create_onednn(&backend, NULL), PBNDS_OK);
    assert_int_equal(
        pbnds_net_create(&ops->model->table, backend, PBNDS_F32, &net, NULL), PBNDS_OK);
    pbnds_net_init(net, 3);
    assert_int_equal(pbnds_weights_save(WEIGHTS, ops->model, net, NULL, 0, NULL),
                     PBNDS_OK);

    const char *folder = "test_task_data/train/000000";
    struct pbnds_train_item item;
    struct pbnds_sample sample;
    assert_int_equal(pbnds_train_item_load(folder, true, &item, NULL), PBNDS_OK);
    assert_int_equal(pbnds_sample_load(folder, 0, &sample, NULL), PBNDS_OK);
    const struct pbnds_task task = {.model = ops->model,
                                    .lights = PBNDS_DATASET_LIGHTS};
    struct pbnds_batch batch;
    assert_int_equal(pbnds_batch_init(&batch, ops, &task, net, 1, 32, 0, NULL),
                     PBNDS_OK);
    const struct pbnds_task_view view = {.item = &item, .window = {0, 0, 32, 32}};
    struct pbnds_task_loss loss;
    assert_int_equal(pbnds_batch_run(&batch, &view, false, 0, &loss, NULL), PBNDS_OK);
    const double rendered = rendered_error(&sample);
    assert_true(rendered > 1e-5);
    assert_near(loss.mse, rendered, 1e-4 * rendered);

    pbnds_batch_free(&batch);
    pbnds_train_item_free(&item);
    pbnds_sample_free(&sample);
    pbnds_net_free(net);
    pbnds_backend_free(backend);
    fixture_remove(folder_of_assets);
    fixture_remove("test_task_data");
    fixture_remove(WEIGHTS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(training_and_rendering_agree)};
    return cmocka_run_group_tests_name("neural/train/task_transport", tests, NULL,
                                       NULL);
}
