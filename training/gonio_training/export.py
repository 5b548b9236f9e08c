"""Writes a trained network as ONNX behind the model contract: one file, symbolic batch, metadata inside.

    python -m gonio_training.export --gonio ../target/release/gonio --checkpoint out/set.pt --out ../models/gonio-lobe-small.onnx
"""

import argparse
import json
from pathlib import Path

import torch

from .data import SLOTS, Batch, sets, stream
from .network import LIGHT, BinsNetwork, SetNetwork
from .onnx_file import graph, write
from .train import errors, published_loss, told

VERSION = "4"
HELD_OUT = 16_384


def load(checkpoint: Path) -> tuple[SetNetwork, dict]:
    """The averaged network of a checkpoint, and the checkpoint."""
    state = torch.load(checkpoint, weights_only=True, map_location="cpu")
    network = SetNetwork(state["lit"]).eval()
    network.load_state_dict(state["average"])
    return network, state


@torch.no_grad()
def answers(network: SetNetwork, batch: Batch) -> torch.Tensor:
    """What the exported model says of maps, [N, 7]."""
    exported, bins = BinsNetwork(network), torch.from_numpy(sets(batch)).split(1024)
    lights = batch.light.split(1024) if network.lit else [None] * len(bins)
    return torch.cat([exported(*inputs) for inputs in zip(bins, lights, strict=True)])


def training(network: SetNetwork, state: dict, binary: str) -> tuple[dict, list[float]]:
    """What `gonio.training` says: data, samples, seed, and errors on samples of another seed; and `gonio.deviation`, their
    root mean square by component."""
    seed = state["seed"] + 2_000_000
    held_out = next(stream(binary, state["prior"], seed, HELD_OUT, HELD_OUT))
    mu = answers(network, held_out)
    metrics = {
        "held_out": HELD_OUT,
        "held_out_seed": seed,
        "loss": published_loss(mu, held_out.material).mean().item(),
        **errors(mu, held_out.material),
    }
    metrics = {name: round(value, 4) for name, value in metrics.items()}
    facts = {**told(state), "metrics": metrics}
    deviation = (mu - held_out.material).square().mean(0).sqrt()
    return facts, [round(value, 4) for value in deviation.tolist()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--checkpoint", type=Path, default=Path("out/set.pt"))
    parser.add_argument("--out", type=Path, default=Path("../models/gonio-lobe-small.onnx"))
    args = parser.parse_args()

    network, state = load(args.checkpoint)
    inputs = {"bins": (torch.full((2, 16, 7), 0.5), {0: "N", 1: "S"})}
    if network.lit:
        inputs["light"] = (torch.full((2, LIGHT), 0.5), {0: "N"})
    model = graph(BinsNetwork(network), inputs)
    trained, deviation = training(network, state, args.gonio)
    facts = {
        "gonio.kind": "lobe",
        "gonio.version": VERSION,
        "gonio.bins": str(SLOTS),
        "gonio.deviation": json.dumps(deviation),
        "gonio.training": json.dumps(trained),
    }
    write(model, facts, args.out)
    parameters = sum(p.numel() for p in network.parameters())
    print(f"{args.out}: {parameters} parameters, {args.out.stat().st_size} bytes, {facts['gonio.training']}")


if __name__ == "__main__":
    main()
