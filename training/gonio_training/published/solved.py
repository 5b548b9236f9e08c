"""Ours: a network says how light and camera stand to the sphere, and physics gives the rest in closed form.

Once light, view and roughness are fixed, radiance is linear in kd and ks: for each of some roughnesses the best kd and ks
solve two equations a channel (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10(2), 1973), and how well they explain the
map says how likely that roughness is. The answer is the mean over all, first on a coarse grid of roughnesses, then on two
finer ones about the likeliest. What has to be learned is which of the published set's lights and views, flipped or not, a map was
made with; of a whole map the outline tells, of a handful of bins what they show.
"""

import math

import torch
import torch.nn.functional as F
from torch import nn

from ..data import COLUMNS, ROWS, directions
from .data import Spheres

# What the published set's light and cameras are: see `gonio synth spheres`.
LIGHT = (math.sin(math.pi / 6), 0.0, math.cos(math.pi / 6))
THETAS = (math.pi / 9, 5 * math.pi / 18, 4 * math.pi / 9)
AZIMUTHS = 8
DISTANCE = 4.0
ETA = 1.5
# Patches of 5 x 5 bins, 15 degrees, and what the network is told of each.
PATCH = 5
PATCHES = (ROWS // PATCH) * (COLUMNS // PATCH)
TOLD = 4
# Bins that are solved with: all of a sparse map, of a full one the bright ones and some of the others.
BINS = 512
# Roughnesses of the first grid, and of the finer ones to either side of the likeliest.
COARSE, FINE = 24, 4
# Variance of radiance: a step of 8 bits at most, and for each unit of the map's summed squares what half precision rounds.
NOISE, ROUNDING = 2e-3**2, 3e-7
# Precision of kd and ks as they are spread over [0, 1].
PRECISION = 12.0


def poses() -> tuple[torch.Tensor, torch.Tensor]:
    """Lights and views [48, 3] that maps of the set are made with: as they are, and with z mirrored as a flip of rows does."""
    views = [
        (math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta))
        for theta in THETAS
        for phi in (i * 2 * math.pi / AZIMUTHS for i in range(AZIMUTHS))
    ]
    views = torch.tensor(views)
    lights = torch.tensor(LIGHT).expand_as(views)
    mirror = torch.tensor([1.0, 1.0, -1.0])
    return torch.cat([lights, lights * mirror]), torch.cat([views, views * mirror])


def pose_loss(logits: torch.Tensor, batch: Spheres) -> torch.Tensor:
    """Cross entropy of the poses [N, 48] that maps are said to be made with."""
    lights, views = (part.to(logits.device) for part in poses())
    return F.cross_entropy(logits, (batch.lights @ lights.T + batch.views @ views.T).argmax(1))


def dot(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """Of vectors in the last dimension."""
    return (a * b).sum(-1)


def fresnel(cos: torch.Tensor) -> torch.Tensor:
    """Unpolarised reflectance of a dielectric by Snell's and Fresnel's laws."""
    inside = torch.sqrt(1 - (1 - cos * cos) / ETA**2)
    s = (cos - ETA * inside) / (cos + ETA * inside)
    p = (inside - ETA * cos) / (inside + ETA * cos)
    return (s * s + p * p) / 2


class Solver(nn.Module):
    """Bins [N, B, 3], their normals [N, B, 3] and weights [N, B, 3], under lights [N, 3] as views [N, 3] see them, to materials."""

    def look(self, normals: torch.Tensor, light: torch.Tensor, view: torch.Tensor) -> tuple[torch.Tensor, ...]:
        """Of each bin: cos_i where it is lit and in sight, else 0; the half vector's squared sine and cosine; the tangents'
        squares of both directions; and pi F / (4 cos_o). [N, B] each."""
        light = light.unsqueeze(1)
        wo = F.normalize(DISTANCE * view.unsqueeze(1) - normals, dim=-1)
        cos_i, cos_o = dot(normals, light), dot(normals, wo)
        seen = ((cos_i > 0) & (cos_o > 0)).to(cos_i.dtype)
        cos_i, cos_o = cos_i.clamp(min=1e-4), cos_o.clamp(min=1e-4)
        half = F.normalize(light + wo, dim=-1)
        cos_h = dot(normals, half)
        # By the chord: 1 - cos^2 has no digits left in the lobe of a smooth surface.
        chord = normals - half
        near = dot(chord, chord)
        sin2 = near * (1 - near / 4)
        tan_i, tan_o = 1 / cos_i.square() - 1, 1 / cos_o.square() - 1
        scale = seen * math.pi * fresnel(dot(light, half).clamp(0, 1)) / (4 * cos_o)
        return seen * cos_i, sin2, cos_h.square(), tan_i, tan_o, scale

    def lobe(self, looks: tuple[torch.Tensor, ...], roughness: torch.Tensor) -> torch.Tensor:
        """Radiance [N, K, B] of the lobe of ks = 1 with roughnesses [N, K]."""
        _, sin2, cos2, tan_i, tan_o, scale = (look.unsqueeze(1) for look in looks)
        a2 = roughness.square().clamp(min=1e-3).square().unsqueeze(-1)
        lean = sin2 + cos2 * a2
        # Smith's two terms, and the 1 beside them, are half the sum of the roots.
        smith = torch.sqrt(1 + a2 * tan_i) + torch.sqrt(1 + a2 * tan_o)
        return a2 * scale * (2 / math.pi) / (lean * lean * smith)

    def solve(self, rgb, weights, looks, noise, roughness):
        """kd, ks [N, K, 3] of roughnesses [N, K], and the logarithm of each one's evidence [N, K]."""
        # What a roughness explains better than its neighbour is far beyond single precision's digits of the sums.
        white, lobe, weights, rgb = (part.double() for part in (looks[0].unsqueeze(-1), self.lobe(looks, roughness), weights, rgb))
        seen = weights * rgb
        sure = PRECISION * noise.unsqueeze(-1)
        n = (weights * white * white).sum(1, keepdim=True) + sure
        p = (seen * white).sum(1, keepdim=True) + sure / 2
        m = lobe @ (weights * white)
        k = (lobe * lobe) @ weights + sure
        q = lobe @ seen + sure / 2
        det = n * k - m * m
        ks = ((n * q - m * p) / det).clamp(0, 1)
        kd = ((p - m * ks) / n).clamp(0, 1)
        ks = ((q - m * kd) / k).clamp(0, 1)
        misfit = n * kd * kd + 2 * m * kd * ks + k * ks * ks - 2 * (kd * p + ks * q)
        evidence = -(misfit / noise.unsqueeze(-1) + torch.log(det)).sum(-1) / 2
        return kd, ks, evidence

    def forward(self, rgb, normals, weights, light, view):
        looks = self.look(normals, light, view)
        weights = weights * (looks[0] > 0).to(rgb.dtype).unsqueeze(-1)
        noise = NOISE + ROUNDING * (weights * rgb * rgb).sum((1, 2)).double().unsqueeze(1)
        grid = torch.linspace(0.0, 1.0, COARSE + 1, device=rgb.device).expand(rgb.shape[0], -1)
        step, found = 1.0 / COARSE, []
        for _ in range(3):
            kd, ks, evidence = self.solve(rgb, weights, looks, noise, grid)
            best = evidence.argmax(1, keepdim=True)
            centre = grid.gather(1, best)
            found.append([kd, ks, grid, evidence + math.log(step), centre, step])
            offsets = torch.arange(-FINE, FINE + 1, device=rgb.device) / FINE
            grid, step = (centre + step * offsets).clamp(0, 1), step / FINE
        # What a finer grid covers, the coarser one does not count again.
        for part in found[:-1]:
            within = (part[2] - part[4]).abs() < 1.01 * part[5]
            part[3] = part[3] - 1e6 * within.double()
        kd, ks, r, evidence = (torch.cat([part[i] for part in found], 1) for i in range(4))
        share = torch.softmax(evidence, 1).unsqueeze(-1)
        return (torch.cat([kd, ks, r.double().unsqueeze(-1)], -1) * share).sum(1).clamp(0, 1).float()


class Solved(nn.Module):
    """`map` [N, 3, 60, 120], linear radiance, to materials [N, 7]; while it trains, to the logits [N, 48] of `poses`."""

    def __init__(self, mean: torch.Tensor, deviation: torch.Tensor, width: int = 256) -> None:
        super().__init__()
        self.pose = nn.Sequential(
            nn.Linear(TOLD * PATCHES, width),
            nn.ReLU(),
            nn.Linear(width, width),
            nn.ReLU(),
            nn.Linear(width, len(poses()[0])),
        )
        self.solver = Solver()
        lights, views = poses()
        self.register_buffer("lights", lights, persistent=False)
        self.register_buffer("views", views, persistent=False)
        self.register_buffer("normals", directions(), persistent=False)
        # A fixed order in which the bins of a full map are taken.
        turn = torch.rand(ROWS * COLUMNS, generator=torch.Generator().manual_seed(1))
        self.register_buffer("turn", turn, persistent=False)

    def told(self, radiance: torch.Tensor, filled: torch.Tensor) -> torch.Tensor:
        """Of each patch: how much of it is filled, and brightest, darkest and mean channel's contrast to the map."""
        share = F.avg_pool2d(filled, PATCH)
        levels = [radiance.amax(1, keepdim=True), radiance.amin(1, keepdim=True), radiance.mean(1, keepdim=True)]
        level = F.avg_pool2d(torch.cat(levels, 1), PATCH) / share.clamp(min=1.0 / PATCH**2)
        whole = (level * share).sum((2, 3), keepdim=True) / share.sum((2, 3), keepdim=True).clamp(min=1e-3)
        contrast = torch.log((level + 0.01) / (whole + 0.01)) * (share > 0)
        # That anything is there counts, and the more so the less there is.
        return torch.cat([share.sqrt(), contrast], 1).flatten(1)

    def forward(self, map: torch.Tensor) -> torch.Tensor:
        radiance = map.clamp(0.0, 1.0)
        brightest = radiance.amax(1, keepdim=True)
        filled = (brightest > 0).to(radiance.dtype)
        logits = self.pose(self.told(radiance, filled))
        if self.training:
            return logits
        best = logits.argmax(1)
        # What is brighter than twice the mean first, where a highlight is; then the others, each in its turn.
        level, there = brightest.flatten(1), filled.flatten(1)
        mean = level.sum(1, keepdim=True) / there.sum(1, keepdim=True).clamp(min=1.0)
        chosen = (there * (1.0 + self.turn + (level > 2.0 * mean))).topk(BINS, 1).indices
        rgb = radiance.flatten(2).gather(2, chosen.unsqueeze(1).expand(-1, 3, -1)).transpose(1, 2)
        # What is clipped may be any brighter, and what is 0 was not seen.
        weights = ((rgb < 0.999) & (rgb.amax(2, keepdim=True) > 0)).to(rgb.dtype)
        return self.solver(rgb, self.normals[chosen], weights, self.lights[best], self.views[best])
