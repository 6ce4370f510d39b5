/* Training of `transport`: the loss on the composite, on its direct and indirect parts,
 * and on the visibility of every cluster light, against the path tracer and its shadow
 * rays. */
#include <math.h>
#include <string.h>

#include "neural/model/model_transport.h"
#include "neural/train/task.h"
#include "neural/transport.h"

/* Weights of the parts. The composite is the aim; the others tell where its error lies.
 */
static const double WEIGHT_DIRECT = 0.5, WEIGHT_INDIRECT = 0.5, WEIGHT_VISIBILITY = 0.1;

static void view_input(const struct pbnds_task *task,
                       const struct pbnds_task_view *view, float *dst)
{
    (void)task;
    pbnds_features_view(&pbnds_features_transport, &view->item->view, view->window,
                        dst);
}

static void light_input(const struct pbnds_task *task,
                        const struct pbnds_task_view *view, int first, int count,
                        float *dst)
{
    const size_t stride = (size_t)view->window.width * (size_t)view->window.height *
                          (size_t)task->model->light_channels;
    for (int k = 0; k < count; ++k) {
        const struct pbnds_light_source source = {
            .wi = view->item->lights[first + k].wi, .bit = first + k};
        pbnds_features_light(&pbnds_features_transport, &view->item->view,
                             &view->item->march, &source, view->window,
                             dst + (size_t)k * stride);
    }
}

/* |log(1 + 3x) - log(1 + 3t)| and its slope in x: relative in the bright, absolute in
 * the dark, so that a sun does not drown the shadows. */
static double log_loss(float x, float t, float *slope)
{
    const float d = log1pf(3.0f * x) - log1pf(3.0f * t);
    *slope = (d > 0.0f ? 1.0f : d < 0.0f ? -1.0f : 0.0f) * 3.0f / (1.0f + 3.0f * x);
    return (double)fabsf(d);
}

static float component(struct pbnds_vec3 v, int c)
{
    return c == 0 ? v.x : c == 1 ? v.y : v.z;
}

/* One pixel, all lights: forward sums, then the gradients of every output. */
struct pixel_job {
    const struct pbnds_task *task;
    const struct pbnds_task_view *view;
    struct pbnds_vec3 wi[PBNDS_DATASET_LIGHTS]; /* camera space */
    size_t stride;                              /* pixels of the window */
    const float *out, *view_out;
    float *d_out, *d_view_out;
    float scale; /* weight / (covered pixels * 3) */
};

static void pixel_loss(const struct pixel_job *job, size_t i, size_t source,
                       struct pbnds_task_loss *loss)
{
    const struct pbnds_train_item *item = job->view->item;
    const struct pbnds_transport_pixel pixel =
        pbnds_transport_pixel(&item->view, source);
    const int n = job->task->lights;
    struct pbnds_vec3 a[PBNDS_DATASET_LIGHTS], direct = pbnds_splat(0.0f),
                                               indirect = direct;
    float visible[PBNDS_DATASET_LIGHTS], importance[PBNDS_DATASET_LIGHTS],
        total = 1e-12f;
    for (int k = 0; k < n; ++k) {
        const float *o = job->out + ((size_t)k * job->stride + i) * PBNDS_OUT_COUNT;
        const struct pbnds_vec3 power = item->lights[k].power;
        a[k] = pbnds_mul(power, pbnds_transport_direct(&pixel, job->wi[k]));
        visible[k] = pbnds_transport_visibility(o[PBNDS_OUT_VISIBILITY]);
        importance[k] = pbnds_luminance(a[k]);
        total += importance[k];
        direct = pbnds_mad(direct, a[k], visible[k]);
        const struct pbnds_vec3 s = {pbnds_transport_indirect(o[1]),
                                     pbnds_transport_indirect(o[2]),
                                     pbnds_transport_indirect(o[3])};
        indirect = pbnds_add(indirect, pbnds_mul(power, pbnds_mul(pixel.b, s)));
    }
    const float occlusion = pbnds_transport_occlusion(job->view_out[i]);
    const float *gloss = item->specular + 3 * source;
    const float *target = item->radiance + 3 * source, *lit = item->direct + 3 * source;
    float d_direct[3], d_indirect[3], d_occlusion = 0.0f, radiance[3];
    for (int c = 0; c < 3; ++c) {
        const float x = component(direct, c) + gloss[c] * occlusion;
        const float y = component(indirect, c);
        radiance[c] = x + y;
        float slope_all, slope_direct, slope_indirect;
        loss->total += (double)job->scale * log_loss(x + y, target[c], &slope_all);
        loss->total +=
            WEIGHT_DIRECT * (double)job->scale * log_loss(x, lit[c], &slope_direct);
        loss->total += WEIGHT_INDIRECT * (double)job->scale *
                       log_loss(y, fmaxf(target[c] - lit[c], 0.0f), &slope_indirect);
        d_direct[c] = job->scale * (slope_all + (float)WEIGHT_DIRECT * slope_direct);
        d_indirect[c] =
            job->scale * (slope_all + (float)WEIGHT_INDIRECT * slope_indirect);
        d_occlusion += d_direct[c] * gloss[c];
    }
    job->d_view_out[i] = d_occlusion * occlusion * (1.0f - occlusion);
    loss->mse += pbnds_task_display_error(radiance, target);

    const uint32_t truth = item->visibility[source];
    for (int k = 0; k < n; ++k) {
        const size_t at = ((size_t)k * job->stride + i) * PBNDS_OUT_COUNT;
        const float v = visible[k], t = (float)(truth >> k & 1u);
        /* Binary cross-entropy of the lights in front, weighted half by what they give
         * here. */
        float weight = 0.0f;
        if (importance[k] > 0.0f) {
            weight = (float)WEIGHT_VISIBILITY * 3.0f * job->scale *
                     (0.5f * importance[k] / total + 0.5f / (float)n);
            const float p = t > 0.5f ? v : 1.0f - v;
            loss->total -= (double)(weight * logf(fmaxf(p, 1e-7f)));
        }
        float d_visible = 0.0f;
        for (int c = 0; c < 3; ++c) {
            d_visible += d_direct[c] * component(a[k], c);
            job->d_out[at + 1 + (size_t)c] =
                d_indirect[c] * component(item->lights[k].power, c) *
                component(pixel.b, c) *
                pbnds_transport_indirect_slope(job->out[at + 1 + (size_t)c]);
        }
        job->d_out[at] = d_visible * v * (1.0f - v) + weight * (v - t);
    }
}

static struct pbnds_task_loss loss(const struct pbnds_task *task,
                                   const struct pbnds_task_view *view, double weight,
                                   const float *out, const float *view_out,
                                   float *d_out, float *d_view_out)
{
    const struct pbnds_window w = view->window;
    const struct pbnds_train_item *item = view->item;
    struct pixel_job job = {.task = task,
                            .view = view,
                            .stride = (size_t)w.width * (size_t)w.height,
                            .out = out,
                            .view_out = view_out,
                            .d_out = d_out,
                            .d_view_out = d_view_out};
    for (int k = 0; k < task->lights; ++k) {
        job.wi[k] =
            pbnds_camera_from_world_vector(&item->view.camera, item->lights[k].wi);
    }
    memset(d_out, 0,
           job.stride * (size_t)task->lights * PBNDS_OUT_COUNT * sizeof *d_out);
    memset(d_view_out, 0, job.stride * sizeof *d_view_out);
    size_t covered = 0;
    const float *mask = item->view.plane[PBNDS_PLANE_MASK];
    struct pbnds_task_loss sum = {0.0, 0.0};
    /* Two passes: the number of covered pixels first, it scales the gradients. */
    for (int pass = 0; pass < 2; ++pass) {
        job.scale = covered ? (float)(weight / (3.0 * (double)covered)) : 0.0f;
        for (int y = 0; y < w.height; ++y) {
            for (int x = 0; x < w.width; ++x) {
                const size_t source =
                    (size_t)(w.y + y) * (size_t)item->view.width + (size_t)(w.x + x);
                if (!(mask[source] > 0.0f)) continue;
                if (pass == 0) {
                    ++covered;
                } else {
                    pixel_loss(&job, (size_t)y * (size_t)w.width + (size_t)x, source,
                               &sum);
                }
            }
        }
    }
    sum.mse = covered ? sum.mse / (3.0 * (double)covered) : -1.0;
    return sum;
}

/* The sum of transport.h at one pixel. */
static struct pbnds_vec3 pixel_radiance(const struct pixel_job *job, size_t i,
                                        size_t source)
{
    const struct pbnds_train_item *item = job->view->item;
    const struct pbnds_transport_pixel pixel =
        pbnds_transport_pixel(&item->view, source);
    const float *gloss = item->specular + 3 * source;
    struct pbnds_vec3 sum = pbnds_scale(pbnds_vec3_make(gloss[0], gloss[1], gloss[2]),
                                        pbnds_transport_occlusion(job->view_out[i]));
    for (int k = 0; k < job->task->lights; ++k) {
        const float *o = job->out + ((size_t)k * job->stride + i) * PBNDS_OUT_COUNT;
        const struct pbnds_vec3 s = {
            pbnds_transport_indirect(o[PBNDS_OUT_INDIRECT]),
            pbnds_transport_indirect(o[PBNDS_OUT_INDIRECT + 1]),
            pbnds_transport_indirect(o[PBNDS_OUT_INDIRECT + 2])};
        const struct pbnds_vec3 direct =
            pbnds_scale(pbnds_transport_direct(&pixel, job->wi[k]),
                        pbnds_transport_visibility(o[PBNDS_OUT_VISIBILITY]));
        sum = pbnds_add(sum, pbnds_mul(item->lights[k].power,
                                       pbnds_add(direct, pbnds_mul(pixel.b, s))));
    }
    return sum;
}

static void picture(const struct pbnds_task *task, const struct pbnds_task_view *view,
                    const float *out, const float *view_out, float *rgb)
{
    const struct pbnds_window w = view->window;
    const struct pbnds_view *planes = &view->item->view;
    struct pixel_job job = {.task = task,
                            .view = view,
                            .stride = (size_t)w.width * (size_t)w.height,
                            .out = out,
                            .view_out = view_out};
    for (int k = 0; k < task->lights; ++k) {
        job.wi[k] =
            pbnds_camera_from_world_vector(&planes->camera, view->item->lights[k].wi);
    }
    memset(rgb, 0, 3 * job.stride * sizeof *rgb);
    for (size_t i = 0; i < job.stride; ++i) {
        const size_t x = i % (size_t)w.width, y = i / (size_t)w.width;
        const size_t source =
            ((size_t)w.y + y) * (size_t)planes->width + (size_t)w.x + x;
        if (!(planes->plane[PBNDS_PLANE_MASK][source] > 0.0f)) continue;
        const struct pbnds_vec3 sum = pixel_radiance(&job, i, source);
        rgb[3 * i] = sum.x;
        rgb[3 * i + 1] = sum.y;
        rgb[3 * i + 2] = sum.z;
    }
}

const struct pbnds_task_ops pbnds_task_transport = {
    .model = &pbnds_model_transport,
    .transport = true,
    .batch = 1,
    .steps = 20000,
    .lights = PBNDS_DATASET_LIGHTS,
    .lr = 1e-3,
    .view_input = view_input,
    .light_input = light_input,
    .loss = loss,
    .picture = picture,
};
