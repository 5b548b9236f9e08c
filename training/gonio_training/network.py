"""A network over the filled bins of a map: real maps fill 5 to 50 bins of 7,200, so a convolution would mostly see zeros.

Every bin is embedded, what all bins say together is pooled and given back to each, embedded and pooled again
(two rounds of Zaheer et al., "Deep Sets", 2017), and a head gives the 7-vector. The order of bins does not matter. Where the
light is known, every bin is told where its direction lies to it.
"""

import torch
from torch import nn

from .data import SLOTS

# Values of a light: the unit vector to the sun, its colour where it reaches the surface, the sky's radiance.
LIGHT = 9
TOLD = 11


def to_light(direction: torch.Tensor, rgb: torch.Tensor, light: torch.Tensor) -> torch.Tensor:
    """What bins are told of the light [N, LIGHT]: the cosines between sun, direction, the half vector between them and the
    normal; how bright sun and sky are; and the radiance over that of a white matt surface, which is kd where all is matt.
    [N, S, TOLD]."""
    light = light.unsqueeze(1)
    sun, colour, sky = light[:, :, :3], light[:, :, 3:6], light[:, :, 6:9]
    half = direction + sun
    half = half / torch.sqrt((half * half).sum(-1, keepdim=True) + 1e-9)
    cos = sun[:, :, 2:].clamp(min=0.0)
    white = colour * cos + sky

    def dot(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
        return (a * b).sum(-1, keepdim=True)

    everywhere = torch.zeros_like(direction[:, :, :1]) + torch.cat([cos, colour.mean(-1, keepdim=True), sky], -1)
    matt = (rgb / (white + 0.02)).clamp(max=4.0)
    return torch.cat([half[:, :, 2:], dot(direction, sun), dot(half, sun), everywhere, matt], -1)


class SetNetwork(nn.Module):
    """Directions [N, S, 3], radiance [N, S, 3] and mask [N, S, 1] to materials [N, 7]; with `lit` also the light [N, LIGHT]."""

    def __init__(self, lit: bool = False, width: int = 96, wide: int = 128, head: int = 1024) -> None:
        super().__init__()
        self.lit = lit
        self.embed = nn.Sequential(nn.Linear(12 + TOLD * lit, 64), nn.ReLU(), nn.Linear(64, width), nn.ReLU())
        self.context = nn.Sequential(nn.Linear(2 * width + 1, width), nn.ReLU())
        self.own = nn.Linear(width, wide)
        self.given = nn.Linear(width, wide)
        self.again = nn.Sequential(nn.ReLU(), nn.Linear(wide, wide), nn.ReLU())
        self.head = nn.Sequential(
            nn.Linear(2 * wide + width, head), nn.ReLU(), nn.Linear(head, 512), nn.ReLU(), nn.Linear(512, 7)
        )

    def forward(
        self, direction: torch.Tensor, rgb: torch.Tensor, mask: torch.Tensor, light: torch.Tensor | None = None
    ) -> torch.Tensor:
        share = mask / mask.sum(1, keepdim=True).clamp(min=1.0)
        # Normalisation: radiance; its square root, which spreads the dark half that linear values crowd together; and by
        # how much a bin differs from the map's mean, which is all that tells a faint highlight from a matt surface.
        mean = (rgb * share).sum(1, keepdim=True)
        contrast = (4.0 * torch.log((rgb + 0.01) / (mean + 0.01))).clamp(-4.0, 4.0)
        features = torch.cat([direction, rgb, torch.sqrt(rgb + 1e-4), contrast], -1)
        if light is not None:
            features = torch.cat([features, to_light(direction, rgb, light)], -1)
        bins = self.embed(features)
        # After a ReLU nothing is below 0, so masking with 0 leaves the maximum right.
        count = mask.sum(1) / SLOTS
        context = self.context(torch.cat([(bins * share).sum(1), (bins * mask).amax(1), count], -1))
        bins = self.again(self.own(bins) + self.given(context).unsqueeze(1))
        pooled = torch.cat([(bins * share).sum(1), (bins * mask).amax(1), context], -1)
        return torch.sigmoid(self.head(pooled))


def cautious(mu: torch.Tensor, rgb: torch.Tensor, mask: torch.Tensor) -> torch.Tensor:
    """Answers [N, 7] moved towards a matt surface that is as bright as it looks.

    One map whose light is unknown never tells kd from the light, and seldom ks and r: what a network says of them is the mean of
    all that is likely, and relights worse than matt surfaces of the mean radiance do. In between both are outdone. How far was
    first tried on the synthetic city of seed 101 and then chosen among three on those of 35 and 36."""
    looks = (rgb * mask).sum(1) / mask.sum(1).clamp(min=1.0)
    kd = mu[:, :3] + 0.5 * (looks - mu[:, :3])
    return torch.cat([kd, 0.4 * mu[:, 3:6], mu[:, 6:] + 0.6 * (0.75 - mu[:, 6:]).clamp(min=0.0)], 1)


class BinsNetwork(nn.Module):
    """The same network behind the model contract: `bins` [N, S, 7], of which each is a direction, rgb and the number of
    observations, 0 where there is none, and where the network wants it `light` [N, 9], to `mu` [N, 7], cautious where there is
    no light."""

    def __init__(self, network: SetNetwork) -> None:
        super().__init__()
        self.network = network

    def forward(self, bins: torch.Tensor, light: torch.Tensor | None = None) -> torch.Tensor:
        mask, rgb = (bins[:, :, 6:] > 0).float(), bins[:, :, 3:6].clamp(0.0, 1.0)
        mu = self.network(bins[:, :, :3], rgb, mask, light)
        return cautious(mu, rgb, mask) if light is None else mu
