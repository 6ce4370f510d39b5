#!/usr/bin/env bash
# pbnds shade --cache: made once, then read; refused where it is not of this view or weights.
. "$(dirname "$0")/lib.sh"
export PBNDS_DATA=$SOURCE
run 0 "$PBNDS" gbuffer "$SOURCE/scenes/still_life.glb" -o g.exr --size 48x32
run 0 "$PBNDS" gbuffer "$SOURCE/scenes/still_life.glb" -o h.exr --size 48x32 --look 100,10
shade() { run "$1" "$PBNDS" shade "$2" -o "$3" --shader transport --precision fp32 --background none "${@:4}"; }

shade 0 g.exr first.exr --cache view.cache --lights 24
check [ -s view.cache ]
cp view.cache kept
shade 0 g.exr second.exr --cache view.cache --threads 2
check cmp view.cache kept
check grep -q "from .* MB of cache" stdout
# another light is another picture; no light is none
shade 0 g.exr turned.exr --cache view.cache --env-yaw 120
shade 0 g.exr dark.exr --cache view.cache --env none
shade 0 g.exr plain.exr
check python3 - <<PY
import sys, math
sys.path.insert(0, "$HERE")
import exr
def radiance(path):
    channels = exr.read(path)[2]
    return [[v for row in channels[c] for v in row] for c in "RGB"]
first, second, turned, dark, plain = (
    radiance(p + ".exr") for p in ("first", "second", "turned", "dark", "plain"))
assert first == second and first != turned
assert all(v == 0 for c in dark for v in c)
flat = lambda p: [math.log1p(max(v, 0)) for c in p for v in c]
a, b = flat(first), flat(plain)
rms = lambda d: math.sqrt(sum(x * x for x in d) / len(d))
error = rms([x - y for x, y in zip(a, b)]) / rms(b)
assert 0 < error < 0.25, error
PY

refuse 3 "another G-buffer" "$PBNDS" shade h.exr -o no.exr --shader transport \
    --precision fp32 --cache view.cache
refuse 2 "is not linear in light" "$PBNDS" shade g.exr -o no.exr --shader pbnds+ --cache other
refuse 2 "is not linear in light" "$PBNDS" shade g.exr -o no.exr --shader ggx --cache other
refuse 2 "holds 24 directions" "$PBNDS" shade g.exr -o no.exr --shader transport \
    --precision fp32 --cache view.cache --lights 25
head -c 5000 kept >view.cache
refuse 3 "no sound light cache" "$PBNDS" shade g.exr -o no.exr --shader transport \
    --precision fp32 --cache view.cache
check [ ! -e no.exr ]
check [ ! -e other ]
clean_folder .
finish
