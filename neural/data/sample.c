/* Reading a data set: its list of samples and each one of them. */
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <xxhash.h>

#include "engine/core/file.h"
#include "neural/data/dataset.h"

static int is_sample(const struct dirent *entry)
{
    return entry->d_name[0] >= '0' && entry->d_name[0] <= '9';
}

enum pbnds_status pbnds_dataset_list(const char *dir, enum pbnds_split split,
                                     struct pbnds_sample_list *list,
                                     struct pbnds_error *error)
{
    *list = (struct pbnds_sample_list){0};
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    struct stat info;
    if (stat(path, &info) != 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO,
                          "%s: is not a data set (no dataset.json in it)", dir);
    }
    (void)snprintf(path, sizeof path, "%s/%s", dir, pbnds_split_name(split));
    if (stat(path, &info) != 0) return PBNDS_OK; /* no such split: an empty list */
    struct dirent **entries;
    const int n = scandir(path, &entries, is_sample, alphasort);
    if (n < 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be listed: %s", path,
                          strerror(errno));
    }
    list->folders = calloc((size_t)n + 1, sizeof *list->folders);
    bool ok = list->folders != NULL;
    for (int i = 0; i < n; ++i) {
        const size_t size = strlen(path) + strlen(entries[i]->d_name) + 2;
        char *folder = ok ? malloc(size) : NULL;
        if (folder) {
            (void)snprintf(folder, size, "%s/%s", path, entries[i]->d_name);
            list->folders[list->count++] = folder;
        } else {
            ok = false;
        }
        free(entries[i]);
    }
    free(entries);
    if (!ok) {
        pbnds_sample_list_free(list);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list",
                          path);
    }
    return PBNDS_OK;
}

void pbnds_sample_list_free(struct pbnds_sample_list *list)
{
    for (int i = 0; i < list->count; ++i)
        free(list->folders[i]);
    free(list->folders);
    *list = (struct pbnds_sample_list){0};
}

enum pbnds_status pbnds_dataset_hash(const char *dir, char hash[17],
                                     struct pbnds_error *error)
{
    char path[4096];
    (void)snprintf(path, sizeof path, "%s/dataset.json", dir);
    uint8_t *manifest;
    size_t size;
    PBNDS_TRY(pbnds_file_read(path, (size_t)1 << 26, &manifest, &size, error));
    uint64_t h = XXH64(manifest, size, 0);
    free(manifest);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        struct pbnds_sample_list list;
        PBNDS_TRY(pbnds_dataset_list(dir, (enum pbnds_split)s, &list, error));
        for (int i = 0; i < list.count; ++i) {
            const char *name = list.folders[i] + strlen(dir);
            h = XXH64(name, strlen(name), h);
        }
        pbnds_sample_list_free(&list);
    }
    (void)snprintf(hash, 17, "%016" PRIx64, h);
    return PBNDS_OK;
}

/* Interleaves direct.R, .G, .B and copies the visibility words. */
static enum pbnds_status read_targets(const char *path, const struct pbnds_exr *exr,
                                      struct pbnds_sample *sample,
                                      struct pbnds_error *error)
{
    static const char *const NAMES[3] = {"direct.R", "direct.G", "direct.B"};
    const size_t count = (size_t)exr->width * (size_t)exr->height;
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
    enum pbnds_status status = pbnds_gbuffer_read(path, &sample->gbuffer, NULL,
                                                  &sample->radiance, &exr, error);
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
