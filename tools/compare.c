/* pbnds compare: the same view through several shaders, against a truth. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "engine/image/oiio.h"
#include "engine/image/sheet.h"
#include "tools/commands.h"
#include "tools/compare_data.h"
#include "tools/console.h"
#include "tools/rows.h"
#include "tools/shaders.h"

static const char default_shaders[] = "blinn-phong,ggx,pbnds+,neural";

/* What the rows are compared with. */
struct truth {
    const char *name;  /* for the JSON file and the sheet */
    bool display_only; /* an 8-bit picture: its radiance is not known */
    struct pbnds_image linear, shown;
    struct pbnds_image alpha; /* the reference's own coverage, or empty */
};

/* One shader's part of the work. */
struct entry {
    struct tool_row row;
    struct pbnds_image shown; /* with background */
    struct pbnds_image map;   /* error, coloured */
    char label[128];
};

struct comparison {
    const struct tool_options *options;
    struct pbnds_display display;
    struct tool_world world;
    struct truth truth;
    struct entry entries[TOOL_MAX_SHADERS];
    int count, failed;
};

/* DIR/NAME SUFFIX, with everything odd in a name (neural:a/b.safetensors) replaced. */
static enum pbnds_status file_name(char *path, size_t size, const char *dir,
                                   const char *name, const char *suffix,
                                   struct pbnds_error *error)
{
    const int n = snprintf(path, size, "%s/%s%s", dir, name, suffix);
    if (n < 0 || (size_t)n >= size) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: is too long a name", dir);
    }
    for (char *at = path + strlen(dir) + 1; *at; ++at) {
        const bool fine = (*at >= 'a' && *at <= 'z') || (*at >= 'A' && *at <= 'Z') ||
                          (*at >= '0' && *at <= '9') || strchr("+-._", *at);
        if (!fine) *at = '_';
    }
    return PBNDS_OK;
}

static enum pbnds_status shade(const struct comparison *c, const char *name,
                               uint64_t seed, int spp, struct pbnds_image *radiance,
                               struct pbnds_image *alpha, double *seconds,
                               struct pbnds_error *error)
{
    struct tool_shader shader;
    PBNDS_TRY(tool_shader_open(name, c->options->precision, &shader, error));
    struct pbnds_shade_job job = tool_world_job(c->options, &c->world);
    job.seed = seed;
    job.spp = spp;
    job.alpha = alpha;
    const double start = tool_seconds();
    enum pbnds_status status = pbnds_shade(shader.shader, &job, radiance, error);
    *seconds = tool_seconds() - start;
    if (status == PBNDS_OK) status = tool_check_stop(error);
    tool_shader_close(&shader);
    return status;
}

static int reference_spp(const struct tool_options *options)
{
    return options->reference_spp ? options->reference_spp : options->spp;
}

/* The display values of a picture that was decoded from them. */
static enum pbnds_status show_picture(struct truth *truth, struct pbnds_error *error)
{
    const struct pbnds_display plain = {0.0f, PBNDS_TONEMAP_NONE};
    truth->display_only = true;
    return tool_displayed(&truth->linear, &plain, &truth->shown, error);
}

/* --against FILE, read before anything slow. An 8-bit picture comes back linear; its
 * display values are the code values it was made of. */
static enum pbnds_status read_truth(struct comparison *c, const char *path,
                                    struct pbnds_error *error)
{
    struct truth *truth = &c->truth;
    truth->name = path;
    PBNDS_TRY(pbnds_image_read_rgb(path, &truth->linear, error));
    if (tool_has_extension(path, ".exr") || tool_has_extension(path, ".hdr"))
        return PBNDS_OK;
    return show_picture(truth, error);
}

/* The truth of this view, unless it was read from a file already. */
static enum pbnds_status make_truth(struct comparison *c, struct pbnds_error *error)
{
    struct truth *truth = &c->truth;
    const struct tool_options *options = c->options;
    if (!truth->linear.data && !options->against && c->world.stored.data) {
        truth->name = options->inputs[0];
        truth->linear = c->world.stored;
        c->world.stored = (struct pbnds_image){0, 0, 0, NULL};
        if (c->world.stored_target == PBNDS_TARGET_DISPLAY) {
            c->display.tonemap = PBNDS_TONEMAP_NONE; /* as the photograph is shown */
            PBNDS_TRY(show_picture(truth, error));
        }
    } else if (!truth->linear.data) {
        truth->name = "reference";
        if (!c->world.accel) {
            return pbnds_fail(
                error, PBNDS_ERROR_ARGUMENT,
                "%s: carries no picture and the reference needs the scene; "
                "give --against IMAGE",
                options->inputs[0]);
        }
        double seconds = 0.0;
        PBNDS_TRY(shade(c, "reference", options->seed, reference_spp(options),
                        &truth->linear, &truth->alpha, &seconds, error));
    }
    if (truth->linear.width != c->world.gbuffer.width ||
        truth->linear.height != c->world.gbuffer.height) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: is %dx%d and the view is %dx%d; give --size %dx%d",
                          truth->name, truth->linear.width, truth->linear.height,
                          c->world.gbuffer.width, c->world.gbuffer.height,
                          truth->linear.width, truth->linear.height);
    }
    if (truth->shown.data) return PBNDS_OK;
    return tool_displayed(&truth->linear, &c->display, &truth->shown, error);
}

static enum pbnds_status measure(struct comparison *c, struct entry *entry,
                                 const struct pbnds_image *radiance, double seconds,
                                 struct pbnds_error *error)
{
    struct pbnds_image map = {0, 0, 0, NULL};
    struct pbnds_metrics metrics;
    PBNDS_TRY(tool_displayed(radiance, &c->display, &entry->shown, error));
    enum pbnds_status status = pbnds_metrics_compare(
        &entry->shown, &c->truth.shown, radiance, &c->truth.linear,
        c->world.gbuffer.coverage, &metrics, &map, error);
    if (status == PBNDS_OK) status = pbnds_colorize(&map, &entry->map, error);
    pbnds_image_free(&map);
    if (status != PBNDS_OK) return status;
    if (c->truth.display_only) metrics.relmse = (double)NAN;
    tool_row_set(&entry->row, &metrics, seconds);
    (void)snprintf(entry->label, sizeof entry->label, "%s\n%.2f dB FLIP %.3f %.2f s",
                   entry->row.shader, metrics.psnr, metrics.flip, seconds);
    return PBNDS_OK;
}

/* NAME.exr, NAME.png, NAME_error.png */
static enum pbnds_status write_entry(struct comparison *c, struct entry *entry,
                                     struct pbnds_image *radiance,
                                     const struct pbnds_image *alpha,
                                     struct pbnds_error *error)
{
    char path[1400];
    const char *dir = c->options->output, *name = entry->row.shader;
    tool_background(&c->world, c->options->background, alpha, radiance);
    pbnds_display_image(&c->display, radiance, &entry->shown);
    PBNDS_TRY(file_name(path, sizeof path, dir, name, ".exr", error));
    PBNDS_TRY(
        tool_picture_write(path, &c->world, radiance, alpha, NULL, &c->display, error));
    PBNDS_TRY(file_name(path, sizeof path, dir, name, ".png", error));
    PBNDS_TRY(pbnds_png_write(path, &entry->shown, error));
    PBNDS_TRY(file_name(path, sizeof path, dir, name, "_error.png", error));
    return pbnds_png_write(path, &entry->map, error);
}

/* A row `reference` beside a reference truth gets other random numbers: it shows how
 * much of every distance is the truth's own noise. */
static enum pbnds_status run_entry(struct comparison *c, struct entry *entry,
                                   struct pbnds_error *error)
{
    const bool reference = strcmp(entry->row.shader, "reference") == 0;
    const uint64_t seed = c->options->seed ^ (reference ? 0x9e3779b97f4a7c15u : 0u);
    struct pbnds_image radiance = {0, 0, 0, NULL}, alpha = radiance;
    struct pbnds_error reason = {""};
    double seconds = 0.0;
    enum pbnds_status status =
        shade(c, entry->row.shader, seed,
              reference ? reference_spp(c->options) : c->options->spp, &radiance,
              &alpha, &seconds, &reason);
    if (status == PBNDS_OK) status = measure(c, entry, &radiance, seconds, &reason);
    if (status == PBNDS_ERROR_INTERRUPTED) {
        (void)pbnds_fail(error, status, "%s", reason.message);
    } else if (status != PBNDS_OK) {
        tool_console_clear();
        (void)fprintf(stderr, "pbnds: %s: %s\n", entry->row.shader, reason.message);
        (void)snprintf(entry->label, sizeof entry->label, "%s\nfailed",
                       entry->row.shader);
        entry->row.failed = true;
        ++c->failed;
        status = PBNDS_OK;
    } else {
        status = write_entry(c, entry, &radiance, &alpha, error);
    }
    pbnds_image_free(&radiance);
    pbnds_image_free(&alpha);
    return status;
}

/* Pictures above, their error maps below; the truth first. */
static enum pbnds_status write_sheet(struct comparison *c, struct pbnds_error *error)
{
    struct pbnds_sheet_cell cells[2 * (TOOL_MAX_SHADERS + 1)];
    const int columns = c->count + 1;
    char label[128], path[1400];
    (void)snprintf(label, sizeof label, "%s\nthe truth", tool_base_name(c->truth.name));
    cells[0] = (struct pbnds_sheet_cell){&c->truth.shown, label};
    cells[columns] = (struct pbnds_sheet_cell){NULL, "error: FLIP"};
    for (int i = 0; i < c->count; ++i) {
        const struct entry *entry = &c->entries[i];
        const bool failed = entry->row.failed;
        cells[1 + i] =
            (struct pbnds_sheet_cell){failed ? NULL : &entry->shown, entry->label};
        cells[columns + 1 + i] =
            (struct pbnds_sheet_cell){failed ? NULL : &entry->map, entry->row.shader};
    }
    struct pbnds_image sheet = {0, 0, 0, NULL};
    PBNDS_TRY(pbnds_sheet_make(cells, 2 * columns, columns, &sheet, error));
    enum pbnds_status status =
        file_name(path, sizeof path, c->options->output, "compare", ".png", error);
    if (status == PBNDS_OK) status = pbnds_png_write(path, &sheet, error);
    pbnds_image_free(&sheet);
    return status;
}

/* against.exr, against.png: with background, as the others. */
static enum pbnds_status write_truth(struct comparison *c, struct pbnds_error *error)
{
    char path[1400];
    if (!c->truth.display_only) {
        /* a picture from a file is what is seen already */
        const bool traced = strcmp(c->truth.name, "reference") == 0;
        if (traced) {
            tool_background(&c->world, c->options->background, &c->truth.alpha,
                            &c->truth.linear);
            pbnds_display_image(&c->display, &c->truth.linear, &c->truth.shown);
        }
        PBNDS_TRY(
            file_name(path, sizeof path, c->options->output, "against", ".exr", error));
        PBNDS_TRY(tool_picture_write(path, &c->world, &c->truth.linear, &c->truth.alpha,
                                     NULL, &c->display, error));
    }
    PBNDS_TRY(
        file_name(path, sizeof path, c->options->output, "against", ".png", error));
    return pbnds_png_write(path, &c->truth.shown, error);
}

static enum pbnds_status write_table(const struct comparison *c,
                                     struct pbnds_error *error)
{
    struct tool_row rows[TOOL_MAX_SHADERS];
    for (int i = 0; i < c->count; ++i)
        rows[i] = c->entries[i].row;
    const struct tool_table table = {.rows = rows,
                                     .row_count = c->count,
                                     .against = c->truth.name,
                                     .width = c->world.gbuffer.width,
                                     .height = c->world.gbuffer.height};
    return tool_table_put(&table, c->options->json_file, error);
}

static enum pbnds_status compare_view(struct comparison *c, struct pbnds_error *error)
{
    const struct tool_options *options = c->options;
    const char *input = options->inputs[0];
    PBNDS_TRY(tool_folder_check(options->output, error));
    if (options->against && strcmp(options->against, "reference") != 0) {
        PBNDS_TRY(read_truth(c, options->against, error));
    }
    PBNDS_TRY(tool_has_extension(input, ".exr")
                  ? tool_world_gbuffer(options, input, &c->world, error)
                  : tool_world_scene(options, input, &c->world, error));
    PBNDS_TRY(tool_world_light(options, &c->world, error));
    PBNDS_TRY(make_truth(c, error));
    for (int i = 0; i < c->count; ++i)
        PBNDS_TRY(run_entry(c, &c->entries[i], error));
    PBNDS_TRY(write_truth(c, error));
    PBNDS_TRY(write_sheet(c, error));
    PBNDS_TRY(write_table(c, error));
    if (c->failed) {
        return pbnds_fail(error, PBNDS_ERROR_BACKEND,
                          "compare: %d of %d shaders failed", c->failed, c->count);
    }
    return PBNDS_OK;
}

/* Two names may become one file name. */
static enum pbnds_status check_names(const char *const *names, int count,
                                     struct pbnds_error *error)
{
    char a[512], b[512];
    for (int i = 0; i < count; ++i) {
        PBNDS_TRY(tool_shader_check(names[i], error));
        PBNDS_TRY(file_name(a, sizeof a, ".", names[i], "", error));
        for (int j = 0; j < i; ++j) {
            PBNDS_TRY(file_name(b, sizeof b, ".", names[j], "", error));
            if (strcmp(a, b) == 0) {
                return pbnds_fail(
                    error, PBNDS_ERROR_ARGUMENT,
                    "--shaders: '%s' and '%s' would be written to the same "
                    "files",
                    names[j], names[i]);
            }
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status compare_names(const struct tool_options *options,
                                       const char *const *names, int count,
                                       struct pbnds_error *error)
{
    PBNDS_TRY(check_names(names, count, error));
    if (options->json_file && strcmp(options->json_file, "-") != 0) {
        PBNDS_TRY(tool_output_check(options->json_file, error));
    }
    struct stat info;
    if (stat(options->inputs[0], &info) == 0 && S_ISDIR(info.st_mode)) {
        return tool_compare_data(options, options->inputs[0], names, count, error);
    }
    if (!options->output || options->split >= 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          options->output ? "--split goes with a data set folder"
                                          : "compare: -o DIR is missing");
    }
    struct comparison *c = calloc(1, sizeof *c);
    if (!c)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for the comparison");
    c->options = options;
    c->display = tool_display(options);
    c->count = count;
    for (int i = 0; i < count; ++i)
        c->entries[i].row.shader = names[i];
    const enum pbnds_status status = compare_view(c, error);
    for (int i = 0; i < count; ++i) {
        pbnds_image_free(&c->entries[i].shown);
        pbnds_image_free(&c->entries[i].map);
    }
    pbnds_image_free(&c->truth.linear);
    pbnds_image_free(&c->truth.alpha);
    pbnds_image_free(&c->truth.shown);
    tool_world_free(&c->world);
    free(c);
    return status;
}

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    const char *names[TOOL_MAX_SHADERS];
    int count = 0;
    char *storage = NULL;
    enum pbnds_status status = tool_split_list(
        "shaders", options->shaders ? options->shaders : default_shaders, names,
        TOOL_MAX_SHADERS, &count, &storage, error);
    if (status == PBNDS_OK) status = compare_names(options, names, count, error);
    free(storage);
    return status;
}

const struct tool_command tool_compare = {
    .name = "compare",
    .mask = TOOL_COMPARE,
    .min_inputs = 1,
    .max_inputs = 1,
    .needs_output = false,
    .usage = "compare SCENE|GBUFFER.exr|DATA [-o DIR] --shaders A,B,C [options]",
    .about = "scores shaders against the reference, a picture or a data set",
    .details = "For a view: writes NAME.exr, NAME.png and NAME_error.png for each "
               "shader, the truth as\n"
               "against.exr and against.png, and the contact sheet compare.png; prints "
               "a table.\n"
               "mse, psnr, ssim and flip are taken on the tone-mapped picture, relmse "
               "on linear\n"
               "radiance, all over the pixels that the scene covers. A row 'reference' "
               "is rendered\n"
               "with other random numbers than the truth: it shows the truth's own "
               "noise. The truth\n"
               "of a G-buffer is the picture it carries, else --against IMAGE.\n\n"
               "For a data set folder: shades every sample of --split from its "
               "G-buffer and light map\n"
               "alone and prints mean and worst tenth; -o is optional and gets a "
               "contact sheet.\n"
               "A shader that fails gets a row that says so; the others go on; the "
               "status is 1.\n\n"
               "  pbnds compare scene.glb -o out --env studio.hdr --shaders "
               "ggx,neural,reference\n"
               "  pbnds compare g.exr -o out --against photo.png --shaders ggx,neural\n"
               "  pbnds compare data/ --split test --shaders ggx,pbnds+,neural --json "
               "scores.json",
    .run = run,
};
