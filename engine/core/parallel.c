#include "engine/core/parallel.h"

#include <omp.h>
#if defined(__SSE__)
#include <immintrin.h>
#endif

#include "engine/core/report.h"

static int thread_count; /* 0: not chosen yet */

void pbnds_set_threads(int count)
{
    thread_count = count > 0 ? count : omp_get_num_procs();
    omp_set_num_threads(thread_count);
}

int pbnds_threads(void)
{
    if (thread_count == 0) pbnds_set_threads(0);
    return thread_count;
}

void pbnds_parallel_for(size_t count, void (*body)(void *context, size_t i, int thread),
                        void *context)
{
    const int threads = pbnds_threads();
#pragma omp parallel num_threads(threads)
    {
#if defined(__SSE__)
        const unsigned saved = _mm_getcsr();
        _mm_setcsr(saved | 0x8040u); /* flush to zero, denormals are zero */
#endif
        const int thread = omp_get_thread_num();
#pragma omp for schedule(dynamic, 1)
        for (size_t i = 0; i < count; ++i) {
            if (!pbnds_stop_requested()) body(context, i, thread);
        }
#if defined(__SSE__)
        _mm_setcsr(saved);
#endif
    }
}
