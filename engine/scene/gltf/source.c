#include "engine/scene/gltf/source.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/scene/gltf/jail.h"

static uint32_t get_u32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
           (uint32_t)p[3] << 24;
}

static enum pbnds_status take_json(struct pbnds_gltf_source *source,
                                   const uint8_t *bytes, size_t size,
                                   struct pbnds_error *error)
{
    source->json = malloc(size + 1);
    if (!source->json) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its JSON",
                          source->name);
    }
    if (size) memcpy(source->json, bytes, size);
    source->json[size] = 0;
    source->json_size = size;
    return PBNDS_OK;
}

/* The container, glTF 2.0 specification, section 4: a header of 12 bytes, then chunks
 * of { length, type, bytes }; the first is JSON, a second of type BIN is buffer 0,
 * others are to be ignored. What follows the declared length is ignored too. */
static enum pbnds_status open_glb(struct pbnds_gltf_source *source,
                                  const uint8_t *bytes, size_t size,
                                  struct pbnds_error *error)
{
    const char *name = source->name;
    if (size < 12) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is truncated inside its header", name);
    }
    const uint32_t version = get_u32(bytes + 4);
    const size_t length = get_u32(bytes + 8);
    if (version != 2) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: is GLB version %u, only version 2 can be read", name,
                          version);
    }
    if (length < 20) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: its header says it has %zu bytes, too few for a GLB",
                          name, length);
    }
    if (length > size) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is truncated: its header says %zu bytes, it has %zu",
                          name, length, size);
    }
    size_t at = 12;
    for (int i = 0; length - at >= 8; ++i) {
        const size_t chunk = get_u32(bytes + at);
        const uint32_t type = get_u32(bytes + at + 4);
        at += 8;
        if (chunk > length - at) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                              "%s: chunk %d of %zu bytes reaches beyond the end", name,
                              i, chunk);
        }
        if (i == 0 && type != 0x4e4f534au) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                              "%s: its first chunk is not JSON", name);
        }
        if (i == 0) PBNDS_TRY(take_json(source, bytes + at, chunk, error));
        if (i == 1 && type == 0x004e4942u) {
            source->bin = bytes + at;
            source->bin_size = chunk;
        }
        at += chunk;
    }
    if (at != length) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is truncated inside the header of a chunk", name);
    }
    return PBNDS_OK;
}

static char *copy_text(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (copy) memcpy(copy, text, size);
    return copy;
}

size_t pbnds_gltf_max_file(const struct pbnds_gltf_options *options)
{
    const uint64_t most = options->max_file ? options->max_file : PBNDS_GLTF_MAX_FILE;
    return most < SIZE_MAX / 4 ? (size_t)most : SIZE_MAX / 4;
}

enum pbnds_status pbnds_gltf_source_open(struct pbnds_gltf_source *source,
                                         const uint8_t *bytes, size_t size,
                                         const char *name, const char *folder,
                                         const struct pbnds_gltf_options *options,
                                         struct pbnds_error *error)
{
    *source = (struct pbnds_gltf_source){
        .name = name,
        .external = options->allow_external,
        .max_file = pbnds_gltf_max_file(options),
        .max_structure =
            options->max_geometry ? options->max_geometry : PBNDS_GLTF_MAX_STRUCTURE,
    };
    if (size == 0) return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is empty", name);
    enum pbnds_status status = PBNDS_OK;
    if (folder) {
        source->folder = copy_text(folder);
        if (!source->folder) {
            status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", name);
        }
    }
    if (status == PBNDS_OK) {
        status = size >= 4 && memcmp(bytes, "glTF", 4) == 0
                     ? open_glb(source, bytes, size, error)
                     : take_json(source, bytes, size, error);
    }
    if (status != PBNDS_OK) pbnds_gltf_source_free(source);
    return status;
}

static void free_payloads(struct pbnds_gltf_payload *list, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        free(list[i].uri);
        free(list[i].owned);
    }
    free(list);
}

void pbnds_gltf_source_free(struct pbnds_gltf_source *source)
{
    free_payloads(source->buffers, source->buffer_count);
    free_payloads(source->images, source->image_count);
    free(source->json);
    free(source->folder);
    *source = (struct pbnds_gltf_source){0};
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/** Percent-decodes in place (RFC 3986, 2.1). A % without two digits stays as it is. */
static size_t percent_decode(char *text)
{
    size_t n = 0;
    for (const char *p = text; *p; ++p) {
        const int high = *p == '%' ? hex_digit(p[1]) : -1;
        const int low = high >= 0 ? hex_digit(p[2]) : -1;
        if (low >= 0) {
            text[n++] = (char)(high * 16 + low);
            p += 2;
        } else {
            text[n++] = *p;
        }
    }
    text[n] = 0;
    return n;
}

static int base64_digit(char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+') return 62;
    if (c == '/') return 63;
    return -1;
}

/** Decodes in place (RFC 4648); false when a character is none of the alphabet. */
static bool base64_decode(char *text, size_t *size)
{
    uint32_t bits = 0;
    int count = 0;
    size_t n = 0;
    const char *p = text;
    for (; *p && *p != '='; ++p) {
        const int digit = base64_digit(*p);
        if (digit < 0) return false;
        bits = bits << 6 | (uint32_t)digit;
        count += 6;
        if (count >= 8) {
            count -= 8;
            text[n++] = (char)(bits >> count & 0xff);
        }
    }
    while (*p == '=')
        ++p;
    *size = n;
    return *p == 0;
}

/** data:[<type>][;base64],<data> (RFC 2397). Takes the URI's own memory. */
static enum pbnds_status resolve_data(const struct pbnds_gltf_source *source,
                                      struct pbnds_gltf_payload *payload,
                                      const char *what, size_t index,
                                      struct pbnds_error *error)
{
    char *comma = strchr(payload->uri, ',');
    if (!comma) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: %s %zu has a data URI without data", source->name, what,
                          index);
    }
    *comma = 0;
    const size_t head = strlen(payload->uri);
    const bool base64 = head >= 7 && strcmp(payload->uri + head - 7, ";base64") == 0;
    size_t size = percent_decode(comma + 1);
    if (base64 && !base64_decode(comma + 1, &size)) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: %s %zu has a data URI that is not base64", source->name,
                          what, index);
    }
    payload->data = (const uint8_t *)comma + 1;
    payload->size = size;
    return PBNDS_OK;
}

/** The sentence of a file that stays closed. */
static enum pbnds_status stays_closed(const struct pbnds_gltf_source *source,
                                      enum pbnds_jail why, const char *path,
                                      const char *what, size_t index,
                                      struct pbnds_error *error)
{
    static const char *const reasons[] = {
        [PBNDS_JAIL_SCHEME] = "only relative paths and data: can be read",
        [PBNDS_JAIL_OUTSIDE] =
            "which lies outside of the folder of the file; --allow-external opens it",
        [PBNDS_JAIL_MISSING] = "which is not there or cannot be read",
        [PBNDS_JAIL_SPECIAL] = "which is not a plain file",
    };
    const bool hostile = why == PBNDS_JAIL_SCHEME || why == PBNDS_JAIL_OUTSIDE;
    return pbnds_fail(error, hostile ? PBNDS_ERROR_FORMAT : PBNDS_ERROR_IO,
                      "%s: %s %zu refers to \"%.200s\", %s", source->name, what, index,
                      path, reasons[why]);
}

static enum pbnds_status read_file(const struct pbnds_gltf_source *source,
                                   struct pbnds_gltf_payload *payload, int fd,
                                   const char *path, struct pbnds_error *error)
{
    enum pbnds_status status = pbnds_file_read_open(
        fd, path, source->max_file, &payload->owned, &payload->size, error);
    if (status == PBNDS_ERROR_MEMORY) {
        status = pbnds_fail(error, status,
                            "%s: \"%.200s\" is larger than the limit of %zu MB (see "
                            "--max-file) or than memory",
                            source->name, path, source->max_file >> 20);
    }
    payload->data = payload->owned;
    return status;
}

static enum pbnds_status resolve_file(const struct pbnds_gltf_source *source,
                                      struct pbnds_gltf_payload *payload,
                                      const char *what, size_t index,
                                      struct pbnds_error *error)
{
    if (!source->folder) {
        return pbnds_fail(
            error, PBNDS_ERROR_IO,
            "%s: %s %zu refers to the file \"%.200s\", which cannot be opened "
            "from memory",
            source->name, what, index, payload->uri);
    }
    char *path = copy_text(payload->uri);
    if (!path)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", source->name);
    const size_t length = percent_decode(path);
    int fd = -1;
    const enum pbnds_jail jail =
        pbnds_jail_open(source->folder, path, length, source->external, &fd);
    const enum pbnds_status status =
        jail == PBNDS_JAIL_OPEN
            ? read_file(source, payload, fd, path, error)
            : stays_closed(source, jail, payload->uri, what, index, error);
    if (fd >= 0) (void)close(fd);
    free(path);
    return status;
}

enum pbnds_status pbnds_gltf_resolve(const struct pbnds_gltf_source *source,
                                     struct pbnds_gltf_payload *payload,
                                     const char *what, size_t index,
                                     struct pbnds_error *error)
{
    if (payload->data) return PBNDS_OK;
    if (payload->uri) {
        return strncasecmp(payload->uri, "data:", 5) == 0
                   ? resolve_data(source, payload, what, index, error)
                   : resolve_file(source, payload, what, index, error);
    }
    /* Only the first buffer of a GLB may do without: it is the BIN chunk. */
    if (payload == source->buffers && source->bin) {
        payload->data = source->bin;
        payload->size = source->bin_size;
        return PBNDS_OK;
    }
    return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: %s %zu has no data", source->name,
                      what, index);
}
