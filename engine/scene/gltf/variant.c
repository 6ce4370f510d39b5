/*
 * KHR_materials_variants: what a file's meshes can wear instead.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"

/** A whole decimal number below `count`, or -1. */
static int64_t index_below(const char *text, size_t count)
{
    uint64_t value = 0;
    if (!text[0]) return -1;
    for (const char *p = text; *p; ++p) {
        if (*p < '0' || *p > '9') return -1;
        value = value * 10 + (uint64_t)(*p - '0');
        if (value >= count) return -1;
    }
    return (int64_t)value;
}

/** "a, b, c", cut short where there are too many to read. */
static void list_variants(const struct pbnds_gltf_document *d, char *out, size_t size)
{
    size_t used = 0;
    for (size_t i = 0; i < d->variant_count && used + 64 < size; ++i) {
        const int n =
            snprintf(out + used, size - used, "%s%.48s", i ? ", " : "", d->variants[i]);
        if (n > 0) used += (size_t)n;
    }
}

enum pbnds_status pbnds_gltf_find_variant(struct pbnds_gltf_load_state *g)
{
    const struct pbnds_gltf_document *d = &g->doc;
    const char *wanted = g->options->variant;
    g->variant = -1;
    if (!wanted) return PBNDS_OK;
    for (size_t i = 0; i < d->variant_count && g->variant < 0; ++i) {
        if (strcmp(d->variants[i], wanted) == 0) g->variant = (int64_t)i;
    }
    if (g->variant < 0) g->variant = index_below(wanted, d->variant_count);
    if (g->variant >= 0) return PBNDS_OK;
    if (d->variant_count == 0) {
        return pbnds_fail(g->error, PBNDS_ERROR_ARGUMENT,
                          "%s: has no material variants, so none called \"%.64s\"",
                          g->name, wanted);
    }
    char list[512] = "";
    list_variants(d, list, sizeof list);
    return pbnds_fail(g->error, PBNDS_ERROR_ARGUMENT,
                      "%s: has no material variant \"%.64s\"; there are %s", g->name,
                      wanted, list);
}

enum pbnds_status pbnds_gltf_check_mappings(struct pbnds_gltf_load_state *g,
                                            const struct pbnds_gltf_primitive *p)
{
    for (size_t i = 0; i < p->mapping_count; ++i) {
        const int64_t material = p->mappings[i].material;
        if (material >= 0 && (uint64_t)material < g->doc.material_count) continue;
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: a material variant refers to a material that does not "
                          "exist",
                          g->name);
    }
    return PBNDS_OK;
}

int pbnds_gltf_material_of(const struct pbnds_gltf_load_state *g,
                           const struct pbnds_gltf_primitive *p)
{
    for (size_t i = 0; i < p->mapping_count && g->variant >= 0; ++i) {
        const struct pbnds_gltf_mapping *m = &p->mappings[i];
        for (size_t k = 0; k < m->variant_count; ++k) {
            if (m->variants[k] == g->variant) return (int)m->material;
        }
    }
    return p->material < 0 ? (int)g->doc.material_count : (int)p->material;
}
