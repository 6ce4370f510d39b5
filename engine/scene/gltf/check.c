#include <stdio.h>

#include "engine/scene/gltf/load.h"

/* Every reference of the document, used by the scene or not, so that a damaged file is
 * known as one. Only the structure: no buffer is fetched. What the loader reads is
 * checked once more against the bytes that are really there (gltf/access.c). */

static enum pbnds_status dangling(struct pbnds_gltf_load_state *g, const char *from,
                                  size_t index, const char *to, int64_t target)
{
    return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                      "%s: %s %zu refers to %s %lld, which does not exist", g->name,
                      from, index, to, (long long)target);
}

/** Negative means "none" and is fine where `optional`. */
static bool exists(int64_t target, size_t count, bool optional)
{
    return target < 0 ? optional : (uint64_t)target < count;
}

static enum pbnds_status check_views(struct pbnds_gltf_load_state *g)
{
    for (size_t i = 0; i < g->doc.view_count; ++i) {
        const struct pbnds_gltf_view *v = &g->doc.views[i];
        if (!exists(v->buffer, g->doc.buffer_count, false)) {
            return dangling(g, "bufferView", i, "buffer", v->buffer);
        }
        const uint64_t size = g->source.buffers[v->buffer].byte_length;
        if (v->offset > size || v->length > size - v->offset) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: bufferView %zu reaches beyond its buffer", g->name,
                              i);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status check_accessors(struct pbnds_gltf_load_state *g)
{
    const struct pbnds_gltf_document *d = &g->doc;
    for (size_t i = 0; i < d->accessor_count; ++i) {
        const struct pbnds_gltf_accessor *a = &d->accessors[i];
        if (!exists(a->view, d->view_count, true)) {
            return dangling(g, "accessor", i, "bufferView", a->view);
        }
        const uint64_t element = pbnds_gltf_element_size(a);
        if (a->view >= 0 && element > 0) {
            char what[40];
            (void)snprintf(what, sizeof what, "accessor %zu", i);
            PBNDS_TRY(pbnds_gltf_check_range(g, what, a->view, a->offset, a->count,
                                             element, d->views[a->view].stride));
        }
        if (a->sparse && !exists(a->sparse_index_view, d->view_count, false)) {
            return dangling(g, "accessor", i, "bufferView", a->sparse_index_view);
        }
        if (a->sparse && !exists(a->sparse_value_view, d->view_count, false)) {
            return dangling(g, "accessor", i, "bufferView", a->sparse_value_view);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status check_user(struct pbnds_gltf_load_state *g, const char *user,
                                    size_t index, const int64_t *accessors,
                                    size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (exists(accessors[i], g->doc.accessor_count, true)) continue;
        return dangling(g, user, index, "accessor", accessors[i]);
    }
    return PBNDS_OK;
}

static enum pbnds_status check_primitive(struct pbnds_gltf_load_state *g, size_t mesh,
                                         const struct pbnds_gltf_primitive *p)
{
    const int64_t attributes[] = {p->position, p->normal, p->tangent, p->uv[0],
                                  p->uv[1],    p->color,  p->indices};
    PBNDS_TRY(check_user(g, "mesh", mesh, attributes,
                         sizeof attributes / sizeof attributes[0]));
    for (size_t i = 0; i < p->influence_count; ++i) {
        const int64_t pair[] = {p->influences[i].joints, p->influences[i].weights};
        PBNDS_TRY(check_user(g, "mesh", mesh, pair, 2));
    }
    for (size_t i = 0; i < p->target_count; ++i) {
        const struct pbnds_gltf_target *t = &p->targets[i];
        const int64_t deltas[] = {t->position, t->normal, t->tangent};
        PBNDS_TRY(check_user(g, "mesh", mesh, deltas, 3));
    }
    if (!exists(p->material, g->doc.material_count, true)) {
        return dangling(g, "mesh", mesh, "material", p->material);
    }
    return pbnds_gltf_check_mappings(g, p);
}

static enum pbnds_status check_meshes(struct pbnds_gltf_load_state *g)
{
    for (size_t i = 0; i < g->doc.mesh_count; ++i) {
        const struct pbnds_gltf_mesh *m = &g->doc.meshes[i];
        for (size_t k = 0; k < m->primitive_count; ++k) {
            PBNDS_TRY(check_primitive(g, i, &m->primitives[k]));
            /* One list of weights serves them all (glTF 2.0, section 3.7.2.2). */
            if (m->primitives[k].target_count == m->primitives[0].target_count)
                continue;
            return pbnds_fail(
                g->error, PBNDS_ERROR_FORMAT,
                "%s: the primitives of mesh %zu have different numbers of "
                "morph targets",
                g->name, i);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status check_nodes(struct pbnds_gltf_load_state *g)
{
    const struct pbnds_gltf_document *d = &g->doc;
    for (size_t i = 0; i < d->node_count; ++i) {
        const struct pbnds_gltf_node *n = &d->nodes[i];
        if (!exists(n->mesh, d->mesh_count, true)) {
            return dangling(g, "node", i, "mesh", n->mesh);
        }
        if (!exists(n->skin, d->skin_count, true)) {
            return dangling(g, "node", i, "skin", n->skin);
        }
        if (!exists(n->camera, d->camera_count, true)) {
            return dangling(g, "node", i, "camera", n->camera);
        }
        if (!exists(n->light, d->light_count, true)) {
            return dangling(g, "node", i, "light", n->light);
        }
        const struct pbnds_gltf_instancing *c = &n->instancing;
        const int64_t instances[] = {c->translation, c->rotation, c->scale};
        if (c->present) PBNDS_TRY(check_user(g, "node", i, instances, 3));
    }
    if (!exists(d->scene, d->scene_count, true)) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: the default scene %lld does not exist", g->name,
                          (long long)d->scene);
    }
    return PBNDS_OK;
}

static enum pbnds_status check_skins(struct pbnds_gltf_load_state *g)
{
    const struct pbnds_gltf_document *d = &g->doc;
    for (size_t i = 0; i < d->skin_count; ++i) {
        const struct pbnds_gltf_skin *s = &d->skins[i];
        if (!exists(s->inverse_bind, d->accessor_count, true)) {
            return dangling(g, "skin", i, "accessor", s->inverse_bind);
        }
        for (size_t k = 0; k < s->joints.count; ++k) {
            if (exists(s->joints.items[k], d->node_count, false)) continue;
            return dangling(g, "skin", i, "node", s->joints.items[k]);
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status check_animations(struct pbnds_gltf_load_state *g)
{
    const struct pbnds_gltf_document *d = &g->doc;
    for (size_t i = 0; i < d->animation_count; ++i) {
        const struct pbnds_gltf_animation *a = &d->animations[i];
        for (size_t k = 0; k < a->sampler_count; ++k) {
            const struct pbnds_gltf_animation_sampler *s = &a->samplers[k];
            const bool fine = exists(s->input, d->accessor_count, false) &&
                              exists(s->output, d->accessor_count, false) &&
                              s->interpolation != PBNDS_GLTF_OTHER_INTERPOLATION;
            if (fine) continue;
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: sampler %zu of animation %zu has no valid input, "
                              "output or interpolation",
                              g->name, k, i);
        }
        for (size_t k = 0; k < a->channel_count; ++k) {
            const struct pbnds_gltf_channel *c = &a->channels[k];
            if (!exists(c->sampler, a->sampler_count, false)) {
                return dangling(g, "animation", i, "sampler", c->sampler);
            }
            if (!exists(c->node, d->node_count, true)) {
                return dangling(g, "animation", i, "node", c->node);
            }
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status check_textures(struct pbnds_gltf_load_state *g)
{
    const struct pbnds_gltf_document *d = &g->doc;
    for (size_t i = 0; i < d->texture_count; ++i) {
        const struct pbnds_gltf_texture *t = &d->textures[i];
        if (!exists(t->image, d->image_count, true)) {
            return dangling(g, "texture", i, "image", t->image);
        }
        if (!exists(t->fallback, d->image_count, true)) {
            return dangling(g, "texture", i, "image", t->fallback);
        }
        if (!exists(t->sampler, d->sampler_count, true)) {
            return dangling(g, "texture", i, "sampler", t->sampler);
        }
    }
    for (size_t i = 0; i < d->material_count; ++i) {
        const struct pbnds_gltf_material *m = &d->materials[i];
        const int64_t textures[] = {
            m->base_color_texture.index,     m->metallic_roughness_texture.index,
            m->normal_texture.index,         m->emissive_texture.index,
            m->occlusion_texture.index,      m->specular_texture.index,
            m->specular_color_texture.index,
        };
        for (size_t k = 0; k < sizeof textures / sizeof textures[0]; ++k) {
            if (exists(textures[k], d->texture_count, true)) continue;
            return dangling(g, "material", i, "texture", textures[k]);
        }
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_check(struct pbnds_gltf_load_state *g)
{
    PBNDS_TRY(check_views(g));
    PBNDS_TRY(pbnds_gltf_check_packed(g));
    PBNDS_TRY(check_accessors(g));
    PBNDS_TRY(check_meshes(g));
    PBNDS_TRY(check_nodes(g));
    PBNDS_TRY(check_skins(g));
    PBNDS_TRY(check_animations(g));
    return check_textures(g);
}
