#include "neural/layers/arena.h"

#include <stdlib.h>

enum { ALIGNMENT = 64 };

/** The smallest free block that fits without wasting more than half of it. */
static int find_fit(const struct pbnds_arena *arena, size_t size)
{
    int best = -1;
    for (int i = 0; i < arena->count; ++i) {
        const struct pbnds_block *b = &arena->blocks[i];
        if (b->taken || b->size < size || b->size / 2 > size) continue;
        if (best < 0 || b->size < arena->blocks[best].size) best = i;
    }
    return best;
}

/** A place for a new block: the largest free one too small to use (the need has grown),
 * an emptied one, or a fresh one. */
static int find_place(struct pbnds_arena *arena, size_t size)
{
    int best = -1;
    for (int i = 0; i < arena->count; ++i) {
        const struct pbnds_block *b = &arena->blocks[i];
        if (b->taken || b->size >= size) continue;
        if (best < 0 || b->size > arena->blocks[best].size) best = i;
    }
    if (best >= 0) return best;
    if (arena->count == arena->capacity) {
        const int capacity = arena->capacity ? 2 * arena->capacity : 32;
        struct pbnds_block *blocks =
            realloc(arena->blocks, (size_t)capacity * sizeof *blocks);
        if (!blocks) return -1;
        arena->blocks = blocks;
        arena->capacity = capacity;
    }
    arena->blocks[arena->count] = (struct pbnds_block){NULL, 0, false};
    return arena->count++;
}

int pbnds_arena_take(struct pbnds_arena *arena, size_t size)
{
    int i = find_fit(arena, size);
    if (i < 0) {
        i = find_place(arena, size);
        if (i < 0) return -1;
        struct pbnds_block *b = &arena->blocks[i];
        free(b->data);
        const size_t rounded = (size / ALIGNMENT + 1) * ALIGNMENT;
        b->data = arena->dry ? NULL : aligned_alloc(ALIGNMENT, rounded);
        b->size = b->data || arena->dry ? rounded : 0;
        if (b->size == 0) return -1;
    }
    arena->blocks[i].taken = true;
    return i;
}

void pbnds_arena_give(struct pbnds_arena *arena, int block)
{
    arena->blocks[block].taken = false;
}

void pbnds_arena_trim(struct pbnds_arena *arena)
{
    for (int i = 0; i < arena->count; ++i) {
        struct pbnds_block *b = &arena->blocks[i];
        if (b->taken) continue;
        free(b->data);
        b->data = NULL;
        b->size = 0;
    }
}

void pbnds_arena_free(struct pbnds_arena *arena)
{
    for (int i = 0; i < arena->count; ++i)
        free(arena->blocks[i].data);
    free(arena->blocks);
    *arena = (struct pbnds_arena){.dry = arena->dry};
}

size_t pbnds_arena_bytes(const struct pbnds_arena *arena)
{
    size_t bytes = 0;
    for (int i = 0; i < arena->count; ++i)
        bytes += arena->blocks[i].size;
    return bytes;
}
