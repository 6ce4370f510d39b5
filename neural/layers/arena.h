/**
 * @file arena.h
 * Blocks of memory that are taken and given back during a pass and kept between passes,
 * so that a run of passes of one shape allocates in the first of them only.
 */
#ifndef PBNDS_NEURAL_LAYERS_ARENA_H
#define PBNDS_NEURAL_LAYERS_ARENA_H

#include <stdbool.h>
#include <stddef.h>

struct pbnds_block {
    void *data; /**< 64-byte aligned */
    size_t size;
    bool taken;
};

struct pbnds_arena {
    struct pbnds_block *blocks;
    int count, capacity;
    bool dry; /**< only count: blocks get no memory */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Index of a block of at least `size` bytes, -1 when there is no memory. */
int pbnds_arena_take(struct pbnds_arena *arena, size_t size);
void pbnds_arena_give(struct pbnds_arena *arena, int block);
/** Frees the blocks that nobody holds: the next pass has another shape. */
void pbnds_arena_trim(struct pbnds_arena *arena);
void pbnds_arena_free(struct pbnds_arena *arena);
size_t pbnds_arena_bytes(const struct pbnds_arena *arena);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_LAYERS_ARENA_H */
