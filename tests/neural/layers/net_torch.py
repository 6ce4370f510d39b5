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


def main(table_path, in_path, out_path):
    lines = [list(map(int, line.split())) for line in open(table_path)]
    (batch, lights, h, w, light_output, view_output), rows = lines[0], lines[1:]
    data = np.fromfile(in_path, np.float32)
    at = 0

    def read(*shape):
        nonlocal at
        count = int(np.prod(shape))
        part = torch.from_numpy(data[at:at + count].astype(np.float64)).reshape(shape)
        at += count
        return part

    def read_image(n, y, x, c):
        return read(n, y, x, c).permute(0, 3, 1, 2)

    # sizes first: parameters are read in the order of the table, before any input
    light, channels, level, params = [], [], [], {}
    for r, (op, a, b, c, kernel, stride, relu) in enumerate(rows):
        ins = [i for i in (a, b) if i >= 0]
        light.append(op == LIGHT or any(light[i] for i in ins))
        down = {CONV: stride - 1, UP: -1, SHUFFLE: -1, POOL: 1}.get(op, 0)
        level.append((level[a] if ins else 0) + down)
        channels.append(c if op in (VIEW, LIGHT, CONV, UP) else
                        channels[a] + channels[b] if op == CONCAT else
                        channels[a] // 4 if op == SHUFFLE else channels[a])
        if op == CONV:
            params[r] = [read(c, channels[a], kernel, kernel), read(c)]
        if op == UP:
            params[r] = [read(channels[a], c, 2, 2), read(c)]
    for pair in params.values():
        for p in pair:
            p.requires_grad_()

    def size(r):
        return (batch * lights if light[r] else batch, h >> level[r], w >> level[r], channels[r])

    inputs = {op: read_image(*size(r)) for op in (VIEW, LIGHT)
              for r, row in enumerate(rows) if row[0] == op}
    masks = {r: read_image(*size(r)) for r, row in enumerate(rows) if row[0] == DROPOUT}
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
            y = value[a] * masks[r]
        value.append(torch.relu(y) if relu else y)

    outputs = [value[light_output], value[view_output]]
    loss = sum((o * read_image(*size(r))).sum()
               for o, r in zip(outputs, (light_output, view_output)))
    assert at == data.size
    loss.backward()
    results = [o.permute(0, 2, 3, 1) for o in outputs]
    results += [torch.zeros_like(p) if p.grad is None else p.grad
                for pair in params.values() for p in pair]
    np.concatenate([t.detach().contiguous().numpy().ravel() for t in results]) \
        .astype(np.float32).tofile(out_path)


main(*sys.argv[1:])
