#!/usr/bin/env bash
# G-buffer files from the command line: every option of what is stored, the lint, what other
# programs made, and what OpenImageIO makes of our files.
. "$(dirname "$0")/lib.sh"
export PYTHONPATH=$HERE

# Channels and header as asked for.
all="--size 60x40 --aov-samples 4 --aov-through alpha --aovs --cryptomatte"
run 0 "$PBNDS" gbuffer box.gltf -o plain.exr --size 60x40
run 0 "$PBNDS" gbuffer box.gltf -o all.exr $all --threads 1
cp all.exr one.exr
run 0 "$PBNDS" gbuffer box.gltf -o all.exr $all --threads 3
run 0 "$PBNDS" gbuffer box.gltf -o world.exr --size 60x40 --normal-space world --depth distance
check python3 - <<'PY'
import exr
_, _, plain = exr.read("plain.exr")
_, _, all_ = exr.read("all.exr")
_, _, one = exr.read("one.exr")
_, _, world = exr.read("world.exr")
required = {"albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "specular.R",
            "roughness.R", "Z", "metallic.R", "coverage.A", "position.X", "emission.G", "object_id"}
assert required <= set(plain), set(plain)
assert set(all_) - set(plain) == {"uv.U", "uv.V", "ao.R", "material_id"} | {
    "Crypto%s0%d.%s" % (k, i, c) for k in ("Object", "Material") for i in range(3) for c in "RGBA"}
assert all_ == one, "threads"
cells = [(x, y) for y in range(40) for x in range(60)]
part = sum(0 < all_["coverage.A"][y][x] < 1 for x, y in cells)
assert part > 30, part
assert all(plain["coverage.A"][y][x] in (0, 1) for x, y in cells)
hit = [(x, y) for x, y in cells if plain["coverage.A"][y][x]]
assert any(abs(world["Z"][y][x] - plain["Z"][y][x]) > 0.01 for x, y in hit)
assert all(world["Z"][y][x] >= plain["Z"][y][x] - 1e-5 for x, y in hit)
assert all(world["position.X"][y][x] == plain["position.X"][y][x] for x, y in hit)
tops = [(x, y) for x, y in hit if abs(world["normal.Y"][y][x] - 1) < 1e-6]
assert len(tops) > 100 and all(plain["normal.Y"][y][x] < 0.999 for x, y in tops)
PY
run 0 "$PBNDS" info all.exr --json
check python3 - <<'PY'
import json
a = json.load(open("stdout"))["attributes"]
assert a["pbnds:samples"] == 4 and a["pbnds:through"] == "alpha" and a["pbnds:contract"] == 1, a
assert a["cryptomatte/3ae39a5/name"] == "CryptoObject"
assert a["cryptomatte/3ae39a5/conversion"] == "uint32_to_float32"
json.loads(a["cryptomatte/3ae39a5/manifest"]), json.loads(a["cryptomatte/be359d6/manifest"])
PY
for file in plain all world; do
    run 0 "$PBNDS" check $file.exr
    check grep -q "^$file.exr: G-buffer, sound$" stdout
done
# Shading what was stored in world space and distance is shading what was not.
run 0 "$PBNDS" shade plain.exr -o a.exr --env light.hdr --shader ggx
run 0 "$PBNDS" shade world.exr -o b.exr --env light.hdr --shader ggx
check python3 - <<'PY'
import exr
a, b = exr.read("a.exr")[2], exr.read("b.exr")[2]
assert max(abs(p - q) for c in "RGB" for r, s in zip(a[c], b[c]) for p, q in zip(r, s)) < 1e-4
PY
# Mattes and optional planes survive shading.
run 0 "$PBNDS" shade all.exr -o a.exr --env light.hdr --shader ggx
check python3 -c '
import exr
a, b = exr.read("all.exr")[2], exr.read("a.exr")[2]
assert all(a[k] == b[k] for k in a if k[:6] == "Crypto" or k[:3] in ("uv.", "ao.") or k == "material_id")'

# Motion: a card at 4 m goes 0.5 m/s to the right, the camera 0.1 m/s to the left, so in half a
# second 0.3 m; 40 rows at 90 degrees show 5 pixels a metre there.
python3 - <<'PY'
import base64, json, struct
f = lambda *v: struct.pack("<%df" % len(v), *v)
parts = [f(-9, -9, -4, 9, -9, -4, 9, 9, -4, -9, 9, -4), struct.pack("<6H", 0, 1, 2, 0, 2, 3),
         f(0, 2), f(0, 0, 0, 1, 0, 0), f(0, 0, 0, -0.2, 0, 0)]
views, at = [], 0
for p in parts:
    views.append({"buffer": 0, "byteOffset": at, "byteLength": len(p)})
    at += len(p)
accessor = lambda v, n, kind, component=5126, **more: dict(
    bufferView=v, componentType=component, count=n, type=kind, **more)
json.dump({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "buffers": [{"byteLength": at, "uri": "data:application/octet-stream;base64," +
                 base64.b64encode(b"".join(parts)).decode()}],
    "bufferViews": views,
    "accessors": [accessor(0, 4, "VEC3", min=[-9, -9, -4], max=[9, 9, -4]),
                  accessor(1, 6, "SCALAR", 5123), accessor(2, 2, "SCALAR", min=[0], max=[2]),
                  accessor(3, 2, "VEC3"), accessor(4, 2, "VEC3")],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1.5707963267948966, "znear": 0.1}}],
    "nodes": [{"mesh": 0, "name": "card"}, {"camera": 0, "name": "eye"}],
    "animations": [{"samplers": [{"input": 2, "output": 3}, {"input": 2, "output": 4}],
                    "channels": [{"sampler": i, "target": {"node": i, "path": "translation"}}
                                 for i in (0, 1)]}]}, open("moving.gltf", "w"))
PY
run 0 "$PBNDS" gbuffer moving.gltf -o m.exr --size 60x40 --time 1 --motion 0.5
check python3 -c '
import exr
c = exr.read("m.exr")[2]
u, v = c["motion.U"], c["motion.V"]
assert all(abs(x - 1.5) < 1e-3 for row in u for x in row), u[20][30]
assert all(abs(x) < 1e-3 for row in v for x in row)'
run 0 "$PBNDS" check m.exr
refuse 2 "motion" "$PBNDS" gbuffer moving.gltf -o x.exr --motion 0.5

# The lint says what, where, how often; status 3.
run 3 "$PBNDS" check nan.exr
check grep -q "fault  *finite" stdout
check grep -q "pixel" stdout
check [ "$(wc -l <stderr)" -eq 1 ]
run 3 "$PBNDS" check nan.exr --json
check python3 -c '
import json
t = json.load(open("stdout"))
assert t["sound"] == 0 and any(f["rule"] == "finite" and f["level"] == "fault" for f in t["findings"]), t'
run 0 "$PBNDS" check all.exr --json
check python3 -c 'import json; assert json.load(open("stdout"))["findings"] == []'
run 0 "$PBNDS" check foreign.exr
check grep -q "warning  *contract" stdout

# Blender's files: one, and a folder of them.
blender=$SOURCE/tests/golden/blender/multilayer.exr
run 0 "$PBNDS" import blender "$blender" -o imported.exr
check grep -q "camera: from the Position pass, 40.00 degrees" stdout
run 0 "$PBNDS" check imported.exr
run 0 "$PBNDS" shade imported.exr -o x.png --env light.hdr --shader ggx
mkdir -p renders && cp "$blender" renders/a.exr && cp "$blender" renders/b.exr
run 0 "$PBNDS" import blender renders -o out_folder --json
check python3 -c '
import json
lines = [json.loads(l) for l in open("stdout")]
assert [l["output"] for l in lines] == ["out_folder/a.exr", "out_folder/b.exr"]
assert lines[0]["width"] == 48 and any("view layer" in n for n in lines[0]["notes"])'
check [ -s out_folder/b.exr ]
refuse 4 "DWAB" "$PBNDS" import blender "$SOURCE/tests/fuzz/corpus/gbuffer/c_dwab.exr" -o x2.exr
refuse 3 "MultiLayer" "$PBNDS" import blender rgb.exr -o x2.exr
refuse 1 "missing.exr" "$PBNDS" import blender missing.exr -o x2.exr
refuse 3 "renders: has no folder" "$PBNDS" import ffhq-pbr renders -o x2.exr
refuse 2 "'maya' is not one of blender, images" "$PBNDS" import maya renders -o x2.exr
refuse 2 "as .exr" "$PBNDS" import blender "$blender" -o x2.png
check [ ! -e x2.exr ]

# Folders of maps.
mkdir -p maps empty_maps
run 0 "$PBNDS" render box.gltf -o maps/albedo.png --size 32x24 --env light.hdr --shader ggx
run 0 "$PBNDS" import images maps -o maps.exr --fov 30
check grep -q "albedo: from albedo.png" stdout
check grep -q "roughness: 0.5 everywhere, there is no such map" stdout
check grep -q "30.00 degrees" stdout
run 0 "$PBNDS" check maps.exr
run 0 "$PBNDS" shade maps.exr -o x.png --env light.hdr --shader ggx
refuse 3 "neither albedo nor normal" "$PBNDS" import images empty_maps -o x3.exr
refuse 1 "no_maps" "$PBNDS" import images no_maps -o x3.exr
check [ ! -e x3.exr ]

# OpenImageIO opens all of it; what it extracts is what we read.
if command -v oiiotool >/dev/null && command -v idiff >/dev/null; then
    run 0 oiiotool --info -v all.exr
    check grep -q "60 x *40, 46 channel" stdout
    check grep -q "worldToCamera: " stdout
    check grep -q 'cryptomatte/3ae39a5/name: "CryptoObject"' stdout
    check grep -q "object_id (uint)" stdout
    run 0 oiiotool all.exr --ch Z --printstats
    check grep -q "NanCount: 0 *$" stdout
    run 0 oiiotool plain.exr --ch normal.X,normal.Y,normal.Z --printstats
    check grep -q "NanCount: 0 0 0 *$" stdout
    check grep -q "InfCount: 0 0 0 *$" stdout
    for file in plain a; do # a.exr: the same planes, read and written once more
        source=$([ $file = a ] && echo all || echo plain)
        for set in albedo.R,albedo.G,albedo.B coverage.A,roughness.R,metallic.R Z; do
            run 0 oiiotool $source.exr --ch $set -o first.exr
            run 0 oiiotool $file.exr --ch $set -o second.exr
            run 0 idiff -fail 0 -warn 0 first.exr second.exr
        done
    done
    run 0 oiiotool plain.exr --ch albedo.R -o first.exr
    run 0 oiiotool all.exr --ch albedo.R -o second.exr
    run 2 idiff -fail 0.001 first.exr second.exr # edges differ: the comparison can fail
else
    echo "openimageio-tools are not installed: not compared"
fi

# The floor is one-sided: from below the camera looks through it, unless told not to.
below="--size 40x40 --look 0,-70"
run 0 "$PBNDS" gbuffer box.gltf -o hidden.exr $below
run 0 "$PBNDS" gbuffer box.gltf -o shown.exr $below --backfaces
check python3 - <<'PY'
import exr
covered = [sum(map(sum, exr.read(f + ".exr")[2]["coverage.A"])) for f in ("hidden", "shown")]
assert 0 < covered[0] < 100 < 500 < covered[1], covered
PY
clean_folder .
finish
