#include "neural/train/batch.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "neural/model/model_transport.h"

static size_t pixels_of(const struct pbnds_batch *b)
{
    return (size_t)b->crop * (size_t)b->crop;
}

enum pbnds_status pbnds_batch_init(struct pbnds_batch *batch,
                                   const struct pbnds_task_ops *ops,
                                   const struct pbnds_task *task, struct pbnds_net *net,
                                   int views, int crop, int chunk,
                                   struct pbnds_error *error)
{
    *batch = (struct pbnds_batch){
        .ops = ops, .task = *task, .net = net, .views = views, .crop = crop};
    batch->out_channels = ops->transport ? PBNDS_TRANSPORT_OUT_CHANNELS : 3;
    batch->view_out_channels = ops->transport ? 1 : 0;
    const size_t pixels = pixels_of(batch), b = (size_t)views, n = (size_t)task->lights;
    /* about 160 float channels of activations and gradients are alive a pixel and light
     */
    const size_t a_light =
        b * pixels * sizeof(float) * ((size_t)task->model->light_channels + 160);
    const size_t fit = ((size_t)1 << 30) / a_light;
    const size_t most = chunk > 0 ? (size_t)chunk : fit < 1 ? 1 : fit;
    batch->chunk = most < n ? (int)most : (int)n;
    const size_t c = (size_t)batch->chunk, co = (size_t)batch->out_channels;
    batch->view_input = malloc(b * pixels * (size_t)task->model->view_channels * 4u);
    batch->light_input =
        malloc(b * c * pixels * (size_t)task->model->light_channels * 4u);
    batch->out = malloc(b * n * pixels * co * 4u);
    batch->d_out = malloc(b * n * pixels * co * 4u);
    batch->view_out = malloc(b * pixels * 4u);
    batch->d_view_out = malloc(b * pixels * 4u);
    batch->part = malloc(b * c * pixels * co * 4u);
    batch->d_part = malloc(b * c * pixels * co * 4u);
    if (!batch->view_input || !batch->light_input || !batch->out || !batch->d_out ||
        !batch->view_out || !batch->d_view_out || !batch->part || !batch->d_part) {
        pbnds_batch_free(batch);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "no memory for a batch of %d views of %d x %d and %d lights",
                          views, crop, crop, task->lights);
    }
    return PBNDS_OK;
}

void pbnds_batch_free(struct pbnds_batch *batch)
{
    free(batch->view_input);
    free(batch->light_input);
    free(batch->out);
    free(batch->d_out);
    free(batch->view_out);
    free(batch->d_view_out);
    free(batch->part);
    free(batch->d_part);
    *batch = (struct pbnds_batch){0};
}

static struct pbnds_pass pass_of(const struct pbnds_batch *b, int first, int count,
                                 bool train, uint64_t key)
{
    return (struct pbnds_pass){.batch = b->views,
                               .lights = count,
                               .h = b->crop,
                               .w = b->crop,
                               .train = train,
                               .first_view = b->first_view,
                               .dropout_key =
                                   pbnds_mix64(key ^ pbnds_mix64((uint64_t)first))};
}

/* Moves the chunk's lights between [B, N] and [B, count] order. */
static void copy_chunk(const struct pbnds_batch *b, int first, int count, float *all,
                       float *part, bool gather)
{
    const size_t image = pixels_of(b) * (size_t)b->out_channels;
    for (int v = 0; v < b->views; ++v) {
        float *whole =
            all + ((size_t)v * (size_t)b->task.lights + (size_t)first) * image;
        float *piece = part + (size_t)v * (size_t)count * image;
        const size_t bytes = (size_t)count * image * sizeof(float);
        if (gather) {
            memcpy(piece, whole, bytes);
        } else {
            memcpy(whole, piece, bytes);
        }
    }
}

static enum pbnds_status forward_chunk(struct pbnds_batch *b,
                                       const struct pbnds_task_view *views, int first,
                                       int count, bool train, uint64_t key,
                                       struct pbnds_error *error)
{
    const size_t stride =
        pixels_of(b) * (size_t)b->task.model->light_channels * (size_t)count;
    for (int v = 0; v < b->views; ++v) {
        b->ops->light_input(&b->task, &views[v], first, count,
                            b->light_input + (size_t)v * stride);
    }
    const struct pbnds_pass pass = pass_of(b, first, count, train, key);
    return pbnds_net_forward_light(b->net, &pass, b->light_input, b->part, error);
}

static enum pbnds_status backward(struct pbnds_batch *b,
                                  const struct pbnds_task_view *views, uint64_t key,
                                  struct pbnds_error *error)
{
    const int n = b->task.lights;
    for (int first = 0; first < n; first += b->chunk) {
        const int count = n - first < b->chunk ? n - first : b->chunk;
        if (b->chunk < n) { /* the activations of this chunk were not kept */
            PBNDS_TRY(forward_chunk(b, views, first, count, true, key, error));
        }
        copy_chunk(b, first, count, b->d_out, b->d_part, true);
        const struct pbnds_pass pass = pass_of(b, first, count, true, key);
        PBNDS_TRY(pbnds_net_backward_light(b->net, &pass, b->d_part, error));
    }
    const struct pbnds_pass pass = pass_of(b, 0, b->chunk, true, key);
    return pbnds_net_backward_view(b->net, &pass,
                                   b->view_out_channels ? b->d_view_out : NULL, error);
}

enum pbnds_status pbnds_batch_run(struct pbnds_batch *b,
                                  const struct pbnds_task_view *views, bool train,
                                  uint64_t key, struct pbnds_task_loss *loss,
                                  struct pbnds_error *error)
{
    const size_t pixels = pixels_of(b);
    const int n = b->task.lights;
    for (int v = 0; v < b->views; ++v) {
        b->ops->view_input(&b->task, &views[v],
                           b->view_input + (size_t)v * pixels *
                                               (size_t)b->task.model->view_channels);
    }
    const struct pbnds_pass pass = pass_of(b, 0, b->chunk, train, key);
    PBNDS_TRY(pbnds_net_forward_view(b->net, &pass, b->view_input,
                                     b->view_out_channels ? b->view_out : NULL, error));
    for (int first = 0; first < n; first += b->chunk) {
        const int count = n - first < b->chunk ? n - first : b->chunk;
        PBNDS_TRY(forward_chunk(b, views, first, count, train, key, error));
        copy_chunk(b, first, count, b->out, b->part, false);
    }
    *loss = (struct pbnds_task_loss){0.0, 0.0};
    const size_t image = (size_t)n * pixels * (size_t)b->out_channels;
    const double weight = 1.0 / (b->step_views > 0 ? b->step_views : b->views);
    b->mse_sum = 0.0;
    b->mse_count = 0;
    for (int v = 0; v < b->views; ++v) {
        const struct pbnds_task_loss one =
            b->ops->loss(&b->task, &views[v], weight, b->out + (size_t)v * image,
                         b->view_out + (size_t)v * pixels, b->d_out + (size_t)v * image,
                         b->d_view_out + (size_t)v * pixels);
        loss->total += one.total;
        if (one.mse >= 0.0) {
            b->mse_sum += one.mse;
            ++b->mse_count;
        }
    }
    loss->mse = b->mse_count ? b->mse_sum / b->mse_count : -1.0;
    return train ? backward(b, views, key, error) : PBNDS_OK;
}
