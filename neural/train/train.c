/* The training run: options, what it begins from, the loop. */
#include "neural/train/train.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <xxhash.h>

#include "engine/core/file.h"
#include "engine/core/ranks.h"
#include "neural/train/curve.h"
#include "neural/train/trainer.h"

static enum pbnds_status choose_options(struct pbnds_trainer *t,
                                        struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    t->ops = pbnds_task_find(o->model);
    if (!t->ops) {
        char names[128];
        pbnds_task_names(names, sizeof names);
        const bool planned =
            strcmp(o->model, "pbnds") == 0 || strcmp(o->model, "nds") == 0;
        return pbnds_fail(error,
                          planned ? PBNDS_ERROR_UNSUPPORTED : PBNDS_ERROR_ARGUMENT,
                          "%s: this version trains %s only", o->model, names);
    }
    t->steps = o->steps > 0 ? o->steps : t->ops->steps;
    t->batch_size = o->batch > 0 ? o->batch : t->ops->batch;
    t->accumulate = o->accumulate > 0 ? o->accumulate : 1;
    t->lr = o->lr > 0.0 ? o->lr : t->ops->lr;
    t->crop = o->crop > 0 ? o->crop : 128;
    t->task = (struct pbnds_task){
        .model = t->ops->model,
        .lights = o->lights > 0 ? o->lights : t->ops->lights,
        .p_dark = o->p_dark >= 0.0 ? o->p_dark : t->ops->p_dark,
        .lambda_zero = o->lambda_zero >= 0.0 ? o->lambda_zero : t->ops->lambda_zero};
    if (t->batch_size > PBNDS_TRAINER_BATCH_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "a batch has at most %d views; --accumulate makes more of "
                          "them a step",
                          PBNDS_TRAINER_BATCH_MAX);
    }
    if (!(o->weight_decay >= 0.0 && o->ema >= 0.0 && o->ema < 1.0)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "weight decay %g, EMA %g: the first is not negative, the "
                          "second in [0, 1)",
                          o->weight_decay, o->ema);
    }
    if (t->ops->transport && t->task.lights != PBNDS_DATASET_LIGHTS) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "transport trains on the %d cluster lights that the data set has "
            "visibility for; at render time any number is fine",
            PBNDS_DATASET_LIGHTS);
    }
    if (t->task.lights > 1024) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "at most 1024 lights a view");
    }
    return PBNDS_OK;
}

static enum pbnds_status open_data(struct pbnds_trainer *t, struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    PBNDS_TRY(pbnds_dataset_hash(o->data, t->data_hash, error));
    PBNDS_TRY(pbnds_train_items_open(&t->items, o->data, t->ops->transport,
                                     o->max_memory, error));
    if (t->items.list[PBNDS_ITEMS_VAL].count == 0) {
        pbnds_warn(t->report,
                   "%s: has no samples in split val: the last weights are kept, "
                   "not the best",
                   o->data);
    }
    return PBNDS_OK;
}

/* The crop is what the net can divide, and no larger than the samples. */
static enum pbnds_status settle_crop(struct pbnds_trainer *t, struct pbnds_error *error)
{
    const int multiple = 1 << pbnds_net_deepest_level(t->net);
    const struct pbnds_train_item *item;
    PBNDS_TRY(pbnds_train_items_get(&t->items, PBNDS_ITEMS_TRAIN, 0, &item, error));
    const struct pbnds_view *v = &item->view;
    const int side = v->width < v->height ? v->width : v->height;
    const int most = t->crop < side ? t->crop : side;
    t->crop = most / multiple * multiple;
    if (t->crop < multiple) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: samples of %d x %d are too small for this model (%d)",
                          t->options->data, v->width, v->height, multiple);
    }
    return PBNDS_OK;
}

/* What must agree for a run to be the same: everything the numbers follow from. */
static enum pbnds_status write_recipe(struct pbnds_trainer *t,
                                      struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    char init[48] = "";
    if (o->init) {
        uint8_t *bytes;
        size_t size;
        PBNDS_TRY(pbnds_file_read(o->init, (size_t)1 << 32, &bytes, &size, error));
        (void)snprintf(init, sizeof init, "init %016" PRIx64 ", ",
                       (uint64_t)XXH64(bytes, size, 0));
        free(bytes);
    }
    (void)snprintf(
        t->state.recipe, sizeof t->state.recipe,
        "model %s v%d, data %s, %ssteps %d, batch %d, accumulate %d, processes %d, "
        "lights %d, crop %d, augment %s, lr %g, weight_decay %g, ema %g, p_dark %g, "
        "lambda_zero %g, seed %" PRIu64 ", %s",
        t->ops->model->name, t->ops->model->version, t->data_hash, init, t->steps,
        t->batch_size, t->accumulate, pbnds_rank_count(), t->task.lights, t->crop,
        o->augment ? "on" : "off", t->lr, o->weight_decay, o->ema, t->task.p_dark,
        t->task.lambda_zero, o->seed, o->dtype == PBNDS_BF16 ? "bf16" : "fp32");
    return PBNDS_OK;
}

static enum pbnds_status start_from_weights(struct pbnds_trainer *t,
                                            struct pbnds_error *error)
{
    struct pbnds_safetensors file = {0};
    const struct pbnds_model *model;
    PBNDS_TRY(pbnds_weights_open(t->options->init, &file, &model, error));
    enum pbnds_status status = PBNDS_OK;
    if (model != t->ops->model) {
        status =
            pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: holds weights of %s, not of %s",
                       t->options->init, model->name, t->ops->model->name);
    } else {
        status = pbnds_weights_apply(t->options->init, &file, t->net, error);
    }
    pbnds_safetensors_free(&file);
    return status;
}

static bool exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0;
}

/* Earlier work is never overwritten in silence: a checkpoint wants --resume, and finished
 * weights want another name. */
static enum pbnds_status guard_earlier_work(const struct pbnds_trainer *t,
                                            struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    const bool checkpoint = exists(t->checkpoint_path);
    if (checkpoint && !o->resume) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: an unfinished run is there; give --resume to go on with "
                          "it, or remove it",
                          t->checkpoint_path);
    }
    if (!checkpoint && exists(o->weights)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: holds the weights of a finished run; give another name, "
                          "or remove it",
                          o->weights);
    }
    return PBNDS_OK;
}

static enum pbnds_status start_state(struct pbnds_trainer *t, struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    t->state.best = HUGE_VAL;
    PBNDS_TRY(write_recipe(t, error));
    pbnds_net_init(t->net, o->seed);
    if (o->init) PBNDS_TRY(start_from_weights(t, error));
    PBNDS_TRY(pbnds_ema_init(&t->ema, o->ema, pbnds_net_param_count(t->net),
                             pbnds_net_params(t->net), error));
    const bool resumed = exists(t->checkpoint_path);
    if (resumed) {
        PBNDS_TRY(pbnds_checkpoint_load(t->checkpoint_path, &t->state, t->net, &t->adam,
                                        &t->ema, error));
        t->saved = t->state.step;
    }
    t->started = pbnds_trainer_now() - t->state.seconds;
    if (pbnds_rank() > 0) return PBNDS_OK;
    return pbnds_curve_start(t->curve_path, t->state.stocked, resumed, error);
}

static enum pbnds_status name_files(struct pbnds_trainer *t, struct pbnds_error *error)
{
    const struct {
        char *path;
        const char *ending;
    } files[] = {{t->checkpoint_path, "checkpoint"},
                 {t->curve_path, "csv"},
                 {t->plot_path, "png"},
                 {t->sheet_path, "sheet.png"}};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        const int n = snprintf(files[i].path, sizeof t->curve_path, "%s.%s",
                               t->options->weights, files[i].ending);
        if (n < 0 || (size_t)n >= sizeof t->curve_path) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: the name is too long",
                              t->options->weights);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status build(struct pbnds_trainer *t, struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    PBNDS_TRY(name_files(t, error));
    PBNDS_TRY(choose_options(t, error));
    PBNDS_TRY(guard_earlier_work(t, error));
    PBNDS_TRY(open_data(t, error));
    PBNDS_TRY(pbnds_backend_create_onednn(&t->backend, error));
    PBNDS_TRY(
        pbnds_net_create(&t->ops->model->table, t->backend, o->dtype, &t->net, error));
    PBNDS_TRY(pbnds_adam_init(&t->adam, pbnds_net_param_count(t->net), error));
    t->adam.weight_decay = (float)o->weight_decay;
    PBNDS_TRY(settle_crop(t, error));
    PBNDS_TRY(pbnds_batch_init(&t->batch, t->ops, &t->task, t->net, t->batch_size,
                               t->crop, 0, error));
    return pbnds_batch_init(&t->validation, t->ops, &t->task, t->net, 1, t->crop, 0,
                            error);
}

/* Everybody looks at what is there before the first rank writes. */
static enum pbnds_status start(struct pbnds_trainer *t, struct pbnds_error *error)
{
    const enum pbnds_status built = build(t, error);
    PBNDS_TRY(pbnds_trainer_agree(t, built, error));
    const enum pbnds_status started = start_state(t, error);
    PBNDS_TRY(pbnds_trainer_agree(t, started, error));
    const int step = (int)t->state.step;
    const bool same = pbnds_ranks_max(step) == -pbnds_ranks_max(-step);
    return same ? PBNDS_OK
                : pbnds_fail(error, PBNDS_ERROR_IO,
                             "%s: the processes read different states; their file "
                             "system must be shared",
                             t->checkpoint_path);
}

static void destroy(struct pbnds_trainer *t)
{
    pbnds_batch_free(&t->batch);
    pbnds_batch_free(&t->validation);
    pbnds_train_items_free(&t->items);
    pbnds_adam_free(&t->adam);
    pbnds_ema_free(&t->ema);
    pbnds_net_free(t->net);
    pbnds_backend_free(t->backend);
}

/* A checkpoint between steps; the stock of a step that was due is taken on resume. */
static enum pbnds_status stop_here(struct pbnds_trainer *t, struct pbnds_error *error)
{
    if (t->state.step > 0) PBNDS_TRY(pbnds_trainer_save(t, error));
    return pbnds_fail_interrupted(error);
}

static bool time_is_up(const struct pbnds_trainer *t)
{
    const bool over = t->options->seconds > 0.0 && pbnds_rank() == 0 &&
                      pbnds_trainer_now() - t->started >= t->options->seconds;
    return pbnds_ranks_max(over) != 0;
}

static enum pbnds_status finish(struct pbnds_trainer *t, struct pbnds_error *error)
{
    enum pbnds_status status = PBNDS_OK;
    if (pbnds_rank() == 0 && remove(t->checkpoint_path) != 0) {
        status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be removed",
                            t->checkpoint_path);
    }
    return pbnds_trainer_agree(t, status, error);
}

static bool stock_is_due(const struct pbnds_trainer *t)
{
    const uint64_t steps = (uint64_t)t->steps, step = t->state.step;
    const uint64_t interval = steps / 50 < 1 ? 1 : steps / 50 > 500 ? 500 : steps / 50;
    return step > t->state.stocked && (step % interval == 0 || step == steps);
}

static enum pbnds_status run(struct pbnds_trainer *t, struct pbnds_error *error)
{
    const uint64_t steps = (uint64_t)t->steps;
    const uint64_t every = (uint64_t)t->options->checkpoint_every;
    const struct pbnds_checkpoint *s = &t->state;
    while (s->stocked < steps) {
        const bool due = stock_is_due(t);
        enum pbnds_status status =
            due ? pbnds_trainer_take_stock(t, error) : pbnds_trainer_step(t, error);
        /* What was interrupted is dropped: the state is the one before it. */
        if (status == PBNDS_ERROR_INTERRUPTED) return stop_here(t, error);
        if (status == PBNDS_OK && every > 0 && s->step % every == 0 &&
            s->step > t->saved && !stock_is_due(t)) {
            status = pbnds_trainer_agree(t, pbnds_trainer_save(t, error), error);
        }
        PBNDS_TRY(status);
        pbnds_progress(t->report, "train", (double)s->step, (double)steps);
        if (due && s->step < steps && time_is_up(t)) {
            pbnds_warn(t->report,
                       "time is up at step %" PRIu64 " of %" PRIu64
                       "; --resume goes on",
                       s->step, steps);
            return PBNDS_OK;
        }
    }
    return finish(t, error);
}

enum pbnds_status pbnds_train(const struct pbnds_train_options *options,
                              const struct pbnds_report *report,
                              struct pbnds_error *error)
{
    struct pbnds_trainer *t = calloc(1, sizeof *t);
    if (!t) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory to train");
    t->options = options;
    t->report = pbnds_rank() == 0 ? report : NULL;
    enum pbnds_status status = start(t, error);
    if (status == PBNDS_OK) status = run(t, error);
    destroy(t);
    free(t);
    return status;
}
