"""Measures a model file on held-out maps, by the number of filled bins: what its card says is what this prints.

PSNR is of what the surface sends towards all bins of the front half, clipped at 1, with the predicted material and with the true
one: under the map's own sun where that reaches it, and under another. The mean over maps; dB.

    python -m gonio_training.evaluate --gonio ../target/release/gonio --model ../models/gonio-lobe-small.onnx
"""

import argparse
import json
import math
from pathlib import Path

import numpy as np
import onnx
import torch

from .data import sets, stream
from .parity import run
from .rerender import lobes
from .train import errors, published_loss

CHUNK = 1024
# Fewest and most filled bins of a row.
BINS = ((3, 6), (7, 9), (10, 13), (14, 18), (19, 27), (28, 36), (37, 59), (60, 64))


def metadata(model: Path) -> dict:
    """What the file says of its training."""
    properties = {p.key: p.value for p in onnx.load(model).metadata_props}
    return json.loads(properties["gonio.training"])


def psnr(gonio: str, mu: torch.Tensor, truth: torch.Tensor, lights: torch.Tensor) -> torch.Tensor:
    """Of each map, [N]; not a number where the light is behind the surface."""
    wanted, found = (lobes(gonio, materials.numpy(), lights.numpy()) for materials in (truth, mu))
    error = np.square(wanted - found).mean((1, 2, 3))
    return torch.from_numpy(-10 * np.log10(np.maximum(error, 1e-10))).masked_fill(lights[:, 2] <= 0, math.nan)


def others(count: int) -> torch.Tensor:
    """Lights from all over the hemisphere, evenly, [N, 3]."""
    dice = torch.Generator().manual_seed(1)
    z, phi = torch.rand(count, generator=dice), 2 * math.pi * torch.rand(count, generator=dice)
    s = (1 - z * z).sqrt()
    return torch.stack([s * phi.cos(), s * phi.sin(), z], 1)


def row(name: str, mu: torch.Tensor, truth: torch.Tensor, lit: tuple[torch.Tensor, torch.Tensor]) -> str:
    """Maps, the published loss, mean absolute errors of kd, ks and roughness, and PSNR under both lights."""
    loss, (kd, ks, r) = published_loss(mu, truth).mean().item(), errors(mu, truth).values()
    same, other = (light.nanmean().item() for light in lit)
    return f"{name:>12}{len(mu):>8}{loss:>9.4f}{kd:>9.4f}{ks:>9.4f}{r:>9.4f}{same:>9.2f}{other:>9.2f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--model", type=Path, default=Path("../models/gonio-lobe-small.onnx"))
    args = parser.parse_args()

    told = metadata(args.model)
    held_out = told["metrics"]
    print(f"{args.model} says: {json.dumps(told)}")
    answers, truths, counts, same, other = [], [], [], [], []
    for batch in stream(args.gonio, told["data"].split()[-1], held_out["held_out_seed"], held_out["held_out"], CHUNK):
        mu, truth = torch.from_numpy(run(args.model, sets(batch), batch.light.numpy())), batch.material
        # Where the sun does not reach it, it is behind.
        reached = (batch.light[:, 3:4] > 0) & (batch.light[:, 2:3] > 0)
        same.append(psnr(args.gonio, mu, truth, torch.where(reached, batch.light[:, :3], torch.tensor([0.0, 0.0, -1.0]))))
        other.append(psnr(args.gonio, mu, truth, others(len(mu))))
        answers.append(mu)
        truths.append(truth)
        counts.append(batch.count)
    mu, truth, count, same, other = (torch.cat(parts) for parts in (answers, truths, counts, same, other))
    print(f"{'filled bins':>12}{'maps':>8}{'loss':>9}{'kd':>9}{'ks':>9}{'r':>9}{'same':>9}{'other':>9}")
    for low, high in BINS:
        part = (count >= low) & (count <= high)
        print(row(f"{low} to {high}", mu[part], truth[part], (same[part], other[part])))
    print(row("all", mu, truth, (same, other)))
    half = torch.full_like(truth, 0.5)
    print(f"0.5 throughout would err by {', '.join(f'{v:.4f}' for v in errors(half, truth).values())} in kd, ks, r")
    quantiles = np.quantile(count.numpy(), [0.05, 0.25, 0.5, 0.75, 0.95]).astype(int).tolist()
    print(f"filled bins of these maps, quantiles 5, 25, 50, 75, 95%: {quantiles}")


if __name__ == "__main__":
    main()
