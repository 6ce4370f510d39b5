#include "tools/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    int width, digits;
    bool more_is_better;
} columns[TOOL_COLUMN_COUNT] = {
    {"mse", 9, 5, false},  {"psnr", 7, 2, true},    {"ssim", 7, 4, true},
    {"flip", 7, 4, false}, {"relmse", 9, 4, false}, {"seconds", 8, 2, false},
};

void tool_row_set(struct tool_row *row, const struct pbnds_metrics *metrics,
                  double seconds)
{
    row->value[TOOL_MSE] = metrics->mse;
    row->value[TOOL_PSNR] = metrics->psnr;
    row->value[TOOL_SSIM] = metrics->ssim;
    row->value[TOOL_FLIP] = metrics->flip;
    row->value[TOOL_RELMSE] = metrics->relmse;
    row->value[TOOL_SECONDS] = seconds;
}

int tool_ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void tool_row_summarize(struct tool_row *row, double *column[TOOL_COLUMN_COUNT],
                        int count)
{
    for (int c = 0; c < TOOL_COLUMN_COUNT; ++c) {
        double *values = column[c];
        double sum = 0.0;
        for (int i = 0; i < count; ++i)
            sum += values[i];
        row->value[c] = sum / (double)count;
        qsort(values, (size_t)count, sizeof *values, tool_ascending);
        const double place =
            (columns[c].more_is_better ? 0.1 : 0.9) * (double)(count - 1);
        const int low = (int)place;
        const int high = low + 1 < count ? low + 1 : low;
        const double part = place - (double)low;
        /* Two infinities have no difference. */
        row->tail[c] =
            part > 0.0 ? (1.0 - part) * values[low] + part * values[high] : values[low];
    }
}

static void print_values(FILE *file, const char *name, int width,
                         const double value[TOOL_COLUMN_COUNT], bool failed)
{
    (void)fprintf(file, "%-*s", width, name);
    for (int c = 0; c < TOOL_COLUMN_COUNT; ++c) {
        const int w = columns[c].width;
        if (failed) {
            (void)fprintf(file, " %*s", w, c == 0 ? "failed" : "-");
        } else if (isnan(value[c])) {
            (void)fprintf(file, " %*s", w, "-");
        } else {
            (void)fprintf(file, " %*.*f", w, columns[c].digits, value[c]);
        }
    }
    (void)fputc('\n', file);
}

void tool_table_print(FILE *file, const struct tool_table *table)
{
    int width = 8;
    for (int i = 0; i < table->row_count; ++i) {
        const int n = (int)strlen(table->rows[i].shader);
        if (n > width) width = n;
    }
    (void)fprintf(file, "%-*s", width, "shader");
    for (int c = 0; c < TOOL_COLUMN_COUNT; ++c) {
        (void)fprintf(file, " %*s", columns[c].width, columns[c].name);
    }
    (void)fputc('\n', file);
    for (int i = 0; i < table->row_count; ++i) {
        const struct tool_row *row = &table->rows[i];
        print_values(file, row->shader, width, row->value, row->failed);
        if (table->split && !row->failed) {
            print_values(file, "  p10", width, row->tail, false);
        }
    }
    if (table->split) {
        (void)fprintf(
            file,
            "Means over %d samples of split %s; p10: what the worst tenth does not "
            "reach.\n",
            table->count, table->split);
    }
}

static void json_values(FILE *file, const double value[TOOL_COLUMN_COUNT], bool failed)
{
    for (int c = 0; c < TOOL_COLUMN_COUNT; ++c) {
        (void)fprintf(file, "%s\"%s\": ", c ? ", " : "", columns[c].name);
        tool_json_number(file, failed ? (double)NAN : value[c]);
    }
}

void tool_table_json(FILE *file, const struct tool_table *table)
{
    (void)fputs("{\"against\": ", file);
    tool_json_string(file, table->against);
    (void)fprintf(file, ", \"size\": [%d, %d]", table->width, table->height);
    if (table->split) {
        (void)fprintf(file, ", \"split\": \"%s\", \"count\": %d", table->split,
                      table->count);
    }
    (void)fputs(", \"rows\": [", file);
    for (int i = 0; i < table->row_count; ++i) {
        const struct tool_row *row = &table->rows[i];
        (void)fprintf(file, "%s\n  {\"shader\": ", i ? "," : "");
        tool_json_string(file, row->shader);
        (void)fputs(", ", file);
        json_values(file, row->value, row->failed);
        if (row->failed) (void)fputs(", \"failed\": true", file);
        if (table->split && !row->failed) {
            (void)fputs(", \"p10\": {", file);
            json_values(file, row->tail, false);
            (void)fputc('}', file);
        }
        (void)fputc('}', file);
    }
    (void)fputs("\n]}\n", file);
}

enum pbnds_status tool_table_put(const struct tool_table *table, const char *json,
                                 struct pbnds_error *error)
{
    if (!json || strcmp(json, "-") != 0) tool_table_print(stdout, table);
    if (!json) return PBNDS_OK;
    struct tool_text text;
    PBNDS_TRY(tool_text_begin(&text, error));
    tool_table_json(text.file, table);
    return tool_text_end(&text, json, error);
}
