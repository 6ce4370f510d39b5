#!/usr/bin/env bash
# Help, version, and what is typed wrongly: exit status 2 and one sentence.
. "$(dirname "$0")/lib.sh"

run 0 "$PBNDS" --help
for word in render gbuffer shade compare dataset train export import info check bench reference neural:FILE; do
    check grep -q -e "$word" stdout
done
check [ ! -s stderr ]
for word in eval; do
    check eval "! grep -qw $word stdout"
    refuse 2 "'$word' is not in this version" "$PBNDS" $word
done
run 0 "$PBNDS" --version
check grep -q '^pbnds [0-9]' stdout
for name in render gbuffer shade compare dataset train export import info check bench; do
    run 0 "$PBNDS" $name --help
    check grep -q "^usage: pbnds $name" stdout
    check grep -q "^Exit status" stdout
    check grep -q "  pbnds $name" stdout # an example
    check [ "$(awk '{ if (length > n) n = length } END { print n }' stdout)" -le 90 ]
    cp stdout help
    run 0 "$PBNDS" help $name
    check cmp -s help stdout
    run 0 "$PBNDS" $name --version
done

refuse 2 "subcommand is missing" "$PBNDS"
refuse 2 "'rendr' is not a subcommand" "$PBNDS" rendr
refuse 2 "usage: pbnds render" "$PBNDS" render
refuse 2 "is missing" "$PBNDS" render box.gltf
refuse 2 "is missing" "$PBNDS" compare box.gltf
refuse 2 "too many" "$PBNDS" info a b
refuse 2 "'--spq' is not an option" "$PBNDS" render box.gltf -o a.png --spq 3
refuse 2 "'--shaders' is not an option" "$PBNDS" render box.gltf -o a.png --shaders ggx
refuse 2 "wants a value" "$PBNDS" render box.gltf -o
refuse 2 "'-o' is not an option" "$PBNDS" check box.gltf -o a.png
refuse 2 "-o is for the contact sheet" "$PBNDS" info box.gltf -o a.png
refuse 2 "a.jpg" "$PBNDS" render box.gltf -o a.jpg
refuse 2 "not a .png" "$PBNDS" render box.gltf -o a.exr --preview b.exr
refuse 2 "written as .exr" "$PBNDS" gbuffer box.gltf -o a.png
refuse 2 "'nope' is not a shader" "$PBNDS" render box.gltf -o a.png --shader nope
refuse 2 "'nds' is not a shader" "$PBNDS" compare box.gltf -o d --shaders ggx,nds
refuse 2 "twice" "$PBNDS" compare box.gltf -o d --shaders ggx,ggx
refuse 2 "empty name" "$PBNDS" compare box.gltf -o d --shaders ggx,,reference
refuse 2 "same files" "$PBNDS" compare box.gltf -o d --shaders neural:a/b,neural:a_b
refuse 2 "no camera 'side'" "$PBNDS" gbuffer box.gltf -o a.exr --camera side
refuse 2 "no camera '1'" "$PBNDS" gbuffer box.gltf -o a.exr --camera 1
refuse 2 "has no camera" "$PBNDS" gbuffer no_camera.gltf -o a.exr --camera 0
refuse 2 "one of them" "$PBNDS" gbuffer box.gltf -o a.exr --camera 0 --look 1,2
refuse 2 "no motion" "$PBNDS" gbuffer box.gltf -o a.exr --motion 0.1
refuse 2 "envs DIR is missing" "$PBNDS" dataset box.gltf -o d --count 3
refuse 2 "count N is missing" "$PBNDS" dataset box.gltf -o d --envs envs
refuse 2 "model is missing" "$PBNDS" train d -o w.safetensors
refuse 2 "'vit' is not a model" "$PBNDS" train d -o w.safetensors --model vit
refuse 2 "written as .safetensors" "$PBNDS" train d -o w.bin --model transport

# Numbers: whole, in range, nothing behind them.
for bad in 0x0 0x64 64x0 -1x4 64 64x 64x64x 1e9x1 16385x1 "64 x64" 64X64; do
    refuse 2 "--size: '$bad'" "$PBNDS" gbuffer box.gltf -o a.exr --size "$bad"
done
for bad in 0 -1 1.5 x 3x "" 99999999999999999999; do
    refuse 2 "--spp: '$bad'\|--spp: is empty" "$PBNDS" render box.gltf -o a.exr --spp "$bad"
done
for bad in nan inf 0x10 1e99999 x "" " 1"; do
    refuse 2 "--exposure: '$bad'" "$PBNDS" render box.gltf -o a.exr --exposure "$bad"
done
for bad in 30 "30," ",20" 30,91 400,0 a,b 30,20,1; do
    refuse 2 "--look: '$bad'" "$PBNDS" gbuffer box.gltf -o a.exr --look "$bad"
done
for bad in 1/1 -1/2 1 1/ a/b 0/0; do
    refuse 2 "--shard: '$bad'" "$PBNDS" dataset box.gltf -o d --envs envs --count 1 --shard "$bad"
done
refuse 2 "--seed: '-1'" "$PBNDS" gbuffer box.gltf -o a.exr --seed -1
refuse 2 "--fov: '200'" "$PBNDS" gbuffer box.gltf -o a.exr --fov 200
refuse 2 "--shadows: 'maybe'" "$PBNDS" render box.gltf -o a.exr --shadows maybe
refuse 2 "--tonemap: 'aces'" "$PBNDS" render box.gltf -o a.exr --tonemap aces
refuse 2 "--env-convention: 'up'" "$PBNDS" render box.gltf -o a.exr --env-convention up
refuse 2 "--threads: '0'" "$PBNDS" gbuffer box.gltf -o a.exr --threads 0

check [ ! -e a.exr ] # nothing was made by any of these
check [ ! -e d ]
finish
