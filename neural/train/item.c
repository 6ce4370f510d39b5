#include "neural/train/item.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "neural/transport.h"

/* The network never sees what a surface emits; the shading pass adds it exactly. */
static float *without_emission(const struct pbnds_image *image,
                               const struct pbnds_gbuffer *gbuffer)
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    float *out = malloc(3 * count * sizeof *out);
    if (!out) return NULL;
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            out[3 * i + c] =
                fmaxf(image->data[3 * i + c] - gbuffer->emission[c][i], 0.0f);
        }
    }
    return out;
}

static void specular_row(void *context, size_t y, int thread)
{
    (void)thread;
    struct pbnds_train_item *item = context;
    const size_t width = (size_t)item->view.width;
    for (size_t x = 0; x < width; ++x) {
        const size_t i = y * width + x;
        const struct pbnds_transport_pixel pixel =
            pbnds_transport_pixel(&item->view, i);
        const struct pbnds_vec3 s =
            pbnds_transport_specular(&pixel, &item->view, item->envmap);
        item->specular[3 * i] = s.x;
        item->specular[3 * i + 1] = s.y;
        item->specular[3 * i + 2] = s.z;
    }
}

static bool precompute_transport(struct pbnds_train_item *item)
{
    const size_t count = (size_t)item->view.width * (size_t)item->view.height;
    item->specular = malloc(3 * count * sizeof *item->specular);
    item->march.thin = malloc(count * sizeof *item->march.thin);
    item->march.thick = malloc(count * sizeof *item->march.thick);
    if (!item->specular || !item->march.thin || !item->march.thick) return false;
    pbnds_parallel_for((size_t)item->view.height, specular_row, item);
    struct pbnds_vec3 wi[PBNDS_DATASET_LIGHTS];
    for (int k = 0; k < PBNDS_DATASET_LIGHTS; ++k)
        wi[k] = item->lights[k].wi;
    pbnds_view_march(&item->view, wi, PBNDS_DATASET_LIGHTS, &item->march);
    return true;
}

/* Light is linear; what a camera made of it is not, and it tells no shadow from a dark
 * surface. */
static enum pbnds_status check_targets(const char *folder,
                                       const struct pbnds_sample *sample,
                                       bool transport, struct pbnds_error *error)
{
    if (!transport || (sample->direct.data && sample->visibility &&
                       sample->target == PBNDS_TARGET_RADIANCE)) {
        return PBNDS_OK;
    }
    return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                      "%s: is a photograph, without the direct light, visibility and "
                      "linear radiance that transport learns from; train pbnds+ on it",
                      folder);
}

enum pbnds_status pbnds_train_item_load(const char *folder, bool transport,
                                        struct pbnds_train_item *item,
                                        struct pbnds_error *error)
{
    *item = (struct pbnds_train_item){0};
    struct pbnds_sample sample;
    PBNDS_TRY(pbnds_sample_load(folder, 0, &sample, error));
    enum pbnds_status status = check_targets(folder, &sample, transport, error);
    if (status == PBNDS_OK)
        status = pbnds_view_create(&sample.gbuffer, &item->view, error);
    if (status == PBNDS_OK) {
        item->target = sample.target;
        item->envmap = sample.envmap;
        sample.envmap = NULL;
        item->visibility = sample.visibility;
        sample.visibility = NULL;
        item->radiance = without_emission(&sample.radiance, &sample.gbuffer);
        if (sample.direct.data)
            item->direct = without_emission(&sample.direct, &sample.gbuffer);
        for (int k = 0; k < PBNDS_DATASET_LIGHTS; ++k) {
            item->lights[k].wi = pbnds_vec3_make(0.0f, 1.0f, 0.0f);
        }
        item->light_count =
            pbnds_envmap_cluster(item->envmap, PBNDS_DATASET_LIGHTS, item->lights);
        if (!item->radiance || (sample.direct.data && !item->direct) ||
            (transport && !precompute_transport(item))) {
            status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", folder);
        }
    }
    pbnds_sample_free(&sample);
    if (status == PBNDS_OK) {
        item->loaded = true;
    } else {
        pbnds_train_item_free(item);
    }
    return status;
}

void pbnds_train_item_free(struct pbnds_train_item *item)
{
    pbnds_view_free(&item->view);
    pbnds_envmap_free(item->envmap);
    free(item->radiance);
    free(item->direct);
    free(item->specular);
    free(item->visibility);
    free(item->march.thin);
    free(item->march.thick);
    *item = (struct pbnds_train_item){0};
}

size_t pbnds_train_item_bytes(const struct pbnds_train_item *item)
{
    const size_t pixels = (size_t)item->view.width * (size_t)item->view.height;
    const size_t floats = PBNDS_PLANE_COUNT + 1 + 3 + (item->direct ? 3u : 0u) +
                          (item->specular ? 3u : 0u);
    const size_t words = (item->visibility ? 1u : 0u) + (item->march.thin ? 2u : 0u);
    /* the light map with its chain of smaller ones and its sampling tables */
    const size_t texels = PBNDS_DATASET_LIGHT_WIDTH * PBNDS_DATASET_LIGHT_WIDTH / 2;
    return pixels * 4 * (floats + words) + texels * 4 * 6;
}
