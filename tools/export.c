/* pbnds export: a weights file as a model for other programs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "neural/features_text.h"
#include "neural/model/onnx.h"
#include "tools/commands.h"
#include "tools/output.h"
#include "tools/world.h"

enum { EXTRA = 7 };

/* The metadata of the file, and behind them what describes the inputs. */
struct metadata {
    struct pbnds_metadata *items;
    int count;
};

static void add(struct metadata *m, const char *key, const char *value)
{
    for (int i = 0; i < m->count; ++i) {
        if (strcmp(m->items[i].key, key) == 0) return; /* the file says it itself */
    }
    /* borrowed by the writer, not changed */
    m->items[m->count++] =
        (struct pbnds_metadata){(char *)(uintptr_t)key, (char *)(uintptr_t)value};
}

static enum pbnds_status write_model(const char *path,
                                     const struct pbnds_safetensors *file,
                                     const struct pbnds_model *model,
                                     const struct pbnds_net *net,
                                     struct pbnds_error *error)
{
    struct pbnds_features_text text = {0};
    struct metadata m = {0};
    char multiple[16];
    const struct pbnds_feature_table *table = pbnds_features_of(model);
    if (table) PBNDS_TRY(pbnds_features_text(table, &text, error));
    m.items = calloc((size_t)file->metadata_count + EXTRA, sizeof *m.items);
    enum pbnds_status status = PBNDS_OK;
    if (!m.items) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
        goto done;
    }
    for (int i = 0; i < file->metadata_count; ++i)
        m.items[m.count++] = file->metadata[i];
    (void)snprintf(multiple, sizeof multiple, "%d", 1 << pbnds_net_deepest_level(net));
    add(&m, "pbnds.multiple", multiple);
    if (table) {
        add(&m, "pbnds.features.view", text.view);
        add(&m, "pbnds.features.light", text.light);
        add(&m, "pbnds.features.encoding", text.encoding);
        add(&m, "pbnds.features.about", text.about);
        add(&m, "pbnds.channels.view", text.view_channels);
        add(&m, "pbnds.channels.light", text.light_channels);
    }
    status = pbnds_onnx_write(path, model, net, m.items, m.count, error);
done:
    free(m.items);
    pbnds_features_text_free(&text);
    return status;
}

static enum pbnds_status export_weights(const char *input, const char *output,
                                        const struct pbnds_model **model,
                                        double *parameters, struct pbnds_error *error)
{
    struct pbnds_safetensors file = {0};
    struct pbnds_backend *backend = NULL;
    struct pbnds_net *net = NULL;
    PBNDS_TRY(pbnds_weights_open(input, &file, model, error));
    enum pbnds_status status = pbnds_backend_create_onednn(&backend, error);
    if (status == PBNDS_OK)
        status = pbnds_net_create(&(*model)->table, backend, PBNDS_F32, &net, error);
    if (status == PBNDS_OK) status = pbnds_weights_apply(input, &file, net, error);
    if (status == PBNDS_OK) {
        *parameters = (double)pbnds_net_param_count(net);
        status = write_model(output, &file, *model, net, error);
    }
    pbnds_net_free(net);
    pbnds_backend_free(backend);
    pbnds_safetensors_free(&file);
    return status;
}

static enum pbnds_status run(const struct tool_options *options,
                             struct pbnds_error *error)
{
    const char *input = options->inputs[0], *output = options->output;
    const struct pbnds_model *model;
    double parameters;
    if (!options->onnx && !tool_has_extension(output, ".onnx")) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: models are written as .onnx (or give --onnx)", output);
    }
    PBNDS_TRY(tool_output_check(output, error));
    PBNDS_TRY(export_weights(input, output, &model, &parameters, error));
    if (options->json) {
        tool_json_result(output, 1, "parameters", parameters);
    } else {
        (void)printf("%s: %s as ONNX, %.0f parameters; view_input [1, %d, h, w], "
                     "light_input [N, %d, h, w]\n",
                     output, model->name, parameters, model->view_channels,
                     model->light_channels);
    }
    return PBNDS_OK;
}

const struct tool_command tool_export = {
    .name = "export",
    .mask = TOOL_EXPORT,
    .min_inputs = 1,
    .max_inputs = 1,
    .needs_output = true,
    .usage = "export WEIGHTS.safetensors -o MODEL.onnx [--onnx]",
    .about = "writes weights as an ONNX model",
    .details =
        "ONNX opset 13, one view: view_input [1, C, h, w] and light_input [N, C', h, "
        "w] "
        "give\n"
        "light_output [N, K, h, w] and, of transport, view_output [1, 1, h, w]; "
        "float32, "
        "NCHW;\n"
        "h, w (multiples of pbnds.multiple) and N are free. The model's metadata are "
        "those of the\n"
        "weights and tell what each channel is (pbnds.channels.*, pbnds.features.*); "
        "what becomes\n"
        "of the outputs is in their doc strings.\n\n"
        "  pbnds export transport.safetensors -o transport.onnx\n"
        "  pbnds export --onnx transport.safetensors -o model.bin",
    .run = run,
};
