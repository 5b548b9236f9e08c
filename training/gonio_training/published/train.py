"""Trains one row of the table; stops at any time and resumes at its checkpoint as if it had not been stopped.

    python -m gonio_training.published.train --data SET --arch wide-resnet-50 --out out/wide-resnet-50.pt
"""

import argparse
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import NamedTuple

import torch
from torch import nn

from ..train import published_loss
from . import checkpoint
from .architectures import ARCHITECTURES
from .augment import augment
from .data import Spheres, load, order, statistics
from .recipe import steps_of


@torch.no_grad()
def predict(network: nn.Module, maps: torch.Tensor) -> torch.Tensor:
    """Materials [N, 7] of a batch of maps, in single precision."""
    return network(maps.contiguous(memory_format=torch.channels_last))


def validate(network: nn.Module, part: Spheres, device: str) -> float:
    """Mean published loss over a part."""
    network.eval()
    total = 0.0
    for some in torch.arange(len(part.maps)).split(256):
        batch = part.batch(some, device)
        total += published_loss(predict(network, batch.maps), batch.materials).sum().item()
    network.train()
    return total / len(part.maps)


class Parts(NamedTuple):
    """What a run learns from and what it is watched with."""

    training: Spheres
    validation: Spheres

    @staticmethod
    def read(args: argparse.Namespace) -> "Parts":
        """Those of the command line: mapped for a CPU, and in the memory of a GPU, which must hold them: 25 GB if whole."""
        training = load(args.data / "train", args.maps)
        return Parts(training.to(args.device), load(args.data / "validation", args.validation))


class Run:
    """A training run: what it reads, how far it is, and what it writes."""

    def __init__(self, args: argparse.Namespace, parts: Parts | None = None) -> None:
        self.args = args
        self.training, self.validation = parts or Parts.read(args)
        architecture = ARCHITECTURES[args.arch]
        self.loss = architecture.loss
        self.recipe = replace(architecture.recipe, batch=args.batch or architecture.recipe.batch)
        self.steps, self.per_epoch = steps_of(self.recipe, len(self.training.maps), args.budget)
        torch.manual_seed(args.seed)
        self.step, self.seconds, self.curve = 0, 0.0, []
        state = checkpoint.read(args.out, args.device) if args.out.exists() else None
        normal = (torch.zeros(3), torch.ones(3)) if state else statistics(self.training)
        self.network = architecture.build(*normal).to(args.device, memory_format=torch.channels_last).train()
        decay, fused = self.recipe.weight_decay, args.device == "cuda"
        self.optimiser = torch.optim.Adam(self.network.parameters(), weight_decay=decay, fused=fused)
        if state:
            self.resume(state)

    def told(self) -> dict:
        """What must be the same for a run to be the same run."""
        return {
            "arch": self.args.arch,
            "seed": self.args.seed,
            "steps": self.steps,
            "per_epoch": self.per_epoch,
            "recipe": asdict(self.recipe),
            "bf16": self.args.bf16,
        }

    def resume(self, state: dict) -> None:
        """Goes on from a checkpoint."""
        for name, value in self.told().items():
            if state[name] != value:
                raise SystemExit(f"{self.args.out} was made with {name} {state[name]}, not {value}: choose another --out")
        self.network.load_state_dict(state["network"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.step, self.seconds, self.curve = state["step"], state["seconds"], state["curve"]
        print(f"resumed at step {self.step} of {self.steps}", flush=True)

    def save(self) -> None:
        """Writes the checkpoint and the curve."""
        state = {"network": self.network.state_dict(), "optimiser": self.optimiser.state_dict()}
        progress = {"step": self.step, "seconds": self.seconds, "curve": self.curve}
        checkpoint.save(self.args.out, {**self.told(), **state, **progress})

    def learn(self) -> torch.Tensor:
        """One step; its loss, which is not waited for."""
        epoch, place = divmod(self.step, self.per_epoch)
        rows = order(len(self.training.maps), self.args.seed, epoch)[place * self.recipe.batch :][: self.recipe.batch]
        batch = self.training.batch(rows, self.args.device)
        augment(batch, self.args.seed, self.step)
        for group in self.optimiser.param_groups:
            group["lr"] = self.recipe.rate_at(self.step, self.steps, self.per_epoch)
        maps = batch.maps.contiguous(memory_format=torch.channels_last)
        self.optimiser.zero_grad(set_to_none=True)
        with torch.autocast(self.args.device, torch.bfloat16, enabled=self.args.bf16):
            answer = self.network(maps)
        loss = self.loss(answer.float(), batch)
        loss.backward()
        self.optimiser.step()
        self.step += 1
        return loss.detach()

    def note(self, loss: float) -> None:
        """A row of the curve: training loss since the last one, validation loss at the ends of epochs and of the run."""
        ends = self.step % self.per_epoch == 0 or self.step == self.steps
        row = {
            "step": self.step,
            "maps": self.step * self.recipe.batch,
            "epoch": round(self.step / self.per_epoch, 4),
            "rate": float(f"{self.optimiser.param_groups[0]['lr']:.4g}"),
            "loss": round(loss, 5),
            "validation_loss": "",
            "seconds": round(self.seconds, 1),
        }
        if ends:
            loss = validate(self.network, self.validation, self.args.device)
            row["validation_loss"] = round(loss, 5)
        self.curve.append(row)
        hours = self.seconds / self.step * (self.steps - self.step) / 3600
        print(" ".join(f"{k} {v}" for k, v in row.items() if v != "") + f", {hours:.2f} hours left", flush=True)

    def go(self, until: int | None = None) -> None:
        """Trains to the end, or until a step, or until the time is up."""
        losses, saved, started, before = [], time.monotonic(), time.monotonic(), self.seconds
        last = until or self.steps
        while self.step < last:
            losses.append(self.learn())
            if self.step % self.args.log and self.step % self.per_epoch and self.step != last:
                continue
            loss = torch.stack(losses).mean().item()
            self.seconds = before + time.monotonic() - started
            over = self.args.minutes is not None and self.seconds >= 60 * self.args.minutes
            self.note(loss)
            losses = []
            if over or time.monotonic() - saved >= self.args.save_every_s or self.step == self.steps:
                self.save()
                saved = time.monotonic()
            if over:
                break


def arguments() -> argparse.ArgumentParser:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="what gonio synth spheres --preset published wrote")
    parser.add_argument("--arch", choices=ARCHITECTURES, required=True)
    parser.add_argument("--out", type=Path, required=True, help="the checkpoint, .pt; the curve goes beside it, .csv")
    parser.add_argument("--budget", type=int, help="maps to show; else the recipe's epochs")
    parser.add_argument("--minutes", type=float, help="end after so many minutes in all; the same command with more goes on")
    parser.add_argument("--batch", type=int, help="maps of a step, else the recipe's 256: fewer give more steps to a small budget")
    parser.add_argument("--maps", type=int, help="train with the first maps of the set; else with all")
    parser.add_argument("--validation", type=int, help="validate with the first maps of the set; else with all")
    parser.add_argument("--log", type=int, default=100, help="steps between rows of the curve")
    parser.add_argument("--save-every-s", type=float, default=60.0, help="seconds between checkpoints")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--device", default="cpu", choices=["cpu", "cuda"])
    parser.add_argument("--bf16", action="store_true", help="bfloat16 products; worth it on CPUs that have them, and on GPUs")
    return parser


def main() -> None:
    args = arguments().parse_args()
    torch.set_num_threads(args.threads)
    Run(args).go()


if __name__ == "__main__":
    main()
