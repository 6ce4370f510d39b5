/* Writes what safetensors.c reads. */
#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "neural/model/safetensors_internal.h"

static bool tensor_is_sound(const struct pbnds_safetensor *t)
{
    uint64_t count = 1;
    if (!memchr(t->name, 0, sizeof t->name) || !t->name[0]) return false;
    if (strcmp(t->name, PBNDS_SAFETENSORS_METADATA) == 0 || t->rank < 0 || t->rank > 4)
        return false;
    for (int i = 0; i < t->rank; ++i) {
        if (t->shape[i] < 0) return false;
        if (t->shape[i] > 0 &&
            count > PBNDS_SAFETENSORS_MAX_FILE / (uint64_t)t->shape[i])
            return false;
        count *= (uint64_t)t->shape[i];
    }
    return count == t->count && (count == 0 || t->data);
}

static enum pbnds_status check_writable(const char *path,
                                        const struct pbnds_safetensors *file,
                                        struct pbnds_error *error)
{
    const size_t nt = (size_t)file->tensor_count, nm = (size_t)file->metadata_count;
    const char **names = malloc((nt + nm + 1) * sizeof *names);
    enum pbnds_status status = PBNDS_OK;
    uint64_t total = PBNDS_SAFETENSORS_MAX_HEADER;
    if (!names) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    for (size_t i = 0; i < nt && status == PBNDS_OK; ++i) {
        names[i] = file->tensors[i].name;
        total += 4 * (uint64_t)file->tensors[i].count;
        if (!tensor_is_sound(&file->tensors[i]) || total > PBNDS_SAFETENSORS_MAX_FILE) {
            status =
                pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                           "%s: tensor %zu has a bad name, shape or size", path, i);
        }
    }
    const char *twice =
        status == PBNDS_OK ? pbnds_safetensors_duplicate(names, nt) : NULL;
    for (size_t i = 0; i < nm; ++i)
        names[i] = file->metadata[i].key;
    if (status == PBNDS_OK && !twice) twice = pbnds_safetensors_duplicate(names, nm);
    if (twice) {
        status = pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: '%s' is given twice",
                            path, twice);
    }
    free(names);
    return status;
}

static cJSON *tensor_entry(const struct pbnds_safetensor *t, uint64_t begin)
{
    const double offsets[2] = {(double)begin, (double)(begin + 4 * (uint64_t)t->count)};
    cJSON *entry = cJSON_CreateObject();
    cJSON *shape = cJSON_CreateIntArray(t->shape, t->rank);
    cJSON *span = cJSON_CreateDoubleArray(offsets, 2);
    if (entry && shape && span && cJSON_AddStringToObject(entry, "dtype", "F32")) {
        (void)cJSON_AddItemToObject(entry, "shape", shape);
        (void)cJSON_AddItemToObject(entry, "data_offsets", span);
        return entry;
    }
    cJSON_Delete(entry);
    cJSON_Delete(shape);
    cJSON_Delete(span);
    return NULL;
}

/* The JSON text, without padding; NULL without memory. Freed with cJSON_free(). */
static char *header_text(const struct pbnds_safetensors *file)
{
    cJSON *root = cJSON_CreateObject();
    char *text = NULL;
    uint64_t begin = 0;
    if (!root) return NULL;
    if (file->metadata_count > 0) {
        cJSON *map = cJSON_AddObjectToObject(root, PBNDS_SAFETENSORS_METADATA);
        if (!map) goto done;
        for (int i = 0; i < file->metadata_count; ++i) {
            const struct pbnds_metadata *m = &file->metadata[i];
            if (!cJSON_AddStringToObject(map, m->key, m->value)) goto done;
        }
    }
    for (int i = 0; i < file->tensor_count; ++i) {
        const struct pbnds_safetensor *t = &file->tensors[i];
        cJSON *entry = tensor_entry(t, begin);
        if (!entry) goto done;
        if (!cJSON_AddItemToObject(root, t->name, entry)) {
            cJSON_Delete(entry);
            goto done;
        }
        begin += 4 * (uint64_t)t->count;
    }
    text = cJSON_PrintUnformatted(root);
done:
    cJSON_Delete(root);
    return text;
}

static bool write_all(FILE *out, const struct pbnds_safetensors *file, const char *text)
{
    const size_t length = strlen(text), padded = (length + 7) & ~(size_t)7;
    uint8_t prefix[8];
    for (size_t i = 0; i < 8; ++i)
        prefix[i] = (uint8_t)((uint64_t)padded >> (8 * i));
    bool ok = fwrite(prefix, 1, 8, out) == 8 && fwrite(text, 1, length, out) == length;
    for (size_t i = length; i < padded; ++i)
        ok = ok && fputc(' ', out) == ' ';
    for (int i = 0; i < file->tensor_count && ok; ++i) {
        const struct pbnds_safetensor *t = &file->tensors[i];
        ok = t->count == 0 || fwrite(t->data, sizeof(float), t->count, out) == t->count;
    }
    return ok;
}

enum pbnds_status pbnds_safetensors_write(const char *path,
                                          const struct pbnds_safetensors *file,
                                          struct pbnds_error *error)
{
    struct pbnds_file_writer w;
    PBNDS_TRY(check_writable(path, file, error));
    char *text = header_text(file);
    if (!text) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its header",
                          path);
    }
    const char *fault =
        strlen(text) > PBNDS_SAFETENSORS_MAX_HEADER - 8
            ? "is too long"
            : pbnds_safetensors_scan((const uint8_t *)text, strlen(text));
    if (fault) {
        cJSON_free(text);
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: header %s", path, fault);
    }
    enum pbnds_status status = pbnds_file_begin(&w, path, error);
    if (status == PBNDS_OK) {
        FILE *out = fopen(w.temp, "wb");
        const bool written = out && write_all(out, file, text);
        const bool closed = out && fclose(out) == 0;
        if (written && closed) {
            status = pbnds_file_commit(&w, error);
        } else {
            pbnds_file_abort(&w);
            status = pbnds_fail(error, PBNDS_ERROR_IO,
                                "%s: cannot be written; is the disk full?", path);
        }
    }
    cJSON_free(text);
    return status;
}
