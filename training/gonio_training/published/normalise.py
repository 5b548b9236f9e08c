"""Radiance as the networks take it. It lives inside the exported graph, so that a model file says all."""

import torch
from torch import nn


class Normalise(nn.Module):
    """Radiance [N, 3, 60, 120], clipped at 1, to mean 0 and deviation 1 of the training set."""

    def __init__(self, mean: torch.Tensor, deviation: torch.Tensor) -> None:
        super().__init__()
        self.register_buffer("mean", mean.reshape(3, 1, 1))
        self.register_buffer("deviation", deviation.reshape(3, 1, 1))

    def forward(self, radiance: torch.Tensor) -> torch.Tensor:
        return (radiance - self.mean) / self.deviation
