#include "neural/data/picture_list.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 9 };

static int index_of(const char *name, size_t length)
{
    size_t begin = 0, end = length;
    for (size_t i = 0; i < length; ++i) {
        if (name[i] == '/') begin = i + 1;
    }
    for (size_t i = length; i > begin; --i) {
        if (name[i - 1] == '.') end = i - 1;
    }
    if (end == begin || end - begin > DIGITS) return -1;
    int index = 0;
    for (size_t i = begin; i < end; ++i) {
        if (name[i] < '0' || name[i] > '9') return -1;
        index = 10 * index + (name[i] - '0');
    }
    return index;
}

int pbnds_picture_index(const char *name)
{
    return index_of(name, strlen(name));
}

static enum pbnds_status add(struct pbnds_picture_list *list, int index, double value,
                             const char *name, struct pbnds_error *error)
{
    const unsigned count = (unsigned)list->count;
    if ((count & (count - 1u)) == 0) { /* zero or a power of two: grow */
        struct pbnds_picture_value *grown =
            realloc(list->items, 2u * (size_t)(count + 1u) * sizeof *grown);
        if (!grown)
            return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for it", name);
        list->items = grown;
    }
    list->items[list->count++] = (struct pbnds_picture_value){index, value};
    return PBNDS_OK;
}

enum pbnds_status pbnds_picture_list_json(struct pbnds_picture_list *list,
                                          const void *bytes, size_t size,
                                          const char *name, struct pbnds_error *error)
{
    cJSON *json = cJSON_ParseWithLength(bytes, size);
    enum pbnds_status status = PBNDS_OK;
    if (!cJSON_IsObject(json)) {
        status =
            pbnds_fail(error, PBNDS_ERROR_FORMAT,
                       "%s: is no JSON object; write {\"05030\": degrees, ...}", name);
    }
    for (const cJSON *at = status == PBNDS_OK ? json->child : NULL;
         at && status == PBNDS_OK; at = at->next) {
        const int index = pbnds_picture_index(at->string);
        if (index < 0) continue;
        status = add(list, index, cJSON_IsNumber(at) ? at->valuedouble : (double)NAN,
                     name, error);
    }
    cJSON_Delete(json);
    return status;
}

static int is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

enum pbnds_status pbnds_picture_list_lines(struct pbnds_picture_list *list,
                                           const void *bytes, size_t size, double value,
                                           const char *name, struct pbnds_error *error)
{
    const char *text = bytes;
    size_t line = 0;
    for (size_t at = 0; at < size;) {
        size_t begin = at, end = at;
        while (end < size && text[end] != '\n')
            ++end;
        at = end + 1;
        ++line;
        while (begin < end && is_blank(text[begin]))
            ++begin;
        while (end > begin && is_blank(text[end - 1]))
            --end;
        if (begin == end || text[begin] == '#') continue;
        const int index = index_of(text + begin, end - begin);
        if (index < 0) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                              "%s: line %zu names no picture; write one number a line",
                              name, line);
        }
        PBNDS_TRY(add(list, index, value, name, error));
    }
    return PBNDS_OK;
}

static int by_index(const void *a, const void *b)
{
    const struct pbnds_picture_value *x = a, *y = b;
    return (x->index > y->index) - (x->index < y->index);
}

enum pbnds_status pbnds_picture_list_sort(struct pbnds_picture_list *list,
                                          const char *name, struct pbnds_error *error)
{
    if (list->count == 0) return PBNDS_OK;
    qsort(list->items, (size_t)list->count, sizeof *list->items, by_index);
    for (int i = 1; i < list->count; ++i) {
        const struct pbnds_picture_value *a = &list->items[i - 1], *b = &list->items[i];
        if (a->index == b->index && !(a->value == b->value)) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                              "%s: says two things of picture %d; keep one", name,
                              a->index);
        }
    }
    return PBNDS_OK;
}

double pbnds_picture_list_find(const struct pbnds_picture_list *list, int index)
{
    const struct pbnds_picture_value key = {index, 0.0}, *found = NULL;
    if (list->count > 0) {
        found = bsearch(&key, list->items, (size_t)list->count, sizeof key, by_index);
    }
    return found ? found->value : (double)NAN;
}

void pbnds_picture_list_free(struct pbnds_picture_list *list)
{
    free(list->items);
    *list = (struct pbnds_picture_list){NULL, 0};
}
