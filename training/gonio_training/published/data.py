"""The published training set as `gonio synth spheres --preset published` writes it, mapped and not copied.

    DIR/{train,validation,test}/maps.npy      [N, 3, 60, 120] float16, linear radiance, not clipped
                                materials.npy [N, 7] float32
                                lights.npy    [N, 3] float32, unit vectors to the light in the map's frame
                                views.npy     [N, 3] float32, unit vectors to the camera
"""

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch

TRAINING_MAPS = 460_800


class Spheres(NamedTuple):
    """Maps and what they were rendered from; of a part of the set, or of a batch."""

    maps: torch.Tensor  # [N, 3, 60, 120]; float16 and not clipped in a part, float32 and clipped at 1 in a batch
    materials: torch.Tensor  # [N, 7]
    lights: torch.Tensor  # [N, 3]
    views: torch.Tensor  # [N, 3]

    def to(self, device: str) -> "Spheres":
        """The same, elsewhere."""
        return Spheres(*(part.to(device) for part in self))

    def batch(self, rows: torch.Tensor, device: str = "cpu") -> "Spheres":
        """The rows of a part, radiance clipped at 1 as in a photograph."""
        maps, materials, lights, views = (part[rows.to(part.device)].to(device) for part in self)
        return Spheres(maps.float().clamp_(0.0, 1.0), materials, lights, views)


def load(folder: Path, first: int | None = None) -> Spheres:
    """A part of the set, or its first maps: materials come in random order, 24 maps of each in a row. Copy-on-write mapping:
    PyTorch wants memory that could be written to, and nothing here writes."""
    part = (torch.from_numpy(np.load(folder / f"{name}.npy", mmap_mode="c")) for name in Spheres._fields)
    return Spheres(*(values[:first] for values in part))


@lru_cache(maxsize=1)
def order(count: int, seed: int, epoch: int) -> torch.Tensor:
    """The order of an epoch's maps: of seed and epoch alone, so that a resumed run goes on where it was."""
    return torch.randperm(count, generator=torch.Generator().manual_seed(seed * 1_000_003 + epoch))


def statistics(part: Spheres, first: int = 16_384) -> tuple[torch.Tensor, torch.Tensor]:
    """Mean and standard deviation of each channel of clipped radiance, [3] each, over the first maps of a part."""
    device = part.maps.device
    total = torch.zeros(2, 3, dtype=torch.float64, device=device)
    rows = torch.arange(min(first, len(part.maps)))
    for some in rows.split(256):
        maps = part.batch(some, device).maps.double()
        total += torch.stack([maps.mean((0, 2, 3)), maps.square().mean((0, 2, 3))]) * len(some) / len(rows)
    mean = total[0]
    return mean.float().cpu(), (total[1] - mean.square()).sqrt().float().cpu()
