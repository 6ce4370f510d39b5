/**
 * @file picture_list.h
 * Numbers that belong to pictures, from the lists beside a set of photographs: fields of
 * view (JSON) and splits (text). Pictures are known by the number that they are named by:
 * 05030, 05030.png and 05000/05030.png are one.
 */
#ifndef PBNDS_NEURAL_DATA_PICTURE_LIST_H
#define PBNDS_NEURAL_DATA_PICTURE_LIST_H

#include <stddef.h>

#include "engine/core/error.h"

struct pbnds_picture_value {
    int index;
    double value;
};

struct pbnds_picture_list {
    struct pbnds_picture_value *items; /**< owned */
    int count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** The number of a name: up to nine digits behind the last slash, with or without an
 *  extension; -1: it has none. */
int pbnds_picture_index(const char *name);

/** Appends what {"05030": 51.7, ...} says. Keys that name no picture are skipped; a value
 *  that is no number becomes NaN. Errors: FORMAT (no JSON object), MEMORY. */
enum pbnds_status pbnds_picture_list_json(struct pbnds_picture_list *list,
                                          const void *bytes, size_t size,
                                          const char *name,
                                          struct pbnds_error *error) PBNDS_NODISCARD;
/** Appends the picture of each line with one and the same value. Empty lines and lines
 *  that begin with # are skipped. Errors: FORMAT (a line that names no picture),
 *  MEMORY. */
enum pbnds_status pbnds_picture_list_lines(struct pbnds_picture_list *list,
                                           const void *bytes, size_t size, double value,
                                           const char *name,
                                           struct pbnds_error *error) PBNDS_NODISCARD;
/** Sorts, for find. Errors: FORMAT (two values for one picture). */
enum pbnds_status pbnds_picture_list_sort(struct pbnds_picture_list *list,
                                          const char *name,
                                          struct pbnds_error *error) PBNDS_NODISCARD;
/** NaN: the sorted list does not have it. */
double pbnds_picture_list_find(const struct pbnds_picture_list *list, int index);
void pbnds_picture_list_free(struct pbnds_picture_list *list);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_PICTURE_LIST_H */
