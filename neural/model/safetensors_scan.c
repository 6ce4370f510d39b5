/* What cJSON does not refuse by itself. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "neural/model/safetensors_internal.h"

#define MAX_DEPTH  4         /* {"tensor": {"shape": [..]}} is 3 */
#define MAX_VALUES (1 << 20) /* cJSON takes 64 bytes for each: bounds its memory */

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

/* Looks only at what JSON nests and at what would end a C string early; the grammar is
 * cJSON's business. */
const char *pbnds_safetensors_scan(const uint8_t *text, size_t size)
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

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

const char *pbnds_safetensors_duplicate(const char **names, size_t count)
{
    if (count > 1) qsort(names, count, sizeof *names, compare_names);
    for (size_t i = 1; i < count; ++i) {
        if (strcmp(names[i - 1], names[i]) == 0) return names[i];
    }
    return NULL;
}
