#include "neural/provenance.h"

#include <inttypes.h>
#include <stdio.h>

#include "neural/features_text.h"

struct list {
    struct pbnds_metadata items[16];
    int count;
};

/* The writer borrows texts and changes none. */
static void add(struct list *list, const char *key, const char *value)
{
    list->items[list->count++] =
        (struct pbnds_metadata){(char *)(uintptr_t)key, (char *)(uintptr_t)value};
}

enum pbnds_status pbnds_weights_save_trained(const char *path,
                                             const struct pbnds_net *net,
                                             const struct pbnds_provenance *provenance,
                                             struct pbnds_error *error)
{
    const struct pbnds_provenance *p = provenance;
    const struct pbnds_feature_table *table = pbnds_features_of(p->model);
    struct pbnds_features_text text = {0};
    struct list list = {.count = 0};
    char lights[16], step[32], steps[32], seed[32], psnr[32];
    (void)snprintf(lights, sizeof lights, "%d", p->lights);
    (void)snprintf(step, sizeof step, "%" PRIu64, p->step);
    (void)snprintf(steps, sizeof steps, "%" PRIu64, p->steps);
    (void)snprintf(seed, sizeof seed, "%" PRIu64, p->seed);
    (void)snprintf(psnr, sizeof psnr, "%.3f", p->validation_psnr);
    add(&list, "pbnds.lights", lights);
    if (table) {
        PBNDS_TRY(pbnds_features_text(table, &text, error));
        add(&list, "pbnds.features.view", text.view);
        add(&list, "pbnds.features.light", text.light);
        add(&list, "pbnds.features.encoding", text.encoding);
    }
    add(&list, "pbnds.program", PBNDS_VERSION);
    add(&list, "train.data", p->data);
    add(&list, "train.recipe", p->recipe);
    add(&list, "train.step", step);
    add(&list, "train.steps", steps);
    add(&list, "train.seed", seed);
    add(&list, "train.dtype", p->dtype == PBNDS_BF16 ? "bf16" : "fp32");
    add(&list, "train.validation_psnr_srgb", psnr);
    const enum pbnds_status status =
        pbnds_weights_save(path, p->model, net, list.items, list.count, error);
    pbnds_features_text_free(&text);
    return status;
}
