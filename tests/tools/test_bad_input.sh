#!/usr/bin/env bash
# Files that are missing, damaged or not what they should be: one sentence that names the file,
# the documented status, and nothing left behind.
. "$(dirname "$0")/lib.sh"
small="--size 16x16 --env light.hdr --shader ggx"

# Scenes.
refuse 1 "missing.glb" "$PBNDS" render missing.glb -o out.exr $small
refuse 1 "scenes" "$PBNDS" render scenes -o out.exr $small
refuse 3 "cut.glb" "$PBNDS" render cut.glb -o out.exr $small
refuse 3 "index.gltf" "$PBNDS" render index.gltf -o out.exr $small
refuse 3 "nan.gltf" "$PBNDS" render nan.gltf -o out.exr $small
refuse 3 "not_json.gltf" "$PBNDS" render not_json.gltf -o out.exr $small
refuse 3 "zero" "$PBNDS" render zero_image.gltf -o out.exr $small
refuse 4 "required.gltf" "$PBNDS" render required.gltf -o out.exr $small
: >empty.glb
refuse 3 "empty.glb" "$PBNDS" render empty.glb -o out.exr $small
for name in missing.glb cut.glb index.gltf nan.gltf; do
    run $([ $name = missing.glb ] && echo 1 || echo 3) "$PBNDS" check $name
    run $([ $name = missing.glb ] && echo 1 || echo 3) "$PBNDS" info $name
done

# A file outside of the scene's folder, and the limits that can be moved.
refuse 3 "picture.png.*--allow-external" "$PBNDS" render below/outside.gltf -o out.exr $small
refuse 1 "3 x 2 pixels.*--max-image-side" "$PBNDS" render below/outside.gltf -o out.exr $small \
    --allow-external --max-image-side 2
refuse 2 "--max-images" "$PBNDS" render box.gltf -o out.exr $small --max-images 0
refuse 1 "light.hdr.*--max-image-side" "$PBNDS" render box.gltf -o out.exr $small --max-image-side 2
run 0 "$PBNDS" render below/outside.gltf -o outside.exr $small --allow-external --max-images 1 \
    --max-geometry 1 --max-file 1
run 3 "$PBNDS" info below/outside.gltf
run 0 "$PBNDS" info below/outside.gltf --allow-external

# Light maps.
refuse 1 "missing.hdr" "$PBNDS" render box.gltf -o out.exr --size 16x16 --shader ggx --env missing.hdr
refuse 3 "zero.hdr" "$PBNDS" render box.gltf -o out.exr --size 16x16 --shader ggx --env zero.hdr
refuse 3 "cut.hdr" "$PBNDS" render box.gltf -o out.exr --size 16x16 --shader ggx --env cut.hdr
refuse 3 "cut_rgb.exr" "$PBNDS" render box.gltf -o out.exr --size 16x16 --shader ggx --env cut_rgb.exr

# G-buffers.
refuse 1 "missing.exr" "$PBNDS" shade missing.exr -o out.exr --env light.hdr --shader ggx
refuse 3 "rgb.exr.*albedo" "$PBNDS" shade rgb.exr -o out.exr --env light.hdr --shader ggx
refuse 3 "cut.exr" "$PBNDS" shade cut.exr -o out.exr --env light.hdr --shader ggx
refuse 3 "nan.exr" "$PBNDS" shade nan.exr -o out.exr --env light.hdr --shader ggx
refuse 3 "light.hdr\|not" "$PBNDS" shade light.hdr -o out.exr --env light.hdr --shader ggx
refuse 2 "reference" "$PBNDS" shade foreign.exr -o out.exr --env light.hdr --shader reference
refuse 2 "foreign.exr" "$PBNDS" compare foreign.exr -o d --env light.hdr --shaders ggx

# Weights: not there, not weights at all.
refuse 1 "missing.safetensors" "$PBNDS" render box.gltf -o out.exr --size 16x16 --env light.hdr \
    --shader neural:missing.safetensors
refuse 3 "box.glb" "$PBNDS" render box.gltf -o out.exr --size 16x16 --env light.hdr \
    --shader neural:box.glb

# Other kinds.
refuse 4 "make.txt" "$PBNDS" info make.txt
refuse 1 "envs" "$PBNDS" info envs
refuse 1 "envs" "$PBNDS" compare envs --shaders ggx

# The picture to compare with.
refuse 1 "missing.png" "$PBNDS" compare box.gltf -o d --size 16x16 --env light.hdr \
    --shaders ggx --against missing.png
refuse 2 "rgb.exr.*8x4" "$PBNDS" compare box.gltf -o d --size 16x16 --env light.hdr \
    --shaders ggx --against rgb.exr

# Outputs that cannot be made are told before anything is computed.
refuse 1 "no/such/out.exr" "$PBNDS" render box.gltf -o no/such/out.exr $small
refuse 1 "no/such/out.png" "$PBNDS" render box.gltf -o out.exr --preview no/such/out.png $small
refuse 1 "box.glb" "$PBNDS" compare box.gltf -o box.glb/d --size 16x16 --env light.hdr --shaders ggx
refuse 1 "no/such" "$PBNDS" compare box.gltf -o d --size 16x16 --env light.hdr --shaders ggx \
    --json no/such/x.json
mkdir locked && chmod 500 locked
if [ "$(id -u)" -ne 0 ]; then
    refuse 1 "locked" "$PBNDS" render box.gltf -o locked/out.exr $small
    refuse 1 "locked" "$PBNDS" compare box.gltf -o locked --size 16x16 --env light.hdr --shaders ggx
    refuse 1 "locked" "$PBNDS" dataset box.gltf -o locked/d --envs envs --count 1 --size 32x32
fi
refuse 1 "/proc/out.exr" "$PBNDS" render box.gltf -o /proc/out.exr $small

check [ ! -e out.exr ]
check [ ! -e out.png ]
clean_folder .
finish
