#include "tools/compare_data.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/image/oiio.h"
#include "engine/image/sheet.h"
#include "neural/data/dataset.h"
#include "tools/console.h"
#include "tools/rows.h"
#include "tools/shaders.h"

enum { SHEET_SAMPLES = 16, CELL_LABEL = 64 };

struct scorer {
    const struct tool_options *options;
    struct pbnds_display display;
    const char *const *names;
    int count;
    struct tool_shader shaders[TOOL_MAX_SHADERS];
    struct tool_row rows[TOOL_MAX_SHADERS];
    int failed;
    struct pbnds_sample_list list;
    double *values; /* [shader][column][sample] */
    int width, height;
    /* The sheet: a row a sample, the truth last. NULL without -o. */
    struct pbnds_image *pictures;
    char (*labels)[CELL_LABEL];
};

static double *column(const struct scorer *s, int shader, int c)
{
    return s->values +
           ((size_t)shader * TOOL_COLUMN_COUNT + (size_t)c) * (size_t)s->list.count;
}

static void give_up(struct scorer *s, int shader, const struct pbnds_error *reason)
{
    tool_console_clear();
    (void)fprintf(stderr, "pbnds: %s: %s\n", s->names[shader], reason->message);
    s->rows[shader].failed = true;
    ++s->failed;
}

/* Takes `shown` over when the sample is one of the sheet's. */
static void keep_picture(struct scorer *s, int sample, int cell,
                         struct pbnds_image *shown, const char *label, double psnr)
{
    if (s->pictures && sample < SHEET_SAMPLES) {
        const int at = sample * (s->count + 1) + cell;
        s->pictures[at] = *shown;
        *shown = (struct pbnds_image){0, 0, 0, NULL};
        if (psnr >= 0.0) {
            (void)snprintf(s->labels[at], CELL_LABEL, "%s %.2f dB", label, psnr);
        } else {
            (void)snprintf(s->labels[at], CELL_LABEL, "%s", label);
        }
    }
    pbnds_image_free(shown);
}

static enum pbnds_status score(struct scorer *s, const struct pbnds_sample *sample,
                               int i, int shader, const struct pbnds_image *truth_shown,
                               struct pbnds_error *error)
{
    const struct pbnds_shade_job job = {
        .gbuffer = &sample->gbuffer,
        .envmap = sample->envmap,
        .seed = s->options->seed + (uint64_t)i,
        .spp = s->options->spp,
        .lights = s->options->lights,
        .shadows = 0,
        .max_memory = (size_t)s->options->max_memory_mb << 20,
        .report = NULL,
    };
    struct pbnds_image radiance = {0, 0, 0, NULL}, shown = {0, 0, 0, NULL};
    struct pbnds_metrics m;
    const double start = tool_seconds();
    enum pbnds_status status =
        pbnds_shade(s->shaders[shader].shader, &job, &radiance, error);
    const double seconds = tool_seconds() - start;
    if (status == PBNDS_OK) status = tool_check_stop(error);
    struct pbnds_display display = s->display;
    if (sample->target == PBNDS_TARGET_DISPLAY) display.tonemap = PBNDS_TONEMAP_NONE;
    if (status == PBNDS_OK) status = tool_displayed(&radiance, &display, &shown, error);
    if (status == PBNDS_OK) {
        status =
            pbnds_metrics_compare(&shown, truth_shown, &radiance, &sample->radiance,
                                  sample->gbuffer.coverage, &m, NULL, error);
    }
    if (status == PBNDS_OK) {
        struct tool_row row;
        if (sample->target == PBNDS_TARGET_DISPLAY) m.relmse = (double)NAN;
        tool_row_set(&row, &m, seconds);
        for (int c = 0; c < TOOL_COLUMN_COUNT; ++c) {
            column(s, shader, c)[i] = row.value[c];
        }
        keep_picture(s, i, shader, &shown, s->names[shader], m.psnr);
    }
    pbnds_image_free(&shown);
    pbnds_image_free(&radiance);
    return status;
}

static enum pbnds_status score_sample(struct scorer *s, int i,
                                      struct pbnds_error *error)
{
    struct pbnds_sample sample;
    PBNDS_TRY(pbnds_sample_load(s->list.folders[i], 0, &sample, error));
    struct pbnds_image truth = {0, 0, 0, NULL};
    /* A photograph is shown as it was taken; what is compared with it gets the exposure,
     * but no tone map either. */
    const struct pbnds_display plain = {0.0f, PBNDS_TONEMAP_NONE};
    const bool photograph = sample.target == PBNDS_TARGET_DISPLAY;
    enum pbnds_status status = tool_displayed(
        &sample.radiance, photograph ? &plain : &s->display, &truth, error);
    if (status == PBNDS_OK && i == 0) {
        s->width = sample.gbuffer.width;
        s->height = sample.gbuffer.height;
    }
    for (int k = 0; k < s->count && status == PBNDS_OK; ++k) {
        struct pbnds_error reason = {""};
        if (s->rows[k].failed) continue;
        status = score(s, &sample, i, k, &truth, &reason);
        if (status == PBNDS_ERROR_INTERRUPTED) {
            (void)pbnds_fail(error, status, "%s", reason.message);
        } else if (status != PBNDS_OK) {
            give_up(s, k, &reason);
            status = PBNDS_OK;
        }
    }
    if (status == PBNDS_OK) {
        keep_picture(s, i, s->count, &truth, tool_base_name(s->list.folders[i]), -1.0);
    }
    pbnds_image_free(&truth);
    pbnds_sample_free(&sample);
    return status;
}

static enum pbnds_status write_sheet(const struct scorer *s, struct pbnds_error *error)
{
    const int columns = s->count + 1;
    const int samples = s->list.count < SHEET_SAMPLES ? s->list.count : SHEET_SAMPLES;
    struct pbnds_sheet_cell cells[SHEET_SAMPLES * (TOOL_MAX_SHADERS + 1)];
    for (int i = 0; i < samples * columns; ++i) {
        cells[i] = (struct pbnds_sheet_cell){
            s->pictures[i].data ? &s->pictures[i] : NULL, s->labels[i]};
    }
    struct pbnds_image sheet = {0, 0, 0, NULL};
    PBNDS_TRY(pbnds_sheet_make(cells, samples * columns, columns, &sheet, error));
    char path[1400];
    (void)snprintf(path, sizeof path, "%s/compare.png", s->options->output);
    const enum pbnds_status status = pbnds_png_write(path, &sheet, error);
    pbnds_image_free(&sheet);
    return status;
}

static enum pbnds_status write_table(struct scorer *s, const char *split,
                                     struct pbnds_error *error)
{
    for (int k = 0; k < s->count; ++k) {
        double *columns[TOOL_COLUMN_COUNT];
        for (int c = 0; c < TOOL_COLUMN_COUNT; ++c)
            columns[c] = column(s, k, c);
        if (!s->rows[k].failed) tool_row_summarize(&s->rows[k], columns, s->list.count);
    }
    const struct tool_table table = {.rows = s->rows,
                                     .row_count = s->count,
                                     .against = "reference",
                                     .width = s->width,
                                     .height = s->height,
                                     .split = split,
                                     .count = s->list.count};
    return tool_table_put(&table, s->options->json_file, error);
}

static enum pbnds_status allocate(struct scorer *s, struct pbnds_error *error)
{
    const size_t n = (size_t)s->list.count;
    const size_t cells = SHEET_SAMPLES * (size_t)(s->count + 1);
    s->values = calloc((size_t)s->count * TOOL_COLUMN_COUNT * n, sizeof *s->values);
    if (s->options->output) {
        s->pictures = calloc(cells, sizeof *s->pictures);
        s->labels = calloc(cells, sizeof *s->labels);
    }
    if (!s->values || (s->options->output && (!s->pictures || !s->labels))) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for the scores");
    }
    return PBNDS_OK;
}

static enum pbnds_status score_all(struct scorer *s, const char *dir,
                                   struct pbnds_error *error)
{
    const enum pbnds_split split =
        s->options->split >= 0 ? (enum pbnds_split)s->options->split : PBNDS_SPLIT_TEST;
    if (s->options->output) PBNDS_TRY(tool_folder_check(s->options->output, error));
    PBNDS_TRY(pbnds_dataset_list(dir, split, &s->list, error));
    if (s->list.count == 0) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: has no samples of split %s",
                          dir, pbnds_split_name(split));
    }
    PBNDS_TRY(allocate(s, error));
    for (int k = 0; k < s->count; ++k) {
        struct pbnds_error reason = {""};
        s->rows[k].shader = s->names[k];
        if (tool_shader_open(s->names[k], s->options->precision, &s->shaders[k],
                             &reason) != PBNDS_OK) {
            give_up(s, k, &reason);
        }
    }
    for (int i = 0; i < s->list.count; ++i) {
        PBNDS_TRY(score_sample(s, i, error));
        pbnds_progress(tool_report(), "compare", i + 1.0, s->list.count);
    }
    if (s->options->output) PBNDS_TRY(write_sheet(s, error));
    PBNDS_TRY(write_table(s, pbnds_split_name(split), error));
    if (s->failed) {
        return pbnds_fail(error, PBNDS_ERROR_BACKEND,
                          "compare: %d of %d shaders failed", s->failed, s->count);
    }
    return PBNDS_OK;
}

enum pbnds_status tool_compare_data(const struct tool_options *options, const char *dir,
                                    const char *const *names, int count,
                                    struct pbnds_error *error)
{
    struct scorer *s = calloc(1, sizeof *s);
    if (!s)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for the comparison");
    s->options = options;
    s->display = tool_display(options);
    s->names = names;
    s->count = count;
    const enum pbnds_status status = score_all(s, dir, error);
    for (int i = 0; s->pictures && i < SHEET_SAMPLES * (count + 1); ++i) {
        pbnds_image_free(&s->pictures[i]);
    }
    for (int k = 0; k < count; ++k)
        tool_shader_close(&s->shaders[k]);
    pbnds_sample_list_free(&s->list);
    free(s->pictures);
    free(s->labels);
    free(s->values);
    free(s);
    return status;
}
