#!/usr/bin/env bash
# Photographs of others: one with its maps, and a set laid out as FFHQ-PBR.
. "$(dirname "$0")/lib.sh"

# Twelve pictures of a bowl, 32x24, whose light is brightest at the left.
cat >make_photos.py <<'PY'
import math, os, sys
sys.path.insert(0, sys.argv[1])
from make_fixtures import exr, png
W, H = 32, 24
def write(name, data):
    os.makedirs(os.path.dirname(name), exist_ok=True)
    open(name, "wb").write(data)
def rows(pixel, n):
    return b"".join(b"\0" + b"".join(bytes(pixel(x, y)[:n]) for x in range(W)) for y in range(H))
def inside(x, y):
    return math.hypot(x - 15.5, y - 11.5) < 10
def normal(x, y):
    n = ((x - 15.5) / 12, (11.5 - y) / 12)
    n += (math.sqrt(max(0.05, 1 - n[0] ** 2 - n[1] ** 2)),)
    return [min(255, max(0, round(127.5 * (c + 1)))) for c in n]
def rgb(kind, color):
    return png(W, H, rows(color, 3))
root = sys.argv[2]
for i in range(12):
    name = "%05d" % (5030 + i)
    def photo(x, y):
        return (200 - 3 * x, 150 - 2 * x, 100 + i, 255) if inside(x, y) else (9, 9, 9, 0)
    write("%s/bgremoval/05000/%s.png" % (root, name), png(W, H, rows(photo, 4), 6))
    for kind, color in (("albedo", lambda x, y: (180, 140, 120)), ("normal", normal),
                        ("roughness", lambda x, y: (128,) * 3),
                        ("specular", lambda x, y: (10,) * 3)):
        write("%s/texture/%s/05000/%s_%s.png" % (root, kind, kind, name), rgb(kind, color))
    write("%s/texture/depth/05000/depth_%s.exr" % (root, name),
          exr(W, H, {"Y": lambda x, y: 2.0 + 0.01 * math.hypot(x - 15.5, y - 11.5)}))
    write("%s/hdri/05000/hdri_%s.exr" % (root, name),
          exr(16, 8, {c: lambda x, y: 4.0 if (x, y) == (8, 3) else 0.3 for c in "RGB"}))
write(root + "/pred_fov.json",
      ("{" + ", ".join('"%05d": %g' % (5030 + i, 50 + i) for i in range(12)) + "}").encode())
for split, ids in (("train", range(8)), ("val", (8, 9)), ("test", (10, 11))):
    write("%s/%s.txt" % (root, split), "".join("%05d\n" % (5030 + i) for i in ids).encode())
PY
python3 make_photos.py "$HERE" set || exit 1

# The set. Again: nothing is made anew.
run 0 "$PBNDS" import ffhq-pbr set -o faces
check grep -q "train 8, val 2, test 2 samples$" stdout
run 0 "$PBNDS" check faces
run 0 "$PBNDS" info faces --json
check python3 - stdout <<'PY'
import json, sys
facts = json.load(open(sys.argv[1]))
assert facts["kind"] == "data set" and (facts["train"], facts["val"], facts["test"]) == (8, 2, 2), facts
assert facts["recipe"]["target"] == "display" and facts["recipe"]["frame"] == "camera"
PY
run 0 "$PBNDS" check faces/test/000000/sample.exr
run 0 "$PBNDS" info faces/test/000000/sample.exr
check grep -q "pbnds:target: display" stdout
find faces -name 'sample.*' -o -name 'light.*' | sort | xargs md5sum >before
run 0 "$PBNDS" import ffhq-pbr set -o faces --json
check python3 - stdout <<'PY'
import json, sys
facts = json.load(open(sys.argv[1]))
assert (facts["train"], facts["val"], facts["test"], facts["left_out"]) == (8, 2, 2, 0), facts
PY
find faces -name 'sample.*' -o -name 'light.*' | sort | xargs md5sum >after
check cmp before after

# Killed at any moment and started again it ends in the same samples.
for ms in 005 010 020 040 080; do
    timeout -s KILL 0.$ms "$PBNDS" import ffhq-pbr set -o killed >/dev/null 2>&1
done
run 0 "$PBNDS" import ffhq-pbr set -o killed
(cd killed && find . -name 'sample.*' -o -name 'light.*' | sort | xargs md5sum) >after
(cd faces && find . -name 'sample.*' -o -name 'light.*' | sort | xargs md5sum) >before
check cmp before after

run 0 "$PBNDS" import ffhq-pbr set -o tars --format tar --per-tar 3
run 0 "$PBNDS" check tars
check [ "$(ls tars/*.tar | wc -l)" -eq 5 ]

# What is broken is listed and not fatal, unless nothing is left.
cp -r set worse
head -c 100 set/bgremoval/05000/05031.png >worse/bgremoval/05000/05031.png
rm worse/hdri/05000/hdri_05032.exr
run 0 "$PBNDS" import ffhq-pbr worse -o rest
check grep -q "train 6, val 2, test 2 samples; 2 pictures left out, see rest/import.json" stdout
check grep -q "picture 05031 is left out: .*05031.png" stderr
check grep -q "picture 05032 is left out: .*hdri_05032.exr: is missing" stderr
check python3 - rest/import.json <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
assert [x["id"] for x in report["left_out"]] == ["05031", "05032"], report
assert report["imported"] == 10 and all(x["reason"] for x in report["left_out"])
PY
run 0 "$PBNDS" import ffhq-pbr worse -o rest --quiet
check [ ! -s stderr ]
rm worse/hdri/05000/*
run 3 "$PBNDS" import ffhq-pbr worse -o none
check grep -q "^pbnds: .*no picture could be imported; the first: .*is missing" stderr
refuse 2 "one of blender, images, ffhq-pbr" "$PBNDS" import celeba set -o x
refuse 2 "leave out --format" "$PBNDS" import images set -o x.exr --format tar
refuse 2 "leave out --look" "$PBNDS" import ffhq-pbr set -o x --look 1,2
refuse 1 "no folder that can be read" "$PBNDS" import ffhq-pbr nowhere -o x
refuse 3 "no folder bgremoval" "$PBNDS" import ffhq-pbr set/hdri -o x
refuse 2 "another recipe" "$PBNDS" import ffhq-pbr worse -o faces
echo '{' >worse/pred_fov.json
refuse 3 "pred_fov.json: is no JSON object" "$PBNDS" import ffhq-pbr worse -o x
check [ ! -e x ]

# It is judged as a data set is, and shown without a tone map; it trains pbnds+ only.
run 0 "$PBNDS" compare faces --split test --shaders ggx,paper-ggx --json s.json -o scores
check python3 - s.json <<'PY'
import json, sys
t = json.load(open(sys.argv[1]))
assert t["count"] == 2 and t["size"] == [32, 24], t
for row in t["rows"]:
    assert row["relmse"] is None and 5 < row["psnr"] < 40, row
PY
run 0 "$PBNDS" train faces --model pbnds+ --crop 16 --batch 1 --lights 2 --steps 2 \
    --precision fp32 --quiet -o w.safetensors
run 0 "$PBNDS" check w.safetensors
refuse 4 "is a photograph" "$PBNDS" train faces --model transport --crop 16 --batch 1 --steps 2 \
    --quiet -o t.safetensors
check [ ! -e t.safetensors ]

# One photograph with its maps.
mkdir maps
cp set/bgremoval/05000/05030.png maps/photo.png
for kind in albedo normal roughness; do
    cp set/texture/$kind/05000/${kind}_05030.png maps/$kind.png
done
cp set/texture/depth/05000/depth_05030.exr maps/depth.exr
run 0 "$PBNDS" import images maps -o g.exr --fov 40
check grep -q "photo: kept as R, G, B, display-referred" stdout
check grep -q "mask: photo's alpha" stdout
run 0 "$PBNDS" info g.exr
check grep -q "pbnds:target: display" stdout
run 0 "$PBNDS" shade g.exr -o lit.exr --env light.hdr --shader ggx
run 0 "$PBNDS" info lit.exr
check eval "! grep -q pbnds:target stdout" # radiance again
run 0 "$PBNDS" compare g.exr -o one --env light.hdr --shaders ggx --json -
check python3 - stdout <<'PY'
import json, sys
assert json.load(open(sys.argv[1]))["rows"][0]["relmse"] is None
PY
clean_folder .
finish
