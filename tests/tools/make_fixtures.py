#!/usr/bin/env python3
"""Writes the small inputs of the command line tests into a folder: sound ones and broken
ones. Standard library only, so that a reader can see what is in each file."""
import base64
import json
import math
import os
import struct
import sys
import zlib


def box(cx, cy, cz, half):
    """24 vertices with face normals, 12 triangles."""
    positions, normals, indices = [], [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            n = [0.0, 0.0, 0.0]
            n[axis] = sign
            u, v = (axis + 1) % 3, (axis + 2) % 3
            first = len(positions)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                p = [0.0, 0.0, 0.0]
                p[axis], p[u], p[v] = sign * half, a * half, b * half
                positions.append([p[0] + cx, p[1] + cy, p[2] + cz])
                normals.append(n)
            quad = (0, 1, 2, 0, 2, 3) if sign > 0 else (0, 2, 1, 0, 3, 2)
            indices += [first + i for i in quad]
    return positions, normals, indices


def ground(half):
    corners = [[-half, 0.0, -half], [-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half]]
    return corners, [[0.0, 1.0, 0.0]] * 4, [0, 1, 2, 0, 2, 3]


def scene(meshes, camera=True):
    """A glTF document and its one buffer."""
    views, accessors, gltf_meshes, nodes, blob = [], [], [], [], b""

    def add(data, kind, component, count, lo=None, hi=None):
        nonlocal blob
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        accessor = {"bufferView": len(views) - 1, "componentType": component,
                    "count": count, "type": kind}
        if lo:
            accessor.update(min=lo, max=hi)
        accessors.append(accessor)
        blob += data + b"\0" * (-len(data) % 4)
        return len(accessors) - 1

    for i, (positions, normals, indices) in enumerate(meshes):
        finite = [p for p in positions if all(map(math.isfinite, p))]
        lo = [min(p[k] for p in finite) for k in range(3)]
        hi = [max(p[k] for p in finite) for k in range(3)]
        p = add(b"".join(struct.pack("<3f", *x) for x in positions), "VEC3", 5126,
                len(positions), lo, hi)
        n = add(b"".join(struct.pack("<3f", *x) for x in normals), "VEC3", 5126, len(normals))
        t = add(struct.pack("<%dH" % len(indices), *indices), "SCALAR", 5123, len(indices))
        gltf_meshes.append({"primitives": [{"attributes": {"POSITION": p, "NORMAL": n},
                                            "indices": t, "material": i % 2}]})
        nodes.append({"mesh": i})
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.6, 0.5, 1],
                                      "metallicFactor": 0, "roughnessFactor": 0.8}},
            {"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.4, 0.2, 1],
                                      "metallicFactor": 1, "roughnessFactor": 0.3}}],
        "meshes": gltf_meshes,
        "accessors": accessors,
        "bufferViews": views,
    }
    if camera:
        document["cameras"] = [{"type": "perspective",
                                "perspective": {"yfov": 0.7, "znear": 0.01}}]
        # Looks down by 20 degrees.
        nodes.append({"name": "main", "camera": 0, "translation": [0, 1.7, 3.6],
                      "rotation": [-math.sin(math.radians(10)), 0, 0,
                                   math.cos(math.radians(10))]})
    document["nodes"] = nodes
    document["scenes"] = [{"nodes": list(range(len(nodes)))}]
    document["buffers"] = [{"byteLength": len(blob)}]
    return document, blob


def write_gltf(path, document, blob):
    embedded = dict(document)
    uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    embedded["buffers"] = [{"byteLength": len(blob), "uri": uri}]
    with open(path, "w") as file:
        json.dump(embedded, file)


def glb(document, blob):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    chunks = (struct.pack("<I4s", len(text), b"JSON") + text +
              struct.pack("<I4s", len(blob), b"BIN\0") + blob)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def rgbe(r, g, b):
    top = max(r, g, b)
    if top < 1e-32:
        return bytes(4)
    mantissa, exponent = math.frexp(top)
    scale = mantissa * 256.0 / top
    return bytes([int(r * scale), int(g * scale), int(b * scale), exponent + 128])


def hdr(width, height, pixel):
    head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width)
    return head.encode() + b"".join(rgbe(*pixel(x, y)) for y in range(height)
                                    for x in range(width))


def sky(x, y):
    """Blue above, brown below, one small strong light."""
    if (x, y) == (20, 4):
        return 80.0, 70.0, 60.0
    return (0.4, 0.6, 1.0) if y < 8 else (0.25, 0.2, 0.15)


def png(width, height, rows, color=2):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))
    return (b"\x89PNG\r\n\x1a\n" +
            chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, color, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def exr(width, height, channels):
    """Uncompressed scanlines of float channels: {name: function of x, y}."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data
    names = sorted(channels)
    listed = b"".join(n.encode() + b"\0" + struct.pack("<IIII", 2, 0, 1, 1)
                      for n in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = (b"\x76\x2f\x31\x01\x02\0\0\0" + attribute(b"channels", b"chlist", listed) +
            attribute(b"compression", b"compression", b"\0") +
            attribute(b"dataWindow", b"box2i", window) +
            attribute(b"displayWindow", b"box2i", window) +
            attribute(b"lineOrder", b"lineOrder", b"\0") +
            attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)) +
            attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)) +
            attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0")
    line = 8 + 4 * width * len(names)
    first = len(head) + 8 * height
    table = b"".join(struct.pack("<Q", first + y * line) for y in range(height))
    lines = b"".join(
        struct.pack("<iI", y, line - 8) +
        b"".join(struct.pack("<f", channels[n](x, y)) for n in names for x in range(width))
        for y in range(height))
    return head + table + lines


def constant(value):
    return lambda x, y: value


def foreign_gbuffer():
    """The least that the contract asks of a G-buffer from elsewhere: a tilted plane."""
    channels = {"albedo." + c: constant(v) for c, v in zip("RGB", (0.8, 0.5, 0.3))}
    channels.update({"normal.X": constant(0.0), "normal.Y": constant(0.6),
                     "normal.Z": constant(0.8), "roughness.R": constant(0.5),
                     "Z": lambda x, y: 4.0 - 0.02 * y})
    return channels


def main(folder):
    def write(name, data):
        path = os.path.join(folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(data)

    os.makedirs(folder, exist_ok=True)
    meshes = [ground(3.0), box(-0.5, 0.5, 0.0, 0.5), box(0.8, 0.3, 0.3, 0.3)]
    document, blob = scene(meshes)
    write_gltf(os.path.join(folder, "box.gltf"), document, blob)
    write("box.glb", glb(document, blob))
    write("cut.glb", glb(document, blob)[:700])
    plain, plain_blob = scene(meshes, camera=False)
    write_gltf(os.path.join(folder, "no_camera.gltf"), plain, plain_blob)

    broken = json.loads(json.dumps(document))
    broken["meshes"][0]["primitives"][0]["indices"] = 99
    write_gltf(os.path.join(folder, "index.gltf"), broken, blob)
    broken = json.loads(json.dumps(document))
    broken["extensionsRequired"] = broken["extensionsUsed"] = ["KHR_texture_basisu"]
    write_gltf(os.path.join(folder, "required.gltf"), broken, blob)
    bad = [ground(3.0), box(0, 0.5, 0, 0.5)]
    bad[1][0][5][1] = math.nan
    write_gltf(os.path.join(folder, "nan.gltf"), *scene(bad))
    broken = json.loads(json.dumps(document))
    write("zero.png", png(0, 0, b""))
    broken["images"] = [{"uri": "zero.png"}]
    broken["textures"] = [{"source": 0}]
    broken["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    write_gltf(os.path.join(folder, "zero_image.gltf"), broken, blob)
    broken["images"] = [{"uri": "../picture.png"}]
    write("picture.png", png(3, 2, bytes([0] + [200, 100, 50] * 3) * 2))
    os.makedirs(os.path.join(folder, "below"), exist_ok=True)
    write_gltf(os.path.join(folder, "below", "outside.gltf"), broken, blob)
    write("not_json.gltf", b"hello")

    write("light.hdr", hdr(32, 16, sky))
    write("black.hdr", hdr(32, 16, lambda x, y: (0, 0, 0)))
    write("zero.hdr", hdr(0, 0, sky))
    write("cut.hdr", hdr(32, 16, sky)[:200])
    rgb = exr(8, 4, {c: constant(0.5) for c in "RGB"})
    write("rgb.exr", rgb)
    write("cut_rgb.exr", rgb[:len(rgb) - 100])
    write("foreign.exr", exr(16, 12, foreign_gbuffer()))
    write("cut.exr", exr(16, 12, foreign_gbuffer())[:900])
    nans = foreign_gbuffer()
    nans["normal.Y"] = lambda x, y: math.nan if (x, y) == (3, 2) else 0.6
    write("nan.exr", exr(16, 12, nans))

    # The same scene or light in two splits would be refused, so each has its own.
    for i, split in enumerate(("train", "val", "test")):
        write("envs/%s/sky_%s.hdr" % (split, split),
              hdr(32, 16, lambda x, y, i=i: sky(x + 7 * i, y)))
        os.makedirs(os.path.join(folder, "scenes", split), exist_ok=True)
        write_gltf(os.path.join(folder, "scenes", split, "box_%s.gltf" % split),
                   *scene([ground(3.0), box(-0.4, 0.5, 0.1 * i, 0.5), meshes[2]]))


if __name__ == "__main__":
    main(sys.argv[1])
