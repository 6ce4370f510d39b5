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

int pbnds_ranks_max(int x)
{
    return x;
}

#endif
