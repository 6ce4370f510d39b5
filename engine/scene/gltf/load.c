#include "engine/scene/gltf.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/scene/gltf/load.h"
#include "engine/scene/maps.h"
#include "engine/scene/packet.h"

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

enum pbnds_status pbnds_gltf_choose(struct pbnds_gltf_load_state *g, const char *wanted,
                                    const char *what, size_t count,
                                    pbnds_gltf_namer *name, size_t *chosen)
{
    for (size_t i = 0; wanted[0] && i < count; ++i) {
        char shown[64]; /* what pbnds_gltf_list() calls it */
        pbnds_gltf_name(shown, name(&g->doc, i), what, i);
        if (strcmp(shown, wanted) != 0 && strcmp(name(&g->doc, i), wanted) != 0)
            continue;
        *chosen = i;
        return PBNDS_OK;
    }
    char *end = NULL;
    errno = 0;
    const unsigned long long index = strtoull(wanted, &end, 10);
    if (wanted[0] >= '0' && wanted[0] <= '9' && !*end && !errno && index < count) {
        *chosen = (size_t)index;
        return PBNDS_OK;
    }
    return pbnds_fail(g->error, PBNDS_ERROR_ARGUMENT,
                      "%s: has no %s '%.100s', its %zu are listed by 'pbnds info'",
                      g->name, what, wanted, count);
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

static enum pbnds_status fill_scene(struct pbnds_gltf_load_state *g)
{
    PBNDS_TRY(pbnds_gltf_make_room(g));
    for (size_t i = 0; i < g->doc.node_count; ++i) {
        const struct pbnds_gltf_node *n = &g->doc.nodes[i];
        pbnds_gltf_name(g->scene->objects[i].name, n->name, "node", i);
        ++g->scene->object_count;
        if (!g->in_scene[i]) continue;
        if (n->camera >= 0) PBNDS_TRY(pbnds_gltf_add_camera(g, i));
        if (n->light >= 0) PBNDS_TRY(pbnds_gltf_add_light(g, i));
        if (n->mesh >= 0) PBNDS_TRY(pbnds_gltf_node_meshes(g, i));
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
    if (g->skinned_instances) {
        pbnds_warn(r, "%s: a skinned mesh has instances, only one is shown", g->name);
    }
    if (g->matrix_animated) {
        pbnds_warn(r, "%s: an animated node has a matrix, which stays as it is",
                   g->name);
    }
    if (g->scene->triangle_count == 0) {
        pbnds_warn(r, "%s: has no triangles, only the background will be seen",
                   g->name);
    }
}

/** What all geometry of a scene may take unless the caller says else. */
#define PBNDS_GLTF_MAX_GEOMETRY ((uint64_t)8 << 30)

enum pbnds_status pbnds_gltf_open(struct pbnds_gltf_load_state *g, const void *bytes,
                                  size_t size, const char *folder)
{
    static const struct pbnds_gltf_options defaults = {0};
    if (!g->options) g->options = &defaults;
    g->max_geometry =
        g->options->max_geometry ? g->options->max_geometry : PBNDS_GLTF_MAX_GEOMETRY;
    PBNDS_TRY(pbnds_gltf_source_open(&g->source, bytes, size, g->name, folder,
                                     g->options, g->error));
    PBNDS_TRY(pbnds_gltf_scan(&g->source, g->error));
    PBNDS_TRY(pbnds_gltf_parse(g->source.json, g->source.json_size, g->name, &g->doc,
                               g->error));
    if (g->doc.buffer_count != g->source.buffer_count ||
        g->doc.image_count != g->source.image_count) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: its list of buffers or images is not valid", g->name);
    }
    PBNDS_TRY(check_version(g));
    if (g->source.odd_list) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: is not valid glTF: one of its lists is not an array",
                          g->name);
    }
    PBNDS_TRY(pbnds_gltf_check_extensions(g));
    return pbnds_gltf_check(g);
}

void pbnds_gltf_close(struct pbnds_gltf_load_state *g)
{
    pbnds_gltf_free_unpacked(g);
    pbnds_gltf_free_joints(g); /* before the document, which counts them */
    pbnds_gltf_document_free(&g->doc);
    pbnds_gltf_source_free(&g->source);
    free(g->pose[0].world);
    free(g->pose[1].world);
    free(g->weights_channel);
    free(g->in_scene);
}

static enum pbnds_status load(struct pbnds_gltf_load_state *g)
{
    PBNDS_TRY(pbnds_gltf_find_variant(g));
    PBNDS_TRY(pbnds_gltf_choose_animation(g));
    PBNDS_TRY(pbnds_gltf_place_nodes(g));
    PBNDS_TRY(pbnds_gltf_materials(g));
    PBNDS_TRY(pbnds_gltf_unpack_meshes(g));
    PBNDS_TRY(fill_scene(g));
    measure(g->scene);
    PBNDS_TRY(pbnds_scene_pack(g->scene, g->error));
    PBNDS_TRY(pbnds_scene_prefilter(g->scene, g->options->max_images, g->error));
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
    struct pbnds_gltf_load_state g = {.name = name,
                                      .options = options,
                                      .report = report,
                                      .error = error,
                                      .scene = scene};
    *scene = (struct pbnds_scene){0};
    enum pbnds_status status = pbnds_gltf_open(&g, bytes, size, folder);
    if (status == PBNDS_OK) status = load(&g);
    pbnds_gltf_close(&g);
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

enum pbnds_status pbnds_gltf_read_file(const char *path,
                                       const struct pbnds_gltf_options *options,
                                       struct pbnds_gltf_file *file,
                                       struct pbnds_error *error)
{
    static const struct pbnds_gltf_options defaults = {0};
    *file = (struct pbnds_gltf_file){0};
    const size_t most = pbnds_gltf_max_file(options ? options : &defaults);
    PBNDS_TRY(pbnds_file_read(path, most, &file->bytes, &file->size, error));
    file->folder = folder_of(path);
    if (file->folder) return PBNDS_OK;
    pbnds_gltf_file_free(file);
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
}

void pbnds_gltf_file_free(struct pbnds_gltf_file *file)
{
    free(file->bytes);
    free(file->folder);
    *file = (struct pbnds_gltf_file){0};
}

enum pbnds_status pbnds_gltf_load(const char *path,
                                  const struct pbnds_gltf_options *options,
                                  const struct pbnds_report *report,
                                  struct pbnds_scene *scene, struct pbnds_error *error)
{
    struct pbnds_gltf_file file;
    *scene = (struct pbnds_scene){0};
    PBNDS_TRY(pbnds_gltf_read_file(path, options, &file, error));
    const enum pbnds_status status = pbnds_gltf_load_memory(
        file.bytes, file.size, path, file.folder, options, report, scene, error);
    pbnds_gltf_file_free(&file);
    return status;
}
