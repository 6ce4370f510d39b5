#!/usr/bin/env bash
# Pictures: the channels of the contract, the same at any thread count, a G-buffer file shades
# as the scene does.
. "$(dirname "$0")/lib.sh"
light="--env light.hdr --env-yaw 30"
ggx="--env light.hdr --env-yaw 30 --spp 4 --shader ggx"

for shader in blinn-phong ggx paper-blinn-phong paper-ggx reference; do
    run 0 "$PBNDS" render box.gltf -o "$shader.exr" --preview "$shader.png" --size 64x64 $light \
        --spp 4 --shader $shader --shadows off
    check grep -q "^$shader.exr: 64x64, $shader" stdout
    check [ -s "$shader.exr" ] && check [ -s "$shader.png" ]
done
check [ ! -s stderr ]

# Another program reads it, with the channels and the attributes of the contract.
if command -v oiiotool >/dev/null; then
    run 0 oiiotool --info -v ggx.exr
    check grep -q "64 x *64" stdout
    for name in R G B A albedo.R albedo.G albedo.B normal.X normal.Y normal.Z specular.R \
        roughness.R metallic.R coverage.A Z; do
        check grep -q -e "channel list:.*\b$name\b" stdout
    done
    check grep -q "zip" stdout
    check grep -q "worldToCamera" stdout
    check grep -q "light.hdr" stdout
    run 0 oiiotool --stats ggx.exr
    check grep -q "Stats NanCount: 0 0 0 0" stdout
else
    echo "oiiotool is not installed: its checks are skipped"
fi
run 0 "$PBNDS" info ggx.exr --json
check python3 - stdout <<'PY'
import json, sys
facts = json.load(open(sys.argv[1]))
assert facts["kind"] == "G-buffer" and facts["size"] == [64, 64], facts
assert any(c["name"] == "Z" and c["type"] == "float" for c in facts["channels"])
assert any("light.hdr" in str(v) for v in facts["attributes"].values())
PY

# One seed gives one picture at any number of threads; another seed another one.
for threads in 1 2 3; do
    run 0 "$PBNDS" render box.gltf -o t$threads.png --size 48x40 $light --shader reference \
        --spp 8 --threads $threads --seed 5
done
check cmp t1.png t2.png
check cmp t1.png t3.png
run 0 "$PBNDS" render box.gltf -o t4.png --size 48x40 $light --shader reference --spp 8 --seed 6
check eval '! cmp -s t1.png t4.png'

# .gltf and .glb of one scene give one picture; the named camera is the first one.
run 0 "$PBNDS" render box.glb -o glb.png --size 64x64 $ggx --shadows off --camera main
run 0 "$PBNDS" render box.gltf -o gltf.png --size 64x64 $ggx --shadows off
check cmp glb.png gltf.png
check cmp gltf.png ggx.png

# Options that change the picture do.
n=0
for option in "--env-yaw 120" "--exposure 1" "--tonemap none" "--look 0,0" "--fov 60" \
    "--env-strength 2" "--env-convention pbnds" "--background none" "--shadows on" \
    "--env black.hdr" "--env none"; do
    n=$((n + 1))
    run 0 "$PBNDS" render box.gltf -o o.png --size 64x64 $ggx --shadows off $option
    check eval '! cmp -s o.png ggx.png'
done
run 0 "$PBNDS" render no_camera.gltf -o o.png --size 64x64 $ggx
run 0 "$PBNDS" render no_camera.gltf -o p.png --size 64x64 $ggx --look 30,20 --fov 40
check cmp o.png p.png

# The deferred stage alone: a G-buffer file, or a render with its AOVs, shades as the scene does.
run 0 "$PBNDS" gbuffer box.gltf -o g.exr --size 64x64
check grep -q "covered" stdout
for from in g.exr reference.exr; do
    run 0 "$PBNDS" shade $from -o s.exr --preview s.png $ggx
    run 0 "$PBNDS" compare $from -o same $light --shaders ggx --spp 4 --against ggx.exr --json s.json
    check python3 - s.json <<'PY'
import json, sys
row = json.load(open(sys.argv[1]))["rows"][0]
# The file keeps colours as half floats, finer than 8 bits: 59 dB is one step everywhere.
assert row["psnr"] is None or row["psnr"] > 59, row
PY
done

# A G-buffer of another program: no camera, the least channels.
run 0 "$PBNDS" shade foreign.exr -o f.exr $light --shader ggx
run 0 "$PBNDS" check f.exr
run 0 "$PBNDS" check box.glb
run 0 "$PBNDS" check light.hdr
run 0 "$PBNDS" info box.gltf
check grep -q "triangles: 26" stdout
check grep -q '"name":"main"' stdout

# Without --env, the sky that ships: here with a folder of our own.
mkdir -p share/scenes && cp light.hdr share/scenes/sky.hdr
run 0 env PBNDS_DATA=share "$PBNDS" render box.gltf -o o.png --size 64x64 --spp 4 --shader ggx \
    --env-yaw 30 --shadows off
check cmp o.png ggx.png

# One line a stage, key=value.
run 0 "$PBNDS" bench gbuffer --size 64x64
check grep -qE '^stage=gbuffer size=64x64 threads=[0-9]+ runs=5 .*pixels_per_s=[1-9]' stdout
run 0 "$PBNDS" bench dataset --size 16x16
check grep -qE '^stage=dataset size=16x16 spp=256 .*samples_per_s=[0-9.]+ .*added=[0-9]' stdout
check test -z "$(find . -maxdepth 1 -name 'pbnds-bench-*')"
refuse 2 "'rays' is not a shader" "$PBNDS" bench rays

# Only errors are told with --quiet; standard output that cannot be written is one.
run 0 "$PBNDS" render box.gltf -o q.png --size 16x16 $light --shader ggx --quiet
check [ ! -s stderr ]
checks=$((checks + 1))
if [ -w /dev/full ]; then
    "$PBNDS" info box.gltf >/dev/full 2>stderr
    [ $? -eq 1 ] && grep -q "standard output" stderr || fail "a full standard output"
fi
checks=$((checks + 1))
"$PBNDS" --help 2>stderr | true
[ "${PIPESTATUS[0]}" -le 1 ] || fail "a closed pipe kills"
clean_folder .
finish
