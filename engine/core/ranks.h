/**
 * @file ranks.h
 * Processes of one run on one or more machines, through MPI where the build has it
 * (PBNDS_MPI) and mpirun started the program. Otherwise there is one rank, and every call
 * is free. The only file that includes MPI is ranks.c.
 */
#ifndef PBNDS_ENGINE_CORE_RANKS_H
#define PBNDS_ENGINE_CORE_RANKS_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Call once, from the main thread, before any other; the program calls finish() before
 *  it ends. Errors: BACKEND (mpirun started a program that was built without MPI: every
 *  process would do all of the work). */
enum pbnds_status pbnds_ranks_init(struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_ranks_finish(void);

int pbnds_rank(void);       /**< of this process, from 0 */
int pbnds_rank_count(void); /**< 1 without mpirun */

/** Collective: every rank calls it, or all wait for ever. */
void pbnds_ranks_barrier(void);
/** Collective: x[i] becomes the sum over the ranks. Not in a fixed order. */
void pbnds_ranks_sum(double *x, size_t count);
/** Collective: the same for floats, added up in the order of the ranks and in double: the
 *  same bits on every rank, and on every run over as many of them. Each rank adds up a
 *  part and hands it to the others. Errors: MEMORY (on all of them). */
enum pbnds_status pbnds_ranks_sum_in_order(float *x, size_t count,
                                           struct pbnds_error *error) PBNDS_NODISCARD;
/** Collective: the greatest of the ranks' values. */
int pbnds_ranks_max(int x);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_CORE_RANKS_H */
