/* Writes procedural worlds and light maps for training, and the scenes and sky that
 * ship. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "scenes/generator/chart.h"
#include "scenes/generator/generate.h"
#include "scenes/generator/hdr.h"
#include "scenes/generator/sky.h"
#include "scenes/generator/still.h"
#include "scenes/generator/trial.h"

static const char USAGE[] =
    "usage: pbnds_make_scenes -o DIR [--count N] [--skies N] [--shipped] [--trial] "
    "[options]\n"
    "  -o DIR       folder for the files (made when missing)\n"
    "  --count N    writes N random worlds, world_00000.glb ...\n"
    "  --skies N    writes N random light maps, sky_00000.hdr ... (256x128)\n"
    "  --shipped    writes still_life.glb, spheres.glb, sky.hdr, chart.glb, chart.hdr\n"
    "  --trial      writes emitters.glb, lamps.glb and panes.glb, to compare "
    "renderers\n"
    "  --seed S     seed of all random choices (default 1)\n"
    "  --first I    number of the first file (default 0); file I is the same in any "
    "run\n"
    "  --threads N  threads (default: one a core)\n";

enum { SKY_WIDTH = 256, SKY_HEIGHT = 128 };

struct options {
    const char *folder;
    uint64_t count, skies, seed, first;
    int shipped, trial;
};

/* One file of a batch: i-th, under its name. */
struct job {
    const struct options *options;
    enum pbnds_status (*write)(const struct options *o, uint64_t number,
                               struct pbnds_error *error);
    enum pbnds_status *status;
    struct pbnds_error *errors;
};

static enum pbnds_status write_world(const struct options *o, uint64_t number,
                                     struct pbnds_error *error)
{
    char path[4096];
    uint8_t *glb;
    size_t size;
    (void)snprintf(path, sizeof path, "%s/world_%05llu.glb", o->folder,
                   (unsigned long long)number);
    PBNDS_TRY(pbnds_world_generate(o->seed, number, &glb, &size, error));
    const enum pbnds_status status = pbnds_file_write(path, glb, size, error);
    free(glb);
    return status;
}

static enum pbnds_status write_sky(const struct options *o, uint64_t number,
                                   struct pbnds_error *error)
{
    char path[4096];
    float *rgb = malloc(sizeof(float) * 3 * SKY_WIDTH * SKY_HEIGHT);
    if (!rgb) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a sky");
    (void)snprintf(path, sizeof path, "%s/sky_%05llu.hdr", o->folder,
                   (unsigned long long)number);
    pbnds_sky_generate(o->seed, number, SKY_WIDTH, SKY_HEIGHT, rgb);
    const enum pbnds_status status =
        gen_hdr_write(path, rgb, SKY_WIDTH, SKY_HEIGHT, error);
    free(rgb);
    return status;
}

static void write_one(void *context, size_t i, int thread)
{
    const struct job *job = context;
    (void)thread;
    job->status[i] = job->write(job->options, job->options->first + i, &job->errors[i]);
}

static enum pbnds_status write_many(struct job *job, size_t count,
                                    struct pbnds_error *error)
{
    enum pbnds_status status = PBNDS_OK;
    job->status = calloc(count + 1, sizeof *job->status);
    job->errors = calloc(count + 1, sizeof *job->errors);
    if (!job->status || !job->errors) {
        status =
            pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for %zu files", count);
    } else {
        pbnds_parallel_for(count, write_one, job);
        for (size_t i = 0; i < count && status == PBNDS_OK; ++i) {
            status = job->status[i];
            if (status != PBNDS_OK) *error = job->errors[i];
        }
    }
    free(job->status);
    free(job->errors);
    return status;
}

static enum pbnds_status write_scene(const char *folder, const char *name,
                                     void (*make)(struct gen_world *),
                                     struct pbnds_error *error)
{
    char path[4096];
    struct gen_world *w = calloc(1, sizeof *w);
    if (!w) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a scene");
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    make(w);
    const enum pbnds_status status = gen_glb_write(w, path, error);
    gen_world_free(w);
    free(w);
    return status;
}

/* Scaled so that a white surface on the ground has radiance 1. */
static enum pbnds_status write_default_sky(const char *folder,
                                           struct pbnds_error *error)
{
    enum { WIDTH = 512, HEIGHT = 256 };
    char path[4096];
    struct gen_sky sky;
    float *rgb = malloc(sizeof(float) * 3 * WIDTH * HEIGHT);
    if (!rgb) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for the sky");
    gen_default_sky(&sky);
    gen_sky_render(&sky, WIDTH, HEIGHT, rgb);
    const float scale =
        PBNDS_PI / pbnds_luminance(gen_sky_irradiance(rgb, WIDTH, HEIGHT));
    for (size_t i = 0; i < (size_t)3 * WIDTH * HEIGHT; ++i)
        rgb[i] *= scale;
    (void)snprintf(path, sizeof path, "%s/sky.hdr", folder);
    const enum pbnds_status status = gen_hdr_write(path, rgb, WIDTH, HEIGHT, error);
    free(rgb);
    return status;
}

static enum pbnds_status write_chart_light(const char *folder,
                                           struct pbnds_error *error)
{
    enum { WIDTH = 512, HEIGHT = 256 };
    char path[4096];
    float *rgb = malloc(sizeof(float) * 3 * WIDTH * HEIGHT);
    if (!rgb) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a light map");
    gen_chart_light(WIDTH, HEIGHT, rgb);
    (void)snprintf(path, sizeof path, "%s/chart.hdr", folder);
    const enum pbnds_status status = gen_hdr_write(path, rgb, WIDTH, HEIGHT, error);
    free(rgb);
    return status;
}

static enum pbnds_status run(const struct options *o, struct pbnds_error *error)
{
    struct job worlds = {.options = o, .write = write_world};
    struct job skies = {.options = o, .write = write_sky};
    PBNDS_TRY(pbnds_make_folder(o->folder, error));
    PBNDS_TRY(write_many(&worlds, (size_t)o->count, error));
    PBNDS_TRY(write_many(&skies, (size_t)o->skies, error));
    if (o->trial) {
        PBNDS_TRY(write_scene(o->folder, "emitters.glb", gen_emitters, error));
        PBNDS_TRY(write_scene(o->folder, "lamps.glb", gen_lamps, error));
        PBNDS_TRY(write_scene(o->folder, "panes.glb", gen_panes, error));
    }
    if (!o->shipped) return PBNDS_OK;
    PBNDS_TRY(write_scene(o->folder, "still_life.glb", gen_still_life, error));
    PBNDS_TRY(write_scene(o->folder, "spheres.glb", gen_sphere_grid, error));
    PBNDS_TRY(write_scene(o->folder, "chart.glb", gen_chart, error));
    PBNDS_TRY(write_chart_light(o->folder, error));
    return write_default_sky(o->folder, error);
}

/* Decimal number of at most `limit`; exits with status 2 otherwise. */
static uint64_t number(const char *option, const char *text, uint64_t limit)
{
    char *end = NULL;
    errno = 0;
    const unsigned long long value = text ? strtoull(text, &end, 10) : 0;
    if (!text || text[0] < '0' || text[0] > '9' || *end || errno || value > limit) {
        (void)fprintf(stderr, "pbnds_make_scenes: %s wants a number up to %llu\n",
                      option, (unsigned long long)limit);
        exit(2);
    }
    return value;
}

static struct options parse(int argc, char **argv)
{
    struct options o = {.seed = 1};
    for (int i = 1; i < argc; ++i) {
        const char *option = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(option, "--help") == 0) {
            (void)fputs(USAGE, stdout);
            exit(0);
        }
        if (strcmp(option, "--shipped") == 0) {
            o.shipped = 1;
            continue;
        }
        if (strcmp(option, "--trial") == 0) {
            o.trial = 1;
            continue;
        }
        if (strcmp(option, "-o") == 0 && value) {
            o.folder = value;
        } else if (strcmp(option, "--count") == 0) {
            o.count = number(option, value, 1000000);
        } else if (strcmp(option, "--skies") == 0) {
            o.skies = number(option, value, 1000000);
        } else if (strcmp(option, "--seed") == 0) {
            o.seed = number(option, value, UINT64_MAX);
        } else if (strcmp(option, "--first") == 0) {
            o.first = number(option, value, 1000000000);
        } else if (strcmp(option, "--threads") == 0) {
            pbnds_set_threads((int)number(option, value, 1024));
        } else {
            (void)fprintf(stderr, "pbnds_make_scenes: %s?\n%s", option, USAGE);
            exit(2);
        }
        ++i;
    }
    if (!o.folder || strlen(o.folder) > 4000) {
        (void)fputs(USAGE, stderr);
        exit(2);
    }
    return o;
}

int main(int argc, char **argv)
{
    const struct options o = parse(argc, argv);
    struct pbnds_error error = {""};
    if (run(&o, &error) == PBNDS_OK) return 0;
    (void)fprintf(stderr, "pbnds_make_scenes: %s\n", error.message);
    return 1;
}
