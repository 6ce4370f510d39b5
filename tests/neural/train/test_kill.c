/* Training bears kills: a run killed at random moments, again and again, ends with the bytes
 * of one that was left alone. */
#include "tests/neural/data/fixture_data.h"

#include <signal.h>
#include <sys/wait.h>
#include <time.h>

#include "engine/core/parallel.h"
#include "neural/train/curve.h"
#include "neural/train/train.h"

#if defined(__SANITIZE_ADDRESS__)
enum { KILLS = 12 };
#else
enum { KILLS = 200 };
#endif

static char folder_of_assets[] = "test_kill_assets";
static struct pbnds_dataset_source ROOT[] = {{folder_of_assets, 0.0}};
static const char *const DATA = "test_kill_data";
static uint32_t chance = 1;

static struct pbnds_train_options options_of(const char *weights)
{
    return (struct pbnds_train_options){.data = DATA,
                                        .weights = weights,
                                        .model = "transport",
                                        .steps = 40,
                                        .accumulate = 2,
                                        .crop = 16,
                                        .lr = 2e-3,
                                        .weight_decay = 0.01,
                                        .ema = 0.9,
                                        .augment = true,
                                        .p_dark = -1.0,
                                        .lambda_zero = -1.0,
                                        .seed = 5,
                                        .resume = true,
                                        .checkpoint_every = 1,
                                        .sheet_every = 7,
                                        .dtype = PBNDS_F32};
}

static int setup(void **state)
{
    (void)state;
    pbnds_set_threads(1);
    if (system("rm -rf test_kill_*") != 0) return -1;
    fixture_assets(folder_of_assets);
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, 10);
    recipe.width = recipe.height = 16;
    return pbnds_dataset_make(&recipe, NULL, DATA, NULL, NULL, NULL) == PBNDS_OK ? 0
                                                                                 : -1;
}

static int teardown(void **state)
{
    (void)state;
    return system("rm -rf test_kill_*") == 0 ? 0 : -1;
}

static pid_t start(const char *weights)
{
    (void)fflush(NULL);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0) return child;
    const struct pbnds_train_options options = options_of(weights);
    struct pbnds_error error;
    (void)pbnds_file_set_sync(false); /* a kill takes no power from the disk */
    const enum pbnds_status status = pbnds_train(&options, NULL, &error);
    if (status != PBNDS_OK) (void)fprintf(stderr, "%s\n", error.message);
    _exit(status == PBNDS_OK ? 0 : 1);
}

static double now(void)
{
    struct timespec t;
    assert_int_equal(clock_gettime(CLOCK_MONOTONIC, &t), 0);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void wait_a_while(double seconds)
{
    struct timespec left = {(time_t)seconds,
                            (long)(1e9 * (seconds - (double)(time_t)seconds))};
    while (nanosleep(&left, &left) != 0) {
    }
}

static double uniform(void)
{
    chance = 1664525u * chance + 1013904223u;
    return (double)(chance >> 8) / 16777216.0;
}

/* @return was it killed, or had it ended (well)? */
static bool killed(pid_t child)
{
    int status;
    (void)kill(child, SIGKILL);
    assert_int_equal(waitpid(child, &status, 0), child);
    if (WIFSIGNALED(status)) return true;
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    return false;
}

/* @return did it end well, left alone? */
static bool ended(pid_t child)
{
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    return true;
}

/* All of the curve but its seconds. */
static void assert_same_curve(const char *a, const char *b)
{
    struct pbnds_curve_row *x, *y;
    int n, m;
    assert_int_equal(pbnds_curve_read(a, &x, &n, NULL), PBNDS_OK);
    assert_int_equal(pbnds_curve_read(b, &y, &m, NULL), PBNDS_OK);
    assert_int_equal(n, m);
    assert_true(n > 10);
    for (int i = 0; i < n; ++i) {
        y[i].seconds = x[i].seconds;
        assert_memory_equal(&x[i], &y[i], sizeof x[i]);
    }
    free(x);
    free(y);
}

static void sweep(void)
{
    static const char *const LEFT[] = {"", ".csv", ".png", ".sheet.png"};
    for (size_t i = 0; i < sizeof LEFT / sizeof LEFT[0]; ++i) {
        char path[64];
        (void)snprintf(path, sizeof path, "test_kill_b.safetensors%s", LEFT[i]);
        assert_int_equal(unlink(path), 0);
    }
}

/* The delays reach a third of a run, so that kills come at every stage of it: while it
 * starts, in a step, while a checkpoint, the weights or a picture are written. */
static void killed_runs_end_the_same(void **state)
{
    (void)state;
    const double begin = now();
    assert_true(ended(start("test_kill_a.safetensors")));
    const double whole = now() - begin;
    int ends = 0;
    for (int kills = 0; ends < 1 || kills < KILLS;) {
        const pid_t child = start("test_kill_b.safetensors");
        if (kills < KILLS) wait_a_while(uniform() * whole / 3.0);
        if (kills < KILLS ? killed(child) : !ended(child)) {
            ++kills;
            /* Ended between its last act and its exit? Then the next one would be a new
             * run under a finished name. */
            const bool over = access("test_kill_b.safetensors.checkpoint", F_OK) != 0 &&
                              access("test_kill_b.safetensors", F_OK) == 0;
            if (!over) continue;
        }
        ++ends;
        assert_true(fixture_same("test_kill_a.safetensors", "test_kill_b.safetensors"));
        assert_same_curve("test_kill_a.safetensors.csv", "test_kill_b.safetensors.csv");
        sweep();
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(killed_runs_end_the_same)};
    return cmocka_run_group_tests_name("neural/train/kill", tests, setup, teardown);
}
