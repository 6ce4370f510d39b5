#include "engine/image/sheet.h"

#include <stdint.h>
#include <string.h>

#include "engine/image/font.h"

/* Display-encoded greys, and distances in units of the text's scale. */
static const float background = 0.10f, ink = 0.92f;
enum {
    GAP = 6,
    ADVANCE = PBNDS_FONT_WIDTH + 1,
    LEADING = PBNDS_FONT_HEIGHT + PBNDS_FONT_DESCENT + 1
};

struct layout {
    int columns, rows;
    int width, height; /* of a picture */
    int lines;         /* of the longest label */
    int scale;         /* pixels a font pixel */
};

static size_t line_length(const char *text)
{
    return strcspn(text, "\n");
}

/* Up to two lines: the rest of a label is not shown. */
static int line_count(const char *label)
{
    if (!label || !*label) return 0;
    return label[line_length(label)] ? 2 : 1;
}

static size_t longest_line(const char *label)
{
    if (!label) return 0;
    const size_t first = line_length(label);
    const size_t second = label[first] ? line_length(label + first + 1) : 0;
    return first > second ? first : second;
}

/* Large pictures are looked at from further away; long labels must still fit. */
static int choose_scale(int width, size_t letters)
{
    int scale = width < 160 ? 1 : width < 640 ? 2 : width < 1280 ? 3 : 4;
    while (scale > 1 && letters * ADVANCE * (size_t)scale > (size_t)width)
        --scale;
    return scale;
}

static enum pbnds_status measure(const struct pbnds_sheet_cell *cells, int count,
                                 int columns, struct layout *out,
                                 struct pbnds_error *error)
{
    if (count < 1 || columns < 1) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "contact sheet of %d pictures in %d columns: there must be some", count,
            columns);
    }
    struct layout l = {
        .columns = columns < count ? columns : count, .width = 1, .height = 1};
    l.rows = count / l.columns + (count % l.columns != 0);
    size_t letters = 0;
    for (int i = 0; i < count; ++i) {
        const struct pbnds_image *image = cells[i].image;
        if (image && (image->channels != 3 || !image->data)) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "contact sheet: picture %d has %d channels, not 3", i,
                              image->channels);
        }
        if (image && image->width > l.width) l.width = image->width;
        if (image && image->height > l.height) l.height = image->height;
        const size_t length = longest_line(cells[i].label);
        if (length > letters) letters = length;
        const int lines = line_count(cells[i].label);
        if (lines > l.lines) l.lines = lines;
    }
    l.scale = choose_scale(l.width, letters);
    *out = l;
    return PBNDS_OK;
}

static int text_height(const struct layout *l)
{
    return l->lines * LEADING * l->scale;
}

static void fill(struct pbnds_image *sheet, int x0, int y0, int width, int height,
                 float grey)
{
    for (int y = y0; y < y0 + height; ++y) {
        float *row = pbnds_image_at(sheet, x0, y);
        for (size_t k = 0; k < 3 * (size_t)width; ++k)
            row[k] = grey;
    }
}

static void draw_glyph(struct pbnds_image *sheet, int x, int y, int scale, char letter)
{
    const int code = (unsigned char)letter;
    const int known = code >= PBNDS_FONT_FIRST && code <= PBNDS_FONT_LAST;
    const unsigned char *rows = pbnds_font[(known ? code : '?') - PBNDS_FONT_FIRST];
    if (letter && strchr("gpqy", letter)) y += PBNDS_FONT_DESCENT * scale;
    for (int r = 0; r < PBNDS_FONT_HEIGHT; ++r) {
        for (int c = 0; c < PBNDS_FONT_WIDTH; ++c) {
            if (!(rows[r] >> (PBNDS_FONT_WIDTH - 1 - c) & 1)) continue;
            fill(sheet, x + c * scale, y + r * scale, scale, scale, ink);
        }
    }
}

/* A line that is too long for the cell is cut, and ends in two points to say so. */
static void draw_line(struct pbnds_image *sheet, const struct layout *l, int x, int y,
                      const char *text)
{
    const size_t length = line_length(text);
    const size_t room = (size_t)((l->width + l->scale) / (ADVANCE * l->scale));
    const size_t shown = length < room ? length : room;
    for (size_t i = 0; i < shown; ++i) {
        const int cut = shown < length && i + 2 >= shown;
        draw_glyph(sheet, x + (int)i * ADVANCE * l->scale, y, l->scale,
                   cut ? '.' : text[i]);
    }
}

static void draw_cell(struct pbnds_image *sheet, const struct layout *l,
                      const struct pbnds_sheet_cell *cell, int x, int y)
{
    const struct pbnds_image *image = cell->image;
    if (image) {
        const int left = x + (l->width - image->width) / 2;
        const int top = y + (l->height - image->height) / 2;
        for (int row = 0; row < image->height; ++row) {
            memcpy(pbnds_image_at(sheet, left, top + row),
                   pbnds_image_at(image, 0, row),
                   3 * (size_t)image->width * sizeof(float));
        }
    }
    const char *text = cell->label;
    int line = y + l->height + 2 * l->scale;
    for (int i = line_count(text); i > 0; --i, line += LEADING * l->scale) {
        draw_line(sheet, l, x, line, text);
        text += line_length(text) + (i > 1);
    }
}

enum pbnds_status pbnds_sheet_make(const struct pbnds_sheet_cell *cells, int count,
                                   int columns, struct pbnds_image *sheet,
                                   struct pbnds_error *error)
{
    *sheet = (struct pbnds_image){0, 0, 0, NULL};
    struct layout l = {0};
    PBNDS_TRY(measure(cells, count, columns, &l, error));
    const int gap = GAP * l.scale;
    const int64_t step_x = (int64_t)l.width + gap;
    const int64_t step_y = (int64_t)l.height + text_height(&l) + gap;
    const int64_t width = l.columns * step_x + gap, height = l.rows * step_y + gap;
    if (width > INT32_MAX || height > INT32_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "contact sheet of %d pictures is too large, use fewer",
                          count);
    }
    PBNDS_TRY(pbnds_image_init(sheet, (int)width, (int)height, 3, error));
    fill(sheet, 0, 0, sheet->width, sheet->height, background);
    for (int i = 0; i < count; ++i) {
        draw_cell(sheet, &l, &cells[i], gap + (int)(i % l.columns * step_x),
                  gap + (int)(i / l.columns * step_y));
    }
    return PBNDS_OK;
}
