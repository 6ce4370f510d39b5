#!/usr/bin/env bash
# From scenes to weights: data set, training, resume, scoring, and damaged weights.
. "$(dirname "$0")/lib.sh"

run 0 "$PBNDS" dataset scenes -o data --envs envs --count 10 --size 32x32 --spp 4 --seed 3
check grep -q "train [1-9]" stdout
check grep -q "test [1-9]" stdout
run 0 "$PBNDS" info data --json
check python3 - stdout <<'PY'
import json, sys
facts = json.load(open(sys.argv[1]))
assert facts["kind"] == "data set" and len(facts["hash"]) == 16
assert facts["train"] + facts["val"] + facts["test"] == 10 and facts["test"] > 0, facts
assert facts["recipe"]["seed"] == 3
PY
run 0 "$PBNDS" check data

# Again: nothing is made anew. Another recipe into the same folder is refused.
find data -type f -exec md5sum {} + | sort >before
run 0 "$PBNDS" dataset scenes -o data --envs envs --count 10 --size 32x32 --spp 4 --seed 3
find data -type f -exec md5sum {} + | sort >after
check cmp before after
refuse 2 "data" "$PBNDS" dataset scenes -o data --envs envs --count 10 --size 32x32 --spp 4 --seed 4
# Two shards make together what one run makes.
for i in 0 1; do
    run 0 "$PBNDS" dataset scenes -o shards --envs envs --count 10 --size 32x32 --spp 4 --seed 3 \
        --shard $i/2
done
check diff -r data shards

# Classical shaders on the test split.
run 0 "$PBNDS" compare data --split test --shaders ggx,paper-ggx -o scores --json s.json
check grep -q "^  p10" stdout
check [ -s scores/compare.png ]
check python3 - s.json <<'PY'
import json, sys
t = json.load(open(sys.argv[1]))
assert t["split"] == "test" and t["count"] > 0 and t["size"] == [32, 32], t
ggx, paper = t["rows"]
for row in (ggx, paper):
    assert row["p10"]["psnr"] <= row["psnr"] and row["p10"]["mse"] >= 0, row
PY
run 1 "$PBNDS" compare data --shaders ggx,reference # the reference needs the scene
check grep -q "^reference *failed" stdout

# Training: a few steps of each model; stopped and resumed it ends where one run ends.
for model in transport pbnds+; do
    name=${model/+/_plus}
    train="$PBNDS train data --model $model --crop 32 --batch 1 --precision fp32 --quiet"
    [ $model = pbnds+ ] && train="$train --lights 2"
    run 0 $train -o $name.safetensors --steps 4
    check [ -s $name.safetensors ]
    check [ ! -e $name.safetensors.checkpoint ]
    check [ -s $name.safetensors.csv ]
    run 0 "$PBNDS" check $name.safetensors
    run 0 "$PBNDS" info $name.safetensors
    check grep -q "^model: $model" stdout
    check grep -q "^ *recipe: model $model v" stdout
    run 0 "$PBNDS" render box.gltf -o $name.exr --size 64x64 --env light.hdr --lights 4 \
        --shader neural:$name.safetensors --precision fp32
    head -c 2000 $name.safetensors >cut.safetensors
    refuse 3 "cut.safetensors" "$PBNDS" render box.gltf -o x.exr --size 64x64 --env light.hdr \
        --shader neural:cut.safetensors
    head -c -100 $name.safetensors >cut.safetensors
    refuse 3 "cut.safetensors" "$PBNDS" check cut.safetensors
done
run 0 "$PBNDS" compare data --shaders neural:transport.safetensors,neural:pbnds_plus.safetensors

# Zero light gives exactly zero from the structured model.
run 0 "$PBNDS" render box.gltf -o black.exr --size 64x64 --env black.hdr \
    --shader neural:transport.safetensors --precision fp32
if command -v oiiotool >/dev/null; then
    run 0 oiiotool --ch R,G,B --stats black.exr
    check grep -q "Stats Max: 0.000000 0.000000 0.000000" stdout
fi

# Weights of another model: the names inside say the wrong thing.
python3 - <<'PY'
import json, struct
data = open("transport.safetensors", "rb").read()
size = struct.unpack("<Q", data[:8])[0]
header = json.loads(data[8:8 + size])
header["__metadata__"].update({"pbnds.model": "pbnds+", "pbnds.version": "2"})
def save(name, header, body):
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    open(name, "wb").write(struct.pack("<Q", len(text)) + text + body)
save("other.safetensors", header, data[8 + size:])
header["__metadata__"]["pbnds.model"] = "somebody"
save("unknown.safetensors", header, data[8 + size:])
PY
refuse 3 "other.safetensors" "$PBNDS" render box.gltf -o x.exr --size 64x64 --env light.hdr \
    --shader neural:other.safetensors
refuse 4 "unknown.safetensors" "$PBNDS" render box.gltf -o x.exr --size 64x64 --env light.hdr \
    --shader neural:unknown.safetensors
check [ ! -e x.exr ]

# A data set without samples, and one with a damaged sample.
refuse 1 "empty" "$PBNDS" train empty -o w.safetensors --model transport --steps 1
sample=$(find data/test -name sample.exr | sort | head -n 1)
head -c 500 "$sample" >cut.bytes && cat cut.bytes >"$sample"
run 3 "$PBNDS" check data
check grep -q "sample.exr" stderr
refuse 3 "sample.exr" "$PBNDS" compare data --shaders ggx
check [ ! -e w.safetensors ]
clean_folder .
finish
