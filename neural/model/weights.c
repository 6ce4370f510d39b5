/* Weights files: which model, which version, then every tensor by name and shape. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "neural/model/model.h"

enum pbnds_status pbnds_weights_save(const char *path, const struct pbnds_model *model,
                                     const struct pbnds_net *net,
                                     const struct pbnds_metadata *extra,
                                     int extra_count, struct pbnds_error *error)
{
    const int tensors = pbnds_net_tensor_count(net);
    struct pbnds_safetensors file = {0};
    file.tensors = calloc((size_t)tensors, sizeof *file.tensors);
    file.metadata = calloc((size_t)extra_count + 2, sizeof *file.metadata);
    enum pbnds_status status = PBNDS_OK;
    if (!file.tensors || !file.metadata) {
        status =
            pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its header", path);
        goto done;
    }
    char version[16];
    (void)snprintf(version, sizeof version, "%d", model->version);
    char key_model[] = "pbnds.model", key_version[] = "pbnds.version", name[64];
    (void)snprintf(name, sizeof name, "%s", model->name);
    file.metadata[0] = (struct pbnds_metadata){key_model, name};
    file.metadata[1] = (struct pbnds_metadata){key_version, version};
    for (int i = 0; i < extra_count; ++i)
        file.metadata[i + 2] = extra[i];
    file.metadata_count = extra_count + 2;
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

enum pbnds_status pbnds_weights_open(const char *path, struct pbnds_safetensors *file,
                                     const struct pbnds_model **model,
                                     struct pbnds_error *error)
{
    *model = NULL;
    PBNDS_TRY(pbnds_safetensors_read(path, file, error));
    const char *name = pbnds_safetensors_metadata(file, "pbnds.model");
    const char *version = pbnds_safetensors_metadata(file, "pbnds.version");
    const struct pbnds_model *found = name ? pbnds_model_find(name) : NULL;
    enum pbnds_status status = PBNDS_OK;
    if (!name || !version) {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT,
                            "%s: is not a weights file of pbnds (no pbnds.model in its "
                            "metadata)",
                            path);
    } else if (!found) {
        status = pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                            "%s: holds a model '%s' that this version does not have",
                            path, name);
    } else {
        char expected[16];
        (void)snprintf(expected, sizeof expected, "%d", found->version);
        if (strcmp(version, expected) != 0) {
            status =
                pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                           "%s: holds version %s of model '%s', this program has "
                           "version %s; train it again or use the matching program",
                           path, version, name, expected);
        }
    }
    if (status != PBNDS_OK) {
        pbnds_safetensors_free(file);
        return status;
    }
    *model = found;
    return PBNDS_OK;
}

enum pbnds_status pbnds_weights_apply(const char *path,
                                      const struct pbnds_safetensors *file,
                                      struct pbnds_net *net, struct pbnds_error *error)
{
    const int tensors = pbnds_net_tensor_count(net);
    for (int i = 0; i < tensors; ++i) {
        const struct pbnds_param *p = pbnds_net_param(net, i);
        const struct pbnds_safetensor *t = pbnds_safetensors_find(file, p->name);
        if (!t) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: tensor '%s' is missing",
                              path, p->name);
        }
        if (t->rank != p->rank ||
            memcmp(t->shape, p->shape, (size_t)p->rank * sizeof *p->shape) != 0) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                              "%s: tensor '%s' has another shape than the model's",
                              path, p->name);
        }
        for (size_t k = 0; k < t->count; ++k) {
            if (!isfinite(t->data[k])) {
                return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                                  "%s: tensor '%s' holds a value that is not finite",
                                  path, p->name);
            }
        }
        memcpy(pbnds_net_params(net) + p->offset, t->data, t->count * sizeof(float));
    }
    if (file->tensor_count != tensors) {
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "%s: holds %d tensors, the model has %d: weights of another model", path,
            file->tensor_count, tensors);
    }
    pbnds_net_params_changed(net);
    return PBNDS_OK;
}
