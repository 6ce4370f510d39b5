#!/usr/bin/env bash
# Several processes make one data set, by mpirun and as the tasks of a Slurm array; and train
# one network.
. "$(dirname "$0")/lib.sh"

cat >recipe.json <<'JSON'
{"scenes": ["scenes"], "envs": ["envs"], "count": {"train": 7, "test": 2}, "size": [16, 16],
 "spp": 2, "seed": 3}
JSON
run 0 "$PBNDS" dataset --recipe recipe.json -o whole

# The tasks of an array, one after another and out of order, each from the script itself.
export PBNDS RECIPE=recipe.json OUT=array SLURM_ARRAY_TASK_COUNT=3 SLURM_ARRAY_TASK_MIN=1
for task in 2 3 1; do
    SLURM_ARRAY_TASK_ID=$task run 0 "$SOURCE/tools/slurm/dataset_array.sh"
done
check diff -r whole array

if command -v mpirun >/dev/null && ldd "$PBNDS" | grep -q libmpi; then
    # Root is refused and more ranks than cores too, by default; both are right here.
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
    export OMPI_MCA_btl_vader_single_copy_mechanism=none OMP_NUM_THREADS=1
    # What Open MPI keeps at the end is not ours.
    export ASAN_OPTIONS=detect_leaks=0
    for ranks in 2 4; do
        run 0 env PBNDS_TEST_RANKS=$ranks mpirun -q -n $ranks "$(dirname "$PBNDS")/../tests/test_engine_core_ranks"
        run 0 mpirun -q -n $ranks "$PBNDS" dataset --recipe recipe.json -o "mpi$ranks"
        check diff -r whole "mpi$ranks"
        check [ "$(wc -l <stdout)" -eq 1 ]
    done
    # Training: so many processes make the step of one that takes as many views at once, and
    # twice the same processes the same bytes. They stop together, and go on.
    cat >train.json <<'JSON'
{"scenes": ["scenes"], "envs": ["envs"], "count": {"train": 6, "val": 3}, "size": [16, 16],
 "spp": 2, "seed": 4}
JSON
    run 0 "$PBNDS" dataset --recipe train.json -o set
    how="--crop 16 --precision fp32 --threads 1 --quiet --seed 7 --lr 0.002 --ema 0"
    train="$PBNDS train set --model transport $how"
    run 0 $train -o start.safetensors --steps 1 --lr 0.000000001
    run 0 $train -o one.safetensors --steps 3 --batch 4
    run 0 mpirun -q -n 2 $train -o two.safetensors --steps 3 --batch 2
    check [ "$(wc -l <stdout)" -eq 1 ]
    check python3 "$HERE/same_training.py" start one two
    run 0 mpirun -q -n 2 $train -o parts.safetensors --steps 3 --batch 1 --accumulate 2
    check python3 "$HERE/same_training.py" start one parts
    run 0 mpirun -q -n 4 $train -o four.safetensors --steps 3 --batch 1
    check python3 "$HERE/same_training.py" start one four
    run 0 mpirun -q -n 2 $train -o again.safetensors --steps 3 --batch 2 --minutes 0.01
    if [ -e again.safetensors.checkpoint ]; then
        refuse 2 "other options" $train -o again.safetensors --steps 3 --batch 2 --resume
        export LAUNCH="mpirun -q -n 2" DATA=set OUT=again.safetensors
        ARGS="$how --steps 3 --batch 2" run 0 "$SOURCE/tools/slurm/train.sh"
    fi
    check cmp two.safetensors again.safetensors
    check [ ! -e again.safetensors.checkpoint ]
    run 1 timeout 60 mpirun -q -n 2 $train -o no/folder/w.safetensors --steps 3

    # A part that fails is told, and no process waits for ever.
    touch file
    run 1 timeout 60 mpirun -q -n 2 "$PBNDS" dataset --recipe recipe.json -o file/inside
else
    # Without MPI, several processes that do not know of each other would do everything twice.
    if ! ldd "$PBNDS" | grep -q libmpi; then
        refuse 1 "no MPI" env OMPI_COMM_WORLD_SIZE=2 "$PBNDS" dataset --recipe recipe.json -o no
    fi
fi
finish
