#include "neural/train/items.h"

#include <stdlib.h>

enum pbnds_status pbnds_train_items_open(struct pbnds_train_items *items,
                                         const char *data, bool transport,
                                         size_t budget, struct pbnds_error *error)
{
    static const enum pbnds_split SPLITS[PBNDS_ITEMS_LISTS] = {PBNDS_SPLIT_TRAIN,
                                                               PBNDS_SPLIT_VAL};
    *items = (struct pbnds_train_items){.transport = transport, .budget = budget};
    enum pbnds_status status = PBNDS_OK;
    for (int l = 0; l < PBNDS_ITEMS_LISTS && status == PBNDS_OK; ++l) {
        status = pbnds_dataset_list(data, SPLITS[l], &items->list[l], error);
        if (status != PBNDS_OK) break;
        items->items[l] =
            calloc((size_t)items->list[l].count + 1, sizeof *items->items[l]);
        if (!items->items[l]) {
            status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list",
                                data);
        }
    }
    if (status == PBNDS_OK && items->list[PBNDS_ITEMS_TRAIN].count == 0) {
        status = pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                            "%s: has no samples in split train", data);
    }
    if (status != PBNDS_OK) pbnds_train_items_free(items);
    return status;
}

void pbnds_train_items_free(struct pbnds_train_items *items)
{
    for (int l = 0; l < PBNDS_ITEMS_LISTS; ++l) {
        for (int i = 0; items->items[l] && i < items->list[l].count; ++i)
            pbnds_train_item_free(&items->items[l][i]);
        free(items->items[l]);
        pbnds_sample_list_free(&items->list[l]);
    }
    *items = (struct pbnds_train_items){.turn = 0};
}

void pbnds_train_items_turn(struct pbnds_train_items *items)
{
    ++items->turn;
}

static struct pbnds_train_item *oldest_of(struct pbnds_train_items *items)
{
    struct pbnds_train_item *oldest = NULL;
    for (int l = 0; l < PBNDS_ITEMS_LISTS; ++l) {
        for (int i = 0; i < items->list[l].count; ++i) {
            struct pbnds_train_item *item = &items->items[l][i];
            if (item->loaded && item->used < items->turn &&
                (!oldest || item->used < oldest->used)) {
                oldest = item;
            }
        }
    }
    return oldest;
}

/* Those used longest ago go until `room` bytes are free in the budget. */
static void make_room(struct pbnds_train_items *items, size_t room)
{
    while (items->budget > 0 && items->bytes + room > items->budget) {
        struct pbnds_train_item *oldest = oldest_of(items);
        if (!oldest) return; /* what is left belongs to this turn */
        items->bytes -= pbnds_train_item_bytes(oldest);
        pbnds_train_item_free(oldest);
    }
}

enum pbnds_status pbnds_train_items_get(struct pbnds_train_items *items, int list,
                                        int i, const struct pbnds_train_item **item,
                                        struct pbnds_error *error)
{
    struct pbnds_train_item *it = &items->items[list][i];
    if (!it->loaded) {
        make_room(items, items->largest);
        PBNDS_TRY(pbnds_train_item_load(items->list[list].folders[i], items->transport,
                                        it, error));
        const size_t bytes = pbnds_train_item_bytes(it);
        it->used = items->turn;
        items->bytes += bytes;
        if (bytes > items->largest) items->largest = bytes;
        make_room(items, 0); /* it was larger than those before */
        if (items->bytes > items->most) items->most = items->bytes;
        ++items->loaded;
    }
    it->used = items->turn;
    *item = it;
    return PBNDS_OK;
}
