#!/usr/bin/env bash
# The table, its JSON form, the files beside it, and a shader that fails.
. "$(dirname "$0")/lib.sh"
view="--size 64x64 --env light.hdr --spp 8"

run 0 "$PBNDS" compare box.gltf -o out $view --shaders blinn-phong,ggx,reference --json t.json
check grep -q "^shader *mse *psnr *ssim *flip *relmse *seconds" stdout
check grep -q "^ggx " stdout
check [ "$(wc -l <stdout)" -eq 4 ]
for name in blinn-phong ggx reference; do
    for suffix in .exr .png _error.png; do check [ -s "out/$name$suffix" ]; done
done
check [ -s out/compare.png ] && check [ -s out/against.exr ]
check python3 - t.json <<'PY'
import json, sys
table = json.load(open(sys.argv[1]))
assert table["against"] == "reference" and table["size"] == [64, 64], table
assert [r["shader"] for r in table["rows"]] == ["blinn-phong", "ggx", "reference"]
for row in table["rows"]:
    assert set(row) == {"shader", "mse", "psnr", "ssim", "flip", "relmse", "seconds"}, row
    assert 0 < row["mse"] < 1 and 5 < row["psnr"] < 60 and 0 < row["ssim"] < 1, row
    assert 0 < row["flip"] < 1 and row["relmse"] > 0 and row["seconds"] > 0, row
noise, ggx = table["rows"][2], table["rows"][1]
assert noise["psnr"] > 15
PY
run 0 "$PBNDS" compare box.gltf -o out $view --shaders ggx --json -
check python3 -c 'import json; assert json.load(open("stdout"))["rows"]'

# A picture is equal to itself, as EXR and as PNG.
run 0 "$PBNDS" render box.gltf -o ggx.exr --preview ggx.png $view --shader ggx
run 0 "$PBNDS" compare box.gltf -o out $view --shaders ggx --against ggx.exr --json t.json
check python3 - t.json <<'PY'
import json, sys
row = json.load(open(sys.argv[1]))["rows"][0]
# Radiance is stored as half or float: equal but for that.
assert row["mse"] < 1e-6 and row["flip"] < 1e-2 and row["ssim"] > 0.9999, row
PY
run 0 "$PBNDS" compare box.gltf -o out $view --shaders ggx --against ggx.png --json t.json
check python3 - t.json <<'PY'
import json, sys
row = json.load(open(sys.argv[1]))["rows"][0]
assert row["mse"] < 1e-5 and row["relmse"] is None, row
PY

# A render with its AOVs is a G-buffer with its truth inside.
run 0 "$PBNDS" render box.gltf -o ref.exr $view --shader reference --spp 32
run 0 "$PBNDS" compare ref.exr -o out --env light.hdr --shaders ggx,blinn-phong --json t.json
check python3 -c 'import json; t = json.load(open("t.json")); assert t["against"] == "ref.exr"'

# One shader fails: its row says so, the others go on, the status is 1.
run 1 "$PBNDS" compare box.gltf -o part $view --shaders ggx,neural:box.glb --json t.json
check grep -q "^neural:box.glb *failed" stdout
check grep -q "^ggx *0" stdout
check grep -q "1 of 2 shaders failed" stderr
check grep -q "box.glb" stderr
check [ -s part/ggx.png ] && check [ -s part/compare.png ]
check python3 - t.json <<'PY'
import json, sys
rows = json.load(open(sys.argv[1]))["rows"]
assert rows[0]["psnr"] > 0 and "failed" not in rows[0]
assert rows[1]["psnr"] is None and rows[1]["failed"] is True
PY
clean_folder .
finish
