/* Training of `pbnds+`: L1 on the display image (pbnds_plus.h), and the energy
 * regularisation (eq. 4) with the reconstruction gated by (1 - z), since taken
 * literally the paper would pull dark samples to the bright target. */
#include <math.h>

#include "engine/core/color.h"
#include "engine/core/rng.h"
#include "neural/model/model_pbnds_plus.h"
#include "neural/pbnds_plus.h"
#include "neural/train/task.h"

enum { LIGHTS_MAX = 1024 };

static bool is_dark(const struct pbnds_task *task, const struct pbnds_task_view *view)
{
    struct pbnds_rng rng = pbnds_rng_make(view->key, 1, 0);
    return view->train && (double)pbnds_rng_float(&rng) < task->p_dark;
}

static void view_input(const struct pbnds_task *task,
                       const struct pbnds_task_view *view, float *dst)
{
    (void)task;
    pbnds_features_view(&pbnds_features_pbnds_plus, &view->item->view, view->window,
                        dst);
}

static void light_input(const struct pbnds_task *task,
                        const struct pbnds_task_view *view, int first, int count,
                        float *dst)
{
    struct pbnds_light_source lights[LIGHTS_MAX];
    const struct pbnds_envmap *envmap = is_dark(task, view) ? NULL : view->item->envmap;
    pbnds_plus_draw_lights(envmap, view->key, task->lights, lights);
    const size_t stride = (size_t)view->window.width * (size_t)view->window.height *
                          (size_t)task->model->light_channels;
    const float gain = exp2f(view->item->stops);
    for (int k = 0; k < count; ++k) {
        lights[first + k].radiance = pbnds_scale(lights[first + k].radiance, gain);
        pbnds_features_light(&pbnds_features_pbnds_plus, &view->item->view, NULL,
                             &lights[first + k], view->window,
                             dst + (size_t)k * stride);
    }
}

/* sRGB as the loss sees it: the exact curve in [0, 1], straight on with its slope below
 * and above, so that a value out of range still knows the way back. */
static float encode(float x, float *slope)
{
    *slope = 12.92f;
    if (x <= 0.0031308f) return 12.92f * x;
    const float at = fminf(x, 1.0f);
    *slope = 1.055f / 2.4f * powf(at, 1.0f / 2.4f - 1.0f);
    return pbnds_srgb_encode(at) + (x - at) * *slope;
}

/* Loss of one pixel's channel, and its slope in the (linear) mean over lights. */
static double channel_loss(const struct pbnds_task *task, bool dark, float mean,
                           float target, float *slope)
{
    float encoding;
    const float y = encode(mean, &encoding);
    if (dark) { /* lambda ||I||_2^2 */
        *slope = (float)(2.0 * task->lambda_zero) * y * encoding;
        return task->lambda_zero * (double)y * (double)y;
    }
    if (target >= 1.0f && y >= 1.0f) { /* both white on the display */
        *slope = 0.0f;
        return 0.0;
    }
    const float d = y - target;
    *slope = (d > 0.0f ? encoding : d < 0.0f ? -encoding : 0.0f);
    return (double)fabsf(d);
}

static struct pbnds_task_loss loss(const struct pbnds_task *task,
                                   const struct pbnds_task_view *view, double weight,
                                   const float *out, const float *view_out,
                                   float *d_out, float *d_view_out)
{
    (void)view_out;
    (void)d_view_out;
    const struct pbnds_window w = view->window;
    const struct pbnds_train_item *item = view->item;
    const float *mask = item->view.plane[PBNDS_PLANE_MASK];
    const size_t stride = 3 * (size_t)w.width * (size_t)w.height;
    const bool dark = is_dark(task, view);
    size_t covered = 0;
    for (int y = 0; y < w.height; ++y) {
        for (int x = 0; x < w.width; ++x) {
            covered +=
                mask[(size_t)(w.y + y) * (size_t)item->view.width + (size_t)(w.x + x)] >
                0.0f;
        }
    }
    const double scale = covered ? weight / (3.0 * (double)covered) : 0.0;
    struct pbnds_task_loss sum = {0.0, 0.0};
    for (int y = 0; y < w.height; ++y) {
        for (int x = 0; x < w.width; ++x) {
            const size_t source =
                (size_t)(w.y + y) * (size_t)item->view.width + (size_t)(w.x + x);
            for (size_t c = 0; c < 3; ++c) {
                const size_t at = 3 * ((size_t)y * (size_t)w.width + (size_t)x) + c;
                float mean = 0.0f, slope = 0.0f;
                if (mask[source] > 0.0f) {
                    for (int k = 0; k < task->lights; ++k)
                        mean += out[(size_t)k * stride + at];
                    mean /= (float)task->lights;
                    const float t = pbnds_srgb_encode(item->radiance[3 * source + c]);
                    sum.total += scale * channel_loss(task, dark, mean, t, &slope);
                    const float e = pbnds_srgb_encode(mean) - t;
                    sum.mse += (double)(e * e);
                }
                const float d = slope * (float)scale / (float)task->lights;
                for (int k = 0; k < task->lights; ++k)
                    d_out[(size_t)k * stride + at] = d;
            }
        }
    }
    sum.mse = covered && !dark ? sum.mse / (3.0 * (double)covered) : -1.0;
    return sum;
}

static void picture(const struct pbnds_task *task, const struct pbnds_task_view *view,
                    const float *out, const float *view_out, float *rgb)
{
    (void)view_out;
    const size_t stride = 3 * (size_t)view->window.width * (size_t)view->window.height;
    for (size_t i = 0; i < stride; ++i) {
        rgb[i] = 0.0f;
        for (int k = 0; k < task->lights; ++k)
            rgb[i] += out[(size_t)k * stride + i];
        rgb[i] /= (float)task->lights;
    }
}

const struct pbnds_task_ops pbnds_task_pbnds_plus = {
    .model = &pbnds_model_pbnds_plus,
    .batch = 1,
    .steps = 10000,
    .lights = 32,
    .lr = 5e-4,
    .p_dark = 0.1,
    .lambda_zero = 1.0,
    .view_input = view_input,
    .light_input = light_input,
    .loss = loss,
    .picture = picture,
};

double pbnds_task_display_error(const float *radiance, const float *reference)
{
    double sum = 0.0;
    for (int c = 0; c < 3; ++c) {
        const float e =
            pbnds_srgb_encode(radiance[c]) - pbnds_srgb_encode(reference[c]);
        sum += (double)(e * e);
    }
    return sum;
}
