/**
 * @file items.h
 * The samples of a data set as the trainer holds them: loaded when they are drawn, kept
 * while they fit into a budget. Whether a sample was kept or loaded again makes no
 * difference to its numbers.
 */
#ifndef PBNDS_NEURAL_TRAIN_ITEMS_H
#define PBNDS_NEURAL_TRAIN_ITEMS_H

#include "neural/train/item.h"

enum { PBNDS_ITEMS_TRAIN, PBNDS_ITEMS_VAL, PBNDS_ITEMS_LISTS };

struct pbnds_train_items {
    struct pbnds_sample_list list[PBNDS_ITEMS_LISTS];
    struct pbnds_train_item *items[PBNDS_ITEMS_LISTS];
    bool transport;  /**< with the planes that transport reads                       */
    size_t budget;   /**< bytes; 0: all are kept                                     */
    size_t bytes;    /**< held now                                                   */
    size_t largest;  /**< of those seen so far: room is made for one like it         */
    size_t most;     /**< ever held                                                  */
    uint64_t turn;   /**< items drawn in the present turn stay                       */
    uint64_t loaded; /**< from disk, all in all                                      */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Lists train and val of a data set. Errors: of pbnds_dataset_list(); ARGUMENT (no
 *  samples in train); MEMORY. */
enum pbnds_status pbnds_train_items_open(struct pbnds_train_items *items,
                                         const char *data, bool transport,
                                         size_t budget,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_train_items_free(struct pbnds_train_items *items);
/** Begins a turn: what was drawn before may go. */
void pbnds_train_items_turn(struct pbnds_train_items *items);
/** Sample i of a list; stays at least until the next turn. The budget is kept to as long
 *  as it has room for the samples of one turn. Errors: of pbnds_train_item_load(). */
enum pbnds_status pbnds_train_items_get(struct pbnds_train_items *items, int list,
                                        int i, const struct pbnds_train_item **item,
                                        struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRAIN_ITEMS_H */
