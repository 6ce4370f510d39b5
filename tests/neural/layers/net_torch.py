"""Oracle for test_net.c: runs a table of layers forward and backward in PyTorch, in double.

    net_torch.py TABLE IN OUT

TABLE: a line `B N h w light_output view_output`, then a line for each row,
`op in0 in1 channels kernel stride relu`. IN: raw float32 in the order of use: for each row
with weights its weight and bias; then the view input, the light input, the mask (0 or
1 / (1 - rate)) of each dropout row, dL/d(light output), dL/d(view output); all NHWC.
OUT: the light output, the view output and the parameter gradients, in the same way.
Exit status 77: there is no torch here.
"""
import sys

try:
    import numpy as np
    import torch
    import torch.nn.functional as F
except ImportError:
    sys.exit(77)

torch.set_num_threads(1)
VIEW, LIGHT, CONV, UP, ADD, CONCAT, SHUFFLE, POOL, DROPOUT = range(9)


def derive(rows):
    """Scope, level and channels of every row."""
    light, channels, level = [], [], []
    for op, a, b, c, kernel, stride, relu in rows:
        ins = [i for i in (a, b) if i >= 0]
        light.append(op == LIGHT or any(light[i] for i in ins))
        down = {CONV: stride - 1, UP: -1, SHUFFLE: -1, POOL: 1}.get(op, 0)
        level.append((level[a] if ins else 0) + down)
        channels.append(c if op in (VIEW, LIGHT, CONV, UP) else
                        channels[a] + channels[b] if op == CONCAT else
                        channels[a] // 4 if op == SHUFFLE else channels[a])
    return light, level, channels


def read_params(rows, channels, read):
    """Weight and bias of each row that has them, in the order of the table."""
    params = {}
    for r, (op, a, b, c, kernel, stride, relu) in enumerate(rows):
        if op == CONV:
            params[r] = [read(c, channels[a], kernel, kernel), read(c)]
        if op == UP:
            params[r] = [read(channels[a], c, 2, 2), read(c)]
    for pair in params.values():
        for p in pair:
            p.requires_grad_()
    return params


def network(rows, light, lights, params, inputs, masks):
    """Values of all rows; inputs by op, masks by row (absent: the identity)."""
    value = []

    def scoped(i, r):
        return value[i].repeat_interleave(lights, 0) if light[r] and not light[i] else value[i]

    for r, (op, a, b, c, kernel, stride, relu) in enumerate(rows):
        if op in (VIEW, LIGHT):
            y = inputs[op]
        elif op == CONV and kernel == 3:
            y = F.conv2d(F.pad(value[a], (1, 1, 1, 1) if stride == 1 else (1, 0, 1, 0)),
                         *params[r], stride=stride)
        elif op == CONV:
            y = F.conv2d(value[a], *params[r], stride=stride)
        elif op == UP:
            y = F.conv_transpose2d(value[a], *params[r], stride=2)
        elif op == ADD:
            y = scoped(a, r) + scoped(b, r)
        elif op == CONCAT:
            y = torch.cat([scoped(a, r), scoped(b, r)], 1)
        elif op == SHUFFLE:
            y = F.pixel_shuffle(value[a], 2)
        elif op == POOL:
            y = F.avg_pool2d(value[a], 2)
        else:
            y = value[a] * masks[r] if r in masks else value[a]
        value.append(torch.relu(y) if relu else y)
    return value


def gradients(params):
    return [torch.zeros_like(p) if p.grad is None else p.grad
            for pair in params.values() for p in pair]


class Reader:
    """Raw float32 in the order of use, as doubles."""

    def __init__(self, path):
        self.data, self.at = np.fromfile(path, np.float32), 0

    def __call__(self, *shape):
        count = int(np.prod(shape))
        part = self.data[self.at:self.at + count]
        assert part.size == count
        self.at += count
        return torch.from_numpy(part.astype(np.float64)).reshape(shape)

    def image(self, n, y, x, c):
        return self(n, y, x, c).permute(0, 3, 1, 2)

    def done(self):
        assert self.at == self.data.size


def read_table(path):
    lines = [list(map(int, line.split())) for line in open(path)]
    return lines[0], lines[1:]


def write(path, tensors):
    np.concatenate([t.detach().contiguous().numpy().ravel() for t in tensors]) \
        .astype(np.float32).tofile(path)


def main(table_path, in_path, out_path):
    (batch, lights, h, w, light_output, view_output), rows = read_table(table_path)
    read = Reader(in_path)
    light, level, channels = derive(rows)
    params = read_params(rows, channels, read)

    def size(r):
        return (batch * lights if light[r] else batch, h >> level[r], w >> level[r], channels[r])

    inputs = {op: read.image(*size(r)) for op in (VIEW, LIGHT)
              for r, row in enumerate(rows) if row[0] == op}
    masks = {r: read.image(*size(r)) for r, row in enumerate(rows) if row[0] == DROPOUT}
    value = network(rows, light, lights, params, inputs, masks)
    ends = (light_output, view_output)
    loss = sum((value[r] * read.image(*size(r))).sum() for r in ends)
    read.done()
    loss.backward()
    write(out_path, [value[r].permute(0, 2, 3, 1) for r in ends] + gradients(params))


if __name__ == "__main__":
    main(*sys.argv[1:])
