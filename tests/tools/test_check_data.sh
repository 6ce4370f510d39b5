#!/usr/bin/env bash
# pbnds check of data sets: everything that can be wrong with one is found and named.
. "$(dirname "$0")/lib.sh"

make="$PBNDS dataset scenes --envs envs --count 12 --size 16x16 --spp 1 --seed 3 --threads 1 --quiet"
tar="--format tar --per-tar 4"
run 0 $make -o folders
run 0 $make -o tar $tar

# fault PATTERN DIR: status 3, one sentence on stderr, the pattern among those on stdout.
fault() {
    run 3 "$PBNDS" check "$2" || return
    [ "$(wc -l <stderr)" -eq 1 ] && grep -q "^pbnds: .*not a sound data set" stderr ||
        fail "not one sentence on stderr: check $2"
    grep -q -e "$1" stdout || fail "no '$1' on stdout: check $2"
}

# fresh: a copy of both in which something goes wrong.
fresh() {
    rm -rf f t
    cp -r folders f
    cp -r tar t
}

for dir in folders tar; do
    run 0 "$PBNDS" check $dir
    check grep -q "sound: 12 samples, 0 in quarantine" stdout
done
run 0 "$PBNDS" check tar --json
check python3 - stdout <<'PY'
import json, sys
facts = json.load(open(sys.argv[1]))
assert facts["sound"] == 1 and facts["samples"] == 12 and facts["findings"] == [], facts
PY

# One byte of one file, in the middle.
flip() {
    python3 - "$1" "$2" <<'PY'
import sys
with open(sys.argv[1], "r+b") as file:
    file.seek(int(sys.argv[2]))
    byte = file.read(1)[0]
    file.seek(int(sys.argv[2]))
    file.write(bytes([byte ^ 4]))
PY
}
fresh
flip f/train/000002/sample.exr 9000
fault "train/000002/sample.exr: is not what it was" f
check [ "$(grep -c . stdout)" -le 3 ]
flip t/train-000000.tar 9000
fault "train-000000.tar/00000..[a-z]*.[a-z]*: is not what it was" t

# Missing, too many, cut short.
fresh
rm -r f/train/000003
fault "sample 3 of train is missing" f
cp -r f/train/000002 f/train/000099
fault "train/000099: is not in the manifest" f
rm f/val/000000/light.exr
fault "val/000000: lacks its light.exr" f
echo more >f/val/000000/notes.txt
fault "notes.txt: is not in the manifest" f
rm t/train-000001.tar
fault "sample 4 of train is missing" t
fresh
truncate -s 5000 t/train-000000.tar
fault "train-000000.tar: is cut short" t

# The claim and the manifest.
sed -i 's/"spp":\t1,/"spp":\t2,/' f/dataset.json
fault "dataset.json: was changed" f
fresh
sed -i '0,/"bytes":/s//"bytes": /' t/manifest.json
fault "manifest.json: was changed" t
rm t/manifest.json
fault "manifest.json: is not there: the data set was not finished" t

# remake: gives the data set a manifest for what is in it now, as if it had been made so.
remake() {
    rm -f f/manifest.json
    find f -name sample.json | while read -r file; do
        python3 - "$file" <<'PY'
import json, sys
about = json.load(open(sys.argv[1]))
about.pop("files", None)
json.dump(about, open(sys.argv[1], "w"))
PY
    done
    run 0 $make -o f
}

# Contents.
fresh
remake
run 0 "$PBNDS" check f
python3 - "$HERE" <<'PY'
import math, sys
sys.path.insert(0, sys.argv[1])
from make_fixtures import constant, exr, foreign_gbuffer
bad = {c: constant(0.5) for c in "RGB"}
bad["G"] = lambda x, y: math.nan if (x, y) == (3, 2) else 0.5
open("f/train/000001/light.exr", "wb").write(exr(8, 4, bad))
bad["G"] = lambda x, y: -0.25 if (x, y) == (5, 1) else 0.5
open("f/train/000002/light.exr", "wb").write(exr(8, 4, bad))
planes = foreign_gbuffer()
planes["normal.Z"] = constant(0.3)
open("f/train/000004/sample.exr", "wb").write(exr(16, 16, planes))
open("f/train/000005/sample.exr", "wb").write(b"hello")
PY
remake
fault "000001/light.exr: G is -\?nan at pixel (3, 2)" f
fault "000002/light.exr: G is -0.25 at pixel (5, 1)" f
fault "000004/sample.exr: normal" f
fault "000004/sample.exr: has no reference radiance" f
fault "000005/sample.exr: not a sound OpenEXR file" f
check grep -q "000001" stdout

# Splits: by what the samples say, and by what the claim lists.
fresh
sed -i 's/box_train/box_test/' f/train/000000/sample.json
sed -i 's/"sky_val"/"sky_train"/' f/val/000000/sample.json
remake
fault "asset box_test is in samples of train and of test" f
fault "light sky_train is in samples of train and of val" f
fresh
python3 - <<'PY'
import json
claim = json.load(open("f/dataset.json"))
claim["assets"][0]["xxh64"] = claim["assets"][1]["xxh64"]
json.dump(claim, open("f/dataset.json", "w"))
PY
fault "box_train of train is box_[a-z]* of " f

# Nothing of a data set, or not one at all.
mkdir none
refuse 1 "none" "$PBNDS" check none
finish
