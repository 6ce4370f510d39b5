#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"

/** A strided range of a buffer whose every element has been checked to exist. */
struct range {
    const uint8_t *data;
    uint64_t stride;
};

static uint64_t component_size(int component)
{
    switch (component) {
    case PBNDS_GLTF_BYTE:
    case PBNDS_GLTF_UBYTE:
        return 1;
    case PBNDS_GLTF_SHORT:
    case PBNDS_GLTF_USHORT:
        return 2;
    case PBNDS_GLTF_UINT:
    case PBNDS_GLTF_FLOAT:
        return 4;
    default:
        return 0;
    }
}

enum pbnds_status pbnds_gltf_buffer_bytes(struct pbnds_gltf_load_state *g,
                                          int64_t index, uint64_t offset, uint64_t size,
                                          const uint8_t **data)
{
    struct pbnds_gltf_payload *buffer = &g->source.buffers[index];
    PBNDS_TRY(
        pbnds_gltf_resolve(&g->source, buffer, "buffer", (size_t)index, g->error));
    if (buffer->size < buffer->byte_length) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: buffer %lld should have %llu bytes, it has %zu", g->name,
                          (long long)index, (unsigned long long)buffer->byte_length,
                          buffer->size);
    }
    if (offset > buffer->byte_length || size > buffer->byte_length - offset) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: a bufferView reaches beyond buffer %lld", g->name,
                          (long long)index);
    }
    *data = buffer->data + offset;
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_view_bytes(struct pbnds_gltf_load_state *g, int64_t index,
                                        const char *what, const uint8_t **data,
                                        uint64_t *size)
{
    if (index < 0 || (uint64_t)index >= g->doc.view_count) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: %s refers to bufferView %lld, which does not exist",
                          g->name, what, (long long)index);
    }
    const struct pbnds_gltf_view *view = &g->doc.views[index];
    *size = view->length;
    if (view->meshopt.present) {
        PBNDS_TRY(pbnds_gltf_unpack_view(g, index));
        *data = view->unpacked;
        return PBNDS_OK;
    }
    if (view->buffer < 0 || (uint64_t)view->buffer >= g->doc.buffer_count) {
        return pbnds_fail(
            g->error, PBNDS_ERROR_FORMAT,
            "%s: bufferView %lld refers to buffer %lld, which does not exist", g->name,
            (long long)index, (long long)view->buffer);
    }
    return pbnds_gltf_buffer_bytes(g, view->buffer, view->offset, view->length, data);
}

enum pbnds_status pbnds_gltf_check_range(struct pbnds_gltf_load_state *g,
                                         const char *what, int64_t view,
                                         uint64_t offset, uint64_t count,
                                         uint64_t element, uint64_t stride)
{
    const uint64_t size = g->doc.views[view].length;
    if (stride && stride < element) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: bufferView %lld has a byteStride of %llu, smaller than "
                          "the elements of %s",
                          g->name, (long long)view, (unsigned long long)stride, what);
    }
    /* (count - 1) * stride + element <= size - offset, without an overflow */
    const uint64_t step = stride ? stride : element;
    const bool fits = offset <= size && element <= size - offset &&
                      (count - 1) <= (size - offset - element) / step;
    if (count == 0 || fits) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                      "%s: %s reaches beyond the end of bufferView %lld", g->name, what,
                      (long long)view);
}

/** Where `count` elements of `element` bytes lie; a view's stride spaces them if
 * `strided`. */
static enum pbnds_status range_of(struct pbnds_gltf_load_state *g, const char *what,
                                  int64_t view, uint64_t offset, uint64_t count,
                                  uint64_t element, bool strided, struct range *range)
{
    const uint8_t *data = NULL;
    uint64_t size = 0;
    PBNDS_TRY(pbnds_gltf_view_bytes(g, view, what, &data, &size));
    const uint64_t stride = strided ? g->doc.views[view].stride : 0;
    PBNDS_TRY(pbnds_gltf_check_range(g, what, view, offset, count, element, stride));
    range->stride = stride ? stride : element;
    range->data = count ? data + offset : data;
    return PBNDS_OK;
}

uint64_t pbnds_gltf_element_size(const struct pbnds_gltf_accessor *a)
{
    return component_size(a->component) * (uint64_t)a->width;
}

enum pbnds_status pbnds_gltf_accessor_at(struct pbnds_gltf_load_state *g, int64_t index,
                                         int width, const char *what,
                                         const struct pbnds_gltf_accessor **accessor)
{
    if (index < 0 || (uint64_t)index >= g->doc.accessor_count) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: %s refers to accessor %lld, which does not exist",
                          g->name, what, (long long)index);
    }
    const struct pbnds_gltf_accessor *a = &g->doc.accessors[index];
    if (a->width != width || component_size(a->component) == 0) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: accessor %lld has the wrong type for %s", g->name,
                          (long long)index, what);
    }
    if (a->unpacked) {
        *accessor = a;
        return PBNDS_OK;
    }
    /* Without a buffer the file pays nothing for an element: bound it. */
    if (a->view < 0 && a->count > (1u << 24)) {
        return pbnds_fail(g->error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: accessor %lld has more than 2^24 elements and no data",
                          g->name, (long long)index);
    }
    struct range unused;
    if (a->view >= 0) {
        PBNDS_TRY(range_of(g, what, a->view, a->offset, a->count,
                           pbnds_gltf_element_size(a), true, &unused));
    }
    *accessor = a;
    return PBNDS_OK;
}

/* Elements need not be aligned: memcpy. Both formats are little-endian, as every
 * machine we build for. */
static float component_float(const uint8_t *p, int component, bool normalized)
{
    switch (component) {
    case PBNDS_GLTF_BYTE: {
        const float x = (float)(int8_t)p[0];
        return normalized ? fmaxf(x / 127.0f, -1.0f) : x;
    }
    case PBNDS_GLTF_UBYTE:
        return normalized ? (float)p[0] / 255.0f : (float)p[0];
    case PBNDS_GLTF_SHORT: {
        int16_t x;
        memcpy(&x, p, sizeof x);
        return normalized ? fmaxf((float)x / 32767.0f, -1.0f) : (float)x;
    }
    case PBNDS_GLTF_USHORT: {
        uint16_t x;
        memcpy(&x, p, sizeof x);
        return normalized ? (float)x / 65535.0f : (float)x;
    }
    case PBNDS_GLTF_UINT: {
        uint32_t x;
        memcpy(&x, p, sizeof x);
        return (float)x;
    }
    default: {
        float x;
        memcpy(&x, p, sizeof x);
        return x;
    }
    }
}

static uint32_t component_uint(const uint8_t *p, int component)
{
    uint16_t s;
    uint32_t x;
    switch (component) {
    case PBNDS_GLTF_UBYTE:
        return p[0];
    case PBNDS_GLTF_USHORT:
        memcpy(&s, p, sizeof s);
        return s;
    default:
        memcpy(&x, p, sizeof x);
        return x;
    }
}

static bool is_unsigned(int component)
{
    return component == PBNDS_GLTF_UBYTE || component == PBNDS_GLTF_USHORT ||
           component == PBNDS_GLTF_UINT;
}

/** Called once an element: `slot` of the output gets what lies at `from`. */
typedef void put_element(const struct pbnds_gltf_accessor *a, void *out, uint64_t slot,
                         const uint8_t *from);

static void put_floats(const struct pbnds_gltf_accessor *a, void *out, uint64_t slot,
                       const uint8_t *from)
{
    const uint64_t width = (uint64_t)a->width, size = component_size(a->component);
    float *to = (float *)out + slot * width;
    for (uint64_t i = 0; i < width; ++i) {
        to[i] = component_float(from + i * size, a->component, a->normalized);
    }
}

static void put_index(const struct pbnds_gltf_accessor *a, void *out, uint64_t slot,
                      const uint8_t *from)
{
    ((uint32_t *)out)[slot] = component_uint(from, a->component);
}

/** Some elements of an accessor, and what they are made of. */
struct part {
    const struct pbnds_gltf_accessor *accessor;
    const char *what;
    uint64_t first, count;
    put_element *put;
    void *out;
    size_t out_size; /* of all `count` */
};

/** Overwrites the elements that a sparse accessor lists. */
static enum pbnds_status read_sparse(struct pbnds_gltf_load_state *g,
                                     const struct part *p)
{
    const struct pbnds_gltf_accessor *a = p->accessor;
    const char *what = p->what;
    const int component = a->sparse_index_component;
    if (a->sparse_count < 0 || (uint64_t)a->sparse_count > a->count ||
        a->sparse_index_offset < 0 || a->sparse_value_offset < 0 ||
        !is_unsigned(component)) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: the sparse accessor of %s is not valid", g->name, what);
    }
    const uint64_t count = (uint64_t)a->sparse_count;
    struct range indices, values;
    PBNDS_TRY(range_of(g, what, a->sparse_index_view, (uint64_t)a->sparse_index_offset,
                       count, component_size(component), false, &indices));
    PBNDS_TRY(range_of(g, what, a->sparse_value_view, (uint64_t)a->sparse_value_offset,
                       count, pbnds_gltf_element_size(a), false, &values));
    for (uint64_t i = 0; i < count; ++i) {
        const uint32_t slot =
            component_uint(indices.data + i * indices.stride, component);
        if (slot >= a->count) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: the sparse accessor of %s has index %u of %llu",
                              g->name, what, slot, (unsigned long long)a->count);
        }
        if (slot < p->first || slot - p->first >= p->count) continue;
        p->put(a, p->out, slot - p->first, values.data + i * values.stride);
    }
    return PBNDS_OK;
}

static enum pbnds_status read_part(struct pbnds_gltf_load_state *g,
                                   const struct part *p)
{
    const struct pbnds_gltf_accessor *a = p->accessor;
    const uint64_t overwritten =
        a->sparse && a->sparse_count > 0 ? (uint64_t)a->sparse_count : 0;
    PBNDS_TRY(pbnds_gltf_work(g, p->count + overwritten, pbnds_gltf_element_size(a)));
    if (a->view >= 0 || a->unpacked) {
        struct range r = {a->unpacked, pbnds_gltf_element_size(a)};
        if (!a->unpacked) {
            PBNDS_TRY(range_of(g, p->what, a->view, a->offset, a->count,
                               pbnds_gltf_element_size(a), true, &r));
        }
        for (uint64_t i = 0; i < p->count; ++i)
            p->put(a, p->out, i, r.data + (p->first + i) * r.stride);
    } else {
        memset(p->out, 0, p->out_size);
    }
    return a->sparse ? read_sparse(g, p) : PBNDS_OK;
}

enum pbnds_status pbnds_gltf_read_some(struct pbnds_gltf_load_state *g,
                                       const struct pbnds_gltf_accessor *a,
                                       const char *what, uint64_t first, uint64_t count,
                                       float *out)
{
    const size_t total = (size_t)count * (size_t)a->width;
    const struct part part = {
        a, what, first, count, put_floats, out, total * sizeof *out};
    PBNDS_TRY(read_part(g, &part));
    for (size_t i = 0; i < total; ++i) {
        if (!isfinite(out[i])) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: %s has a value that is not finite (element %zu)",
                              g->name, what, (size_t)first + i / (size_t)a->width);
        }
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_read_floats(struct pbnds_gltf_load_state *g,
                                         const struct pbnds_gltf_accessor *a,
                                         const char *what, float *out)
{
    return pbnds_gltf_read_some(g, a, what, 0, a->count, out);
}

enum pbnds_status pbnds_gltf_read_indices(struct pbnds_gltf_load_state *g,
                                          const struct pbnds_gltf_accessor *a,
                                          uint64_t limit, uint32_t *out)
{
    if (!is_unsigned(a->component) || a->normalized) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: indices are not of an unsigned integer type", g->name);
    }
    const struct part part = {
        a, "indices", 0, a->count, put_index, out, (size_t)a->count * sizeof *out};
    PBNDS_TRY(read_part(g, &part));
    for (uint64_t i = 0; i < a->count; ++i) {
        if (out[i] >= limit) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: index %u is out of range, there are %llu vertices",
                              g->name, out[i], (unsigned long long)limit);
        }
    }
    return PBNDS_OK;
}
