/* A sample's files: writing them, and reading them back. */
#include "neural/data/sample.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"

static enum pbnds_status write_light(const char *folder,
                                     const struct pbnds_image *light,
                                     struct pbnds_error *error)
{
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/light.exr", folder);
    const size_t count = (size_t)light->width * (size_t)light->height;
    float *planes = malloc(3 * count * sizeof *planes);
    if (!planes) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c)
            planes[c * count + i] = light->data[3 * i + c];
    }
    struct pbnds_exr_channel channels[3] = {{"B", PBNDS_EXR_FLOAT, planes + 2 * count},
                                            {"G", PBNDS_EXR_FLOAT, planes + count},
                                            {"R", PBNDS_EXR_FLOAT, planes}};
    const struct pbnds_exr exr = {.width = light->width,
                                  .height = light->height,
                                  .compression = PBNDS_EXR_ZIP,
                                  .channels = channels,
                                  .channel_count = 3};
    const enum pbnds_status status = pbnds_exr_write(path, &exr, error);
    free(planes);
    return status;
}

static enum pbnds_status write_json(const char *folder, const cJSON *json,
                                    struct pbnds_error *error)
{
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/sample.json", folder);
    char *text = cJSON_Print(json);
    if (!text) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    const enum pbnds_status status = pbnds_file_write(path, text, strlen(text), error);
    free(text);
    return status;
}

enum pbnds_status pbnds_sample_write_parts(const char *folder,
                                           const struct pbnds_sample_parts *parts,
                                           struct pbnds_error *error)
{
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/sample.exr", folder);
    PBNDS_TRY(pbnds_gbuffer_write(path, parts->gbuffer, parts->origin, parts->radiance,
                                  parts->extra, parts->extra_count, PBNDS_EXR_PIZ,
                                  error));
    PBNDS_TRY(write_light(folder, parts->light, error));
    return write_json(folder, parts->json, error);
}

static struct pbnds_exr_channel *target_channels(const struct pbnds_image *direct,
                                                 const uint32_t *visibility,
                                                 float **planes)
{
    const size_t count = (size_t)direct->width * (size_t)direct->height;
    static const char *const NAMES[3] = {"direct.R", "direct.G", "direct.B"};
    struct pbnds_exr_channel *channels = calloc(4, sizeof *channels);
    *planes = malloc(3 * count * sizeof **planes);
    if (!channels || !*planes) {
        free(channels);
        free(*planes);
        *planes = NULL;
        return NULL;
    }
    for (size_t c = 0; c < 3; ++c) {
        (void)snprintf(channels[c].name, sizeof channels[c].name, "%s", NAMES[c]);
        channels[c].type = PBNDS_EXR_FLOAT;
        channels[c].data = *planes + c * count;
        for (size_t i = 0; i < count; ++i) {
            (*planes)[c * count + i] = direct->data[3 * i + c];
        }
    }
    (void)snprintf(channels[3].name, sizeof channels[3].name, "visibility");
    channels[3].type = PBNDS_EXR_UINT;
    channels[3].data = (void *)(uintptr_t)visibility;
    return channels;
}

enum pbnds_status pbnds_sample_write(const char *folder,
                                     const struct pbnds_dataset_recipe *recipe,
                                     const struct pbnds_draw *draw,
                                     const struct pbnds_targets *targets,
                                     struct pbnds_error *error)
{
    float *planes = NULL;
    struct pbnds_exr_channel *extra =
        target_channels(&targets->direct, targets->visibility, &planes);
    if (!extra) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", folder);
    struct pbnds_gbuffer_origin origin = {.env_yaw_deg = draw->yaw_deg,
                                          .env_strength = draw->strength,
                                          .seed = recipe->seed};
    (void)snprintf(origin.env, sizeof origin.env, "%s", draw->env->stem);
    (void)snprintf(origin.env_convention, sizeof origin.env_convention, "gltf");
    (void)snprintf(origin.arguments, sizeof origin.arguments,
                   "dataset, %s sample %d of %s", pbnds_split_name(draw->split),
                   draw->index, draw->asset->stem);
    cJSON *json = cJSON_Duplicate(draw->notes, true);
    cJSON_AddNumberToObject(json, "spp", recipe->spp);
    cJSON_AddNumberToObject(json, "seed", (double)recipe->seed);
    const struct pbnds_sample_parts parts = {.gbuffer = &targets->gbuffer,
                                             .origin = &origin,
                                             .radiance = &targets->radiance,
                                             .extra = extra,
                                             .extra_count = 4,
                                             .light = &draw->light,
                                             .json = json};
    const enum pbnds_status status = pbnds_sample_write_parts(folder, &parts, error);
    cJSON_Delete(json);
    free(extra);
    free(planes);
    return status;
}

/* Interleaves direct.R, .G, .B and copies the visibility words. */
static enum pbnds_status read_targets(const char *path, const struct pbnds_exr *exr,
                                      struct pbnds_sample *sample,
                                      struct pbnds_error *error)
{
    static const char *const NAMES[3] = {"direct.R", "direct.G", "direct.B"};
    const size_t count = (size_t)exr->width * (size_t)exr->height;
    /* Nobody knows these of a photograph. */
    if (sample->target == PBNDS_TARGET_DISPLAY && !pbnds_exr_find(exr, NAMES[0]) &&
        !pbnds_exr_find(exr, "visibility")) {
        return PBNDS_OK;
    }
    PBNDS_TRY(pbnds_image_init(&sample->direct, exr->width, exr->height, 3, error));
    for (size_t c = 0; c < 3; ++c) {
        const struct pbnds_exr_channel *channel = pbnds_exr_find(exr, NAMES[c]);
        if (!channel || channel->type == PBNDS_EXR_UINT) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: has no channel %s", path,
                              NAMES[c]);
        }
        const float *plane = channel->data;
        for (size_t i = 0; i < count; ++i) {
            if (!isfinite(plane[i])) {
                return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                                  "%s: %s is not finite at pixel %zu", path, NAMES[c],
                                  i);
            }
            sample->direct.data[3 * i + c] = plane[i];
        }
    }
    const struct pbnds_exr_channel *visibility = pbnds_exr_find(exr, "visibility");
    sample->visibility = malloc(count * sizeof *sample->visibility);
    if (!sample->visibility) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    }
    if (!visibility || visibility->type != PBNDS_EXR_UINT) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: has no uint channel visibility", path);
    }
    memcpy(sample->visibility, visibility->data, count * sizeof *sample->visibility);
    return PBNDS_OK;
}

enum pbnds_status pbnds_sample_load(const char *folder, struct pbnds_sample *sample,
                                    struct pbnds_error *error)
{
    *sample = (struct pbnds_sample){0};
    (void)snprintf(sample->path, sizeof sample->path, "%s", folder);
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/sample.exr", folder);
    struct pbnds_exr exr = {0};
    struct pbnds_gbuffer_origin origin;
    enum pbnds_status status = pbnds_gbuffer_read(path, &sample->gbuffer, &origin,
                                                  &sample->radiance, &exr, error);
    if (status == PBNDS_OK) sample->target = origin.target;
    if (status == PBNDS_OK && !sample->radiance.data) {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT,
                            "%s: has no reference radiance (R, G, B)", path);
    }
    if (status == PBNDS_OK) status = read_targets(path, &exr, sample, error);
    pbnds_exr_free(&exr);
    if (status == PBNDS_OK) {
        (void)snprintf(path, sizeof path, "%s/light.exr", folder);
        status =
            pbnds_envmap_load(path, PBNDS_ENV_GLTF, 0.0f, 1.0f, &sample->envmap, error);
    }
    if (status != PBNDS_OK) pbnds_sample_free(sample);
    return status;
}

void pbnds_sample_free(struct pbnds_sample *sample)
{
    pbnds_gbuffer_free(&sample->gbuffer);
    pbnds_image_free(&sample->radiance);
    pbnds_image_free(&sample->direct);
    free(sample->visibility);
    pbnds_envmap_free(sample->envmap);
    *sample = (struct pbnds_sample){0};
}
