#include "neural/train/curve.h"

#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"

static const char HEADER[] = "step,seconds,lr,loss,train_psnr,val_loss,val_psnr\n";

enum pbnds_status pbnds_curve_start(const char *path, uint64_t keep_step, int resume,
                                    struct pbnds_error *error)
{
    uint8_t *old = NULL;
    size_t size = 0;
    if (!resume ||
        pbnds_file_read(path, (size_t)1 << 28, &old, &size, NULL) != PBNDS_OK) {
        return pbnds_file_write(path, HEADER, sizeof HEADER - 1, error);
    }
    size_t kept = 0;
    for (size_t at = 0; at < size;) {
        const uint8_t *end = memchr(old + at, '\n', size - at);
        if (!end) break; /* a row cut short by a kill */
        if (at > 0 && strtoull((const char *)old + at, NULL, 10) > keep_step) break;
        at = (size_t)(end - old) + 1;
        kept = at;
    }
    const enum pbnds_status status = pbnds_file_write(path, old, kept, error);
    free(old);
    return status;
}

enum pbnds_status pbnds_curve_append(const char *path,
                                     const struct pbnds_curve_row *row,
                                     struct pbnds_error *error)
{
    FILE *file = fopen(path, "ab");
    const int written =
        file ? fprintf(file, "%" PRIu64 ",%.1f,%.3g,%.6g,%.3f,%.6g,%.3f\n", row->step,
                       row->seconds, row->lr, row->loss, row->train_psnr, row->val_loss,
                       row->val_psnr)
             : -1;
    if (!file || (fclose(file) != 0) | (written < 0)) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                          strerror(errno));
    }
    return PBNDS_OK;
}

static bool parse_row(const char *line, struct pbnds_curve_row *row)
{
    double *const columns[] = {&row->seconds,    &row->lr,       &row->loss,
                               &row->train_psnr, &row->val_loss, &row->val_psnr};
    char *end;
    row->step = strtoull(line, &end, 10);
    for (size_t i = 0; i < sizeof columns / sizeof columns[0]; ++i) {
        if (*end != ',') return false;
        *columns[i] = strtod(end + 1, &end);
    }
    return *end == '\n';
}

enum pbnds_status pbnds_curve_read(const char *path, struct pbnds_curve_row **rows,
                                   int *count, struct pbnds_error *error)
{
    uint8_t *bytes;
    size_t size;
    *rows = NULL;
    *count = 0;
    PBNDS_TRY(pbnds_file_read(path, (size_t)1 << 28, &bytes, &size, error));
    const char *text = (const char *)bytes;
    size_t lines = 0;
    for (size_t i = 0; i < size; ++i)
        lines += text[i] == '\n';
    *rows = calloc(lines + 1, sizeof **rows);
    if (!*rows) {
        free(bytes);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its rows",
                          path);
    }
    const char *line = strchr(text, '\n'); /* after the header */
    while (line && parse_row(line + 1, &(*rows)[*count])) {
        ++*count;
        line = strchr(line + 1, '\n');
    }
    free(bytes);
    return PBNDS_OK;
}
