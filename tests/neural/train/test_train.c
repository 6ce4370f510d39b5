/* Training from a data set to a weights file: it learns, and stopping does not change
 * what comes out. Runs that are stopped or killed live in child processes. */
#include "tests/neural/data/fixture_data.h"

#include <signal.h>
#include <sys/wait.h>

#include "engine/core/parallel.h"
#include "neural/train/train.h"

static char folder_of_assets[] = "test_train_assets";
static struct pbnds_dataset_source ROOT[] = {{folder_of_assets, 0.0}};
static const char *const DATA = "test_train_data";

static struct pbnds_train_options options_of(const char *weights, const char *model)
{
    return (struct pbnds_train_options){.data = DATA,
                                        .weights = weights,
                                        .model = model,
                                        .steps = 12,
                                        .crop = 16,
                                        .lr = 2e-3,
                                        .lights = strcmp(model, "pbnds+") == 0 ? 4 : 0,
                                        .p_dark = -1.0,
                                        .lambda_zero = -1.0,
                                        .seed = 5,
                                        .dtype = PBNDS_F32};
}

static int setup(void **state)
{
    (void)state;
    pbnds_set_threads(1);
    if (system("rm -rf test_train_*") != 0) return -1; /* of a run that was killed */
    fixture_assets(folder_of_assets);
    const struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    return pbnds_dataset_make(&recipe, NULL, DATA, NULL, NULL, NULL) == PBNDS_OK ? 0
                                                                                 : -1;
}

static int teardown(void **state)
{
    (void)state;
    fixture_remove(folder_of_assets);
    fixture_remove(DATA);
    return 0;
}

static void train(const struct pbnds_train_options *options)
{
    struct pbnds_error error = {{0}};
    if (pbnds_train(options, NULL, &error) != PBNDS_OK) fail_msg("%s", error.message);
}

/* Last column but one and last of the curve's first and last rows: validation loss,
 * PSNR. */
static void curve_ends(const char *path, double *first, double *last, int *rows)
{
    uint8_t *text;
    size_t size;
    assert_int_equal(pbnds_file_read(path, 1u << 20, &text, &size, NULL), PBNDS_OK);
    *rows = 0;
    for (char *line = strtok((char *)text, "\n"); line; line = strtok(NULL, "\n")) {
        double step, seconds, lr, loss, train_psnr, val_loss, val_psnr;
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf,%lf", &step, &seconds, &lr, &loss,
                   &train_psnr, &val_loss, &val_psnr) != 7) {
            continue;
        }
        if (++*rows == 1) *first = val_loss;
        *last = val_loss;
    }
    free(text);
}

static void both_models_learn(void **state)
{
    (void)state;
    static const char *const MODELS[] = {"transport", "pbnds+"};
    for (int m = 0; m < 2; ++m) {
        const char *weights = "test_train_learn.safetensors";
        struct pbnds_train_options options = options_of(weights, MODELS[m]);
        options.steps = 60;
        train(&options);
        double first = 0.0, last = 1e9;
        int rows;
        curve_ends("test_train_learn.safetensors.csv", &first, &last, &rows);
        assert_int_equal(rows, 60);
        assert_true(last < 0.8 * first);
        assert_int_equal(access(weights, F_OK), 0);
        assert_int_not_equal(access("test_train_learn.safetensors.checkpoint", F_OK),
                             0);
        (void)unlink(weights);
        (void)unlink("test_train_learn.safetensors.csv");
    }
}

static void kill_self(void *user, const char *stage, double done, double total)
{
    (void)stage;
    (void)total;
    if ((int)done == *(const int *)user) (void)raise(SIGKILL);
}

static void stop_self(void *user, const char *stage, double done, double total)
{
    (void)stage;
    (void)total;
    if ((int)done == *(const int *)user) pbnds_request_stop();
}

/* Trains in a child that dies (or is asked to stop) after `step` steps. */
static void train_until(const struct pbnds_train_options *options, int step, bool kill)
{
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const struct pbnds_report report = {.progress = kill ? kill_self : stop_self,
                                            .user = &step};
        const enum pbnds_status status = pbnds_train(options, &report, NULL);
        _exit(status == PBNDS_ERROR_INTERRUPTED ? 42 : 43);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    if (kill) {
        assert_true(WIFSIGNALED(status));
    } else {
        assert_int_equal(WEXITSTATUS(status), 42);
    }
}

static void stopping_changes_nothing(void **state)
{
    (void)state;
    static const char *const MODELS[] = {"transport", "pbnds+"};
    for (int m = 0; m < 2; ++m) {
        struct pbnds_train_options whole =
            options_of("test_train_a.safetensors", MODELS[m]);
        struct pbnds_train_options parts =
            options_of("test_train_b.safetensors", MODELS[m]);
        train(&whole);
        parts.resume = true;
        train_until(&parts, 3, true);
        train_until(&parts, 5, false);
        train_until(&parts, 8, true);
        train(&parts);
        assert_true(fixture_same(whole.weights, parts.weights));
        static const char *const LEFT[] = {"a.safetensors", "b.safetensors",
                                           "a.safetensors.csv", "b.safetensors.csv"};
        for (int k = 0; k < 4; ++k) {
            char path[64];
            (void)snprintf(path, sizeof path, "test_train_%s", LEFT[k]);
            (void)unlink(path);
        }
    }
}

/* Neither an unfinished run nor finished weights are overwritten in silence. */
static void earlier_work_is_kept(void **state)
{
    (void)state;
    struct pbnds_train_options options =
        options_of("test_train_c.safetensors", "transport");
    train_until(&options, 3, true);
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "--resume"));
    options.resume = true;
    train(&options);
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "finished run"));
    fixture_remove("test_train_c.safetensors");
    fixture_remove("test_train_c.safetensors.csv");
}

static void a_checkpoint_of_another_run_is_refused(void **state)
{
    (void)state;
    struct pbnds_train_options options =
        options_of("test_train_c.safetensors", "transport");
    options.resume = true;
    train_until(&options, 3, true);
    options.lr = 1e-3;
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "other options"));
    fixture_remove("test_train_c.safetensors.checkpoint");
    fixture_remove("test_train_c.safetensors");
    fixture_remove("test_train_c.safetensors.csv");
}

static void divergence_keeps_the_last_checkpoint(void **state)
{
    (void)state;
    struct pbnds_train_options options =
        options_of("test_train_d.safetensors", "transport");
    options.lr = 1e18;
    options.steps = 400;
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_BACKEND);
    assert_non_null(strstr(error.message, "diverged at step"));
    fixture_remove("test_train_d.safetensors");
    fixture_remove("test_train_d.safetensors.checkpoint");
    fixture_remove("test_train_d.safetensors.csv");
}

/* With room for one sample at a time the numbers are the same. */
static void memory_bounds_change_nothing(void **state)
{
    (void)state;
    struct pbnds_train_options whole =
        options_of("test_train_e.safetensors", "transport");
    struct pbnds_train_options tight =
        options_of("test_train_f.safetensors", "transport");
    tight.max_memory = 1;
    train(&whole);
    train(&tight);
    assert_true(fixture_same(whole.weights, tight.weights));
    fixture_remove("test_train_e.safetensors");
    fixture_remove("test_train_e.safetensors.csv");
    fixture_remove("test_train_f.safetensors");
    fixture_remove("test_train_f.safetensors.csv");
}

static void bad_requests_are_refused(void **state)
{
    (void)state;
    struct pbnds_error error = {{0}};
    struct pbnds_train_options options = options_of("x.safetensors", "no-such-model");
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "no-such-model"));
    options.model = "nds";
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_UNSUPPORTED);
    options = options_of("x.safetensors", "transport");
    options.data = "test_train_nowhere";
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_IO);
    options = options_of("no/such/folder/x.safetensors", "transport");
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_IO);
    assert_non_null(strstr(error.message, "no/such/folder"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_models_learn),
        cmocka_unit_test(stopping_changes_nothing),
        cmocka_unit_test(earlier_work_is_kept),
        cmocka_unit_test(a_checkpoint_of_another_run_is_refused),
        cmocka_unit_test(divergence_keeps_the_last_checkpoint),
        cmocka_unit_test(memory_bounds_change_nothing),
        cmocka_unit_test(bad_requests_are_refused),
    };
    return cmocka_run_group_tests_name("neural/train/train", tests, setup, teardown);
}
