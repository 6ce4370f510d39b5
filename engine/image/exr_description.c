#include "engine/image/exr_description.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

int pbnds_exr_channel_index(const struct pbnds_exr *exr, const char *name)
{
    for (int i = 0; i < exr->channel_count; ++i) {
        if (strcmp(exr->channels[i].name, name) == 0) return i;
    }
    return -1;
}

size_t pbnds_exr_plane_bytes(const struct pbnds_exr *exr)
{
    return (size_t)exr->width * (size_t)exr->height * sizeof(float);
}

enum pbnds_status pbnds_exr_fail_memory(const char *path, struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its channels",
                      path);
}

void pbnds_exr_free(struct pbnds_exr *exr)
{
    for (int i = 0; i < exr->channel_count; ++i)
        free(exr->channels[i].data);
    for (int i = 0; i < exr->attribute_count; ++i) {
        if (exr->attributes[i].type == PBNDS_EXR_ATTRIBUTE_TEXT)
            free(exr->attributes[i].value.text);
    }
    free(exr->channels);
    free(exr->attributes);
    *exr = (struct pbnds_exr){0};
}

const struct pbnds_exr_channel *pbnds_exr_find(const struct pbnds_exr *exr,
                                               const char *name)
{
    const int i = pbnds_exr_channel_index(exr, name);
    return i < 0 ? NULL : &exr->channels[i];
}

const struct pbnds_exr_attribute *pbnds_exr_find_attribute(const struct pbnds_exr *exr,
                                                           const char *name)
{
    for (int i = 0; i < exr->attribute_count; ++i) {
        if (strcmp(exr->attributes[i].name, name) == 0) return &exr->attributes[i];
    }
    return NULL;
}

static bool terminated(const char *text, size_t size)
{
    return memchr(text, 0, size) != NULL;
}

static enum pbnds_status check_channels(const char *path, const struct pbnds_exr *exr,
                                        struct pbnds_error *error)
{
    for (int i = 0; i < exr->channel_count; ++i) {
        const struct pbnds_exr_channel *c = &exr->channels[i];
        if (!terminated(c->name, sizeof c->name) || !c->name[0] || !c->data ||
            (c->type != PBNDS_EXR_UINT && c->type != PBNDS_EXR_HALF &&
             c->type != PBNDS_EXR_FLOAT)) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "%s: channel %d lacks a name, a type or data", path, i);
        }
        if (pbnds_exr_channel_index(exr, c->name) != i) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "%s: two channels are called %s", path, c->name);
        }
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_exr_check(const char *path, const struct pbnds_exr *exr,
                                  struct pbnds_error *error)
{
    if (exr->width < 1 || exr->width > PBNDS_EXR_SIDE_MAX || exr->height < 1 ||
        exr->height > PBNDS_EXR_SIDE_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: %d x %d pixels, sides must lie in [1, %d]", path,
                          exr->width, exr->height, (int)PBNDS_EXR_SIDE_MAX);
    }
    if (exr->channel_count < 1 || exr->channel_count > PBNDS_EXR_CHANNELS_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: %d channels, there must be 1 to %d", path,
                          exr->channel_count, (int)PBNDS_EXR_CHANNELS_MAX);
    }
    if (exr->compression != PBNDS_EXR_NONE && exr->compression != PBNDS_EXR_ZIPS &&
        exr->compression != PBNDS_EXR_ZIP && exr->compression != PBNDS_EXR_PIZ) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: compression %d is not written", path,
                          (int)exr->compression);
    }
    return check_channels(path, exr, error);
}

/* Names of 32 characters and more need a flag that old readers do not know. */
bool pbnds_exr_has_long_names(const struct pbnds_exr *exr)
{
    for (int i = 0; i < exr->channel_count; ++i) {
        if (strlen(exr->channels[i].name) > 31) return true;
    }
    for (int i = 0; i < exr->attribute_count; ++i) {
        if (strlen(exr->attributes[i].name) > 31) return true;
    }
    return false;
}

static bool one_of(const char *name, const char *const *list)
{
    for (; *list; ++list) {
        if (strcmp(name, *list) == 0) return true;
    }
    return false;
}

enum pbnds_exr_attribute_fate
pbnds_exr_attribute_fate(const struct pbnds_exr_attribute *a)
{
    /* These follow from the planes: dropped, so that what was read can be written. */
    static const char *const implied[] = {"type", "name", "chunkCount", "version",
                                          NULL};
    static const char *const reserved[] = {
        "channels",  "compression",        "dataWindow", "displayWindow",
        "lineOrder", "screenWindowCenter", "tiles",      NULL};
    const bool text = a->type == PBNDS_EXR_ATTRIBUTE_STRING;
    if (!terminated(a->name, sizeof a->name) || !a->name[0] ||
        (text && !terminated(a->value.string, sizeof a->value.string)) ||
        (a->type == PBNDS_EXR_ATTRIBUTE_TEXT && !a->value.text) ||
        one_of(a->name, reserved)) {
        return PBNDS_EXR_ATTRIBUTE_REFUSED;
    }
    return one_of(a->name, implied) ? PBNDS_EXR_ATTRIBUTE_IMPLIED
                                    : PBNDS_EXR_ATTRIBUTE_WRITTEN;
}
