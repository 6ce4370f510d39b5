/**
 * @file item.h
 * A training sample as it is kept in memory: everything that does not change from step
 * to step is computed once.
 */
#ifndef PBNDS_NEURAL_TRAIN_ITEM_H
#define PBNDS_NEURAL_TRAIN_ITEM_H

#include "neural/data/dataset.h"
#include "neural/features.h"

struct pbnds_train_item {
    bool loaded;
    uint64_t used;            /**< the turn it was drawn in last (items.h) */
    enum pbnds_target target; /**< what radiance is */
    float
        stops; /**< lights and targets are exposed by so much; what is looked up in the
                      light map is to be multiplied by 2^stops (cut.h) */
    struct pbnds_view view;
    struct pbnds_envmap *envmap;
    struct pbnds_env_light
        lights[PBNDS_DATASET_LIGHTS]; /**< clusters; unused ones black */
    int light_count;
    float *radiance;      /**< [h, w, 3] reference without the primary emission; of a
                               photograph its sRGB-decoded values, which pbnds+, a model
                               of the displayed image, takes as they are */
    float *direct;        /**< [h, w, 3] its direct part; NULL in photographs */
    float *specular;      /**< [h, w, 3] narrow specular of the whole map (transport) */
    uint32_t *visibility; /**< bit i: cluster i is seen, by rays; NULL in photographs */
    struct pbnds_march march; /**< bit i: cluster i is blocked, by march */
    /* A plane more here is a plane more in cut.c. */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Loads a sample's folder and precomputes. `transport` says whether the planes only
 * that model reads are needed; photographs, which cannot have them, are then
 * UNSUPPORTED. */
enum pbnds_status pbnds_train_item_load(const char *folder, bool transport,
                                        struct pbnds_train_item *item,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_train_item_free(struct pbnds_train_item *item);
/** What it holds in memory, bytes, to a few per cent. */
size_t pbnds_train_item_bytes(const struct pbnds_train_item *item);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_ITEM_H */
