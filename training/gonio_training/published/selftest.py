"""Checks of the protocol that take seconds: against gonio's renderer, closed forms, and a run that was stopped.

    python -m gonio_training.published.selftest --gonio ../target/release/gonio
"""

import argparse
import math
import tempfile
from pathlib import Path

import numpy as np
import torch

from ..rerender import spheres as render_spheres
from . import metrics
from .architectures import ARCHITECTURES
from .augment import augment, flip_columns, flip_rows
from .data import Spheres, load, statistics
from .normalise import Normalise
from .recipe import OneCycle, Recipe, steps_of
from .sparse import keep
from .train import Run, arguments

MAPS = 600


def random_spheres(gonio: str, camera: str) -> Spheres:
    """Maps of random materials, lights and views."""
    rng = np.random.default_rng(5)
    materials = rng.random((MAPS, 7), dtype=np.float32)
    lights, views = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in rng.normal(size=(2, MAPS, 3)))
    views[:, 2] = np.abs(views[:, 2])
    maps = render_spheres(gonio, camera, materials, lights, views)
    return Spheres(*(torch.from_numpy(part.astype(np.float32)) for part in (maps, materials, lights, views)))


def write(spheres: Spheres, folder: Path) -> None:
    """A small set in the published layout."""
    for part, rows in (("train", slice(0, 520)), ("validation", slice(520, MAPS))):
        (folder / part).mkdir()
        for name, values in spheres._asdict().items():
            kind = np.float16 if name == "maps" else np.float32
            np.save(folder / part / f"{name}.npy", values[rows].numpy().astype(kind))


def first(spheres: Spheres, count: int) -> Spheres:
    """A copy of the first maps."""
    return Spheres(*(part[:count].clone() for part in spheres))


def flips_are_what_mirrored_light_and_view_give(spheres: Spheres, gonio: str, camera: str) -> None:
    """Rows, columns, and both."""
    every = torch.arange(64)
    for turns in ((flip_rows,), (flip_columns,), (flip_rows, flip_columns)):
        flipped = first(spheres, 64)
        for turn in turns:
            turn(flipped, every)
        again = render_spheres(gonio, camera, *(part.numpy() for part in flipped[1:]))
        apart = np.abs(again - flipped.maps.numpy())
        # A sharp highlight's flank moves with the last bit of a direction.
        assert np.quantile(apart, 0.9999) < 1e-4 and apart.max() < 1e-2, apart.max()
        assert not torch.equal(flipped.maps, spheres.maps[:64])


def augmenting_depends_on_seed_and_step_alone(spheres: Spheres) -> None:
    """And leaves materials and the range of radiance as they are."""
    before, once, again, other = (first(spheres, 256) for _ in range(4))
    for batch, step in ((once, 7), (again, 7), (other, 8)):
        augment(batch, 1, step)
    assert all(torch.equal(a, b) for a, b in zip(once, again, strict=True))
    assert not torch.equal(once.maps, other.maps)
    assert torch.equal(once.materials, before.materials)
    assert once.maps.min() >= 0.0 and once.maps.max() <= 1.0
    filled = [(maps > 0).any(1).sum().item() for maps in (before.maps, once.maps)]
    assert 0.4 < filled[1] / filled[0] < 0.85, filled


def sparse_maps_keep_what_was_asked_for(spheres: Spheres) -> None:
    """As many bins as asked for, unchanged, or all there are."""
    maps = spheres.maps[:64]
    kept = keep(maps, 16, 1)
    before, after = ((part > 0).any(1).flatten(1).sum(1) for part in (maps, kept))
    assert torch.equal(after, before.clamp(max=16))
    assert torch.equal(kept[kept > 0], maps[kept > 0])


def metrics_agree_with_closed_forms() -> None:
    """Two even images, one 0.1 brighter than the other."""
    dark, bright = (np.full((1, 3, 60, 120), level, np.float32) for level in (0.5, 0.6))
    psnr, nrmse, dssim = metrics.images(dark, bright)[0]
    stable = 0.01**2
    ssim = (2 * 0.5 * 0.6 + stable) / (0.5**2 + 0.6**2 + stable)
    assert abs(psnr - 20.0) < 1e-4 and abs(nrmse - 0.2) < 1e-5 and abs(dssim - (1 - ssim) / 2) < 1e-5
    assert metrics.images(dark, dark)[0].tolist() == [metrics.BEST_PSNR, 0.0, 0.0]
    assert math.isnan(metrics.images(0 * dark, dark)[0, 1])
    errors = metrics.materials(np.zeros((1, 7)), np.array([[0.3, 0.0, 0.0, 0.0, 0.6, 0.0, 0.5]]))
    assert np.allclose(errors, [[0.1, 0.2, 0.5]])


def normalising_gives_mean_0_and_deviation_1(folder: Path) -> None:
    """Over the maps that it was measured on."""
    part = load(folder / "train")
    maps = Normalise(*statistics(part))(part.batch(torch.arange(len(part.maps))).maps)
    assert maps.mean((0, 2, 3)).abs().max() < 1e-4 and (maps.std((0, 2, 3)) - 1).abs().max() < 1e-3


def rates_follow_the_recipes() -> None:
    """The published steps, and one cycle from nearly nothing to nearly nothing."""
    steps, per_epoch = steps_of(Recipe(), 460_800, None)
    assert (steps, per_epoch) == (162_000, 1_800)
    rates = [Recipe().rate_at(epoch * per_epoch, steps, per_epoch) for epoch in (0, 19, 20, 89)]
    assert np.allclose(rates, [3e-4, 3e-4, 2.7e-4, 3e-4 * 0.9**4])
    cycle = [OneCycle().rate_at(step, 1000, 10) for step in range(1000)]
    assert cycle[0] < 2e-4 and cycle[-1] < 2e-8 and 1.9e-3 < max(cycle) <= 2e-3


def every_architecture_takes_maps_and_gives_materials() -> None:
    """Seven numbers in [0, 1], of a batch, as small as ours says."""
    for name, architecture in ARCHITECTURES.items():
        network = architecture.build(torch.zeros(3), torch.ones(3)).eval()
        with torch.no_grad():
            mu = network(torch.rand(2, 3, 60, 120) * 4)
        assert mu.shape == (2, 7) and mu.min() >= 0 and mu.max() <= 1, name
        if name == "ours":
            assert sum(p.numel() for p in network.parameters()) <= 1_000_000


def a_stopped_run_ends_like_one_that_was_not(folder: Path) -> None:
    """Six steps over three epochs, stopped after three, in the middle of an epoch."""
    options = ["--data", str(folder), "--arch", "ours", "--budget", str(6 * 256), "--log", "1"]
    whole = Run(arguments().parse_args([*options, "--out", str(folder / "whole.pt")]))
    whole.go()
    parted = arguments().parse_args([*options, "--out", str(folder / "parted.pt"), "--save-every-s", "0"])
    stopped = Run(parted)
    stopped.go(until=3)
    resumed = Run(parted)
    assert resumed.step == 3
    resumed.go()
    for name, value in whole.network.state_dict().items():
        assert torch.equal(value, resumed.network.state_dict()[name]), name
    without_clock = [[{**row, "seconds": 0} for row in run.curve] for run in (whole, resumed)]
    assert without_clock[0] == without_clock[1] and len(without_clock[0]) == 6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gonio", default="../target/release/gonio", help="the gonio binary")
    args = parser.parse_args()

    torch.set_num_threads(2)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for camera in ("orthographic", "perspective"):
            spheres = random_spheres(args.gonio, camera)
            flips_are_what_mirrored_light_and_view_give(spheres, args.gonio, camera)
        augmenting_depends_on_seed_and_step_alone(spheres)
        sparse_maps_keep_what_was_asked_for(spheres)
        metrics_agree_with_closed_forms()
        rates_follow_the_recipes()
        write(spheres, folder)
        normalising_gives_mean_0_and_deviation_1(folder)
        every_architecture_takes_maps_and_gives_materials()
        a_stopped_run_ends_like_one_that_was_not(folder)
    print("all as it should be")


if __name__ == "__main__":
    main()
