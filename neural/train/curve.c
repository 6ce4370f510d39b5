#include "neural/train/curve.h"

#include <errno.h>
#include <inttypes.h>
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
