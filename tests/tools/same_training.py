"""Two trainings that should be one: their weights went the same way, their curves agree.

    same_training.py START ONE OTHER    (names without .safetensors)

Adam steps by the sign of a gradient even where that is all rounding, so single weights may
part; the way as a whole may not.
"""
import json
import math
import struct
import sys


def tensors(path):
    with open(path + ".safetensors", "rb") as file:
        data = file.read()
    size = struct.unpack("<Q", data[:8])[0]
    header = json.loads(data[8 : 8 + size])
    header.pop("__metadata__")
    values = []
    for name in sorted(header):
        begin, end = (8 + size + x for x in header[name]["data_offsets"])
        values += struct.unpack(f"<{(end - begin) // 4}f", data[begin:end])
    return values


def curve(path):
    with open(path + ".safetensors.csv") as file:
        return [[float(x) for x in line.split(",")] for line in file.read().split()[1:]]


start, one, other = (tensors(path) for path in sys.argv[1:])
way = math.dist(one, start)
assert way > 0 and math.dist(one, other) < 0.05 * way, (math.dist(one, other), way)
rows, others = curve(sys.argv[2]), curve(sys.argv[3])
assert rows and len(rows) == len(others)
for k, (a, b) in enumerate(zip(rows, others)):
    for column, tolerance in ((3, 3e-3 if k else 2e-5), (5, 3e-3)):  # loss, val_loss
        assert abs(a[column] - b[column]) <= tolerance * a[column], (k, a, b)
