/**
 * @file task.h
 * What differs between models in training: the lights, the inputs and the loss. The
 * loop (train.c) and the network (net.h) know nothing of it.
 */
#ifndef PBNDS_NEURAL_TRAIN_TASK_H
#define PBNDS_NEURAL_TRAIN_TASK_H

#include "neural/model/model.h"
#include "neural/train/item.h"
#include "neural/train/train.h"

/** One view of a batch: which sample, which window of it, under which lights. */
struct pbnds_task_view {
    const struct pbnds_train_item *item;
    struct pbnds_window window; /**< inside the image */
    uint64_t key; /**< of this view in this step: everything random follows */
    bool train;   /**< false in validation: no dark gate */
};

/** Losses of one view, for the curves. */
struct pbnds_task_loss {
    double total; /**< what is minimised */
    double mse;   /**< of sRGB(clamp(radiance)) against the reference's, covered pixels;
                       < 0 when this view has none (a dark sample)                      */
};

struct pbnds_task {
    const struct pbnds_model *model;
    int lights; /**< N a view */
    double p_dark, lambda_zero;
};

/** Defaults and functions of one model. */
struct pbnds_task_ops {
    const struct pbnds_model *model;
    bool transport; /**< items need the transport planes */
    int batch, steps, lights;
    double lr;
    double p_dark, lambda_zero;
    /** [h, w, view_channels] */
    void (*view_input)(const struct pbnds_task *task,
                       const struct pbnds_task_view *view, float *dst);
    /** [N, h, w, light_channels]; lights [first, first + count) of the view's N. */
    void (*light_input)(const struct pbnds_task *task,
                        const struct pbnds_task_view *view, int first, int count,
                        float *dst);
    /** out: [N, h, w, Co]; view_out: [h, w, Cv] or NULL. Fills the gradients of
     * `weight` times the total loss. */
    struct pbnds_task_loss (*loss)(const struct pbnds_task *task,
                                   const struct pbnds_task_view *view, double weight,
                                   const float *out, const float *view_out,
                                   float *d_out, float *d_view_out);
    /** rgb: [h, w, 3] linear radiance that these outputs mean, without emission; what it
     *  is where nothing was hit does not matter. NULL: no contact sheets of this model. */
    void (*picture)(const struct pbnds_task *task, const struct pbnds_task_view *view,
                    const float *out, const float *view_out, float *rgb);
};

extern const struct pbnds_task_ops pbnds_task_transport;
extern const struct pbnds_task_ops pbnds_task_pbnds_plus;

/** By the model's name; NULL: no such model can be trained. */
const struct pbnds_task_ops *pbnds_task_find(const char *model);
/** "pbnds+, transport": for messages; the caller's buffer. */
void pbnds_task_names(char *text, size_t size);

/** Squared error of one pixel in display space, as struct pbnds_task_loss says. */
double pbnds_task_display_error(const float *radiance, const float *reference);

#endif /* PBNDS_NEURAL_TRAIN_TASK_H */
