#include <stdlib.h>

#include "engine/scene/gltf/load.h"

/** A list of `count` empty items. */
static enum pbnds_status make_list(struct pbnds_gltf_load_state *g, size_t count,
                                   struct pbnds_gltf_item **list)
{
    *list = calloc(count + 1, sizeof **list);
    return *list ? PBNDS_OK
                 : pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory", g->name);
}

static enum pbnds_status list_scenes(struct pbnds_gltf_load_state *g,
                                     struct pbnds_gltf_contents *c)
{
    const struct pbnds_gltf_document *d = &g->doc;
    PBNDS_TRY(make_list(g, d->scene_count, &c->scenes));
    c->scene_count = d->scene_count;
    c->default_scene = d->scene < 0 ? 0 : (size_t)d->scene;
    for (size_t i = 0; i < d->scene_count; ++i) {
        pbnds_gltf_name(c->scenes[i].name, d->scenes[i].name, "scene", i);
        c->scenes[i].count = d->scenes[i].nodes.count;
    }
    return PBNDS_OK;
}

static enum pbnds_status list_animations(struct pbnds_gltf_load_state *g,
                                         struct pbnds_gltf_contents *c)
{
    const struct pbnds_gltf_document *d = &g->doc;
    PBNDS_TRY(make_list(g, d->animation_count, &c->animations));
    c->animation_count = d->animation_count;
    for (size_t i = 0; i < d->animation_count; ++i) {
        const struct pbnds_gltf_animation *a = &d->animations[i];
        pbnds_gltf_name(c->animations[i].name, a->name, "animation", i);
        c->animations[i].count = a->channel_count;
        PBNDS_TRY(pbnds_gltf_animation_end(g, a, &c->animations[i].seconds));
    }
    return PBNDS_OK;
}

static enum pbnds_status list_the_rest(struct pbnds_gltf_load_state *g,
                                       struct pbnds_gltf_contents *c)
{
    const struct pbnds_gltf_document *d = &g->doc;
    PBNDS_TRY(make_list(g, d->variant_count, &c->variants));
    PBNDS_TRY(make_list(g, d->skin_count, &c->skins));
    c->variant_count = d->variant_count;
    c->skin_count = d->skin_count;
    for (size_t i = 0; i < d->variant_count; ++i)
        pbnds_gltf_name(c->variants[i].name, d->variants[i], "variant", i);
    for (size_t i = 0; i < d->skin_count; ++i) {
        pbnds_gltf_name(c->skins[i].name, d->skins[i].name, "skin", i);
        c->skins[i].count = d->skins[i].joints.count;
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_list(const char *path,
                                  const struct pbnds_gltf_options *options,
                                  struct pbnds_gltf_contents *contents,
                                  struct pbnds_error *error)
{
    struct pbnds_gltf_file file;
    struct pbnds_gltf_load_state g = {.name = path, .options = options, .error = error};
    *contents = (struct pbnds_gltf_contents){0};
    PBNDS_TRY(pbnds_gltf_read_file(path, options, &file, error));
    enum pbnds_status status = pbnds_gltf_open(&g, file.bytes, file.size, file.folder);
    if (status == PBNDS_OK) status = list_scenes(&g, contents);
    if (status == PBNDS_OK) status = list_animations(&g, contents);
    if (status == PBNDS_OK) status = list_the_rest(&g, contents);
    pbnds_gltf_close(&g);
    pbnds_gltf_file_free(&file);
    if (status != PBNDS_OK) pbnds_gltf_contents_free(contents);
    return status;
}

void pbnds_gltf_contents_free(struct pbnds_gltf_contents *contents)
{
    free(contents->scenes);
    free(contents->animations);
    free(contents->variants);
    free(contents->skins);
    *contents = (struct pbnds_gltf_contents){0};
}
