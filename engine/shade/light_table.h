/**
 * @file light_table.h
 * Which light to ask: the light map, one of the file's lights, or one emitting triangle,
 * drawn by estimated power from a single table.
 *
 * Power, luminance, in W: the map through the scene's bounding sphere of radius r,
 * 4 pi^2 r^2 mean(L); a directional light pi r^2 E; a point 4 pi I; a spot 2 pi (1 - (2 cos
 * inner + cos outer) / 3) I, the integral of its falloff, a ramp squared (light_punctual.h);
 * a triangle 2 pi A mean(L) (light_emissive.h). Power says
 * nothing of what can be seen from where, so a quarter of the choices is shared evenly
 * between the kinds that are there, and a tenth of a kind's between its punctual lights:
 * those are found in no other way and must never be left out.
 *
 * Choosing inverts the cumulated distribution (binary search: 17 steps for 100 000
 * triangles), which keeps neighbouring numbers neighbours where an alias table would not.
 * It is held in units of 2^-32, the resolution of the numbers that choose, so that
 * probabilities are exact.
 *
 * Threads: immutable once made.
 */
#ifndef PBNDS_ENGINE_SHADE_LIGHT_TABLE_H
#define PBNDS_ENGINE_SHADE_LIGHT_TABLE_H

#include "engine/scene/envmap.h"
#include "engine/shade/light_emissive.h"

enum pbnds_light_class {
    PBNDS_LIGHT_CLASS_MAP,
    PBNDS_LIGHT_CLASS_PUNCTUAL,
    PBNDS_LIGHT_CLASS_EMISSIVE,
};

struct pbnds_light_choice {
    enum pbnds_light_class kind;
    size_t index;      /**< into scene->lights or emissive.triangles              */
    float probability; /**< of this choice, > 0                                   */
};

struct pbnds_light_table {
    const struct pbnds_scene *scene; /**< borrowed */
    struct pbnds_emissive emissive;
    uint32_t *start; /**< of each entry's share, in 2^-32: map, lights, triangles */
    size_t count;    /**< entries; 0: there is no light at all               */
    float map_probability; /**< 0 without a map; 1 where nothing else shines       */
};

#ifdef __cplusplus
extern "C" {
#endif

/** envmap may be NULL. Errors: MEMORY, INTERRUPTED. */
enum pbnds_status pbnds_light_table_create(const struct pbnds_scene *scene,
                                           const struct pbnds_envmap *envmap,
                                           struct pbnds_light_table *table,
                                           struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_light_table_free(struct pbnds_light_table *table);

/** bits: uniform in [0, 2^32). The table must not be empty. */
struct pbnds_light_choice
pbnds_light_table_choose(const struct pbnds_light_table *table, uint32_t bits);
/** Density with which choosing a light and a point on it gives the point that a ray hit
 *  at distance t and cosine cos_l, 1/sr; 0 where it is no light of the table. */
float pbnds_light_table_emissive_pdf(const struct pbnds_light_table *table,
                                     const struct pbnds_hit *hit, float cos_l);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_LIGHT_TABLE_H */
