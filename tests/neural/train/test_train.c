/* Training from a data set to a weights file: it learns, and stopping does not change
 * what comes out. Runs that are stopped or killed live in child processes. */
#include "tests/neural/data/fixture_data.h"

#include <signal.h>
#include <sys/wait.h>

#include "engine/core/parallel.h"
#include "engine/core/rng.h"
#include "engine/image/oiio.h"
#include "neural/model/safetensors.h"
#include "neural/train/curve.h"
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

/* Weights and what lies beside them. */
static void sweep(const char *weights)
{
    static const char *const ENDINGS[] = {"", ".csv", ".png", ".sheet.png",
                                          ".checkpoint"};
    for (size_t i = 0; i < sizeof ENDINGS / sizeof ENDINGS[0]; ++i) {
        char path[128];
        (void)snprintf(path, sizeof path, "%s%s", weights, ENDINGS[i]);
        (void)unlink(path);
    }
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
        sweep(weights);
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

/* Each model as it is, and with all that a step can have. */
static void stopping_changes_nothing(void **state)
{
    (void)state;
    static const char *const MODELS[] = {"transport", "pbnds+", "transport", "pbnds+"};
    for (int m = 0; m < 4; ++m) {
        struct pbnds_train_options whole =
            options_of("test_train_a.safetensors", MODELS[m]);
        if (m >= 2) {
            whole.weight_decay = 0.01;
            whole.ema = 0.9;
            whole.augment = true;
            whole.batch = whole.accumulate = 2;
            whole.checkpoint_every = 3;
        }
        struct pbnds_train_options parts = whole;
        parts.weights = "test_train_b.safetensors";
        train(&whole);
        parts.resume = true;
        train_until(&parts, 3, true);
        train_until(&parts, 5, false);
        train_until(&parts, 8, true);
        train(&parts);
        assert_true(fixture_same(whole.weights, parts.weights));
        sweep(whole.weights);
        sweep(parts.weights);
    }
}

/* A row of the curve, from 0. */
static struct pbnds_curve_row row_of(const char *weights, int i)
{
    char path[128];
    struct pbnds_curve_row *rows;
    int count;
    (void)snprintf(path, sizeof path, "%s.csv", weights);
    assert_int_equal(pbnds_curve_read(path, &rows, &count, NULL), PBNDS_OK);
    assert_true(i < count);
    const struct pbnds_curve_row row = rows[i];
    free(rows);
    return row;
}

/* Four views at once, or by one: the same steps, to rounding. */
static void accumulating_is_a_larger_batch(void **state)
{
    (void)state;
    static const char *const MODELS[] = {"transport", "pbnds+"};
    for (int m = 0; m < 2; ++m) {
        struct pbnds_train_options wide =
            options_of("test_train_a.safetensors", MODELS[m]);
        wide.steps = 3;
        wide.augment = true;
        wide.p_dark = 0.5;
        struct pbnds_train_options narrow = wide;
        wide.batch = 4;
        narrow.batch = 1;
        narrow.accumulate = 4;
        narrow.weights = "test_train_b.safetensors";
        train(&wide);
        train(&narrow);
        for (int i = 0; i < 3; ++i) {
            const struct pbnds_curve_row a = row_of(wide.weights, i),
                                         b = row_of(narrow.weights, i);
            /* Adam steps by the sign of a gradient, be it all rounding */
            const double tolerance = i == 0 ? 2e-6 : 2e-3;
            assert_near(b.loss / a.loss, 1.0, tolerance);
            assert_near(b.val_loss / a.val_loss, 1.0, 2e-3);
        }
        sweep(wide.weights);
        sweep(narrow.weights);
    }
}

/* The average of the weights is what is validated and written: another file than without,
 * from the same steps. */
static void the_average_is_written(void **state)
{
    (void)state;
    struct pbnds_train_options plain =
        options_of("test_train_a.safetensors", "transport");
    struct pbnds_train_options mean = plain;
    mean.weights = "test_train_b.safetensors";
    mean.ema = 0.99;
    train(&plain);
    train(&mean);
    for (int i = 0; i < 12; i += 11) {
        const struct pbnds_curve_row a = row_of(plain.weights, i),
                                     b = row_of(mean.weights, i);
        assert_true(a.loss == b.loss);
        assert_true(a.val_loss != b.val_loss);
    }
    sweep(plain.weights);
    sweep(mean.weights);
}

static void pictures_lie_beside_the_weights(void **state)
{
    (void)state;
    static const char *const MODELS[] = {"transport", "pbnds+"};
    for (int m = 0; m < 2; ++m) {
        struct pbnds_train_options options =
            options_of("test_train_a.safetensors", MODELS[m]);
        options.steps = 2;
        options.sheet_every = 100; /* at the end */
        train(&options);
        struct pbnds_image image;
        assert_int_equal(
            pbnds_image_read_rgb("test_train_a.safetensors.png", &image, NULL),
            PBNDS_OK);
        assert_true(image.width > 600);
        pbnds_image_free(&image);
        assert_int_equal(
            pbnds_image_read_rgb("test_train_a.safetensors.sheet.png", &image, NULL),
            PBNDS_OK);
        /* one sample of val: two pictures of 16 x 16 side by side, with labels */
        assert_true(image.width >= 2 * 16 && image.height > 16 && image.height < 60);
        pbnds_image_free(&image);
        sweep(options.weights);
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
    sweep("test_train_c.safetensors");
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
    sweep("test_train_c.safetensors");
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
    sweep("test_train_d.safetensors");
}

/* Makes every value of R of a sample's radiance x. */
static void plant(const char *sample, float x)
{
    char path[128];
    struct pbnds_exr exr;
    (void)snprintf(path, sizeof path, "%s/sample.exr", sample);
    assert_int_equal(pbnds_exr_read(path, &exr, NULL), PBNDS_OK);
    const struct pbnds_exr_channel *red = pbnds_exr_find(&exr, "R");
    assert_non_null(red);
    for (int i = 0; i < exr.width * exr.height; ++i)
        ((float *)red->data)[i] = x;
    for (int c = 0; c < exr.channel_count; ++c) {
        if (&exr.channels[c] == red) exr.channels[c].type = PBNDS_EXR_FLOAT;
    }
    assert_int_equal(pbnds_exr_write(path, &exr, NULL), PBNDS_OK);
    pbnds_exr_free(&exr);
}

/* The first step that draws a sample that no step before it drew, from `least` on. */
static int first_of_another(uint64_t seed, int count, int least, int *sample)
{
    for (int step = least;; ++step) {
        bool seen = false;
        for (int s = 0; s <= step; ++s) {
            struct pbnds_rng rng = pbnds_rng_make(seed, (uint64_t)s, 0);
            const int i = (int)(pbnds_rng_u64(&rng) % (uint64_t)count);
            if (s == step) {
                *sample = i;
            } else {
                struct pbnds_rng last = pbnds_rng_make(seed, (uint64_t)step, 0);
                seen |= i == (int)(pbnds_rng_u64(&last) % (uint64_t)count);
            }
        }
        if (!seen) return step;
    }
}

/* A target whose loss is infinite stops the run at the step that meets it, with the state
 * before it saved: when the sample is mended the run goes on, to the same end. */
static void an_infinite_target_stops_the_run(void **state)
{
    (void)state;
    struct pbnds_train_options whole =
        options_of("test_train_a.safetensors", "transport");
    struct pbnds_train_options hurt = whole;
    hurt.weights = "test_train_b.safetensors";
    hurt.ema = whole.ema = 0.9;
    train(&whole);
    int number = -1;
    const int step = first_of_another(whole.seed, 8, 3, &number);
    assert_true(step < whole.steps);
    char sample[64], kept[80], command[256], told[80];
    (void)snprintf(sample, sizeof sample, "%s/train/%06d", DATA, number);
    (void)snprintf(command, sizeof command, "cp %s/sample.exr test_train_kept.exr",
                   sample);
    assert_int_equal(system(command), 0);

    plant(sample, 3e38f); /* log(1 + 3 x) is infinite, x is not */
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_train(&hurt, NULL, &error), PBNDS_ERROR_BACKEND);
    (void)snprintf(told, sizeof told, "diverged at step %d", step);
    (void)snprintf(kept, sizeof kept, "the checkpoint of step %d is kept", step);
    assert_non_null(strstr(error.message, told));
    assert_non_null(strstr(error.message, kept));
    hurt.resume = true;
    plant(sample, INFINITY); /* of which the reader knows at once */
    assert_int_equal(pbnds_train(&hurt, NULL, &error), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, sample));

    (void)snprintf(command, sizeof command, "mv test_train_kept.exr %s/sample.exr",
                   sample);
    assert_int_equal(system(command), 0);
    train(&hurt);
    assert_true(fixture_same(whole.weights, hurt.weights));
    sweep(whole.weights);
    sweep(hurt.weights);
}

/* The tensors of two weights files; their provenance may differ. */
static void assert_same_tensors(const char *a, const char *b)
{
    struct pbnds_safetensors x, y;
    assert_int_equal(pbnds_safetensors_read(a, &x, NULL), PBNDS_OK);
    assert_int_equal(pbnds_safetensors_read(b, &y, NULL), PBNDS_OK);
    assert_int_equal(x.tensor_count, y.tensor_count);
    for (int i = 0; i < x.tensor_count; ++i) {
        assert_string_equal(x.tensors[i].name, y.tensors[i].name);
        assert_memory_equal(x.tensors[i].data, y.tensors[i].data,
                            x.tensors[i].count * sizeof(float));
    }
    pbnds_safetensors_free(&x);
    pbnds_safetensors_free(&y);
}

static void tar_files_train_the_same(void **state)
{
    (void)state;
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    recipe.format = PBNDS_DATASET_TAR;
    recipe.per_tar = 3;
    assert_int_equal(
        pbnds_dataset_make(&recipe, NULL, "test_train_tar", NULL, NULL, NULL),
        PBNDS_OK);
    struct pbnds_train_options folders =
        options_of("test_train_a.safetensors", "transport");
    struct pbnds_train_options tars = folders;
    tars.weights = "test_train_b.safetensors";
    tars.data = "test_train_tar";
    tars.max_memory = 1;
    train(&folders);
    train(&tars);
    assert_same_tensors(folders.weights, tars.weights);
    sweep(folders.weights);
    sweep(tars.weights);
    fixture_remove("test_train_tar");
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
    sweep("test_train_e.safetensors");
    sweep("test_train_f.safetensors");
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
    options.ema = 1.0;
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_ARGUMENT);
    options = options_of("x.safetensors", "transport");
    options.batch = 17;
    assert_int_equal(pbnds_train(&options, NULL, &error), PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "--accumulate"));
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
        cmocka_unit_test(accumulating_is_a_larger_batch),
        cmocka_unit_test(the_average_is_written),
        cmocka_unit_test(pictures_lie_beside_the_weights),
        cmocka_unit_test(an_infinite_target_stops_the_run),
        cmocka_unit_test(tar_files_train_the_same),
        cmocka_unit_test(memory_bounds_change_nothing),
        cmocka_unit_test(bad_requests_are_refused),
    };
    return cmocka_run_group_tests_name("neural/train/train", tests, setup, teardown);
}
