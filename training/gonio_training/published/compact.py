"""Ours: a small convolutional network that reads kd and ks off the map by weighted sums.

Once light, view and roughness are fixed, radiance is linear in kd and ks, channel by channel: so each of the two is a weighted
sum of the channel's radiance, with weights that are the same for red, green and blue. The convolutions find the
geometry and give the weights; the sums are exact where a plain regression would have to learn a product.
"""

import torch
import torch.nn.functional as F
from torch import nn

from .normalise import Normalise

PATCH = 5
PATCHES = (60 // PATCH) * (120 // PATCH)
SUMS = 6


class Residual(nn.Module):
    """Two 3x3 convolutions beside a shortcut."""

    def __init__(self, before: int, after: int, stride: int) -> None:
        super().__init__()
        self.first = nn.Sequential(
            nn.Conv2d(before, after, 3, stride, 1, bias=False), nn.BatchNorm2d(after), nn.ReLU(inplace=True)
        )
        self.second = nn.Sequential(nn.Conv2d(after, after, 3, 1, 1, bias=False), nn.BatchNorm2d(after))
        same = before == after and stride == 1
        self.shortcut = nn.Identity() if same else nn.Conv2d(before, after, 1, stride, bias=False)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return torch.relu(self.second(self.first(x)) + self.shortcut(x))


class Compact(nn.Module):
    """`map` [N, 3, 60, 120], linear radiance, to materials [N, 7]."""

    def __init__(self, mean: torch.Tensor, deviation: torch.Tensor) -> None:
        super().__init__()
        self.normalise = Normalise(mean, deviation)
        # Patches of 5 x 5 bins, 15 degrees: radiance, its square root, which spreads the dark half, and what is filled.
        self.stem = nn.Sequential(
            nn.Conv2d(7, 32, PATCH, PATCH, bias=False), nn.BatchNorm2d(32), nn.ReLU(inplace=True)
        )
        self.blocks = nn.Sequential(Residual(32, 32, 1), Residual(32, 64, 2), Residual(64, 96, 2))
        self.state = nn.Sequential(nn.Flatten(), nn.Linear(96 * 3 * 6, 192), nn.ReLU(inplace=True))
        self.weights = nn.Linear(192, SUMS * PATCHES)
        self.head = nn.Sequential(nn.Linear(192 + 3 * SUMS, 192), nn.ReLU(inplace=True), nn.Linear(192, 7))

    def forward(self, map: torch.Tensor) -> torch.Tensor:
        radiance = map.clamp(0.0, 1.0)
        filled = (radiance.amax(1, keepdim=True) > 0).to(radiance.dtype)
        state = self.state(
            self.blocks(self.stem(torch.cat([self.normalise(radiance), radiance.sqrt(), filled], 1)))
        )
        share = F.avg_pool2d(filled, PATCH)
        patches = (F.avg_pool2d(radiance, PATCH) / share.clamp(min=1.0 / PATCH**2)).flatten(2)
        weights = self.weights(state).unflatten(1, (SUMS, 1, PATCHES))
        # Not a matrix product: that would be done in bfloat16 where training uses it, which is too coarse here.
        sums = (weights * patches.unsqueeze(1)).sum(-1).flatten(1)
        # The first two sums are kd and ks themselves, and the head corrects them; a logit undoes the sigmoid.
        known = torch.logit(sums[:, :6].clamp(0.01, 0.99))
        answer = self.head(torch.cat([state, sums], 1))
        return torch.sigmoid(torch.cat([answer[:, :6] + known, answer[:, 6:]], 1))
