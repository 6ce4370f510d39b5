#!/usr/bin/env bash
# tools/judge_cycles, small: Blender's Cycles sees the chart lit as we do, under a turned light
# map of another convention.
command -v blender >/dev/null && command -v oiiotool >/dev/null || {
    echo "blender or oiiotool is not installed: skipped"
    exit 77
}
. "$(dirname "$0")/lib.sh"
judge() { # CONVENTION the map is read with
    cat >list <<LIST
chart | $SOURCE/scenes/chart.glb | $1 | 32 | --camera front --env-convention falcor --env-yaw -35
LIST
    "$SOURCE/tools/judge_cycles" --pbnds "$PBNDS" --list list --size 48x32 --material lambert \
        --min 25 -o judged
}
run 0 judge "$SOURCE/scenes/chart.hdr"
check grep -q "^| chart " stdout
check [ -s judged/chart.png ]
run 1 "$SOURCE/tools/judge_cycles" --pbnds "$PBNDS" "$SOURCE/scenes/chart.glb" --size 16x16 \
    --spp 4 --min 99 --env "$SOURCE/scenes/chart.hdr" -o judged
run 1 "$SOURCE/tools/judge_cycles" --pbnds "$PBNDS" missing.glb -o judged
run 2 "$SOURCE/tools/judge_cycles" --pbnds "$PBNDS" --size
run 2 "$SOURCE/tools/judge_cycles" --nonsense
finish
