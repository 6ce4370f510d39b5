/**
 * @file tiles.h
 * Walks an image in square tiles on every thread, with progress and interruption. Which
 * thread takes a tile never matters: a body writes only to the pixels of its tile.
 */
#ifndef PBNDS_ENGINE_SHADE_TILES_H
#define PBNDS_ENGINE_SHADE_TILES_H

#include "engine/core/report.h"

/** Half-open pixel ranges [x0, x1) x [y0, y1). */
struct pbnds_tile {
    int x0, y0, x1, y1;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Calls body once for each tile of `side` pixels. Progress under the name `stage`
 * comes from the calling thread only. Errors: INTERRUPTED. */
enum pbnds_status
pbnds_for_tiles(int width, int height, int side, const struct pbnds_report *report,
                const char *stage,
                void (*body)(void *context, const struct pbnds_tile *tile),
                void *context, struct pbnds_error *error) PBNDS_NODISCARD;

/** For tests, which show that the size of tiles changes no result: every later walk takes
 *  tiles of `side` pixels, whatever its caller says; 0: as the callers say. */
void pbnds_set_tile_side(int side);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_TILES_H */
