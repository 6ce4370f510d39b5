/* Reads https://huggingface.co/docs/safetensors: length, JSON header, one gapless block
 * of data. */
#include "neural/model/safetensors.h"

#include <cjson/cJSON.h>
#include <limits.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "neural/model/safetensors_internal.h"

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "safetensors data are little-endian; this reader uses them in place"
#endif

struct reader {
    const char *name; /* of the file, for messages */
    struct pbnds_error *error;
    uint64_t data_size;
};

#define BAD(r, format, ...)                                                            \
    pbnds_fail((r)->error, PBNDS_ERROR_FORMAT,                                         \
               "%s: " format "; get the weights file again", (r)->name, __VA_ARGS__)

/* A JSON number as an exact non-negative integer of at most 2^53. */
static bool whole_number(const cJSON *item, uint64_t *value)
{
    if (!cJSON_IsNumber(item)) return false;
    const double x = item->valuedouble;
    if (!(x >= 0.0 && x <= 9007199254740992.0)) return false;
    *value = (uint64_t)x;
    return (double)*value == x;
}

static enum pbnds_status read_shape(const struct reader *r, const cJSON *shape,
                                    struct pbnds_safetensor *tensor)
{
    uint64_t count = 1;
    const cJSON *item;
    if (!cJSON_IsArray(shape)) return BAD(r, "tensor '%s' has no shape", tensor->name);
    tensor->rank = 0;
    cJSON_ArrayForEach(item, shape)
    {
        uint64_t extent;
        if (!whole_number(item, &extent)) {
            return BAD(r, "tensor '%s' has a damaged shape", tensor->name);
        }
        if (tensor->rank == 4 || extent > INT_MAX) {
            return pbnds_fail(
                r->error, PBNDS_ERROR_UNSUPPORTED,
                "%s: tensor '%s' has more than 4 dimensions or a huge one; "
                "this program reads its own weights only",
                r->name, tensor->name);
        }
        if (extent != 0 && count > PBNDS_SAFETENSORS_MAX_FILE / extent) {
            return BAD(r, "tensor '%s' is larger than any file", tensor->name);
        }
        count *= extent;
        tensor->shape[tensor->rank++] = (int)extent;
    }
    tensor->count = (size_t)count;
    return PBNDS_OK;
}

static enum pbnds_status read_dtype(const struct reader *r, const cJSON *dtype,
                                    const char *tensor)
{
    if (!cJSON_IsString(dtype)) return BAD(r, "tensor '%s' has no dtype", tensor);
    if (strcmp(dtype->valuestring, "F32") == 0) return PBNDS_OK;
    return pbnds_fail(r->error, PBNDS_ERROR_UNSUPPORTED,
                      "%s: tensor '%s' has dtype %.16s; convert the file to F32",
                      r->name, tensor, dtype->valuestring);
}

/* Begin and end in the data block must span exactly the shape. */
static enum pbnds_status read_offsets(const struct reader *r, const cJSON *offsets,
                                      const struct pbnds_safetensor *tensor,
                                      uint64_t *begin)
{
    uint64_t end;
    if (!cJSON_IsArray(offsets) || cJSON_GetArraySize(offsets) != 2 ||
        !whole_number(offsets->child, begin) ||
        !whole_number(offsets->child->next, &end)) {
        return BAD(r, "tensor '%s' has damaged data_offsets", tensor->name);
    }
    if (*begin > end || end > r->data_size) {
        return BAD(r, "tensor '%s' lies outside of the file, which may be cut short",
                   tensor->name);
    }
    if (end - *begin != 4 * (uint64_t)tensor->count) {
        return BAD(r, "tensor '%s' has a shape and a size that differ", tensor->name);
    }
    return PBNDS_OK;
}

static enum pbnds_status read_tensor(const struct reader *r, const cJSON *entry,
                                     struct pbnds_safetensor *tensor, uint64_t *begin)
{
    const cJSON *fields[3] = {NULL, NULL, NULL}, *item;
    static const char *const names[3] = {"dtype", "shape", "data_offsets"};
    const size_t length = strlen(entry->string);
    if (length == 0 || length >= sizeof tensor->name) {
        return pbnds_fail(
            r->error, PBNDS_ERROR_UNSUPPORTED,
            "%s: tensor name '%.40s...' is empty or longer than %zu bytes; "
            "this program reads its own weights only",
            r->name, entry->string, sizeof tensor->name - 1);
    }
    memcpy(tensor->name, entry->string, length + 1);
    if (!cJSON_IsObject(entry))
        return BAD(r, "tensor '%s' is not described", tensor->name);
    cJSON_ArrayForEach(item, entry)
    {
        int k = 0;
        while (k < 3 && strcmp(item->string, names[k]) != 0)
            ++k;
        if (k == 3 || fields[k]) {
            return BAD(r, "tensor '%s' has an unknown or double field '%.40s'",
                       tensor->name, item->string);
        }
        fields[k] = item;
    }
    PBNDS_TRY(read_dtype(r, fields[0], tensor->name));
    PBNDS_TRY(read_shape(r, fields[1], tensor));
    return read_offsets(r, fields[2], tensor, begin);
}

static char *copy_string(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy) memcpy(copy, text, size);
    return copy;
}

static enum pbnds_status read_metadata(const struct reader *r, const cJSON *map,
                                       struct pbnds_safetensors *file)
{
    if (!cJSON_IsObject(map))
        return BAD(r, "%s is not a map", PBNDS_SAFETENSORS_METADATA);
    const size_t count = (size_t)cJSON_GetArraySize(map);
    file->metadata = calloc(count + 1, sizeof *file->metadata);
    const char **names = malloc((count + 1) * sizeof *names);
    enum pbnds_status status = PBNDS_OK;
    const cJSON *item;
    if (!file->metadata || !names) goto memory;
    cJSON_ArrayForEach(item, map)
    {
        if (!cJSON_IsString(item)) {
            status = BAD(r, "metadata '%.80s' is not a string", item->string);
            goto done;
        }
        struct pbnds_metadata *m = &file->metadata[file->metadata_count++];
        m->key = copy_string(item->string);
        m->value = copy_string(item->valuestring);
        if (!m->key || !m->value) goto memory;
        names[file->metadata_count - 1] = m->key;
    }
    const char *twice = pbnds_safetensors_duplicate(names, count);
    if (twice) status = BAD(r, "metadata '%.80s' is there twice", twice);
    goto done;
memory:
    status = pbnds_fail(r->error, PBNDS_ERROR_MEMORY, "%s: no memory for its metadata",
                        r->name);
done:
    free(names);
    return status;
}

struct span {
    uint64_t begin, end;
};

static int compare_spans(const void *a, const void *b)
{
    const struct span *p = a, *q = b;
    if (p->begin != q->begin) return p->begin < q->begin ? -1 : 1;
    return p->end < q->end ? -1 : p->end > q->end;
}

/* The tensors must tile the data: no overlap, no gap, nothing behind. */
static enum pbnds_status check_tiling(const struct reader *r, struct span *spans,
                                      size_t count)
{
    uint64_t reached = 0;
    if (count > 1) qsort(spans, count, sizeof *spans, compare_spans);
    for (size_t i = 0; i < count; ++i) {
        if (spans[i].begin != reached) {
            return BAD(r, "tensors overlap or leave a gap at byte %llu of the data",
                       (unsigned long long)reached);
        }
        reached = spans[i].end;
    }
    if (reached != r->data_size) {
        return BAD(r, "%llu bytes of data belong to no tensor",
                   (unsigned long long)(r->data_size - reached));
    }
    return PBNDS_OK;
}

static enum pbnds_status read_entries(const struct reader *r, const cJSON *root,
                                      const float *data, struct pbnds_safetensors *file)
{
    const size_t count = (size_t)cJSON_GetArraySize(root);
    const char **names = malloc((count + 1) * sizeof *names);
    struct span *spans = malloc((count + 1) * sizeof *spans);
    file->tensors = calloc(count + 1, sizeof *file->tensors);
    enum pbnds_status status = PBNDS_OK;
    size_t n = 0, seen = 0;
    const cJSON *item;
    if (!names || !spans || !file->tensors) {
        status = pbnds_fail(r->error, PBNDS_ERROR_MEMORY,
                            "%s: no memory for %zu tensors", r->name, count);
        goto done;
    }
    cJSON_ArrayForEach(item, root) names[seen++] = item->string;
    const char *twice = pbnds_safetensors_duplicate(names, count);
    if (twice) {
        status = BAD(r, "'%.95s' is there twice", twice);
        goto done;
    }
    cJSON_ArrayForEach(item, root)
    {
        if (strcmp(item->string, PBNDS_SAFETENSORS_METADATA) == 0) {
            status = read_metadata(r, item, file);
            if (status != PBNDS_OK) goto done;
            continue;
        }
        struct pbnds_safetensor *tensor = &file->tensors[n];
        uint64_t begin = 0;
        status = read_tensor(r, item, tensor, &begin);
        if (status != PBNDS_OK) goto done;
        spans[n].begin = begin;
        spans[n].end = begin + 4 * (uint64_t)tensor->count;
        /* A gapless tiling of floats starts each at a multiple of 4 (checked below). */
        tensor->data = data + begin / 4;
        file->tensor_count = (int)++n;
    }
    status = check_tiling(r, spans, n);
done:
    free(names);
    free(spans);
    return status;
}

/* Takes `bytes` (malloc'd) over, on failure too. */
static enum pbnds_status parse_owned(uint8_t *bytes, size_t size, const char *name,
                                     struct pbnds_safetensors *file,
                                     struct pbnds_error *error)
{
    struct reader r = {name, error, 0};
    enum pbnds_status status;
    cJSON *root = NULL;
    uint64_t length = 0;
    *file = (struct pbnds_safetensors){.storage = bytes};
    for (size_t i = 0; i < 8 && size >= 8; ++i)
        length |= (uint64_t)bytes[i] << (8 * i);
    if (size < 10 || length < 2 || bytes[8] != '{') {
        status = BAD(&r, "is %s", "not a safetensors file");
        goto done;
    }
    if (length > PBNDS_SAFETENSORS_MAX_HEADER || length > size - 8) {
        status =
            BAD(&r, "has a header of %llu bytes, more than the file holds or allows",
                (unsigned long long)length);
        goto done;
    }
    const size_t start = 8 + (size_t)length;
    const char *fault = pbnds_safetensors_scan(bytes + 8, (size_t)length);
    if (fault) {
        status = BAD(&r, "header %s", fault);
        goto done;
    }
    const char *end = NULL, *text = (const char *)bytes + 8;
    root = cJSON_ParseWithLengthOpts(text, (size_t)length, &end, 0);
    while (root && end < text + length && *end == ' ')
        ++end;
    if (!cJSON_IsObject(root) || end != text + length) {
        status = BAD(&r, "header is %s", "not valid JSON");
        goto done;
    }
    r.data_size = size - start;
    if (start % sizeof(float) != 0) { /* over the header: root holds copies */
        memmove(bytes, bytes + start, size - start);
    }
    const void *data = start % sizeof(float) != 0 ? bytes : bytes + start;
    status = read_entries(&r, root, data, file);
done:
    cJSON_Delete(root);
    if (status != PBNDS_OK) pbnds_safetensors_free(file);
    return status;
}

enum pbnds_status pbnds_safetensors_parse(const void *bytes, size_t size,
                                          const char *name,
                                          struct pbnds_safetensors *file,
                                          struct pbnds_error *error)
{
    *file = (struct pbnds_safetensors){.storage = NULL};
    uint8_t *copy = size <= PBNDS_SAFETENSORS_MAX_FILE ? malloc(size + 1) : NULL;
    if (!copy) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for %zu bytes",
                          name, size);
    }
    if (size > 0) memcpy(copy, bytes, size);
    return parse_owned(copy, size, name, file, error);
}

enum pbnds_status pbnds_safetensors_read(const char *path,
                                         struct pbnds_safetensors *file,
                                         struct pbnds_error *error)
{
    uint8_t *bytes;
    size_t size;
    *file = (struct pbnds_safetensors){.storage = NULL};
    PBNDS_TRY(pbnds_file_read(path, (size_t)PBNDS_SAFETENSORS_MAX_FILE, &bytes, &size,
                              error));
    return parse_owned(bytes, size, path, file, error);
}

void pbnds_safetensors_free(struct pbnds_safetensors *file)
{
    for (int i = 0; i < file->metadata_count; ++i) {
        free(file->metadata[i].key);
        free(file->metadata[i].value);
    }
    free(file->metadata);
    free(file->tensors);
    free(file->storage);
    *file = (struct pbnds_safetensors){.storage = NULL};
}

const struct pbnds_safetensor *
pbnds_safetensors_find(const struct pbnds_safetensors *file, const char *name)
{
    for (int i = 0; i < file->tensor_count; ++i) {
        if (strcmp(file->tensors[i].name, name) == 0) return &file->tensors[i];
    }
    return NULL;
}

const char *pbnds_safetensors_metadata(const struct pbnds_safetensors *file,
                                       const char *key)
{
    for (int i = 0; i < file->metadata_count; ++i) {
        if (strcmp(file->metadata[i].key, key) == 0) return file->metadata[i].value;
    }
    return NULL;
}
