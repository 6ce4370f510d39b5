#include "engine/image/exr.h"

#include <errno.h>
#include <fcntl.h>
#include <openexr.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "engine/image/exr_description.h"
#include "engine/image/exr_staging.h"

enum { ATTRIBUTES_MAX = 4096 };

static const size_t planes_max = (size_t)1 << 31;

/* What the library's callbacks work on: a file in memory to read, a descriptor to
 * write. */
struct stream {
    const uint8_t *bytes;
    size_t size;
    int fd;
    int fault;        /* errno of the first write that failed */
    atomic_flag told; /* chunks are coded by several threads: one of them may speak */
    char message[256];
};

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
    if (s && message && !atomic_flag_test_and_set(&s->told))
        printable(s->message, sizeof s->message, message);
}

static void forget_message(struct stream *s)
{
    atomic_flag_clear(&s->told);
    s->message[0] = 0;
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

/* Chunks of a small image are coded faster than threads wake up. */
static void for_chunks(const struct pbnds_exr *exr, size_t count,
                       void (*body)(void *context, size_t i, int thread), void *context)
{
    const uint64_t samples =
        (uint64_t)exr->width * (uint64_t)exr->height * (uint64_t)exr->channel_count;
    if (samples >= 16384) {
        pbnds_parallel_for(count, body, context);
    } else {
        for (size_t i = 0; i < count; ++i)
            body(context, i, 0);
    }
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

/* ---- reading ---- */

static const char *compression_name(exr_compression_t compression)
{
    switch (compression) {
    case EXR_COMPRESSION_RLE:
        return "RLE";
    case EXR_COMPRESSION_PXR24:
        return "PXR24 (lossy)";
    case EXR_COMPRESSION_B44:
        return "B44 (lossy)";
    case EXR_COMPRESSION_B44A:
        return "B44A (lossy)";
    case EXR_COMPRESSION_DWAA:
        return "DWAA (lossy)";
    case EXR_COMPRESSION_DWAB:
        return "DWAB (lossy)";
    default:
        return "an unknown method";
    }
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
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: is compressed with %s, which is not supported; store it "
                          "with ZIP or PIZ",
                          path, compression_name(compression));
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
    if (width > PBNDS_EXR_SIDE_MAX || height > PBNDS_EXR_SIDE_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: is %lld x %lld pixels, at most %d a side are supported",
                          path, (long long)width, (long long)height,
                          (int)PBNDS_EXR_SIDE_MAX);
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
    channel->data = calloc(1, pbnds_exr_plane_bytes(exr));
    if (!channel->data) return pbnds_exr_fail_memory(path, error);
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
    if (list->num_channels > PBNDS_EXR_CHANNELS_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: has %d channels, at most %d are supported", path,
                          list->num_channels, (int)PBNDS_EXR_CHANNELS_MAX);
    }
    const size_t count = (size_t)list->num_channels;
    if (pbnds_exr_plane_bytes(exr) > planes_max / count) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: %d x %d pixels and %zu channels are more than 2 GiB",
                          path, exr->width, exr->height, count);
    }
    exr->channels = calloc(count, sizeof *exr->channels);
    if (!exr->channels) return pbnds_exr_fail_memory(path, error);
    for (size_t i = 0; i < count; ++i) {
        PBNDS_TRY(read_channel(&list->entries[i], path, exr, error));
    }
    return PBNDS_OK;
}

static bool copy_string(const exr_attr_string_t *from, struct pbnds_exr_attribute *to)
{
    if (!from || from->length < 0) return false;
    const size_t length = (size_t)from->length;
    char *text = to->value.string;
    to->type = PBNDS_EXR_ATTRIBUTE_STRING;
    if (length >= sizeof to->value.string) {
        text = malloc(length + 1);
        if (!text) return false;
        to->type = PBNDS_EXR_ATTRIBUTE_TEXT;
        to->value.text = text;
    }
    memcpy(text, from->str, length);
    text[length] = 0;
    return true;
}

/* False where the attribute is of another kind or does not fit. */
static bool copy_attribute(const exr_attribute_t *from, struct pbnds_exr_attribute *to)
{
    if (!from->name || strlen(from->name) >= sizeof to->name) return false;
    strcpy(to->name, from->name);
    switch (from->type) {
    case EXR_ATTR_STRING:
        return copy_string(from->string, to);
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
    if (!exr->attributes) return pbnds_exr_fail_memory(path, error);
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

/* Where the library reads or writes chunk rows [row, ...) of channel i. */
static void bind_channel(exr_coding_channel_info_t *info, const struct pbnds_exr *exr,
                         const struct pbnds_exr_channel *channel,
                         const struct pbnds_exr_staging *st, int slot, int row)
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

/* What one thread keeps from chunk to chunk. */
struct decoder {
    exr_decode_pipeline_t pipe;
    struct pbnds_exr_staging staging;
    bool started;
};

/* One reading of all planes. */
struct decoding {
    exr_context_t context;
    const struct pbnds_exr *exr;
    struct decoder *decoders; /* one a thread */
    exr_result_t *results;    /* one a chunk  */
    int top, step;            /* first row of the data window, rows a chunk */
};

/* Of a chunk that no thread took on. */
enum { NOT_DONE = -1 };

static exr_result_t prepare_decoder(const struct decoding *job, struct decoder *d,
                                    int row, int lines)
{
    const struct pbnds_exr *exr = job->exr;
    exr_chunk_info_t chunk;
    exr_result_t rv =
        exr_read_scanline_chunk_info(job->context, 0, job->top + row, &chunk);
    if (rv != EXR_ERR_SUCCESS) return rv;
    if (chunk.start_y != job->top + row || chunk.height != lines ||
        chunk.width != exr->width) {
        return EXR_ERR_BAD_CHUNK_LEADER;
    }
    rv = d->started ? exr_decoding_update(job->context, 0, &chunk, &d->pipe)
                    : exr_decoding_initialize(job->context, 0, &chunk, &d->pipe);
    if (rv != EXR_ERR_SUCCESS) return rv;
    for (int c = 0; c < d->pipe.channel_count; ++c) {
        const int i = pbnds_exr_channel_index(exr, d->pipe.channels[c].channel_name);
        if (i < 0) return EXR_ERR_INVALID_ATTR;
        bind_channel(&d->pipe.channels[c], exr, &exr->channels[i], &d->staging, i, row);
    }
    if (!d->started)
        rv = exr_decoding_choose_default_routines(job->context, 0, &d->pipe);
    d->started = true;
    return rv;
}

static void stop_decoder(const struct decoding *job, struct decoder *d)
{
    (void)exr_decoding_destroy(job->context, &d->pipe);
    d->pipe = (exr_decode_pipeline_t)EXR_DECODE_PIPELINE_INITIALIZER;
    d->started = false;
}

static exr_result_t decode_chunk(const struct decoding *job, struct decoder *d,
                                 size_t chunk)
{
    const struct pbnds_exr *exr = job->exr;
    const int row = (int)chunk * job->step;
    const int lines = exr->height - row < job->step ? exr->height - row : job->step;
    exr_result_t rv = prepare_decoder(job, d, row, lines);
    if (rv == EXR_ERR_SUCCESS) rv = exr_decoding_run(job->context, 0, &d->pipe);
    /* The PIZ decoder says so of data that inflate beyond their chunk. */
    if (rv == EXR_ERR_OUT_OF_MEMORY) rv = EXR_ERR_CORRUPT_CHUNK;
    if (rv == EXR_ERR_SUCCESS) {
        pbnds_exr_unpack_halves(exr, &d->staging, row, lines);
    } else {
        stop_decoder(job, d); /* what a failure leaves is good for nothing */
    }
    return rv;
}

static void decode_body(void *context, size_t chunk, int thread)
{
    const struct decoding *job = context;
    job->results[chunk] = decode_chunk(job, &job->decoders[thread], chunk);
}

/* The chunks that failed once more, in order, by this thread alone, so that the message is
 * that of the first; and those that were left out because a stop was asked for: reading
 * is short, and stops only as a whole. */
static enum pbnds_status decode_again(const struct decoding *job, struct stream *s,
                                      const char *path, size_t chunks,
                                      struct pbnds_error *error)
{
    for (size_t i = 0; i < chunks; ++i) {
        if (job->results[i] == EXR_ERR_SUCCESS) continue;
        forget_message(s);
        const exr_result_t rv = decode_chunk(job, &job->decoders[0], i);
        if (rv != EXR_ERR_SUCCESS) return fail_read(s, path, rv, error);
    }
    return PBNDS_OK;
}

static enum pbnds_status read_planes(exr_context_t context, struct stream *s,
                                     const char *path, const struct pbnds_exr *exr,
                                     int top, struct pbnds_error *error)
{
    int32_t step = 0;
    const exr_result_t rv = exr_get_scanlines_per_chunk(context, 0, &step);
    if (rv != EXR_ERR_SUCCESS || step < 1) return fail_read(s, path, rv, error);
    const size_t chunks = ((size_t)exr->height + (size_t)step - 1) / (size_t)step;
    const size_t threads = (size_t)pbnds_threads();
    struct decoding job = {
        .context = context,
        .exr = exr,
        .decoders = calloc(threads, sizeof *job.decoders),
        .results = malloc(chunks * sizeof *job.results),
        .top = top,
        .step = step,
    };
    enum pbnds_status status =
        job.decoders && job.results ? PBNDS_OK : pbnds_exr_fail_memory(path, error);
    for (size_t t = 0; t < threads && status == PBNDS_OK; ++t)
        status =
            pbnds_exr_staging_init(&job.decoders[t].staging, exr, step, path, error);
    if (status == PBNDS_OK) {
        for (size_t i = 0; i < chunks; ++i)
            job.results[i] = NOT_DONE;
        for_chunks(exr, chunks, decode_body, &job);
        status = decode_again(&job, s, path, chunks, error);
    }
    for (size_t t = 0; t < threads && job.decoders; ++t) {
        stop_decoder(&job, &job.decoders[t]);
        free(job.decoders[t].staging.halves);
    }
    free(job.decoders);
    free(job.results);
    return status;
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

enum pbnds_status pbnds_exr_read_memory(const char *name, const uint8_t *bytes,
                                        size_t size, struct pbnds_exr *exr,
                                        struct pbnds_error *error)
{
    *exr = (struct pbnds_exr){0};
    struct stream s = {
        .bytes = bytes, .size = size, .fd = -1, .told = ATOMIC_FLAG_INIT};
    const enum pbnds_status status = read_stream(&s, name, exr, error);
    if (status != PBNDS_OK) pbnds_exr_free(exr);
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
    const enum pbnds_status status =
        pbnds_exr_read_memory(path, bytes, size, exr, error);
    free(bytes);
    return status;
}

/* ---- writing ---- */

static exr_result_t write_attribute(exr_context_t context,
                                    const struct pbnds_exr_attribute *a)
{
    exr_attr_m44f_t m;
    switch (a->type) {
    case PBNDS_EXR_ATTRIBUTE_STRING:
        return exr_attr_set_string(context, 0, a->name, a->value.string);
    case PBNDS_EXR_ATTRIBUTE_TEXT:
        return exr_attr_set_string(context, 0, a->name, a->value.text);
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
    for (int i = 0; i < exr->attribute_count; ++i) {
        const struct pbnds_exr_attribute *a = &exr->attributes[i];
        const enum pbnds_exr_attribute_fate fate = pbnds_exr_attribute_fate(a);
        if (fate == PBNDS_EXR_ATTRIBUTE_REFUSED) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "%s: attribute %d lacks a name of its own or an end",
                              path, i);
        }
        if (fate == PBNDS_EXR_ATTRIBUTE_IMPLIED) continue;
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

static exr_result_t start_part(exr_context_t context, const struct pbnds_exr *exr)
{
    int part = 0;
    exr_result_t rv =
        exr_set_longname_support(context, pbnds_exr_has_long_names(exr) ? 1 : 0);
    if (rv != EXR_ERR_SUCCESS) return rv;
    rv = exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (rv != EXR_ERR_SUCCESS) return rv;
    rv = exr_initialize_required_attr_simple(context, 0, exr->width, exr->height,
                                             (exr_compression_t)exr->compression);
    return rv == EXR_ERR_SUCCESS ? add_channels(context, exr) : rv;
}

/* Chunks must be written in order, and take far longer to compress than to write. So
 * some are compressed at once, each by its own pipeline, and then written one after the
 * other: the file is the same at any number of threads, and no thread waits for another
 * in the middle of its work. */
enum { ENCODERS_A_THREAD = 2, ENCODERS_MAX = 32 };

struct encoder {
    exr_encode_pipeline_t pipe;
    struct pbnds_exr_staging staging;
    bool started, done;
    exr_result_t result;
};

struct encoding {
    exr_context_t context;
    const struct pbnds_exr *exr;
    struct encoder *encoders;
    int step;      /* rows a chunk           */
    int first_row; /* of the encoders' batch */
};

static exr_result_t keep_chunk(exr_encode_pipeline_t *pipe)
{
    (void)pipe;
    return EXR_ERR_SUCCESS;
}

static exr_result_t encode_chunk(const struct encoding *job, struct encoder *e, int row)
{
    const struct pbnds_exr *exr = job->exr;
    const int lines = exr->height - row < job->step ? exr->height - row : job->step;
    exr_chunk_info_t chunk;
    exr_result_t rv = exr_write_scanline_chunk_info(job->context, 0, row, &chunk);
    if (rv != EXR_ERR_SUCCESS) return rv;
    rv = e->started ? exr_encoding_update(job->context, 0, &chunk, &e->pipe)
                    : exr_encoding_initialize(job->context, 0, &chunk, &e->pipe);
    if (rv != EXR_ERR_SUCCESS) return rv;
    pbnds_exr_pack_halves(exr, &e->staging, row, lines);
    for (int c = 0; c < e->pipe.channel_count; ++c) {
        const int i = pbnds_exr_channel_index(exr, e->pipe.channels[c].channel_name);
        if (i < 0) return EXR_ERR_INVALID_ATTR;
        bind_channel(&e->pipe.channels[c], exr, &exr->channels[i], &e->staging, i, row);
    }
    if (!e->started) {
        rv = exr_encoding_choose_default_routines(job->context, 0, &e->pipe);
        e->pipe.yield_until_ready_fn = keep_chunk;
        e->pipe.write_fn = keep_chunk;
        e->started = true;
    }
    return rv == EXR_ERR_SUCCESS ? exr_encoding_run(job->context, 0, &e->pipe) : rv;
}

static void encode_body(void *context, size_t i, int thread)
{
    (void)thread;
    const struct encoding *job = context;
    struct encoder *e = &job->encoders[i];
    e->result = encode_chunk(job, e, job->first_row + (int)i * job->step);
    e->done = true;
}

/* Compresses `count` chunks and writes them. One that was left out because a stop was
 * asked for is done here: a file that was begun is finished. */
static exr_result_t encode_batch(struct encoding *job, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        job->encoders[i].done = false;
    for_chunks(job->exr, count, encode_body, job);
    for (size_t i = 0; i < count; ++i) {
        struct encoder *e = &job->encoders[i];
        if (!e->done) encode_body(job, i, 0);
        if (e->result != EXR_ERR_SUCCESS) return e->result;
        const exr_result_t rv = exr_write_scanline_chunk(
            job->context, 0, job->first_row + (int)i * job->step,
            e->pipe.compressed_buffer, e->pipe.compressed_bytes);
        if (rv != EXR_ERR_SUCCESS) return rv;
    }
    return EXR_ERR_SUCCESS;
}

static exr_result_t encode_all(struct encoding *job, size_t encoders)
{
    const size_t step = (size_t)job->step, height = (size_t)job->exr->height;
    for (size_t row = 0; row < height; row += encoders * step) {
        const size_t left = (height - row + step - 1) / step;
        job->first_row = (int)row;
        const exr_result_t rv = encode_batch(job, left < encoders ? left : encoders);
        if (rv != EXR_ERR_SUCCESS) return rv;
    }
    return EXR_ERR_SUCCESS;
}

static enum pbnds_status write_planes(exr_context_t context, const struct stream *s,
                                      const char *path, const struct pbnds_exr *exr,
                                      struct pbnds_error *error)
{
    int32_t step = 0;
    exr_result_t rv = exr_get_scanlines_per_chunk(context, 0, &step);
    if (rv != EXR_ERR_SUCCESS || step < 1) return fail_write(s, path, rv, error);
    const size_t chunks = ((size_t)exr->height + (size_t)step - 1) / (size_t)step;
    size_t count = (size_t)pbnds_threads();
    count = count > 1 ? count * ENCODERS_A_THREAD : 1;
    if (count > ENCODERS_MAX) count = ENCODERS_MAX;
    if (count > chunks) count = chunks;
    struct encoding job = {.context = context,
                           .exr = exr,
                           .encoders = calloc(count, sizeof *job.encoders),
                           .step = step};
    enum pbnds_status status =
        job.encoders ? PBNDS_OK : pbnds_exr_fail_memory(path, error);
    for (size_t i = 0; i < count && status == PBNDS_OK; ++i)
        status =
            pbnds_exr_staging_init(&job.encoders[i].staging, exr, step, path, error);
    if (status == PBNDS_OK) {
        rv = encode_all(&job, count);
        if (rv != EXR_ERR_SUCCESS) status = fail_write(s, path, rv, error);
    }
    for (size_t i = 0; i < count && job.encoders; ++i) {
        (void)exr_encoding_destroy(context, &job.encoders[i].pipe);
        free(job.encoders[i].staging.halves);
    }
    free(job.encoders);
    return status;
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
    PBNDS_TRY(pbnds_exr_check(path, exr, error));
    struct pbnds_file_writer w;
    PBNDS_TRY(pbnds_file_begin(&w, path, error));
    struct stream s = {.fd = open(w.temp, O_WRONLY | O_CLOEXEC),
                       .told = ATOMIC_FLAG_INIT};
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
