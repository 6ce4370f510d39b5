#include "engine/shade/tiles.h"

#include <stdatomic.h>
#include <stddef.h>

#include "engine/core/parallel.h"

struct walk {
    int width, height, side;
    size_t columns, total;
    atomic_size_t done;
    const struct pbnds_report *report;
    const char *stage;
    void (*body)(void *context, const struct pbnds_tile *tile);
    void *context;
};

static int forced_side; /* 0: as the callers say */

void pbnds_set_tile_side(int side)
{
    forced_side = side;
}

static int min_int(int a, int b)
{
    return a < b ? a : b;
}

static void one_tile(void *context, size_t i, int thread)
{
    struct walk *walk = context;
    struct pbnds_tile tile;
    tile.x0 = (int)(i % walk->columns) * walk->side;
    tile.y0 = (int)(i / walk->columns) * walk->side;
    tile.x1 = min_int(tile.x0 + walk->side, walk->width);
    tile.y1 = min_int(tile.y0 + walk->side, walk->height);
    walk->body(walk->context, &tile);

    /* Thread 0 is the caller's, so reports never come from two threads at once. */
    const size_t done = atomic_fetch_add(&walk->done, 1) + 1;
    if (thread == 0)
        pbnds_progress(walk->report, walk->stage, (double)done, (double)walk->total);
}

enum pbnds_status pbnds_for_tiles(int width, int height, int side,
                                  const struct pbnds_report *report, const char *stage,
                                  void (*body)(void *context,
                                               const struct pbnds_tile *tile),
                                  void *context, struct pbnds_error *error)
{
    if (forced_side > 0) side = forced_side;
    struct walk walk = {.width = width,
                        .height = height,
                        .side = side,
                        .columns = ((size_t)width + (size_t)side - 1) / (size_t)side,
                        .report = report,
                        .stage = stage,
                        .body = body,
                        .context = context};
    walk.total = walk.columns * (((size_t)height + (size_t)side - 1) / (size_t)side);
    atomic_init(&walk.done, 0);
    pbnds_parallel_for(walk.total, one_tile, &walk);
    if (pbnds_stop_requested()) return pbnds_fail_interrupted(error);
    pbnds_progress(report, stage, (double)walk.total, (double)walk.total);
    return PBNDS_OK;
}
