#include <string.h>

#include "engine/scene/gltf/load.h"

/* KHR_lights_punctual. A light shines along -z of its node. Only where the node is and
 * how it is turned count: a scale changes neither intensity nor range nor cone. */

static bool kind_of(const char *type, enum pbnds_light_kind *kind)
{
    static const char *const names[] = {"directional", "point", "spot"};
    for (int i = 0; i < 3; ++i) {
        if (strcmp(type, names[i]) != 0) continue;
        *kind = (enum pbnds_light_kind)i;
        return true;
    }
    return false;
}

/** What is wrong with a light; NULL: nothing. */
static const char *fault_of(const struct pbnds_gltf_light *l)
{
    bool fine = l->intensity >= 0.0 && l->intensity <= 1e30;
    for (int i = 0; i < 3; ++i)
        fine = fine && l->color[i] >= 0.0 && l->color[i] <= 1e6;
    if (!fine) return "intensity or colour";
    if (!(l->range >= 0.0)) return "range";
    if (strcmp(l->type, "spot") != 0) return NULL;
    const bool cone = l->inner >= 0.0 && l->inner < l->outer &&
                      l->outer <= 0.5 * (double)PBNDS_PI + 1e-6;
    return cone ? NULL : "cone";
}

enum pbnds_status pbnds_gltf_add_light(struct pbnds_gltf_load_state *g, size_t node)
{
    const struct pbnds_gltf_node *n = &g->doc.nodes[node];
    const struct pbnds_gltf_light *source = &g->doc.lights[n->light];
    struct pbnds_light *l = &g->scene->lights[g->scene->light_count];
    const char *fault = kind_of(source->type, &l->kind) ? fault_of(source) : "type";
    const struct pbnds_mat4 m = pbnds_gltf_rigid(&g->pose[0].world[node]);
    for (int i = 8; i < 15 && !fault; ++i)
        if (!isfinite(m.m[i])) fault = "place";
    if (fault) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: the light of node %zu has no valid %s", g->name, node,
                          fault);
    }
    pbnds_gltf_name(l->name, source->name[0] ? source->name : n->name, "light",
                    (size_t)g->scene->light_count);
    l->position = pbnds_vec3_make(m.m[12], m.m[13], m.m[14]);
    l->direction = pbnds_vec3_make(-m.m[8], -m.m[9], -m.m[10]);
    l->intensity = pbnds_vec3_make((float)(source->color[0] * source->intensity),
                                   (float)(source->color[1] * source->intensity),
                                   (float)(source->color[2] * source->intensity));
    l->range = source->range > 0.0 ? (float)source->range : INFINITY;
    l->cos_inner = (float)cos(source->inner);
    l->cos_outer = (float)cos(source->outer);
    ++g->scene->light_count;
    return PBNDS_OK;
}
