/* Taking stock: validation, and everything that a run writes. */
#include <math.h>
#include <stdio.h>
#include <time.h>

#include "engine/core/ranks.h"
#include "engine/core/rng.h"
#include "neural/provenance.h"
#include "neural/train/curve.h"
#include "neural/train/curve_plot.h"
#include "neural/train/trainer.h"

enum { VALIDATION_VIEWS = 32 };

static const double PLOT_SECONDS = 1.0; /* nobody looks more often */

double pbnds_trainer_now(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double psnr(double mse)
{
    return mse > 0.0 ? -10.0 * log10(mse) : 99.0;
}

static bool all_finite(const float *x, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(x[i])) return false;
    }
    return true;
}

enum pbnds_status pbnds_trainer_fixed_view(struct pbnds_trainer *t, int list, int i,
                                           struct pbnds_task_view *view,
                                           struct pbnds_error *error)
{
    const struct pbnds_train_item *item;
    pbnds_train_items_turn(&t->items);
    PBNDS_TRY(pbnds_train_items_get(&t->items, list, i, &item, error));
    const struct pbnds_view *v = &item->view;
    if (v->width < t->crop || v->height < t->crop) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: is %d x %d, smaller than the crop of %d; give --crop",
                          t->items.list[list].folders[i], v->width, v->height, t->crop);
    }
    *view = (struct pbnds_task_view){
        .item = item,
        .window = {(v->width - t->crop) / 2, (v->height - t->crop) / 2, t->crop,
                   t->crop},
        .key = pbnds_rng_make(t->options->seed, (uint64_t)i, 1u << 21).key};
    return PBNDS_OK;
}

/* Centre crops, each process some of them. What the others add to a view's place is zero,
 * so the sums are the same bits for any number of processes. */
static enum pbnds_status validate(struct pbnds_trainer *t, double *loss, double *mse,
                                  struct pbnds_error *error)
{
    const int there = t->items.list[PBNDS_ITEMS_VAL].count;
    const int count = there < VALIDATION_VIEWS ? there : VALIDATION_VIEWS;
    double values[2 * VALIDATION_VIEWS] = {0.0};
    enum pbnds_status status = PBNDS_OK;
    for (int i = pbnds_rank(); i < count && status == PBNDS_OK;
         i += pbnds_rank_count()) {
        struct pbnds_task_view view;
        struct pbnds_task_loss one = {0.0, 0.0};
        status = pbnds_trainer_fixed_view(t, PBNDS_ITEMS_VAL, i, &view, error);
        if (status == PBNDS_OK)
            status = pbnds_batch_run(&t->validation, &view, false, 0, &one, error);
        values[2 * i] = one.total;
        values[2 * i + 1] = one.mse;
    }
    PBNDS_TRY(pbnds_trainer_agree_or_stop(t, status, error));
    pbnds_ranks_sum(values, 2 * VALIDATION_VIEWS);
    *loss = *mse = 0.0;
    int counted = 0;
    for (int i = 0; i < count; ++i) {
        if (values[2 * i + 1] < 0.0) continue; /* the crop shows nothing */
        *loss += values[2 * i];
        *mse += values[2 * i + 1];
        ++counted;
    }
    *loss /= counted > 0 ? counted : 1;
    *mse /= counted > 0 ? counted : 1;
    return isfinite(*loss) ? PBNDS_OK : pbnds_trainer_diverged(t, *loss, NAN, error);
}

static enum pbnds_status save_weights(struct pbnds_trainer *t, double val_psnr,
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

static enum pbnds_status write_curve(struct pbnds_trainer *t, double loss, double mse,
                                     struct pbnds_error *error)
{
    const struct pbnds_checkpoint *s = &t->state;
    const struct pbnds_curve_row row = {
        .step = s->step,
        .seconds = s->seconds,
        .lr = pbnds_trainer_learning_rate(t, s->step),
        .loss = s->loss_count ? s->loss_sum / (double)s->loss_count : 0.0,
        .train_psnr = psnr(s->mse_count ? s->mse_sum / (double)s->mse_count : 0.0),
        .val_loss = loss,
        .val_psnr = psnr(mse)};
    PBNDS_TRY(pbnds_curve_append(t->curve_path, &row, error));
    const double now = pbnds_trainer_now();
    if (s->step < (uint64_t)t->steps && now - t->plotted < PLOT_SECONDS)
        return PBNDS_OK;
    t->plotted = now;
    return pbnds_curve_plot(t->curve_path, t->plot_path, error);
}

static bool sheet_is_due(const struct pbnds_trainer *t)
{
    const uint64_t every = (uint64_t)t->options->sheet_every, step = t->state.step;
    if (every == 0 || !t->ops->picture) return false;
    /* with the first row of the curve at or after each multiple */
    return step == (uint64_t)t->steps || step / every > t->state.stocked / every;
}

/* With the averaged parameters in the net. */
static enum pbnds_status examine(struct pbnds_trainer *t, struct pbnds_error *error)
{
    double loss, mse;
    PBNDS_TRY(validate(t, &loss, &mse, error));
    t->state.seconds = pbnds_trainer_now() - t->started;
    const bool better =
        t->items.list[PBNDS_ITEMS_VAL].count == 0 || loss < t->state.best;
    if (better) t->state.best = loss;
    if (pbnds_rank() > 0) return PBNDS_OK;
    PBNDS_TRY(write_curve(t, loss, mse, error));
    if (better) PBNDS_TRY(save_weights(t, psnr(mse), error));
    return sheet_is_due(t) ? pbnds_trainer_sheet(t, error) : PBNDS_OK;
}

enum pbnds_status pbnds_trainer_save(struct pbnds_trainer *t, struct pbnds_error *error)
{
    const float *params = pbnds_net_params(t->net);
    if (!all_finite(params, pbnds_net_param_count(t->net)))
        return pbnds_trainer_diverged(t, NAN, NAN, error);
    if (pbnds_rank() == 0) {
        t->state.seconds = pbnds_trainer_now() - t->started;
        PBNDS_TRY(pbnds_checkpoint_save(t->checkpoint_path, &t->state, t->net, &t->adam,
                                        &t->ema, error));
    }
    t->saved = t->state.step;
    return PBNDS_OK;
}

static void swap_average(struct pbnds_trainer *t)
{
    if (!t->ema.mean) return;
    pbnds_ema_swap(&t->ema, pbnds_net_params(t->net));
    pbnds_net_params_changed(t->net);
}

enum pbnds_status pbnds_trainer_take_stock(struct pbnds_trainer *t,
                                           struct pbnds_error *error)
{
    const double best = t->state.best;
    if (!all_finite(pbnds_net_params(t->net), pbnds_net_param_count(t->net)))
        return pbnds_trainer_diverged(t, NAN, NAN, error);
    swap_average(t);
    enum pbnds_status status = examine(t, error);
    swap_average(t);
    /* What was interrupted is taken again on resume, with the state from before. */
    const struct pbnds_checkpoint before = t->state;
    if (status == PBNDS_OK) {
        t->state.stocked = t->state.step;
        t->state.loss_sum = t->state.mse_sum = 0.0;
        t->state.loss_count = t->state.mse_count = 0;
        status = pbnds_trainer_save(t, error);
    }
    status = pbnds_trainer_agree(t, status, error);
    if (status != PBNDS_OK) {
        t->state = before;
        t->state.best = best;
    }
    return status;
}
