"""Oracle for test_step.c: one training step of a model in PyTorch, in double, from the network's
inputs to the gradient of every parameter.

    step_torch.py transport|pbnds+ TABLE IN OUT

TABLE: as for net_torch.py. IN: raw float32: parameters, view input, light input, mask [B, h, w],
reference radiance [B, h, w, 3]; of transport also the reference's direct part and the specular
of the whole map [B, h, w, 3], and a light: what it gives unshadowed, what it gives to B, both
[B, N, h, w, 3], and whether it is seen [B, N, h, w]. OUT: the loss, the gradients.
Exit status 77: there is no torch here.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "layers"))
from net_torch import (F, LIGHT, VIEW, Reader, derive, gradients, network, read_params,  # noqa: E402
                       read_table, torch, write)


def mean_over(mask, value):
    """Per view over its covered pixels and the channels, then over the views."""
    covered = mask.sum((1, 2))
    return ((mask * value.sum(-1)).sum((1, 2)) / (3 * covered)).mean()


def transport_loss(out, view_out, mask, target, lit, gloss, direct, to_b, seen):
    """neural/transport.h; neural/train/task_transport.c has the weights."""
    visible = torch.sigmoid(out[:, :, 0] + 1)
    indirect = F.softplus(out[:, :, 1:] - 2).permute(0, 1, 3, 4, 2)
    occlusion = torch.sigmoid(view_out[:, 0] + 2)[..., None]
    x = (direct * visible[..., None]).sum(1) + gloss * occlusion
    y = (to_b * indirect).sum(1)

    def apart(a, b):
        return (torch.log1p(3 * a) - torch.log1p(3 * b)).abs()

    total = mean_over(mask, apart(x + y, target) + 0.5 * apart(x, lit) +
                      0.5 * apart(y, (target - lit).clamp(min=0)))
    importance = direct @ torch.tensor([0.2126, 0.7152, 0.0722], dtype=torch.float64)
    share = 0.5 * importance / importance.sum(1, keepdim=True).clamp(min=1e-12) + 0.5 / out.shape[1]
    entropy = F.binary_cross_entropy(visible, seen, reduction="none")
    weighted = (entropy * share * (importance > 0)).sum(1)
    return total + 0.1 * ((mask * weighted).sum((1, 2)) / mask.sum((1, 2))).mean()


def srgb(x):
    return torch.where(x <= 0.0031308, 12.92 * x,
                       1.055 * x.clamp(min=0.0031308) ** (1 / 2.4) - 0.055)


def plus_loss(out, mask, target):
    """L1 on the display image; neural/train/task_pbnds_plus.c: straight on above white."""
    mean = out.mean(1).permute(0, 2, 3, 1)
    shown = srgb(mean.clamp(max=1)) + (mean - 1).clamp(min=0) * 1.055 / 2.4
    wanted = srgb(target.clamp(0, 1))
    white = (target >= 1) & (mean >= 1)
    return mean_over(mask, (shown - wanted).abs() * ~white)


def main(model, table_path, in_path, out_path):
    (batch, lights, h, w, light_output, view_output), rows = read_table(table_path)
    read = Reader(in_path)
    light, _, channels = derive(rows)
    params = read_params(rows, channels, read)
    inputs = {op: read.image(batch * (lights if op == LIGHT else 1), h, w, channels[r])
              for op in (VIEW, LIGHT) for r, row in enumerate(rows) if row[0] == op}
    value = network(rows, light, lights, params, inputs, {})
    out = value[light_output]
    out = out.reshape(batch, lights, *out.shape[1:])
    mask, target = read(batch, h, w), read(batch, h, w, 3)
    if model == "transport":
        lit, gloss = read(batch, h, w, 3), read(batch, h, w, 3)
        direct, to_b = read(batch, lights, h, w, 3), read(batch, lights, h, w, 3)
        loss = transport_loss(out, value[view_output], mask, target, lit, gloss, direct, to_b,
                              read(batch, lights, h, w))
    else:
        loss = plus_loss(out, mask, target)
    read.done()
    loss.backward()
    write(out_path, [loss.reshape(1)] + gradients(params))


main(*sys.argv[1:])
