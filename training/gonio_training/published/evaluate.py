"""Measures a trained row on the test set: predict, render the sphere again under its light and view, compare.

    python -m gonio_training.published.evaluate --gonio ../target/release/gonio --data SET --checkpoint out/ours.pt

Writes OUT.json beside the checkpoint; `table` prints it.
"""

import argparse
import json
from pathlib import Path

import numpy as np
import torch
from torch import nn

from . import checkpoint, metrics
from .data import TRAINING_MAPS, Spheres, load
from .rerender import rerender
from .sparse import keep
from .train import predict

# Filled bins of a map; 0 stands for all.
FILLED = (0, 64, 16, 8)
NAMES = ("psnr", "nrmse", "dssim", "kd", "ks", "r")
CHUNK = 1000


def measure(network: nn.Module, batch: Spheres, bins: int, args: argparse.Namespace) -> np.ndarray:
    """Figures of each map of a batch, [N, 6], in the order of NAMES."""
    maps = keep(batch.maps, bins, args.seed) if bins else batch.maps
    mu = torch.cat([predict(network, some.to(args.device)).cpu() for some in maps.split(250)]).numpy()
    again = rerender(args.gonio, args.camera, mu, batch.lights.numpy(), batch.views.numpy())
    images = metrics.images(batch.maps.numpy(), again)
    return np.concatenate([images, metrics.materials(batch.materials.numpy(), mu)], 1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--camera", default="perspective", help="the set's camera: perspective or orthographic")
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--count", type=int, help="measure with the first maps of the test set; else with all")
    parser.add_argument("--seed", type=int, default=1, help="of the bins that sparse maps keep")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--device", default="cpu", choices=["cpu", "cuda"])
    args = parser.parse_args()

    torch.set_num_threads(args.threads)
    state = checkpoint.read(args.checkpoint)
    network = checkpoint.network_of(state).to(args.device)
    test = load(args.data / "test", args.count)
    rows = torch.arange(len(test.maps))
    figures = {}
    for bins in FILLED:
        all_maps = np.concatenate([measure(network, test.batch(some), bins, args) for some in rows.split(CHUNK)])
        figures[bins or "all"] = {n: round(float(v), 5) for n, v in zip(NAMES, np.nanmean(all_maps, 0), strict=True)}
        print(f"{state['arch']}, {bins or 'all'} bins: {figures[bins or 'all']}", flush=True)
    shown = state["step"] * state["recipe"]["batch"]
    told = {
        "arch": state["arch"],
        "parameters": sum(p.numel() for p in network.parameters()),
        "maps_shown": shown,
        "epochs": round(state["step"] / state["per_epoch"], 2),
        "to_the_end": shown >= state["recipe"]["epochs"] * TRAINING_MAPS,
        "training_minutes": round(state["seconds"] / 60, 1),
        "seed": state["seed"],
        "test_maps": len(rows),
        "filled_bins": figures,
    }
    args.checkpoint.with_suffix(".json").write_text(json.dumps(told, indent=1) + "\n")


if __name__ == "__main__":
    main()
