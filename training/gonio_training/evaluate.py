"""Measures a model file on held-out maps, by the number of filled bins: what its card says is what this prints.

    python -m gonio_training.evaluate --gonio ../target/release/gonio --model ../models/gonio-lobe-small.onnx
"""

import argparse
import json
from pathlib import Path

import numpy as np
import onnx
import torch

from .data import sets, stream
from .parity import run
from .train import SIZES, published_loss

CHUNK = 1024


def metadata(model: Path) -> dict:
    """What the file says of its training."""
    properties = {p.key: p.value for p in onnx.load(model).metadata_props}
    return json.loads(properties["gonio.training"])


def row(name: str, mu: torch.Tensor, truth: torch.Tensor) -> str:
    """Maps, the published loss, and mean absolute errors of kd, ks and roughness."""
    error = (mu - truth).abs().mean(0)
    loss = published_loss(mu, truth).mean().item()
    kd, ks, r = error[:3].mean().item(), error[3:6].mean().item(), error[6].item()
    return f"{name:>12}{len(mu):>8}{loss:>9.4f}{kd:>9.4f}{ks:>9.4f}{r:>9.4f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--model", type=Path, default=Path("../models/gonio-lobe-small.onnx"))
    args = parser.parse_args()

    told = metadata(args.model)
    held_out = told["metrics"]
    print(f"{args.model} says: {json.dumps(told)}")
    answers, truths, counts = [], [], []
    for batch in stream(args.gonio, held_out["held_out_seed"], held_out["held_out"], CHUNK):
        answers.append(torch.from_numpy(run(args.model, sets(batch), batch.light.numpy())))
        truths.append(batch.material)
        counts.append(batch.count)
    mu, truth, count = torch.cat(answers), torch.cat(truths), torch.cat(counts)
    print(f"{'filled bins':>12}{'maps':>8}{'loss':>9}{'kd':>9}{'ks':>9}{'r':>9}")
    for low, high in zip(SIZES, SIZES[1:]):
        part = (count > low) & (count <= high)
        print(row(f"{max(low + 1, 3)} to {high}", mu[part], truth[part]))
    print(row("all", mu, truth))
    print(row("0.5", torch.full_like(truth, 0.5), truth))
    quantiles = np.quantile(count.numpy(), [0.05, 0.25, 0.5, 0.75, 0.95]).astype(int).tolist()
    print(f"filled bins of these maps, quantiles 5, 25, 50, 75, 95%: {quantiles}")


if __name__ == "__main__":
    main()
