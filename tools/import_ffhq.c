#include "tools/import_ffhq.h"

#include <stdio.h>

#include "neural/data/import_ffhq.h"
#include "tools/console.h"
#include "tools/output.h"

enum pbnds_status tool_import_ffhq(const struct tool_options *options,
                                   struct pbnds_error *error)
{
    if (options->look_given) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "import ffhq-pbr: the frame is the camera's; leave out --look");
    }
    const struct pbnds_ffhq_options how = {
        .yfov = options->fov > 0.0 ? (float)options->fov * PBNDS_PI / 180.0f : 0.0f,
        .format = (enum pbnds_dataset_format)options->format,
        .per_tar = options->per_tar};
    struct pbnds_ffhq_result result;
    PBNDS_TRY(pbnds_import_ffhq(options->inputs[1], options->output, &how,
                                tool_report(), &result, error));
    const int *count = result.count;
    if (options->json) {
        tool_json_result(options->output, 4, "train", (double)count[PBNDS_SPLIT_TRAIN],
                         "val", (double)count[PBNDS_SPLIT_VAL], "test",
                         (double)count[PBNDS_SPLIT_TEST], "left_out",
                         (double)result.left_out);
        return PBNDS_OK;
    }
    (void)printf("%s: train %d, val %d, test %d samples", options->output,
                 count[PBNDS_SPLIT_TRAIN], count[PBNDS_SPLIT_VAL],
                 count[PBNDS_SPLIT_TEST]);
    if (result.left_out > 0)
        (void)printf("; %d pictures left out, see %s/import.json", result.left_out,
                     options->output);
    (void)printf("\n");
    return PBNDS_OK;
}
