/**
 * @file tiles.h
 * An image cut into windows that a network is run on one after another, so that memory
 * does not grow with the image.
 *
 * A network sees the image on a domain: the image, with its border repeated up to
 * multiples of 1 << (deepest level). Outside of the domain its convolutions pad with
 * zeros. Each window holds an own part and, up to the domain's border, the halo
 * (pbnds_net_halo) around it. The own parts cover the image once; what the network says
 * inside them is what it says there in one pass over the whole domain.
 *
 * All windows have one size, so that the network's buffers and kernels are made once.
 */
#ifndef PBNDS_NEURAL_TILES_H
#define PBNDS_NEURAL_TILES_H

#include "neural/layers/net.h"
#include "neural/view.h"

/** Lights of a chunk at most: more gain nothing. */
enum { PBNDS_CHUNK_MAX = 16 };

struct pbnds_tiling {
    int width, height;               /**< of the image */
    int window_width, window_height; /**< of each window */
    int step_x, step_y;              /**< from a window to the next */
    int columns, rows;
    int halo;
    int domain_width, domain_height;
    int chunk;    /**< lights at once */
    size_t bytes; /**< that working memory takes then, as the caller counts it */
};

/** One window; in pixels of the image. */
struct pbnds_tile {
    struct pbnds_window window; /**< may reach past the image */
    struct pbnds_window own;    /**< inside the image */
};

/** Working memory of a window with so many lights at once. Grows with either. */
typedef size_t (*pbnds_tile_bytes)(const void *context, int width, int height,
                                   int lights);

#ifdef __cplusplus
extern "C" {
#endif

/** Chooses the windows that cost the least work among those that fit `max_memory` bytes
 *  (0: 1 GiB) with one light at once, then as many lights, to `lights` and
 *  PBNDS_CHUNK_MAX, as fit. Where not even the smallest window fits, it is taken. */
struct pbnds_tiling pbnds_tiling_plan(const struct pbnds_net *net, int width,
                                      int height, int lights, size_t max_memory,
                                      pbnds_tile_bytes bytes, const void *context);
/** Tile i of columns * rows. */
struct pbnds_tile pbnds_tiling_tile(const struct pbnds_tiling *tiling, int i);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TILES_H */
