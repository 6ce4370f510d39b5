/* A folder of its own for the files that a test writes, in the working directory. */
#ifndef PBNDS_TEST_SCRATCH_H
#define PBNDS_TEST_SCRATCH_H

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "tests/test.h"

static inline int scratch_skip(const struct dirent *entry)
{
    return strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0;
}

/** Number of entries of a folder, -1 where there is none. */
static inline int scratch_count(const char *folder)
{
    DIR *dir = opendir(folder);
    if (!dir) return -1;
    int count = 0;
    for (const struct dirent *e = readdir(dir); e; e = readdir(dir)) {
        count += !scratch_skip(e);
    }
    closedir(dir);
    return count;
}

/** Makes the folder, empty. */
static inline void scratch_make(const char *folder)
{
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_make_folder(folder, &error), PBNDS_OK);
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (const struct dirent *e = readdir(dir); e; e = readdir(dir)) {
        char path[1024];
        if (scratch_skip(e)) continue;
        (void)snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        if (remove(path) != 0) fail_msg("%s cannot be removed", path);
    }
    closedir(dir);
}

/** Makes every write beyond `bytes` of a file fail, as a full disk does; restore with
 *  scratch_unlimit(). */
static inline struct rlimit scratch_limit(rlim_t bytes)
{
    struct rlimit old;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    const struct rlimit limit = {bytes, old.rlim_max};
    (void)signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    return old;
}

static inline void scratch_unlimit(struct rlimit old)
{
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
}

#endif /* PBNDS_TEST_SCRATCH_H */
