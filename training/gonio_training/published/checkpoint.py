"""What a training run leaves behind: one file to go on from, and its curve beside it."""

import csv
import os
from pathlib import Path

import torch
from torch import nn

from .architectures import ARCHITECTURES

VERSION = 1


def save(path: Path, state: dict) -> None:
    """Writes a checkpoint, then the curve in it as CSV. A kill at any time leaves the old file or the new one."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".tmp")
    torch.save({"version": VERSION, **state}, temporary)
    os.replace(temporary, path)
    with temporary.open("w", newline="") as file:
        writer = csv.DictWriter(file, state["curve"][0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(state["curve"])
    os.replace(temporary, path.with_suffix(".csv"))


def read(path: Path, device: str = "cpu") -> dict:
    """A checkpoint."""
    state = torch.load(path, weights_only=True, map_location=device)
    if state["version"] != VERSION:
        raise ValueError(f"{path} is a checkpoint of version {state['version']}; this reads version {VERSION}")
    return state


def network_of(state: dict) -> nn.Module:
    """The network of a checkpoint, to predict with."""
    network = ARCHITECTURES[state["arch"]].build(torch.zeros(3), torch.ones(3))
    network.load_state_dict(state["network"])
    return network.eval()
