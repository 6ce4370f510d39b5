#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"

/* A primitive as the file has it: attributes, and a list of triangles. */

enum pbnds_status pbnds_gltf_no_memory(struct pbnds_gltf_load_state *g)
{
    return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for its geometry",
                      g->name);
}

enum pbnds_status pbnds_gltf_read_attribute(struct pbnds_gltf_build *b,
                                            int64_t accessor, int width,
                                            const char *what, float **out)
{
    struct pbnds_gltf_load_state *g = b->g;
    const struct pbnds_gltf_accessor *a = NULL;
    *out = NULL;
    if (accessor < 0) return PBNDS_OK;
    PBNDS_TRY(pbnds_gltf_accessor_at(g, accessor, width, what, &a));
    if (a->count != b->file_vertices) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: %s has %llu elements for %zu vertices", g->name, what,
                          (unsigned long long)a->count, b->file_vertices);
    }
    PBNDS_TRY(pbnds_gltf_charge(g, a->count, sizeof(float) * (uint64_t)width));
    float *data = calloc((size_t)a->count * (size_t)width + 1, sizeof *data);
    if (!data) return pbnds_gltf_no_memory(g);
    const enum pbnds_status status = pbnds_gltf_read_floats(g, a, what, data);
    if (status != PBNDS_OK) {
        free(data);
        return status;
    }
    *out = data;
    return PBNDS_OK;
}

/** COLOR_0 has three components or four. */
static enum pbnds_status read_color(struct pbnds_gltf_build *b)
{
    const int64_t index = b->primitive->color;
    const bool rgb = index >= 0 && b->g->doc.accessors[index].width == 3;
    struct pbnds_mesh *m = &b->mesh;
    float *data = NULL;
    PBNDS_TRY(pbnds_gltf_read_attribute(b, index, rgb ? 3 : 4, "COLOR_0", &data));
    if (!rgb) {
        m->color = (struct pbnds_vec4 *)(void *)data;
        return PBNDS_OK;
    }
    enum pbnds_status status =
        pbnds_gltf_charge(b->g, m->vertex_count, sizeof *m->color);
    if (status == PBNDS_OK) {
        m->color = malloc((m->vertex_count + 1) * sizeof *m->color);
        if (!m->color) status = pbnds_gltf_no_memory(b->g);
    }
    for (size_t i = 0; m->color && i < m->vertex_count; ++i) {
        const float *c = data + 3 * i;
        m->color[i] = (struct pbnds_vec4){c[0], c[1], c[2], 1.0f};
    }
    free(data);
    pbnds_gltf_refund(b->g, m->vertex_count, 3 * sizeof *data);
    return status;
}

/* The vector types are plain floats in order: an array of them is read as floats. */
_Static_assert(sizeof(struct pbnds_vec2) == 8, "pbnds_vec2 has padding");
_Static_assert(sizeof(struct pbnds_vec3) == 12, "pbnds_vec3 has padding");
_Static_assert(sizeof(struct pbnds_vec4) == 16, "pbnds_vec4 has padding");

enum pbnds_status pbnds_gltf_read_vertices(struct pbnds_gltf_build *b)
{
    const struct pbnds_gltf_primitive *p = b->primitive;
    struct pbnds_mesh *m = &b->mesh;
    const struct pbnds_gltf_accessor *a = NULL;
    PBNDS_TRY(pbnds_gltf_accessor_at(b->g, p->position, 3, "POSITION", &a));
    if (a->count > UINT32_MAX) {
        return pbnds_fail(b->g->error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: a mesh has more than 2^32 vertices", b->g->name);
    }
    b->file_vertices = m->vertex_count = (size_t)a->count;
    float *data = NULL;
    PBNDS_TRY(pbnds_gltf_read_attribute(b, p->position, 3, "POSITION", &data));
    m->position = (struct pbnds_vec3 *)(void *)data;
    PBNDS_TRY(pbnds_gltf_read_attribute(b, p->normal, 3, "NORMAL", &data));
    m->normal = (struct pbnds_vec3 *)(void *)data;
    /* Without normals faces are flat, and tangents mean nothing: section 3.7.2.1. */
    PBNDS_TRY(
        pbnds_gltf_read_attribute(b, m->normal ? p->tangent : -1, 4, "TANGENT", &data));
    m->tangent = (struct pbnds_vec4 *)(void *)data;
    for (int set = 0; set < 2; ++set) {
        PBNDS_TRY(pbnds_gltf_read_attribute(b, p->uv[set], 2,
                                            set ? "TEXCOORD_1" : "TEXCOORD_0", &data));
        m->uv[set] = (struct pbnds_vec2 *)(void *)data;
    }
    return read_color(b);
}

/** Writes a triangle of a strip or fan unless it has no area by construction. */
static void emit(struct pbnds_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    if (a == b || b == c || c == a) return;
    uint32_t *out = m->index + 3 * m->triangle_count++;
    out[0] = a;
    out[1] = b;
    out[2] = c;
}

/** Makes a list of triangles of the primitive's indices; glTF 2.0, section 3.7.2.1. */
static void make_triangles(struct pbnds_mesh *m, int mode, const uint32_t *index,
                           size_t count)
{
    if (mode == PBNDS_GLTF_TRIANGLES) {
        m->triangle_count = count / 3;
        memcpy(m->index, index, m->triangle_count * 3 * sizeof *index);
        return;
    }
    for (size_t i = 0; i + 2 < count; ++i) {
        if (mode == PBNDS_GLTF_STRIP)
            emit(m, index[i], index[i + 1 + i % 2], index[i + 2 - i % 2]);
        else
            emit(m, index[i + 1], index[i + 2], index[0]);
    }
}

enum pbnds_status pbnds_gltf_read_triangles(struct pbnds_gltf_build *b)
{
    struct pbnds_gltf_load_state *g = b->g;
    const struct pbnds_gltf_accessor *a = NULL;
    uint64_t count = b->mesh.vertex_count;
    if (b->primitive->indices >= 0) {
        PBNDS_TRY(pbnds_gltf_accessor_at(g, b->primitive->indices, 1, "indices", &a));
        count = a->count;
    }
    const int mode = b->primitive->mode;
    const uint64_t room = mode == PBNDS_GLTF_TRIANGLES ? count : 3 * count;
    if (count > UINT32_MAX) {
        return pbnds_fail(g->error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: a mesh has more than 2^32 indices", g->name);
    }
    PBNDS_TRY(pbnds_gltf_charge(g, room, sizeof(uint32_t)));
    uint32_t *index = calloc((size_t)count + 1, sizeof *index);
    b->mesh.index = calloc((size_t)room + 1, sizeof *index);
    if (!index || !b->mesh.index) {
        free(index);
        return pbnds_gltf_no_memory(g);
    }
    enum pbnds_status status = PBNDS_OK;
    if (a) {
        status = pbnds_gltf_read_indices(g, a, b->mesh.vertex_count, index);
    } else {
        for (size_t i = 0; i < count; ++i)
            index[i] = (uint32_t)i;
    }
    if (status == PBNDS_OK) make_triangles(&b->mesh, mode, index, (size_t)count);
    free(index);
    return status;
}
