#!/usr/bin/env bash
# A data set by a Slurm array: every task makes its part into one folder on a shared file
# system. A task that was killed or preempted is submitted again and goes on where it was.
#
#   sbatch --export=ALL,RECIPE=recipe.json,ROOT=/data/assets,OUT=/data/set tools/slurm/dataset_array.sh
#
# With MPI instead of an array, one job of several nodes:
#   srun -n 64 --mpi=pmix pbnds dataset --recipe recipe.json --root /data/assets -o /data/set
#SBATCH --job-name=pbnds-dataset
#SBATCH --array=0-15
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=4
#SBATCH --mem=8G
#SBATCH --time=08:00:00
#SBATCH --requeue
#SBATCH --signal=TERM@60
set -euo pipefail
: "${RECIPE:?the recipe file}" "${OUT:?the folder of the data set}"
exec "${PBNDS:-pbnds}" dataset --recipe "$RECIPE" ${ROOT:+--root "$ROOT"} -o "$OUT" \
    --shard "$((SLURM_ARRAY_TASK_ID - ${SLURM_ARRAY_TASK_MIN:-0}))/$SLURM_ARRAY_TASK_COUNT" \
    --threads "${SLURM_CPUS_PER_TASK:-1}"
