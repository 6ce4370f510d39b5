"""Checks pictures of the calibration chart (scenes/generator/chart.h) seen by its camera
"front". What is expected comes from the chart's description and the formulas of the
conventions alone.

    chart.py cards RENDER.exr
    chart.py light RENDER.exr CONVENTION YAW
    chart.py roll CHART.hdr QUARTERS OUT.hdr    the same map, its columns moved to the right
"""
import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import exr  # noqa: E402

EYE, YFOV = (0.0, 1.0, 8.0), 0.32
# The map's column of a direction, in turns, less that of the convention gltf.
ROLL = {"gltf": 0.0, "openexr": -0.25, "falcor": 0.25, "pbnds": 0.5}
FACES = {(0, 0): (1, 0.1, 0.1), (1, 0): (0.1, 1, 0.1), (2, 0): (0.1, 0.1, 1),
         (0, 1): (0.1, 1, 1), (1, 1): (1, 0.1, 1), (2, 1): (1, 1, 0.1)}
VALUES = [(0.18,) * 3, (0.8,) * 3, (0.02,) * 3, (0.4, 0.04, 0.04), (0.04, 0.4, 0.04),
          (0.04, 0.04, 0.4), (0.4, 0.4, 0.04)]


class Picture:
    def __init__(self, path):
        self.width, self.height, self.rows = exr.read(path)
        self.focal = 0.5 * self.height / math.tan(0.5 * YFOV)

    def at(self, layer, names, x, y):
        return tuple(self.rows[layer + n][y][x] for n in names)

    def find(self, p):
        """Pixel of a world point."""
        depth = EYE[2] - p[2]
        return (int(0.5 * self.width + self.focal * (p[0] - EYE[0]) / depth),
                int(0.5 * self.height - self.focal * (p[1] - EYE[1]) / depth))

    def ray(self, x, y):
        return unit(((x + 0.5 - 0.5 * self.width) / self.focal,
                     -(y + 0.5 - 0.5 * self.height) / self.focal, -1.0))


def unit(v):
    length = math.sqrt(sum(c * c for c in v))
    return tuple(c / length for c in v)


def near(got, want, tolerance, what):
    assert all(abs(g - w) <= tolerance for g, w in zip(got, want)), (what, got, want)


def cards(picture):
    for i, value in enumerate(VALUES):
        x = 0.32 * (i - 3)
        lit, plain = picture.find((x, 0.75, 0)), picture.find((x, 1.1, 0))
        near(picture.at("albedo.", "RGB", *lit), value, 5e-4, "albedo of card %d" % i)
        near(picture.at("specular.", "R", *lit), (0.0,), 1e-6, "f0 of card %d" % i)
        near(picture.at("", "RGB", *plain), value, 1e-5, "unlit card %d" % i)
        near(picture.at("", "Z", *plain), (8.0,), 1e-5, "depth of card %d" % i)
        near(picture.at("normal.", "XYZ", *plain), (0, 0, 1), 1e-6, "normal of card %d" % i)
    for i, depth in enumerate((7.0, 8.0, 9.0, 10.0, 12.0, 16.0)):
        s = depth / 8.0
        x, y = 1.2 + 0.22 * (i % 3), 0.3 if i < 3 else 0.55
        at = picture.find((x * s, 1.0 + (y - 1.0) * s, 8.0 - depth))
        near(picture.at("", "Z", *at), (depth,), 1e-5 * depth, "rung %d" % i)
        near(picture.at("", "RGB", *at), (0.1 + 0.15 * i,) * 3, 1e-5, "rung %d" % i)
    # Texel orientation: red grows with u to the right, green with v downwards; white
    # where both are least.
    def uv(u, v):
        return picture.at("", "RGB", *picture.find((-0.75 + 0.6 * (u - 0.5),
                                                    1.65 - 0.6 * (v - 0.5), 0)))
    near(uv(0.06, 0.06), (1, 1, 1), 0.02, "first texels")
    right, left, low = uv(0.9, 0.1), uv(0.2, 0.9), uv(0.9, 0.9)
    assert right[0] > 0.6 and right[1] < 0.1, right
    assert left[0] < 0.1 and left[1] > 0.6, left
    assert low[0] > 0.6 and low[1] > 0.6 and low[2] < 0.01, low
    # Handedness of the normal map: it bulges as the dome of geometry beside it does.
    for a in (-0.14, -0.08, 0.0, 0.08, 0.14):
        for b in (-0.14, -0.07, 0.0, 0.07, 0.14):
            mapped = picture.at("normal.", "XYZ", *picture.find((a, 1.65 + b, 0)))
            z = 0.225 / 0.8 * (math.sqrt(1 - (a * a + b * b) / (0.225 / 0.8) ** 2) - 0.6)
            dome = picture.at("normal.", "XYZ", *picture.find((0.75 + a, 1.65 + b, z)))
            near(mapped, dome, 0.12, "normal at %g, %g" % (a, b))
            assert (mapped[0] > 0.1) == (a > 0.02) and (mapped[1] > 0.1) == (b > 0.02)


def expected(w, convention, yaw):
    """Colour of the map in direction w, or None beside a face's edge or on its letters."""
    turn = 2.0 * math.pi * ROLL[convention] + math.radians(yaw)
    azimuth = math.atan2(w[2], w[0]) + turn
    around = math.hypot(w[0], w[2])
    w = (around * math.cos(azimuth), w[1], around * math.sin(azimuth))
    axis = max(range(3), key=lambda i: abs(w[i]))
    reach = max(abs(w[i] / w[axis]) for i in range(3) if i != axis)
    return FACES[axis, int(w[axis] < 0)] if 0.55 < reach < 0.93 else None


def light(picture, convention, yaw):
    """The mirror ball, and the background."""
    seen, faces = [0, 0], set()
    for y in range(picture.height):
        for x in range(picture.width):
            d = picture.ray(x, y)
            w = d
            if picture.at("coverage.", "A", x, y) != (0.0,):
                # ball of radius 0.35 at (-1.5, 1.55, 0)
                o = (EYE[0] + 1.5, EYE[1] - 1.55, EYE[2])
                b = sum(p * q for p, q in zip(o, d))
                disc = b * b - sum(p * p for p in o) + 0.35**2
                if disc < 0.0:
                    continue
                t = -b - math.sqrt(disc)
                n = unit(tuple(p + t * q for p, q in zip(o, d)))
                c = sum(p * q for p, q in zip(n, d))
                w = tuple(q - 2.0 * c * p for p, q in zip(n, d))
                # elsewhere it reflects the chart
                if w[2] < 0.35 or w[1] < -0.5:
                    continue
            want = expected(w, convention, yaw)
            if want:
                got = picture.at("", "RGB", x, y)
                if w != d:  # few samples: the hue is sure, the amount is not
                    assert 0.5 < max(got) < 2.0, (x, y, got)
                    got = tuple(c / max(got) for c in got)
                near(got, want, 0.05 if w != d else 2e-3, (x, y, convention, yaw))
                seen[w != d] += 1
                faces.add(want)
    assert seen[1] > 80 and len(faces) >= 4, (seen, faces)


def roll(source, quarters, target):
    """Through run-length decoding: flat RGBE is the plainest form to move columns in."""
    with open(source, "rb") as file:
        head, data = file.read().split(b"\n\n", 1)
    size, data = data.split(b"\n", 1)
    height, width = int(size.split()[1]), int(size.split()[3])
    rows, at = [], 0
    for _ in range(height):
        assert data[at:at + 2] == b"\2\2"
        at += 4
        planes = []
        for _ in range(4):
            plane = bytearray()
            while len(plane) < width:
                n = data[at]
                if n > 128:
                    plane += data[at + 1:at + 2] * (n - 128)
                    at += 2
                else:
                    plane += data[at + 1:at + 1 + n]
                    at += 1 + n
            planes.append(plane)
        pixels = list(zip(*planes))
        shift = -quarters * width // 4 % width
        rows.append(b"".join(bytes(p) for p in pixels[shift:] + pixels[:shift]))
    with open(target, "wb") as file:
        file.write(head + b"\n\n" + size + b"\n" + b"".join(rows))


def main():
    if sys.argv[1] == "cards":
        cards(Picture(sys.argv[2]))
    elif sys.argv[1] == "light":
        light(Picture(sys.argv[2]), sys.argv[3], float(sys.argv[4]))
    else:
        roll(sys.argv[2], int(sys.argv[3]), sys.argv[4])


main()
