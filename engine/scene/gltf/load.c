#include "engine/scene/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/scene/gltf/load.h"

void pbnds_gltf_name(char out[64], const char *name, const char *what, size_t index)
{
    if (!name[0]) {
        (void)snprintf(out, 64, "%s %zu", what, index);
        return;
    }
    size_t size = strlen(name);
    if (size > 63) {
        size = 63;
        while (size && ((unsigned char)name[size] & 0xc0u) == 0x80u)
            --size;
    }
    memcpy(out, name, size);
    out[size] = 0;
}

static enum pbnds_status check_version(struct pbnds_gltf_load_state *g)
{
    const struct pbnds_gltf_document *d = &g->doc;
    if (d->version[0] < '0' || d->version[0] > '9') {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT, "%s: names no glTF version",
                          g->name);
    }
    const bool newer = d->min_version[0] && strcmp(d->min_version, "2.0") != 0;
    if (strncmp(d->version, "2.", 2) != 0 || newer) {
        return pbnds_fail(g->error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: is glTF %.16s, only version 2.0 can be read", g->name,
                          newer ? d->min_version : d->version);
    }
    return PBNDS_OK;
}

/** A node's own transform: 16 numbers, or translation, rotation and scale. */
static enum pbnds_status local_transform(struct pbnds_gltf_load_state *g, size_t index,
                                         struct pbnds_mat4 *out)
{
    const struct pbnds_gltf_node *n = &g->doc.nodes[index];
    const bool fine = (n->matrix_count == 0 || n->matrix_count == 16) &&
                      (n->translation_count == 0 || n->translation_count == 3) &&
                      (n->rotation_count == 0 || n->rotation_count == 4) &&
                      (n->scale_count == 0 || n->scale_count == 3);
    if (!fine) {
        return pbnds_fail(
            g->error, PBNDS_ERROR_FORMAT,
            "%s: the transform of node %zu has the wrong number of values", g->name,
            index);
    }
    if (n->matrix_count) {
        for (int i = 0; i < 16; ++i)
            out->m[i] = (float)n->matrix[i];
        return PBNDS_OK;
    }
    const double *t = n->translation, *q = n->rotation, *s = n->scale;
    struct pbnds_vec3 translation = {0, 0, 0}, scale = {1, 1, 1};
    struct pbnds_vec4 rotation = {0, 0, 0, 1};
    if (n->translation_count) {
        translation = pbnds_vec3_make((float)t[0], (float)t[1], (float)t[2]);
    }
    if (n->scale_count) scale = pbnds_vec3_make((float)s[0], (float)s[1], (float)s[2]);
    if (n->rotation_count) {
        const double length =
            sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (length > 0.0) {
            rotation =
                (struct pbnds_vec4){(float)(q[0] / length), (float)(q[1] / length),
                                    (float)(q[2] / length), (float)(q[3] / length)};
        }
    }
    *out = pbnds_mat4_from_trs(translation, rotation, scale);
    return PBNDS_OK;
}

/** parent[child] for every node; a child has one parent (glTF 2.0, section 3.5.2). */
static enum pbnds_status find_parents(struct pbnds_gltf_load_state *g, int64_t *parent)
{
    const struct pbnds_gltf_document *d = &g->doc;
    for (size_t i = 0; i < d->node_count; ++i)
        parent[i] = -1;
    for (size_t i = 0; i < d->node_count; ++i) {
        for (size_t k = 0; k < d->nodes[i].child_count; ++k) {
            const int child = d->nodes[i].children[k];
            if (child < 0 || (size_t)child >= d->node_count) {
                return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                                  "%s: node %zu has child %d, which does not exist",
                                  g->name, i, child);
            }
            if (parent[child] >= 0) {
                return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                                  "%s: node %d has more than one parent", g->name,
                                  child);
            }
            parent[child] = (int64_t)i;
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status find_roots(struct pbnds_gltf_load_state *g,
                                    const int64_t *parent, bool *root)
{
    const struct pbnds_gltf_document *d = &g->doc;
    if (d->scene_count == 0) {
        for (size_t i = 0; i < d->node_count; ++i)
            root[i] = parent[i] < 0;
        return PBNDS_OK;
    }
    const int64_t scene = d->scene < 0 ? 0 : d->scene;
    for (size_t i = 0; i < d->scenes[scene].count; ++i) {
        const int node = d->scenes[scene].items[i];
        if (node < 0 || (size_t)node >= d->node_count || parent[node] >= 0) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: scene %lld lists node %d, which is not a root node",
                              g->name, (long long)scene, node);
        }
        root[node] = true;
    }
    return PBNDS_OK;
}

/** Walks down from every root, without recursion: world transforms of all nodes (joints
 * may lie outside of the scene). A node that no root leads to is in a cycle. */
static enum pbnds_status walk(struct pbnds_gltf_load_state *g, const int64_t *parent,
                              const bool *root, size_t *stack)
{
    const struct pbnds_gltf_document *d = &g->doc;
    size_t depth = 0, visited = 0;
    for (size_t i = 0; i < d->node_count; ++i) {
        if (parent[i] < 0) stack[depth++] = i;
    }
    while (depth > 0) {
        const size_t i = stack[--depth];
        struct pbnds_mat4 local;
        PBNDS_TRY(local_transform(g, i, &local));
        ++visited;
        g->in_scene[i] = parent[i] < 0 ? root[i] : g->in_scene[parent[i]];
        g->world[i] =
            parent[i] < 0 ? local : pbnds_mat4_mul(&g->world[parent[i]], &local);
        for (size_t k = 0; k < d->nodes[i].child_count; ++k) {
            stack[depth++] = (size_t)d->nodes[i].children[k];
        }
    }
    if (visited < d->node_count) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: its nodes are not a tree, some are their own ancestors",
                          g->name);
    }
    return PBNDS_OK;
}

static enum pbnds_status place_nodes(struct pbnds_gltf_load_state *g)
{
    const size_t count = g->doc.node_count;
    int64_t *parent = calloc(count + 1, sizeof *parent);
    size_t *stack = calloc(count + 1, sizeof *stack); /* each node is pushed once */
    bool *root = calloc(count + 1, sizeof *root);
    g->world = calloc(count + 1, sizeof *g->world);
    g->in_scene = calloc(count + 1, sizeof *g->in_scene);
    enum pbnds_status status = PBNDS_OK;
    if (!parent || !stack || !root || !g->world || !g->in_scene) {
        status = pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for nodes",
                            g->name);
    }
    if (status == PBNDS_OK) status = find_parents(g, parent);
    if (status == PBNDS_OK) status = find_roots(g, parent, root);
    if (status == PBNDS_OK) status = walk(g, parent, root, stack);
    free(parent);
    free(stack);
    free(root);
    return status;
}

/** Rotation and translation of a transform: scale, shear and mirroring do not move the
 *  image plane (glTF 2.0, section 3.10.1). */
static struct pbnds_mat4 rigid(const struct pbnds_mat4 *m)
{
    struct pbnds_mat4 out = pbnds_mat4_identity();
    struct pbnds_vec3 z = {m->m[8], m->m[9], m->m[10]}, y = {m->m[4], m->m[5], m->m[6]};
    if (pbnds_length(z) > 0.0f)
        z = pbnds_normalize(z);
    else
        z = pbnds_vec3_make(0, 0, 1);
    y = pbnds_mad(y, z, -pbnds_dot(y, z));
    if (pbnds_length(y) > 0.0f)
        y = pbnds_normalize(y);
    else
        y = pbnds_frame_from_normal(z).b;
    const struct pbnds_vec3 x = pbnds_cross(y, z);
    const struct pbnds_vec3 columns[3] = {x, y, z};
    for (int c = 0; c < 3; ++c) {
        out.m[4 * c] = columns[c].x;
        out.m[4 * c + 1] = columns[c].y;
        out.m[4 * c + 2] = columns[c].z;
        out.m[12 + c] = m->m[12 + c];
    }
    return out;
}

static enum pbnds_status add_camera(struct pbnds_gltf_load_state *g, size_t node)
{
    const struct pbnds_gltf_node *n = &g->doc.nodes[node];
    const struct pbnds_gltf_camera *source = &g->doc.cameras[n->camera];
    struct pbnds_camera *c = &g->scene->cameras[g->scene->camera_count];
    pbnds_gltf_name(c->name, source->name[0] ? source->name : n->name, "camera",
                    (size_t)g->scene->camera_count);
    c->world_from_camera = rigid(&g->world[node]);
    c->orthographic = source->orthographic;
    c->yfov = (float)source->yfov;
    c->ymag = (float)fabs(source->ymag);
    const bool fine = c->orthographic ? c->ymag > 0.0f && isfinite(c->ymag)
                                      : c->yfov > 0.0f && c->yfov < PBNDS_PI;
    bool finite = true;
    for (int i = 0; i < 16; ++i)
        finite = finite && isfinite(c->world_from_camera.m[i]);
    if (!fine || !finite) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: the camera of node %zu has no valid %s", g->name, node,
                          !finite ? "place" : (c->orthographic ? "ymag" : "yfov"));
    }
    ++g->scene->camera_count;
    return PBNDS_OK;
}

/** What the vertices and indices of a mesh take at least, once for each of its nodes.
 */
static uint64_t least_size(const struct pbnds_gltf_document *d, int64_t mesh)
{
    uint64_t size = 0;
    for (size_t i = 0; i < d->meshes[mesh].primitive_count; ++i) {
        const struct pbnds_gltf_primitive *p = &d->meshes[mesh].primitives[i];
        const uint64_t vertices = p->position < 0 ? 0 : d->accessors[p->position].count;
        const uint64_t indices = p->indices < 0 ? 0 : d->accessors[p->indices].count;
        size += (vertices < UINT32_MAX ? vertices : UINT32_MAX) * 12;
        size += (indices < UINT32_MAX ? indices : UINT32_MAX) * 4;
    }
    return size;
}

/** Room for every mesh and camera that the scene can have. Instances are copies: a
 * small file that asks for much is refused before anything is built. */
static enum pbnds_status make_room(struct pbnds_gltf_load_state *g)
{
    uint64_t meshes = 0, cameras = 0, size = 0;
    for (size_t i = 0; i < g->doc.node_count; ++i) {
        const int64_t mesh = g->doc.nodes[i].mesh;
        if (!g->in_scene[i]) continue;
        if (mesh >= 0) meshes += g->doc.meshes[mesh].primitive_count;
        if (mesh >= 0 && size <= PBNDS_GLTF_MAX_GEOMETRY)
            size += least_size(&g->doc, mesh);
        if (g->doc.nodes[i].camera >= 0) ++cameras;
    }
    if (meshes > (1u << 24) || size > PBNDS_GLTF_MAX_GEOMETRY) {
        return pbnds_fail(g->error, PBNDS_ERROR_MEMORY,
                          "%s: its geometry takes more than 8 GiB or 2^24 meshes",
                          g->name);
    }
    g->scene->meshes = calloc((size_t)meshes + 1, sizeof *g->scene->meshes);
    g->scene->cameras = calloc((size_t)cameras + 1, sizeof *g->scene->cameras);
    if (!g->scene->meshes || !g->scene->cameras) {
        return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for meshes",
                          g->name);
    }
    return PBNDS_OK;
}

static enum pbnds_status fill_scene(struct pbnds_gltf_load_state *g)
{
    PBNDS_TRY(make_room(g));
    for (size_t i = 0; i < g->doc.node_count; ++i) {
        if (!g->in_scene[i]) continue;
        if (g->doc.nodes[i].camera >= 0) PBNDS_TRY(add_camera(g, i));
        if (g->doc.nodes[i].mesh >= 0) PBNDS_TRY(pbnds_gltf_node_meshes(g, i));
        if (pbnds_stop_requested()) return pbnds_fail_interrupted(g->error);
    }
    return PBNDS_OK;
}

static void measure(struct pbnds_scene *scene)
{
    bool first = true;
    for (int i = 0; i < scene->mesh_count; ++i) {
        const struct pbnds_mesh *m = &scene->meshes[i];
        scene->triangle_count += m->triangle_count;
        for (size_t k = 0; k < m->vertex_count; ++k) {
            const struct pbnds_vec3 p = m->position[k];
            if (first) scene->lo = scene->hi = p;
            first = false;
            scene->lo =
                pbnds_vec3_make(fminf(scene->lo.x, p.x), fminf(scene->lo.y, p.y),
                                fminf(scene->lo.z, p.z));
            scene->hi =
                pbnds_vec3_make(fmaxf(scene->hi.x, p.x), fmaxf(scene->hi.y, p.y),
                                fmaxf(scene->hi.z, p.z));
        }
    }
}

static void tell(const struct pbnds_gltf_load_state *g)
{
    const struct pbnds_report *r = g->report;
    if (g->doc.notes[0]) pbnds_warn(r, "%s: %s", g->name, g->doc.notes);
    if (g->skipped_primitives) {
        pbnds_warn(r, "%s: %zu primitives of points, lines or no position are left out",
                   g->name, g->skipped_primitives);
    }
    if (g->doc.animation_count) {
        pbnds_warn(r, "%s: its animations are ignored, the rest pose is loaded",
                   g->name);
    }
    if (g->morphs) pbnds_warn(r, "%s: its morph targets are ignored", g->name);
    if (g->more_joints) {
        pbnds_warn(r, "%s: a vertex has more than four joints, four are used", g->name);
    }
    if (g->scene->triangle_count == 0) {
        pbnds_warn(r, "%s: has no triangles, only the background will be seen",
                   g->name);
    }
}

static enum pbnds_status load(struct pbnds_gltf_load_state *g)
{
    PBNDS_TRY(pbnds_gltf_scan(&g->source, g->error));
    PBNDS_TRY(pbnds_gltf_parse(g->source.json, g->source.json_size, g->name, &g->doc,
                               g->error));
    if (g->doc.buffer_count != g->source.buffer_count ||
        g->doc.image_count != g->source.image_count) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: its list of buffers or images is not valid", g->name);
    }
    PBNDS_TRY(check_version(g));
    PBNDS_TRY(pbnds_gltf_check_extensions(g));
    PBNDS_TRY(pbnds_gltf_check(g));
    PBNDS_TRY(pbnds_gltf_find_variant(g));
    PBNDS_TRY(place_nodes(g));
    PBNDS_TRY(pbnds_gltf_materials(g));
    PBNDS_TRY(pbnds_gltf_unpack_meshes(g));
    PBNDS_TRY(fill_scene(g));
    measure(g->scene);
    tell(g);
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_load_memory(const void *bytes, size_t size,
                                         const char *name, const char *folder,
                                         const struct pbnds_gltf_options *options,
                                         const struct pbnds_report *report,
                                         struct pbnds_scene *scene,
                                         struct pbnds_error *error)
{
    static const struct pbnds_gltf_options defaults = {0};
    struct pbnds_gltf_load_state g = {.name = name,
                                      .options = options ? options : &defaults,
                                      .report = report,
                                      .error = error,
                                      .scene = scene};
    *scene = (struct pbnds_scene){0};
    enum pbnds_status status =
        pbnds_gltf_source_open(&g.source, bytes, size, name, folder, g.options, error);
    if (status == PBNDS_OK) status = load(&g);
    pbnds_gltf_free_unpacked(&g);
    pbnds_gltf_document_free(&g.doc);
    pbnds_gltf_source_free(&g.source);
    free(g.world);
    free(g.in_scene);
    if (status != PBNDS_OK) pbnds_scene_free(scene);
    return status;
}

/** The folder part of a path, malloc'd; "." when it has none. */
static char *folder_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    size_t size = slash ? (size_t)(slash - path) : 1;
    if (slash == path) size = 1;
    char *folder = malloc(size + 1);
    if (folder) {
        memcpy(folder, slash ? path : ".", size);
        folder[size] = 0;
    }
    return folder;
}

enum pbnds_status pbnds_gltf_load(const char *path,
                                  const struct pbnds_gltf_options *options,
                                  const struct pbnds_report *report,
                                  struct pbnds_scene *scene, struct pbnds_error *error)
{
    uint8_t *bytes = NULL;
    size_t size = 0;
    *scene = (struct pbnds_scene){0};
    static const struct pbnds_gltf_options defaults = {0};
    const size_t most = pbnds_gltf_max_file(options ? options : &defaults);
    PBNDS_TRY(pbnds_file_read(path, most, &bytes, &size, error));
    char *folder = folder_of(path);
    const enum pbnds_status status =
        folder ? pbnds_gltf_load_memory(bytes, size, path, folder, options, report,
                                        scene, error)
               : pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    free(folder);
    free(bytes);
    return status;
}
