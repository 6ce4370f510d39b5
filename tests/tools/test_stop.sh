#!/usr/bin/env bash
# Ctrl-C and a full disk: status 1, one sentence, no partial file, nothing lost of earlier work.
. "$(dirname "$0")/lib.sh"

# Waits until the program answers to signals: before, the process is still the shell that
# forked it, which catches signals of its own, or loads its libraries.
ready() {
    local caught
    for _ in $(seq 3000); do
        if [ "$(cat "/proc/$1/comm" 2>/dev/null)" = pbnds ]; then
            caught=$(awk '/^SigCgt/ { print $2 }' "/proc/$1/status" 2>/dev/null)
            [ $((0x${caught:-0} & 0x4002)) -eq $((0x4002)) ] && return # TERM and INT
        fi
        sleep 0.01
    done
}

# halt SIGNAL PID: sends it and wants status 1 and one sentence soon.
halt() {
    kill -s "$1" "$2" 2>/dev/null || fail "ended before it was stopped"
    for _ in $(seq 300); do
        kill -0 "$2" 2>/dev/null || break
        sleep 0.1
    done
    kill -KILL "$2" 2>/dev/null && fail "not stopped within thirty seconds"
    wait "$2"
    local got=$?
    [ $got -eq 1 ] || fail "status $got, not 1, after $1"
    [ "$(wc -l <stderr)" -eq 1 ] && grep -q "^pbnds: .*interrupted" stderr ||
        fail "not one sentence about it"
}

# stop SIGNAL COMMAND...: sends the signal when the work has begun.
stop() {
    local signal=$1 pid
    shift
    checks=$((checks + 1))
    "$@" >stdout 2>stderr &
    pid=$!
    ready $pid
    sleep 0.5
    halt "$signal" $pid
}

echo earlier >kept.exr
for signal in INT TERM; do
    stop $signal "$PBNDS" render box.gltf -o kept.exr --env light.hdr --shader reference \
        --spp 400 --size 1024x1024 --quiet
    check [ "$(cat kept.exr)" = earlier ]
    stop $signal "$PBNDS" compare box.gltf -o out --env light.hdr --shaders ggx \
        --reference-spp 400 --size 1024x1024 --quiet
    check [ ! -e out/compare.png ]
done
clean_folder .

# A data set that was stopped goes on: what was made stays, and the end is the same.
make="$PBNDS dataset scenes --envs envs --count 24 --size 64x64 --spp 64 --seed 1 --quiet"
checks=$((checks + 1))
$make -o stopped >stdout 2>stderr &
pid=$!
for _ in $(seq 1000); do
    compgen -G 'stopped/*/*/sample.exr' >made && break
    sleep 0.05
done
halt INT $pid
clean_folder stopped
check [ "$(find stopped -name sample.exr | wc -l)" -lt 24 ]
run 0 $make -o stopped
run 0 $make -o data
check diff -r data stopped

# Training leaves a checkpoint and goes on from it.
train="$PBNDS train data -o w.safetensors --model transport --crop 32 --batch 1 --precision fp32"
train="$train --steps 200"
checks=$((checks + 1))
$train --quiet >stdout 2>stderr &
pid=$!
for _ in $(seq 600); do
    [ -s w.safetensors.checkpoint ] && break
    sleep 0.2
done
halt INT $pid
check [ -s w.safetensors.checkpoint ]
rows=$(wc -l <w.safetensors.csv)
run 0 $train --resume --minutes 0.01
check grep -q "resume goes on" stderr
check [ "$(wc -l <w.safetensors.csv)" -eq $((rows + 1)) ]
clean_folder .

# Full disk: a small one where we may mount, and a limit on the size of files everywhere.
full() {
    local target=$1
    shift
    refuse 1 "$target" "$@"
    check [ ! -e "$target" ]
    clean_folder "$(dirname "$target")"
}
big="--size 256x256 --env light.hdr --shader ggx --spp 1"
limited() { (ulimit -f 16 && "$@"); }
mkdir small
full small/out.exr limited "$PBNDS" render box.gltf -o small/out.exr $big
full small/out.png limited "$PBNDS" render box.gltf -o small/out.png $big
full small/g.exr limited "$PBNDS" gbuffer box.gltf -o small/g.exr --size 256x256
if [ "$(id -u)" -eq 0 ] && mount -t tmpfs -o size=16k tmpfs small 2>/dev/null; then
    trap 'umount "$WORK/small"; rm -rf "$WORK"' EXIT
    full small/out.exr "$PBNDS" render box.gltf -o small/out.exr $big
    full small/out.png "$PBNDS" render box.gltf -o small/out.png $big
    echo earlier >small/kept.exr
    refuse 1 "small/kept.exr" "$PBNDS" render box.gltf -o small/kept.exr $big
    check [ "$(cat small/kept.exr)" = earlier ]
    # A data set goes on past what does not fit, and has it made when there is room again.
    for format in folders tar; do
        make="$PBNDS dataset scenes --envs envs --count 12 --size 16x16 --spp 1 --quiet
            --format $format --per-tar 4"
        run 0 $make -o whole-$format
        rm -rf small/*
        mount -o remount,size=150k small
        run 1 $make -o small/data
        check grep -q "No space left" stderr
        check [ ! -e small/data/quarantine ]
        check [ ! -e small/data/manifest.json ]
        mount -o remount,size=10m small
        run 0 $make -o small/data
        check diff -r whole-$format small/data
    done
else
    echo "no right to mount: the full file system itself is skipped"
fi
finish
