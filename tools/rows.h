/**
 * @file rows.h
 * The table that `compare` prints: one row a shader.
 */
#ifndef PBNDS_TOOLS_ROWS_H
#define PBNDS_TOOLS_ROWS_H

#include "neural/metrics/metrics.h"
#include "tools/output.h"

enum { TOOL_MAX_SHADERS = 32 };

enum tool_column {
    TOOL_MSE,
    TOOL_PSNR,
    TOOL_SSIM,
    TOOL_FLIP,
    TOOL_RELMSE,
    TOOL_SECONDS,
    TOOL_COLUMN_COUNT
};

struct tool_row {
    const char *shader;
    double value[TOOL_COLUMN_COUNT]; /**< of one picture, or the mean of many */
    double tail[TOOL_COLUMN_COUNT];  /**< many: what the worst tenth does not reach  */
    bool failed;
};

/** What stands above the rows in the JSON file. */
struct tool_table {
    const struct tool_row *rows;
    int row_count;
    const char *against;
    int width, height;
    const char *split; /**< NULL: one picture, no tail */
    int count;         /**< samples behind each row    */
};

/** For qsort() of doubles. */
int tool_ascending(const void *a, const void *b);
void tool_row_set(struct tool_row *row, const struct pbnds_metrics *metrics,
                  double seconds);
/** Mean and tail of `count` samples a column; sorts the columns in place. The tail is
 * the 10th percentile of quality: of PSNR and SSIM the 10th, of the errors and the
 * seconds the 90th percentile, by linear interpolation. */
void tool_row_summarize(struct tool_row *row, double *column[TOOL_COLUMN_COUNT],
                        int count);
void tool_table_print(FILE *file, const struct tool_table *table);
void tool_table_json(FILE *file, const struct tool_table *table);
/** Prints the table, and writes it as JSON where `json` names a file; "-": JSON on stdout in
 *  the table's place. */
enum pbnds_status tool_table_put(const struct tool_table *table, const char *json,
                                 struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_ROWS_H */
