/* Weights files: which model, which version, then every tensor by name and shape. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <xxhash.h>

#include "neural/model/model.h"

enum { OWN_METADATA = 5 };

struct own_metadata {
    char text[OWN_METADATA][96];
    struct pbnds_metadata list[OWN_METADATA];
};

/* Hash of what decides over the numbers of a forward pass: initial weights and dropout do
 * not. Fields one by one, since structures have gaps. */
static uint64_t table_hash(const struct pbnds_net_table *table)
{
    const int ends[2] = {table->light_output, table->view_output};
    uint64_t hash = XXH64(ends, sizeof ends, 0);
    for (int r = 0; r < table->layer_count; ++r) {
        const struct pbnds_layer *l = &table->layers[r];
        const int row[] = {(int)l->op, l->in[0],  l->in[1],   l->channels,
                           l->kernel,  l->stride, (int)l->act};
        hash = XXH64(row, sizeof row, hash);
        hash = XXH64(l->name, strlen(l->name), hash);
    }
    return hash;
}

static const char HASH_WORD[] = "xxh64 ";

static void describe(struct own_metadata *own, const struct pbnds_model *model,
                     const struct pbnds_net *net)
{
    static const char *const KEYS[OWN_METADATA] = {
        "pbnds.model", "pbnds.version", "pbnds.architecture", "pbnds.features",
        "pbnds.light_mode"};
    const size_t size = sizeof own->text[0];
    (void)snprintf(own->text[0], size, "%s", model->name);
    (void)snprintf(own->text[1], size, "%d", model->version);
    (void)snprintf(own->text[2], size, "%d layers, %zu parameters, %s%016" PRIx64,
                   model->table.layer_count, pbnds_net_param_count(net), HASH_WORD,
                   table_hash(&model->table));
    (void)snprintf(own->text[3], size, "%d", model->features);
    (void)snprintf(own->text[4], size, "%s",
                   model->light_mode ? model->light_mode : "none");
    for (int i = 0; i < OWN_METADATA; ++i) { /* borrowed by the writer, not changed */
        own->list[i] =
            (struct pbnds_metadata){(char *)(uintptr_t)KEYS[i], own->text[i]};
    }
}

enum pbnds_status pbnds_weights_save(const char *path, const struct pbnds_model *model,
                                     const struct pbnds_net *net,
                                     const struct pbnds_metadata *extra,
                                     int extra_count, struct pbnds_error *error)
{
    const int tensors = pbnds_net_tensor_count(net);
    struct pbnds_safetensors file = {0};
    file.tensors = calloc((size_t)tensors, sizeof *file.tensors);
    file.metadata = calloc((size_t)extra_count + OWN_METADATA, sizeof *file.metadata);
    enum pbnds_status status = PBNDS_OK;
    if (!file.tensors || !file.metadata) {
        status =
            pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its header", path);
        goto done;
    }
    struct own_metadata own;
    describe(&own, model, net);
    memcpy(file.metadata, own.list, sizeof own.list);
    for (int i = 0; i < extra_count; ++i)
        file.metadata[i + OWN_METADATA] = extra[i];
    file.metadata_count = extra_count + OWN_METADATA;
    /* The parameters are read only: the net is not changed by asking for them. */
    const float *params = pbnds_net_params((struct pbnds_net *)(uintptr_t)net);
    for (int i = 0; i < tensors; ++i) {
        const struct pbnds_param *p = pbnds_net_param(net, i);
        struct pbnds_safetensor *t = &file.tensors[i];
        (void)snprintf(t->name, sizeof t->name, "%s", p->name);
        memcpy(t->shape, p->shape, sizeof t->shape);
        t->rank = p->rank;
        t->count = p->count;
        t->data = params + p->offset;
    }
    file.tensor_count = tensors;
    status = pbnds_safetensors_write(path, &file, error);
done:
    free(file.tensors);
    free(file.metadata);
    return status;
}

/* "" where the key is absent. */
static const char *metadata(const struct pbnds_safetensors *file, const char *key)
{
    const char *value = pbnds_safetensors_metadata(file, key);
    return value ? value : "";
}

static enum pbnds_status check_versions(const char *path,
                                        const struct pbnds_safetensors *file,
                                        const struct pbnds_model *model,
                                        struct pbnds_error *error)
{
    char ours[32];
    const char *version = metadata(file, "pbnds.version");
    (void)snprintf(ours, sizeof ours, "%d", model->version);
    if (strcmp(version, ours) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: holds version %.20s of model '%s', this program has "
                          "version %s; train it again or use the matching program",
                          path, version, model->name, ours);
    }
    const char *architecture = metadata(file, "pbnds.architecture");
    const char *hash = strstr(architecture, HASH_WORD);
    (void)snprintf(ours, sizeof ours, "%s%016" PRIx64, HASH_WORD,
                   table_hash(&model->table));
    if (architecture[0] && (!hash || strcmp(hash, ours) != 0)) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: says that it is version %s of model '%s' and describes "
                          "another network (%.80s, ours is %s); train it again",
                          path, version, model->name, architecture, ours);
    }
    const char *features = metadata(file, "pbnds.features");
    (void)snprintf(ours, sizeof ours, "%d", model->features);
    if (features[0] && strcmp(features, ours) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: was trained on version %.20s of the features of '%s', "
                          "this program has version %s; train it again or use the "
                          "matching program",
                          path, features, model->name, ours);
    }
    const char *mode = metadata(file, "pbnds.light_mode");
    if (mode[0] && (!model->light_mode || strcmp(mode, model->light_mode) != 0)) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: was trained with lights of mode '%.20s', this program "
                          "gives '%s' the mode '%s'; train it again",
                          path, mode, model->name,
                          model->light_mode ? model->light_mode : "none");
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_weights_identify(const char *path,
                                         const struct pbnds_safetensors *file,
                                         const struct pbnds_model **model,
                                         struct pbnds_error *error)
{
    const char *name = metadata(file, "pbnds.model");
    *model = NULL;
    if (!name[0] || !metadata(file, "pbnds.version")[0]) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is not a weights file of pbnds (no pbnds.model in its "
                          "metadata)",
                          path);
    }
    const struct pbnds_model *found = pbnds_model_find(name);
    if (!found) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: holds a model '%.40s' that this version does not have",
                          path, name);
    }
    PBNDS_TRY(check_versions(path, file, found, error));
    *model = found;
    return PBNDS_OK;
}

enum pbnds_status pbnds_weights_open(const char *path, struct pbnds_safetensors *file,
                                     const struct pbnds_model **model,
                                     struct pbnds_error *error)
{
    *model = NULL;
    PBNDS_TRY(pbnds_safetensors_read(path, file, error));
    const enum pbnds_status status = pbnds_weights_identify(path, file, model, error);
    if (status != PBNDS_OK) pbnds_safetensors_free(file);
    return status;
}

/* The tensor of a parameter, if it is there and sound. */
static enum pbnds_status find_tensor(const char *path,
                                     const struct pbnds_safetensors *file,
                                     const struct pbnds_param *p,
                                     const struct pbnds_safetensor **tensor,
                                     struct pbnds_error *error)
{
    const struct pbnds_safetensor *t = pbnds_safetensors_find(file, p->name);
    if (!t) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: tensor '%s' is missing", path,
                          p->name);
    }
    if (t->rank != p->rank ||
        memcmp(t->shape, p->shape, (size_t)p->rank * sizeof *p->shape) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: tensor '%s' has another shape than the model's", path,
                          p->name);
    }
    for (size_t k = 0; k < t->count; ++k) {
        if (!isfinite(t->data[k])) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                              "%s: tensor '%s' holds a value that is not finite", path,
                              p->name);
        }
    }
    *tensor = t;
    return PBNDS_OK;
}

enum pbnds_status pbnds_weights_apply(const char *path,
                                      const struct pbnds_safetensors *file,
                                      struct pbnds_net *net, struct pbnds_error *error)
{
    const int tensors = pbnds_net_tensor_count(net);
    const struct pbnds_safetensor *t;
    for (int i = 0; i < tensors; ++i)
        PBNDS_TRY(find_tensor(path, file, pbnds_net_param(net, i), &t, error));
    if (file->tensor_count != tensors) {
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "%s: holds %d tensors, the model has %d: weights of another model", path,
            file->tensor_count, tensors);
    }
    for (int i = 0; i < tensors; ++i) {
        const struct pbnds_param *p = pbnds_net_param(net, i);
        t = pbnds_safetensors_find(file, p->name);
        memcpy(pbnds_net_params(net) + p->offset, t->data, p->count * sizeof(float));
    }
    pbnds_net_params_changed(net);
    return PBNDS_OK;
}
