/* pbnds train: weights from a data set. */
#include <stdio.h>

#include "engine/core/ranks.h"
#include "neural/train/task.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/output.h"

static enum pbnds_status check_model(const char *model, struct pbnds_error *error)
{
    char names[128];
    pbnds_task_names(names, sizeof names);
    if (!model) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "train: --model is missing; there are %s", names);
    }
    if (!pbnds_task_find(model)) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "--model: '%s' is not a model that this version trains; there "
            "are %s",
            model, names);
    }
    return PBNDS_OK;
}

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    PBNDS_TRY(check_model(options->model, error));
    if (options->crop % 16 != 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "--crop: '%d' is not a multiple of 16", options->crop);
    }
    if (!tool_has_extension(options->output, ".safetensors")) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: weights are written as .safetensors", options->output);
    }
    PBNDS_TRY(tool_output_check(options->output, error));
    const bool bf16 =
        options->precision == TOOL_PRECISION_BF16 ||
        (options->precision == TOOL_PRECISION_AUTO && pbnds_backend_has_fast_bf16());
    const struct pbnds_train_options train = {
        .data = options->inputs[0],
        .weights = options->output,
        .model = options->model,
        .init = options->init,
        .steps = options->steps,
        .batch = options->batch,
        .accumulate = options->accumulate,
        .lights = options->lights,
        .crop = options->crop,
        .lr = options->lr,
        .weight_decay = options->weight_decay,
        .ema = options->ema,
        .augment = options->augment == 1,
        .checkpoint_every = options->checkpoint_every,
        .sheet_every = options->sheet_every,
        .seconds = 60.0 * options->minutes,
        .p_dark = options->p_dark,
        .lambda_zero = options->lambda_zero,
        .seed = options->seed,
        .resume = options->resume,
        .max_memory = (size_t)options->max_memory_mb << 20,
        .dtype = bf16 ? PBNDS_BF16 : PBNDS_F32,
    };
    const double start = tool_seconds();
    PBNDS_TRY(pbnds_train(&train, tool_report(), error));
    const double seconds = tool_seconds() - start;
    if (pbnds_rank() > 0) return PBNDS_OK;
    if (options->json) {
        tool_json_result(options->output, 1, "seconds", seconds);
    } else {
        (void)printf("%s: %s, trained for %.1f min\n", options->output, options->model,
                     seconds / 60.0);
    }
    return PBNDS_OK;
}

const struct tool_command tool_train = {
    .name = "train",
    .mask = TOOL_TRAIN,
    .min_inputs = 1,
    .max_inputs = 1,
    .needs_output = true,
    .usage = "train DATA -o WEIGHTS.safetensors --model pbnds+|transport [options]",
    .about = "trains a shader on a data set",
    .details =
        "DATA is a folder made by 'pbnds dataset'. Beside the weights it writes the "
        "loss curve\n"
        "(WEIGHTS.safetensors.csv, and .png as a plot), predictions beside references\n"
        "(WEIGHTS.safetensors.sheet.png) and, while it runs, a checkpoint\n"
        "(WEIGHTS.safetensors.checkpoint): after Ctrl-C, a kill or --minutes the same "
        "command\n"
        "with --resume goes on exactly there.\n"
        "Under mpirun every process takes --batch views a step, and the first one "
        "writes.\n\n"
        "  pbnds train data/ -o transport.safetensors --model transport --steps 20000\n"
        "  pbnds train data/ -o u.safetensors --model pbnds+ --minutes 60 --p-dark "
        "0.1\n"
        "  mpirun -n 4 pbnds train data/ -o m.safetensors --model transport --threads "
        "1\n"
        "  pbnds render scene.glb -o out.png --shader neural:transport.safetensors",
    .run = run,
};
