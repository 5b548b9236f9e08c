"""Ours: a small convolutional network that reads kd and ks off the map by weighted sums.

Once light, view and roughness are fixed, radiance is linear in kd and ks, channel by channel: so each of the two is a weighted
sum of the channel's radiance, with weights that are the same for red, green and blue. The convolutions see where the
sphere is bright and find the weights; the sums are exact where a plain regression would have to learn a product.
Nothing in it tells red from green or blue, so that what it learns of one it knows of all.
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
        fitted = nn.Sequential(nn.Conv2d(before, after, 1, stride, bias=False), nn.BatchNorm2d(after))
        self.shortcut = nn.Identity() if same else fitted

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return torch.relu(self.second(self.first(x)) + self.shortcut(x))


class Compact(nn.Module):
    """`map` [N, 3, 60, 120], linear radiance, to materials [N, 7]."""

    def __init__(self, mean: torch.Tensor, deviation: torch.Tensor) -> None:
        super().__init__()
        self.normalise = Normalise(mean.mean().repeat(3), deviation.mean().repeat(3))
        # Patches of 5 x 5 bins, 15 degrees: radiance, its contrast to the map's mean, and what is filled.
        self.stem = nn.Sequential(
            nn.Conv2d(7, 32, PATCH, PATCH, bias=False), nn.BatchNorm2d(32), nn.ReLU(inplace=True)
        )
        self.blocks = nn.Sequential(Residual(32, 32, 1), Residual(32, 64, 2), Residual(64, 96, 2))
        self.state = nn.Sequential(nn.Flatten(), nn.Linear(96 * 3 * 6, 192), nn.LeakyReLU(0.1))
        self.weights = nn.Linear(192, SUMS * PATCHES)
        # An even mean at first, whatever the state: random weights of 288 patches would add up to anything, and the first
        # thing to be learned would be to silence the convolutions.
        nn.init.zeros_(self.weights.weight)
        nn.init.constant_(self.weights.bias, 0.5 / (PATCHES * max(float(mean.mean()), 1e-3)))
        self.all_channels = nn.Linear(192 + 4 * SUMS, 128)
        self.channel = nn.Linear(SUMS, 128)
        self.correction = nn.Sequential(
            nn.LeakyReLU(0.1), nn.Linear(128, 64), nn.LeakyReLU(0.1), nn.Linear(64, 2)
        )
        self.roughness = nn.Sequential(nn.Linear(192 + 4 * SUMS, 64), nn.LeakyReLU(0.1), nn.Linear(64, 1))

    def stem_input(self, radiance: torch.Tensor, filled: torch.Tensor) -> torch.Tensor:
        """Brightest, darkest and mean channel of each bin, their contrast, and whether it is filled: [N, 7, 60, 120]."""
        levels = torch.cat(
            [radiance.amax(1, keepdim=True), radiance.amin(1, keepdim=True), radiance.mean(1, keepdim=True)], 1
        )
        count = filled.sum((2, 3), keepdim=True).clamp(min=1.0)
        mean = levels[:, 2:].sum((2, 3), keepdim=True) / count
        contrast = filled * torch.log((levels + 0.02) / (mean + 0.02))
        return torch.cat([self.normalise(levels), contrast, filled], 1)

    def forward(self, map: torch.Tensor) -> torch.Tensor:
        radiance = map.clamp(0.0, 1.0)
        filled = (radiance.amax(1, keepdim=True) > 0).to(radiance.dtype)
        state = self.state(self.blocks(self.stem(self.stem_input(radiance, filled))))
        share = F.avg_pool2d(filled, PATCH)
        mean = F.avg_pool2d(radiance, PATCH) / share.clamp(min=1.0 / PATCH**2)
        # A fourth channel of ones: the sum of the weights of what is filled.
        patches = torch.cat([mean, (share > 0).to(mean.dtype)], 1).flatten(2)
        weights = self.weights(state).unflatten(1, (SUMS, 1, PATCHES))
        # Not a matrix product: that would be done in bfloat16 where training uses it, which is too coarse here.
        sums = (weights * patches.unsqueeze(1)).sum(-1)
        own, ones = sums[:, :, :3].transpose(1, 2), sums[:, :, 3]
        shared = torch.cat([state, own.mean(1), own.amax(1), own.amin(1), ones], 1)
        # The first two sums are kd and ks, but for a correction.
        colour = own[:, :, :2] + self.correction(self.channel(own) + self.all_channels(shared).unsqueeze(1))
        mu = torch.cat([colour.transpose(1, 2).flatten(1), torch.sigmoid(self.roughness(shared))], 1)
        # A clipped value has no gradient to learn from.
        return mu if self.training else mu.clamp(0.0, 1.0)
