#include "engine/scene/gltf/source.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* tinygltf recurses without a bound into `extras`, truncates indices to 32 bits,
 * ignores negative offsets, and insists on reading buffers and images itself. This pass
 * over the text closes these doors before it sees the file. It also makes what is valid
 * readable for it: integers written as 1.0 (JSON does not tell them from 1), and
 * primitives whose index accessor has no bufferView (sparse or compressed ones). It is
 * lax about JSON otherwise: the real parser comes after. The text is edited in place,
 * never grown. */

enum { MAX_DEPTH = 96 };

/** The largest integer that every JSON writer can write. */
static const uint64_t MAX_SIZE = ((uint64_t)1 << 53) - 1;

/* What parsing takes of memory, in bytes: for every value, for one inside an extension
 * (which is kept as a tree), and for the structure that a list of the document is made
 * of. A document of "{},{},{}" is a thousand times larger once it is parsed. */
enum { COST_VALUE = 64, COST_TREE = 320, COST_ITEM = 1024, COST_MATERIAL = 3072 };

/** Where in the document a value stands. */
enum place {
    PLACE_ANY,
    PLACE_FREE, /* inside extras: nothing is checked */
    PLACE_TREE, /* inside extensions: neither        */
    PLACE_ROOT,
    PLACE_BUFFERS,
    PLACE_BUFFER,
    PLACE_IMAGES,
    PLACE_IMAGE,
    PLACE_LIST, /* any other list of the document */
    PLACE_MATERIALS,
    PLACE_MESHES,
    PLACE_MESH,
    PLACE_PRIMITIVES,
    PLACE_PRIMITIVE,
    PLACE_ANIMATIONS,
    PLACE_ANIMATION,
    PLACE_SPARSE,
    PLACE_INDEX, /* an integer in [0, 2^31), or an array of them */
    PLACE_SIZE,  /* an integer in [0, 2^53)                      */
    PLACE_ATTRIBUTES,
};

struct scanner {
    struct pbnds_gltf_source *source;
    char *text;
    size_t at, size;
    const char *fault; /* NULL: none yet */
    uint64_t cost;
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

/** Does an object come after the colon? */
static bool peek_object(const struct scanner *s)
{
    size_t at = s->at;
    while (at < s->size && s->text[at] && strchr(" \t\r\n", s->text[at]))
        ++at;
    return at < s->size && s->text[at] == '{';
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

static bool is_one_of(const struct scanner *s, struct token key,
                      const char *const *keys, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (same(s, key, keys[i])) return true;
    }
    return false;
}

static bool is_size_key(const struct scanner *s, struct token key)
{
    static const char *const keys[] = {"byteOffset", "byteLength", "count"};
    return is_one_of(s, key, keys, sizeof keys / sizeof keys[0]);
}

static bool is_index_key(const struct scanner *s, struct token key)
{
    static const char *const keys[] = {
        "buffer",   "bufferView", "byteStride", "componentType",
        "mesh",     "skin",       "camera",     "indices",
        "material", "mode",       "index",      "inverseBindMatrices",
        "skeleton", "source",     "sampler",    "texCoord",
        "scene",    "children",   "nodes",      "joints",
        "node",     "input",      "output",
    };
    return is_one_of(s, key, keys, sizeof keys / sizeof keys[0]);
}

/** Lists that tinygltf takes for absent where they are something else. */
static bool is_list_key(const struct scanner *s, enum place place, struct token key)
{
    static const char *const keys[] = {
        "accessors", "animations", "bufferViews", "buffers", "cameras",
        "images",    "materials",  "meshes",      "nodes",   "samplers",
        "scenes",    "skins",      "textures",
    };
    if (place == PLACE_MESH) return same(s, key, "primitives");
    return place == PLACE_ROOT && is_one_of(s, key, keys, sizeof keys / sizeof keys[0]);
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/** The value of "12.0", "1.5e3", ...: false where it is no integer below 2^31, or has a
 * sign. */
static bool whole_value(const char *p, size_t size, uint64_t *value)
{
    uint64_t m = 0;
    int scale = 0, exponent = 0;
    size_t i = 0;
    bool fraction = false, negative = false;
    /* What is no JSON stays as it is, for the parser to refuse. */
    if (size < 2 || !is_digit(p[size - 1]) || (p[0] == '0' && is_digit(p[1]))) {
        return false;
    }
    for (; i < size && (is_digit(p[i]) || (p[i] == '.' && !fraction)); ++i) {
        if (p[i] == '.') {
            fraction = true;
            if (!is_digit(p[i + 1])) return false;
            continue;
        }
        if (m > UINT64_MAX / 100) return false;
        m = m * 10 + (uint64_t)(p[i] - '0');
        scale -= fraction;
    }
    if (i < size && (p[i] == 'e' || p[i] == 'E')) {
        ++i;
        negative = i < size && p[i] == '-';
        if (i < size && (p[i] == '-' || p[i] == '+')) ++i;
        for (; i < size && is_digit(p[i]) && exponent < 100; ++i)
            exponent = exponent * 10 + (p[i] - '0');
    }
    if (i < size) return false;
    scale += negative ? -exponent : exponent;
    for (; scale < 0 && m % 10 == 0 && m; ++scale)
        m /= 10;
    for (; scale > 0 && m && m <= INT32_MAX; --scale)
        m *= 10;
    *value = m;
    return (scale == 0 || m == 0) && m <= INT32_MAX;
}

/** Writes `value` over a token that has room for it. */
static void put_number(struct scanner *s, struct token t, uint64_t value)
{
    char digits[24];
    size_t n = 0;
    do {
        digits[n++] = (char)('0' + value % 10);
        value /= 10;
    } while (value);
    if (n > t.end - t.start) return;
    memset(s->text + t.start, ' ', t.end - t.start);
    for (size_t i = 0; i < n; ++i)
        s->text[t.start + i] = digits[n - 1 - i];
}

/** Takes a number; one that is whole loses its fraction or exponent. */
static void take_number(struct scanner *s, struct token *t)
{
    bool plain = true;
    t->start = s->at;
    for (; s->at < s->size; ++s->at) {
        const char c = s->text[s->at];
        if (c == '.' || c == 'e' || c == 'E') plain = false;
        if (!is_digit(c) && c != '.' && c != 'e' && c != 'E' && c != '+' && c != '-')
            break;
    }
    t->end = s->at;
    uint64_t value = 0;
    if (!plain && whole_value(s->text + t->start, t->end - t->start, &value)) {
        put_number(s, *t, value);
    }
}

/** In an extension an integer beyond 2^31 would be truncated: it becomes the nearest
 * real number that has room, 12345678901 -> 1.234567e10. */
static void keep_large(struct scanner *s, struct token t)
{
    char *p = s->text + t.start;
    size_t size = t.end - t.start;
    if (size && *p == '-') {
        ++p;
        --size;
    }
    if (size < 10 || size > 300) return;
    for (size_t i = 0; i < size; ++i) {
        if (!is_digit(p[i])) return;
    }
    if (size == 10 && memcmp(p, "2147483647", 10) <= 0) return;
    const size_t exponent = size - 1;
    const size_t width = exponent < 10 ? 1 : (exponent < 100 ? 2 : 3);
    char *end = p + size - width;
    memmove(p + 2, p + 1, (size_t)(end - 1 - (p + 2)));
    p[1] = '.';
    end[-1] = 'e';
    for (size_t k = width, x = exponent; k-- > 0; x /= 10)
        end[k] = (char)('0' + x % 10);
}

/** An unsigned integer up to `most`. */
static bool to_integer(struct scanner *s, struct token t, uint64_t most,
                       uint64_t *value)
{
    *value = 0;
    for (size_t i = t.start; i < t.end && s->text[i] != ' '; ++i) {
        const char c = s->text[i];
        if (!is_digit(c)) {
            return refuse(s, "an index or size is not an unsigned integer");
        }
        *value = *value * 10 + (uint64_t)(c - '0');
        if (*value > most) return refuse(s, "an index or size is out of range");
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
    if (code < 0x10000) {
        out[0] = (char)(0xe0 | code >> 12);
        out[1] = (char)(0x80 | (code >> 6 & 0x3f));
        out[2] = (char)(0x80 | (code & 0x3f));
        return 3;
    }
    out[0] = (char)(0xf0 | code >> 18);
    out[1] = (char)(0x80 | (code >> 12 & 0x3f));
    out[2] = (char)(0x80 | (code >> 6 & 0x3f));
    out[3] = (char)(0x80 | (code & 0x3f));
    return 4;
}

/** The character whose four hexadecimal digits are at `p`, `left` bytes before the end; with
 * the escape behind it where two surrogates make one (RFC 8259, section 7). *used: bytes. */
static unsigned escaped(const char *p, size_t left, size_t *used)
{
    const unsigned high = hex4(p);
    *used = 4;
    if (high < 0xd800 || high > 0xdbff || left < 10 || p[4] != '\\' || p[5] != 'u') {
        return high;
    }
    const unsigned low = hex4(p + 6);
    if (low < 0xdc00 || low > 0xdfff) return high;
    *used = 10;
    return 0x10000 + ((high - 0xd800) << 10) + (low - 0xdc00);
}

/** A JSON string without its escapes, malloc'd: never longer than its source. */
static char *unescape(const char *text, size_t size)
{
    char *out = malloc(size + 1);
    size_t n = 0;
    for (size_t i = 0; out && i < size; ++i) {
        char c = text[i];
        if (c == '\\' && i + 1 < size) {
            c = text[++i];
            if (c == 'u' && i + 4 < size) {
                size_t used = 0;
                n += put_utf8(out + n, escaped(text + i + 1, size - i - 1, &used));
                i += used;
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
        if (!to_integer(s, t, MAX_SIZE, &buffer->byte_length)) return false;
        memset(s->text + t.start, ' ', t.end - t.start);
        s->text[t.start] = '1';
        return true;
    }
    *taken = false;
    return true;
}

static enum place place_in_root(const struct scanner *s, struct token key)
{
    if (same(s, key, "buffers")) return PLACE_BUFFERS;
    if (same(s, key, "images")) return PLACE_IMAGES;
    if (same(s, key, "meshes")) return PLACE_MESHES;
    if (same(s, key, "materials")) return PLACE_MATERIALS;
    if (same(s, key, "animations")) return PLACE_ANIMATIONS;
    return same(s, key, "scene") ? PLACE_INDEX : PLACE_LIST;
}

static enum place place_of_member(const struct scanner *s, enum place place,
                                  struct token key)
{
    if (place == PLACE_FREE || place == PLACE_TREE) return place;
    if (same(s, key, "extras")) return PLACE_FREE;
    if (same(s, key, "extensions")) return PLACE_TREE;
    if (place == PLACE_ROOT) return place_in_root(s, key);
    if (place == PLACE_ATTRIBUTES) return PLACE_INDEX;
    if (place == PLACE_MESH && same(s, key, "primitives")) return PLACE_PRIMITIVES;
    if (same(s, key, "attributes")) return PLACE_ATTRIBUTES;
    if (same(s, key, "sparse")) return PLACE_SPARSE;
    if (is_size_key(s, key)) return place == PLACE_SPARSE ? PLACE_INDEX : PLACE_SIZE;
    /* The indices and values of a sparse accessor are objects. */
    if (place == PLACE_SPARSE && peek_object(s)) return PLACE_SPARSE;
    return is_index_key(s, key) ? PLACE_INDEX : PLACE_ANY;
}

/** Renames keys that tinygltf would do harm with. */
static void rename_key(struct scanner *s, enum place place, struct token key)
{
    /* Nobody reads extras, but they are kept as a tree, 200 bytes for "0,". */
    if (place != PLACE_ATTRIBUTES && same(s, key, "extras")) s->text[key.start] = '_';
    /* The extensions of an animation are parsed again for each of its samplers. */
    if (place == PLACE_ANIMATION && same(s, key, "extensions")) {
        s->text[key.start] = '_';
    }
    /* Where an index accessor has no bufferView the file is refused, which would be
     * all that are sparse or compressed. So it goes by as extras, which are free by
     * now; the shim looks for it there. */
    if (place == PLACE_PRIMITIVE && same(s, key, "indices")) {
        memcpy(s->text + key.start, "extras\" ", 8);
    }
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
    rename_key(s, place, key);
    if (is_list_key(s, place, key) && peek(s) != '[') {
        s->source->odd_list = true; /* not yet: glTF 1.0 is told by its version */
    }
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
    if (place == PLACE_INDEX || place == PLACE_SIZE) place = PLACE_ANY;
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

/** What an element of a list is, and what it costs beyond its values. */
static enum place place_of_element(enum place list, uint64_t *cost)
{
    *cost = list == PLACE_MATERIALS ? COST_MATERIAL : COST_ITEM;
    switch (list) {
    case PLACE_BUFFERS:
        return PLACE_BUFFER;
    case PLACE_IMAGES:
        return PLACE_IMAGE;
    case PLACE_MESHES:
        return PLACE_MESH;
    case PLACE_PRIMITIVES:
        return PLACE_PRIMITIVE;
    case PLACE_ANIMATIONS:
        return PLACE_ANIMATION;
    case PLACE_LIST:
    case PLACE_MATERIALS:
        return PLACE_ANY;
    default:
        *cost = 0;
        return list == PLACE_FREE || list == PLACE_TREE || list == PLACE_INDEX
                   ? list
                   : PLACE_ANY;
    }
}

static bool take_element(struct scanner *s, enum place place, int depth)
{
    struct pbnds_gltf_source *src = s->source;
    uint64_t cost = 0;
    const enum place element = place_of_element(place, &cost);
    s->cost += cost;
    if (element == PLACE_BUFFER && !add_payload(s, &src->buffers, &src->buffer_count)) {
        return false;
    }
    if (element == PLACE_IMAGE && !add_payload(s, &src->images, &src->image_count)) {
        return false;
    }
    return take_value(s, element, depth + 1);
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
    s->cost += place == PLACE_TREE ? COST_TREE : COST_VALUE;
    if (s->cost > s->source->max_structure) {
        s->no_memory = true;
        return refuse(s, "it describes more than memory is allowed for, see "
                         "--max-geometry");
    }
    struct token t;
    const char c = peek(s);
    if (c == '{') return take_object(s, place, depth);
    if (c == '[') return take_array(s, place, depth);
    if (c == '"') return take_string(s, &t);
    if (c == '-' || (c >= '0' && c <= '9')) {
        uint64_t unused;
        take_number(s, &t);
        if (place == PLACE_TREE) keep_large(s, t);
        if (place == PLACE_INDEX) return to_integer(s, t, INT32_MAX, &unused);
        return place != PLACE_SIZE || to_integer(s, t, MAX_SIZE, &unused);
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
