/* https://huggingface.co/docs/safetensors: length, JSON header, one gapless block of
 * data. */
#include "neural/model/safetensors.h"

#include <cjson/cJSON.h>
#include <limits.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "safetensors data are little-endian; this reader uses them in place"
#endif

#define MAX_FILE   ((uint64_t)1 << 32) /* 4 GiB */
#define MAX_HEADER ((uint64_t)16 << 20)
#define MAX_DEPTH  4         /* {"tensor": {"shape": [..]}} is 3 */
#define MAX_VALUES (1 << 20) /* cJSON takes 64 bytes for each: bounds its memory */

static const char METADATA[] = "__metadata__";

static const char *find_duplicate(const char **names, size_t count);

/* ---- scan: what cJSON does not refuse by itself ---- */

/* Length of the UTF-8 sequence at p (RFC 3629), 0 when it is not one. */
static size_t utf8_length(const uint8_t *p, size_t left)
{
    const uint8_t c = p[0];
    if (c < 0x80) return 1;
    const size_t n = c >= 0xf0 ? 4 : c >= 0xe0 ? 3 : 2;
    if (c < 0xc2 || c > 0xf4 || n > left) return 0;
    for (size_t i = 1; i < n; ++i) {
        if ((p[i] & 0xc0) != 0x80) return 0;
    }
    if (c == 0xe0 && p[1] < 0xa0) return 0; /* overlong  */
    if (c == 0xed && p[1] > 0x9f) return 0; /* surrogate */
    if (c == 0xf0 && p[1] < 0x90) return 0; /* overlong  */
    if (c == 0xf4 && p[1] > 0x8f) return 0; /* > U+10FFFF */
    return n;
}

/* Why the bytes cannot be a header, or NULL. Looks only at what JSON nests and at what
 * would end a C string early; the grammar is cJSON's business. */
static const char *scan_header(const uint8_t *text, size_t size)
{
    int depth = 0, values = 0;
    bool in_string = false;
    for (size_t i = 0; i < size;) {
        const uint8_t c = text[i];
        const size_t n = utf8_length(text + i, size - i);
        if (n == 0) return "is not UTF-8";
        if (c == 0 || (in_string && c < 0x20)) return "holds control characters";
        if (in_string && c == '\\') {
            if (size - i >= 6 && memcmp(text + i, "\\u0000", 6) == 0) {
                return "holds a zero character in a string";
            }
            i += 2;
            continue;
        }
        if (c == '"') in_string = !in_string;
        if (!in_string) {
            if ((c == '{' || c == '[') && ++depth > MAX_DEPTH)
                return "is nested too deep";
            if (c == '}' || c == ']') --depth;
            if (c == ',' && ++values > MAX_VALUES) return "holds too many values";
        }
        i += n;
    }
    return NULL;
}

/* ---- read ---- */

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
        if (extent != 0 && count > MAX_FILE / extent) {
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
    if (!cJSON_IsObject(map)) return BAD(r, "%s is not a map", METADATA);
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
    const char *twice = find_duplicate(names, count);
    if (twice) status = BAD(r, "metadata '%.80s' is there twice", twice);
    goto done;
memory:
    status = pbnds_fail(r->error, PBNDS_ERROR_MEMORY, "%s: no memory for its metadata",
                        r->name);
done:
    free(names);
    return status;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Sorts names; one that is there twice, or NULL. */
static const char *find_duplicate(const char **names, size_t count)
{
    if (count > 1) qsort(names, count, sizeof *names, compare_names);
    for (size_t i = 1; i < count; ++i) {
        if (strcmp(names[i - 1], names[i]) == 0) return names[i];
    }
    return NULL;
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
    const char *twice = find_duplicate(names, count);
    if (twice) {
        status = BAD(r, "'%.95s' is there twice", twice);
        goto done;
    }
    cJSON_ArrayForEach(item, root)
    {
        if (strcmp(item->string, METADATA) == 0) {
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
    if (length > MAX_HEADER || length > size - 8) {
        status =
            BAD(&r, "has a header of %llu bytes, more than the file holds or allows",
                (unsigned long long)length);
        goto done;
    }
    const size_t start = 8 + (size_t)length;
    const char *fault = scan_header(bytes + 8, (size_t)length);
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
    uint8_t *copy = size <= MAX_FILE ? malloc(size + 1) : NULL;
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
    PBNDS_TRY(pbnds_file_read(path, (size_t)MAX_FILE, &bytes, &size, error));
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

/* ---- write ---- */

static bool tensor_is_sound(const struct pbnds_safetensor *t)
{
    uint64_t count = 1;
    if (!memchr(t->name, 0, sizeof t->name) || !t->name[0]) return false;
    if (strcmp(t->name, METADATA) == 0 || t->rank < 0 || t->rank > 4) return false;
    for (int i = 0; i < t->rank; ++i) {
        if (t->shape[i] < 0) return false;
        if (t->shape[i] > 0 && count > MAX_FILE / (uint64_t)t->shape[i]) return false;
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
    uint64_t total = MAX_HEADER;
    if (!names) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    for (size_t i = 0; i < nt && status == PBNDS_OK; ++i) {
        names[i] = file->tensors[i].name;
        total += 4 * (uint64_t)file->tensors[i].count;
        if (!tensor_is_sound(&file->tensors[i]) || total > MAX_FILE) {
            status =
                pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                           "%s: tensor %zu has a bad name, shape or size", path, i);
        }
    }
    const char *twice = status == PBNDS_OK ? find_duplicate(names, nt) : NULL;
    for (size_t i = 0; i < nm; ++i)
        names[i] = file->metadata[i].key;
    if (status == PBNDS_OK && !twice) twice = find_duplicate(names, nm);
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
        cJSON *map = cJSON_AddObjectToObject(root, METADATA);
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
    const char *fault = strlen(text) > MAX_HEADER - 8
                            ? "is too long"
                            : scan_header((const uint8_t *)text, strlen(text));
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
