"""Maps with few bins, to measure how a network that was asked for a whole sphere answers to a real scene's handful."""

import torch


def keep(maps: torch.Tensor, bins: int, seed: int) -> torch.Tensor:
    """Maps [N, 3, 60, 120] with `bins` of their filled bins, taken at random, and the others 0; all where they have no more."""
    filled = (maps > 0).any(1).flatten(1)
    lot = torch.rand(filled.shape, generator=torch.Generator().manual_seed(seed)) * filled
    best = lot.topk(bins, 1).indices
    kept = torch.zeros_like(filled).scatter_(1, best, True) & filled
    return maps * kept.reshape(len(maps), 1, *maps.shape[2:])
