/* Contact sheets of validation samples: predictions beside references. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/image/oiio.h"
#include "engine/image/sheet.h"
#include "engine/image/tonemap.h"
#include "neural/train/trainer.h"

enum { PAIRS = 8, COLUMNS = 4 };

struct pairs {
    struct pbnds_image images[2 * PAIRS]; /* prediction, reference, prediction, ... */
    char labels[2 * PAIRS][64];
    int count; /* of images */
};

/* As the error is measured: exact sRGB, clamped. Grey where nothing was hit. */
static void show(const struct pbnds_task_view *view, struct pbnds_image *image)
{
    static const struct pbnds_display DISPLAY = {.tonemap = PBNDS_TONEMAP_NONE};
    const struct pbnds_view *planes = &view->item->view;
    pbnds_display_image(&DISPLAY, image, image);
    for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) {
            const size_t source = (size_t)(view->window.y + y) * (size_t)planes->width +
                                  (size_t)(view->window.x + x);
            float *pixel = pbnds_image_at(image, x, y);
            if (planes->plane[PBNDS_PLANE_MASK][source] > 0.0f) continue;
            pixel[0] = pixel[1] = pixel[2] = 0.2f;
        }
    }
}

static void copy_reference(const struct pbnds_task_view *view,
                           struct pbnds_image *image)
{
    const struct pbnds_window w = view->window;
    for (int y = 0; y < w.height; ++y) {
        const size_t source =
            (size_t)(w.y + y) * (size_t)view->item->view.width + (size_t)w.x;
        memcpy(pbnds_image_at(image, 0, y), view->item->radiance + 3 * source,
               3 * (size_t)w.width * sizeof(float));
    }
}

/* The last part of a sample's name. */
static const char *name_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static enum pbnds_status add_pair(struct pbnds_trainer *t, int list, int i,
                                  struct pairs *pairs, struct pbnds_error *error)
{
    struct pbnds_task_view view;
    struct pbnds_task_loss loss;
    PBNDS_TRY(pbnds_trainer_fixed_view(t, list, i, &view, error));
    PBNDS_TRY(pbnds_batch_run(&t->validation, &view, false, 0, &loss, error));
    struct pbnds_image *both = &pairs->images[pairs->count];
    for (int k = 0; k < 2; ++k) {
        PBNDS_TRY(pbnds_image_init(&both[k], t->crop, t->crop, 3, error));
        ++pairs->count;
    }
    t->ops->picture(&t->task, &view, t->validation.out, t->validation.view_out,
                    both[0].data);
    copy_reference(&view, &both[1]);
    show(&view, &both[0]);
    show(&view, &both[1]);
    char *label = pairs->labels[pairs->count - 2];
    if (loss.mse > 0.0) {
        (void)snprintf(label, 64, "%.1f dB", -10.0 * log10(loss.mse));
    }
    (void)snprintf(pairs->labels[pairs->count - 1], 64, "%.60s",
                   name_of(t->items.list[list].folders[i]));
    return PBNDS_OK;
}

static enum pbnds_status write_sheet(const struct pbnds_trainer *t,
                                     const struct pairs *pairs,
                                     struct pbnds_error *error)
{
    struct pbnds_sheet_cell cells[2 * PAIRS];
    for (int i = 0; i < pairs->count; ++i)
        cells[i] = (struct pbnds_sheet_cell){&pairs->images[i], pairs->labels[i]};
    struct pbnds_image sheet;
    PBNDS_TRY(pbnds_sheet_make(cells, pairs->count, COLUMNS, &sheet, error));
    const enum pbnds_status status = pbnds_png_write(t->sheet_path, &sheet, error);
    pbnds_image_free(&sheet);
    return status;
}

enum pbnds_status pbnds_trainer_sheet(struct pbnds_trainer *t,
                                      struct pbnds_error *error)
{
    const int list =
        t->items.list[PBNDS_ITEMS_VAL].count > 0 ? PBNDS_ITEMS_VAL : PBNDS_ITEMS_TRAIN;
    const int there = t->items.list[list].count;
    const int count = there < PAIRS ? there : PAIRS;
    struct pairs *pairs = calloc(1, sizeof *pairs);
    if (!pairs) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for a sheet");
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < count && status == PBNDS_OK; ++i)
        status = add_pair(t, list, i, pairs, error);
    /* Half a picture is not shown: the sheet from before stays. */
    if (status == PBNDS_OK && !pbnds_stop_requested())
        status = write_sheet(t, pairs, error);
    for (int i = 0; i < pairs->count; ++i)
        pbnds_image_free(&pairs->images[i]);
    free(pairs);
    return status;
}
