/* Writes procedural worlds for training, and the scenes and sky that ship. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "scenes/generator/layout.h"

static const char USAGE[] =
    "usage: pbnds_make_scenes -o DIR [--count N] [--seed S] [--first I] [--threads N]\n"
    "  -o DIR       folder for the files (made when missing)\n"
    "  --count N    writes N random worlds, world_00000.glb ...\n"
    "  --seed S     seed of all random choices (default 1)\n"
    "  --first I    number of the first file (default 0); world I is the same in any "
    "run\n"
    "  --threads N  threads (default: one a core)\n";

struct job {
    const char *folder;
    uint64_t seed, first;
    enum pbnds_status *status;
    struct pbnds_error *errors; /* one a thread would do; one a file keeps it simple */
};

static void write_world(void *context, size_t i, int thread)
{
    (void)thread;
    const struct job *job = context;
    char path[4096];
    const unsigned long long number = job->first + i;
    struct gen_world *w = calloc(1, sizeof *w);
    if (!w) {
        job->status[i] = pbnds_fail(&job->errors[i], PBNDS_ERROR_MEMORY, "no memory");
        return;
    }
    (void)snprintf(path, sizeof path, "%s/world_%05llu.glb", job->folder, number);
    gen_random_world(w, job->seed, number);
    job->status[i] = gen_glb_write(w, path, &job->errors[i]);
    gen_world_free(w);
    free(w);
}

static int write_worlds(const char *folder, uint64_t seed, uint64_t first, size_t count)
{
    struct job job = {folder, seed, first, calloc(count + 1, sizeof *job.status),
                      calloc(count + 1, sizeof *job.errors)};
    int failed = 0;
    if (!job.status || !job.errors) {
        (void)fprintf(stderr, "pbnds_make_scenes: no memory for %zu worlds\n", count);
        failed = 1;
    } else {
        pbnds_parallel_for(count, write_world, &job);
        for (size_t i = 0; i < count && !failed; ++i) {
            if (job.status[i] == PBNDS_OK) continue;
            (void)fprintf(stderr, "pbnds_make_scenes: %s\n", job.errors[i].message);
            failed = 1;
        }
    }
    free(job.status);
    free(job.errors);
    return failed;
}

/* Decimal number of at most `limit`; exits with the usage otherwise. */
static uint64_t number(const char *option, const char *text, uint64_t limit)
{
    char *end = NULL;
    errno = 0;
    const unsigned long long value = text ? strtoull(text, &end, 10) : 0;
    if (!text || !*text || *end || errno || value > limit || text[0] == '-') {
        (void)fprintf(stderr, "pbnds_make_scenes: %s wants a number up to %llu\n",
                      option, (unsigned long long)limit);
        exit(2);
    }
    return value;
}

int main(int argc, char **argv)
{
    const char *folder = NULL;
    uint64_t count = 0, seed = 1, first = 0;
    for (int i = 1; i < argc; ++i) {
        const char *option = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(option, "--help") == 0) {
            (void)fputs(USAGE, stdout);
            return 0;
        }
        if (strcmp(option, "-o") == 0 && value) {
            folder = value;
        } else if (strcmp(option, "--count") == 0) {
            count = number(option, value, 1000000);
        } else if (strcmp(option, "--seed") == 0) {
            seed = number(option, value, UINT64_MAX);
        } else if (strcmp(option, "--first") == 0) {
            first = number(option, value, 1000000000);
        } else if (strcmp(option, "--threads") == 0) {
            pbnds_set_threads((int)number(option, value, 1024));
        } else {
            (void)fprintf(stderr, "pbnds_make_scenes: %s?\n%s", option, USAGE);
            return 2;
        }
        ++i;
    }
    if (!folder) {
        (void)fputs(USAGE, stderr);
        return 2;
    }
    struct pbnds_error error = {""};
    if (pbnds_make_folder(folder, &error) != PBNDS_OK) {
        (void)fprintf(stderr, "pbnds_make_scenes: %s\n", error.message);
        return 1;
    }
    return write_worlds(folder, seed, first, (size_t)count);
}
