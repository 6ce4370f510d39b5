/**
 * @file trainer.h
 * The state of a run, for the files of this folder: train.c (the run), trainer_step.c (a
 * step), trainer_stock.c (validation and what is written), trainer_sheet.c.
 */
#ifndef PBNDS_NEURAL_TRAIN_TRAINER_H
#define PBNDS_NEURAL_TRAIN_TRAINER_H

#include "neural/train/adam.h"
#include "neural/train/batch.h"
#include "neural/train/checkpoint.h"
#include "neural/train/ema.h"
#include "neural/train/items.h"

enum { PBNDS_TRAINER_BATCH_MAX = 16 };

struct pbnds_trainer {
    const struct pbnds_train_options *options;
    const struct pbnds_report *report; /* the first rank's; silence on others */
    const struct pbnds_task_ops *ops;
    struct pbnds_task task;
    int steps, batch_size, accumulate, crop;
    double lr;
    char data_hash[17];
    char checkpoint_path[4096], curve_path[4096], plot_path[4096], sheet_path[4096];
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    struct pbnds_adam adam;
    struct pbnds_ema ema;
    struct pbnds_batch batch;      /* training: batch_size views          */
    struct pbnds_batch validation; /* one view at a time, same crop       */
    struct pbnds_train_items items;
    struct pbnds_train_item cuts[PBNDS_TRAINER_BATCH_MAX]; /* of the batch at hand */
    struct pbnds_checkpoint state;
    uint64_t saved; /* step of the checkpoint on disk; 0: none */
    double plotted; /* when the curve was last */
    double started; /* wall clock at which state.seconds began to count */
};

/** The worst status of all ranks is everybody's: the rank that failed says why. Collective.
 */
enum pbnds_status pbnds_trainer_agree(const struct pbnds_trainer *t,
                                      enum pbnds_status status,
                                      struct pbnds_error *error) PBNDS_NODISCARD;
/** The same; a stop that was requested of any of them is a failure too. */
enum pbnds_status
pbnds_trainer_agree_or_stop(const struct pbnds_trainer *t, enum pbnds_status status,
                            struct pbnds_error *error) PBNDS_NODISCARD;

/** Linear warm-up, then half a cosine down to a fraction of the peak. */
double pbnds_trainer_learning_rate(const struct pbnds_trainer *t, uint64_t step);
/** One step; state.step is one more. Collective. After a failure the state is that before
 *  it. */
enum pbnds_status pbnds_trainer_step(struct pbnds_trainer *t,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** The sentence of a run that cannot go on: BACKEND. */
enum pbnds_status pbnds_trainer_diverged(const struct pbnds_trainer *t, double loss,
                                         double norm, struct pbnds_error *error);

/** Validation, the curve, the weights where they are the best so far, the checkpoint.
 *  Collective. */
enum pbnds_status pbnds_trainer_take_stock(struct pbnds_trainer *t,
                                           struct pbnds_error *error) PBNDS_NODISCARD;
/** A checkpoint of the present state, by the first rank. Parameters that are not finite are
 *  never saved: BACKEND. */
enum pbnds_status pbnds_trainer_save(struct pbnds_trainer *t,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Fixed views with fixed lights: number i of the validation. */
enum pbnds_status pbnds_trainer_fixed_view(struct pbnds_trainer *t, int list, int i,
                                           struct pbnds_task_view *view,
                                           struct pbnds_error *error) PBNDS_NODISCARD;
/** Predictions of the parameters in the net beside their references, as a picture. */
enum pbnds_status pbnds_trainer_sheet(struct pbnds_trainer *t,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

/** Seconds of a clock that only goes forward. */
double pbnds_trainer_now(void);

#endif /* PBNDS_NEURAL_TRAIN_TRAINER_H */
