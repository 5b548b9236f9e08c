"""Trains the set network on fresh samples with the published loss; stops and resumes at its checkpoints.

    python -m gonio_training.train --gonio ../target/release/gonio --samples 10000000 --seed 1 --out out/set.pt
"""

import argparse
import csv
import itertools
import math
import time
from pathlib import Path

import torch
import torch.nn.functional as F

from .data import SLOTS, Batch, directions, stream
from .network import SetNetwork

DIRECTIONS = directions()
# How far the light that the network is told is from the one that was: direction, sun, sky; relative but for the direction.
DOUBT = (0.02, 0.03, 0.15)
# Maps of similar size go through together, so that little of a batch is padding; the gradient is that of the batch.
SIZES = (0, 6, 10, 16, 28, 64)


def published_loss(mu: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """E = SSE_kd + (1 - cbrt(r)) SSE_ks + 3 SSE_r per sample, r the true roughness (Wasee, Joy and Poullis)."""
    error = (mu - truth).square()
    roughness = truth[:, 6]
    return error[:, :3].sum(1) + (1 - roughness.pow(1 / 3)) * error[:, 3:6].sum(1) + 3 * error[:, 6]


def errors(mu: torch.Tensor, truth: torch.Tensor) -> dict[str, float]:
    """Mean absolute errors of kd, ks and roughness."""
    error = (mu - truth).abs().mean(0)
    return {"kd": error[:3].mean().item(), "ks": error[3:6].mean().item(), "r": error[6].item()}


def doubted(light: torch.Tensor) -> torch.Tensor:
    """Lights [N, 9] as they are known: about right."""

    def about(values: torch.Tensor, deviation: float) -> torch.Tensor:
        return values * (1 + deviation * torch.randn_like(values[:, :1]))

    sun = F.normalize(light[:, :3] + DOUBT[0] * torch.randn_like(light[:, :3]), dim=1)
    return torch.cat([sun, about(light[:, 3:6], DOUBT[1]), about(light[:, 6:], DOUBT[2])], 1)


def groups(batch: Batch, lit: bool):
    """Network inputs, with the light if `lit`, and truth for the parts of a batch, by number of filled bins."""
    device = batch.rgb.device
    # A GPU waits longer for the pieces than it works on the padding.
    sizes = (0, SLOTS) if device.type == "cuda" else SIZES
    for low, high in itertools.pairwise(sizes):
        part = ((batch.count > low) & (batch.count <= high)).nonzero().squeeze(1)
        if len(part) == 0:
            continue
        slots = int(batch.count[part].max())
        mask = (torch.arange(slots, device=device) < batch.count[part].unsqueeze(1)).float().unsqueeze(-1)
        light = batch.light[part] if lit else None
        yield part, (DIRECTIONS.to(device)[batch.bins[part, :slots]], batch.rgb[part, :slots], mask, light), batch.material[part]


@torch.no_grad()
def predict(network: SetNetwork, batch: Batch) -> torch.Tensor:
    """Materials of a batch, [N, 7]."""
    out = torch.empty_like(batch.material)
    for part, inputs, _ in groups(batch, network.lit):
        out[part] = network(*inputs)
    return out


def told(state: dict) -> dict:
    """What a checkpoint was trained with, and what it started from."""
    before = {"before": state["before"]} if state.get("before") else {}
    return {"data": f"gonio synth bins --prior {state['prior']}", "samples": state["samples"], "seed": state["seed"], **before}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    parser.add_argument("--samples", type=int, default=10_000_000)
    parser.add_argument("--batch", type=int, default=1024)
    parser.add_argument("--rate", type=float, default=2e-3, help="peak learning rate of the one cosine cycle")
    parser.add_argument("--prior", default="outdoor", help="from what materials and lights are drawn: uniform, outdoor or mixed")
    parser.add_argument("--start", type=Path, help="a checkpoint whose averaged weights to start from")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--device", default="cpu", choices=["cpu", "cuda"])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--light", action="store_true", help="tell the network where the light is")
    parser.add_argument("--bf16", action="store_true", help="bfloat16 products; worth it on CPUs that have them")
    parser.add_argument("--out", type=Path, default=Path("out/set.pt"))
    args = parser.parse_args()

    torch.set_num_threads(args.threads)
    torch.manual_seed(args.seed)
    network, average = SetNetwork(args.light).to(args.device), SetNetwork(args.light).to(args.device)
    start = torch.load(args.start, weights_only=True, map_location=args.device) if args.start else None
    if start:
        network.load_state_dict(start["average"])
    average.load_state_dict(network.state_dict())
    optimiser = torch.optim.AdamW(network.parameters(), lr=args.rate, weight_decay=1e-4)
    steps, step = math.ceil(args.samples / args.batch), 0
    if args.out.exists():
        state = torch.load(args.out, weights_only=True, map_location=args.device)
        network.load_state_dict(state["network"])
        average.load_state_dict(state["average"])
        optimiser.load_state_dict(state["optimiser"])
        step = state["step"]
        print(f"resumed at step {step} of {steps}", flush=True)
    args.out.parent.mkdir(parents=True, exist_ok=True)
    held_out = next(stream(args.gonio, args.prior, args.seed + 1_000_000, 8192, 8192)).to(args.device)

    started, first = time.time(), step
    # A resumed run draws the samples that it has not seen yet from a seed of its own.
    batches = stream(args.gonio, args.prior, args.seed + (step << 20), (steps - step) * args.batch, args.batch)
    for batch in batches:
        batch = batch.to(args.device)
        batch = batch._replace(light=doubted(batch.light)) if args.light else batch
        warm = min(1.0, (step + 1) / 500)
        for group in optimiser.param_groups:
            group["lr"] = args.rate * warm * 0.5 * (1 + math.cos(math.pi * step / steps))
        optimiser.zero_grad(set_to_none=True)
        for _, inputs, truth in groups(batch, args.light):
            with torch.autocast(args.device, torch.bfloat16, enabled=args.bf16):
                mu = network(*inputs)
            (published_loss(mu.float(), truth).sum() / args.batch).backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimiser.step()
        step += 1
        with torch.no_grad():
            blend = min(0.999, step / (step + 10))
            for slow, fast in zip(average.parameters(), network.parameters(), strict=True):
                slow.lerp_(fast, 1 - blend)
        if step % 500 == 0 or step == steps:
            mu = predict(average, held_out)
            row = {
                "step": step,
                "samples": step * args.batch,
                "loss": published_loss(mu, held_out.material).mean().item(),
                **errors(mu, held_out.material),
                "samples_per_s": (step - first) * args.batch / (time.time() - started),
            }
            row["hours_left"] = (steps - step) * args.batch / row["samples_per_s"] / 3600
            print(" ".join(f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items()), flush=True)
            curve = args.out.with_suffix(".csv")
            new = not curve.exists()
            with curve.open("a", newline="") as file:
                writer = csv.DictWriter(file, row)
                if new:
                    writer.writeheader()
                writer.writerow(row)
            state = {
                "network": network.state_dict(),
                "average": average.state_dict(),
                "optimiser": optimiser.state_dict(),
                "step": step,
                "samples": step * args.batch,
                "before": told(start) if start else None,
                "seed": args.seed,
                "lit": args.light,
                "prior": args.prior,
            }
            torch.save(state, args.out.with_suffix(".tmp"))
            args.out.with_suffix(".tmp").replace(args.out)


if __name__ == "__main__":
    main()
