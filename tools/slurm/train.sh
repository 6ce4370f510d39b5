#!/usr/bin/env bash
# A training over several nodes by MPI. Each process takes --batch views of every step, so a
# step is ntasks times as large as one process's; data and weights lie on a shared file
# system. A job that was preempted or ran out of time is submitted again, with as many tasks,
# and goes on from its checkpoint.
#
#   sbatch --export=ALL,DATA=/data/set,OUT=/data/m.safetensors,MODEL=transport tools/slurm/train.sh
#
# Further options of pbnds train in ARGS. Without Slurm: LAUNCH="mpirun -n 2".
#SBATCH --job-name=pbnds-train
#SBATCH --ntasks=8
#SBATCH --cpus-per-task=4
#SBATCH --mem-per-cpu=2G
#SBATCH --time=24:00:00
#SBATCH --requeue
#SBATCH --signal=TERM@120
set -euo pipefail
: "${DATA:?the folder of the data set}" "${OUT:?the weights file to write}"
read -ra launch <<<"${LAUNCH:-srun --mpi=pmix}"
read -ra args <<<"${ARGS:-}"
exec "${launch[@]}" "${PBNDS:-pbnds}" train "$DATA" -o "$OUT" --model "${MODEL:-transport}" \
    --resume --threads "${SLURM_CPUS_PER_TASK:-1}" "${args[@]}"
