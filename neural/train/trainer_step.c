/* A step: a pure function of (seed, step, parameters, moments) and of how the views are
 * dealt out to processes and batches. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "engine/core/ranks.h"
#include "engine/core/rng.h"
#include "neural/train/cut.h"
#include "neural/train/trainer.h"

static const double CLIP_NORM = 1.0, WARM_UP_STEPS = 200.0, LR_FLOOR = 0.02;

enum pbnds_status pbnds_trainer_agree(const struct pbnds_trainer *t,
                                      enum pbnds_status status,
                                      struct pbnds_error *error)
{
    const int worst = pbnds_ranks_max((int)status);
    if (status != PBNDS_OK || worst == 0) return status;
    if (worst == (int)PBNDS_ERROR_INTERRUPTED) return pbnds_fail_interrupted(error);
    return pbnds_fail(error, (enum pbnds_status)worst,
                      "%s: another process of this run failed", t->options->weights);
}

enum pbnds_status pbnds_trainer_agree_or_stop(const struct pbnds_trainer *t,
                                              enum pbnds_status status,
                                              struct pbnds_error *error)
{
    if (status == PBNDS_OK && pbnds_stop_requested())
        status = pbnds_fail_interrupted(error);
    return pbnds_trainer_agree(t, status, error);
}

enum pbnds_status pbnds_trainer_diverged(const struct pbnds_trainer *t, double loss,
                                         double norm, struct pbnds_error *error)
{
    char kept[64] = "there is no checkpoint yet";
    if (t->saved > 0) {
        (void)snprintf(kept, sizeof kept, "the checkpoint of step %" PRIu64 " is kept",
                       t->saved);
    }
    return pbnds_fail(error, PBNDS_ERROR_BACKEND,
                      "%s: training diverged at step %" PRIu64
                      " (loss %g, gradient norm %g); %s; look for a sample whose light "
                      "is not finite, or train anew with a smaller --lr",
                      t->options->weights, t->state.step, loss, norm, kept);
}

double pbnds_trainer_learning_rate(const struct pbnds_trainer *t, uint64_t step)
{
    const double warm = fmin(1.0, ((double)step + 1.0) / WARM_UP_STEPS);
    const double x = (double)step / (double)t->steps;
    const double cosine = 0.5 * (1.0 + cos(3.14159265358979323846 * x));
    return t->lr * warm * (LR_FLOOR + (1.0 - LR_FLOOR) * cosine);
}

/* View `number` of the step, cut into cuts[slot]. */
static enum pbnds_status draw_view(struct pbnds_trainer *t, int number, int slot,
                                   struct pbnds_task_view *view,
                                   struct pbnds_error *error)
{
    struct pbnds_rng rng =
        pbnds_rng_make(t->options->seed, t->state.step, (uint64_t)number);
    const uint64_t count = (uint64_t)t->items.list[PBNDS_ITEMS_TRAIN].count;
    const int i = (int)(pbnds_rng_u64(&rng) % count);
    const struct pbnds_train_item *item;
    PBNDS_TRY(pbnds_train_items_get(&t->items, PBNDS_ITEMS_TRAIN, i, &item, error));
    const struct pbnds_view *v = &item->view;
    if (v->width < t->crop || v->height < t->crop) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: is %d x %d, smaller than the crop of %d; give --crop",
                          t->items.list[PBNDS_ITEMS_TRAIN].folders[i], v->width,
                          v->height, t->crop);
    }
    const uint64_t across = (uint64_t)(v->width - t->crop) + 1;
    const uint64_t down = (uint64_t)(v->height - t->crop) + 1;
    struct pbnds_cut cut = {.window = {.width = t->crop, .height = t->crop}};
    cut.window.x = (int)(pbnds_rng_u64(&rng) % across);
    cut.window.y = (int)(pbnds_rng_u64(&rng) % down);
    *view = (struct pbnds_task_view){.item = &t->cuts[slot],
                                     .window = {0, 0, t->crop, t->crop},
                                     .key = pbnds_rng_u64(&rng),
                                     .train = true};
    if (t->options->augment) {
        cut.mirror = (pbnds_rng_u64(&rng) & 1u) != 0;
        if (item->target == PBNDS_TARGET_RADIANCE)
            cut.stops = 2.0f * pbnds_rng_float(&rng) - 1.0f;
    }
    return pbnds_train_item_cut(item, &cut, &t->cuts[slot], error);
}

/* The views of this process, batch by batch; gradients add up in the net. */
static enum pbnds_status run_views(struct pbnds_trainer *t, struct pbnds_task_loss *sum,
                                   double *mse_count, struct pbnds_error *error)
{
    const uint64_t key = pbnds_rng_make(t->options->seed, t->state.step, 1u << 20).key;
    const int mine = t->batch_size * t->accumulate;
    enum pbnds_status status = PBNDS_OK;
    pbnds_net_zero_grads(t->net);
    t->batch.step_views = mine * pbnds_rank_count();
    for (int k = 0; k < t->accumulate && status == PBNDS_OK; ++k) {
        struct pbnds_task_view views[PBNDS_TRAINER_BATCH_MAX];
        struct pbnds_task_loss loss;
        int drawn = 0;
        t->batch.first_view = pbnds_rank() * mine + k * t->batch_size;
        pbnds_train_items_turn(&t->items);
        while (drawn < t->batch_size && status == PBNDS_OK) {
            status =
                draw_view(t, t->batch.first_view + drawn, drawn, &views[drawn], error);
            drawn += status == PBNDS_OK;
        }
        if (status == PBNDS_OK)
            status = pbnds_batch_run(&t->batch, views, true, key, &loss, error);
        if (status == PBNDS_OK) {
            sum->total += loss.total;
            sum->mse += t->batch.mse_sum;
            *mse_count += t->batch.mse_count;
        }
        while (drawn > 0)
            pbnds_train_cut_free(&t->cuts[--drawn]);
        if (pbnds_stop_requested()) break; /* the step is dropped below */
    }
    return status;
}

enum pbnds_status pbnds_trainer_step(struct pbnds_trainer *t, struct pbnds_error *error)
{
    struct pbnds_task_loss loss = {0.0, 0.0};
    double mse_count = 0.0;
    const enum pbnds_status status = run_views(t, &loss, &mse_count, error);
    PBNDS_TRY(pbnds_trainer_agree_or_stop(t, status, error));
    float *grads = pbnds_net_grads(t->net), *params = pbnds_net_params(t->net);
    const size_t count = pbnds_net_param_count(t->net);
    double sums[3] = {loss.total, loss.mse, mse_count};
    pbnds_ranks_sum(sums, 3);
    PBNDS_TRY(pbnds_ranks_sum_in_order(grads, count, error));
    const double norm = pbnds_clip_norm(grads, count, CLIP_NORM);
    if (!isfinite(sums[0]) || !isfinite(norm))
        return pbnds_trainer_diverged(t, sums[0], norm, error);
    pbnds_adam_step(&t->adam, (float)pbnds_trainer_learning_rate(t, t->state.step),
                    grads, params);
    pbnds_net_params_changed(t->net);
    ++t->state.step;
    pbnds_ema_update(&t->ema, t->state.step, params);
    t->state.loss_sum += sums[0];
    ++t->state.loss_count;
    if (sums[2] > 0.0) {
        t->state.mse_sum += sums[1] / sums[2];
        ++t->state.mse_count;
    }
    return PBNDS_OK;
}
