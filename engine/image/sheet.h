/**
 * @file sheet.h
 * Contact sheets: labelled pictures in a grid, for people to look at.
 */
#ifndef PBNDS_ENGINE_IMAGE_SHEET_H
#define PBNDS_ENGINE_IMAGE_SHEET_H

#include "engine/image/image.h"

/** One cell; the image is 3-channel display-encoded and borrowed. */
struct pbnds_sheet_cell {
    const struct pbnds_image *image; /**< NULL leaves the cell empty */
    const char *label;               /**< printable ASCII, under the picture; '\n' starts a
                                          second line; may be NULL */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Lays cells out row by row, `columns` wide, each as large as the largest picture.
 *  `sheet` is a new display-encoded 3-channel image. */
enum pbnds_status pbnds_sheet_make(const struct pbnds_sheet_cell *cells, int count,
                                   int columns, struct pbnds_image *sheet,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_IMAGE_SHEET_H */
