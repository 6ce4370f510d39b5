/* A data set on disk: whole after any kill, shared by processes, with its failures told. */
#include "tests/neural/data/fixture_data.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>

#include "engine/core/parallel.h"
#include "neural/data/store_index.h"
#include "neural/data/store_manifest.h"
#include "neural/data/store_read.h"

#if defined(__SANITIZE_ADDRESS__)
enum { KILLS = 12, SHARD_ROUNDS = 2 };
#else
enum { KILLS = 100, SHARD_ROUNDS = 8 };
#endif

enum { COUNT = 24, PER_TAR = 4 };

static char folder[] = "test_store_assets";
static struct pbnds_dataset_source ROOT[] = {{folder, 0.0}};
static uint32_t chance = 1;

static const char *const WHOLE[] = {"test_store_folders", "test_store_tar"};

static struct pbnds_dataset_recipe recipe_of(enum pbnds_dataset_format format)
{
    struct pbnds_dataset_recipe recipe = fixture_recipe(ROOT, COUNT);
    recipe.width = recipe.height = 16;
    recipe.spp = 1;
    recipe.format = format;
    recipe.per_tar = PER_TAR;
    return recipe;
}

static struct pbnds_dataset_summary make(const struct pbnds_dataset_recipe *recipe,
                                         const char *dir)
{
    struct pbnds_error error = {{0}};
    struct pbnds_dataset_summary summary;
    if (pbnds_dataset_make(recipe, NULL, dir, NULL, &summary, &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
    return summary;
}

/* The same names with the same bytes, hidden ones too. */
static void assert_same(const char *a, const char *b)
{
    char command[512];
    (void)snprintf(command, sizeof command, "diff -r '%s' '%s' >&2", a, b);
    assert_int_equal(system(command), 0);
}

static int setup(void **state)
{
    (void)state;
    pbnds_set_threads(1);
    if (system("rm -rf test_store_*") != 0) return -1; /* of a run that was killed */
    fixture_assets(folder);
    for (int f = 0; f < 2; ++f) {
        const struct pbnds_dataset_recipe recipe =
            recipe_of((enum pbnds_dataset_format)f);
        const struct pbnds_dataset_summary s = make(&recipe, WHOLE[f]);
        if (s.made != COUNT || s.total != COUNT || !s.complete) return -1;
    }
    /* A kill takes nothing from what was written: the disk need not be waited for, and
     * kills meet the work more often. */
    (void)pbnds_file_set_sync(false);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    return system("rm -rf test_store_*") == 0 ? 0 : -1;
}

/* ---- processes ---- */

/* In a child, whose status is the number of samples it made, or 255. */
static pid_t start(const struct pbnds_dataset_recipe *recipe, const char *dir,
                   int shard, int shards)
{
    (void)fflush(NULL);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0) return child;
    struct pbnds_error error = {{0}};
    struct pbnds_dataset_summary summary;
    const struct pbnds_dataset_options options = {.shard = {shard, shards}};
    const enum pbnds_status status =
        pbnds_dataset_make(recipe, &options, dir, NULL, &summary, &error);
    if (status != PBNDS_OK) (void)fprintf(stderr, "%s\n", error.message);
    _exit(status == PBNDS_OK ? summary.made : 255);
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

static double now(void)
{
    struct timespec t;
    assert_int_equal(clock_gettime(CLOCK_MONOTONIC, &t), 0);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* @return was it killed, or had it ended (well)? */
static bool killed(pid_t child)
{
    int status;
    (void)kill(child, SIGKILL);
    assert_int_equal(waitpid(child, &status, 0), child);
    if (WIFSIGNALED(status)) return true;
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) != 255);
    return false;
}

static int made_by(pid_t child)
{
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) != 255);
    return WEXITSTATUS(status);
}

/* Runs go on where others were killed, again and again, until one comes to the end; and so
 * on, until there were enough kills. The delays reach a third of a run, so that kills come
 * at every stage of it. */
static void nothing_is_lost_or_twice_after_kills(enum pbnds_dataset_format format)
{
    const struct pbnds_dataset_recipe recipe = recipe_of(format);
    const char *dir = "test_store_killed";
    const double begin = now();
    (void)made_by(start(&recipe, dir, 0, 1));
    const double whole = now() - begin;
    fixture_remove(dir);
    int ends = 0;
    for (int kills = 0; kills < KILLS || ends < 2;) {
        const pid_t child = start(&recipe, dir, 0, 1);
        wait_a_while(uniform() * whole / 3.0);
        if (killed(child)) {
            ++kills;
            continue;
        }
        ++ends;
        assert_same(WHOLE[format], dir);
        fixture_remove(dir);
    }
    const struct pbnds_dataset_summary s = make(&recipe, dir);
    assert_int_equal(s.made + s.kept, COUNT);
    assert_same(WHOLE[format], dir);
    fixture_remove(dir);
}

static void folders_bear_kills(void **state)
{
    (void)state;
    nothing_is_lost_or_twice_after_kills(PBNDS_DATASET_FOLDERS);
}

static void tars_bear_kills(void **state)
{
    (void)state;
    nothing_is_lost_or_twice_after_kills(PBNDS_DATASET_TAR);
}

static void one_shard_killed_does_not_hurt_the_other(void **state)
{
    (void)state;
    for (int round = 0; round < SHARD_ROUNDS; ++round) {
        const int format = round % 2;
        const struct pbnds_dataset_recipe recipe =
            recipe_of((enum pbnds_dataset_format)format);
        const pid_t a = start(&recipe, "test_store_shards", 0, 2);
        const pid_t b = start(&recipe, "test_store_shards", 1, 2);
        wait_a_while(0.2 * uniform());
        (void)killed(a);
        (void)made_by(b);
        (void)made_by(start(&recipe, "test_store_shards", 0, 2));
        assert_same(WHOLE[format], "test_store_shards");
        fixture_remove("test_store_shards");
    }
}

/* Without shards: whoever comes first to a unit makes it. */
static void runs_over_one_folder_share_it(void **state)
{
    (void)state;
    for (int format = 0; format < 2; ++format) {
        const struct pbnds_dataset_recipe recipe =
            recipe_of((enum pbnds_dataset_format)format);
        pid_t children[3];
        int sum = 0;
        for (int i = 0; i < 3; ++i)
            children[i] = start(&recipe, "test_store_shared", 0, 1);
        for (int i = 0; i < 3; ++i)
            sum += made_by(children[i]);
        assert_int_equal(sum, COUNT);
        assert_same(WHOLE[format], "test_store_shared");
        fixture_remove("test_store_shared");
    }
}

/* ---- what cannot be made ---- */

static char warned[1024];
static int warnings;

static void remember(void *user, const char *sentence)
{
    (void)user;
    ++warnings;
    (void)snprintf(warned, sizeof warned, "%s", sentence);
}

static struct pbnds_dataset_summary
make_broken(const struct pbnds_dataset_recipe *recipe, bool retry)
{
    const struct pbnds_report report = {.warn = remember};
    const struct pbnds_dataset_options options = {.retry = retry};
    struct pbnds_dataset_summary s;
    struct pbnds_error error = {{0}};
    warnings = 0;
    if (pbnds_dataset_make(recipe, &options, "test_store_broken", &report, &s,
                           &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
    return s;
}

/* A scene whose points are missing for a while. */
static void quarantine(enum pbnds_dataset_format format)
{
    unsigned char points[180];
    fixture_points(2.0f, points);
    fixture_gltf_of("test_store_assets/train/apart.gltf", "apart.bin");
    const struct pbnds_dataset_recipe recipe = recipe_of(format);
    struct pbnds_dataset_summary s = make_broken(&recipe, false);
    const int lost = s.quarantined;
    assert_in_range(lost, 1, COUNT - 1);
    assert_int_equal(s.made, COUNT - lost);
    assert_int_equal(warnings, lost + 1);
    assert_true(s.complete);
    assert_non_null(strstr(s.reason, "apart.bin"));
    cJSON *manifest;
    assert_int_equal(pbnds_manifest_read("test_store_broken", &manifest, NULL),
                     PBNDS_OK);
    const cJSON *list = cJSON_GetObjectItem(manifest, "quarantined");
    assert_int_equal(cJSON_GetArraySize(list), lost);
    assert_non_null(strstr(
        cJSON_GetStringValue(cJSON_GetObjectItem(list->child, "reason")), "apart.bin"));
    cJSON_Delete(manifest);
    s = make_broken(&recipe, false); /* is not tried again */
    assert_int_equal(s.quarantined, lost);
    assert_int_equal(s.made, 0);
    assert_int_equal(warnings, 1);
    s = make_broken(&recipe, true); /* in vain */
    assert_int_equal(s.quarantined, lost);
    assert_int_equal(warnings, lost + 1);
    assert_int_equal(pbnds_file_write("test_store_assets/train/apart.bin", points,
                                      sizeof points, NULL),
                     PBNDS_OK);
    s = make_broken(&recipe, true);
    assert_int_equal(s.made, lost);
    assert_int_equal(s.kept, COUNT - lost);
    assert_int_equal(s.quarantined, 0);
    (void)make(&recipe, "test_store_mended");
    assert_same("test_store_mended", "test_store_broken");
    fixture_remove("test_store_mended");
    fixture_remove("test_store_broken");
    assert_int_equal(unlink("test_store_assets/train/apart.bin"), 0);
    assert_int_equal(unlink("test_store_assets/train/apart.gltf"), 0);
}

static void hopeless_samples_are_quarantined(void **state)
{
    (void)state;
    quarantine(PBNDS_DATASET_FOLDERS);
    quarantine(PBNDS_DATASET_TAR);
}

static void targets_that_are_not_finite_are_refused(void **state)
{
    (void)state;
    struct pbnds_sample sample;
    struct pbnds_error error = {{0}};
    struct pbnds_image light;
    assert_int_equal(
        pbnds_sample_load("test_store_folders/val/000000", 0, &sample, &error),
        PBNDS_OK);
    assert_int_equal(pbnds_image_init(&light, 8, 4, 3, &error), PBNDS_OK);
    assert_int_equal(pbnds_make_folder("test_store_nan", NULL), PBNDS_OK);
    float plane[16 * 16] = {0.0f};
    const struct pbnds_exr_channel extra = {"R", PBNDS_EXR_HALF, plane};
    const struct pbnds_gbuffer_origin origin = {.env_strength = 1.0f};
    cJSON *json = cJSON_CreateObject();
    const struct pbnds_sample_parts parts = {.gbuffer = &sample.gbuffer,
                                             .origin = &origin,
                                             .extra = &extra,
                                             .extra_count = 1,
                                             .light = &light,
                                             .json = json};
    assert_int_equal(pbnds_sample_write_parts("test_store_nan", &parts, &error),
                     PBNDS_OK);
    plane[16 * 3 + 5] = INFINITY;
    assert_int_equal(pbnds_sample_write_parts("test_store_nan", &parts, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "R is not finite at pixel (5, 3)"));
    plane[16 * 3 + 5] = 0.0f;
    light.data[3 * 10] = NAN;
    assert_int_equal(pbnds_sample_write_parts("test_store_nan", &parts, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(
        strstr(error.message, "light.exr: R is not finite at pixel (2, 1)"));
    cJSON_Delete(json);
    pbnds_image_free(&light);
    pbnds_sample_free(&sample);
    fixture_remove("test_store_nan");
}

/* ---- what cannot be written ---- */

static void limit_files(rlim_t bytes)
{
    struct rlimit limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = bytes;
    (void)signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void what_cannot_be_written_is_made_later(void **state)
{
    (void)state;
    for (int format = 0; format < 2; ++format) {
        const struct pbnds_dataset_recipe recipe =
            recipe_of((enum pbnds_dataset_format)format);
        struct pbnds_error error = {{0}};
        struct pbnds_dataset_summary s;
        limit_files(8000); /* dataset.json fits, sample.exr does not */
        const enum pbnds_status status =
            pbnds_dataset_make(&recipe, NULL, "test_store_full", NULL, &s, &error);
        limit_files(RLIM_INFINITY);
        assert_int_equal(status, PBNDS_ERROR_IO);
        assert_non_null(strstr(error.message, "cannot be written"));
        assert_int_equal(s.failed, 8); /* in a row: no point in going on */
        assert_int_equal(s.quarantined + s.made, 0);
        assert_int_not_equal(access("test_store_full/quarantine", F_OK), 0);
        s = make(&recipe, "test_store_full");
        assert_int_equal(s.made, COUNT);
        assert_same(WHOLE[format], "test_store_full");
        fixture_remove("test_store_full");
    }
}

static int listed(const char *dir)
{
    int sum = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        struct pbnds_sample_list list;
        assert_int_equal(pbnds_dataset_list(dir, (enum pbnds_split)s, &list, NULL),
                         PBNDS_OK);
        sum += list.count;
        for (int i = 0; i < list.count; ++i) {
            struct pbnds_sample sample;
            struct pbnds_error error = {{0}};
            if (pbnds_sample_load(list.folders[i], 0, &sample, &error) != PBNDS_OK)
                fail_msg("%s", error.message);
            pbnds_sample_free(&sample);
        }
        pbnds_sample_list_free(&list);
    }
    return sum;
}

static void a_tar_that_does_not_fit_waits_for_the_next_run(void **state)
{
    (void)state;
    const struct pbnds_dataset_recipe recipe = recipe_of(PBNDS_DATASET_TAR);
    struct pbnds_dataset_summary s;
    struct pbnds_error error = {{0}};
    limit_files(48000); /* two samples */
    const enum pbnds_status status =
        pbnds_dataset_make(&recipe, NULL, "test_store_staged", NULL, &s, &error);
    limit_files(RLIM_INFINITY);
    assert_int_equal(status, PBNDS_ERROR_IO);
    assert_int_equal(s.made, COUNT);
    assert_false(s.complete);
    assert_int_equal(listed("test_store_staged"), COUNT); /* half-made, but readable */
    s = make(&recipe, "test_store_staged");
    assert_int_equal(s.kept, COUNT);
    assert_same(WHOLE[PBNDS_DATASET_TAR], "test_store_staged");
    fixture_remove("test_store_staged");
}

static void what_waits_and_was_spoilt_is_made_again(void **state)
{
    (void)state;
    const struct pbnds_dataset_recipe recipe = recipe_of(PBNDS_DATASET_TAR);
    limit_files(48000);
    const enum pbnds_status status =
        pbnds_dataset_make(&recipe, NULL, "test_store_spoilt", NULL, NULL, NULL);
    limit_files(RLIM_INFINITY);
    assert_int_equal(status, PBNDS_ERROR_IO);
    assert_int_equal(truncate("test_store_spoilt/.work/train-000002/sample.exr", 77),
                     0);
    const struct pbnds_dataset_summary s = make(&recipe, "test_store_spoilt");
    assert_int_equal(s.made, 1);
    assert_same(WHOLE[PBNDS_DATASET_TAR], "test_store_spoilt");
    fixture_remove("test_store_spoilt");
}

/* ---- reading ---- */

static void both_formats_hold_the_same(void **state)
{
    (void)state;
    struct pbnds_sample_list a, b;
    char hash[2][17];
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        const enum pbnds_split split = (enum pbnds_split)s;
        assert_int_equal(pbnds_dataset_list(WHOLE[0], split, &a, NULL), PBNDS_OK);
        assert_int_equal(pbnds_dataset_list(WHOLE[1], split, &b, NULL), PBNDS_OK);
        assert_int_equal(a.count, b.count);
        for (int i = 0; i < a.count; ++i) {
            struct pbnds_store_bytes x, y;
            struct pbnds_error error = {{0}};
            for (int k = 0; k < 3; ++k) {
                const char *file = pbnds_sample_file(k);
                assert_int_equal(pbnds_store_read(a.folders[i], file, &x, &error),
                                 PBNDS_OK);
                if (pbnds_store_read(b.folders[i], file, &y, &error) != PBNDS_OK)
                    fail_msg("%s", error.message);
                assert_int_equal(x.size, y.size);
                assert_memory_equal(x.data, y.data, x.size);
                free(x.data);
                free(y.data);
            }
        }
        pbnds_sample_list_free(&a);
        pbnds_sample_list_free(&b);
    }
    assert_int_equal(listed(WHOLE[1]), COUNT);
    for (int f = 0; f < 2; ++f)
        assert_int_equal(pbnds_dataset_hash(WHOLE[f], hash[f], NULL), PBNDS_OK);
    assert_string_not_equal(hash[0], hash[1]); /* they are two data sets yet */
}

/* A path with a wrong hint, with none, and of a sample that is not there. */
static void samples_are_found_by_name(void **state)
{
    (void)state;
    struct pbnds_store_bytes bytes;
    struct pbnds_error error = {{0}};
    static const char *const PATHS[] = {
        "test_store_tar/train-000001.tar#000006",
        "test_store_tar/train-000001.tar#000006@0",
        "test_store_tar/train-000001.tar#000006@77",
        "test_store_tar/train-000001.tar#000006@18446744073709551000"};
    for (int i = 0; i < 4; ++i) {
        assert_int_equal(pbnds_store_read(PATHS[i], "sample.json", &bytes, &error),
                         PBNDS_OK);
        assert_non_null(strstr((const char *)bytes.data, "\"index\":\t6,"));
        free(bytes.data);
    }
    assert_int_equal(pbnds_store_read("test_store_tar/train-000001.tar#000099",
                                      "sample.json", &bytes, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "000099.sample.json"));
    assert_false(pbnds_store_holds(PATHS[0], "olat.exr"));
    assert_true(pbnds_store_holds(PATHS[0], "light.exr"));
}

/* What other tools write: GNU and pax headers, a folder before every name. */
static void tars_of_others_are_read(void **state)
{
    (void)state;
    static const char *const FORMATS[] = {"gnu", "pax", "ustar", "v7"};
    const char *tar = "test_store_other.tar";
    for (int f = 0; f < 4; ++f) {
        char command[512];
        (void)snprintf(command, sizeof command,
                       "rm -rf test_store_other && mkdir test_store_other && "
                       "tar -C test_store_other -xf %s/val-000000.tar && "
                       "tar -C test_store_other --format=%s -cf %s .",
                       WHOLE[1], FORMATS[f], tar);
        assert_int_equal(system(command), 0);
        struct pbnds_tar_index index;
        struct pbnds_error error = {{0}};
        if (pbnds_tar_index_read(tar, &index, &error) != PBNDS_OK)
            fail_msg("%s", error.message);
        assert_int_equal(index.count, 6);
        assert_string_equal(index.members[0].name, "000000.light.exr");
        pbnds_tar_index_free(&index);
    }
}

static void damaged_tars_are_refused(void **state)
{
    (void)state;
    const char *tar = "test_store_damaged.tar";
    uint8_t *bytes;
    size_t size;
    assert_int_equal(pbnds_file_read("test_store_tar/val-000000.tar", (size_t)1 << 30,
                                     &bytes, &size, NULL),
                     PBNDS_OK);
    struct pbnds_tar_index index;
    struct pbnds_error error = {{0}};
    static const size_t CUTS[] = {0, 100, 511, 512, 513, 5000};
    for (int i = 0; i < 6; ++i) {
        assert_int_equal(pbnds_file_write(tar, bytes, CUTS[i], NULL), PBNDS_OK);
        assert_int_equal(pbnds_tar_index_read(tar, &index, &error), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, "cut short"));
        assert_null(index.members);
    }
    for (size_t at = 0; at < 512; at += 7) { /* the checksum covers the header */
        if (at >= 148 && at < 156) continue;
        bytes[at] ^= 0x10;
        assert_int_equal(pbnds_file_write(tar, bytes, size, NULL), PBNDS_OK);
        assert_int_equal(pbnds_tar_index_read(tar, &index, &error), PBNDS_ERROR_FORMAT);
        bytes[at] ^= 0x10;
    }
    free(bytes);
    assert_int_equal(pbnds_tar_index_read("test_store_none.tar", &index, &error),
                     PBNDS_ERROR_IO);
    assert_int_equal(pbnds_tar_index_read(folder, &index, &error), PBNDS_ERROR_IO);
}

/* A damaged tar stops neither the reading of the others nor their making. */
static void a_damaged_tar_costs_its_samples_only(void **state)
{
    (void)state;
    const struct pbnds_dataset_recipe recipe = recipe_of(PBNDS_DATASET_TAR);
    struct pbnds_dataset_summary s = make(&recipe, "test_store_hurt");
    const char *tar = "test_store_hurt/train-000002.tar";
    assert_int_equal(truncate(tar, 3000), 0);
    assert_int_equal(unlink("test_store_hurt/train-000003.tar"), 0);
    struct pbnds_error error = {{0}};
    assert_int_equal(
        pbnds_dataset_make(&recipe, NULL, "test_store_hurt", NULL, &s, &error),
        PBNDS_ERROR_IO);
    assert_int_equal(s.made, PER_TAR);
    assert_int_equal(s.failed, PER_TAR);
    assert_non_null(strstr(error.message, "train-000002.tar"));
    assert_int_not_equal(access("test_store_hurt/manifest.json", F_OK), 0);
    assert_int_equal(unlink(tar), 0);
    s = make(&recipe, "test_store_hurt");
    assert_int_equal(s.made, PER_TAR);
    assert_same(WHOLE[1], "test_store_hurt");
    fixture_remove("test_store_hurt");
}

/* ---- the manifest ---- */

static void the_manifest_knows_its_own_hash(void **state)
{
    (void)state;
    cJSON *json;
    char hash[17];
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_manifest_read(WHOLE[1], &json, &error), PBNDS_OK);
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(json, "samples")), COUNT);
    assert_int_equal(pbnds_dataset_hash(WHOLE[1], hash, NULL), PBNDS_OK);
    assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(json, "hash")), hash);
    cJSON_Delete(json);
    uint8_t *bytes;
    size_t size;
    assert_int_equal(pbnds_file_read("test_store_tar/manifest.json", (size_t)1 << 30,
                                     &bytes, &size, NULL),
                     PBNDS_OK);
    assert_int_equal(pbnds_make_folder("test_store_forged", NULL), PBNDS_OK);
    for (size_t at = 0; at < size; at += 97) {
        bytes[at] ^= 1;
        assert_int_equal(
            pbnds_file_write("test_store_forged/manifest.json", bytes, size, NULL),
            PBNDS_OK);
        const enum pbnds_status status =
            pbnds_manifest_read("test_store_forged", &json, &error);
        bytes[at] ^= 1;
        assert_int_equal(status, PBNDS_ERROR_FORMAT);
        assert_null(json);
    }
    free(bytes);
    fixture_remove("test_store_forged");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_formats_hold_the_same),
        cmocka_unit_test(samples_are_found_by_name),
        cmocka_unit_test(tars_of_others_are_read),
        cmocka_unit_test(damaged_tars_are_refused),
        cmocka_unit_test(a_damaged_tar_costs_its_samples_only),
        cmocka_unit_test(the_manifest_knows_its_own_hash),
        cmocka_unit_test(hopeless_samples_are_quarantined),
        cmocka_unit_test(targets_that_are_not_finite_are_refused),
        cmocka_unit_test(what_cannot_be_written_is_made_later),
        cmocka_unit_test(a_tar_that_does_not_fit_waits_for_the_next_run),
        cmocka_unit_test(what_waits_and_was_spoilt_is_made_again),
        cmocka_unit_test(runs_over_one_folder_share_it),
        cmocka_unit_test(one_shard_killed_does_not_hurt_the_other),
        cmocka_unit_test(folders_bear_kills),
        cmocka_unit_test(tars_bear_kills),
    };
    return cmocka_run_group_tests_name("neural/data/store", tests, setup, teardown);
}
