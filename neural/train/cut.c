#include "neural/train/cut.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where the pixels of a cut are in the image it is cut from. */
struct place {
    struct pbnds_window window;
    size_t width; /* of the image */
    bool mirror;
};

static size_t source_of(const struct place *p, int x, int y)
{
    const int across = p->mirror ? p->window.width - 1 - x : x;
    return (size_t)(p->window.y + y) * p->width + (size_t)(p->window.x + across);
}

/* `channels` interleaved floats a pixel, times gain. */
static void copy_floats(const struct place *p, const float *src, size_t channels,
                        float gain, float *dst)
{
    for (int y = 0; y < p->window.height; ++y) {
        for (int x = 0; x < p->window.width; ++x, dst += channels) {
            const float *from = src + channels * source_of(p, x, y);
            for (size_t c = 0; c < channels; ++c)
                dst[c] = gain * from[c];
        }
    }
}

static bool cut_colors(const struct place *p, const float *src, float gain, float **dst)
{
    if (!src) return true;
    const size_t count = (size_t)p->window.width * (size_t)p->window.height;
    *dst = malloc(3 * count * sizeof **dst);
    if (*dst) copy_floats(p, src, 3, gain, *dst);
    return *dst != NULL;
}

static bool cut_words(const struct place *p, const uint32_t *src, uint32_t **dst)
{
    if (!src) return true;
    const size_t count = (size_t)p->window.width * (size_t)p->window.height;
    uint32_t *to = *dst = malloc(count * sizeof **dst);
    if (!to) return false;
    for (int y = 0; y < p->window.height; ++y) {
        for (int x = 0; x < p->window.width; ++x)
            *to++ = src[source_of(p, x, y)];
    }
    return true;
}

/* Which plane of the image becomes plane k of the mirrored one. */
static int mirrored_plane(int k)
{
    if (k < PBNDS_PLANE_HORIZON) return k;
    const int azimuth = k - PBNDS_PLANE_HORIZON;
    return PBNDS_PLANE_HORIZON +
           (PBNDS_HORIZONS + PBNDS_HORIZONS / 2 - azimuth) % PBNDS_HORIZONS;
}

static bool cut_view(const struct place *p, const struct pbnds_view *src,
                     struct pbnds_view *dst)
{
    const size_t count = (size_t)p->window.width * (size_t)p->window.height;
    *dst = (struct pbnds_view){.width = p->window.width,
                               .height = p->window.height,
                               .image_width = p->window.width,
                               .image_height = p->window.height,
                               .camera = src->camera};
    dst->storage = malloc(count * (PBNDS_PLANE_COUNT + 1) * sizeof *dst->storage);
    if (!dst->storage) return false;
    for (int k = 0; k < PBNDS_PLANE_COUNT; ++k) {
        dst->plane[k] = dst->storage + (size_t)k * count;
        const bool turns = k == PBNDS_PLANE_NORMAL_X || k == PBNDS_PLANE_WO_X;
        copy_floats(p, src->plane[p->mirror ? mirrored_plane(k) : k], 1,
                    p->mirror && turns ? -1.0f : 1.0f, dst->plane[k]);
    }
    float *depth = dst->storage + (size_t)PBNDS_PLANE_COUNT * count;
    copy_floats(p, src->depth, 1, 1.0f, depth);
    dst->depth = depth;
    for (int row = 0; p->mirror && row < 3; ++row) {
        float *x_axis = dst->camera.world_from_camera.m;
        x_axis[row] = -x_axis[row];
    }
    return true;
}

enum pbnds_status pbnds_train_item_cut(const struct pbnds_train_item *item,
                                       const struct pbnds_cut *cut,
                                       struct pbnds_train_item *out,
                                       struct pbnds_error *error)
{
    const struct place p = {cut->window, (size_t)item->view.width, cut->mirror};
    const float gain = exp2f(cut->stops);
    *out = (struct pbnds_train_item){.loaded = true,
                                     .envmap = item->envmap,
                                     .light_count = item->light_count,
                                     .target = item->target,
                                     .stops = item->stops + cut->stops};
    memcpy(out->lights, item->lights, sizeof out->lights);
    for (int k = 0; k < PBNDS_DATASET_LIGHTS; ++k)
        out->lights[k].power = pbnds_scale(out->lights[k].power, gain);
    if (cut_view(&p, &item->view, &out->view) &&
        cut_colors(&p, item->radiance, gain, &out->radiance) &&
        cut_colors(&p, item->direct, gain, &out->direct) &&
        cut_colors(&p, item->specular, gain, &out->specular) &&
        cut_words(&p, item->visibility, &out->visibility) &&
        cut_words(&p, item->march.thin, &out->march.thin) &&
        cut_words(&p, item->march.thick, &out->march.thick)) {
        return PBNDS_OK;
    }
    pbnds_train_cut_free(out);
    return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                      "no memory for a window of %d x %d of a sample",
                      cut->window.width, cut->window.height);
}

void pbnds_train_cut_free(struct pbnds_train_item *item)
{
    item->envmap = NULL; /* borrowed */
    pbnds_train_item_free(item);
}
