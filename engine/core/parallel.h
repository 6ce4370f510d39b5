/**
 * @file parallel.h
 * The only file of ours that starts threads (OpenMP, the pool that oneDNN uses too).
 */
#ifndef PBNDS_ENGINE_CORE_PARALLEL_H
#define PBNDS_ENGINE_CORE_PARALLEL_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Threads for later calls of pbnds_parallel_for and for the neural backend; 0 means
 *  one a core. Call from the main thread, outside of any parallel work. */
void pbnds_set_threads(int count);
int pbnds_threads(void);

/** Calls body(context, i, thread) for every i in [0, count), in any order, on any
 *  thread; returns when all are done. thread is in [0, pbnds_threads()). Once a stop is
 *  requested (report.h) the remaining calls are skipped: ask pbnds_stop_requested()
 *  afterwards. Flush-to-zero is set in each thread, as Embree wants. */
void pbnds_parallel_for(size_t count, void (*body)(void *context, size_t i, int thread),
                        void *context);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_CORE_PARALLEL_H */
