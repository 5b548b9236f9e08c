"""The published augmentations, on batches, wherever the batch lies. The publication names them and gives no rates; ours:

| what            | of the maps | how                                                                                 |
|-----------------|-------------|-------------------------------------------------------------------------------------|
| salt and pepper | a quarter   | up to 2% of all bins become 0 or 1 in every channel                                 |
| localised noise | a quarter   | in one box of 6 to 30 rows and 6 to 60 columns, filled bins get noise, deviation up |
|                 |             | to 0.1, each channel its own                                                        |
| masking out     | half        | each bin stays with a chance between 1 in 1,000 and 1, uniform in its logarithm     |
| flips           | half, twice | rows; columns, each with its own chance                                             |

A flip of rows mirrors the sphere in z, a flip of columns in y: with light and view mirrored too, it is exactly the map
of the same material. No affine transformation: what it gives is no map of any material.
"""

import math

import torch

from .data import Spheres

SALT, LOCAL, MASK, FLIP = 0.25, 0.25, 0.5, 0.5


def chosen(count: int, chance: float, dice: torch.Generator) -> torch.Tensor:
    """Rows of a batch, each taken with a chance."""
    return (torch.rand(count, generator=dice, device=dice.device) < chance).nonzero().squeeze(1)


def uniform(low: float, high: float, shape: tuple[int, ...], dice: torch.Generator) -> torch.Tensor:
    """Numbers between two bounds."""
    return low + (high - low) * torch.rand(shape, generator=dice, device=dice.device)


def salt_and_pepper(maps: torch.Tensor, dice: torch.Generator) -> torch.Tensor:
    """Sets up to 2% of the bins to 0 or 1."""
    count, _, rows, columns = maps.shape
    share = uniform(0.0, 0.02, (count, 1, 1, 1), dice)
    lot = uniform(0.0, 1.0, (count, 1, rows, columns), dice)
    return torch.where(lot < share, (lot < share / 2).to(maps.dtype), maps)


def localised_noise(maps: torch.Tensor, dice: torch.Generator) -> torch.Tensor:
    """Adds noise to the filled bins of one box of each map."""
    count, _, rows, columns = maps.shape

    def inside(length: int, longest: int) -> torch.Tensor:
        size = uniform(6.0, longest, (count, 1), dice)
        start = uniform(0.0, 1.0, (count, 1), dice) * (length - size)
        place = torch.arange(length, device=maps.device)
        return (place >= start) & (place < start + size)

    box = inside(rows, 30)[:, None, :, None] & inside(columns, 60)[:, None, None, :]
    filled = (maps > 0).any(1, keepdim=True)
    deviation = uniform(0.0, 0.1, (count, 1, 1, 1), dice)
    noise = torch.randn(maps.shape, generator=dice, device=maps.device) * deviation
    return (maps + noise * (box & filled)).clamp_(0.0, 1.0)


def mask_out(maps: torch.Tensor, dice: torch.Generator) -> torch.Tensor:
    """Empties bins: most of most maps, as in real ones."""
    count, _, rows, columns = maps.shape
    share = uniform(math.log(1e-3), 0.0, (count, 1, 1, 1), dice).exp()
    return maps * (uniform(0.0, 1.0, (count, 1, rows, columns), dice) < share)


def flip(spheres: Spheres, some: torch.Tensor, dimension: int, axis: int) -> None:
    """Flips some maps, in place, along a dimension and mirrors their lights and views along the axis that belongs to it."""
    spheres.maps[some] = spheres.maps[some].flip(dimension)
    spheres.lights[some, axis] *= -1.0
    spheres.views[some, axis] *= -1.0


def flip_rows(spheres: Spheres, some: torch.Tensor) -> None:
    """Top to bottom: theta becomes pi - theta, z becomes -z."""
    flip(spheres, some, 2, 2)


def flip_columns(spheres: Spheres, some: torch.Tensor) -> None:
    """Left to right: phi becomes 2 pi - phi, y becomes -y."""
    flip(spheres, some, 3, 1)


def augment(spheres: Spheres, seed: int, step: int) -> None:
    """Makes a batch, in place, what the network sees: of seed and step alone."""
    maps = spheres.maps
    dice = torch.Generator(maps.device).manual_seed(seed * 1_000_003 + step)
    for change, chance in ((localised_noise, LOCAL), (salt_and_pepper, SALT), (mask_out, MASK)):
        some = chosen(len(maps), chance, dice)
        maps[some] = change(maps[some], dice)
    for turn in (flip_rows, flip_columns):
        turn(spheres, chosen(len(maps), FLIP, dice))
