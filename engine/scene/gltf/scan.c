#include "engine/scene/gltf/source.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* tinygltf recurses without a bound into `extras`, truncates indices to 32 bits,
 * ignores negative offsets, and insists on reading buffers and images itself. This pass
 * over the text closes these doors before it sees the file. It is lax about JSON
 * otherwise: the real parser comes after. The text is edited in place, never grown. */

enum { MAX_DEPTH = 96 };

/** Where in the document a value stands. */
enum place {
    PLACE_ANY,
    PLACE_FREE, /* inside extras or extensions: nothing is checked */
    PLACE_ROOT,
    PLACE_BUFFERS,
    PLACE_BUFFER,
    PLACE_IMAGES,
    PLACE_IMAGE,
    PLACE_INDEX, /* an integer in [0, 2^31), or an array of them */
    PLACE_ATTRIBUTES,
};

struct scanner {
    struct pbnds_gltf_source *source;
    char *text;
    size_t at, size;
    const char *fault; /* NULL: none yet */
    bool no_memory, saw_buffers, saw_images;
};

struct token {
    size_t start, end; /* of a string: without its quotes */
};

static bool refuse(struct scanner *s, const char *fault)
{
    if (!s->fault) s->fault = fault;
    return false;
}

static void skip_space(struct scanner *s)
{
    while (s->at < s->size && strchr(" \t\r\n", s->text[s->at]) && s->text[s->at])
        ++s->at;
}

/** The next character that is not a space, 0 at the end. */
static char peek(struct scanner *s)
{
    skip_space(s);
    return s->at < s->size ? s->text[s->at] : (char)0;
}

static bool take(struct scanner *s, char c)
{
    if (peek(s) != c) return refuse(s, "it is not valid JSON");
    ++s->at;
    return true;
}

static bool take_string(struct scanner *s, struct token *t)
{
    if (!take(s, '"')) return false;
    t->start = s->at;
    for (; s->at < s->size; ++s->at) {
        if (s->text[s->at] == '\\') {
            ++s->at;
        } else if (s->text[s->at] == '"') {
            t->end = s->at++;
            return true;
        }
    }
    return refuse(s, "its JSON ends inside a string");
}

static bool same(const struct scanner *s, struct token t, const char *word)
{
    const size_t length = strlen(word);
    return t.end - t.start == length && memcmp(s->text + t.start, word, length) == 0;
}

static bool is_index_key(const struct scanner *s, struct token key)
{
    static const char *const keys[] = {
        "buffer",        "bufferView",
        "byteOffset",    "byteLength",
        "byteStride",    "count",
        "mesh",          "skin",
        "componentType", "indices",
        "material",      "mode",
        "camera",        "inverseBindMatrices",
        "skeleton",      "source",
        "sampler",       "index",
        "texCoord",      "scene",
        "children",      "nodes",
        "joints",        "node",
        "input",         "output",
    };
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i) {
        if (same(s, key, keys[i])) return true;
    }
    return false;
}

static void take_number(struct scanner *s, struct token *t)
{
    t->start = s->at;
    while (s->at < s->size && s->text[s->at] &&
           strchr("+-.eE0123456789", s->text[s->at])) {
        ++s->at;
    }
    t->end = s->at;
}

/** An unsigned integer below 2^31, the largest that any size or index here may be. */
static bool to_index(struct scanner *s, struct token t, uint64_t *value)
{
    *value = 0;
    for (size_t i = t.start; i < t.end; ++i) {
        const char c = s->text[i];
        if (c < '0' || c > '9') {
            return refuse(s, "an index or size is not an unsigned integer");
        }
        *value = *value * 10 + (uint64_t)(c - '0');
        if (*value > INT32_MAX) return refuse(s, "an index or size is out of range");
    }
    return true;
}

static unsigned hex4(const char *p)
{
    unsigned x = 0;
    for (int i = 0; i < 4; ++i) {
        const char c = p[i];
        x <<= 4;
        if (c >= '0' && c <= '9') x |= (unsigned)(c - '0');
        if (c >= 'a' && c <= 'f') x |= (unsigned)(c - 'a' + 10);
        if (c >= 'A' && c <= 'F') x |= (unsigned)(c - 'A' + 10);
    }
    return x;
}

static size_t put_utf8(char *out, unsigned code)
{
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    if (code < 0x800) {
        out[0] = (char)(0xc0 | code >> 6);
        out[1] = (char)(0x80 | (code & 0x3f));
        return 2;
    }
    out[0] = (char)(0xe0 | code >> 12);
    out[1] = (char)(0x80 | (code >> 6 & 0x3f));
    out[2] = (char)(0x80 | (code & 0x3f));
    return 3;
}

/** A JSON string without its escapes, malloc'd: never longer than its source. Surrogate
 *  pairs stay two code units: such a name is not found, which is all that happens. */
static char *unescape(const char *text, size_t size)
{
    char *out = malloc(size + 1);
    size_t n = 0;
    for (size_t i = 0; out && i < size; ++i) {
        char c = text[i];
        if (c == '\\' && i + 1 < size) {
            c = text[++i];
            if (c == 'u' && i + 4 < size) {
                n += put_utf8(out + n, hex4(text + i + 1));
                i += 4;
                continue;
            }
            static const char from[] = "bfnrt", to[] = "\b\f\n\r\t";
            const char *found = strchr(from, c);
            if (found && c) c = to[found - from];
        }
        out[n++] = c;
    }
    if (out) out[n] = 0;
    return out;
}

static bool add_payload(struct scanner *s, struct pbnds_gltf_payload **list,
                        size_t *count)
{
    /* Doubling: full when the count is a power of two. */
    if ((*count & (*count - 1)) == 0) {
        const size_t capacity = *count ? *count * 2 : 1;
        struct pbnds_gltf_payload *grown = realloc(*list, capacity * sizeof **list);
        if (!grown) {
            s->no_memory = true;
            return refuse(s, "no memory");
        }
        *list = grown;
    }
    (*list)[(*count)++] = (struct pbnds_gltf_payload){0};
    return true;
}

static bool take_uri(struct scanner *s, struct pbnds_gltf_payload *payload)
{
    struct token t;
    if (peek(s) != '"') return refuse(s, "a uri is not a string");
    if (!take_string(s, &t)) return false;
    free(payload->uri);
    payload->uri = unescape(s->text + t.start, t.end - t.start);
    if (!payload->uri) {
        s->no_memory = true;
        return refuse(s, "no memory");
    }
    if (t.end > t.start) {
        /* `"uri": "..."` becomes `"uri": "x"` and spaces. */
        memset(s->text + t.start, ' ', t.end - t.start + 1);
        s->text[t.start] = 'x';
        s->text[t.start + 1] = '"';
    }
    return true;
}

/** A member of a buffer. True with *taken set when it was one of ours. */
static bool take_buffer_member(struct scanner *s, struct token key, bool *taken)
{
    struct pbnds_gltf_payload *buffer =
        &s->source->buffers[s->source->buffer_count - 1];
    *taken = true;
    if (same(s, key, "uri")) {
        s->text[key.start] = '_'; /* tinygltf then takes it from the BIN chunk */
        return take_uri(s, buffer);
    }
    if (same(s, key, "byteLength")) {
        struct token t;
        (void)peek(s);
        take_number(s, &t);
        if (t.start == t.end) return refuse(s, "a byteLength is not a number");
        if (!to_index(s, t, &buffer->byte_length)) return false;
        memset(s->text + t.start, ' ', t.end - t.start);
        s->text[t.start] = '1';
        return true;
    }
    *taken = false;
    return true;
}

static enum place place_of_member(const struct scanner *s, enum place place,
                                  struct token key)
{
    if (place == PLACE_FREE || same(s, key, "extras") || same(s, key, "extensions")) {
        return PLACE_FREE;
    }
    if (place == PLACE_ROOT && same(s, key, "buffers")) return PLACE_BUFFERS;
    if (place == PLACE_ROOT && same(s, key, "images")) return PLACE_IMAGES;
    if (place == PLACE_ATTRIBUTES) return PLACE_INDEX;
    if (same(s, key, "attributes")) return PLACE_ATTRIBUTES;
    return is_index_key(s, key) ? PLACE_INDEX : PLACE_ANY;
}

static bool take_value(struct scanner *s, enum place place, int depth);

static bool take_member(struct scanner *s, enum place place, int depth)
{
    struct token key;
    if (!take_string(s, &key) || !take(s, ':')) return false;
    bool taken = false;
    if (place == PLACE_BUFFER && !take_buffer_member(s, key, &taken)) return false;
    if (place == PLACE_IMAGE && same(s, key, "uri")) {
        taken = true;
        if (!take_uri(s, &s->source->images[s->source->image_count - 1])) return false;
    }
    if (taken) return true;
    const enum place inner = place_of_member(s, place, key);
    /* A second list would be counted from the end of the first. */
    bool *saw = inner == PLACE_BUFFERS
                    ? &s->saw_buffers
                    : (inner == PLACE_IMAGES ? &s->saw_images : NULL);
    if (saw && *saw) return refuse(s, "buffers or images are listed twice");
    if (saw) *saw = true;
    return take_value(s, inner, depth + 1);
}

static bool take_object(struct scanner *s, enum place place, int depth)
{
    if (place == PLACE_INDEX)
        place = PLACE_ANY; /* e.g. the sparse accessor's "indices" */
    if (!take(s, '{')) return false;
    if (peek(s) == '}') {
        ++s->at;
        return true;
    }
    for (;;) {
        if (!take_member(s, place, depth)) return false;
        if (peek(s) == '}') {
            ++s->at;
            return true;
        }
        if (!take(s, ',')) return false;
    }
}

static bool take_element(struct scanner *s, enum place place, int depth)
{
    struct pbnds_gltf_source *src = s->source;
    if (place == PLACE_BUFFERS) {
        if (!add_payload(s, &src->buffers, &src->buffer_count)) return false;
        return take_value(s, PLACE_BUFFER, depth + 1);
    }
    if (place == PLACE_IMAGES) {
        if (!add_payload(s, &src->images, &src->image_count)) return false;
        return take_value(s, PLACE_IMAGE, depth + 1);
    }
    return take_value(
        s, place == PLACE_FREE || place == PLACE_INDEX ? place : PLACE_ANY, depth + 1);
}

static bool take_array(struct scanner *s, enum place place, int depth)
{
    if (!take(s, '[')) return false;
    if (peek(s) == ']') {
        ++s->at;
        return true;
    }
    for (;;) {
        if (!take_element(s, place, depth)) return false;
        if (peek(s) == ']') {
            ++s->at;
            return true;
        }
        if (!take(s, ',')) return false;
    }
}

static bool take_value(struct scanner *s, enum place place, int depth)
{
    if (depth > MAX_DEPTH) return refuse(s, "its JSON is nested too deeply");
    struct token t;
    const char c = peek(s);
    if (c == '{') return take_object(s, place, depth);
    if (c == '[') return take_array(s, place, depth);
    if (c == '"') return take_string(s, &t);
    if (c == '-' || (c >= '0' && c <= '9')) {
        uint64_t unused;
        take_number(s, &t);
        return place != PLACE_INDEX || to_index(s, t, &unused);
    }
    const size_t start = s->at;
    while (s->at < s->size && s->text[s->at] >= 'a' && s->text[s->at] <= 'z')
        ++s->at;
    return s->at > start || refuse(s, "it is not valid JSON");
}

enum pbnds_status pbnds_gltf_scan(struct pbnds_gltf_source *source,
                                  struct pbnds_error *error)
{
    struct scanner s = {
        .source = source, .text = source->json, .size = source->json_size};
    if (s.size >= 3 && memcmp(s.text, "\xef\xbb\xbf", 3) == 0) s.at = 3;
    bool fine = peek(&s) == '{' && take_value(&s, PLACE_ROOT, 0);
    if (!fine) (void)refuse(&s, "it is neither a GLB nor a JSON object");
    if (fine && peek(&s)) fine = refuse(&s, "something follows its JSON");
    if (fine) return PBNDS_OK;
    return pbnds_fail(error, s.no_memory ? PBNDS_ERROR_MEMORY : PBNDS_ERROR_FORMAT,
                      "%s: is not valid glTF: %s (byte %zu of the JSON)", source->name,
                      s.fault, s.at);
}
