/*
 * Compressed geometry made plain: bufferViews of EXT_meshopt_compression when they are
 * read, primitives of KHR_draco_mesh_compression before anything reads them.
 */
#include <stdlib.h>

#include "engine/scene/gltf/draco.h"
#include "engine/scene/gltf/load.h"
#include "engine/scene/gltf/meshopt.h"

/** malloc of what has been charged; never NULL on success. */
static enum pbnds_status make_room(struct pbnds_gltf_load_state *g, uint64_t bytes,
                                   uint8_t **out)
{
    PBNDS_TRY(pbnds_gltf_charge(g, bytes, 1));
    *out = calloc((size_t)bytes + 1, 1);
    if (*out) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for its geometry",
                      g->name);
}

/* ---- EXT_meshopt_compression --------------------------------------------------- */

static enum pbnds_status bad_view(struct pbnds_gltf_load_state *g, size_t view,
                                  const char *fault)
{
    return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                      "%s: the EXT_meshopt_compression of bufferView %zu has %s",
                      g->name, view, fault);
}

static enum pbnds_status check_view(struct pbnds_gltf_load_state *g, size_t index)
{
    const struct pbnds_gltf_view *v = &g->doc.views[index];
    const struct pbnds_gltf_meshopt *m = &v->meshopt;
    if (m->buffer < 0 || (uint64_t)m->buffer >= g->doc.buffer_count) {
        return bad_view(g, index, "no buffer");
    }
    const uint64_t size = g->source.buffers[m->buffer].byte_length;
    if (m->offset < 0 || m->length < 0 || (uint64_t)m->offset > size ||
        (uint64_t)m->length > size - (uint64_t)m->offset) {
        return bad_view(g, index, "a range beyond its buffer");
    }
    /* Below 2^53 and 2^9: the product fits. */
    if (m->count < 0 || m->stride <= 0 || m->stride > 256 ||
        (uint64_t)m->count * (uint64_t)m->stride != v->length) {
        return bad_view(g, index, "a byteStride and count that are not its size");
    }
    if (v->stride && v->stride != (uint64_t)m->stride) {
        return bad_view(g, index, "another byteStride than the view");
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_unpack_view(struct pbnds_gltf_load_state *g, int64_t index)
{
    struct pbnds_gltf_view *v = &g->doc.views[index];
    const struct pbnds_gltf_meshopt *m = &v->meshopt;
    const uint8_t *bytes = NULL;
    if (v->unpacked) return PBNDS_OK;
    PBNDS_TRY(pbnds_gltf_buffer_bytes(g, m->buffer, (uint64_t)m->offset,
                                      (uint64_t)m->length, &bytes));
    PBNDS_TRY(make_room(g, v->length, &v->unpacked));
    const char *fault =
        pbnds_meshopt_decode(m->mode, m->filter, bytes, (size_t)m->length,
                             (size_t)m->count, (size_t)m->stride, v->unpacked);
    if (!fault) return PBNDS_OK;
    free(v->unpacked);
    v->unpacked = NULL;
    return bad_view(g, (size_t)index, fault);
}

/* ---- KHR_draco_mesh_compression ------------------------------------------------ */

static enum pbnds_status check_draco(struct pbnds_gltf_load_state *g,
                                     const struct pbnds_gltf_draco *d)
{
    if (d->view >= 0 && (uint64_t)d->view < g->doc.view_count) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                      "%s: the KHR_draco_mesh_compression of mesh %lld refers to a "
                      "bufferView that does not exist",
                      g->name, (long long)d->mesh);
}

enum pbnds_status pbnds_gltf_check_packed(struct pbnds_gltf_load_state *g)
{
    for (size_t i = 0; i < g->doc.view_count; ++i) {
        if (g->doc.views[i].meshopt.present) PBNDS_TRY(check_view(g, i));
    }
    for (size_t i = 0; i < g->doc.draco_count; ++i) {
        PBNDS_TRY(check_draco(g, &g->doc.dracos[i]));
    }
    return PBNDS_OK;
}

/** Fills an accessor with what the mesh has for it. */
static enum pbnds_status fill_accessor(struct pbnds_gltf_load_state *g,
                                       const struct pbnds_gltf_draco *d,
                                       const struct pbnds_draco *mesh, bool indices,
                                       struct pbnds_gltf_accessor *a)
{
    const uint64_t element = pbnds_gltf_element_size(a);
    if (indices) a->count = 3 * pbnds_draco_triangles(mesh);
    if (element == 0 || (indices && a->width != 1)) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: an accessor of the Draco mesh %lld has the wrong type",
                          g->name, (long long)d->mesh);
    }
    PBNDS_TRY(make_room(g, a->count * element, &a->unpacked));
    const bool fits = indices ? pbnds_draco_indices(mesh, (size_t)element, a->unpacked)
                              : pbnds_draco_attribute(mesh, a->draco_id, a->width,
                                                      a->component, a->unpacked);
    if (fits) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                      "%s: the Draco data of mesh %lld do not fit the type of its "
                      "accessors",
                      g->name, (long long)d->mesh);
}

static enum pbnds_status unpack_mesh(struct pbnds_gltf_load_state *g,
                                     const struct pbnds_gltf_draco *d)
{
    struct pbnds_gltf_accessor *a = g->doc.accessors + d->first;
    struct pbnds_draco_limits limits = {UINT64_MAX, UINT64_MAX, 0};
    const uint8_t *bytes = NULL;
    uint64_t size = 0;
    for (size_t i = 1; i < d->count; ++i) {
        if (a[i].count != a[1].count) {
            return pbnds_fail(
                g->error, PBNDS_ERROR_FORMAT,
                "%s: the attributes of the Draco mesh %lld have different "
                "counts",
                g->name, (long long)d->mesh);
        }
    }
    if (d->count > 1) limits.vertices = a[1].count;
    if (d->counted) limits.triangles = a[0].count / 3;
    PBNDS_TRY(pbnds_gltf_view_bytes(g, d->view, "a Draco mesh", &bytes, &size));
    /* A mesh costs time even where it holds nothing: its bytes count too. */
    PBNDS_TRY(pbnds_gltf_charge(g, size, 1));
    limits.bytes = g->max_geometry - g->geometry_bytes;
    struct pbnds_draco *mesh = NULL;
    PBNDS_TRY(
        pbnds_draco_decode(bytes, (size_t)size, g->name, &limits, &mesh, g->error));
    enum pbnds_status status = PBNDS_OK;
    for (size_t i = 0; i < d->count && status == PBNDS_OK; ++i) {
        status = fill_accessor(g, d, mesh, i == 0, &a[i]);
    }
    pbnds_draco_free(mesh);
    return status;
}

enum pbnds_status pbnds_gltf_unpack_meshes(struct pbnds_gltf_load_state *g)
{
    if (g->doc.draco_count == 0) return PBNDS_OK;
    bool *used = calloc(g->doc.mesh_count + 1, sizeof *used);
    if (!used)
        return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory", g->name);
    for (size_t i = 0; i < g->doc.node_count; ++i) {
        const int64_t mesh = g->doc.nodes[i].mesh;
        if (g->in_scene[i] && mesh >= 0) used[mesh] = true;
    }
    enum pbnds_status status = PBNDS_OK;
    for (size_t i = 0; i < g->doc.draco_count && status == PBNDS_OK; ++i) {
        if (used[g->doc.dracos[i].mesh]) status = unpack_mesh(g, &g->doc.dracos[i]);
        if (status == PBNDS_OK && pbnds_stop_requested()) {
            status = pbnds_fail_interrupted(g->error);
        }
    }
    free(used);
    return status;
}

void pbnds_gltf_free_unpacked(struct pbnds_gltf_load_state *g)
{
    for (size_t i = 0; i < g->doc.view_count; ++i)
        free(g->doc.views[i].unpacked);
    for (size_t i = 0; i < g->doc.accessor_count; ++i)
        free(g->doc.accessors[i].unpacked);
}
