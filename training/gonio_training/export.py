"""Writes a trained network as ONNX behind the model contract: one file, symbolic batch, metadata inside.

    python -m gonio_training.export --gonio ../target/release/gonio --checkpoint out/set.pt --out ../models/gonio-lobe-small.onnx
"""

import argparse
import json
from pathlib import Path

import torch

from .data import SLOTS, stream
from .network import BinsNetwork, SetNetwork
from .onnx_file import graph, write
from .train import predict, published_loss

VERSION = "2"
HELD_OUT = 16_384


def load(checkpoint: Path) -> tuple[SetNetwork, dict]:
    """The averaged network of a checkpoint, and the checkpoint."""
    state = torch.load(checkpoint, weights_only=True)
    network = SetNetwork().eval()
    network.load_state_dict(state["average"])
    return network, state


def training(network: SetNetwork, state: dict, binary: str) -> dict:
    """What `gonio.training` says: data, samples, seed, and errors on samples of another seed."""
    seed = state["seed"] + 2_000_000
    held_out = next(stream(binary, seed, HELD_OUT, HELD_OUT))
    mu = predict(network, held_out)
    error = (mu - held_out.material).abs().mean(0)
    metrics = {
        "held_out": HELD_OUT,
        "held_out_seed": seed,
        "loss": published_loss(mu, held_out.material).mean().item(),
        "kd": error[:3].mean().item(),
        "ks": error[3:6].mean().item(),
        "r": error[6].item(),
    }
    metrics = {name: round(value, 4) for name, value in metrics.items()}
    return {"data": "gonio synth bins", "samples": state["samples"], "seed": state["seed"], "metrics": metrics}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--checkpoint", type=Path, default=Path("out/set.pt"))
    parser.add_argument("--out", type=Path, default=Path("../models/gonio-lobe-small.onnx"))
    args = parser.parse_args()

    network, state = load(args.checkpoint)
    model = graph(BinsNetwork(network), torch.full((2, 16, 7), 0.5), "bins", {0: "N", 1: "S"})
    told = training(network, state, args.gonio)
    facts = {
        "gonio.kind": "lobe",
        "gonio.version": VERSION,
        "gonio.bins": str(SLOTS),
        "gonio.training": json.dumps(told),
    }
    write(model, facts, args.out)
    parameters = sum(p.numel() for p in network.parameters())
    print(f"{args.out}: {parameters} parameters, {args.out.stat().st_size} bytes, {facts['gonio.training']}")


if __name__ == "__main__":
    main()
