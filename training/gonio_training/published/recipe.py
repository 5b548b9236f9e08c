"""How long and how fast to learn."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Recipe:
    """The published protocol. What the publication leaves open is marked ours."""

    batch: int = 256
    epochs: int = 90
    rate: float = 3e-4
    decay: float = 0.9  # of the rate, every `every` epochs
    every: int = 20
    weight_decay: float = 1e-4  # ours: "weight decay" is all that is said

    def rate_at(self, step: int, steps: int, steps_per_epoch: int) -> float:
        """The learning rate of a step."""
        return self.rate * self.decay ** (step // steps_per_epoch // self.every)


@dataclass(frozen=True)
class OneCycle(Recipe):
    """The same with one cosine cycle over whatever budget there is: for networks that are to be good in few epochs."""

    rate: float = 2e-3
    warm: float = 0.02  # share of the steps in which the rate rises

    def rate_at(self, step: int, steps: int, steps_per_epoch: int) -> float:
        rise = min(1.0, (step + 1) / (self.warm * steps))
        return self.rate * rise * 0.5 * (1 + math.cos(math.pi * step / steps))


def steps_of(recipe: Recipe, maps: int, budget: int | None) -> tuple[int, int]:
    """Steps in all and in an epoch, of a training set of `maps`; a budget is a number of maps shown, and rounds up to whole
    batches. A batch that an epoch cannot fill is left out."""
    per_epoch = maps // recipe.batch
    if per_epoch == 0:
        raise ValueError(f"{maps} maps do not fill one batch of {recipe.batch}")
    return math.ceil(budget / recipe.batch) if budget else recipe.epochs * per_epoch, per_epoch
