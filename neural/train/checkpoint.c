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

/* The numbers of a checkpoint by name: what is written is what is read. */
struct number {
    const char *name;
    uint64_t *whole; /* either this */
    double *real;    /* or this     */
};

enum { NUMBERS = 8 };

static void numbers_of(struct pbnds_checkpoint *c, struct number numbers[NUMBERS])
{
    const struct number all[NUMBERS] = {
        {"step", &c->step, NULL},
        {"stocked", &c->stocked, NULL},
        {"best", NULL, &c->best},
        {"seconds", NULL, &c->seconds},
        {"loss_sum", NULL, &c->loss_sum},
        {"mse_sum", NULL, &c->mse_sum},
        {"loss_count", &c->loss_count, NULL},
        {"mse_count", &c->mse_count, NULL},
    };
    memcpy(numbers, all, sizeof all);
}

enum pbnds_status
pbnds_checkpoint_save(const char *path, const struct pbnds_checkpoint *checkpoint,
                      struct pbnds_net *net, const struct pbnds_adam *adam,
                      const struct pbnds_ema *ema, struct pbnds_error *error)
{
    const size_t count = pbnds_net_param_count(net);
    struct pbnds_checkpoint copy = *checkpoint;
    struct number numbers[NUMBERS];
    numbers_of(&copy, numbers);
    char names[NUMBERS][16], values[NUMBERS][32], recipe[] = "recipe";
    struct pbnds_metadata metadata[NUMBERS + 1];
    for (int i = 0; i < NUMBERS; ++i) {
        (void)snprintf(names[i], sizeof names[i], "%s", numbers[i].name);
        if (numbers[i].whole) {
            (void)snprintf(values[i], sizeof values[i], "%" PRIu64, *numbers[i].whole);
        } else {
            (void)snprintf(values[i], sizeof values[i], "%.17g", *numbers[i].real);
        }
        metadata[i] = (struct pbnds_metadata){names[i], values[i]};
    }
    metadata[NUMBERS] = (struct pbnds_metadata){recipe, copy.recipe};
    struct pbnds_safetensor tensors[4] = {flat("params", pbnds_net_params(net), count),
                                          flat("adam.m", adam->m, count),
                                          flat("adam.v", adam->v, count)};
    if (ema->mean) tensors[3] = flat("ema", ema->mean, count);
    const struct pbnds_safetensors file = {.tensors = tensors,
                                           .tensor_count = ema->mean ? 4 : 3,
                                           .metadata = metadata,
                                           .metadata_count = NUMBERS + 1};
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

static enum pbnds_status read_numbers(const char *path,
                                      const struct pbnds_safetensors *file,
                                      struct pbnds_checkpoint *checkpoint,
                                      struct pbnds_error *error)
{
    struct number numbers[NUMBERS];
    numbers_of(checkpoint, numbers);
    for (int i = 0; i < NUMBERS; ++i) {
        const char *value = pbnds_safetensors_metadata(file, numbers[i].name);
        if (!value) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                              "%s: is not a checkpoint of this version ('%s')", path,
                              numbers[i].name);
        }
        if (numbers[i].whole) {
            *numbers[i].whole = strtoull(value, NULL, 10);
        } else {
            *numbers[i].real = strtod(value, NULL);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status read_all(const char *path,
                                  const struct pbnds_safetensors *file,
                                  struct pbnds_checkpoint *checkpoint,
                                  struct pbnds_net *net, struct pbnds_adam *adam,
                                  struct pbnds_ema *ema, struct pbnds_error *error)
{
    const size_t count = pbnds_net_param_count(net);
    const char *recipe = pbnds_safetensors_metadata(file, "recipe");
    if (!recipe)
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not a checkpoint", path);
    if (strcmp(recipe, checkpoint->recipe) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: belongs to a run with other options (%s); give those, "
                          "or train without --resume",
                          path, recipe);
    }
    PBNDS_TRY(restore(path, file, "params", count, pbnds_net_params(net), error));
    PBNDS_TRY(restore(path, file, "adam.m", count, adam->m, error));
    PBNDS_TRY(restore(path, file, "adam.v", count, adam->v, error));
    if (ema->mean) PBNDS_TRY(restore(path, file, "ema", count, ema->mean, error));
    return read_numbers(path, file, checkpoint, error);
}

enum pbnds_status pbnds_checkpoint_load(const char *path,
                                        struct pbnds_checkpoint *checkpoint,
                                        struct pbnds_net *net, struct pbnds_adam *adam,
                                        struct pbnds_ema *ema,
                                        struct pbnds_error *error)
{
    struct pbnds_safetensors file = {0};
    PBNDS_TRY(pbnds_safetensors_read(path, &file, error));
    const enum pbnds_status status =
        read_all(path, &file, checkpoint, net, adam, ema, error);
    if (status == PBNDS_OK) {
        adam->step = checkpoint->step;
        pbnds_net_params_changed(net);
    }
    pbnds_safetensors_free(&file);
    return status;
}
