#!/usr/bin/env bash
# The calibration chart comes out right: known albedos and depths, texel and normal map
# orientation, and the light from where each convention of light maps says.
. "$(dirname "$0")/lib.sh"
chart=$SOURCE/scenes/chart.glb
map=$SOURCE/scenes/chart.hdr
look="--camera front --shader reference --spp 4 --size 180x120"

run 0 "$PBNDS" render "$chart" -o cards.exr --env "$map" $look
check python3 "$HERE/chart.py" cards cards.exr

for convention in gltf openexr falcor pbnds; do
    for yaw in 0 -35; do
        run 0 "$PBNDS" render "$chart" -o o.exr --env "$map" $look \
            --env-convention $convention --env-yaw=$yaw
        check python3 "$HERE/chart.py" light o.exr $convention $yaw
    done
done

# u_openexr = u - 1/4, u_falcor = u + 1/4, u_pbnds = u + 1/2: a map in such a convention, its
# columns moved, shows the same background to the bit.
run 0 "$PBNDS" render "$chart" -o gltf.exr --env "$map" $look
for roll in openexr:-1 falcor:1 pbnds:2; do
    run 0 python3 "$HERE/chart.py" roll "$map" ${roll#*:} rolled.hdr
    run 0 "$PBNDS" render "$chart" -o rolled.exr --env rolled.hdr $look \
        --env-convention ${roll%:*}
    check python3 - gltf.exr rolled.exr <<PY
import sys
sys.path.insert(0, "$HERE")
import exr
a, b = (exr.read(p)[2] for p in sys.argv[1:])
free = [(x, y) for y, row in enumerate(a["coverage.A"]) for x, c in enumerate(row) if not c]
assert len(free) > 5000
assert all(a[c][y][x] == b[c][y][x] for c in "RGB" for x, y in free)
PY
done
finish
