/* A sample's files: writing them, and reading them back. */
#include "neural/data/sample.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "neural/data/pack.h"
#include "neural/data/store_read.h"

enum { PATH_SIZE = 4200 };

const char *pbnds_sample_file(int i)
{
    static const char *const FILES[] = {"sample.exr", "light.exr", "sample.json",
                                        "olat.exr"};
    return i >= 0 && i < (int)(sizeof FILES / sizeof *FILES) ? FILES[i] : NULL;
}

/* Channels of a file to be, with the planes that are made for them. */

struct sheet {
    size_t pixels;
    struct pbnds_exr_channel *channels;
    int count;
    float *planes; /* the rest of what sheet_open() took; owned by `block` */
    float *block;
};

static bool sheet_open(struct sheet *sheet, size_t pixels, int channels, int planes)
{
    *sheet = (struct sheet){.pixels = pixels};
    sheet->channels = calloc((size_t)channels, sizeof *sheet->channels);
    sheet->block = malloc((size_t)planes * pixels * sizeof *sheet->block);
    sheet->planes = sheet->block;
    return sheet->channels && sheet->block;
}

static void sheet_close(struct sheet *sheet)
{
    free(sheet->channels);
    free(sheet->block);
}

static void add_channel(struct sheet *sheet, const char *prefix, const char *name,
                        enum pbnds_exr_type type, const void *data)
{
    struct pbnds_exr_channel *c = &sheet->channels[sheet->count++];
    (void)snprintf(c->name, sizeof c->name, "%s%s", prefix, name);
    c->type = type;
    c->data = (void *)(uintptr_t)data; /* is only read */
}

/* The next three planes as prefix + R, G, B. */
static void add_planes(struct sheet *sheet, const char *prefix,
                       enum pbnds_exr_type type)
{
    static const char *const NAMES[3] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c, sheet->planes += sheet->pixels)
        add_channel(sheet, prefix, NAMES[c], type, sheet->planes);
}

static enum pbnds_exr_type type_of(const float *values, size_t count)
{
    return pbnds_pack_fits_half(values, count) ? PBNDS_EXR_HALF : PBNDS_EXR_FLOAT;
}

static void split(const struct pbnds_image *image, size_t pixels, float *planes)
{
    for (size_t i = 0; i < pixels; ++i) {
        for (size_t c = 0; c < 3; ++c)
            planes[c * pixels + i] = image->data[3 * i + c];
    }
}

static void add_light(struct sheet *sheet, const char *prefix,
                      const struct pbnds_image *image)
{
    split(image, sheet->pixels, sheet->planes);
    add_planes(sheet, prefix, type_of(sheet->planes, 3 * sheet->pixels));
}

/* What is left of `all` without `part`; their sums round differently, so not below 0. */
static void add_rest(struct sheet *sheet, const char *prefix,
                     const struct pbnds_image *all, const struct pbnds_image *part)
{
    for (size_t i = 0; i < sheet->pixels; ++i) {
        for (size_t c = 0; c < 3; ++c)
            sheet->planes[c * sheet->pixels + i] =
                fmaxf(all->data[3 * i + c] - part->data[3 * i + c], 0.0f);
    }
    add_planes(sheet, prefix, type_of(sheet->planes, 3 * sheet->pixels));
}

static void add_variance(struct sheet *sheet, const struct pbnds_image *variance)
{
    split(variance, sheet->pixels, sheet->planes);
    pbnds_pack_round_short(sheet->planes, 3 * sheet->pixels);
    add_planes(sheet, "variance.", PBNDS_EXR_FLOAT);
}

/* Writing. */

/* A target that is not finite would spoil a training for ever. */
static enum pbnds_status check_finite(const char *path,
                                      const struct pbnds_exr_channel *channels,
                                      int count, int width, int height,
                                      struct pbnds_error *error)
{
    const size_t pixels = (size_t)width * (size_t)height;
    for (int c = 0; c < count; ++c) {
        const float *plane = channels[c].data;
        if (channels[c].type == PBNDS_EXR_UINT) continue;
        for (size_t i = 0; i < pixels; ++i) {
            if (isfinite(plane[i])) continue;
            return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                              "%s: %s is not finite at pixel (%d, %d)", path,
                              channels[c].name, (int)(i % (size_t)width),
                              (int)(i / (size_t)width));
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status write_sheet(const char *folder, const char *name,
                                     const struct sheet *sheet, int width, int height,
                                     struct pbnds_error *error)
{
    char path[PATH_SIZE];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    const struct pbnds_exr exr = {.width = width,
                                  .height = height,
                                  .compression = PBNDS_EXR_PIZ,
                                  .channels = sheet->channels,
                                  .channel_count = sheet->count};
    PBNDS_TRY(check_finite(name, sheet->channels, sheet->count, width, height, error));
    return pbnds_exr_write(path, &exr, error);
}

static enum pbnds_status write_light(const char *folder,
                                     const struct pbnds_image *light,
                                     struct pbnds_error *error)
{
    struct sheet sheet;
    enum pbnds_status status = PBNDS_OK;
    if (sheet_open(&sheet, (size_t)light->width * (size_t)light->height, 3, 3)) {
        add_light(&sheet, "", light);
        status = write_sheet(folder, "light.exr", &sheet, light->width, light->height,
                             error);
    } else {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", folder);
    }
    sheet_close(&sheet);
    return status;
}

static enum pbnds_status write_olat(const char *folder, const struct pbnds_olat *olat,
                                    struct pbnds_error *error)
{
    const int width = olat->images->width, height = olat->images->height;
    struct sheet sheet;
    enum pbnds_status status = PBNDS_OK;
    if (sheet_open(&sheet, (size_t)width * (size_t)height, 3 * olat->count + 1,
                   3 * olat->count)) {
        for (int k = 0; k < olat->count; ++k) {
            char prefix[24];
            (void)snprintf(prefix, sizeof prefix, "olat.%02d.", k);
            add_light(&sheet, prefix, &olat->images[k]);
        }
        add_channel(&sheet, "", "olat_visibility", PBNDS_EXR_UINT, olat->visibility);
        status = write_sheet(folder, "olat.exr", &sheet, width, height, error);
    } else {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", folder);
    }
    sheet_close(&sheet);
    return status;
}

static enum pbnds_status write_json(const char *folder, const cJSON *json,
                                    struct pbnds_error *error)
{
    char path[PATH_SIZE];
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
    char path[PATH_SIZE];
    (void)snprintf(path, sizeof path, "%s/sample.exr", folder);
    PBNDS_TRY(check_finite("sample.exr", parts->extra, parts->extra_count,
                           parts->gbuffer->width, parts->gbuffer->height, error));
    PBNDS_TRY(pbnds_gbuffer_write(path, parts->gbuffer, parts->origin, parts->radiance,
                                  parts->extra, parts->extra_count, PBNDS_EXR_PIZ,
                                  error));
    PBNDS_TRY(write_light(folder, parts->light, error));
    if (parts->olat && parts->olat->count > 0)
        PBNDS_TRY(write_olat(folder, parts->olat, error));
    return write_json(folder, parts->json, error);
}

static struct pbnds_gbuffer_origin origin_of(const struct pbnds_dataset_recipe *recipe,
                                             const struct pbnds_draw *draw)
{
    struct pbnds_gbuffer_origin origin = {.env_yaw_deg = draw->yaw_deg,
                                          .env_strength = draw->strength,
                                          .seed = recipe->seed};
    (void)snprintf(origin.env, sizeof origin.env, "%s", draw->env->stem);
    (void)snprintf(origin.env_convention, sizeof origin.env_convention, "gltf");
    (void)snprintf(origin.arguments, sizeof origin.arguments,
                   "dataset, %s sample %d of %s", pbnds_split_name(draw->split),
                   draw->index, draw->asset->stem);
    return origin;
}

/* Directions, as many samples each. */
static void describe_olat(cJSON *json, const struct pbnds_dataset_recipe *recipe,
                          const struct pbnds_olat *olat)
{
    if (olat->count == 0) return;
    cJSON *object = cJSON_AddObjectToObject(json, "olat");
    cJSON_AddNumberToObject(object, "spp",
                            recipe->olat_spp ? recipe->olat_spp : recipe->spp);
    cJSON *list = cJSON_AddArrayToObject(object, "wi");
    for (int k = 0; k < olat->count; ++k) {
        const struct pbnds_vec3 *w = &olat->wi[k];
        cJSON_AddItemToArray(
            list, cJSON_CreateFloatArray((const float[3]){w->x, w->y, w->z}, 3));
    }
}

static cJSON *describe(const struct pbnds_dataset_recipe *recipe,
                       const struct pbnds_draw *draw,
                       const struct pbnds_targets *targets)
{
    cJSON *json = cJSON_Duplicate(draw->notes, true);
    cJSON_AddNumberToObject(json, "spp", recipe->spp);
    cJSON_AddNumberToObject(json, "seed", (double)recipe->seed);
    if (targets->denoised) cJSON_AddTrueToObject(json, "denoised");
    describe_olat(json, recipe, &targets->olat);
    return json;
}

enum pbnds_status pbnds_sample_write(const char *folder,
                                     const struct pbnds_dataset_recipe *recipe,
                                     const struct pbnds_draw *draw,
                                     const struct pbnds_targets *targets,
                                     struct pbnds_error *error)
{
    enum { LAYERS = 4, OTHERS = 2 }; /* light, direct, indirect, variance; A, bits */
    const struct pbnds_gbuffer *g = &targets->gbuffer;
    const size_t pixels = (size_t)g->width * (size_t)g->height;
    struct sheet sheet;
    enum pbnds_status status;
    if (sheet_open(&sheet, pixels, 3 * LAYERS + OTHERS, 3 * LAYERS)) {
        add_light(&sheet, "", &targets->radiance);
        add_light(&sheet, "direct.", &targets->direct);
        add_rest(&sheet, "indirect.", &targets->radiance, &targets->direct);
        if (targets->variance.data) add_variance(&sheet, &targets->variance);
        add_channel(&sheet, "", "A", PBNDS_EXR_HALF, g->coverage);
        add_channel(&sheet, "", "visibility", PBNDS_EXR_UINT, targets->visibility);
        const struct pbnds_gbuffer_origin origin = origin_of(recipe, draw);
        cJSON *json = describe(recipe, draw, targets);
        const struct pbnds_sample_parts parts = {.gbuffer = g,
                                                 .origin = &origin,
                                                 .extra = sheet.channels,
                                                 .extra_count = sheet.count,
                                                 .light = &targets->light,
                                                 .olat = &targets->olat,
                                                 .json = json};
        status = pbnds_sample_write_parts(folder, &parts, error);
        cJSON_Delete(json);
    } else {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", folder);
    }
    sheet_close(&sheet);
    return status;
}

/* Reading. */

static bool has_layer(const struct pbnds_exr *exr, const char *prefix)
{
    char name[64];
    (void)snprintf(name, sizeof name, "%sR", prefix);
    return pbnds_exr_find(exr, name) != NULL;
}

/* Interleaves prefix + R, G, B. */
static enum pbnds_status read_layer(const char *path, const struct pbnds_exr *exr,
                                    const char *prefix, struct pbnds_image *image,
                                    struct pbnds_error *error)
{
    const size_t count = (size_t)exr->width * (size_t)exr->height;
    PBNDS_TRY(pbnds_image_init(image, exr->width, exr->height, 3, error));
    for (size_t c = 0; c < 3; ++c) {
        char name[64];
        (void)snprintf(name, sizeof name, "%s%c", prefix, "RGB"[c]);
        const struct pbnds_exr_channel *channel = pbnds_exr_find(exr, name);
        if (!channel || channel->type == PBNDS_EXR_UINT) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: has no channel %s", path,
                              name);
        }
        const float *plane = channel->data;
        for (size_t i = 0; i < count; ++i) {
            if (!isfinite(plane[i])) {
                return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                                  "%s: %s is not finite at pixel %zu", path, name, i);
            }
            image->data[3 * i + c] = plane[i];
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status read_bits(const char *path, const struct pbnds_exr *exr,
                                   const char *name, uint32_t **bits,
                                   struct pbnds_error *error)
{
    const size_t count = (size_t)exr->width * (size_t)exr->height;
    const struct pbnds_exr_channel *channel = pbnds_exr_find(exr, name);
    if (!channel || channel->type != PBNDS_EXR_UINT) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: has no uint channel %s", path,
                          name);
    }
    *bits = malloc(count * sizeof **bits);
    if (!*bits) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    memcpy(*bits, channel->data, count * sizeof **bits);
    return PBNDS_OK;
}

static enum pbnds_status read_targets(const char *path, const struct pbnds_exr *exr,
                                      unsigned parts, struct pbnds_sample *sample,
                                      struct pbnds_error *error)
{
    if (!sample->radiance.data) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: has no reference radiance (R, G, B)", path);
    }
    /* Nobody knows these of a photograph. */
    if (sample->target == PBNDS_TARGET_DISPLAY && !has_layer(exr, "direct.") &&
        !pbnds_exr_find(exr, "visibility")) {
        return PBNDS_OK;
    }
    PBNDS_TRY(read_layer(path, exr, "direct.", &sample->direct, error));
    if ((parts & PBNDS_SAMPLE_VARIANCE) && has_layer(exr, "variance."))
        PBNDS_TRY(read_layer(path, exr, "variance.", &sample->variance, error));
    return read_bits(path, exr, "visibility", &sample->visibility, error);
}

/* The directions that sample.json lists: their number, or -1 where it is damaged. */
static int list_directions(const cJSON *json, struct pbnds_vec3 *wi)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(
        cJSON_GetObjectItemCaseSensitive(json, "olat"), "wi");
    const cJSON *item;
    int count = 0;
    cJSON_ArrayForEach(item, list)
    {
        if (count == PBNDS_DATASET_OLAT || cJSON_GetArraySize(item) != 3) return -1;
        float w[3];
        for (int c = 0; c < 3; ++c)
            w[c] = (float)cJSON_GetNumberValue(cJSON_GetArrayItem(item, c));
        wi[count] = pbnds_vec3_make(w[0], w[1], w[2]);
        /* written so that NaN fails */
        if (!(fabsf(pbnds_length(wi[count++]) - 1.0f) < 1e-3f)) return -1;
    }
    return count;
}

static enum pbnds_status read_directions(const char *sample, struct pbnds_olat *olat,
                                         struct pbnds_error *error)
{
    struct pbnds_store_bytes bytes;
    PBNDS_TRY(pbnds_store_read(sample, "sample.json", &bytes, error));
    cJSON *json = cJSON_ParseWithLength((const char *)bytes.data, bytes.size);
    free(bytes.data);
    const int count = list_directions(json, olat->wi);
    cJSON_Delete(json);
    if (count < 1) {
        return pbnds_fail(
            error, PBNDS_ERROR_FORMAT,
            "%s: has no list of unit directions olat.wi, as olat.exr needs",
            bytes.name);
    }
    olat->count = count;
    return PBNDS_OK;
}

static enum pbnds_status read_lights(const char *path, const struct pbnds_exr *exr,
                                     const struct pbnds_gbuffer *g,
                                     struct pbnds_olat *olat, struct pbnds_error *error)
{
    if (exr->width != g->width || exr->height != g->height) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is %d x %d, the sample %d x %d", path, exr->width,
                          exr->height, g->width, g->height);
    }
    olat->images = calloc((size_t)olat->count, sizeof *olat->images);
    if (!olat->images)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    for (int k = 0; k < olat->count; ++k) {
        char prefix[24];
        (void)snprintf(prefix, sizeof prefix, "olat.%02d.", k);
        PBNDS_TRY(read_layer(path, exr, prefix, &olat->images[k], error));
    }
    return read_bits(path, exr, "olat_visibility", &olat->visibility, error);
}

static enum pbnds_status load_olat(const char *path, struct pbnds_sample *sample,
                                   struct pbnds_error *error)
{
    if (!pbnds_store_holds(path, "olat.exr")) return PBNDS_OK;
    struct pbnds_store_bytes bytes;
    struct pbnds_exr exr = {0};
    PBNDS_TRY(read_directions(path, &sample->olat, error));
    PBNDS_TRY(pbnds_store_read(path, "olat.exr", &bytes, error));
    enum pbnds_status status =
        pbnds_exr_read_memory(bytes.name, bytes.data, bytes.size, &exr, error);
    free(bytes.data);
    if (status == PBNDS_OK)
        status = read_lights(bytes.name, &exr, &sample->gbuffer, &sample->olat, error);
    pbnds_exr_free(&exr);
    return status;
}

static enum pbnds_status load_views(const char *path, unsigned parts,
                                    struct pbnds_sample *sample,
                                    struct pbnds_error *error)
{
    struct pbnds_store_bytes bytes;
    struct pbnds_exr exr = {0};
    struct pbnds_gbuffer_origin origin;
    PBNDS_TRY(pbnds_store_read(path, "sample.exr", &bytes, error));
    enum pbnds_status status =
        pbnds_gbuffer_read_memory(bytes.name, bytes.data, bytes.size, &sample->gbuffer,
                                  &origin, &sample->radiance, &exr, error);
    free(bytes.data);
    if (status == PBNDS_OK) {
        sample->target = origin.target;
        status = read_targets(bytes.name, &exr, parts, sample, error);
    }
    pbnds_exr_free(&exr);
    return status;
}

static enum pbnds_status load_light(const char *path, struct pbnds_sample *sample,
                                    struct pbnds_error *error)
{
    struct pbnds_store_bytes bytes;
    struct pbnds_exr exr = {0};
    struct pbnds_image light = {0, 0, 0, NULL};
    PBNDS_TRY(pbnds_store_read(path, "light.exr", &bytes, error));
    enum pbnds_status status =
        pbnds_exr_read_memory(bytes.name, bytes.data, bytes.size, &exr, error);
    free(bytes.data);
    if (status == PBNDS_OK) status = read_layer(bytes.name, &exr, "", &light, error);
    if (status == PBNDS_OK) {
        status = pbnds_envmap_create(&light, PBNDS_ENV_GLTF, 0.0f, 1.0f,
                                     &sample->envmap, error);
    }
    pbnds_image_free(&light);
    pbnds_exr_free(&exr);
    return status;
}

enum pbnds_status pbnds_sample_load(const char *path, unsigned parts,
                                    struct pbnds_sample *sample,
                                    struct pbnds_error *error)
{
    *sample = (struct pbnds_sample){0};
    (void)snprintf(sample->path, sizeof sample->path, "%s", path);
    enum pbnds_status status = load_views(path, parts, sample, error);
    if (status == PBNDS_OK) status = load_light(path, sample, error);
    if (status == PBNDS_OK && (parts & PBNDS_SAMPLE_OLAT))
        status = load_olat(path, sample, error);
    if (status != PBNDS_OK) pbnds_sample_free(sample);
    return status;
}

void pbnds_sample_free(struct pbnds_sample *sample)
{
    pbnds_gbuffer_free(&sample->gbuffer);
    pbnds_image_free(&sample->radiance);
    pbnds_image_free(&sample->direct);
    pbnds_image_free(&sample->variance);
    free(sample->visibility);
    pbnds_envmap_free(sample->envmap);
    pbnds_olat_free(&sample->olat);
    *sample = (struct pbnds_sample){0};
}
