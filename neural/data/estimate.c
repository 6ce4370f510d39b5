#include "neural/data/estimate.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "neural/data/dataset.h"

enum { PILOTS = 48 };

/* Cores times seconds. */
static double core_seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Removes the files of a folder; returns their bytes. */
static double sweep(const char *folder)
{
    double bytes = 0.0;
    DIR *dir = opendir(folder);
    if (!dir) return 0.0;
    for (struct dirent *entry; (entry = readdir(dir));) {
        char path[4096 + 300];
        struct stat info;
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] == '.' && strncmp(entry->d_name, ".tmp", 4) != 0) continue;
        if (stat(path, &info) == 0) bytes += (double)info.st_size;
        (void)unlink(path);
    }
    (void)closedir(dir);
    return bytes;
}

struct pilots {
    struct pbnds_drawer *drawer;
    const struct pbnds_dataset_recipe *recipe;
    char folder[4096];
    double scale; /* share of the samples a pixel in the first of two tries */
    int made;
    double seconds[PILOTS], bytes[PILOTS];
};

/* The targets with a share of the recipe's samples a pixel; @return core seconds. */
static enum pbnds_status render(const struct pilots *p, double scale,
                                const struct pbnds_draw *draw,
                                struct pbnds_targets *targets, double *seconds,
                                struct pbnds_error *error)
{
    struct pbnds_dataset_recipe few = *p->recipe;
    const int olat_spp = few.olat_spp ? few.olat_spp : few.spp;
    few.spp = (int)lround(fmax(few.spp * scale, 1.0));
    few.olat_spp = (int)lround(fmax(olat_spp * scale, 1.0));
    const double start = core_seconds();
    const enum pbnds_status status = pbnds_targets_render(&few, draw, targets, error);
    *seconds = core_seconds() - start;
    return status;
}

static enum pbnds_status measure(struct pilots *p, const struct pbnds_draw *draw,
                                 struct pbnds_error *error)
{
    struct pbnds_targets targets = {0};
    double once = 0.0, twice = 0.0;
    PBNDS_TRY(render(p, p->scale, draw, &targets, &once, error));
    pbnds_targets_free(&targets);
    PBNDS_TRY(render(p, 2.0 * p->scale, draw, &targets, &twice, error));
    const double start = core_seconds();
    const enum pbnds_status status =
        pbnds_sample_write(p->folder, p->recipe, draw, &targets, error);
    p->seconds[p->made] += core_seconds() - start + once +
                           fmax(twice - once, 0.0) * (1.0 / p->scale - 1.0);
    p->bytes[p->made] = sweep(p->folder);
    pbnds_targets_free(&targets);
    return status;
}

static enum pbnds_status try_sample(struct pilots *p, enum pbnds_split split, int index,
                                    struct pbnds_error *error)
{
    struct pbnds_draw draw;
    const double start = core_seconds();
    PBNDS_TRY(pbnds_draw(p->drawer, split, index, &draw, error));
    p->seconds[p->made] = core_seconds() - start;
    const enum pbnds_status status = measure(p, &draw, error);
    pbnds_draw_free(&draw);
    if (status == PBNDS_OK) ++p->made;
    return status;
}

/* Sum over `count` samples and its standard error, from the mean of n of them. */
static void extrapolate(const double *x, int n, int count, double *sum, double *error)
{
    double mean = 0.0, square = 0.0;
    for (int i = 0; i < n; ++i)
        mean += x[i] / n;
    for (int i = 0; i < n; ++i)
        square += (x[i] - mean) * (x[i] - mean);
    *sum = mean * count;
    *error = n > 1 && n < count ? count * sqrt(square / (n - 1) / n) : 0.0;
}

/* Which sample is the number-th of all splits in a row. */
static enum pbnds_split place(const struct pbnds_drawer *drawer, int number, int *index)
{
    int s = 0;
    while (s + 1 < PBNDS_SPLIT_COUNT &&
           number >= pbnds_drawer_count(drawer, (enum pbnds_split)s)) {
        number -= pbnds_drawer_count(drawer, (enum pbnds_split)s);
        ++s;
    }
    *index = number;
    return (enum pbnds_split)s;
}

static enum pbnds_status try_all(struct pilots *p, const struct pbnds_report *report,
                                 struct pbnds_dataset_cost *cost,
                                 struct pbnds_error *error)
{
    enum pbnds_status first = PBNDS_OK;
    cost->pilots = cost->count < PILOTS ? cost->count : PILOTS;
    for (int i = 0; i < cost->pilots; ++i) {
        int index;
        const int number = (int)((int64_t)i * cost->count / cost->pilots);
        const enum pbnds_split split = place(p->drawer, number, &index);
        struct pbnds_error reason = {{0}};
        pbnds_progress(report, "dry run", i, cost->pilots);
        const enum pbnds_status status = try_sample(p, split, index, &reason);
        if (pbnds_stop_requested()) return pbnds_fail_interrupted(error);
        if (status != PBNDS_OK && ++cost->failed == 1) {
            first = status;
            if (error) *error = reason;
        }
    }
    pbnds_progress(report, "dry run", cost->pilots, cost->pilots);
    if (p->made == 0) return first;
    const int share = (int)((int64_t)cost->count * p->made / cost->pilots);
    extrapolate(p->seconds, p->made, share, &cost->core_seconds, &cost->core_error);
    extrapolate(p->bytes, p->made, share, &cost->bytes, &cost->bytes_error);
    return PBNDS_OK;
}

enum pbnds_status pbnds_dataset_estimate(const struct pbnds_dataset_recipe *recipe,
                                         const char *scratch,
                                         const struct pbnds_report *report,
                                         struct pbnds_dataset_cost *cost,
                                         struct pbnds_error *error)
{
    *cost = (struct pbnds_dataset_cost){0};
    struct pilots p = {.recipe = recipe, .scale = recipe->spp >= 32 ? 0.125 : 0.25};
    if (recipe->spp < 16) p.scale = 0.5;
    if (snprintf(p.folder, sizeof p.folder, "%s/pbnds-dry-XXXXXX", scratch) >=
            (int)sizeof p.folder ||
        !mkdtemp(p.folder)) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written", scratch);
    }
    enum pbnds_status status = pbnds_drawer_create(recipe, &p.drawer, error);
    if (status == PBNDS_OK) {
        for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
            cost->count += pbnds_drawer_count(p.drawer, (enum pbnds_split)s);
        status = try_all(&p, report, cost, error);
    }
    pbnds_drawer_free(p.drawer);
    (void)sweep(p.folder);
    (void)rmdir(p.folder);
    return status;
}
