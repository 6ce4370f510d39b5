#include <string.h>

#include "neural/model/model.h"
#include "tools/weights.h"

/* Which key is told where under which name; what is none of these goes to "more". */
struct place {
    const char *key, *section, *name;
};
static const struct place PLACES[] = {
    {"pbnds.model", NULL, "model"},
    {"pbnds.version", NULL, "version"},
    {"pbnds.architecture", NULL, "architecture"},
    {"pbnds.light_mode", "lights", "mode"},
    {"pbnds.lights", "lights", "in training"},
    {"pbnds.features", "features", "version"},
    {"pbnds.features.view", "features", "view"},
    {"pbnds.features.light", "features", "light"},
    {"pbnds.features.encoding", "features", "encoding"},
    {"pbnds.program", "training", "program"},
    {"train.data", "training", "data"},
    {"train.recipe", "training", "recipe"},
    {"train.step", "training", "step"},
    {"train.steps", "training", "of steps"},
    {"train.seed", "training", "seed"},
    {"train.dtype", "training", "precision"},
    {"train.validation_psnr_srgb", "training", "validation PSNR dB"},
};
enum { PLACE_COUNT = sizeof PLACES / sizeof PLACES[0] };

static const struct place *place_of(const char *key)
{
    for (int i = 0; i < PLACE_COUNT; ++i) {
        if (strcmp(PLACES[i].key, key) == 0) return &PLACES[i];
    }
    return NULL;
}

static cJSON *section(cJSON *facts, const char *name)
{
    if (!name) return facts;
    cJSON *found = cJSON_GetObjectItemCaseSensitive(facts, name);
    return found ? found : cJSON_AddObjectToObject(facts, name);
}

static void add_provenance(const struct pbnds_safetensors *file, cJSON *facts)
{
    for (int i = 0; i < PLACE_COUNT; ++i) {
        const char *value = pbnds_safetensors_metadata(file, PLACES[i].key);
        if (value)
            tool_add_text(section(facts, PLACES[i].section), PLACES[i].name, value);
    }
    for (int i = 0; i < file->metadata_count; ++i) {
        const struct pbnds_metadata *m = &file->metadata[i];
        if (!place_of(m->key)) tool_add_text(section(facts, "more"), m->key, m->value);
    }
}

static void add_tensors(const struct pbnds_safetensors *file, cJSON *facts)
{
    cJSON *tensors = cJSON_AddArrayToObject(facts, "tensors");
    for (int i = 0; i < file->tensor_count; ++i) {
        cJSON *item = tool_add_item(tensors);
        tool_add_text(item, "name", file->tensors[i].name);
        float shape[4];
        for (int k = 0; k < file->tensors[i].rank; ++k)
            shape[k] = (float)file->tensors[i].shape[k];
        tool_add_floats(item, "shape", shape, file->tensors[i].rank);
    }
}

enum pbnds_status tool_describe_weights(const char *path, bool raw, cJSON *facts,
                                        struct pbnds_error *error)
{
    struct pbnds_safetensors file;
    const struct pbnds_model *model;
    struct pbnds_error fault = {""};
    PBNDS_TRY(pbnds_safetensors_read(path, &file, error));
    double parameters = 0.0;
    for (int i = 0; i < file.tensor_count; ++i)
        parameters += (double)file.tensors[i].count;
    tool_add_text(facts, "kind", "weights");
    tool_add_number(facts, "parameters", parameters);
    const enum pbnds_status status =
        pbnds_weights_identify(path, &file, &model, &fault);
    tool_add_text(facts, "this program",
                  status == PBNDS_OK ? "reads it" : fault.message);
    if (raw) {
        cJSON *metadata = cJSON_AddObjectToObject(facts, "metadata");
        for (int i = 0; i < file.metadata_count; ++i)
            tool_add_text(metadata, file.metadata[i].key, file.metadata[i].value);
    }
    add_provenance(&file, facts);
    add_tensors(&file, facts);
    pbnds_safetensors_free(&file);
    return PBNDS_OK;
}
