"""Writes a trained row as ONNX behind the model contract and checks that ONNX Runtime gives what PyTorch gives.

    python -m gonio_training.published.export --data SET --checkpoint out/ours.pt
"""

import argparse
import json
from pathlib import Path

import numpy as np
import torch
from torch import nn

from ..onnx_file import graph, write
from ..parity import timed
from . import checkpoint
from .data import load
from .train import predict

VERSION = "1"
ALLOWED = 1e-4


def facts(state: dict, kind: str) -> dict[str, str]:
    """The file's metadata."""
    training = {
        "data": "gonio synth spheres --preset published",
        "architecture": state["arch"],
        "samples": state["step"] * state["recipe"]["batch"],
        "seed": state["seed"],
        "metrics": {"validation_loss": state["curve"][-1]["validation_loss"]},
    }
    return {"gonio.kind": kind, "gonio.version": VERSION, "gonio.training": json.dumps(training)}


def compare(network: nn.Module, model: Path, maps: torch.Tensor, threads: int) -> tuple[float, float]:
    """Largest difference of a material's components between PyTorch and ONNX Runtime, and the latter's milliseconds a map; an
    empty map is among the maps."""
    maps = torch.cat([maps, torch.zeros_like(maps[:1])])
    there, milliseconds = timed(model, maps.numpy(), threads=threads)
    return float(np.abs(there - predict(network, maps).numpy()).max()), milliseconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--out", type=Path, help="the model file; else beside the checkpoint")
    parser.add_argument("--kind", default="sphere", choices=["sphere", "lobe"], help="lobe: to see what it makes of scenes")
    parser.add_argument("--count", type=int, default=127, help="test maps to compare")
    parser.add_argument("--threads", type=int, default=2)
    args = parser.parse_args()

    torch.set_num_threads(args.threads)
    out = args.out or args.checkpoint.with_suffix(".onnx")
    state = checkpoint.read(args.checkpoint)
    network = checkpoint.network_of(state)
    write(graph(network, {"map": (torch.full((2, 3, 60, 120), 0.5), {0: "N"})}), facts(state, args.kind), out)
    maps = load(args.data / "test").batch(torch.arange(args.count)).maps
    apart, milliseconds = compare(network, out, maps, args.threads)
    print(f"{out}: {out.stat().st_size} bytes; {milliseconds:.2f} ms a map on {args.threads} threads")
    print(f"PyTorch and ONNX Runtime differ by {apart:.1e}, {ALLOWED:.0e} allowed")
    raise SystemExit(0 if apart <= ALLOWED else 1)


if __name__ == "__main__":
    main()
