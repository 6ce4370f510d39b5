"""Reads the data sets that `pbnds dataset` makes, folders and WebDataset tar files alike.

    from pbnds_dataset import Samples
    for sample in Samples("data", "train"):
        print(sample["radiance"].shape, sample["albedo"].dtype, sample["json"]["asset"])

A sample is a dict of numpy arrays: float32 planes [height, width, channels] by the names of
the layers in sample.exr ("radiance" is R, G, B; "alpha" is A), uint32 bit masks, "light" the
light map, "json" what was drawn, "olat" [K, height, width, 3] and "olat_wi" [K, 3] where the set
has them. len() and [i] make it a torch.utils.data.Dataset as it is:

    loader = torch.utils.data.DataLoader(Samples("data", "train", layers=("albedo", "radiance")), 4)

Needs numpy and OpenImageIO (Debian: python3-numpy python3-openimageio).
"""
import glob
import json
import os
import tarfile
import tempfile

import numpy
import OpenImageIO

_COMPONENTS = "RGBAXYZUV"


def _channels(data):
    """{"albedo.R": [height, width]} of an EXR file in memory; float32 or uint32."""
    with tempfile.NamedTemporaryFile(suffix=".exr") as file:
        file.write(data)
        file.flush()
        exr = OpenImageIO.ImageInput.open(file.name)
        if exr is None:
            raise ValueError(OpenImageIO.geterror())
        spec = exr.spec()
        planes = exr.read_image(0, 0, 0, spec.nchannels, "float")
        channels = {}
        for i, name in enumerate(spec.channelnames):
            kind = spec.channelformats[i] if spec.channelformats else spec.format
            if str(kind).startswith("uint"):
                channels[name] = exr.read_image(0, 0, i, i + 1, "uint")[..., 0]
            else:
                channels[name] = planes[..., i]
        exr.close()
    return channels


def _layers(channels):
    """{"albedo": [height, width, 3]}: the channels of a layer side by side, RGB and XYZ in
    that order; ids and bit masks stay integers."""
    groups = {}
    for name in channels:
        layer, _, component = name.rpartition(".")
        if not layer:
            layer = {"R": "radiance", "G": "radiance", "B": "radiance", "A": "alpha",
                     "Z": "depth"}.get(name, name)
            component = name if name in ("R", "G", "B") else ""
        groups.setdefault(layer, []).append((_COMPONENTS.find(component), name))
    layers = {}
    for layer, members in groups.items():
        planes = [channels[name] for _, name in sorted(members)]
        layers[layer] = planes[0] if len(planes) == 1 else numpy.stack(planes, axis=-1)
    return layers


class Samples:
    """The samples of one split (train, val, test), in the order of their names."""

    def __init__(self, folder, split="train", layers=None):
        """layers: names of those wanted; all of them by default."""
        self.layers = layers
        self.places = [("folder", path) for path in sorted(glob.glob(
            os.path.join(folder, split, "[0-9]*")))]
        for path in sorted(glob.glob(os.path.join(folder, split + "-[0-9]*.tar"))):
            with tarfile.open(path) as tar:
                members = {}
                for member in tar:
                    key, _, name = os.path.basename(member.name).partition(".")
                    members.setdefault(key, {})[name] = (member.offset_data, member.size)
            self.places += [("tar", (path, members[key])) for key in sorted(members)]
        if not os.path.exists(os.path.join(folder, "dataset.json")):
            raise FileNotFoundError(f"{folder}: is not a data set (no dataset.json in it)")

    def __len__(self):
        return len(self.places)

    def _files(self, i):
        kind, place = self.places[i]
        if kind == "folder":
            for path in glob.glob(os.path.join(place, "*.*")):
                with open(path, "rb") as file:
                    yield os.path.basename(path), file.read()
        else:
            path, members = place
            with open(path, "rb") as file:
                for name, (offset, size) in members.items():
                    file.seek(offset)
                    yield name, file.read(size)

    def __getitem__(self, i):
        sample = {}
        for name, data in self._files(i):
            if name == "sample.exr":
                sample.update(_layers(_channels(data)))
            elif name == "light.exr":
                sample["light"] = _layers(_channels(data))["radiance"]
            elif name == "sample.json":
                sample["json"] = json.loads(data)
            elif name == "olat.exr":
                layers = _layers(_channels(data))
                lights = sorted(key for key in layers if key.startswith("olat."))
                sample["olat"] = numpy.stack([layers[key] for key in lights])
                sample["olat_visibility"] = layers["olat_visibility"]
        if "olat" in sample:
            sample["olat_wi"] = numpy.array(sample["json"]["olat"]["wi"], numpy.float32)
        if self.layers is not None:
            sample = {key: sample[key] for key in self.layers}
        return sample
