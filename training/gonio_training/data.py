"""Training samples, streamed from `gonio synth bins`: never stored, never seen twice."""

import math
import subprocess
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import torch

ROWS, COLUMNS = 60, 120
BINS = ROWS * COLUMNS
SLOTS = 64
RECORD = np.dtype(
    [("count", "<u4"), ("bins", "<u2", SLOTS), ("rgb", "<f4", (SLOTS, 3)), ("material", "<f4", 7), ("light", "<f4", 9)]
)


class Batch(NamedTuple):
    """Maps as sets of filled bins; slots past a map's count hold zeros."""

    count: torch.Tensor  # [N] int64
    bins: torch.Tensor  # [N, SLOTS] int64
    rgb: torch.Tensor  # [N, SLOTS, 3], linear, clipped at 1
    material: torch.Tensor  # [N, 7]
    light: torch.Tensor  # [N, 9]: the unit vector to the sun, its colour where it reaches the surface, the sky's radiance

    def to(self, device: str) -> "Batch":
        """The same, elsewhere."""
        return Batch(*(part.to(device, non_blocking=True) for part in self))


def directions() -> torch.Tensor:
    """Unit directions at the centres of all bins, [BINS, 3]."""
    theta = (torch.arange(ROWS, dtype=torch.float64) + 0.5) * math.pi / ROWS
    phi = (torch.arange(COLUMNS, dtype=torch.float64) + 0.5) * 2 * math.pi / COLUMNS
    theta, phi = torch.meshgrid(theta, phi, indexing="ij")
    xyz = torch.stack([theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()], -1)
    return xyz.reshape(BINS, 3).float()


def to_batch(records: np.ndarray) -> Batch:
    """A batch of raw records."""

    def field(name: str, dtype: type) -> torch.Tensor:
        return torch.from_numpy(np.ascontiguousarray(records[name]).astype(dtype, copy=False))

    return Batch(
        field("count", np.int64),
        field("bins", np.int64),
        field("rgb", np.float32),
        field("material", np.float32),
        field("light", np.float32),
    )


def sets(batch: Batch) -> np.ndarray:
    """The maps as the model contract has them, [N, SLOTS, 7]: direction, rgb, 1; rows past a map's count are 0."""
    mask = torch.arange(SLOTS) < batch.count.unsqueeze(1)
    bins = torch.cat([directions()[batch.bins], batch.rgb, torch.ones(*batch.bins.shape, 1)], -1)
    return (bins * mask.unsqueeze(-1)).numpy()


def stream(binary: str, prior: str, seed: int, count: int, batch: int) -> Iterator[Batch]:
    """Batches of samples `0..count` of a prior and a seed; the last one may be short."""
    command = [binary, "synth", "bins", "--prior", prior, "--count", str(count), "--seed", str(seed), "--out", "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, bufsize=1 << 22) as process:
        for start in range(0, count, batch):
            wanted = min(batch, count - start) * RECORD.itemsize
            raw = process.stdout.read(wanted)
            if len(raw) != wanted:
                raise RuntimeError(f"{' '.join(command)} ended after {start} samples of {count}")
            yield to_batch(np.frombuffer(raw, RECORD))
