"""Reads what pbnds writes: OpenEXR 2, one part, scan lines, ZIP. Standard library only."""
import struct
import zlib


def _unzip(data, size):
    if len(data) == size:
        return data
    raw = bytearray(zlib.decompress(data))
    for i in range(1, len(raw)):  # each byte is a difference
        raw[i] = (raw[i - 1] + raw[i] - 128) & 255
    half = (len(raw) + 1) // 2
    out = bytearray(len(raw))
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return bytes(out)


def read(path):
    """(width, height, {channel: rows of numbers})"""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:4] == b"\x76\x2f\x31\x01" and data[4] == 2, path
    at, header = 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<I", data, at)[0]
        header[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
    channels, listed = [], header["channels"]
    while listed[0]:
        name, rest = listed.split(b"\0", 1)
        kind = struct.unpack_from("<I", rest)[0]
        channels.append((name.decode(), "Ief"[kind], (4, 2, 4)[kind]))
        listed = rest[16:]
    line = width * sum(size for _, _, size in channels)
    rows = {name: [None] * height for name, _, _ in channels}
    blocks = (height + lines - 1) // lines
    for offset in struct.unpack_from("<%dQ" % blocks, data, at):
        y, size = struct.unpack_from("<iI", data, offset)
        count = min(lines, y1 + 1 - y)
        block = _unzip(data[offset + 8:offset + 8 + size], count * line)
        position = 0
        for k in range(count):
            for name, code, size in channels:
                rows[name][y - y0 + k] = struct.unpack_from("<%d%s" % (width, code), block,
                                                            position)
                position += width * size
    return width, height, rows
