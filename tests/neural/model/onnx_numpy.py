"""Oracle for test_onnx.c: decodes an ONNX file with nothing but the standard library, checks its
structure, and evaluates it with numpy in double.

    onnx_numpy.py MODEL.onnx                       structure; prints metadata, inputs, outputs, nodes
    onnx_numpy.py MODEL.onnx IN OUT N h w          IN: raw float32 view input, light input, NHWC;
                                                   OUT: the outputs in the order of the graph, NHWC
Exit status 77: there is no numpy here (the structure is sound).
"""
import struct
import sys


def varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 0x7f) << shift
        shift += 7
        if byte < 0x80:
            return value, at
        assert shift < 70, "varint of more than ten bytes"


def fields(data):
    """{field: [values]}: ints, or bytes for what has a length."""
    at, out = 0, {}
    while at < len(data):
        key, at = varint(data, at)
        if key & 7 == 0:
            value, at = varint(data, at)
            value -= (value >> 63) << 64
        elif key & 7 == 2:
            size, at = varint(data, at)
            value = data[at:at + size]
            assert len(value) == size, "a field ends behind the file"
            at += size
        else:
            raise AssertionError(f"wire type {key & 7}")
        out.setdefault(key >> 3, []).append(value)
    assert at == len(data)
    return out


def text(message, field):
    return message[field][0].decode() if field in message else ""


def texts(message, field):
    return [value.decode() for value in message.get(field, [])]


class Tensor:
    def __init__(self, data):
        m = fields(data)
        self.name, self.shape, self.type = text(m, 8), m.get(1, []), m[2][0]
        self.raw = m[9][0]
        count = 1
        for extent in self.shape:
            count *= extent
        assert len(self.raw) == count * {1: 4, 7: 8}[self.type], self.name


class Node:
    def __init__(self, data):
        m = fields(data)
        self.inputs, self.outputs, self.op = texts(m, 1), texts(m, 2), text(m, 4)
        self.attributes = {}
        for item in m.get(5, []):
            a = fields(item)
            kind = a[20][0]
            self.attributes[text(a, 1)] = {2: lambda: a[3][0], 3: lambda: text(a, 4),
                                           7: lambda: a[8]}[kind]()


class End:
    """An input or output: its name and shape, numbers or words."""

    def __init__(self, data):
        m = fields(data)
        tensor = fields(fields(m[2][0])[1][0])
        assert tensor[1] == [1], "float32"
        self.name, self.shape = text(m, 1), []
        for item in fields(tensor[2][0])[1]:
            dim = fields(item)
            assert len(dim) == 1
            self.shape.append(dim[1][0] if 1 in dim else text(dim, 2))


class Model:
    def __init__(self, path):
        m = fields(open(path, "rb").read())
        assert m[1][0] == 7, "IR version"
        opset = fields(m[8][0])
        assert opset[2] == [13] and not opset.get(1), "opset"
        self.metadata = {text(fields(e), 1): text(fields(e), 2) for e in m.get(14, [])}
        assert len(self.metadata) == len(m.get(14, []))
        graph = fields(m[7][0])
        self.nodes = [Node(n) for n in graph[1]]
        self.tensors = {t.name: t for t in map(Tensor, graph.get(5, []))}
        assert len(self.tensors) == len(graph.get(5, []))
        self.inputs = [End(e) for e in graph[11]]
        self.outputs = [End(e) for e in graph[12]]
        self.check_wiring()

    def check_wiring(self):
        known = set(self.tensors) | {e.name for e in self.inputs}
        used = set()
        for node in self.nodes:
            for name in node.inputs:
                assert name in known, f"{node.op} reads {name} before it is made"
                used.add(name)
            assert len(node.outputs) == 1 and node.outputs[0] not in known, node.outputs
            known.add(node.outputs[0])
        used |= {e.name for e in self.outputs}
        assert known == used, f"nobody reads {known - used}"


def evaluate(model, inputs):
    value = dict(inputs)
    for t in model.tensors.values():
        kind = np.float32 if t.type == 1 else np.int64
        v = np.frombuffer(t.raw, kind).reshape(t.shape)
        value[t.name] = v.astype(np.float64) if t.type == 1 else v
    for node in model.nodes:
        value[node.outputs[0]] = OPS[node.op](node.attributes, *[value[i] for i in node.inputs])
    return value


def conv(a, x, w, b):
    (kh, kw), (sy, sx) = a["kernel_shape"], a["strides"]
    top, left, bottom, right = a["pads"]
    assert w.shape[1:] == (x.shape[1], kh, kw)
    x = np.pad(x, ((0, 0), (0, 0), (top, bottom), (left, right)))
    height, width = (x.shape[2] - kh) // sy + 1, (x.shape[3] - kw) // sx + 1
    y = np.zeros((x.shape[0], w.shape[0], height, width))
    for dy in range(kh):
        for dx in range(kw):
            part = x[:, :, dy:dy + sy * (height - 1) + 1:sy, dx:dx + sx * (width - 1) + 1:sx]
            y += np.tensordot(part, w[:, :, dy, dx], (1, 1)).transpose(0, 3, 1, 2)
    return y + b[None, :, None, None]


def conv_transpose(a, x, w, b):
    assert a["kernel_shape"] == a["strides"] == [2, 2]
    n, _, height, width = x.shape
    y = np.zeros((n, w.shape[1], 2 * height, 2 * width))
    for dy in range(2):
        for dx in range(2):
            y[:, :, dy::2, dx::2] = np.tensordot(x, w[:, :, dy, dx], (1, 0)).transpose(0, 3, 1, 2)
    return y + b[None, :, None, None]


def depth_to_space(a, x):
    assert a == {"blocksize": 2, "mode": "CRD"}
    n, c, h, w = x.shape
    return x.reshape(n, c // 4, 2, 2, h, w).transpose(0, 1, 4, 2, 5, 3).reshape(n, c // 4, 2 * h, 2 * w)


def average_pool(a, x):
    assert a["kernel_shape"] == a["strides"] == [2, 2]
    return (x[:, :, ::2, ::2] + x[:, :, 1::2, ::2] + x[:, :, ::2, 1::2] + x[:, :, 1::2, 1::2]) / 4


OPS = {
    "Conv": conv,
    "ConvTranspose": conv_transpose,
    "DepthToSpace": depth_to_space,
    "AveragePool": average_pool,
    "Relu": lambda a, x: np.maximum(x, 0),
    "Add": lambda a, x, y: x + y,
    "Concat": lambda a, *x: np.concatenate(x, a["axis"]),
    "Identity": lambda a, x: x,
    "Shape": lambda a, x: np.array(x.shape),
    "Slice": lambda a, x, first, end: x[first[0]:end[0]],
    "Expand": lambda a, x, shape: np.broadcast_to(x, np.broadcast_shapes(x.shape, tuple(shape))),
}


def run(model, in_path, out_path, lights, h, w):
    data, at, inputs = np.fromfile(in_path, np.float32).astype(np.float64), 0, {}
    sizes = {"N": lights, "h": h, "w": w}
    for end in sorted(model.inputs, key=lambda e: e.name != "view_input"):
        n, c, y, x = (sizes[d] if isinstance(d, str) else d for d in end.shape)
        inputs[end.name] = data[at:at + n * c * y * x].reshape(n, y, x, c).transpose(0, 3, 1, 2)
        at += n * c * y * x
    assert at == data.size
    value, out = evaluate(model, inputs), []
    for end in model.outputs:
        y = value[end.name]
        sizes.update({f"{s}/{1 << k}": sizes[s] >> k for s in "hw" for k in range(1, 5)})
        assert list(y.shape) == [sizes[d] if isinstance(d, str) else d for d in end.shape], end.name
        out.append(y.transpose(0, 2, 3, 1).ravel())
    np.concatenate(out).astype(np.float32).tofile(out_path)


loaded = Model(sys.argv[1])
if len(sys.argv) == 2:
    for key, word in loaded.metadata.items():
        print(f"{key}: {word}")
    for kind, ends in ("input", loaded.inputs), ("output", loaded.outputs):
        for e in ends:
            print(kind, e.name, *e.shape)
    for op in sorted({n.op for n in loaded.nodes}):
        print("nodes", op, sum(n.op == op for n in loaded.nodes))
else:
    try:
        import numpy as np
    except ImportError:
        sys.exit(77)
    run(loaded, sys.argv[2], sys.argv[3], *map(int, sys.argv[4:7]))
