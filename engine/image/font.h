/**
 * @file font.h
 * A 5 x 7 bitmap font of the printable ASCII characters, for labels.
 */
#ifndef PBNDS_ENGINE_IMAGE_FONT_H
#define PBNDS_ENGINE_IMAGE_FONT_H

enum {
    PBNDS_FONT_WIDTH = 5,
    PBNDS_FONT_HEIGHT = 7,
    PBNDS_FONT_FIRST = 0x20, /**< space */
    PBNDS_FONT_LAST = 0x7e,  /**< tilde */
    PBNDS_FONT_DESCENT = 2,  /**< rows that g, p, q and y are drawn lower */
};

/** Rows of each glyph from the top; bit 4 is the left column. */
extern const unsigned char pbnds_font[PBNDS_FONT_LAST - PBNDS_FONT_FIRST + 1]
                                     [PBNDS_FONT_HEIGHT];

#endif /* PBNDS_ENGINE_IMAGE_FONT_H */
