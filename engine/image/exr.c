#include "engine/image/exr.h"

#include <errno.h>
#include <fcntl.h>
#include <openexr.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/file.h"

enum { SIDE_MAX = 65535, CHANNELS_MAX = 1024, ATTRIBUTES_MAX = 4096 };

static const size_t planes_max = (size_t)1 << 31;

/* What the library's callbacks work on: a file in memory to read, a descriptor to
 * write. */
struct stream {
    const uint8_t *bytes;
    size_t size;
    int fd;
    int fault; /* errno of the first write that failed */
    char message[256];
};

/* ---- half floats, IEEE 754 binary16, in integer arithmetic so that no flush-to-zero
 * mode of the calling thread can reach them ---- */

static uint16_t half_from_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint16_t sign = (uint16_t)(bits >> 16 & 0x8000u);
    const uint32_t magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u) { /* NaN keeps the top of its payload, and stays one */
        const uint32_t payload = magnitude >> 13 & 0x3ffu;
        return (uint16_t)(sign | 0x7c00u | (payload ? payload : 0x200u));
    }
    if (magnitude == 0x7f800000u) return (uint16_t)(sign | 0x7c00u);
    if (magnitude >= 0x477fe000u) return (uint16_t)(sign | 0x7bffu); /* saturates */
    if (magnitude < 0x33000000u) return sign;                        /* below 2^-25 */
    uint32_t mantissa, shift;
    if (magnitude < 0x38800000u) { /* subnormal: the leading one becomes explicit */
        shift = 126u - (magnitude >> 23);
        mantissa = (magnitude & 0x7fffffu) | 0x800000u;
    } else { /* rebias 127 to 15 */
        shift = 13;
        mantissa = magnitude - 0x38000000u;
    }
    const uint32_t rest = mantissa & ((1u << shift) - 1u), middle = 1u << (shift - 1u);
    uint32_t half = mantissa >> shift;
    half += rest > middle || (rest == middle && (half & 1u)) ? 1u : 0u;
    return (uint16_t)(sign | half);
}

static float float_from_half(uint16_t half)
{
    const uint32_t sign = (uint32_t)(half & 0x8000u) << 16;
    const uint32_t exponent = half >> 10 & 0x1fu;
    uint32_t mantissa = half & 0x3ffu, bits;
    if (exponent == 0x1fu) {
        bits = sign | 0x7f800000u | mantissa << 13;
    } else if (exponent != 0) {
        bits = sign | (exponent + 112u) << 23 | mantissa << 13;
    } else if (mantissa == 0) {
        bits = sign;
    } else { /* subnormal half, normal float */
        uint32_t e = 113u;
        while (!(mantissa & 0x400u)) {
            mantissa <<= 1;
            --e;
        }
        bits = sign | e << 23 | (mantissa & 0x3ffu) << 13;
    }
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* ---- the library: streams, messages, status ---- */

static struct stream *stream_of(exr_const_context_t context)
{
    void *user = NULL;
    if (!context || exr_get_user_data(context, &user) != EXR_ERR_SUCCESS) return NULL;
    return user;
}

/* Text from a file that may be damaged: what is not printable ASCII becomes '?'. */
static void printable(char *out, size_t size, const char *text)
{
    size_t n = 0;
    for (; text[n] && n + 1 < size; ++n) {
        out[n] = text[n] < 0x20 || text[n] > 0x7e ? '?' : text[n];
    }
    while (n > 0 && (out[n - 1] == '.' || out[n - 1] == ' '))
        --n; /* no full stop */
    out[n] = 0;
}

/* Keeps the first message: the ones that follow are its consequences. */
static void keep_message(exr_const_context_t context, exr_result_t code,
                         const char *message)
{
    (void)code;
    struct stream *s = stream_of(context);
    if (s && message && !s->message[0])
        printable(s->message, sizeof s->message, message);
}

static int64_t stream_size(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const struct stream *)user)->size;
}

static int64_t stream_read(exr_const_context_t context, void *user, void *buffer,
                           uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t fail)
{
    (void)context;
    (void)fail;
    const struct stream *s = user;
    if (offset >= s->size) return 0;
    const size_t left = s->size - (size_t)offset;
    const size_t count = size < left ? (size_t)size : left;
    memcpy(buffer, s->bytes + (size_t)offset, count);
    return (int64_t)count;
}

static int64_t stream_write(exr_const_context_t context, void *user, const void *buffer,
                            uint64_t size, uint64_t offset,
                            exr_stream_error_func_ptr_t fail)
{
    (void)context;
    (void)fail;
    struct stream *s = user;
    size_t done = 0;
    while (done < size) {
        const ssize_t n = pwrite(s->fd, (const char *)buffer + done,
                                 (size_t)size - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            if (!s->fault) s->fault = n < 0 ? errno : EIO;
            return -1;
        }
        done += (size_t)n;
    }
    return (int64_t)size;
}

static exr_context_initializer_t initializer(struct stream *s)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_message;
    init.user_data = s;
    init.read_fn = stream_read;
    init.size_fn = stream_size;
    init.write_fn = stream_write;
    /* The lenient mode guesses what is missing: a damaged compression becomes ZIP. */
    init.flags =
        EXR_CONTEXT_FLAG_STRICT_HEADER | EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return init;
}

static const char *reason(const struct stream *s, exr_result_t code)
{
    return s->message[0] ? s->message : exr_get_default_error_message(code);
}

static enum pbnds_status fail_read(const struct stream *s, const char *path,
                                   exr_result_t code, struct pbnds_error *error)
{
    switch (code) {
    case EXR_ERR_OUT_OF_MEMORY:
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory to read it", path);
    case EXR_ERR_FEATURE_NOT_IMPLEMENTED:
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED, "%s: not supported: %s", path,
                          reason(s, code));
    default:
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: not a sound OpenEXR file: %s",
                          path, reason(s, code));
    }
}

static enum pbnds_status fail_write(const struct stream *s, const char *path,
                                    exr_result_t code, struct pbnds_error *error)
{
    if (s->fault) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                          strerror(s->fault));
    }
    if (code == EXR_ERR_OUT_OF_MEMORY) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory to write it", path);
    }
    return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: cannot be an OpenEXR file: %s",
                      path, reason(s, code));
}

static enum pbnds_status fail_memory(const char *path, struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its channels",
                      path);
}

/* ---- reading ---- */

static size_t memory_bytes(const struct pbnds_exr *exr)
{
    return (size_t)exr->width * (size_t)exr->height * sizeof(float);
}

static enum pbnds_status check_kind(exr_context_t context, const struct stream *s,
                                    const char *path, struct pbnds_exr *exr,
                                    struct pbnds_error *error)
{
    int parts = 0;
    exr_storage_t storage;
    exr_compression_t compression;
    exr_result_t rv = exr_get_count(context, &parts);
    if (rv == EXR_ERR_SUCCESS) rv = exr_get_storage(context, 0, &storage);
    if (rv == EXR_ERR_SUCCESS) rv = exr_get_compression(context, 0, &compression);
    if (rv != EXR_ERR_SUCCESS) return fail_read(s, path, rv, error);
    if (parts != 1) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: has %d parts, store its channels in a single one", path,
                          parts);
    }
    if (storage != EXR_STORAGE_SCANLINE) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: is %s, store it as flat scan lines", path,
                          storage == EXR_STORAGE_TILED ? "tiled" : "a deep image");
    }
    if (compression != EXR_COMPRESSION_NONE && compression != EXR_COMPRESSION_ZIPS &&
        compression != EXR_COMPRESSION_ZIP && compression != EXR_COMPRESSION_PIZ) {
        return pbnds_fail(
            error, PBNDS_ERROR_UNSUPPORTED,
            "%s: its compression (%d) is not supported, store it with ZIP or "
            "PIZ",
            path, (int)compression);
    }
    exr->compression = (enum pbnds_exr_compression)compression;
    return PBNDS_OK;
}

/* Sizes, and whether a file of this length can hold them: a chunk takes at least 8
 * bytes in the table of offsets and 8 before its data. */
static enum pbnds_status check_size(exr_context_t context, const struct stream *s,
                                    const char *path, struct pbnds_exr *exr,
                                    exr_attr_box2i_t *window, struct pbnds_error *error)
{
    int32_t chunks = 0;
    exr_result_t rv = exr_get_data_window(context, 0, window);
    if (rv == EXR_ERR_SUCCESS) rv = exr_get_chunk_count(context, 0, &chunks);
    if (rv != EXR_ERR_SUCCESS) return fail_read(s, path, rv, error);
    const int64_t width = (int64_t)window->max.x - window->min.x + 1;
    const int64_t height = (int64_t)window->max.y - window->min.y + 1;
    if (width < 1 || height < 1) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: its data window has no pixels", path);
    }
    if (width > SIDE_MAX || height > SIDE_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: is %lld x %lld pixels, at most %d a side are supported",
                          path, (long long)width, (long long)height, (int)SIDE_MAX);
    }
    if (chunks < 1 || (uint64_t)chunks * 16u > s->size) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is cut short: %zu bytes cannot hold %d chunks", path,
                          s->size, (int)chunks);
    }
    exr->width = (int)width;
    exr->height = (int)height;
    return PBNDS_OK;
}

static enum pbnds_status read_channel(const exr_attr_chlist_entry_t *entry,
                                      const char *path, struct pbnds_exr *exr,
                                      struct pbnds_error *error)
{
    struct pbnds_exr_channel *channel = &exr->channels[exr->channel_count];
    const size_t length = (size_t)(entry->name.length > 0 ? entry->name.length : 0);
    if (length == 0 || length >= sizeof channel->name) {
        return pbnds_fail(
            error, PBNDS_ERROR_UNSUPPORTED,
            "%s: a channel name of %zu characters, 1 to %zu are supported", path,
            length, sizeof channel->name - 1);
    }
    memcpy(channel->name, entry->name.str, length);
    channel->name[length] = 0;
    char shown[sizeof channel->name];
    printable(shown, sizeof shown, channel->name);
    if (entry->x_sampling != 1 || entry->y_sampling != 1) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: channel %s is subsampled, store it at full size", path,
                          shown);
    }
    if (entry->pixel_type != EXR_PIXEL_UINT && entry->pixel_type != EXR_PIXEL_HALF &&
        entry->pixel_type != EXR_PIXEL_FLOAT) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: channel %s is of no known type", path, shown);
    }
    channel->type = (enum pbnds_exr_type)entry->pixel_type;
    channel->data = calloc(1, memory_bytes(exr));
    if (!channel->data) return fail_memory(path, error);
    ++exr->channel_count;
    return PBNDS_OK;
}

static enum pbnds_status read_channels(exr_context_t context, const struct stream *s,
                                       const char *path, struct pbnds_exr *exr,
                                       struct pbnds_error *error)
{
    const exr_attr_chlist_t *list = NULL;
    const exr_result_t rv = exr_get_channels(context, 0, &list);
    if (rv != EXR_ERR_SUCCESS) return fail_read(s, path, rv, error);
    if (list->num_channels < 1) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: has no channels", path);
    }
    if (list->num_channels > CHANNELS_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: has %d channels, at most %d are supported", path,
                          list->num_channels, (int)CHANNELS_MAX);
    }
    const size_t count = (size_t)list->num_channels;
    if (memory_bytes(exr) > planes_max / count) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: %d x %d pixels and %zu channels are more than 2 GiB",
                          path, exr->width, exr->height, count);
    }
    exr->channels = calloc(count, sizeof *exr->channels);
    if (!exr->channels) return fail_memory(path, error);
    for (size_t i = 0; i < count; ++i) {
        PBNDS_TRY(read_channel(&list->entries[i], path, exr, error));
    }
    return PBNDS_OK;
}

/* False where the attribute is of another kind or does not fit. */
static bool copy_attribute(const exr_attribute_t *from, struct pbnds_exr_attribute *to)
{
    if (!from->name || strlen(from->name) >= sizeof to->name) return false;
    strcpy(to->name, from->name);
    switch (from->type) {
    case EXR_ATTR_STRING:
        to->type = PBNDS_EXR_ATTRIBUTE_STRING;
        if (!from->string || from->string->length < 0 ||
            (size_t)from->string->length >= sizeof to->value.string) {
            return false;
        }
        memcpy(to->value.string, from->string->str, (size_t)from->string->length);
        to->value.string[from->string->length] = 0;
        return true;
    case EXR_ATTR_INT:
        to->type = PBNDS_EXR_ATTRIBUTE_INT;
        to->value.i = from->i;
        return true;
    case EXR_ATTR_FLOAT:
        to->type = PBNDS_EXR_ATTRIBUTE_FLOAT;
        to->value.f = from->f;
        return true;
    case EXR_ATTR_M44F:
        to->type = PBNDS_EXR_ATTRIBUTE_M44F;
        memcpy(to->value.m44, from->m44f->m, sizeof to->value.m44);
        return true;
    default:
        return false;
    }
}

static enum pbnds_status read_attributes(exr_context_t context, const struct stream *s,
                                         const char *path, struct pbnds_exr *exr,
                                         struct pbnds_error *error)
{
    int32_t count = 0;
    exr_result_t rv = exr_get_attribute_count(context, 0, &count);
    if (rv != EXR_ERR_SUCCESS) return fail_read(s, path, rv, error);
    if (count > ATTRIBUTES_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: has %d attributes, at most %d are supported", path,
                          (int)count, (int)ATTRIBUTES_MAX);
    }
    if (count < 1) return PBNDS_OK;
    exr->attributes = calloc((size_t)count, sizeof *exr->attributes);
    if (!exr->attributes) return fail_memory(path, error);
    for (int32_t i = 0; i < count; ++i) {
        const exr_attribute_t *attribute = NULL;
        rv = exr_get_attribute_by_index(context, 0, EXR_ATTR_LIST_FILE_ORDER, i,
                                        &attribute);
        if (rv != EXR_ERR_SUCCESS) return fail_read(s, path, rv, error);
        if (copy_attribute(attribute, &exr->attributes[exr->attribute_count])) {
            ++exr->attribute_count;
        }
    }
    return PBNDS_OK;
}

/* Halves are converted in a staging buffer that holds one chunk of every half channel.
 */
struct staging {
    uint16_t *halves;
    size_t plane; /* elements a channel */
};

static enum pbnds_status staging_init(struct staging *st, const struct pbnds_exr *exr,
                                      int lines, const char *path,
                                      struct pbnds_error *error)
{
    st->plane = (size_t)exr->width * (size_t)lines;
    st->halves = calloc(st->plane * (size_t)exr->channel_count, sizeof *st->halves);
    return st->halves ? PBNDS_OK : fail_memory(path, error);
}

/* Where the library reads or writes chunk rows [row, ...) of channel i. */
static void bind_channel(exr_coding_channel_info_t *info, const struct pbnds_exr *exr,
                         const struct pbnds_exr_channel *channel,
                         const struct staging *st, int slot, int row)
{
    const bool half = channel->type == PBNDS_EXR_HALF;
    const int size = half ? 2 : 4;
    info->user_bytes_per_element = (int16_t)size;
    info->user_data_type = (uint16_t)channel->type;
    info->user_pixel_stride = size;
    info->user_line_stride = size * exr->width;
    info->decode_to_ptr =
        half ? (uint8_t *)(st->halves + (size_t)slot * st->plane)
             : (uint8_t *)channel->data + (size_t)row * (size_t)exr->width * 4u;
}

static int channel_index(const struct pbnds_exr *exr, const char *name)
{
    for (int i = 0; i < exr->channel_count; ++i) {
        if (strcmp(exr->channels[i].name, name) == 0) return i;
    }
    return -1;
}

static void unpack_halves(const struct pbnds_exr *exr, const struct staging *st,
                          int row, int lines)
{
    const size_t count = (size_t)exr->width * (size_t)lines;
    for (int i = 0; i < exr->channel_count; ++i) {
        if (exr->channels[i].type != PBNDS_EXR_HALF) continue;
        const uint16_t *in = st->halves + (size_t)i * st->plane;
        float *out = (float *)exr->channels[i].data + (size_t)row * (size_t)exr->width;
        for (size_t k = 0; k < count; ++k)
            out[k] = float_from_half(in[k]);
    }
}

static void pack_halves(const struct pbnds_exr *exr, const struct staging *st, int row,
                        int lines)
{
    const size_t count = (size_t)exr->width * (size_t)lines;
    for (int i = 0; i < exr->channel_count; ++i) {
        if (exr->channels[i].type != PBNDS_EXR_HALF) continue;
        const float *in =
            (const float *)exr->channels[i].data + (size_t)row * (size_t)exr->width;
        uint16_t *out = st->halves + (size_t)i * st->plane;
        for (size_t k = 0; k < count; ++k)
            out[k] = half_from_float(in[k]);
    }
}

static exr_result_t decode_chunk(exr_context_t context, exr_decode_pipeline_t *pipe,
                                 const struct pbnds_exr *exr, const struct staging *st,
                                 int row, int top, int lines)
{
    exr_chunk_info_t chunk;
    exr_result_t rv = exr_read_scanline_chunk_info(context, 0, top + row, &chunk);
    if (rv != EXR_ERR_SUCCESS) return rv;
    if (chunk.start_y != top + row || chunk.height != lines ||
        chunk.width != exr->width) {
        return EXR_ERR_BAD_CHUNK_LEADER;
    }
    rv = row == 0 ? exr_decoding_initialize(context, 0, &chunk, pipe)
                  : exr_decoding_update(context, 0, &chunk, pipe);
    if (rv != EXR_ERR_SUCCESS) return rv;
    for (int c = 0; c < pipe->channel_count; ++c) {
        const int i = channel_index(exr, pipe->channels[c].channel_name);
        if (i < 0) return EXR_ERR_INVALID_ATTR;
        bind_channel(&pipe->channels[c], exr, &exr->channels[i], st, i, row);
    }
    if (row == 0) rv = exr_decoding_choose_default_routines(context, 0, pipe);
    if (rv == EXR_ERR_SUCCESS) rv = exr_decoding_run(context, 0, pipe);
    /* The PIZ decoder says so of data that inflate beyond their chunk. */
    if (rv == EXR_ERR_OUT_OF_MEMORY) rv = EXR_ERR_CORRUPT_CHUNK;
    if (rv == EXR_ERR_SUCCESS) unpack_halves(exr, st, row, lines);
    return rv;
}

static enum pbnds_status read_planes(exr_context_t context, const struct stream *s,
                                     const char *path, const struct pbnds_exr *exr,
                                     int top, struct pbnds_error *error)
{
    int32_t step = 0;
    exr_result_t rv = exr_get_scanlines_per_chunk(context, 0, &step);
    if (rv != EXR_ERR_SUCCESS || step < 1) return fail_read(s, path, rv, error);
    struct staging st;
    PBNDS_TRY(staging_init(&st, exr, step, path, error));
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    for (int row = 0; row < exr->height && rv == EXR_ERR_SUCCESS; row += step) {
        const int lines = exr->height - row < step ? exr->height - row : step;
        rv = decode_chunk(context, &pipe, exr, &st, row, top, lines);
    }
    (void)exr_decoding_destroy(context, &pipe);
    free(st.halves);
    return rv == EXR_ERR_SUCCESS ? PBNDS_OK : fail_read(s, path, rv, error);
}

static enum pbnds_status read_stream(struct stream *s, const char *path,
                                     struct pbnds_exr *exr, struct pbnds_error *error)
{
    const exr_context_initializer_t init = initializer(s);
    exr_context_t context = NULL;
    const exr_result_t rv = exr_start_read(&context, path, &init);
    if (rv != EXR_ERR_SUCCESS) return fail_read(s, path, rv, error);
    exr_attr_box2i_t window;
    enum pbnds_status status = check_kind(context, s, path, exr, error);
    if (status == PBNDS_OK) status = check_size(context, s, path, exr, &window, error);
    if (status == PBNDS_OK) status = read_channels(context, s, path, exr, error);
    if (status == PBNDS_OK) status = read_attributes(context, s, path, exr, error);
    if (status == PBNDS_OK) {
        status = read_planes(context, s, path, exr, window.min.y, error);
    }
    (void)exr_finish(&context);
    return status;
}

enum pbnds_status pbnds_exr_read(const char *path, struct pbnds_exr *exr,
                                 struct pbnds_error *error)
{
    *exr = (struct pbnds_exr){0};
    uint8_t *bytes = NULL;
    size_t size = 0;
    PBNDS_TRY(
        pbnds_file_read(path, planes_max + (planes_max >> 4), &bytes, &size, error));
    struct stream s = {.bytes = bytes, .size = size, .fd = -1};
    const enum pbnds_status status = read_stream(&s, path, exr, error);
    free(bytes);
    if (status != PBNDS_OK) pbnds_exr_free(exr);
    return status;
}

void pbnds_exr_free(struct pbnds_exr *exr)
{
    for (int i = 0; i < exr->channel_count; ++i)
        free(exr->channels[i].data);
    free(exr->channels);
    free(exr->attributes);
    *exr = (struct pbnds_exr){0};
}

const struct pbnds_exr_channel *pbnds_exr_find(const struct pbnds_exr *exr,
                                               const char *name)
{
    const int i = channel_index(exr, name);
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

/* ---- writing ---- */

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
        if (channel_index(exr, c->name) != i) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "%s: two channels are called %s", path, c->name);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status check_description(const char *path,
                                           const struct pbnds_exr *exr,
                                           struct pbnds_error *error)
{
    if (exr->width < 1 || exr->width > SIDE_MAX || exr->height < 1 ||
        exr->height > SIDE_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: %d x %d pixels, sides must lie in [1, %d]", path,
                          exr->width, exr->height, (int)SIDE_MAX);
    }
    if (exr->channel_count < 1 || exr->channel_count > CHANNELS_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: %d channels, there must be 1 to %d", path,
                          exr->channel_count, (int)CHANNELS_MAX);
    }
    if (exr->compression != PBNDS_EXR_NONE && exr->compression != PBNDS_EXR_ZIPS &&
        exr->compression != PBNDS_EXR_ZIP && exr->compression != PBNDS_EXR_PIZ) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: compression %d is not written", path,
                          (int)exr->compression);
    }
    return check_channels(path, exr, error);
}

static bool one_of(const char *name, const char *const *list)
{
    for (; *list; ++list) {
        if (strcmp(name, *list) == 0) return true;
    }
    return false;
}

static exr_result_t write_attribute(exr_context_t context,
                                    const struct pbnds_exr_attribute *a)
{
    exr_attr_m44f_t m;
    switch (a->type) {
    case PBNDS_EXR_ATTRIBUTE_STRING:
        return exr_attr_set_string(context, 0, a->name, a->value.string);
    case PBNDS_EXR_ATTRIBUTE_INT:
        return exr_attr_set_int(context, 0, a->name, a->value.i);
    case PBNDS_EXR_ATTRIBUTE_FLOAT:
        return exr_attr_set_float(context, 0, a->name, a->value.f);
    case PBNDS_EXR_ATTRIBUTE_M44F:
        memcpy(m.m, a->value.m44, sizeof m.m);
        return exr_attr_set_m44f(context, 0, a->name, &m);
    }
    return EXR_ERR_INVALID_ATTR;
}

static enum pbnds_status write_attributes(exr_context_t context, const struct stream *s,
                                          const char *path, const struct pbnds_exr *exr,
                                          struct pbnds_error *error)
{
    /* These follow from the planes: dropped, so that what was read can be written. */
    static const char *const implied[] = {"type", "name", "chunkCount", "version",
                                          NULL};
    static const char *const reserved[] = {
        "channels",  "compression",        "dataWindow", "displayWindow",
        "lineOrder", "screenWindowCenter", "tiles",      NULL};
    for (int i = 0; i < exr->attribute_count; ++i) {
        const struct pbnds_exr_attribute *a = &exr->attributes[i];
        const bool text = a->type == PBNDS_EXR_ATTRIBUTE_STRING;
        if (!terminated(a->name, sizeof a->name) || !a->name[0] ||
            (text && !terminated(a->value.string, sizeof a->value.string)) ||
            one_of(a->name, reserved)) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "%s: attribute %d lacks a name of its own or an end",
                              path, i);
        }
        if (one_of(a->name, implied)) continue;
        const exr_result_t rv = write_attribute(context, a);
        if (rv != EXR_ERR_SUCCESS) return fail_write(s, path, rv, error);
    }
    return PBNDS_OK;
}

/* The library puts channels in the order of their names, as the format wants it. */
static exr_result_t add_channels(exr_context_t context, const struct pbnds_exr *exr)
{
    exr_result_t rv = EXR_ERR_SUCCESS;
    for (int i = 0; i < exr->channel_count && rv == EXR_ERR_SUCCESS; ++i) {
        rv = exr_add_channel(context, 0, exr->channels[i].name,
                             (exr_pixel_type_t)exr->channels[i].type,
                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    return rv;
}

/* Names of 32 characters and more need a flag that old readers do not know. */
static bool has_long_names(const struct pbnds_exr *exr)
{
    for (int i = 0; i < exr->channel_count; ++i) {
        if (strlen(exr->channels[i].name) > 31) return true;
    }
    for (int i = 0; i < exr->attribute_count; ++i) {
        if (strlen(exr->attributes[i].name) > 31) return true;
    }
    return false;
}

static exr_result_t start_part(exr_context_t context, const struct pbnds_exr *exr)
{
    int part = 0;
    exr_result_t rv = exr_set_longname_support(context, has_long_names(exr) ? 1 : 0);
    if (rv != EXR_ERR_SUCCESS) return rv;
    rv = exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (rv != EXR_ERR_SUCCESS) return rv;
    rv = exr_initialize_required_attr_simple(context, 0, exr->width, exr->height,
                                             (exr_compression_t)exr->compression);
    return rv == EXR_ERR_SUCCESS ? add_channels(context, exr) : rv;
}

static exr_result_t encode_chunk(exr_context_t context, exr_encode_pipeline_t *pipe,
                                 const struct pbnds_exr *exr, const struct staging *st,
                                 int row, int lines)
{
    exr_chunk_info_t chunk;
    exr_result_t rv = exr_write_scanline_chunk_info(context, 0, row, &chunk);
    if (rv != EXR_ERR_SUCCESS) return rv;
    rv = row == 0 ? exr_encoding_initialize(context, 0, &chunk, pipe)
                  : exr_encoding_update(context, 0, &chunk, pipe);
    if (rv != EXR_ERR_SUCCESS) return rv;
    pack_halves(exr, st, row, lines);
    for (int c = 0; c < pipe->channel_count; ++c) {
        const int i = channel_index(exr, pipe->channels[c].channel_name);
        if (i < 0) return EXR_ERR_INVALID_ATTR;
        bind_channel(&pipe->channels[c], exr, &exr->channels[i], st, i, row);
    }
    if (row == 0) rv = exr_encoding_choose_default_routines(context, 0, pipe);
    return rv == EXR_ERR_SUCCESS ? exr_encoding_run(context, 0, pipe) : rv;
}

static enum pbnds_status write_planes(exr_context_t context, const struct stream *s,
                                      const char *path, const struct pbnds_exr *exr,
                                      struct pbnds_error *error)
{
    int32_t step = 0;
    exr_result_t rv = exr_get_scanlines_per_chunk(context, 0, &step);
    if (rv != EXR_ERR_SUCCESS || step < 1) return fail_write(s, path, rv, error);
    struct staging st;
    PBNDS_TRY(staging_init(&st, exr, step, path, error));
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    for (int row = 0; row < exr->height && rv == EXR_ERR_SUCCESS; row += step) {
        const int lines = exr->height - row < step ? exr->height - row : step;
        rv = encode_chunk(context, &pipe, exr, &st, row, lines);
    }
    (void)exr_encoding_destroy(context, &pipe);
    free(st.halves);
    return rv == EXR_ERR_SUCCESS ? PBNDS_OK : fail_write(s, path, rv, error);
}

static enum pbnds_status write_stream(struct stream *s, const char *path,
                                      const struct pbnds_exr *exr,
                                      struct pbnds_error *error)
{
    const exr_context_initializer_t init = initializer(s);
    exr_context_t context = NULL;
    exr_result_t rv = exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (rv != EXR_ERR_SUCCESS) return fail_write(s, path, rv, error);
    enum pbnds_status status = PBNDS_OK;
    rv = start_part(context, exr);
    if (rv != EXR_ERR_SUCCESS) status = fail_write(s, path, rv, error);
    if (status == PBNDS_OK) status = write_attributes(context, s, path, exr, error);
    if (status == PBNDS_OK) {
        rv = exr_write_header(context);
        if (rv != EXR_ERR_SUCCESS) status = fail_write(s, path, rv, error);
    }
    if (status == PBNDS_OK) status = write_planes(context, s, path, exr, error);
    rv = exr_finish(&context);
    if (status == PBNDS_OK && (rv != EXR_ERR_SUCCESS || s->fault)) {
        status = fail_write(s, path, rv, error);
    }
    return status;
}

enum pbnds_status pbnds_exr_write(const char *path, const struct pbnds_exr *exr,
                                  struct pbnds_error *error)
{
    PBNDS_TRY(check_description(path, exr, error));
    struct pbnds_file_writer w;
    PBNDS_TRY(pbnds_file_begin(&w, path, error));
    struct stream s = {.fd = open(w.temp, O_WRONLY | O_CLOEXEC)};
    enum pbnds_status status;
    if (s.fd < 0) {
        status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", path,
                            strerror(errno));
    } else {
        status = write_stream(&s, path, exr, error);
        if (close(s.fd) != 0 && status == PBNDS_OK) {
            status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s",
                                path, strerror(errno));
        }
    }
    if (status == PBNDS_OK) return pbnds_file_commit(&w, error);
    pbnds_file_abort(&w);
    return status;
}
