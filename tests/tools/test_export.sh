#!/usr/bin/env bash
# pbnds export, and what info and check say of weights files.
. "$(dirname "$0")/lib.sh"
ONNX=$SOURCE/tests/neural/model/onnx_numpy.py
PYTHON=$(command -v /usr/bin/python3 || command -v python3)

for name in transport pbnds_plus; do
    weights=$SOURCE/neural/weights/$name.safetensors
    run 0 "$PBNDS" export "$weights" -o $name.onnx
    check grep -q "^$name.onnx\|^pbnds_plus.onnx: pbnds+ as ONNX" stdout
    run 0 "$PYTHON" "$ONNX" $name.onnx # decodes, and the wiring is sound
    cp stdout facts
    check grep -q "^pbnds.multiple: [0-9]" facts
    check grep -q "^train.recipe: model" facts
    check grep -q "^pbnds.features.about: albedo.R: base colour" facts
    check grep -q "^pbnds.channels.view: albedo.R; albedo.G; albedo.B; normal.X" facts
    check grep -q "^output light_output N [34] h w" facts
    run 0 "$PBNDS" export --onnx "$weights" -o $name.bin
    check cmp -s $name.onnx $name.bin
    run 0 "$PBNDS" info "$weights"
    check grep -q "^this program: reads it" stdout
    check grep -q "^training:" stdout
    check grep -q "^  recipe: model" stdout
    run 0 "$PBNDS" check "$weights"
    check grep -q "sound (0 faults" stdout
done
run 0 "$PBNDS" export "$SOURCE/neural/weights/transport.safetensors" -o t.onnx --json
check python3 -c 'import json; assert json.load(open("stdout"))["parameters"] == 405796'
check grep -q "^output view_output 1 1 h w" <("$PYTHON" "$ONNX" transport.onnx)

# Weights that are not sound, of another version, of nobody.
python3 - "$SOURCE/neural/weights/transport.safetensors" <<'PY'
import json, struct, sys
data = open(sys.argv[1], "rb").read()
size = struct.unpack("<Q", data[:8])[0]
header, body = json.loads(data[8:8 + size]), data[8 + size:]
def save(name, header, body):
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    open(name, "wb").write(struct.pack("<Q", len(text)) + text + body)
begin = header["light2.weight"]["data_offsets"][0]
nan = bytearray(body)
nan[begin + 8:begin + 12] = struct.pack("<f", float("nan"))
nan[begin + 40:begin + 44] = struct.pack("<f", float("inf"))
save("nan.safetensors", header, bytes(nan))
begin, end = header["light3.weight"]["data_offsets"]
save("zero.safetensors", header, body[:begin] + bytes(end - begin) + body[end:])
other = json.loads(json.dumps(header))
other["renamed\x1b"] = other.pop("light2.bias")
save("renamed.safetensors", other, body)
header["__metadata__"]["pbnds.version"] = "99"
save("later.safetensors", header, body)
header["__metadata__"] = {}
save("nobody.safetensors", header, body)
PY
run 3 "$PBNDS" check nan.safetensors
check grep -q "fault  *finite  *light2.weight .*2 of them, the first at 2)" stdout
check grep -q "nan.safetensors: not sound weights: 1 fault, the first of light2.weight" stderr
run 3 "$PBNDS" check nan.safetensors --json
check python3 - stdout <<'PY'
import json, sys
t = json.load(open(sys.argv[1]))
assert t["sound"] == 0 and t["model"] == "transport", t
f, = t["findings"]
assert (f["rule"], f["tensor"], f["count"], f["first"]) == ("finite", "light2.weight", 2, 2), f
PY
run 0 "$PBNDS" check zero.safetensors
check grep -q "warning zero  *light3.weight" stdout
run 3 "$PBNDS" check renamed.safetensors
check grep -q "fault  *missing  *light2.bias" stdout
check grep -q "fault  *foreign  *renamed?" stdout
refuse 3 "light2.weight" "$PBNDS" export nan.safetensors -o x.onnx
refuse 3 "light2.bias" "$PBNDS" export renamed.safetensors -o x.onnx
for command in check "export -o x.onnx" "render box.gltf --env light.hdr -o x.exr --shader neural:later.safetensors"; do
    file=later.safetensors
    [ "${command%% *}" = render ] && file=
    refuse 4 "later.safetensors: holds version 99 .*this program has version 1" "$PBNDS" $command $file
done
run 0 "$PBNDS" info later.safetensors
check grep -q "^this program: later.safetensors: holds version 99" stdout
refuse 3 "nobody.safetensors" "$PBNDS" export nobody.safetensors -o x.onnx
refuse 1 "none.safetensors" "$PBNDS" export none.safetensors -o x.onnx
refuse 2 "written as .onnx" "$PBNDS" export nan.safetensors -o x.bin
refuse 2 "is missing" "$PBNDS" export nan.safetensors
refuse 1 "no/such" "$PBNDS" export "$SOURCE/neural/weights/transport.safetensors" -o no/such/x.onnx
check [ ! -e x.onnx ]
check [ ! -e x.exr ]
clean_folder .
finish
