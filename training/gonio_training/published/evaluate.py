"""Measures a trained row on the test set: predict, render the sphere again under its light and view, compare.

    python -m gonio_training.published.evaluate --gonio ../target/release/gonio --data SET --checkpoint out/ours.pt

Writes OUT.json beside the checkpoint; `table` prints it.
"""

import argparse
import json
import multiprocessing
from functools import partial
from pathlib import Path

import numpy as np
import torch
from torch import nn

from ..rerender import spheres
from . import checkpoint, metrics
from .data import TRAINING_MAPS, Spheres, load
from .sparse import keep
from .train import predict

# Filled bins of a map; 0 stands for all.
FILLED = (0, 64, 16, 8)
NAMES = ("psnr", "nrmse", "dssim", "kd", "ks", "r")
CHUNK = 250


def judge(batch: Spheres, mu: np.ndarray, gonio: str, camera: str) -> np.ndarray:
    """Figures of predicted materials [N, 7], [N, 6], in the order of NAMES."""
    again = spheres(gonio, camera, mu, batch.lights.numpy(), batch.views.numpy())
    images = metrics.images(batch.maps.numpy(), again)
    return np.concatenate([images, metrics.materials(batch.materials.numpy(), mu)], 1)


def answers(network: nn.Module, test: Spheres, bins: int, args: argparse.Namespace):
    """The test set by and by, and what is predicted of it."""
    for some in torch.arange(len(test.maps)).split(CHUNK):
        batch = test.batch(some)
        maps = keep(batch.maps, bins, args.seed) if bins else batch.maps
        yield batch, torch.cat([predict(network, part.to(args.device)).cpu() for part in maps.split(250)]).numpy()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--camera", default="perspective", help="the set's camera: perspective or orthographic")
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--count", type=int, help="measure with the first maps of the test set; else with all")
    parser.add_argument("--seed", type=int, default=1, help="of the bins that sparse maps keep")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--processes", type=int, default=1, help="that compare renders beside the one that predicts")
    parser.add_argument("--device", default="cpu", choices=["cpu", "cuda"])
    args = parser.parse_args()

    torch.set_num_threads(args.threads)
    state = checkpoint.read(args.checkpoint)
    network = checkpoint.network_of(state).to(args.device)
    test = load(args.data / "test", args.count)
    figures = {}
    judging = partial(judge, gonio=args.gonio, camera=args.camera)
    with multiprocessing.get_context("spawn").Pool(args.processes) as pool:
        for bins in FILLED:
            told = [pool.apply_async(judging, answer) for answer in answers(network, test, bins, args)]
            all_maps = np.concatenate([rows.get() for rows in told])
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
        "test_maps": len(test.maps),
        "filled_bins": figures,
    }
    args.checkpoint.with_suffix(".json").write_text(json.dumps(told, indent=1) + "\n")


if __name__ == "__main__":
    main()
