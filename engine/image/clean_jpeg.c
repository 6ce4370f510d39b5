#include "engine/image/clean.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* ITU-T T.81 annex B: markers and segments. JFIF is APP0, Adobe's colour transform
 * APP14. */

enum { TEM = 0x01, SOF0 = 0xc0, DHT = 0xc4, JPG = 0xc8, DAC = 0xcc, SOF15 = 0xcf };
enum { RST0 = 0xd0, RST7 = 0xd7, SOI = 0xd8, EOI = 0xd9, SOS = 0xda };
enum { APP0 = 0xe0, APP14 = 0xee, APP15 = 0xef, JPG0 = 0xf0, COM = 0xfe };

struct walk {
    const uint8_t *bytes;
    size_t size, at;
    bool frame, scan; /* seen */
    uint8_t *out;
    size_t out_size;
    const char *fault;
};

static bool is_frame(unsigned marker)
{
    return marker >= SOF0 && marker <= SOF15 && marker != DHT && marker != JPG &&
           marker != DAC;
}

static bool is_alone(unsigned marker)
{
    return marker == TEM || (marker >= RST0 && marker <= RST7);
}

static bool starts(const uint8_t *data, size_t size, const char *text, size_t length)
{
    return size >= length && memcmp(data, text, length) == 0;
}

/* Whether a segment shapes the pixels; data are what follows its length. */
static bool counts(unsigned marker, const uint8_t *data, size_t size)
{
    if (marker == APP0) return starts(data, size, "JFIF", 5);
    if (marker == APP14) return starts(data, size, "Adobe", 5);
    return !(marker > APP0 && marker <= APP15) && !(marker >= JPG0 && marker <= COM);
}

static void keep(struct walk *w, const uint8_t *data, size_t size)
{
    memcpy(w->out + w->out_size, data, size);
    w->out_size += size;
}

/* Next marker, or -1 where the file ends; any number of 0xff may come before it. */
static int next_marker(struct walk *w)
{
    if (w->at >= w->size || w->bytes[w->at] != 0xff) {
        w->fault = w->at >= w->size ? "it is cut short" : "a marker is missing";
        return -1;
    }
    while (w->at < w->size && w->bytes[w->at] == 0xff)
        ++w->at;
    if (w->at >= w->size) {
        w->fault = "it is cut short";
        return -1;
    }
    return w->bytes[w->at++];
}

/* Coded data end before a marker that is neither a stuffed zero nor a restart. */
static void keep_scan(struct walk *w)
{
    const size_t begin = w->at;
    while (w->at < w->size) {
        if (w->bytes[w->at] == 0xff && w->at + 1 < w->size) {
            const unsigned next = w->bytes[w->at + 1];
            if (next != 0 && next != 0xff && !(next >= RST0 && next <= RST7)) break;
        }
        ++w->at;
    }
    keep(w, w->bytes + begin, w->at - begin);
    w->scan = true;
}

static void see_frame(struct walk *w, const uint8_t *data, size_t size)
{
    if (w->frame) {
        w->fault = "it has two frames";
    } else if (size < 6) {
        w->fault = "its frame header is cut short";
    } else if ((data[1] | data[2]) == 0 || (data[3] | data[4]) == 0) {
        w->fault = "it has no pixels";
    }
    w->frame = true;
}

static void take_segment(struct walk *w, unsigned marker)
{
    if (w->size - w->at < 2) {
        w->fault = "it is cut short";
        return;
    }
    const uint8_t *segment = w->bytes + w->at;
    const size_t length = (size_t)segment[0] << 8 | segment[1];
    if (length < 2 || length > w->size - w->at) {
        w->fault = length < 2 ? "a segment has no length" : "it is cut short";
        return;
    }
    if (is_frame(marker)) see_frame(w, segment + 2, length - 2);
    if (marker == SOS && !w->frame) w->fault = "a scan comes before its frame";
    if (counts(marker, segment + 2, length - 2)) {
        const uint8_t head[2] = {0xff, (uint8_t)marker};
        keep(w, head, sizeof head);
        keep(w, segment, length);
    }
    w->at += length;
    if (marker == SOS) keep_scan(w);
}

static void walk_segments(struct walk *w)
{
    static const uint8_t start[2] = {0xff, SOI}, end[2] = {0xff, EOI};
    keep(w, start, sizeof start);
    w->at = sizeof start;
    while (!w->fault) {
        const int marker = next_marker(w);
        if (marker == EOI) {
            if (!w->scan) w->fault = "it has no image data";
            keep(w, end, sizeof end);
            return;
        }
        if (marker == SOI || marker == 0) w->fault = "a marker is not valid";
        if (!w->fault && !is_alone((unsigned)marker)) take_segment(w, (unsigned)marker);
    }
}

enum pbnds_status pbnds_clean_jpeg(const uint8_t *bytes, size_t size, const char *name,
                                   uint8_t **clean, size_t *clean_size,
                                   struct pbnds_error *error)
{
    *clean = NULL;
    *clean_size = 0;
    if (size < 4 || bytes[0] != 0xff || bytes[1] != SOI) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not a JPEG file", name);
    }
    struct walk w = {.bytes = bytes, .size = size, .out = malloc(size)};
    if (!w.out) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for %zu bytes",
                          name, size);
    }
    walk_segments(&w);
    if (w.fault) {
        free(w.out);
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: JPEG is damaged: %s", name,
                          w.fault);
    }
    *clean = w.out;
    *clean_size = w.out_size;
    return PBNDS_OK;
}
