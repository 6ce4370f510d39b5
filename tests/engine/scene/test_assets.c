/* Files and judgements that are not ours: what the loader makes of every glTF asset of
 * Debian's assimp-testmodels and of the shared data, beside what the Khronos validator says
 * of it (assets/assets.csv, written by tools/validate_assets). */
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/scene/gltf.h"
#include "tests/test.h"

#define TABLE PBNDS_SOURCE_DIR "/tests/engine/scene/assets/assets.csv"

enum { ROW_MAX = 1000, FIELDS = 6 };
enum { PATH, VERDICT, ERRORS, WARNINGS, CODES, NOTE };

static const struct {
    const char *name, *folder;
} roots[] = {
    {"assimp/", "/usr/share/assimp/models/"},
    {"shared/", PBNDS_SHARED_DATA "/"},
};

static char *table;
static char *rows[ROW_MAX][FIELDS];
static int row_count;

static int read_table(void **state)
{
    (void)state;
    struct pbnds_error error;
    uint8_t *bytes = NULL;
    size_t size = 0;
    assert_int_equal(pbnds_file_read(TABLE, 1 << 24, &bytes, &size, &error), PBNDS_OK);
    table = (char *)bytes;
    char *line = strchr(table, '\n');
    assert_non_null(line); /* the header */
    for (line = line + 1; *line;) {
        char *end = strchr(line, '\n');
        assert_non_null(end);
        *end = 0;
        assert_true(row_count < ROW_MAX);
        for (int i = 0; i < FIELDS; ++i) {
            rows[row_count][i] = line;
            char *comma = i + 1 < FIELDS ? strchr(line, ',') : NULL;
            if (!comma && i + 1 < FIELDS)
                fail_msg("%s: too few fields", rows[row_count][0]);
            if (comma) *comma = 0;
            line = comma ? comma + 1 : end + 1;
        }
        ++row_count;
    }
    return 0;
}

static int drop_table(void **state)
{
    (void)state;
    free(table);
    return 0;
}

/* A refusal has a reason that the validator gives too, or one that is written down; so has
 * every file that is loaded although the validator finds an error. */
static void every_difference_is_explained(void **state)
{
    (void)state;
    int loads = 0;
    for (int i = 0; i < row_count; ++i) {
        const bool loaded = strcmp(rows[i][VERDICT], "loads") == 0;
        const bool faulty = strtol(rows[i][ERRORS], NULL, 10) > 0;
        loads += loaded;
        if (faulty != (rows[i][CODES][0] != 0)) {
            fail_msg("%s: errors without a code", rows[i][PATH]);
        }
        if (loaded == faulty && !rows[i][NOTE][0]) {
            fail_msg(
                "%s: pbnds says %s, the validator finds %s errors, no note says why",
                rows[i][PATH], rows[i][VERDICT], rows[i][ERRORS]);
        }
        if (i > 0) assert_true(strcmp(rows[i - 1][PATH], rows[i][PATH]) < 0);
    }
    assert_true(loads > 100 && row_count > 200);
}

static const char *verdict_of(enum pbnds_status status)
{
    switch (status) {
    case PBNDS_OK:
        return "loads";
    case PBNDS_ERROR_IO:
        return "unreadable";
    case PBNDS_ERROR_FORMAT:
        return "invalid";
    case PBNDS_ERROR_UNSUPPORTED:
        return "unsupported";
    default:
        return "?";
    }
}

/** The file of a row; false where its folder is not on this machine. */
static bool file_of(const char *path, char *out, size_t size)
{
    for (size_t i = 0; i < sizeof roots / sizeof roots[0]; ++i) {
        const size_t n = strlen(roots[i].name);
        if (strncmp(path, roots[i].name, n) != 0) continue;
        (void)snprintf(out, size, "%s%s", roots[i].folder, path + n);
        return access(roots[i].folder, R_OK) == 0;
    }
    fail_msg("%s: an unknown folder", path);
    return false;
}

static void verdicts_are_those_of_the_table(void **state)
{
    (void)state;
    int tried = 0, wrong = 0;
    for (int i = 0; i < row_count; ++i) {
        char file[1200];
        if (!file_of(rows[i][PATH], file, sizeof file)) continue;
        if (access(file, R_OK) != 0) {
            print_message("%s: is not there\n", file);
            ++wrong;
            continue;
        }
        struct pbnds_scene scene;
        struct pbnds_error error = {{0}};
        const enum pbnds_status status =
            pbnds_gltf_load(file, NULL, NULL, &scene, &error);
        pbnds_scene_free(&scene);
        ++tried;
        if (strcmp(verdict_of(status), rows[i][VERDICT]) == 0) continue;
        print_message("%s: %s now, %s in the table: %s\n", rows[i][PATH],
                      verdict_of(status), rows[i][VERDICT], error.message);
        ++wrong;
    }
    if (tried == 0) skip();
    assert_int_equal(wrong, 0);
}

static int unlisted;
static size_t root_at;

static int look_up(const char *path, const struct stat *info, int kind,
                   struct FTW *where)
{
    (void)info;
    (void)where;
    const char *dot = strrchr(path, '.');
    if (kind != FTW_F || !dot ||
        (strcasecmp(dot, ".gltf") != 0 && strcasecmp(dot, ".glb") != 0)) {
        return 0;
    }
    char name[1200];
    (void)snprintf(name, sizeof name, "%s%s", roots[root_at].name,
                   path + strlen(roots[root_at].folder));
    for (int i = 0; i < row_count; ++i) {
        if (strcmp(rows[i][PATH], name) == 0) return 0;
    }
    print_message("%s: is not in the table\n", name);
    ++unlisted;
    return 0;
}

static void the_table_has_every_file(void **state)
{
    (void)state;
    static const char *const below[] = {"glTF", "glTF2", "models", "malformed"};
    int seen = 0;
    for (size_t i = 0; i < sizeof below / sizeof below[0]; ++i) {
        char folder[1200];
        root_at = i / 2;
        (void)snprintf(folder, sizeof folder, "%s%s", roots[root_at].folder, below[i]);
        seen += nftw(folder, look_up, 16, FTW_PHYS) == 0;
    }
    if (seen == 0) skip();
    assert_int_equal(unlisted, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_difference_is_explained),
        cmocka_unit_test(verdicts_are_those_of_the_table),
        cmocka_unit_test(the_table_has_every_file),
    };
    return cmocka_run_group_tests(tests, read_table, drop_table);
}
