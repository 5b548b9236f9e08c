"""The table's eight architectures from torchvision's definitions, with random weights, and ours.

All take 60 x 120 maps as they are but AlexNet, whose first convolution strides 2 bins here and not 4: else nothing is left
for its last pooling, which is then dropped, its features being 2 x 6 already. The last layer has 7 outputs and a
sigmoid. No dropout and no stochastic depth: the publication regularises by augmentation and weight decay.
"""

from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import nn
from torchvision import models

from ..train import published_loss
from .data import Spheres
from .normalise import Normalise
from .recipe import OneCycle, Recipe
from .solved import Solved, pose_loss

OUTPUTS = 7
# From mean and deviation of the training set's channels, [3] each.
Build = Callable[[torch.Tensor, torch.Tensor], nn.Module]
# Of what a network answers while it trains, and the batch.
Loss = Callable[[torch.Tensor, Spheres], torch.Tensor]


def of_materials(mu: torch.Tensor, batch: Spheres) -> torch.Tensor:
    """The published loss."""
    return published_loss(mu, batch.materials).mean()


class Published(nn.Module):
    """A network behind the contract: `map` [N, 3, 60, 120], linear radiance, to materials [N, 7]."""

    def __init__(self, body: nn.Module, mean: torch.Tensor, deviation: torch.Tensor) -> None:
        super().__init__()
        self.normalise = Normalise(mean, deviation)
        self.body = body

    def forward(self, map: torch.Tensor) -> torch.Tensor:
        return torch.sigmoid(self.body(self.normalise(map.clamp(0.0, 1.0))))


class Architecture(NamedTuple):
    """A row of the table."""

    title: str
    build: Build
    published: tuple[float, float, float] | None  # PSNR in dB, NRMSE, DSSIM on 30,000 test maps
    recipe: Recipe = Recipe()
    loss: Loss = of_materials


def alexnet(mean: torch.Tensor, deviation: torch.Tensor) -> nn.Module:
    """AlexNet for 60 x 120."""
    network = models.alexnet(num_classes=OUTPUTS, dropout=0.0)
    network.features[0] = nn.Conv2d(3, 64, kernel_size=11, stride=2, padding=2)
    network.avgpool = nn.Identity()
    network.classifier[1] = nn.Linear(256 * 2 * 6, 4096)
    return Published(network, mean, deviation)


def plain(definition: Callable[..., nn.Module], **options: float) -> Build:
    """A definition that needs no change but in its last layer."""
    return lambda mean, deviation: Published(definition(num_classes=OUTPUTS, **options), mean, deviation)


ARCHITECTURES = {
    "alexnet": Architecture("AlexNet", alexnet, (41.6841, 0.0564, 0.00676)),
    "resnet-18": Architecture("ResNet-18", plain(models.resnet18), (45.4900, 0.0354, 0.00391)),
    "resnet-34": Architecture("ResNet-34", plain(models.resnet34), (46.3642, 0.0349, 0.00401)),
    "resnet-50": Architecture("ResNet-50", plain(models.resnet50), (47.2551, 0.0325, 0.00398)),
    "wide-resnet-50": Architecture("Wide ResNet-50", plain(models.wide_resnet50_2), (48.0526, 0.0287, 0.00326)),
    "resnext-50": Architecture("ResNeXt-50", plain(models.resnext50_32x4d), (47.4328, 0.0309, 0.00375)),
    "resnext-101": Architecture("ResNeXt-101", plain(models.resnext101_32x8d), (47.5832, 0.0307, 0.00357)),
    "efficientnet-b0": Architecture(
        "EfficientNet-B0",
        plain(models.efficientnet_b0, dropout=0.0, stochastic_depth_prob=0.0),
        (47.7031, 0.0306, 0.00358),
    ),
    "ours": Architecture("ours", Solved, None, OneCycle(epochs=1), pose_loss),
}
