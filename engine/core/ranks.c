#include "engine/core/ranks.h"

#include <stdlib.h>

/* What Open MPI, MPICH and Slurm tell the processes that they start together. */
static bool is_launched(void)
{
    static const char *const NAMES[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};
    for (size_t i = 0; i < sizeof NAMES / sizeof NAMES[0]; ++i) {
        const char *size = getenv(NAMES[i]);
        if (size && atoi(size) > 1) return true;
    }
    return false;
}

#ifdef PBNDS_HAS_MPI

#include <limits.h>
#include <mpi.h>
#include <stdint.h>

static struct {
    bool open;
    int rank, count;
} ranks = {false, 0, 1};

enum pbnds_status pbnds_ranks_init(struct pbnds_error *error)
{
    if (ranks.open || !is_launched()) return PBNDS_OK;
    int provided;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS)
        return pbnds_fail(error, PBNDS_ERROR_BACKEND, "MPI cannot be started");
    (void)MPI_Comm_rank(MPI_COMM_WORLD, &ranks.rank);
    (void)MPI_Comm_size(MPI_COMM_WORLD, &ranks.count);
    ranks.open = true;
    return PBNDS_OK;
}

void pbnds_ranks_finish(void)
{
    if (!ranks.open) return;
    (void)MPI_Finalize();
    ranks.open = false;
    ranks.rank = 0;
    ranks.count = 1;
}

int pbnds_rank(void)
{
    return ranks.rank;
}

int pbnds_rank_count(void)
{
    return ranks.count;
}

void pbnds_ranks_barrier(void)
{
    if (ranks.open) (void)MPI_Barrier(MPI_COMM_WORLD);
}

void pbnds_ranks_sum(double *x, size_t count)
{
    if (!ranks.open) return;
    for (size_t done = 0; done < count;) {
        const size_t left = count - done, part = left < INT_MAX ? left : INT_MAX;
        (void)MPI_Allreduce(MPI_IN_PLACE, x + done, (int)part, MPI_DOUBLE, MPI_SUM,
                            MPI_COMM_WORLD);
        done += part;
    }
}

enum { SUM_BLOCK = 1 << 22 }; /* floats of which the parts are exchanged at once */

/* What each rank adds up of n floats: where it begins and how much it is. */
static void share_out(int n, int *counts, int *starts)
{
    const int part = (n + ranks.count - 1) / ranks.count;
    for (int r = 0; r < ranks.count; ++r) {
        const int64_t first = (int64_t)r * part;
        starts[r] = first < n ? (int)first : n;
        counts[r] = n - starts[r] < part ? n - starts[r] : part;
    }
}

/* plan: 4 arrays of ranks.count; parts: what the others send of this rank's share. */
static void sum_block(float *x, int n, int *plan, float *parts)
{
    int *counts = plan, *starts = plan + ranks.count, *mine = starts + ranks.count,
        *places = mine + ranks.count;
    share_out(n, counts, starts);
    const int share = counts[ranks.rank];
    for (int r = 0; r < ranks.count; ++r) {
        mine[r] = share;
        places[r] = r * share;
    }
    (void)MPI_Alltoallv(x, counts, starts, MPI_FLOAT, parts, mine, places, MPI_FLOAT,
                        MPI_COMM_WORLD);
    float *sum = x + starts[ranks.rank];
    for (int i = 0; i < share; ++i) {
        double total = 0.0;
        for (int r = 0; r < ranks.count; ++r)
            total += (double)parts[(size_t)r * (size_t)share + (size_t)i];
        sum[i] = (float)total;
    }
    (void)MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, x, counts, starts,
                         MPI_FLOAT, MPI_COMM_WORLD);
}

enum pbnds_status pbnds_ranks_sum_in_order(float *x, size_t count,
                                           struct pbnds_error *error)
{
    if (!ranks.open || ranks.count == 1) return PBNDS_OK;
    const size_t block = count < SUM_BLOCK ? count : SUM_BLOCK;
    const size_t k = (size_t)ranks.count;
    int *plan = malloc(4 * k * sizeof *plan);
    float *parts = malloc((block + k) * sizeof *parts);
    enum pbnds_status status = PBNDS_OK;
    if (pbnds_ranks_max(!plan || !parts) != 0) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY,
                            "no memory to add up %zu numbers of %d processes", count,
                            ranks.count);
    }
    for (size_t done = 0; status == PBNDS_OK && done < count; done += block) {
        const size_t left = count - done;
        sum_block(x + done, (int)(left < block ? left : block), plan, parts);
    }
    free(plan);
    free(parts);
    return status;
}

int pbnds_ranks_max(int x)
{
    int greatest = x;
    if (ranks.open)
        (void)MPI_Allreduce(&x, &greatest, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    return greatest;
}

#else

enum pbnds_status pbnds_ranks_init(struct pbnds_error *error)
{
    if (!is_launched()) return PBNDS_OK;
    return pbnds_fail(
        error, PBNDS_ERROR_BACKEND,
        "this build has no MPI, so each process of mpirun would do all of "
        "the work; build it where Open MPI is installed, or use --shard");
}

void pbnds_ranks_finish(void) {}

int pbnds_rank(void)
{
    return 0;
}

int pbnds_rank_count(void)
{
    return 1;
}

void pbnds_ranks_barrier(void) {}

void pbnds_ranks_sum(double *x, size_t count)
{
    (void)x;
    (void)count;
}

enum pbnds_status pbnds_ranks_sum_in_order(float *x, size_t count,
                                           struct pbnds_error *error)
{
    (void)x;
    (void)count;
    (void)error;
    return PBNDS_OK;
}

int pbnds_ranks_max(int x)
{
    return x;
}

#endif
