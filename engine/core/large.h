/**
 * @file large.h
 * Memory for large arrays that are read and written all over the place.
 */
#ifndef PBNDS_ENGINE_CORE_LARGE_H
#define PBNDS_ENGINE_CORE_LARGE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** malloc(), where the system can in pages of 2 MiB: one entry of the processor's table of
 *  pages then covers 512 times as much, and the system hands it out faster. At least 64
 *  byte aligned; what it holds is undefined. Released by free(). */
void *pbnds_large_alloc(size_t size);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_CORE_LARGE_H */
