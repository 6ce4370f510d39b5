#!/usr/bin/env bash
# Data sets as Python people read them: tools/pbnds_dataset.py gives what the program wrote.
. "$(dirname "$0")/lib.sh"

python=
for candidate in python3 /usr/bin/python3; do
    $candidate -c 'import numpy, OpenImageIO' 2>/dev/null && python=$candidate && break
done
[ -n "$python" ] || { echo "no Python with numpy and OpenImageIO: skipped"; exit 77; }

cat >recipe.json <<'JSON'
{"scenes": ["scenes"], "envs": ["envs"], "count": {"train": 5, "test": 2}, "size": [24, 16],
 "spp": 4, "seed": 3, "targets": {"ao": true, "olat": 3, "variance": true}}
JSON
run 0 "$PBNDS" dataset --recipe recipe.json -o folders
sed 's/"seed"/"format": "tar", "per_tar": 2, "seed"/' recipe.json >tar.json
run 0 "$PBNDS" dataset --recipe tar.json -o tars
run 0 env PYTHONPATH="$SOURCE/tools" PYTHONDONTWRITEBYTECODE=1 "$python" - <<'PY'
import numpy
from pbnds_dataset import Samples

folders, tars = Samples("folders", "train"), Samples("tars", "train")
assert len(folders) == len(tars) == 5 and len(Samples("tars", "test")) == 2
assert len(Samples("folders", "val")) == 0
for i, sample in enumerate(folders):
    assert sample["radiance"].shape == (16, 24, 3) and sample["radiance"].dtype == numpy.float32
    assert sample["light"].shape == (128, 256, 3)
    assert sample["json"]["split"] == "train" and sample["json"]["index"] == i
    covered = sample["coverage"] > 0
    assert covered.any()
    length = numpy.linalg.norm(sample["normal"][covered], axis=-1)
    assert abs(length - 1).max() < 1e-3, length
    both = sample["direct"] + sample["indirect"]
    assert numpy.allclose(both, sample["radiance"], rtol=4e-3, atol=1e-4)
    assert sample["visibility"].dtype == numpy.uint32 and sample["visibility"].max() > 1 << 16
    assert sample["olat"].shape == (3, 16, 24, 3) and sample["olat"].max() > 0
    assert abs(numpy.linalg.norm(sample["olat_wi"], axis=-1) - 1).max() < 1e-5
    assert ((sample["ao"] >= 0) & (sample["ao"] <= 1)).all() and (sample["variance"] >= 0).all()
    other = tars[i]
    assert sample.keys() == other.keys()
    for key in sample:
        assert key == "json" or numpy.array_equal(sample[key], other[key]), key
some = Samples("folders", "train", layers=("albedo", "radiance"))[0]
assert sorted(some) == ["albedo", "radiance"]
try:
    Samples("envs")
    raise AssertionError("a folder that is no data set was taken")
except FileNotFoundError as error:
    assert "dataset.json" in str(error)
try:
    import torch
    loader = torch.utils.data.DataLoader(Samples("tars", "train", layers=("albedo", "radiance")), 2)
    assert [batch["albedo"].shape[0] for batch in loader] == [2, 2, 1]
except ImportError:
    pass
PY
finish
