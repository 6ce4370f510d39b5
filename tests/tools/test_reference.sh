#!/usr/bin/env bash
# The reference from the command line: its variance channels, its noise target, and its own
# coverage before a background, for a half-transparent pane and for an edge.
. "$(dirname "$0")/lib.sh"

# A pane that fills the view, unlit and black, of opacity 0.3; the same one upright in half of
# the view, opaque; a white sky.
python3 - <<'PY'
import base64, json, struct

def scene(name, x0, alpha):
    points = [(x0, -50.0, 0.0), (50.0, -50.0, 0.0), (50.0, 50.0, 0.0), (x0, 50.0, 0.0)]
    blob = b"".join(struct.pack("<3f", *p) for p in points)
    blob += struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    json.dump({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "extensionsUsed": ["KHR_materials_unlit"],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 5]}],
        "cameras": [{"type": "orthographic",
                     "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 10}}],
        "materials": [{"alphaMode": "BLEND" if alpha < 1 else "OPAQUE",
                       "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, alpha]},
                       "extensions": {"KHR_materials_unlit": {}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1,
                                    "material": 0}]}],
        "buffers": [{"uri": uri, "byteLength": len(blob)}],
        "bufferViews": [{"buffer": 0, "byteLength": 48},
                        {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                       "min": [x0, -50, 0], "max": [50, 50, 0]},
                      {"bufferView": 1, "componentType": 5123, "count": 6,
                       "type": "SCALAR"}]}, open(name, "w"))

scene("pane.gltf", -50.0, 0.3)
scene("denser.gltf", -50.0, 0.6)
scene("edge.gltf", 1.0 / 16, 1.0)  # 16 pixels across: a quarter of the ninth is free
with open("white.hdr", "wb") as f:
    f.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes((128, 128, 128, 129)) * 32)
PY

# Mean of columns of an 8-bit RGB PNG, decoded to linear.
cat >mean.py <<'PY'
import struct, sys, zlib

def linear(v):
    v /= 255.0
    return v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4

data, at, idat = open(sys.argv[1], "rb").read(), 8, b""
while at < len(data):
    n, kind = struct.unpack(">I4s", data[at:at + 8])
    if kind == b"IHDR":
        width, height = struct.unpack(">II", data[at + 8:at + 16])
    if kind == b"IDAT":
        idat += data[at + 8:at + 8 + n]
    at += 12 + n
raw, stride, before = zlib.decompress(idat), 3 * width, bytes(3 * width)
x0, x1 = int(sys.argv[2]), int(sys.argv[3])
total = count = 0
for y in range(height):
    kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
    for i in range(stride):
        a, b = (line[i - 3] if i >= 3 else 0), before[i]
        c = before[i - 3] if i >= 3 else 0
        p = a + b - c
        nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
        line[i] = (line[i] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
    before = bytes(line)
    for x in range(x0, x1):
        total += linear(line[3 * x])
        count += 1
mean, want, off = total / count, float(sys.argv[4]), float(sys.argv[5])
print("%s: %.4f, expected %.4f" % (sys.argv[1], mean, want))
sys.exit(abs(mean - want) > off)
PY

flat="--tonemap none --seed 3 --shader reference --size 16x16 --spp 256"
run 0 "$PBNDS" render pane.gltf -o pane.png --env white.hdr $flat
check python3 mean.py pane.png 0 16 0.7 0.01
run 0 "$PBNDS" render pane.gltf -o pane.exr --preview none.png --env white.hdr --background none $flat
check python3 mean.py none.png 0 16 0 0
run 0 "$PBNDS" compare denser.gltf -o out --env white.hdr --shaders ggx --spp 256 --size 16x16 \
    --tonemap none
check python3 mean.py out/against.png 0 16 0.4 0.01

for background in env none; do
    sky=1
    [ $background = none ] && sky=0
    run 0 "$PBNDS" render edge.gltf -o edge.png --env white.hdr --aov-samples 16 \
        --background $background $flat
    check python3 mean.py edge.png 0 8 $sky 0.001
    check python3 mean.py edge.png 8 9 "$(python3 -c "print(0.5 * $sky)")" 0.02
    check python3 mean.py edge.png 9 16 0 0
done

# What is in the file.
run 0 "$PBNDS" info pane.exr --json
check python3 - stdout <<'PY'
import json, sys
names = [c["name"] for c in json.load(open(sys.argv[1]))["channels"]]
for name in ("A", "R", "coverage.A", "variance.R", "variance.G", "variance.B"):
    assert names.count(name) == 1, (name, names)
PY
if command -v oiiotool >/dev/null; then
    run 0 oiiotool --stats pane.exr
    check python3 - stdout <<'PY'
import re, sys
mean = float(re.search(r"Stats Avg: (.*)", open(sys.argv[1]).read()).group(1).split()[3])
assert abs(mean - 0.3) < 0.01, mean
PY
fi
run 0 "$PBNDS" render box.gltf -o ggx.exr --env light.hdr --shader ggx --size 16x16
run 0 "$PBNDS" info ggx.exr
check eval '! grep -q variance stdout'

# Noise: the target is said to be reached below spp, and a harder one takes more.
run 0 "$PBNDS" render box.gltf -o a.png --env light.hdr --shader reference --size 32x32 \
    --spp 4096 --noise 0.05 --json
cp stdout a.json
run 0 "$PBNDS" render box.gltf -o b.png --env light.hdr --shader reference --size 32x32 \
    --spp 4096 --noise 0.05 --threads 3
check grep -q "samples a pixel" stdout
check cmp a.png b.png
run 0 "$PBNDS" render box.gltf -o c.png --env light.hdr --shader reference --size 32x32 \
    --spp 64 --noise 0.000001 --json
check python3 - a.json stdout <<'PY'
import json, sys
first, last = (json.load(open(name))["spp"] for name in sys.argv[1:])
assert 0 < first < 4096 and first % 32 == 0, first
assert last == 64, last
PY
run 0 "$PBNDS" render box.gltf -o d.png --env light.hdr --shader reference --size 32x32 --spp 64
check cmp c.png d.png

finish
