/* The training loop. A step is a pure function of (seed, step, parameters, moments). */
#include "neural/train/train.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <xxhash.h>

#include "engine/core/file.h"
#include "engine/core/rng.h"
#include "neural/provenance.h"
#include "neural/train/adam.h"
#include "neural/train/batch.h"
#include "neural/train/checkpoint.h"
#include "neural/train/curve.h"

enum { VALIDATION_VIEWS = 32, BATCH_MAX = 16 };

static const double CLIP_NORM = 1.0, WARM_UP_STEPS = 200.0, LR_FLOOR = 0.02;

struct trainer {
    const struct pbnds_train_options *options;
    const struct pbnds_report *report;
    const struct pbnds_task_ops *ops;
    struct pbnds_task task;
    int steps, batch_size, crop;
    double lr;
    char data_hash[17];
    char checkpoint_path[4096], curve_path[4096];
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    struct pbnds_adam adam;
    struct pbnds_batch batch;      /* training: batch_size views          */
    struct pbnds_batch validation; /* one view at a time, same crop       */
    struct pbnds_sample_list train_list, val_list;
    struct pbnds_train_item *train_items, *val_items;
    size_t item_bytes; /* of the items in memory */
    uint64_t draws;    /* batches drawn: the age of an item */
    struct pbnds_checkpoint state;
    double started;           /* wall clock at which state.seconds began to count */
    double loss_sum, mse_sum; /* since the last row of the curve */
    int loss_count, mse_count;
};

static double now(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static const struct pbnds_task_ops *find_task(const char *model)
{
    static const struct pbnds_task_ops *const TASKS[] = {&pbnds_task_transport,
                                                         &pbnds_task_pbnds_plus};
    for (size_t i = 0; i < sizeof TASKS / sizeof TASKS[0]; ++i) {
        if (strcmp(TASKS[i]->model->name, model) == 0) return TASKS[i];
    }
    return NULL;
}

static double psnr(double mse)
{
    return mse > 0.0 ? -10.0 * log10(mse) : 99.0;
}

static enum pbnds_status choose_options(struct trainer *t, struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    t->ops = find_task(o->model);
    if (!t->ops) {
        const bool planned =
            strcmp(o->model, "pbnds") == 0 || strcmp(o->model, "nds") == 0;
        return pbnds_fail(
            error, planned ? PBNDS_ERROR_UNSUPPORTED : PBNDS_ERROR_ARGUMENT,
            "%s: this version trains transport and pbnds+ only", o->model);
    }
    t->steps = o->steps > 0 ? o->steps : t->ops->steps;
    t->batch_size = o->batch > 0 ? o->batch : t->ops->batch;
    t->lr = o->lr > 0.0 ? o->lr : t->ops->lr;
    t->crop = o->crop > 0 ? o->crop : 128;
    t->task = (struct pbnds_task){
        .model = t->ops->model,
        .lights = o->lights > 0 ? o->lights : t->ops->lights,
        .p_dark = o->p_dark >= 0.0 ? o->p_dark : t->ops->p_dark,
        .lambda_zero = o->lambda_zero >= 0.0 ? o->lambda_zero : t->ops->lambda_zero};
    if (t->batch_size > BATCH_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "a batch has at most %d views",
                          BATCH_MAX);
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

static enum pbnds_status open_data(struct trainer *t, struct pbnds_error *error)
{
    const char *data = t->options->data;
    PBNDS_TRY(pbnds_dataset_hash(data, t->data_hash, error));
    PBNDS_TRY(pbnds_dataset_list(data, PBNDS_SPLIT_TRAIN, &t->train_list, error));
    PBNDS_TRY(pbnds_dataset_list(data, PBNDS_SPLIT_VAL, &t->val_list, error));
    if (t->train_list.count == 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: has no samples in split train", data);
    }
    if (t->val_list.count == 0) {
        pbnds_warn(t->report,
                   "%s: has no samples in split val: the last weights are kept, "
                   "not the best",
                   data);
    }
    t->train_items = calloc((size_t)t->train_list.count, sizeof *t->train_items);
    t->val_items = calloc((size_t)t->val_list.count + 1, sizeof *t->val_items);
    if (!t->train_items || !t->val_items) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list",
                          data);
    }
    return PBNDS_OK;
}

/* Makes room for one more sample: while those in memory exceed the budget, the one used
 * longest ago goes. It is loaded again when it is drawn again, to the same numbers. */
static void evict(struct trainer *t)
{
    while (t->options->max_memory > 0 && t->item_bytes > t->options->max_memory) {
        struct pbnds_train_item *oldest = NULL;
        for (int k = 0; k < t->train_list.count + t->val_list.count; ++k) {
            struct pbnds_train_item *item =
                k < t->train_list.count ? &t->train_items[k]
                                        : &t->val_items[k - t->train_list.count];
            if (item->loaded && item->used < t->draws &&
                (!oldest || item->used < oldest->used)) {
                oldest = item;
            }
        }
        if (!oldest) return; /* what is left is the batch at hand */
        t->item_bytes -= pbnds_train_item_bytes(oldest);
        pbnds_train_item_free(oldest);
    }
}

static enum pbnds_status item_at(struct trainer *t,
                                 const struct pbnds_sample_list *list,
                                 struct pbnds_train_item *items, int i,
                                 struct pbnds_error *error)
{
    if (!items[i].loaded) {
        evict(t);
        PBNDS_TRY(pbnds_train_item_load(list->folders[i], t->ops->transport, &items[i],
                                        error));
        t->item_bytes += pbnds_train_item_bytes(&items[i]);
    }
    items[i].used = t->draws;
    if (items[i].view.width < t->crop || items[i].view.height < t->crop) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: is %d x %d, smaller than the crop of %d; give --crop",
                          list->folders[i], items[i].view.width, items[i].view.height,
                          t->crop);
    }
    return PBNDS_OK;
}

/* The crop is what the net can divide, and no larger than the samples. */
static enum pbnds_status settle_crop(struct trainer *t, struct pbnds_error *error)
{
    const int multiple = 1 << pbnds_net_deepest_level(t->net);
    const int wanted = t->crop;
    t->crop = 1;
    PBNDS_TRY(item_at(t, &t->train_list, t->train_items, 0, error));
    const struct pbnds_view *v = &t->train_items[0].view;
    const int side = v->width < v->height ? v->width : v->height;
    const int most = wanted < side ? wanted : side;
    t->crop = most / multiple * multiple;
    if (t->crop < multiple) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: samples of %d x %d are too small for this model (%d)",
                          t->options->data, v->width, v->height, multiple);
    }
    return PBNDS_OK;
}

/* What must agree for a run to be the same: everything the numbers follow from. */
static enum pbnds_status write_recipe(struct trainer *t, struct pbnds_error *error)
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
        "model %s v%d, data %s, %ssteps %d, batch %d, lights %d, crop %d, lr %g, "
        "p_dark %g, lambda_zero %g, seed %" PRIu64 ", %s",
        t->ops->model->name, t->ops->model->version, t->data_hash, init, t->steps,
        t->batch_size, t->task.lights, t->crop, t->lr, t->task.p_dark,
        t->task.lambda_zero, o->seed, o->dtype == PBNDS_BF16 ? "bf16" : "fp32");
    return PBNDS_OK;
}

static enum pbnds_status start_from_weights(struct trainer *t,
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
static enum pbnds_status guard_earlier_work(const struct trainer *t,
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

static enum pbnds_status start_state(struct trainer *t, struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    t->state.best = HUGE_VAL;
    PBNDS_TRY(write_recipe(t, error));
    pbnds_net_init(t->net, o->seed);
    if (o->init) PBNDS_TRY(start_from_weights(t, error));
    const bool resumed = exists(t->checkpoint_path);
    if (resumed) {
        PBNDS_TRY(pbnds_checkpoint_load(t->checkpoint_path, &t->state, t->net, &t->adam,
                                        error));
    }
    t->started = now() - t->state.seconds;
    return pbnds_curve_start(t->curve_path, t->state.step, resumed, error);
}

static enum pbnds_status build(struct trainer *t, struct pbnds_error *error)
{
    const struct pbnds_train_options *o = t->options;
    const int a = snprintf(t->checkpoint_path, sizeof t->checkpoint_path,
                           "%s.checkpoint", o->weights);
    const int b = snprintf(t->curve_path, sizeof t->curve_path, "%s.csv", o->weights);
    if (a < 0 || b < 0 || (size_t)a >= sizeof t->checkpoint_path) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: the name is too long",
                          o->weights);
    }
    PBNDS_TRY(choose_options(t, error));
    PBNDS_TRY(guard_earlier_work(t, error));
    PBNDS_TRY(open_data(t, error));
    PBNDS_TRY(pbnds_backend_create_onednn(&t->backend, error));
    PBNDS_TRY(
        pbnds_net_create(&t->ops->model->table, t->backend, o->dtype, &t->net, error));
    PBNDS_TRY(pbnds_adam_init(&t->adam, pbnds_net_param_count(t->net), error));
    PBNDS_TRY(settle_crop(t, error));
    PBNDS_TRY(pbnds_batch_init(&t->batch, t->ops, &t->task, t->net, t->batch_size,
                               t->crop, 0, error));
    PBNDS_TRY(pbnds_batch_init(&t->validation, t->ops, &t->task, t->net, 1, t->crop, 0,
                               error));
    return start_state(t, error);
}

static void destroy(struct trainer *t)
{
    pbnds_batch_free(&t->batch);
    pbnds_batch_free(&t->validation);
    for (int i = 0; t->train_items && i < t->train_list.count; ++i) {
        pbnds_train_item_free(&t->train_items[i]);
    }
    for (int i = 0; t->val_items && i < t->val_list.count; ++i) {
        pbnds_train_item_free(&t->val_items[i]);
    }
    free(t->train_items);
    free(t->val_items);
    pbnds_sample_list_free(&t->train_list);
    pbnds_sample_list_free(&t->val_list);
    pbnds_adam_free(&t->adam);
    pbnds_net_free(t->net);
    pbnds_backend_free(t->backend);
}

/* Linear warm-up, then half a cosine down to a fraction of the peak. */
static float learning_rate(const struct trainer *t, uint64_t step)
{
    const double warm = fmin(1.0, ((double)step + 1.0) / WARM_UP_STEPS);
    const double x = (double)step / (double)t->steps;
    const double cosine = 0.5 * (1.0 + cos(3.14159265358979323846 * x));
    return (float)(t->lr * warm * (LR_FLOOR + (1.0 - LR_FLOOR) * cosine));
}

static enum pbnds_status draw_views(struct trainer *t, uint64_t step,
                                    struct pbnds_task_view *views,
                                    struct pbnds_error *error)
{
    ++t->draws;
    for (int b = 0; b < t->batch_size; ++b) {
        struct pbnds_rng rng = pbnds_rng_make(t->options->seed, step, (uint64_t)b);
        const int i = (int)(pbnds_rng_u64(&rng) % (uint64_t)t->train_list.count);
        PBNDS_TRY(item_at(t, &t->train_list, t->train_items, i, error));
        const struct pbnds_view *v = &t->train_items[i].view;
        const uint64_t across = (uint64_t)(v->width - t->crop) + 1;
        const uint64_t down = (uint64_t)(v->height - t->crop) + 1;
        views[b] = (struct pbnds_task_view){
            .item = &t->train_items[i],
            .window = {(int)(pbnds_rng_u64(&rng) % across),
                       (int)(pbnds_rng_u64(&rng) % down), t->crop, t->crop},
            .key = pbnds_rng_u64(&rng),
            .train = true};
    }
    return PBNDS_OK;
}

static enum pbnds_status train_step(struct trainer *t, struct pbnds_error *error)
{
    struct pbnds_task_view views[BATCH_MAX];
    PBNDS_TRY(draw_views(t, t->state.step, views, error));
    pbnds_net_zero_grads(t->net);
    struct pbnds_task_loss loss;
    const uint64_t key = pbnds_rng_make(t->options->seed, t->state.step, 1u << 20).key;
    PBNDS_TRY(pbnds_batch_run(&t->batch, views, true, key, &loss, error));
    if (pbnds_stop_requested())
        return pbnds_fail_interrupted(error); /* half a step: drop it */
    float *grads = pbnds_net_grads(t->net);
    const double norm =
        pbnds_clip_norm(grads, pbnds_net_param_count(t->net), CLIP_NORM);
    if (!isfinite(loss.total) || !isfinite(norm)) {
        return pbnds_fail(
            error, PBNDS_ERROR_BACKEND,
            "%s: training diverged at step %" PRIu64
            " (loss %g, gradient norm %g); the last checkpoint is kept, go on "
            "from it with a smaller --lr",
            t->options->weights, t->state.step, loss.total, norm);
    }
    pbnds_adam_step(&t->adam, learning_rate(t, t->state.step), grads,
                    pbnds_net_params(t->net));
    pbnds_net_params_changed(t->net);
    ++t->state.step;
    t->loss_sum += loss.total;
    ++t->loss_count;
    if (loss.mse >= 0.0) {
        t->mse_sum += loss.mse;
        ++t->mse_count;
    }
    return PBNDS_OK;
}

/* Fixed views, centre crops, fixed lights: the same measure every time. */
static enum pbnds_status validate(struct trainer *t, double *loss, double *mse,
                                  struct pbnds_error *error)
{
    const int count =
        t->val_list.count < VALIDATION_VIEWS ? t->val_list.count : VALIDATION_VIEWS;
    *loss = *mse = 0.0;
    int counted = 0;
    for (int i = 0; i < count; ++i) {
        ++t->draws;
        PBNDS_TRY(item_at(t, &t->val_list, t->val_items, i, error));
        const struct pbnds_view *v = &t->val_items[i].view;
        const struct pbnds_task_view view = {
            .item = &t->val_items[i],
            .window = {(v->width - t->crop) / 2, (v->height - t->crop) / 2, t->crop,
                       t->crop},
            .key = pbnds_rng_make(t->options->seed, (uint64_t)i, 1u << 21).key};
        struct pbnds_task_loss one;
        PBNDS_TRY(pbnds_batch_run(&t->validation, &view, false, 0, &one, error));
        if (one.mse < 0.0) continue; /* the crop shows nothing */
        *loss += one.total;
        *mse += one.mse;
        ++counted;
    }
    *loss /= counted > 0 ? counted : 1;
    *mse /= counted > 0 ? counted : 1;
    return PBNDS_OK;
}

static enum pbnds_status save_weights(struct trainer *t, double val_psnr,
                                      struct pbnds_error *error)
{
    const struct pbnds_provenance provenance = {.model = t->ops->model,
                                                .lights = t->task.lights,
                                                .data = t->data_hash,
                                                .recipe = t->state.recipe,
                                                .step = t->state.step,
                                                .steps = (uint64_t)t->steps,
                                                .seed = t->options->seed,
                                                .dtype = t->options->dtype,
                                                .validation_psnr = val_psnr};
    return pbnds_weights_save_trained(t->options->weights, t->net, &provenance, error);
}

/* Validation, the curve, the weights where they are the best so far, the checkpoint. */
static enum pbnds_status take_stock(struct trainer *t, struct pbnds_error *error)
{
    double loss, mse;
    PBNDS_TRY(validate(t, &loss, &mse, error));
    if (pbnds_stop_requested()) return pbnds_fail_interrupted(error);
    t->state.seconds = now() - t->started;
    const double train_mse = t->mse_count ? t->mse_sum / t->mse_count : 0.0;
    const struct pbnds_curve_row row = {
        .step = t->state.step,
        .seconds = t->state.seconds,
        .lr = (double)learning_rate(t, t->state.step),
        .loss = t->loss_count ? t->loss_sum / t->loss_count : 0.0,
        .train_psnr = psnr(train_mse),
        .val_loss = loss,
        .val_psnr = psnr(mse)};
    PBNDS_TRY(pbnds_curve_append(t->curve_path, &row, error));
    t->loss_sum = t->mse_sum = 0.0;
    t->loss_count = t->mse_count = 0;
    if (t->val_list.count == 0 || loss < t->state.best) {
        t->state.best = loss;
        PBNDS_TRY(save_weights(t, psnr(mse), error));
    }
    t->state.stocked = t->state.step;
    return pbnds_checkpoint_save(t->checkpoint_path, &t->state, t->net, &t->adam,
                                 error);
}

/* A checkpoint between steps; the stock of a step that was due is taken on resume. */
static enum pbnds_status stop_here(struct trainer *t, struct pbnds_error *error)
{
    if (t->state.step > 0) {
        t->state.seconds = now() - t->started;
        PBNDS_TRY(pbnds_checkpoint_save(t->checkpoint_path, &t->state, t->net, &t->adam,
                                        error));
    }
    return pbnds_fail_interrupted(error);
}

static enum pbnds_status run(struct trainer *t, struct pbnds_error *error)
{
    const uint64_t steps = (uint64_t)t->steps;
    const uint64_t interval = steps / 50 < 1 ? 1 : steps / 50 > 500 ? 500 : steps / 50;
    while (t->state.stocked < steps) {
        const bool due = t->state.step > t->state.stocked &&
                         (t->state.step % interval == 0 || t->state.step == steps);
        const enum pbnds_status status =
            due ? take_stock(t, error) : train_step(t, error);
        /* What was interrupted is dropped: the state is the one before it. */
        if (status == PBNDS_ERROR_INTERRUPTED) return stop_here(t, error);
        PBNDS_TRY(status);
        pbnds_progress(t->report, "train", (double)t->state.step, (double)steps);
        if (due && t->options->seconds > 0.0 && t->state.step < steps &&
            now() - t->started >= t->options->seconds) {
            pbnds_warn(t->report,
                       "time is up at step %" PRIu64 " of %" PRIu64
                       "; --resume goes on",
                       t->state.step, steps);
            return PBNDS_OK;
        }
    }
    return remove(t->checkpoint_path) == 0
               ? PBNDS_OK
               : pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be removed",
                            t->checkpoint_path);
}

enum pbnds_status pbnds_train(const struct pbnds_train_options *options,
                              const struct pbnds_report *report,
                              struct pbnds_error *error)
{
    struct trainer *t = calloc(1, sizeof *t);
    if (!t) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory to train");
    t->options = options;
    t->report = report;
    enum pbnds_status status = build(t, error);
    if (status == PBNDS_OK) status = run(t, error);
    destroy(t);
    free(t);
    return status;
}
