#include "neural/train/checkpoint.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "neural/model/safetensors.h"

/* Flat arrays longer than an int can count do not occur: networks here are small. */
static struct pbnds_safetensor flat(const char *name, const float *data, size_t count)
{
    struct pbnds_safetensor t = {.rank = 1, .count = count, .data = data};
    (void)snprintf(t.name, sizeof t.name, "%s", name);
    t.shape[0] = (int)count;
    return t;
}

enum pbnds_status pbnds_checkpoint_save(const char *path,
                                        const struct pbnds_checkpoint *checkpoint,
                                        struct pbnds_net *net,
                                        const struct pbnds_adam *adam,
                                        struct pbnds_error *error)
{
    const size_t count = pbnds_net_param_count(net);
    struct pbnds_safetensor tensors[3] = {flat("params", pbnds_net_params(net), count),
                                          flat("adam.m", adam->m, count),
                                          flat("adam.v", adam->v, count)};
    char step[32], stocked[32], best[64], seconds[64],
        recipe[sizeof checkpoint->recipe];
    (void)snprintf(step, sizeof step, "%" PRIu64, checkpoint->step);
    (void)snprintf(stocked, sizeof stocked, "%" PRIu64, checkpoint->stocked);
    (void)snprintf(best, sizeof best, "%.17g", checkpoint->best);
    (void)snprintf(seconds, sizeof seconds, "%.17g", checkpoint->seconds);
    (void)snprintf(recipe, sizeof recipe, "%s", checkpoint->recipe);
    char k0[] = "step", k1[] = "best", k2[] = "seconds", k3[] = "recipe",
         k4[] = "stocked";
    struct pbnds_metadata metadata[5] = {
        {k0, step}, {k1, best}, {k2, seconds}, {k3, recipe}, {k4, stocked}};
    const struct pbnds_safetensors file = {.tensors = tensors,
                                           .tensor_count = 3,
                                           .metadata = metadata,
                                           .metadata_count = 5};
    return pbnds_safetensors_write(path, &file, error);
}

static enum pbnds_status restore(const char *path, const struct pbnds_safetensors *file,
                                 const char *name, size_t count, float *dst,
                                 struct pbnds_error *error)
{
    const struct pbnds_safetensor *t = pbnds_safetensors_find(file, name);
    if (!t || t->count != count) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is not a checkpoint of this model (tensor '%s')", path,
                          name);
    }
    memcpy(dst, t->data, count * sizeof *dst);
    return PBNDS_OK;
}

enum pbnds_status pbnds_checkpoint_load(const char *path,
                                        struct pbnds_checkpoint *checkpoint,
                                        struct pbnds_net *net, struct pbnds_adam *adam,
                                        struct pbnds_error *error)
{
    struct pbnds_safetensors file = {0};
    PBNDS_TRY(pbnds_safetensors_read(path, &file, error));
    const char *step = pbnds_safetensors_metadata(&file, "step");
    const char *best = pbnds_safetensors_metadata(&file, "best");
    const char *seconds = pbnds_safetensors_metadata(&file, "seconds");
    const char *recipe = pbnds_safetensors_metadata(&file, "recipe");
    const char *stocked = pbnds_safetensors_metadata(&file, "stocked");
    const size_t count = pbnds_net_param_count(net);
    enum pbnds_status status = PBNDS_OK;
    if (!step || !best || !seconds || !recipe || !stocked) {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not a checkpoint", path);
    } else if (strcmp(recipe, checkpoint->recipe) != 0) {
        status =
            pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                       "%s: belongs to a run with other options (%s); give those, or "
                       "train without --resume",
                       path, recipe);
    }
    if (status == PBNDS_OK) {
        status = restore(path, &file, "params", count, pbnds_net_params(net), error);
    }
    if (status == PBNDS_OK)
        status = restore(path, &file, "adam.m", count, adam->m, error);
    if (status == PBNDS_OK)
        status = restore(path, &file, "adam.v", count, adam->v, error);
    if (status == PBNDS_OK) {
        checkpoint->step = strtoull(step, NULL, 10);
        checkpoint->stocked = strtoull(stocked, NULL, 10);
        checkpoint->best = strtod(best, NULL);
        checkpoint->seconds = strtod(seconds, NULL);
        adam->step = checkpoint->step;
        pbnds_net_params_changed(net);
    }
    pbnds_safetensors_free(&file);
    return status;
}
