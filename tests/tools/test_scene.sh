#!/usr/bin/env bash
# What a file is asked for: its scene, its animation at a time, its lights; and what it lists.
. "$(dirname "$0")/lib.sh"
view="--size 24x24 --env light.hdr --shader ggx --camera main"

# Have two pictures the same numbers?
same() {
    python3 -c 'import sys; sys.path.insert(0, sys.argv[1]); import exr
sys.exit(exr.read(sys.argv[2]) != exr.read(sys.argv[3]))' "$HERE" "$1" "$2"
}
differ() { ! same "$@"; }

python3 - <<'PYTHON' || exit 1
import base64, json, struct
document = json.load(open("box.gltf"))
keys = struct.pack("<2f6f", 0, 2, 0, 0, 0, 0, 0.5, 0)
document["buffers"].append({"byteLength": len(keys), "uri":
    "data:application/octet-stream;base64," + base64.b64encode(keys).decode()})
buffer, view, first = (len(document[k]) for k in ("buffers", "bufferViews", "accessors"))
document["bufferViews"] += [{"buffer": buffer - 1, "byteOffset": 0, "byteLength": 8},
                            {"buffer": buffer - 1, "byteOffset": 8, "byteLength": 24}]
document["accessors"] += [
    {"bufferView": view, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [2]},
    {"bufferView": view + 1, "componentType": 5126, "count": 2, "type": "VEC3"}]
camera = next(i for i, n in enumerate(document["nodes"]) if "camera" in n)
document["animations"] = [{"name": "lift", "channels": [
    {"sampler": 0, "target": {"node": i, "path": "translation"}}
    for i, n in enumerate(document["nodes"]) if "mesh" in n],
    "samplers": [{"input": first, "output": first + 1}]}]
document["extensionsUsed"] = ["KHR_lights_punctual"]
document["extensions"] = {"KHR_lights_punctual": {"lights": [
    {"type": "point", "name": "lamp", "intensity": 5, "range": 30}]}}
document["nodes"].append({"translation": [0, 3, 0],
                          "extensions": {"KHR_lights_punctual": {"light": 0}}})
document["scenes"] = [{"name": "all", "nodes": list(range(len(document["nodes"])))},
                      {"name": "empty", "nodes": [camera]}]
json.dump(document, open("moving.gltf", "w"))
PYTHON

run 0 "$PBNDS" info moving.gltf --json
check python3 - <<'PYTHON'
import json
facts = json.load(open("stdout"))
assert [s["name"] for s in facts["scenes"]] == ["all", "empty"] and facts["scenes"][0]["default"]
assert facts["animations"][0]["name"] == "lift" and facts["animations"][0]["seconds"] == 2
(lamp,) = facts["lights"]
assert lamp["kind"] == "point" and lamp["position"] == [0, 3, 0] and lamp["range"] == 30, lamp
assert facts["variants"] == [] and facts["skins"] == []
height = facts["hi"][1]
assert height > 0
json.dump(height, open("height", "w"))
PYTHON
run 0 "$PBNDS" info moving.gltf
check grep -q '"name":"lift"' stdout

# Scenes, by name and by number.
for scene in empty 1; do
    run 0 "$PBNDS" info moving.gltf --scene $scene --json
    check grep -q '"triangles":.0' stdout
done
refuse 2 "scene 'night'" "$PBNDS" info moving.gltf --scene night

# The animation moves the picture, stays still past its end, and is chosen by name.
for time in 0 1 2 9; do
    run 0 "$PBNDS" render moving.gltf -o at$time.exr $view --time $time
    check [ ! -s stderr ]
done
check same at2.exr at9.exr
check differ at0.exr at1.exr
run 0 "$PBNDS" render moving.gltf -o named.exr $view --time 1 --animation lift
check same at1.exr named.exr
refuse 2 "animation 'fall'" "$PBNDS" render moving.gltf -o bad.exr $view --time 1 --animation fall
run 0 "$PBNDS" render box.gltf -o still.exr $view --time 1
check grep -q "no animation" stderr

clean_folder .
finish
