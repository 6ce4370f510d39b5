#!/usr/bin/env bash
# Two runs of what tools/demo runs, small: the same EXR files and pictures to the byte, at other
# numbers of threads too. The light is blender-data's where it is installed, as in the demo.
. "$(dirname "$0")/lib.sh"
export PBNDS_DATA=$SOURCE
light=/usr/share/blender/datafiles/studiolights/world/courtyard.exr
[ -r "$light" ] || light=$SOURCE/scenes/sky.hdr
shaders=$(sed -n 's/^shaders=//p' "$SOURCE/tools/demo")
check [ -n "$shaders" ]

demo() {
    run 0 "$PBNDS" compare "$SOURCE/scenes/still_life.glb" -o demo --env "$light" --size 64x48 \
        --reference-spp 8 --shaders "$shaders" --json demo.json "$@"
    python3 - demo.json >demo/rows <<'PY'
import json, sys
for row in json.load(open(sys.argv[1]))["rows"]:
    row.pop("seconds")
    print(row)
PY
}

demo
check [ "$(ls demo/*.exr | wc -l)" -ge 5 ]
mv demo first
demo
mv demo second
check diff -r first second
# The file says with which arguments it was made: --threads may differ, nothing else.
for threads in 1 2 5; do
    demo --threads $threads
    for file in first/*; do
        case $file in
        *.exr)
            check python3 - "$file" "demo/${file##*/}" <<PY
import sys
sys.path.insert(0, "$HERE")
import exr
a, b = (exr.read(p) for p in sys.argv[1:])
assert a[2] and str(a) == str(b)
PY
            ;;
        */compare.png) ;; # tells the seconds
        *) check cmp "$file" "demo/${file##*/}" ;;
        esac
    done
    rm -rf demo
done
finish
