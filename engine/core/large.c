#define _DEFAULT_SOURCE /* madvise() */
#include "engine/core/large.h"

#include <stdint.h>
#include <stdlib.h>
#if defined(__linux__)
#include <sys/mman.h>
#endif

enum { LINE = 64, HUGE = 2 << 20 };

void *pbnds_large_alloc(size_t size)
{
    if (size > SIZE_MAX - HUGE) return NULL;
    const size_t align = size >= 2 * (size_t)HUGE ? HUGE : LINE;
    const size_t whole = (size + align - 1) / align * align;
    void *memory = aligned_alloc(align, whole ? whole : align);
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    /* A hint: where it is refused, small pages do. */
    if (memory && align == HUGE) (void)madvise(memory, whole, MADV_HUGEPAGE);
#endif
    return memory;
}
